//! How much memory is free, so that what cannot fit is refused before it is made.

use sysinfo::{CGroupLimits, System};

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
    System::new().map_or(u64::MAX, |mut system| {
        system.refresh_memory();
        let all = system.available_memory().saturating_add(system.free_swap());
        let told = if all > 0 { all } else { u64::MAX };
        // Not what the group has free: the files that it read count as taken there, and can be dropped.
        let left = |limits: CGroupLimits| {
            limits.total_memory.saturating_sub(limits.rss).saturating_add(limits.free_swap)
        };
        system.cgroup_limits().map_or(told, |limits| told.min(left(limits)))
    })
}

/// Whether `needed` bytes fit into `free` ones.
///
/// # Errors
/// If they do not.
pub(crate) fn check(needed: u64, free: u64) -> Result<(), Shortage> {
    if needed <= free { Ok(()) } else { Err(Shortage { needed, free }) }
}
