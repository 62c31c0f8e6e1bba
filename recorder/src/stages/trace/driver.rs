//! The driver's own hierarchy over a scene, for ray queries.

use anyhow::{Result, bail};
use scenes::Scene;

use super::leaves::position_array;
use crate::device::{DeviceArray, Gpu};

/// A hierarchy of one instance of all triangles, in scene order, built by the driver. Without masks, triangles are
/// opaque and traversal needs no help.
///
/// # Errors
/// If there are more triangles than the driver takes, or it refuses them.
pub(super) fn hierarchy(gpu: &Gpu, scene: &Scene, is_opaque: bool) -> Result<wgpu::Tlas> {
    let limit = gpu.device().limits().max_blas_primitive_count;
    if scene.triangles.len() as u64 > u64::from(limit) {
        bail!(
            "{} triangles are more than {} takes for ray queries ({limit}); use --trace cwbvh",
            scene.triangles.len(),
            gpu.adapter().title()
        );
    }
    let positions = position_array(gpu, scene)?;
    let indices: DeviceArray<u32> = gpu.array_of("trace::indices", bytemuck::cast_slice(&scene.triangles))?;
    let size = wgpu::BlasTriangleGeometrySizeDescriptor {
        vertex_format: wgpu::VertexFormat::Float32x3,
        vertex_count: scene.positions.len() as u32,
        index_format: Some(wgpu::IndexFormat::Uint32),
        index_count: Some(indices.len() as u32),
        flags: if is_opaque {
            wgpu::AccelerationStructureGeometryFlags::OPAQUE
        } else {
            wgpu::AccelerationStructureGeometryFlags::empty()
        },
    };
    let bottom = gpu.device().create_blas(
        &wgpu::CreateBlasDescriptor {
            label: Some("trace::bottom_level"),
            flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
            update_mode: wgpu::AccelerationStructureUpdateMode::Build,
        },
        wgpu::BlasGeometrySizeDescriptors::Triangles { descriptors: vec![size.clone()] },
    );
    let mut top = gpu.device().create_tlas(&wgpu::CreateTlasDescriptor {
        label: Some("trace::top_level"),
        max_instances: 1,
        flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
        update_mode: wgpu::AccelerationStructureUpdateMode::Build,
    });
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    top[0] = Some(wgpu::TlasInstance::new(&bottom, identity, 0, 0xff));
    let geometry = wgpu::BlasTriangleGeometry {
        size: &size,
        vertex_buffer: positions.buffer(),
        first_vertex: 0,
        vertex_stride: 16,
        index_buffer: Some(indices.buffer()),
        first_index: Some(0),
        transform_buffer: None,
        transform_buffer_offset: None,
    };
    let entry = wgpu::BlasBuildEntry {
        blas: &bottom,
        geometry: wgpu::BlasGeometries::TriangleGeometries(vec![geometry]),
    };
    let mut encoder =
        gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("trace::build") });
    encoder.build_acceleration_structures([&entry], [&top]);
    let building = "building the driver's hierarchy";
    gpu.check(building)?;
    let sent = gpu.submit(building, encoder.finish())?;
    gpu.wait(building, Some(sent))?;
    Ok(top)
}
