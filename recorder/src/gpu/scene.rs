//! A scene's arrays on the GPU, as shading reads them.

use scenes::features::Features;

use super::{DeviceArray, Gpu, GpuError};
use crate::stages::shade::tables::ShadeTables;
use crate::stages::shared::{Emitter, MaterialData, TextureData};

/// Uploaded once per run.
pub struct SceneArrays {
    pub(super) triangles: DeviceArray<[u32; 4]>,
    pub(super) positions: DeviceArray<[f32; 4]>,
    pub(super) materials: DeviceArray<MaterialData>,
    pub(super) emitters: DeviceArray<Emitter>,
    pub(super) normals: Option<DeviceArray<[f32; 4]>>,
    pub(super) textures: Option<TextureArrays>,
}

pub(super) struct TextureArrays {
    pub(super) uvs: DeviceArray<[f32; 2]>,
    pub(super) textures: DeviceArray<TextureData>,
    pub(super) texels: DeviceArray<u32>,
}

/// Vectors of three as kernels read them.
pub(crate) fn padded(vectors: &[[f32; 3]]) -> Vec<[f32; 4]> {
    vectors.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect()
}

impl SceneArrays {
    /// Uploads what kernels for these features read.
    ///
    /// # Errors
    /// If an array is too large for the adapter.
    pub fn new(gpu: &Gpu, tables: &ShadeTables, features: &Features) -> Result<Self, GpuError> {
        let textures = if !features.textures {
            None
        } else {
            Some(TextureArrays {
                uvs: gpu.array_of("scene::uvs", &tables.uvs)?,
                textures: gpu.array_of("scene::textures", &tables.textures)?,
                texels: gpu.array_of("scene::texels", &tables.texels)?,
            })
        };
        let normals =
            features.vertex_normals.then(|| gpu.array_of("scene::normals", &padded(&tables.normals)));
        Ok(Self {
            triangles: gpu.array_of("scene::triangles", &tables.triangles)?,
            positions: gpu.array_of("scene::positions", &padded(&tables.positions))?,
            materials: gpu.array_of("scene::materials", &tables.materials)?,
            emitters: gpu.array_of("scene::emitters", &tables.emitters)?,
            normals: normals.transpose()?,
            textures,
        })
    }
}
