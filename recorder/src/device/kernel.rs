//! From WGSL to a pipeline that can be dispatched: bindings, immediates, constants and grids.

use super::{Gpu, GpuError};

/// Finds a thread's place in a grid that may be two-dimensional; put it in front of a kernel.
///
/// `linear_workgroup(workgroup_id, num_workgroups)` counts workgroups from 0; a grid can have more
/// workgroups than were asked for, so a kernel must return where there is nothing to do.
pub const LINEAR_WORKGROUP_WGSL: &str = "\
fn linear_workgroup(workgroup_id: vec3<u32>, num_workgroups: vec3<u32>) -> u32 {
    return workgroup_id.y * num_workgroups.x + workgroup_id.x;
}
";

/// One WGSL definition per constant, so that what is written in Rust is not written again.
///
/// Put it in front of a kernel.
pub fn constants_wgsl(constants: &[(&str, u32)]) -> String {
    constants.iter().map(|(name, value)| format!("const {name}: u32 = {value}u;\n")).collect()
}

/// What a kernel does with a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`.
    ReadWrite,
    /// `var acceleration_structure`, for `ray-query`.
    AccelerationStructure,
}

/// What a kernel is made from.
#[derive(Clone, Copy, Debug)]
pub struct KernelSource<'a> {
    /// `stage::name`, seen in errors and profilers.
    pub label: &'a str,
    /// The whole module.
    pub wgsl: &'a str,
    /// The function to run.
    pub entry_point: &'a str,
    /// The bindings of group 0, numbered from 0.
    pub bindings: &'a [Binding],
    /// Size of the `var<immediate>` that the module declares; 0 if none.
    pub immediate_bytes: u32,
}

/// A compiled kernel.
#[derive(Clone, Debug)]
pub struct Kernel {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) label: String,
    layout: wgpu::BindGroupLayout,
    pub(super) immediate_bytes: u32,
}

impl Kernel {
    /// Compiles WGSL without index checks and loop bounds in release builds; debug builds, and
    /// with them the tests, keep both.
    ///
    /// # Errors
    /// [`GpuError::Refused`] with the compiler's words.
    ///
    /// # Safety
    /// With the arrays that it will be given, the kernel must neither index out of bounds nor loop
    /// for ever, nor divide integers by zero.
    pub unsafe fn trusted(gpu: &Gpu, source: &KernelSource<'_>) -> Result<Self, GpuError> {
        let checks = if cfg!(debug_assertions) {
            wgpu::ShaderRuntimeChecks::checked()
        } else {
            wgpu::ShaderRuntimeChecks::unchecked()
        };
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(source.label),
            source: wgpu::ShaderSource::Wgsl(source.wgsl.into()),
        };
        // SAFETY: the caller vouches for the kernel.
        let module = unsafe { gpu.device().create_shader_module_trusted(descriptor, checks) };
        let running = format!("compiling {}", source.label);
        gpu.check(&running)?;
        let layout = group_layout(gpu, source.label, source.bindings);
        let pipeline_layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(source.label),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: source.immediate_bytes,
        });
        let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(source.label),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(source.entry_point),
            compilation_options: wgpu::PipelineCompilationOptions {
                // Kernels write workgroup memory before they read it.
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        gpu.check(&running)?;
        Ok(Self { pipeline, label: source.label.to_owned(), layout, immediate_bytes: source.immediate_bytes })
    }

    /// Binds resources, in the order of the kernel's bindings.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when they do not fit these.
    pub fn bind(
        &self,
        gpu: &Gpu,
        resources: &[wgpu::BindingResource<'_>],
    ) -> Result<wgpu::BindGroup, GpuError> {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        let bound = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.layout,
            entries: &entries,
        });
        gpu.check(&format!("binding group 0 of {}", self.label))?;
        Ok(bound)
    }
}

/// A grid of at least `workgroups` workgroups, two-dimensional where one axis has not enough room.
pub(super) fn grid(workgroups: u32, largest_axis: u32) -> [u32; 3] {
    let rows = workgroups.div_ceil(largest_axis).max(1);
    [workgroups.div_ceil(rows), rows, 1]
}

fn group_layout(gpu: &Gpu, label: &str, bindings: &[Binding]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: binding_type(*kind),
            count: None,
        })
        .collect();
    gpu.device()
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn binding_type(kind: Binding) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    match kind {
        Binding::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        Binding::ReadWrite => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        Binding::AccelerationStructure => wgpu::BindingType::AccelerationStructure { vertex_return: false },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_gpu;

    /// Adds 1 to the element of each item.
    const COUNT_WGSL: &str = "
        @group(0) @binding(0) var<storage, read_write> visits: array<u32>;
        struct Chunk { first: u32, count: u32 }
        var<immediate> chunk: Chunk;
        @compute @workgroup_size(THREADS)
        fn count(@builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) grid: vec3<u32>,
                 @builtin(local_invocation_index) thread: u32) {
            let item = linear_workgroup(id, grid) * THREADS + thread;
            if item < chunk.count {
                visits[chunk.first + item] += 1u;
            }
        }";

    fn count_kernel(gpu: &Gpu, threads: u32) -> Kernel {
        let head = constants_wgsl(&[("THREADS", threads)]);
        let wgsl = [&head, LINEAR_WORKGROUP_WGSL, COUNT_WGSL].concat();
        let source = KernelSource {
            label: "test::count",
            wgsl: &wgsl,
            entry_point: "count",
            bindings: &[Binding::ReadWrite],
            immediate_bytes: 8,
        };
        // SAFETY: items are below the count, which the tests keep to the array.
        unsafe { Kernel::trusted(gpu, &source).unwrap() }
    }

    #[test]
    fn more_workgroups_than_one_axis_holds_are_all_run() {
        let gpu = test_gpu();
        let kernel = count_kernel(gpu, 1);
        let items = gpu.adapter().limits.workgroups_per_axis.min(1 << 20) + 4_321;
        let visits = gpu.array::<u32>("test::visits", items as usize).unwrap();
        let group = kernel.bind(gpu, &[visits.binding()]).unwrap();
        let mut run = gpu.stage("test");
        run.dispatch(&kernel, &group, &[0, items], items);
        run.finish().unwrap();
        assert!(gpu.read_vec(&visits).unwrap().iter().all(|&count| count == 1));
    }

    #[test]
    fn grids_hold_what_is_asked_for_and_little_more() {
        for workgroups in [0, 1, 7, 65_535, 65_536, 131_071, 10_000_019] {
            let [x, y, z] = grid(workgroups, 65_535).map(u64::from);
            assert!(x <= 65_535 && y <= 65_535 && z == 1, "{workgroups}: {x} {y}");
            let surplus = (x * y).checked_sub(u64::from(workgroups));
            assert!(surplus.is_some_and(|surplus| surplus < y), "{workgroups}: {x} {y}");
        }
    }

    #[test]
    fn a_kernel_that_does_not_compile_is_an_error_with_its_name() {
        let gpu = test_gpu();
        let source = KernelSource {
            label: "test::nonsense",
            wgsl: "fn main( {",
            entry_point: "main",
            bindings: &[],
            immediate_bytes: 0,
        };
        // SAFETY: it is no kernel.
        let error = unsafe { Kernel::trusted(gpu, &source) }.unwrap_err().to_string();
        assert!(error.contains("compiling test::nonsense"), "{error}");
    }

    #[test]
    fn clears_and_copies_keep_their_place_among_dispatches() {
        let gpu = test_gpu();
        let kernel = count_kernel(gpu, 64);
        let visits = gpu.array_of("test::visits", &[7_u32; 100]).unwrap();
        let before = gpu.array::<u32>("test::before", 100).unwrap();
        let after = gpu.array::<u32>("test::after", 100).unwrap();
        let group = kernel.bind(gpu, &[visits.binding()]).unwrap();
        let mut run = gpu.stage("test");
        run.copy(&visits, &before, 100);
        run.clear(&visits);
        run.dispatch(&kernel, &group, &[0, 100], 2);
        run.copy(&visits, &after, 50);
        run.dispatch(&kernel, &group, &[0, 10], 1);
        let elapsed_ns = run.finish().unwrap();
        assert_eq!(gpu.read_vec(&before).unwrap(), [7; 100]);
        assert_eq!(gpu.read_vec(&after).unwrap(), [[1; 50], [0; 50]].concat());
        assert_eq!(gpu.read_vec(&visits).unwrap()[..12], [2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1]);
        assert!(elapsed_ns > 0);
    }
}
