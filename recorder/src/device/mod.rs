//! The ground under every GPU stage: one adapter opened, kernels compiled, arrays, timed runs, read-back.
//!
//! - [`adapter`]: which adapters there are, which one is chosen, and what it is
//! - [`gpu`]: one adapter opened, and every wgpu error turned into a [`GpuError`]
//! - [`limits`]: what the kernels need of an adapter
//! - [`buffer`]: typed arrays in GPU memory, checked against the adapter's limits
//! - [`kernel`]: WGSL to pipeline, bindings, grids beyond 65,535 workgroups
//! - [`item`]: kernels that run once for each item of a queue, and why they need no index checks
//! - `parameters`: what kernels are told
//! - [`rounding`]: arithmetic that is rounded as it is written, on every device
//! - [`run`]: the dispatches of one stage, recorded, submitted and timed as one figure
//! - `timing`: the device's own clock
//! - [`readback`]: GPU memory to the CPU through a ring of staging buffers

pub mod adapter;
pub mod buffer;
pub mod error;
pub mod gpu;
pub mod item;
pub mod kernel;
pub mod limits;
mod parameters;
pub mod readback;
pub mod rounding;
pub mod run;
mod timing;

pub use adapter::{AdapterDescription, AdapterRequest};
pub use buffer::DeviceArray;
pub use error::GpuError;
pub use gpu::Gpu;
pub use item::{ItemKernel, Module};
pub use kernel::{Binding, Kernel, KernelSource};
pub use parameters::{Chunk, ITEMS, Parameters, WgslType};
pub use readback::Readback;
pub use rounding::Rounding;
pub use run::StageRun;

/// The device that the tests of one process share: any adapter, software ones too.
///
/// # Panics
/// Without an adapter, saying what to install: a GPU test is never skipped in silence.
#[cfg(test)]
pub(crate) fn test_gpu() -> &'static Gpu {
    static GPU: std::sync::OnceLock<Gpu> = std::sync::OnceLock::new();
    GPU.get_or_init(|| match Gpu::open(&AdapterRequest::Any) {
        Ok(gpu) => gpu,
        Err(error) => panic!("the GPU tests need an adapter: {error}"),
    })
}

/// Says past the test harness, which hides what passing tests print, what was not tested and why.
#[cfg(test)]
pub(crate) fn skipped(what: &str, why: &str) {
    use std::io::Write;
    std::io::stderr().write_all(format!("skipped: {what}: {why}\n").as_bytes()).unwrap();
}
