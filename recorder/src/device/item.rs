//! Kernels that run once for each item of a queue: the prologue that they share, what it promises, and the one
//! place that vouches for leaving out index checks.

use super::limits::IMMEDIATE_BYTES;
use super::parameters::{Chunk, Parameters, WgslType};
use super::{Binding, Gpu, GpuError, Kernel, KernelSource, Rounding};

/// Threads of a workgroup.
pub(super) const THREADS: u32 = 64;

/// Most items of one submission. A million rays are milliseconds on hardware, and no watchdog waits less than
/// a second.
pub const ITEMS_PER_SUBMISSION: u32 = 1 << 20;

/// How long a bound array must be.
#[derive(Clone, Copy, Debug)]
enum Length {
    /// The stage's to know: indices into it are in range where they are made.
    Any,
    /// So many bytes for each item.
    PerItem(usize),
    /// So many bytes for each item of a dispatch.
    PerItemOfDispatch(usize),
}

/// A WGSL module in the making whose `run_item(index: u32)` does what there is to do for an item. Bindings of
/// group 0 are numbered in the order of their declaration.
#[derive(Clone, Debug)]
pub struct Module {
    label: String,
    declarations: String,
    body: String,
    bindings: Vec<(Binding, Length)>,
    parameters: &'static str,
    immediate_bytes: u32,
}

impl Module {
    /// A module that is told its items alone; the label reads `stage::name`.
    pub(crate) fn new(label: &str) -> Self {
        Self::with_parameters::<Chunk>(label, "chunk").text("struct Chunk { first: u32, count: u32 }")
    }

    /// A module that is told more, in `var<immediate> name`; the struct's definition must be in the text.
    pub(crate) fn with_parameters<P: Parameters>(label: &str, name: &'static str) -> Self {
        const { assert!(size_of::<P>() <= IMMEDIATE_BYTES as usize) };
        Self {
            label: label.to_owned(),
            declarations: format!("var<immediate> {name}: {};\n", P::NAME),
            body: String::new(),
            bindings: Vec::new(),
            parameters: name,
            immediate_bytes: size_of::<P>() as u32,
        }
    }

    /// Adds WGSL text.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.body.push_str(text);
        self.body.push('\n');
        self
    }

    /// Declares an array to read, with an element for each item.
    #[must_use]
    pub fn items<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::Read, Length::PerItem(size_of::<T>()))
    }

    /// Declares an array to write, with an element for each item.
    #[must_use]
    pub fn items_mut<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::ReadWrite, Length::PerItem(size_of::<T>()))
    }

    /// Declares an array to read, with an element for each item of a dispatch.
    #[must_use]
    pub fn dispatch_items<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::Read, Length::PerItemOfDispatch(size_of::<T>()))
    }

    /// Declares an array to write, with an element for each item of a dispatch.
    #[must_use]
    pub fn dispatch_items_mut<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::ReadWrite, Length::PerItemOfDispatch(size_of::<T>()))
    }

    /// Declares an array to read by indices of the stage's own.
    #[must_use]
    pub fn table<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::Read, Length::Any)
    }

    /// Declares an array to write by indices of the stage's own.
    #[must_use]
    pub fn table_mut<T: WgslType>(self, name: &str) -> Self {
        self.storage(name, T::NAME, Binding::ReadWrite, Length::Any)
    }

    /// Declares counters to add to by indices of the stage's own.
    #[must_use]
    pub fn counters(self, name: &str) -> Self {
        self.storage(name, "atomic<u32>", Binding::ReadWrite, Length::Any)
    }

    /// Declares the driver's own hierarchy.
    #[must_use]
    pub fn driver_hierarchy(mut self, name: &str) -> Self {
        self.declarations.insert_str(0, "enable wgpu_ray_query;\n");
        self.declare(&format!("var {name}: acceleration_structure"));
        self.bindings.push((Binding::AccelerationStructure, Length::Any));
        self
    }

    fn storage(mut self, name: &str, element: &str, binding: Binding, length: Length) -> Self {
        let access = if binding == Binding::Read { "read" } else { "read_write" };
        self.declare(&format!("var<storage, {access}> {name}: array<{element}>"));
        self.bindings.push((binding, length));
        self
    }

    fn declare(&mut self, variable: &str) {
        let number = self.bindings.len();
        self.declarations.push_str(&format!("@group(0) @binding({number}) {variable};\n"));
    }

    /// Storage buffers that the kernel binds.
    pub(crate) fn storage_buffers(&self) -> usize {
        let is_buffer = |binding: &Binding| matches!(binding, Binding::Read | Binding::ReadWrite);
        self.bindings.iter().filter(|(binding, _)| is_buffer(binding)).count()
    }

    /// The label.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The whole module, for a device that rounds so.
    pub fn wgsl(&self, rounding: Rounding) -> String {
        let Self { declarations, body, parameters, .. } = self;
        // A dispatch has fewer items than that.
        let arithmetic = rounding.wgsl(&format!("{parameters}.count >> 31u"));
        format!(
            "{declarations}{arithmetic}{body}
@compute @workgroup_size({THREADS})
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
    let item = (group.y * groups.x + group.x) * {THREADS}u + lane;
    if item >= {parameters}.count {{
        return;
    }}
    run_item({parameters}.first + item);
}}
"
        )
    }

    /// Compiles it, without index checks in release builds.
    ///
    /// # Errors
    /// If the driver refuses it.
    pub fn compile(&self, gpu: &Gpu) -> Result<ItemKernel, GpuError> {
        let bindings: Vec<Binding> = self.bindings.iter().map(|(binding, _)| *binding).collect();
        let source = KernelSource {
            label: &self.label,
            wgsl: &self.wgsl(gpu.rounding()),
            entry_point: "main",
            bindings: &bindings,
            immediate_bytes: self.immediate_bytes,
        };
        // SAFETY: modules are made of this crate's own WGSL alone.
        // - Items: `main` ends where the chunk does, chunks end with the items, and `ItemKernel::bind` has
        //   checked that every array with an element for each of them is so long.
        // - Permutations are bijections of their queue's rays that the sort made or `foreign` has checked; places
        //   in a compacted queue are those of a prefix sum, below its total; cells of the length table have as many bits as
        //   the table.
        // - Path indices are below the number of pixels and lights are the scene's: `generate` counts pixels,
        //   `shade` copies indices and takes lights from the scene's table, and `RecordedRays::check` looks at
        //   what is uploaded, from a recording or a file.
        // - Triangles of hits are what a trace kernel found. Vertices, materials, texels and emitters are in
        //   range where `scenes::load` and a replay's geometry have checked them; `scenes::bvh` checks that all
        //   links of a hierarchy lie inside it, that it is a tree, and that its depth fits the stack. Mask
        //   texels are clamped. What the driver's own hierarchy finds is the driver's to vouch for.
        // - Loops end after a constant number of rounds, or with the tree. The one divisor that is no constant
        //   is the count of a cell, which is never 0: `LengthTable::from_touched` refuses it, and a replay what
        //   the rays of a queue would wrap.
        let kernel = unsafe { Kernel::trusted(gpu, &source)? };
        let lengths = self.bindings.iter().map(|(_, length)| *length).collect();
        Ok(ItemKernel { kernel, lengths })
    }
}

/// A compiled [`Module`].
#[derive(Clone, Debug)]
pub struct ItemKernel {
    kernel: Kernel,
    lengths: Vec<Length>,
}

/// A kernel with its resources, for so many items.
#[derive(Debug)]
pub struct BoundKernel<'a> {
    pub(super) kernel: &'a Kernel,
    pub(super) group: wgpu::BindGroup,
    pub(super) count: u32,
}

impl ItemKernel {
    /// Binds resources for `count` items, in the order of the module's bindings.
    ///
    /// # Errors
    /// [`GpuError::Refused`] when they do not fit the bindings.
    ///
    /// # Panics
    /// If an array is shorter than its items, or there are 2^32 items or more.
    pub fn bind(
        &self,
        gpu: &Gpu,
        resources: &[wgpu::BindingResource<'_>],
        count: usize,
    ) -> Result<BoundKernel<'_>, GpuError> {
        for (number, (resource, length)) in resources.iter().zip(&self.lengths).enumerate() {
            let needed = match length {
                Length::Any => 0,
                Length::PerItem(bytes) => count * bytes,
                Length::PerItemOfDispatch(bytes) => count.min(ITEMS_PER_SUBMISSION as usize) * bytes,
            };
            if let wgpu::BindingResource::Buffer(bound) = resource {
                let bytes = bound.buffer.size();
                let label = self.label();
                assert!(
                    needed as u64 <= bytes,
                    "binding {number} of {label} has {bytes} bytes, {count} items need {needed}"
                );
            }
        }
        let count = u32::try_from(count).expect("binding limits keep arrays below 2^32 elements");
        Ok(BoundKernel { kernel: &self.kernel, group: self.kernel.bind(gpu, resources)?, count })
    }

    /// Runs the kernel for `count` items and waits for it; returns the device's time in nanoseconds.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// As [`ItemKernel::bind`].
    pub fn run<P: Parameters>(
        &self,
        gpu: &Gpu,
        resources: &[wgpu::BindingResource<'_>],
        count: usize,
        parameters: P,
    ) -> Result<u64, GpuError> {
        let bound = self.bind(gpu, resources, count)?;
        let mut run = gpu.stage(self.label());
        run.for_items(&[bound], parameters);
        run.finish()
    }

    /// `stage::name`.
    pub fn label(&self) -> &str {
        &self.kernel.label
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{ITEMS, test_gpu};

    fn counting() -> ItemKernel {
        let module = Module::new("test::count").items_mut::<u32>("visits");
        let count = "fn run_item(index: u32) { visits[index] += 1u; }";
        module.text(count).compile(test_gpu()).unwrap()
    }

    #[test]
    fn every_item_is_visited_once_in_chunks_of_any_size() {
        let (gpu, kernel) = (test_gpu(), counting());
        for (items, per_submission) in [(0, 10), (1, 10), (63, 64), (1000, 1), (70_001, 4_096)] {
            // One more than there are items: nothing may be written beyond them.
            let visits = gpu.array::<u32>("test::visits", items + 1).unwrap();
            let bound = kernel.bind(gpu, &[visits.binding()], items).unwrap();
            let mut run = gpu.stage("test");
            run.for_items_by(&[bound], ITEMS, per_submission);
            run.finish().unwrap();
            let mut expected = vec![1; items];
            expected.push(0);
            assert_eq!(gpu.read_vec(&visits).unwrap(), expected, "{items} by {per_submission}");
        }
    }

    #[test]
    fn arrays_shorter_than_their_items_are_not_bound() {
        let (gpu, kernel) = (test_gpu(), counting());
        let visits = gpu.array::<u32>("test::visits", 100).unwrap();
        kernel.bind(gpu, &[visits.binding()], 100).unwrap();
        let bind = || kernel.bind(gpu, &[visits.binding()], 101).map(drop);
        let refused = std::panic::catch_unwind(std::panic::AssertUnwindSafe(bind));
        let message = refused.unwrap_err().downcast::<String>().unwrap();
        assert!(message.contains("test::count has 400 bytes, 101 items need 404"), "{message}");
    }
}
