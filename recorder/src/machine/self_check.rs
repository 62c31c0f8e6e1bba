//! What every run asks a device before it trusts it: known answers, in well under a second.

use formats::manifest::Check;
use serde::Serialize;

use crate::device::{Binding, DeviceArray, Gpu, GpuError, Kernel, KernelSource, Rounding};
use crate::stages::sort::gpu::{Keys, Sorter};

/// Keys of the trial sort.
const SORT_KEYS: u32 = 70_003;
/// Rows of four floats whose rounding is compared.
const ROUNDING_ROWS: u32 = 4096;
/// Threads that add to one counter.
const ADDERS: u32 = 4096;
/// Smallest extent of a scene on a device that flushes denormal numbers, in the scene's units. Triangle
/// tests multiply three lengths, and compare with rounding errors: hits were still right in a box of 1e-6,
/// and no longer in one of 1e-9.
pub const SMALLEST_FLUSHED_SCENE: f32 = 1e-4;
/// Loops that a device must finish; some drivers stop at 65,535.
const LOOPS: [u32; 4] = [65_535, 65_536, 70_003, 200_003];

/// The kernels, for a device that rounds so.
pub(crate) fn wgsl(rounding: Rounding) -> String {
    // Nobody counts there.
    rounding.wgsl("atomicLoad(&counters[3])") + include_str!("self_check.wgsl")
}

/// It is as it must be.
const PASSED: &str = "passed";
/// It is wrong.
pub(super) const FAILED: &str = "failed";
/// It is allowed, but not as IEEE 754 has it.
const DIFFERS: &str = "differs";

/// What a device does, and how it rounds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SelfCheck {
    /// Every check, in the order in which they ran.
    pub checks: Vec<Check>,
    /// What kernels that trace rays and make keys must guard against.
    #[serde(skip)]
    pub rounding: Rounding,
    /// Whether with these guards they compute what IEEE 754 has, bit for bit.
    pub ieee_arithmetic: bool,
    /// Whether numbers below 1.2e-38 become 0.
    pub flushes_denormals: bool,
}

impl SelfCheck {
    /// Runs every check; a failed one is an error.
    ///
    /// # Errors
    /// [`GpuError::SelfCheck`] for the first check that failed, or what the device reports.
    pub fn run(gpu: &Gpu) -> Result<Self, GpuError> {
        let found = Self::look(gpu)?;
        match found.checks.iter().find(|check| check.outcome == FAILED) {
            None => Ok(found),
            Some(check) => Err(GpuError::SelfCheck {
                adapter: gpu.adapter().title(),
                check: check.name.clone(),
                detail: check.detail.clone(),
            }),
        }
    }

    /// Runs every check and says what came out.
    ///
    /// # Errors
    /// What the device reports.
    pub fn look(gpu: &Gpu) -> Result<Self, GpuError> {
        let mut checks = vec![long_loops(gpu)?, barriers(gpu)?, atomics(gpu)?];
        checks.extend([sort(gpu, 32)?, sort(gpu, 64)?, timestamps(gpu)?]);
        let found = rounding(gpu)?;
        let differs = |check: &Check| check.outcome != PASSED;
        let rounding =
            Rounding { contracts: differs(&found[2]), divides_roughly: found[..2].iter().any(differs) };
        let flushes_denormals = differs(&found[3]);
        checks.extend(found);
        let kernels = kernel_rounding(&gpu.clone().with_rounding(rounding))?;
        let ieee_arithmetic = !differs(&kernels);
        checks.push(kernels);
        Ok(Self { checks, rounding, ieee_arithmetic, flushes_denormals })
    }
}

/// Runs one kernel over `inputs`; returns its outputs, its counters and its nanoseconds.
fn run(
    gpu: &Gpu,
    entry_point: &str,
    inputs: &[u32],
    workgroups: u32,
) -> Result<(Vec<u32>, Vec<u32>, u64), GpuError> {
    let source = KernelSource {
        label: &format!("self_check::{entry_point}"),
        wgsl: &wgsl(gpu.rounding()),
        entry_point,
        bindings: &[Binding::Read, Binding::ReadWrite, Binding::ReadWrite],
        immediate_bytes: 0,
    };
    // SAFETY: threads index below the number of inputs, and every loop counts up to a bound.
    let kernel = unsafe { Kernel::trusted(gpu, &source)? };
    let read: DeviceArray<u32> = gpu.array_of("self_check::inputs", inputs)?;
    let outputs = gpu.array("self_check::outputs", inputs.len())?;
    let counters = gpu.array("self_check::counters", 4)?;
    let group = kernel.bind(gpu, &[read.binding(), outputs.binding(), counters.binding()])?;
    let mut run = gpu.stage("self_check");
    run.dispatch(&kernel, &group, &(), workgroups);
    let elapsed_ns = run.finish()?;
    Ok((gpu.read_vec(&outputs)?, gpu.read_vec(&counters)?, elapsed_ns))
}

fn long_loops(gpu: &Gpu) -> Result<Check, GpuError> {
    let inputs: Vec<u32> = LOOPS.iter().copied().cycle().take(64).collect();
    let (outputs, ..) = run(gpu, "long_loops", &inputs, 1)?;
    let wrong = outputs.iter().zip(&inputs).find(|(found, expected)| found != expected);
    Ok(verdict(
        "long loops",
        wrong.map(|(found, expected)| format!("a loop of {expected} rounds ended after {found}")),
    ))
}

fn barriers(gpu: &Gpu) -> Result<Check, GpuError> {
    let inputs: Vec<u32> = numbers(1).take(64).map(|number| number >> 8).collect();
    let expected: u32 = inputs.iter().sum();
    let (outputs, ..) = run(gpu, "barriers", &inputs, 1)?;
    let wrong = outputs.iter().find(|&&sum| sum != expected);
    Ok(verdict(
        "workgroup barriers",
        wrong.map(|sum| format!("a sum over 64 threads is {sum}, expected {expected}")),
    ))
}

fn atomics(gpu: &Gpu) -> Result<Check, GpuError> {
    let inputs: Vec<u32> = numbers(2).take(ADDERS as usize).collect();
    let expected: u64 = inputs.iter().map(|&number| u64::from(number)).sum();
    let (_, counters, _) = run(gpu, "atomics", &inputs, ADDERS / 64)?;
    let sum = u64::from(counters[1]) << 32 | u64::from(counters[0]);
    let wrong = (sum != expected || counters[2] != ADDERS).then(|| {
        format!("{ADDERS} threads added up to {sum} in {} additions, expected {expected}", counters[2])
    });
    Ok(verdict("atomics", wrong))
}

fn sort(gpu: &Gpu, bits: u32) -> Result<Check, GpuError> {
    let (low, high) = (numbers(3), numbers(4));
    let key = |(low, high)| if bits > 32 { u64::from(high) << 32 | u64::from(low) } else { u64::from(low) };
    let keys: Vec<u64> = low.zip(high).map(key).take(SORT_KEYS as usize).collect();
    let mut expected: Vec<u32> = (0..SORT_KEYS).collect();
    expected.sort_by_key(|&index| keys[index as usize]);
    let sorted = Sorter::new(gpu)?.sorted(gpu, &Keys::upload(gpu, &keys, bits)?)?;
    let found = gpu.read_vec(&sorted)?;
    let wrong = found.iter().zip(&expected).position(|(found, expected)| found != expected);
    let name = if bits > 32 { "sort of 64-bit keys" } else { "sort of 32-bit keys" };
    Ok(verdict(name, wrong.map(|place| format!("place {place} of {SORT_KEYS} holds the wrong key"))))
}

fn timestamps(gpu: &Gpu) -> Result<Check, GpuError> {
    let name = "timestamps";
    if !gpu.adapter().timestamps {
        let detail = "the device has none; times are taken around submissions".to_owned();
        return Ok(check(name, DIFFERS, detail));
    }
    let (.., elapsed_ns) = run(gpu, "long_loops", &[200_003; 64], 1)?;
    Ok(match elapsed_ns {
        0 => check(name, FAILED, "two of them around a loop of 200,003 rounds are equal".to_owned()),
        _ => check(name, PASSED, format!("{elapsed_ns} ns for a loop of 200,003 rounds")),
    })
}

/// Rows of four floats within a few powers of two of 1, where every mantissa occurs.
fn rows() -> Vec<[f32; 4]> {
    let mut random = numbers(5);
    let mut float = || f32::from_bits(0x3e00_0000 + (random.next().unwrap_or_default() >> 6));
    (0..ROUNDING_ROWS).map(|_| std::array::from_fn(|_| float())).collect()
}

/// What IEEE 754 has for a row: quotient, square root, a·b − c·d.
fn expected([a, b, c, d]: &[f32; 4]) -> [f32; 3] {
    [a / b, a.sqrt(), a * b - c * d]
}

/// Division, square root, contraction, denormal numbers.
fn rounding(gpu: &Gpu) -> Result<[Check; 4], GpuError> {
    let rows = rows();
    let (outputs, ..) = run(gpu, "rounding", bytemuck::cast_slice(&rows), ROUNDING_ROWS / 64)?;
    let compare = |name, column: usize| {
        let found = outputs.chunks_exact(4).map(|row| row[column]);
        let wrong = found.zip(&rows).filter(|(found, row)| *found != expected(row)[column].to_bits()).count();
        rounding_check(name, wrong)
    };
    Ok([
        compare("division", 0),
        compare("square root", 1),
        compare("no contraction of a·b − c·d", 2),
        denormals(gpu)?,
    ])
}

/// The same in the words of kernels, with the guards that the device needs.
fn kernel_rounding(gpu: &Gpu) -> Result<Check, GpuError> {
    let rows = rows();
    let (outputs, ..) = run(gpu, "kernel_rounding", bytemuck::cast_slice(&rows), ROUNDING_ROWS / 64)?;
    let is_wrong = |(found, row): &(&[u32], &[f32; 4])| found[..3] != expected(row).map(f32::to_bits);
    Ok(rounding_check("rays and keys", outputs.chunks_exact(4).zip(&rows).filter(is_wrong).count()))
}

fn rounding_check(name: &str, wrong: usize) -> Check {
    let detail = format!("{wrong} of {ROUNDING_ROWS} results are not those of IEEE 754");
    check(name, if wrong == 0 { PASSED } else { DIFFERS }, detail)
}

fn denormals(gpu: &Gpu) -> Result<Check, GpuError> {
    let row = [1e-10f32, 1.0, 1.0, 1.0];
    let rows = [row; 64];
    let (outputs, ..) = run(gpu, "rounding", bytemuck::cast_slice(&rows), 1)?;
    let is_kept = outputs[3] == (1e-10f32 * 1e-30).to_bits();
    let name = "denormal numbers";
    if is_kept {
        return Ok(check(name, PASSED, "kept".to_owned()));
    }
    let detail = format!("flushed to zero; scenes smaller than {SMALLEST_FLUSHED_SCENE} are refused");
    Ok(check(name, DIFFERS, detail))
}

fn verdict(name: &str, fault: Option<String>) -> Check {
    check(name, if fault.is_some() { FAILED } else { PASSED }, fault.unwrap_or_default())
}

fn check(name: &str, outcome: &str, detail: String) -> Check {
    Check { name: name.to_owned(), outcome: outcome.to_owned(), detail }
}

/// The same pseudo-random words on every machine.
fn numbers(seed: u64) -> impl Iterator<Item = u32> {
    let mut random = fastrand::Rng::with_seed(seed);
    std::iter::repeat_with(move || random.u32(..))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_device_passes_in_under_a_second() {
        let gpu = crate::device::test_gpu();
        let start = std::time::Instant::now();
        let found = SelfCheck::run(gpu).unwrap();
        println!("{found:#?} in {:?}", start.elapsed());
        assert_eq!(found.checks.len(), 11);
        assert!(found.ieee_arithmetic, "rays and keys are not those of threads on this device");
    }
}
