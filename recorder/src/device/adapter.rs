//! The adapters of this machine: which there are, which one is chosen, and what it is.

use serde::Serialize;

use super::GpuError;

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AdapterRequest {
    /// The best hardware GPU; software adapters are passed over.
    Hardware,
    /// The best hardware GPU, else a software adapter.
    Any,
    /// The first whose name, driver or backend contains this text, in upper or lower case.
    Named(String),
}

/// What an adapter is and how much it allows; manifests have some of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterDescription {
    /// The card, as the driver calls it.
    pub name: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver, in its own words.
    pub driver_info: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub device_type: String,
    /// Vendor, mostly a PCI id.
    pub vendor_id: u32,
    /// Device, mostly a PCI id.
    pub device_id: u32,
    /// Fewest threads in a subgroup.
    pub subgroup_min_size: u32,
    /// Most threads in a subgroup.
    pub subgroup_max_size: u32,
    /// Whether compute shaders may use subgroup operations.
    pub subgroups: bool,
    /// Whether the device can say how long a pass took.
    pub timestamps: bool,
    /// Whether traversal by the driver (`ray-query`) is offered.
    pub ray_query: bool,
    /// The limits that decide what fits.
    pub limits: AdapterLimits,
}

/// The limits that decide what fits on an adapter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterLimits {
    /// Bytes of the largest buffer.
    pub buffer_bytes: u64,
    /// Bytes of a buffer that one kernel can see through one binding.
    pub storage_binding_bytes: u64,
    /// Storage buffers that one kernel can see.
    pub storage_bindings: u32,
    /// Bytes of memory that the threads of a workgroup share.
    pub workgroup_bytes: u32,
    /// Threads of a workgroup.
    pub workgroup_threads: u32,
    /// Workgroups of a dispatch, along each axis.
    pub workgroups_per_axis: u32,
}

impl AdapterDescription {
    /// Describes an adapter without opening it.
    pub fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let features = adapter.features();
        let limits = adapter.limits();
        Self {
            name: info.name,
            driver: info.driver,
            driver_info: info.driver_info,
            backend: info.backend.to_str().to_owned(),
            device_type: device_type_name(info.device_type).to_owned(),
            vendor_id: info.vendor,
            device_id: info.device,
            subgroup_min_size: info.subgroup_min_size,
            subgroup_max_size: info.subgroup_max_size,
            subgroups: features.contains(wgpu::Features::SUBGROUP),
            timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            ray_query: features.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY),
            limits: AdapterLimits {
                buffer_bytes: limits.max_buffer_size,
                storage_binding_bytes: limits.max_storage_buffer_binding_size,
                storage_bindings: limits.max_storage_buffers_per_shader_stage,
                workgroup_bytes: limits.max_compute_workgroup_storage_size,
                workgroup_threads: limits.max_compute_invocations_per_workgroup,
                workgroups_per_axis: limits.max_compute_workgroups_per_dimension,
            },
        }
    }

    /// Name and driver, as error messages give them.
    pub fn title(&self) -> String {
        let version = [self.driver.as_str(), self.driver_info.as_str()];
        let version: Vec<&str> = version.into_iter().filter(|text| !text.is_empty()).collect();
        format!("{} ({}, {})", self.name, version.join(" "), self.backend)
    }

    /// Whether the adapter computes on the CPU.
    pub fn is_software(&self) -> bool {
        self.device_type == device_type_name(wgpu::DeviceType::Cpu)
    }

    /// Whether the text occurs in the name, the driver or the backend, in upper or lower case.
    fn matches(&self, wanted: &str) -> bool {
        let wanted = wanted.to_lowercase();
        [&self.name, &self.driver, &self.driver_info, &self.backend]
            .into_iter()
            .any(|text| text.to_lowercase().contains(&wanted))
    }
}

/// All adapters of this machine, the best first: hardware before software, discrete before
/// integrated, Vulkan and Metal before DX12.
pub(crate) fn enumerate() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    // Vulkan's validation layers cost time and are not what debug builds of this program test.
    descriptor.flags = wgpu::InstanceFlags::empty().with_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

fn rank(info: &wgpu::AdapterInfo) -> (u32, u32) {
    let by_type = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (by_type, u32::from(info.backend == wgpu::Backend::Dx12))
}

/// The first adapter that is asked for.
///
/// # Errors
/// If there is none.
pub(super) fn choose(request: &AdapterRequest) -> Result<wgpu::Adapter, GpuError> {
    let adapters = enumerate();
    if adapters.is_empty() {
        return Err(GpuError::NoAdapter);
    }
    let described: Vec<_> = adapters.iter().map(AdapterDescription::of).collect();
    let chosen = described.iter().position(|adapter| match request {
        AdapterRequest::Hardware => !adapter.is_software(),
        AdapterRequest::Any => true,
        AdapterRequest::Named(wanted) => adapter.matches(wanted),
    });
    match chosen {
        Some(index) => Ok(adapters[index].clone()),
        None => {
            let titles: Vec<_> = described.iter().map(AdapterDescription::title).collect();
            let found = titles.join("; ");
            Err(match request {
                AdapterRequest::Named(wanted) => GpuError::NoSuchAdapter { wanted: wanted.clone(), found },
                AdapterRequest::Hardware | AdapterRequest::Any => GpuError::NoHardware { found },
            })
        }
    }
}

fn device_type_name(device_type: wgpu::DeviceType) -> &'static str {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Gpu, skipped, test_gpu};

    #[test]
    fn an_adapter_is_found_by_part_of_its_name_in_any_case() {
        let name = test_gpu().adapter().name.clone();
        let part = name.chars().take(6).collect::<String>().to_uppercase();
        let gpu = Gpu::open(&AdapterRequest::Named(part)).unwrap();
        assert_eq!(gpu.adapter().name, name);
    }

    #[test]
    fn an_unknown_adapter_is_refused_with_those_that_there_are() {
        let error = Gpu::open(&AdapterRequest::Named("abacus".into())).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("\"abacus\"") && text.contains(&test_gpu().adapter().name), "{text}");
    }

    #[test]
    fn hardware_is_not_software() {
        match Gpu::open(&AdapterRequest::Hardware) {
            Ok(gpu) => assert!(!gpu.adapter().is_software()),
            Err(error) => {
                assert!(matches!(error, GpuError::NoHardware { .. }), "{error}");
                skipped("opening a hardware adapter", "there are only software adapters");
            }
        }
    }
}
