//! The exclusive prefix sum on the GPU.

use bytemuck::{Pod, Zeroable};

use super::WORKGROUP_SCAN_WGSL;
use crate::device::kernel::{LINEAR_WORKGROUP_WGSL, constants_wgsl};
use crate::device::{Binding, DeviceArray, Gpu, GpuError, Kernel, KernelSource, Readback};

/// Threads of a workgroup; a power of two.
const THREADS: u32 = 64;
/// Consecutive items that one thread sums up.
const ITEMS_PER_THREAD: u32 = 16;
/// Items of a tile, which is what one workgroup sums up.
const TILE: u32 = THREADS * ITEMS_PER_THREAD;

/// Counts live items so that each knows its place.
#[derive(Debug)]
pub struct Scan {
    sum_tiles: Kernel,
    place_tiles: Kernel,
    place_items: Kernel,
}

/// What a prefix sum found beside the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scanned {
    /// How many live.
    pub total: u32,
    /// How long it took, in nanoseconds.
    pub elapsed_ns: u64,
}

/// What the kernels are told.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ScanSpan {
    count: u32,
    tiles: u32,
}

impl Scan {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// If the driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let wgsl = wgsl();
        let compile = |entry_point: &str| {
            let source = KernelSource {
                label: &format!("compact::{entry_point}"),
                wgsl: &wgsl,
                entry_point,
                bindings: &[Binding::Read, Binding::ReadWrite, Binding::ReadWrite],
                immediate_bytes: size_of::<ScanSpan>() as u32,
            };
            // SAFETY: items are below `count` and tiles below `tiles`, which `run` checks against
            // the arrays; all loops count up to bounds; the one divisor is a constant.
            unsafe { Kernel::trusted(gpu, &source) }
        };
        Ok(Self {
            sum_tiles: compile("sum_tiles")?,
            place_tiles: compile("place_tiles")?,
            place_items: compile("place_items")?,
        })
    }

    /// Writes to `places[i]` how many of the rays before i live, for the first `count`: those whose
    /// t_max, the last number of a direction, is not 0.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// If one of the arrays is shorter than `count`.
    pub fn run(
        &self,
        gpu: &Gpu,
        directions: &DeviceArray<[f32; 4]>,
        places: &DeviceArray<u32>,
        count: usize,
    ) -> Result<Scanned, GpuError> {
        let shorter = directions.len().min(places.len());
        assert!(count <= shorter, "{count} items in arrays of {shorter}");
        let count = u32::try_from(count).expect("binding limits keep arrays below 2^32 elements");
        let tiles = count.div_ceil(TILE);
        let span = ScanSpan { count, tiles };
        let tile_places = gpu.array::<u32>("compact::tile_places", tiles as usize + 1)?;
        let resources = [directions.binding(), places.binding(), tile_places.binding()];
        let group = self.sum_tiles.bind(gpu, &resources)?;
        let mut run = gpu.stage("compact");
        run.dispatch(&self.sum_tiles, &group, &span, tiles);
        run.dispatch(&self.place_tiles, &group, &span, 1);
        run.dispatch(&self.place_items, &group, &span, tiles);
        let elapsed_ns = run.finish()?;
        let last = tiles as usize;
        let total = Readback::default().read_vec(gpu, &tile_places, last..last + 1)?[0];
        Ok(Scanned { total, elapsed_ns })
    }
}

/// The whole module.
pub(crate) fn wgsl() -> String {
    let constants = [("SCAN_THREADS", THREADS), ("ITEMS_PER_THREAD", ITEMS_PER_THREAD)];
    [
        &constants_wgsl(&constants),
        LINEAR_WORKGROUP_WGSL,
        WORKGROUP_SCAN_WGSL,
        include_str!("live.wgsl"),
        include_str!("kernel.wgsl"),
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_gpu;

    /// Compares the places and the total with a serial sum.
    fn check(scan: &Scan, flags: &[u32], what: &str) {
        let gpu = test_gpu();
        // Whatever is not 0 lives, a denormal number too.
        let lengths = [[0.0; 2], [f32::INFINITY, 1e-45]].concat();
        let direction =
            |(place, &flag): (usize, &u32)| [1.0, 1.0, 1.0, lengths[2 * flag as usize + place % 2]];
        let directions: Vec<[f32; 4]> = flags.iter().enumerate().map(direction).collect();
        let directions = gpu.array_of("test::directions", &directions).unwrap();
        // What lies beyond the items must not be touched.
        let places = gpu.array_of("test::places", &vec![u32::MAX; flags.len() + 3]).unwrap();
        let scanned = scan.run(gpu, &directions, &places, flags.len()).unwrap();
        let mut expected = Vec::with_capacity(flags.len() + 3);
        let mut sum = 0;
        for flag in flags {
            expected.push(sum);
            sum += flag;
        }
        expected.extend([u32::MAX; 3]);
        assert_eq!(scanned.total, sum, "total of {} {what}", flags.len());
        let found = gpu.read_vec(&places).unwrap();
        let wrong = found.iter().zip(&expected).position(|(found, expected)| found != expected);
        assert_eq!(wrong, None, "first wrong place of {} {what}", flags.len());
    }

    #[test]
    fn places_are_serial_sums_at_every_border() {
        let scan = Scan::new(test_gpu()).unwrap();
        let seed = 0x5CA1_AB1E;
        println!("seed {seed:#x}");
        let mut random = fastrand::Rng::with_seed(seed);
        let borders = [1, ITEMS_PER_THREAD, THREADS, TILE, 2 * TILE, THREADS * TILE];
        for border in borders {
            for count in border - 1..=border + 1 {
                let flags: Vec<u32> = (0..count).map(|_| random.u32(..2)).collect();
                check(&scan, &flags, "flags");
                check(&scan, &vec![1; count as usize], "ones");
                check(&scan, &vec![0; count as usize], "zeros");
            }
        }
    }

    #[test]
    fn as_many_items_as_one_binding_holds() {
        let scan = Scan::new(test_gpu()).unwrap();
        let count = 1 << 23;
        let flags: Vec<u32> = (0..count).map(|i: u32| i.wrapping_mul(0x9E37_79B9) >> 31).collect();
        check(&scan, &flags, "flags");
    }
}
