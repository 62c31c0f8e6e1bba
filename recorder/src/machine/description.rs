//! A device as manifests and benchmarks describe it.

use formats::manifest::{Adapter, Backend, Check};
use sysinfo::System;

use super::{CpuDevice, Device, GpuDevice};

/// What a recording says of the device that it was made on.
pub struct Description {
    /// Threads or a GPU.
    pub backend: Backend,
    /// The processor or the adapter.
    pub adapter: Adapter,
    /// Limits of the adapter, or what times depend on beside the processor, by name.
    pub limits: Vec<(String, u64)>,
    /// Findings of the self-check.
    pub self_check: Vec<Check>,
    /// Whether keys must equal those of IEEE arithmetic.
    pub ieee_arithmetic: bool,
    /// Whose clock times are of.
    pub time_source: &'static str,
    /// Threads of the cpu backend; 0 on a GPU.
    pub threads: u32,
}

impl Description {
    /// Describes a device.
    pub fn of(device: &Device) -> Self {
        match device {
            Device::Cpu(device) => Self::of_threads(device),
            Device::Gpu(device) => Self::of_adapter(device),
        }
    }

    fn of_threads(device: &CpuDevice) -> Self {
        let name = System::new().ok().and_then(|mut system| {
            system.refresh_cpu_all();
            system.cpus().first().map(|cpu| cpu.brand().trim().to_owned())
        });
        let brand = name.filter(|name| !name.is_empty());
        Self {
            backend: Backend::Cpu,
            adapter: Adapter {
                name: super::processors::name(brand.as_deref().unwrap_or(std::env::consts::ARCH)),
                driver: String::new(),
                device_type: "cpu".into(),
                backend: "threads".into(),
            },
            limits: super::processors::facts(),
            self_check: Vec::new(),
            ieee_arithmetic: true,
            time_source: "monotonic clock",
            threads: device.pool.current_num_threads() as u32,
        }
    }

    fn of_adapter(GpuDevice { gpu, self_check }: &GpuDevice) -> Self {
        let adapter = gpu.adapter();
        let limits = &adapter.limits;
        let limits = [
            ("buffer_bytes", limits.buffer_bytes),
            ("storage_binding_bytes", limits.storage_binding_bytes),
            ("storage_bindings", limits.storage_bindings.into()),
            ("workgroup_bytes", limits.workgroup_bytes.into()),
            ("workgroup_threads", limits.workgroup_threads.into()),
            ("workgroups_per_axis", limits.workgroups_per_axis.into()),
        ];
        Self {
            backend: Backend::Gpu,
            adapter: Adapter {
                name: adapter.name.clone(),
                driver: format!("{} {}", adapter.driver, adapter.driver_info).trim().to_owned(),
                device_type: adapter.device_type.clone(),
                backend: adapter.backend.clone(),
            },
            limits: limits.map(|(name, limit)| (name.to_owned(), limit)).to_vec(),
            self_check: self_check.checks.clone(),
            ieee_arithmetic: self_check.ieee_arithmetic,
            time_source: if adapter.timestamps {
                "gpu timestamps"
            } else {
                "monotonic clock around submissions"
            },
            threads: 0,
        }
    }
}
