//! Where a recording runs: opened, checked, described for the manifest.
//!
//! - [`self_check`]: known answers that an adapter must give
//! - [`adapters`]: all adapters of this machine with what it found
//! - [`description`]: a device as manifests and benchmarks describe it

pub mod adapters;
pub mod description;
mod processors;
pub mod self_check;

use anyhow::{Context, Result, ensure};
use formats::length_table::TableCell;
use formats::manifest::Backend;
use scenes::{Scene, memory};

use self::self_check::{SMALLEST_FLUSHED_SCENE, SelfCheck};
use crate::device::{AdapterRequest, Gpu, GpuError};
use crate::options::{BackendChoice, DeviceOptions};
use crate::stages::setup::Setup;
use crate::stages::trace::TraceKernel;

/// Where stages run.
pub enum Device {
    /// Native threads.
    Cpu(CpuDevice),
    /// An adapter that passed its self-check.
    Gpu(Box<GpuDevice>),
}

/// Native threads.
pub struct CpuDevice {
    /// The threads.
    pub pool: rayon::ThreadPool,
    /// What `auto` passed over on the way here.
    passed_over: Option<String>,
}

/// An adapter and what its self-check found.
pub struct GpuDevice {
    /// The adapter.
    pub gpu: Gpu,
    /// What it does and does not.
    pub self_check: SelfCheck,
}

impl GpuDevice {
    /// What passes its self-check, with the guards that its rounding needs.
    ///
    /// # Errors
    /// Those of [`SelfCheck::run`].
    pub fn checked(gpu: Gpu) -> Result<Self, GpuError> {
        let self_check = SelfCheck::run(&gpu)?;
        Ok(Self { gpu: gpu.with_rounding(self_check.rounding), self_check })
    }

    /// Refuses scenes so small that products of lengths are denormal, where the device takes those for 0.
    fn check_extent(&self, scene: &Scene) -> Result<()> {
        let extent = scene.bounds().extent().into_iter().fold(0.0, f32::max);
        ensure!(
            !self.self_check.flushes_denormals || extent >= SMALLEST_FLUSHED_SCENE,
            "the scene is {extent:e} units large, and {} takes numbers below 1.2e-38 for 0, with which rays miss triangles of scenes smaller than {SMALLEST_FLUSHED_SCENE}; scale the scene up, or use --backend cpu",
            self.gpu.adapter().title()
        );
        Ok(())
    }
}

/// Opens the device that is asked for.
///
/// # Errors
/// If there is none, or its self-check fails.
pub fn open(options: &DeviceOptions) -> Result<Device> {
    let request = match (&options.adapter, options.backend) {
        (Some(name), _) => AdapterRequest::Named(name.clone()),
        (None, BackendChoice::Gpu) => AdapterRequest::Any,
        (None, BackendChoice::Auto) => match options.trace {
            Some(TraceKernel::RayQuery) => AdapterRequest::Hardware,
            Some(kernel) if !kernel.is_for_gpus() => return open_cpu(options, None),
            _ => return open_auto(options),
        },
        (None, BackendChoice::Cpu) => return open_cpu(options, None),
    };
    open_gpu(&request, options.trace)
}

fn open_auto(options: &DeviceOptions) -> Result<Device> {
    match open_gpu(&AdapterRequest::Hardware, options.trace) {
        Ok(device) => Ok(device),
        // No hardware is what auto is for; a card that fails is worth a word.
        Err(error) => {
            let is_absent =
                matches!(error.downcast_ref(), Some(GpuError::NoAdapter | GpuError::NoHardware { .. }));
            let passed_over = (!is_absent).then(|| format!("the GPU was passed over: {error:#}"));
            open_cpu(options, passed_over)
        }
    }
}

fn open_gpu(request: &AdapterRequest, trace: Option<TraceKernel>) -> Result<Device> {
    let gpu = match trace {
        Some(TraceKernel::RayQuery) => Gpu::open_with_ray_query(request)?,
        _ => Gpu::open(request)?,
    };
    Ok(Device::Gpu(Box::new(GpuDevice::checked(gpu)?)))
}

fn open_cpu(options: &DeviceOptions, passed_over: Option<String>) -> Result<Device> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(options.threads.unwrap_or(0));
    let pool = builder.build().context("starting the threads of the cpu backend")?;
    if options.pin {
        processors::pin(&pool)?;
    }
    Ok(Device::Cpu(CpuDevice { pool, passed_over }))
}

/// Bytes of CPU memory that a run needs per pixel: queues of three bounces and two of shadow rays with state, a
/// sorted copy; results of both kinds for the loop, a method and its way home; keys, permutations, pairs of the
/// sort, lengths by their cells, the film.
const CPU_BYTES_PER_PIXEL: u64 = 5 * 56 + 32 + 4 * (16 + 4) + 8 + 4 * 4 + 2 * 8 + 8 + 12;
/// Bytes of CPU memory that a scene needs per triangle: its arrays twice, leaf triangles, nodes.
const CPU_BYTES_PER_TRIANGLE: u64 = 2 * 64 + 48 + 80;
/// Bytes of CPU memory of a cell of the length tables: two tables, and two to time adding to them.
const CPU_BYTES_PER_CELL: u64 = 4 * size_of::<TableCell>() as u64;
/// Bytes per item of the largest arrays on the GPU: a half of a ray, four words of a triangle.
const GPU_BYTES_PER_ITEM: u64 = 16;

impl Device {
    /// Threads or a GPU.
    pub fn backend(&self) -> Backend {
        match self {
            Self::Cpu(_) => Backend::Cpu,
            Self::Gpu(_) => Backend::Gpu,
        }
    }

    /// The trace kernels of our own that trace rays one by one here, the fastest first.
    pub fn kernels(&self) -> Vec<TraceKernel> {
        match self {
            Self::Cpu(_) => vec![TraceKernel::Wide, TraceKernel::Cwbvh, TraceKernel::Bvh2],
            Self::Gpu(_) => vec![TraceKernel::Cwbvh, TraceKernel::Bvh2],
        }
    }

    /// The trace kernel that was asked for, or the one that is fastest here.
    pub fn kernel(&self, options: &DeviceOptions) -> TraceKernel {
        options.trace.unwrap_or_else(|| self.kernels()[0])
    }

    /// Does some work on the threads of the device, if it has its own.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::Cpu(cpu) => cpu.pool.install(work),
            Self::Gpu(_) => work(),
        }
    }

    /// Refuses what cannot fit, before anything runs.
    ///
    /// # Errors
    /// If it does not fit, with the limit.
    pub fn check_capacity(&self, setup: &Setup, scene: &Scene) -> Result<()> {
        let pixels = u64::from(setup.width) * u64::from(setup.height);
        let size = format!("{}×{}", setup.width, setup.height);
        ensure!(
            pixels <= u64::from(u32::MAX),
            "{size} pixels are more than path indices of 32 bits can name; ask for a smaller picture"
        );
        match self {
            Self::Cpu(_) => {
                let triangles = scene.triangles.len() as u64;
                let needed = (pixels.saturating_mul(CPU_BYTES_PER_PIXEL))
                    .saturating_add(triangles.saturating_mul(CPU_BYTES_PER_TRIANGLE))
                    .saturating_add(CPU_BYTES_PER_CELL << setup.table_bits);
                let free = memory::free();
                ensure!(
                    needed <= free,
                    "{size} pixels and {triangles} triangles need about {} MiB of memory, but only {} MiB are free; ask for a smaller picture or scene",
                    needed >> 20,
                    free >> 20
                );
            }
            Self::Gpu(device) => {
                device.check_extent(scene)?;
                let limits = &device.gpu.adapter().limits;
                let limit = limits.storage_binding_bytes.min(limits.buffer_bytes);
                let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
                let items = [
                    (format!("{size} pixels"), pixels),
                    (format!("{vertices} vertices"), vertices),
                    (format!("{triangles} triangles"), triangles),
                ];
                for (what, count) in items {
                    let needed = count.saturating_mul(GPU_BYTES_PER_ITEM);
                    ensure!(
                        needed <= limit,
                        "{what} need a storage binding of {} MiB, but {} allows {} MiB; ask for less, or use --backend cpu",
                        needed.div_ceil(1 << 20),
                        device.gpu.adapter().title(),
                        limit >> 20
                    );
                }
            }
        }
        Ok(())
    }

    /// What the user should know.
    pub fn notices(&self) -> Vec<String> {
        match self {
            Self::Cpu(device) => device.passed_over.iter().cloned().collect(),
            Self::Gpu(device) if device.gpu.adapter().is_software() => {
                vec![format!(
                    "{} computes on the CPU: its times say nothing about graphics cards",
                    device.gpu.adapter().name
                )]
            }
            Self::Gpu(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiny_scenes_are_refused_where_denormal_numbers_are_flushed() {
        let gpu = crate::device::test_gpu().clone();
        let mut scene = scenes::load("builtin:cornell").unwrap();
        let found = SelfCheck::run(&gpu).unwrap();
        let device = |flushes_denormals| GpuDevice {
            gpu: gpu.clone(),
            self_check: SelfCheck { flushes_denormals, ..found.clone() },
        };
        device(true).check_extent(&scene).unwrap();
        scene.positions.iter_mut().flatten().for_each(|value| *value *= 1e-9);
        device(false).check_extent(&scene).unwrap();
        let text = device(true).check_extent(&scene).unwrap_err().to_string();
        assert!(text.contains("--backend cpu") && text.contains("0.0001"), "{text}");
    }
}
