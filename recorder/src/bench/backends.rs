//! Backends for benchmarks: one per trace kernel, all of them on one device.

use std::sync::Arc;

use anyhow::{Context, Result};
use scenes::Scene;

use crate::backends::Backend;
use crate::backends::cpu::CpuBackend;
use crate::backends::gpu::GpuBackend;
use crate::machine::Device;
use crate::stages::setup::Setup;
use crate::stages::trace::TraceKernel;
use crate::stages::trace::cpu::CpuTracer;

/// Something to measure on any backend.
pub(super) trait OnBackends {
    /// What it gives.
    type Output: Send;

    /// Measures; `backends` has one for each kernel.
    ///
    /// # Errors
    /// Any of the backends.
    fn run<B: Backend>(self, backends: Vec<B>) -> Result<Self::Output>;
}

/// What a backend is made for.
pub(super) struct Configuration {
    pub(super) setup: Arc<Setup>,
    pub(super) kernel: TraceKernel,
}

/// Runs a measurement with a backend for each kernel: see [`measure_all`].
///
/// # Errors
/// As [`measure_all`].
pub(super) fn measure<M: OnBackends + Send>(
    device: &Device,
    scene: &Scene,
    setup: &Arc<Setup>,
    kernels: &[TraceKernel],
    measurement: M,
) -> Result<M::Output> {
    let of_kernel = |&kernel: &TraceKernel| Configuration { setup: Arc::clone(setup), kernel };
    let configurations: Vec<_> = kernels.iter().map(of_kernel).collect();
    measure_all(device, scene, &configurations, measurement)
}

/// Runs a measurement with several backends, on the threads of the device if it has its own.
///
/// # Errors
/// If a hierarchy cannot be built, a backend not be made, and any of the measurement.
pub(super) fn measure_all<M: OnBackends + Send>(
    device: &Device,
    scene: &Scene,
    configurations: &[Configuration],
    measurement: M,
) -> Result<M::Output> {
    match device {
        Device::Cpu(cpu) => cpu.pool.install(|| {
            let backend = |Configuration { setup, kernel }: &Configuration| {
                let found = kernel.hierarchy(scene)?;
                let (bvh, _) = found.context("threads have no ray queries; use --backend gpu")?;
                let tracer = CpuTracer::for_features(scene, &bvh, &setup.features);
                let tracer = tracer.with_kernel(*kernel).with_precision(setup.precision);
                Ok(CpuBackend::new(Arc::clone(setup), Arc::new(tracer)))
            };
            measurement.run(configurations.iter().map(backend).collect::<Result<_>>()?)
        }),
        Device::Gpu(device) => {
            let backend = |Configuration { setup, kernel }: &Configuration| {
                let bvh = kernel.hierarchy(scene)?.map(|(bvh, _)| bvh);
                GpuBackend::new(device.gpu.clone(), scene, bvh.as_ref(), Arc::clone(setup), *kernel)
            };
            measurement.run(configurations.iter().map(backend).collect::<Result<_>>()?)
        }
    }
}
