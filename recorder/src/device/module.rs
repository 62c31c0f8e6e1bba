//! A kernel's module put together: shared structs, constants, bindings, then the stage's own WGSL.

use super::limits::IMMEDIATE_BYTES;
use super::{Binding, Gpu, GpuError, Kernel, KernelSource};

/// A WGSL module in the making, with the bindings of group 0 in the order of their declaration.
#[derive(Clone, Debug)]
pub struct Module {
    label: String,
    declarations: String,
    body: String,
    bindings: Vec<Binding>,
    immediate_bytes: u32,
}

impl Module {
    /// An empty module; the label reads `stage::name`.
    pub fn new(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            declarations: String::new(),
            body: String::new(),
            bindings: Vec::new(),
            immediate_bytes: 0,
        }
    }

    /// Adds WGSL text.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.body.push_str(text);
        self.body.push('\n');
        self
    }

    /// Declares `var<immediate> name` of a shared struct, whose definition must be in the text.
    #[must_use]
    pub fn immediate<T>(mut self, name: &str, type_name: &str) -> Self {
        const { assert!(size_of::<T>() <= IMMEDIATE_BYTES as usize) };
        self.declarations.push_str(&format!("var<immediate> {name}: {type_name};\n"));
        self.immediate_bytes = size_of::<T>() as u32;
        self
    }

    /// Declares an array that the kernel reads; elements of WGSL type `element`.
    #[must_use]
    pub fn read(self, name: &str, element: &str) -> Self {
        self.storage(name, element, Binding::Read)
    }

    /// Declares an array that the kernel writes.
    #[must_use]
    pub fn write(self, name: &str, element: &str) -> Self {
        self.storage(name, element, Binding::ReadWrite)
    }

    /// Declares the driver's own hierarchy.
    #[must_use]
    pub fn driver_hierarchy(mut self, name: &str) -> Self {
        let number = self.bindings.len();
        self.declarations.insert_str(0, "enable wgpu_ray_query;\n");
        self.declarations
            .push_str(&format!("@group(0) @binding({number}) var {name}: acceleration_structure;\n"));
        self.bindings.push(Binding::AccelerationStructure);
        self
    }

    fn storage(mut self, name: &str, element: &str, binding: Binding) -> Self {
        let access = if binding == Binding::Read { "read" } else { "read_write" };
        let number = self.bindings.len();
        self.declarations.push_str(&format!(
            "@group(0) @binding({number}) var<storage, {access}> {name}: array<{element}>;\n"
        ));
        self.bindings.push(binding);
        self
    }

    /// Storage buffers that the kernel binds.
    #[cfg(test)]
    pub(crate) fn storage_buffers(&self) -> usize {
        let is_buffer = |binding: &&Binding| matches!(binding, Binding::Read | Binding::ReadWrite);
        self.bindings.iter().filter(is_buffer).count()
    }

    /// The label.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The whole module.
    pub fn wgsl(&self) -> String {
        format!("{}{}", self.declarations, self.body)
    }

    /// Compiles it without index checks in release builds.
    ///
    /// # Errors
    /// As [`Kernel::trusted`].
    ///
    /// # Safety
    /// As [`Kernel::trusted`].
    pub unsafe fn compile(&self, gpu: &Gpu) -> Result<Kernel, GpuError> {
        let source = KernelSource {
            label: &self.label,
            wgsl: &self.wgsl(),
            entry_point: "main",
            groups: &[&self.bindings],
            immediate_bytes: self.immediate_bytes,
        };
        // SAFETY: the caller vouches for the kernel.
        unsafe { Kernel::trusted(gpu, &source) }
    }
}
