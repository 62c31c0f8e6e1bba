//! What the leaves of a hierarchy hold on the GPU: their triangles' corners, or where those lie.

use scenes::Scene;

use crate::device::{DeviceArray, Gpu, GpuError, Module};
use crate::stages::vector::padded;

/// Four words of a leaf.
type Words = [u32; 4];

/// Where the corners of a leaf's triangle are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafForm {
    /// In the leaf itself, 48 bytes: one fetch that waits for nothing, in place of four of which three wait.
    Gathered,
    /// In the scene's positions, by the three indices that the leaf holds; 16 bytes.
    Indexed,
}

const GATHERED: &str = "
fn leaf_at(slot: u32) -> Leaf {
    let a = leaves[3u * slot];
    let b = leaves[3u * slot + 1u].xyz;
    let c = leaves[3u * slot + 2u].xyz;
    return Leaf(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b), bitcast<vec3<f32>>(c), a.w);
}
";
const INDEXED: &str = "
fn leaf_at(slot: u32) -> Leaf {
    let leaf = leaves[slot];
    return Leaf(positions[leaf.x].xyz, positions[leaf.y].xyz, positions[leaf.z].xyz, leaf.w);
}
";
const LEAF: &str = "
struct Leaf {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    triangle: u32,
}
";

impl LeafForm {
    /// The faster one that fits into a binding of `limit_bytes`.
    fn that_fits(slots: usize, limit_bytes: u64) -> Self {
        let gathered_bytes = (slots * Self::Gathered.words_each() * size_of::<Words>()) as u64;
        if gathered_bytes <= limit_bytes { Self::Gathered } else { Self::Indexed }
    }

    /// How many times four words a leaf has.
    const fn words_each(self) -> usize {
        match self {
            Self::Gathered => 3,
            Self::Indexed => 1,
        }
    }

    /// Declares the arrays and `fn leaf_at(slot: u32) -> Leaf`.
    pub(super) fn declare(self, module: Module) -> Module {
        let module = module.table::<Words>("leaves").text(LEAF);
        match self {
            Self::Gathered => module.text(GATHERED),
            Self::Indexed => module.table::<[f32; 4]>("positions").text(INDEXED),
        }
    }
}

/// Leaves on the GPU.
pub(super) struct Leaves {
    /// Corner and triangle index, corner, corner; or the indices of corners and triangle.
    words: DeviceArray<Words>,
    /// What indices of corners count.
    positions: Option<DeviceArray<[f32; 4]>>,
}

impl Leaves {
    /// A leaf for each of `triangles`; corners in it if that fits into a binding of `limit_bytes`.
    ///
    /// # Errors
    /// If they are too many for the adapter.
    pub(super) fn new(
        gpu: &Gpu,
        scene: &Scene,
        triangles: &[u32],
        limit_bytes: u64,
    ) -> Result<Self, GpuError> {
        let form = LeafForm::that_fits(triangles.len(), limit_bytes);
        let mut words: Vec<Words> = Vec::with_capacity(triangles.len() * form.words_each());
        for &triangle in triangles {
            match form {
                LeafForm::Gathered => {
                    let corners = scene.corners(triangle as usize);
                    words.extend([(0, triangle), (1, 0), (2, 0)].map(|(corner, last): (usize, u32)| {
                        let [x, y, z] = corners[corner].map(f32::to_bits);
                        [x, y, z, last]
                    }));
                }
                LeafForm::Indexed => {
                    let [a, b, c] = scene.triangles[triangle as usize];
                    words.push([a, b, c, triangle]);
                }
            }
        }
        let words = gpu.array_of("trace::leaves", &words)?;
        let positions = (form == LeafForm::Indexed).then(|| position_array(gpu, scene)).transpose()?;
        Ok(Self { words, positions })
    }

    /// Where the corners are.
    pub(super) fn form(&self) -> LeafForm {
        if self.positions.is_some() { LeafForm::Indexed } else { LeafForm::Gathered }
    }

    /// In the order in which [`LeafForm::declare`] declares them.
    pub(super) fn bindings(&self) -> impl Iterator<Item = wgpu::BindingResource<'_>> {
        [self.words.binding()].into_iter().chain(self.positions.as_ref().map(DeviceArray::binding))
    }
}

/// The scene's vertices.
///
/// # Errors
/// If they are too many for the adapter.
pub(super) fn position_array(gpu: &Gpu, scene: &Scene) -> Result<DeviceArray<[f32; 4]>, GpuError> {
    gpu.array_of("trace::positions", &padded(&scene.positions))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_gpu;

    #[test]
    fn corners_are_in_the_leaves_as_long_as_a_binding_has_room() {
        let scene = scenes::load("builtin:cornell").unwrap();
        let triangles: Vec<u32> = (0..scene.triangles.len() as u32).collect();
        let needed = 48 * triangles.len() as u64;
        for (limit, expected) in [(needed, LeafForm::Gathered), (needed - 1, LeafForm::Indexed)] {
            let leaves = Leaves::new(test_gpu(), &scene, &triangles, limit).unwrap();
            assert_eq!(leaves.form(), expected, "{limit} bytes for {} triangles", triangles.len());
        }
    }
}
