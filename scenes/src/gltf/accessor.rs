//! Typed reading of accessors (glTF 2.0 §3.6.2): interleaved, sparse, normalised, all checked.

use std::borrow::Cow;

use ::gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use ::gltf::json::buffer::View;
use ::gltf::json::{Index, validation::Checked};

use super::Document;
use super::error::GltfError;

/// The largest accessor that has no bytes in the file (no buffer view), in bytes: it starts as zeros,
/// and a few characters of JSON must not allocate without bound.
const MAX_ZERO_FILLED_BYTES: u64 = 1 << 26;

/// How many elements an accessor has, or fewer if its bytes could not hold so many: then reading it says why.
pub(super) fn plausible_count(document: &Document, index: Index<Accessor>) -> u64 {
    let Some(accessor) = document.root.get(index) else { return 0 };
    let bytes = match accessor.buffer_view.map(|view| document.root.get(view)) {
        Some(view) => {
            let buffer = view.and_then(|view| document.buffers.get(view.buffer.value())?.as_ref());
            buffer.map_or(0, |bytes| bytes.len() as u64)
        }
        None => MAX_ZERO_FILLED_BYTES,
    };
    // Each has at least a byte.
    accessor.count.0.min(bytes)
}

/// The elements of one accessor. All reads below `len` are in bounds.
pub(super) struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    stride: usize,
    len: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Elements<'a> {
    /// Opens an accessor whose elements should be of the type `shape`.
    pub(super) fn open(
        document: &'a Document,
        index: Index<Accessor>,
        shape: Type,
        from: impl FnOnce() -> String,
    ) -> Result<Self, GltfError> {
        let json = document.get(index, from, "accessor")?;
        let accessor = index.value();
        let refuse = |problem: String| GltfError::Accessor { accessor, problem };
        let (Checked::Valid(component), Checked::Valid(found)) = (json.component_type, json.type_) else {
            return Err(refuse("has a type or component type that glTF does not have".into()));
        };
        if found != shape {
            return Err(refuse(format!("has elements of type {found:?}, expected {shape:?}")));
        }
        let element_bytes = component.0.size() * shape.multiplicity();
        let (bytes, stride, len) = match json.buffer_view {
            Some(view) => {
                let from = || format!("accessor {accessor}");
                let (bytes, view) = document.view(view, from)?;
                let start = json.byte_offset.unwrap_or_default().0;
                let strided = Strided { start, count: json.count.0, element_bytes };
                strided.cut(bytes, view).map_err(refuse)?
            }
            None => {
                let total = json.count.0.saturating_mul(element_bytes as u64);
                if total > MAX_ZERO_FILLED_BYTES {
                    let problem = format!(
                        "has {} elements but no buffer view; at most {MAX_ZERO_FILLED_BYTES} bytes may be left out",
                        json.count.0
                    );
                    return Err(refuse(problem));
                }
                (Cow::Owned(vec![0; total as usize]), element_bytes, json.count.0 as usize)
            }
        };
        let mut elements = Self { bytes, stride, len, component: component.0, normalized: json.normalized };
        if let Some(sparse) = &json.sparse {
            elements.overwrite(document, accessor, sparse, element_bytes)?;
        }
        Ok(elements)
    }

    /// How many elements there are.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The type of each component.
    pub(super) fn component(&self) -> ComponentType {
        self.component
    }

    /// Element `index` as a vector. `N` is at most the number of components.
    pub(super) fn vector<const N: usize>(&self, index: usize) -> [f32; N] {
        let size = self.component.size();
        let element = &self.bytes[index * self.stride..][..N * size];
        std::array::from_fn(|axis| self.number(&element[axis * size..][..size]))
    }

    /// Component `axis` of element `index` of an accessor of unsigned numbers.
    pub(super) fn unsigned(&self, index: usize, axis: usize) -> u32 {
        let size = self.component.size();
        let number = &self.bytes[index * self.stride + axis * size..][..size];
        number.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
    }

    /// One component as a real number; integers are normalised if the accessor says so (§3.6.2.2).
    fn number(&self, bytes: &[u8]) -> f32 {
        let (value, largest) = match (self.component, bytes) {
            (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            (ComponentType::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
            (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), f32::from(u16::MAX)),
            (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), f32::from(i16::MAX)),
            (ComponentType::U8, &[a]) => (f32::from(a), f32::from(u8::MAX)),
            (ComponentType::I8, &[a]) => (f32::from(a as i8), f32::from(i8::MAX)),
            _ => unreachable!("components are read with the size of their type"),
        };
        if self.normalized { (value / largest).max(-1.0) } else { value }
    }

    /// Replaces the elements that a sparse accessor lists.
    fn overwrite(
        &mut self,
        document: &Document,
        accessor: usize,
        sparse: &Sparse,
        element_bytes: usize,
    ) -> Result<(), GltfError> {
        let refuse = |problem: String| GltfError::Accessor { accessor, problem };
        let from = || format!("the sparse part of accessor {accessor}");
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(refuse("has sparse indices of a type that glTF does not have".into()));
        };
        let count = sparse.count.0;

        let (bytes, view) = document.view(sparse.indices.buffer_view, from)?;
        let start = sparse.indices.byte_offset.0;
        let strided = Strided { start, count, element_bytes: index_type.0.size() };
        let (bytes, stride, len) = strided.cut(bytes, view).map_err(refuse)?;
        let indices = Elements { bytes, stride, len, component: index_type.0, normalized: false };

        let (bytes, view) = document.view(sparse.values.buffer_view, from)?;
        let strided = Strided { start: sparse.values.byte_offset.0, count, element_bytes };
        let (values, value_stride, _) = strided.cut(bytes, view).map_err(refuse)?;

        let target = self.bytes.to_mut();
        for place in 0..len {
            let index = indices.unsigned(place, 0) as usize;
            if index >= self.len {
                return Err(refuse(format!("has sparse index {index}, but only {} elements", self.len)));
            }
            let value = &values[place * value_stride..][..element_bytes];
            target[index * self.stride..][..element_bytes].copy_from_slice(value);
        }
        Ok(())
    }
}

/// Where elements lie in a buffer view.
struct Strided {
    start: u64,
    count: u64,
    element_bytes: usize,
}

impl Strided {
    /// The bytes from the first element to the end of the last one, their stride and their count;
    /// or what is wrong, as the rest of a sentence about the accessor.
    fn cut<'a>(&self, view_bytes: &'a [u8], view: &View) -> Result<(Cow<'a, [u8]>, usize, usize), String> {
        let Self { start, count, element_bytes } = *self;
        let stride = view.byte_stride.map_or(element_bytes, |stride| stride.0);
        if stride < element_bytes {
            return Err(format!("has elements of {element_bytes} bytes in a buffer view of stride {stride}"));
        }
        let end = match count {
            0 => start,
            _ => (count - 1)
                .saturating_mul(stride as u64)
                .saturating_add(element_bytes as u64)
                .saturating_add(start),
        };
        // A range that fits the view fits usize.
        if end > view_bytes.len() as u64 {
            return Err(format!(
                "reaches to byte {end} of its buffer view, which has {} bytes",
                view_bytes.len()
            ));
        }
        let bytes = &view_bytes[start as usize..end as usize];
        Ok((Cow::Borrowed(bytes), stride, count as usize))
    }
}
