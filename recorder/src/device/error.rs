//! Everything that can go wrong on the GPU, in words that say what to do.

/// An error of the adapter, the device or a call on it.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No Vulkan, Metal or DX12 driver is there at all.
    #[error(
        "no GPU adapter was found; install a Vulkan driver (on Debian 12: mesa-vulkan-drivers from \
         bookworm-backports, which also brings the software adapter lavapipe), or use --backend cpu"
    )]
    NoAdapter,

    /// There are adapters, but all of them compute on the CPU.
    #[error(
        "no hardware GPU was found, only software adapters ({found}); \
         choose one by name with --adapter, or use --backend cpu"
    )]
    NoHardware {
        /// Names of the software adapters.
        found: String,
    },

    /// No adapter has the wanted text in its name, driver or backend.
    #[error("no adapter matches \"{wanted}\"; the adapters here are {found}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// The adapters that there are.
        found: String,
    },

    /// The adapter lacks something that was asked for or that kernels need.
    #[error("the adapter {adapter} {lack}")]
    Unfit {
        /// Name and driver of the adapter.
        adapter: String,
        /// What it lacks, as in "offers no …", and what to do instead.
        lack: String,
    },

    /// The driver refused to open the device.
    #[error("the adapter {adapter} could not be opened; is another program holding it, or its memory full?")]
    Open {
        /// Name and driver of the adapter.
        adapter: String,
        /// What wgpu said.
        source: wgpu::RequestDeviceError,
    },

    /// An array is larger than the adapter allows.
    #[error(
        "{label} needs {bytes} bytes, but the adapter {adapter} allows {limit_bytes} ({limit}); \
         use a lower resolution, a smaller scene or another adapter"
    )]
    TooLarge {
        /// The array, as `stage::array`.
        label: String,
        /// What it needs.
        bytes: u64,
        /// Name of the limit that is in the way.
        limit: &'static str,
        /// What the limit allows.
        limit_bytes: u64,
        /// Name and driver of the adapter.
        adapter: String,
    },

    /// The device is gone: a watchdog fired, the driver crashed, or the card was removed.
    #[error(
        "the device of {adapter} was lost while running {running}: {reason}; \
         look into the driver's log, and try a lower resolution or another adapter"
    )]
    Lost {
        /// Name and driver of the adapter.
        adapter: String,
        /// What was being run.
        running: String,
        /// What the driver said.
        reason: String,
    },

    /// The device has no memory left.
    #[error(
        "{adapter} ran out of memory while {running}; \
         use a lower resolution, a smaller scene or another adapter"
    )]
    OutOfMemory {
        /// Name and driver of the adapter.
        adapter: String,
        /// What was being done.
        running: String,
    },

    /// wgpu refused a call. A bug of this program or of a driver, never of the user's input.
    #[error("wgpu refused {running} on {adapter}: {description}")]
    Refused {
        /// Name and driver of the adapter.
        adapter: String,
        /// What was being done.
        running: String,
        /// wgpu's own words.
        description: String,
    },

    /// The adapter computes something wrong that results depend on.
    #[error("{adapter} fails the self-check '{check}': {detail}; update the driver, or use --backend cpu")]
    SelfCheck {
        /// Name and driver of the adapter.
        adapter: String,
        /// Name of the check.
        check: String,
        /// What was found and what was expected.
        detail: String,
    },
}
