//! Where and how rays are traced.

use super::error::{OptionError, in_range};
use crate::cache_model::L2_BYTES;
use crate::stages::trace::TraceKernel;

/// Where to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BackendChoice {
    /// A hardware GPU that passes the self-check, else the CPU.
    Auto,
    /// A GPU; a software adapter if there is no other.
    Gpu,
    /// Native threads.
    Cpu,
}

/// Where and how to trace.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceOptions {
    /// Where to run: auto takes a hardware GPU that passes the self-check, else the CPU.
    #[arg(long, value_enum, default_value_t = BackendChoice::Auto)]
    pub backend: BackendChoice,
    /// GPU by a part of its name, driver or backend (see `recorder adapters`).
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    /// Trace kernel; if not given a replay's source's, else wide on threads and cwbvh on GPUs.
    #[arg(long, value_enum)]
    pub trace: Option<TraceKernel>,
    /// Second level of the cache model in KiB; its first level has 128.
    #[arg(long, default_value_t = L2_BYTES >> 10)]
    pub l2_kib: u64,
    /// Threads of the CPU backend; all cores if not given.
    #[arg(long)]
    pub threads: Option<usize>,
    /// Tie each of these threads to a processor of its own (Linux).
    #[arg(long)]
    pub pin: bool,
}

impl Default for DeviceOptions {
    fn default() -> Self {
        Self {
            backend: BackendChoice::Auto,
            adapter: None,
            trace: None,
            l2_kib: L2_BYTES >> 10,
            threads: None,
            pin: false,
        }
    }
}

impl DeviceOptions {
    /// Whether threads will not do.
    pub fn asks_for_gpu(&self) -> bool {
        self.backend == BackendChoice::Gpu || self.adapter.is_some()
    }

    /// Checks what can be judged without opening a device.
    ///
    /// # Errors
    /// The first option that makes no sense.
    pub fn check(&self) -> Result<(), OptionError> {
        in_range("l2-kib", self.l2_kib, 64, 1 << 20)?;
        if let Some(threads) = self.threads {
            in_range("threads", threads, 1, 4096)?;
        }
        let is_cpu = self.backend == BackendChoice::Cpu;
        let for_threads = self.trace.filter(|kernel| !kernel.is_for_gpus());
        let message = if self.pin && !cfg!(target_os = "linux") {
            "--pin ties threads to processors, which this system is not asked for; leave it out"
        } else if self.pin && self.asks_for_gpu() {
            "--pin ties the threads of the cpu backend, but --backend gpu or --adapter asks for a GPU; leave one of them out"
        } else if is_cpu && self.trace == Some(TraceKernel::RayQuery) {
            "kernel ray-query needs a GPU that has ray queries; use --backend gpu, or wide, cwbvh, bvh2, lanes or packet"
        } else if let Some(kernel) = for_threads.filter(|_| self.asks_for_gpu()) {
            return Err(OptionError::conflict(format!(
                "kernel {} is for threads; use --backend cpu without --adapter, or cwbvh or bvh2",
                kernel.name()
            )));
        } else if is_cpu && self.adapter.is_some() {
            "--adapter names a GPU, but --backend cpu asks for threads; leave one of them out"
        } else {
            return Ok(());
        };
        Err(OptionError::conflict(message))
    }
}
