//! What the kernels need of an adapter: checked before a device is opened, so that a lack is a sentence
//! and not the driver's or wgpu's affair.

use super::{AdapterDescription, GpuError};

/// Storage buffers that a kernel may bind: what WebGPU promises everywhere. Devices are opened with
/// this many, however many an adapter allows, so that a kernel with more compiles nowhere.
pub const STORAGE_BUFFERS: u32 = 8;
/// Bytes of the longest immediates; [`super::Module::immediate`] takes no longer ones.
pub const IMMEDIATE_BYTES: u32 = 80;
/// Threads of the largest workgroup.
pub const WORKGROUP_THREADS: u32 = 256;
/// Bytes of workgroup memory with which every stage has a kernel; the sort takes more where there is more.
pub const WORKGROUP_BYTES: u32 = 16 << 10;

/// Refuses an adapter whose limits are lower than what some kernel needs.
///
/// # Errors
/// [`GpuError::Unfit`] with the first limit that is.
pub(super) fn check(adapter: &AdapterDescription, limits: &wgpu::Limits) -> Result<(), GpuError> {
    let needs = [
        ("storage buffers in a kernel", limits.max_storage_buffers_per_shader_stage, STORAGE_BUFFERS),
        ("bytes of immediate data", limits.max_immediate_size, IMMEDIATE_BYTES),
        ("threads in a workgroup", limits.max_compute_invocations_per_workgroup, WORKGROUP_THREADS),
        ("threads along a workgroup", limits.max_compute_workgroup_size_x, WORKGROUP_THREADS),
        ("bytes of workgroup memory", limits.max_compute_workgroup_storage_size, WORKGROUP_BYTES),
    ];
    match needs.into_iter().find(|&(_, allowed, needed)| allowed < needed) {
        None => Ok(()),
        Some((what, allowed, needed)) => {
            let lack = format!(
                "allows {allowed} {what}, but {needed} are needed; use another adapter or --backend cpu"
            );
            Err(GpuError::Unfit { adapter: adapter.title(), lack })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_gpu;

    /// The limits that WebGPU promises, and the immediates that Vulkan does.
    fn promised() -> wgpu::Limits {
        wgpu::Limits { max_immediate_size: 128, ..wgpu::Limits::default() }
    }

    #[test]
    fn what_webgpu_promises_is_enough() {
        check(test_gpu().adapter(), &promised()).unwrap();
    }

    #[test]
    fn a_limit_that_is_too_low_is_named_with_what_is_needed() {
        let mut cases = Vec::new();
        let mut lower = |what, change: fn(&mut wgpu::Limits)| {
            let mut limits = promised();
            change(&mut limits);
            cases.push((what, limits));
        };
        lower("7 storage buffers in a kernel, but 8", |limits| {
            limits.max_storage_buffers_per_shader_stage = 7;
        });
        lower("64 bytes of immediate data, but 80", |limits| limits.max_immediate_size = 64);
        lower("128 threads in a workgroup, but 256", |limits| {
            limits.max_compute_invocations_per_workgroup = 128;
        });
        lower("128 threads along a workgroup, but 256", |limits| {
            limits.max_compute_workgroup_size_x = 128;
        });
        lower("8192 bytes of workgroup memory, but 16384", |limits| {
            limits.max_compute_workgroup_storage_size = 8192;
        });
        for (what, limits) in cases {
            let text = check(test_gpu().adapter(), &limits).unwrap_err().to_string();
            assert!(text.contains(what) && text.contains("--backend cpu"), "{text}");
        }
    }
}
