//! Backends for benchmarks, on one device: one, or one per trace kernel.

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
pub(super) trait OnBackend {
    /// What it gives.
    type Output: Send;

    /// Measures.
    ///
    /// # Errors
    /// Any of the backend.
    fn run<B: Backend>(self, backend: &mut B) -> Result<Self::Output>;
}

/// The same on several at once.
pub(super) trait OnBackends {
    /// What it gives.
    type Output: Send;

    /// Measures; `backends` has one for each configuration.
    ///
    /// # Errors
    /// Any of the backends.
    fn run<B: Backend>(self, backends: Vec<B>) -> Result<Self::Output>;
}

/// The first of several, which is the only one.
struct Only<M>(M);

impl<M: OnBackend> OnBackends for Only<M> {
    type Output = M::Output;

    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<M::Output> {
        self.0.run(&mut backends[0])
    }
}

/// What a backend is made for.
pub(super) struct Configuration {
    pub(super) setup: Arc<Setup>,
    pub(super) kernel: TraceKernel,
}

/// Runs a measurement on one backend: see [`measure_all`].
///
/// # Errors
/// As [`measure_all`].
pub(super) fn measure<M: OnBackend + Send>(
    device: &Device,
    scene: &Scene,
    setup: &Arc<Setup>,
    kernel: TraceKernel,
    measurement: M,
) -> Result<M::Output> {
    let configuration = Configuration { setup: Arc::clone(setup), kernel };
    measure_all(device, scene, &[configuration], Only(measurement))
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
