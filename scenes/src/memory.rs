//! How much memory is free, so that what cannot fit is refused before it is made.

use sysinfo::System;

/// That something needs more memory than is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("about {} MiB of memory are needed, but only {} MiB are free", needed >> 20, free >> 20)]
pub struct Shortage {
    /// Bytes that are needed, at least.
    pub needed: u64,
    /// Bytes that were free.
    pub free: u64,
}

/// Free memory and swap space, bytes, or what a control group (a container, a job of a cluster) leaves of
/// them. Where the system does not tell, [`u64::MAX`], so that nothing is refused.
pub fn free() -> u64 {
    let found = System::new().map_or(0, |mut system| {
        system.refresh_memory();
        let all = system.available_memory().saturating_add(system.free_swap());
        let limits = system.cgroup_limits();
        limits.map_or(all, |limits| all.min(limits.free_memory.saturating_add(limits.free_swap)))
    });
    if found > 0 { found } else { u64::MAX }
}

/// Whether `needed` bytes fit into `free` ones.
///
/// # Errors
/// If they do not.
pub(crate) fn check(needed: u64, free: u64) -> Result<(), Shortage> {
    if needed <= free { Ok(()) } else { Err(Shortage { needed, free }) }
}
