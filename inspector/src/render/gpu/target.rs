//! The picture of one view, with depth and several samples to a pixel.

use wgpu::{Device, TextureUsages};

use super::pipelines::{DEPTH_FORMAT, PICTURE_FORMAT, Pipelines, SAMPLES};
use crate::theme::ShaderColour;

pub(super) struct Target {
    pub(super) pixels: [u32; 2],
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    resolved: wgpu::TextureView,
    /// Of the pipeline that copies it.
    pub(super) picture: wgpu::BindGroup,
}

impl Target {
    pub(super) fn new(device: &Device, pipelines: &Pipelines, pixels: [u32; 2]) -> Self {
        let view = |label, format, sample_count, usage| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: pixels[0], height: pixels[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let resolved = view("view::resolved", PICTURE_FORMAT, 1, drawn | TextureUsages::TEXTURE_BINDING);
        Self {
            pixels,
            samples: view("view::samples", PICTURE_FORMAT, SAMPLES, drawn),
            depth: view("view::depth", DEPTH_FORMAT, SAMPLES, drawn),
            picture: pipelines.picture_bindings(device, &resolved),
            resolved,
        }
    }

    /// Starts to draw on the background.
    pub(super) fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        background: ShaderColour,
    ) -> wgpu::RenderPass<'a> {
        let [r, g, b, a] = background.map(f64::from);
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("view"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.samples,
                depth_slice: None,
                resolve_target: Some(&self.resolved),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}
