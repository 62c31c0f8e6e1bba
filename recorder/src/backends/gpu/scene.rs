//! A scene's arrays on the GPU, as shading reads them.

use scenes::features::Features;

use crate::device::{DeviceArray, Gpu, GpuError};
use crate::stages::shade::tables::ShadeTables;
use crate::stages::shared::Emitter;
use crate::stages::vector::padded;

/// Uploaded once per run.
pub struct SceneArrays {
    pub(super) triangles: DeviceArray<[u32; 4]>,
    pub(super) positions: DeviceArray<[f32; 4]>,
    /// Texels where the scene has textures, then materials, in words.
    pub(super) tables: DeviceArray<u32>,
    pub(super) emitters: DeviceArray<Emitter>,
    pub(super) normals: Option<DeviceArray<[f32; 4]>>,
    pub(super) uvs: Option<DeviceArray<[f32; 2]>>,
}

impl SceneArrays {
    /// Uploads what kernels for these features read.
    ///
    /// # Errors
    /// If an array is too large for the adapter.
    pub fn new(gpu: &Gpu, tables: &ShadeTables, features: &Features) -> Result<Self, GpuError> {
        let texels = if features.textures { tables.texels.as_slice() } else { &[] };
        let words = [texels, bytemuck::cast_slice(&tables.materials)].concat();
        let uvs = features.textures.then(|| gpu.array_of("scene::uvs", &tables.uvs));
        let normals =
            features.vertex_normals.then(|| gpu.array_of("scene::normals", &padded(&tables.normals)));
        Ok(Self {
            triangles: gpu.array_of("scene::triangles", &tables.triangles)?,
            positions: gpu.array_of("scene::positions", &padded(&tables.positions))?,
            tables: gpu.array_of("scene::tables", &words)?,
            emitters: gpu.array_of("scene::emitters", &tables.emitters)?,
            normals: normals.transpose()?,
            uvs: uvs.transpose()?,
        })
    }
}
