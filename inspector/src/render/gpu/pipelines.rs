//! One pipeline for each way of drawing.

use std::collections::BTreeMap;

use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    BindingType, CompareFunction, Device, ShaderStages, TextureFormat, VertexStepMode, vertex_attr_array,
};

use super::super::picture::LayerUniform;
use super::shaders::Module;
use crate::colour_map::{ColourMap, STEPS};

/// Of pictures: sRGB as it is, without conversion.
pub(super) const PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Samples to a pixel: what every adapter has.
pub(super) const SAMPLES: u32 = 4;

/// A way of drawing: each has a pipeline, made when something is first drawn so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Drawing {
    Solid,
    Ghost,
    Lines(Lines, Seen),
    Boxes,
    Capsules,
}

/// What is drawn for each pair of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lines {
    /// A line.
    Plain,
    /// A line that is cut with the surfaces.
    Edges,
    /// A head at the second.
    Arrows,
    /// A mark at the second.
    Marks,
}

/// What surfaces do to lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Seen {
    /// Only what they do not hide is drawn.
    InFront,
    /// Only what they hide.
    Behind,
    /// All.
    OnTop,
}

/// The pipelines that were used so far, and what they share.
pub(super) struct Pipelines {
    made: BTreeMap<Drawing, wgpu::RenderPipeline>,
    modules: BTreeMap<Module, wgpu::ShaderModule>,
    pub(super) copy: wgpu::RenderPipeline,
    layer_layout: wgpu::BindGroupLayout,
    points_layout: wgpu::BindGroupLayout,
    colour_maps: wgpu::TextureView,
}

/// How a pipeline differs from the others.
struct PipelineParts {
    module: Module,
    /// Of the vertices, and of the pixels.
    entries: [&'static str; 2],
    /// Where vertices come from; where there are none, the shader reads two points by their number.
    buffers: &'static [Option<wgpu::VertexBufferLayout<'static>>],
    /// What is drawn, and whether it hides what is behind it; all in one sample to a pixel if `None`.
    depth: Option<(CompareFunction, bool)>,
}

impl Pipelines {
    pub(super) fn new(device: &Device, queue: &wgpu::Queue, window: wgpu::TextureFormat) -> Self {
        let entry = if window.is_srgb() { "copy_to_linear" } else { "copy_to_gamma" };
        let copy = PipelineParts {
            module: Module::Copy,
            entries: ["copy_vertex", entry],
            buffers: &[],
            depth: None,
        };
        let shader = module(device, copy.module);
        Self {
            made: BTreeMap::new(),
            modules: BTreeMap::new(),
            copy: pipeline(device, "copy", None, &shader, &copy, window.into()),
            colour_maps: colour_maps(device, queue),
            points_layout: points_layout(device),
            layer_layout: layer_layout(device),
        }
    }

    /// Makes what draws in this way, unless it was made before.
    pub(super) fn make(&mut self, device: &Device, drawing: Drawing) {
        let Self { made, modules, layer_layout, points_layout, .. } = self;
        made.entry(drawing).or_insert_with(|| {
            let parts = parts(drawing);
            let shader = modules.entry(parts.module).or_insert_with(|| module(device, parts.module));
            let points = Some(&*points_layout).filter(|_| parts.buffers.is_empty());
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&*layer_layout), points],
                immediate_size: 0,
            });
            let target = wgpu::ColorTargetState {
                format: PICTURE_FORMAT,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            };
            pipeline(device, &format!("view::{drawing:?}"), Some(&layout), shader, &parts, target)
        });
    }

    /// What draws in this way, once it was made.
    pub(super) fn get(&self, drawing: Drawing) -> Option<&wgpu::RenderPipeline> {
        self.made.get(&drawing)
    }

    /// A buffer of uniforms and the colour maps, for all pipelines but the last.
    pub(super) fn layer_bindings(&self, device: &Device, uniforms: &wgpu::Buffer) -> wgpu::BindGroup {
        let buffer = wgpu::BufferBinding {
            buffer: uniforms,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<LayerUniform>() as u64),
        };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("view::layers"),
            layout: &self.layer_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(buffer) },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&self.colour_maps),
                },
            ],
        })
    }

    /// A part of a buffer of points.
    pub(super) fn points_bindings(
        &self,
        device: &Device,
        points: wgpu::BufferBinding<'_>,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("lines::points"),
            layout: &self.points_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(points) }],
        })
    }

    /// A picture, for the last pipeline.
    pub(super) fn picture_bindings(&self, device: &Device, picture: &wgpu::TextureView) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("copy::picture"),
            layout: &self.copy.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(picture),
            }],
        })
    }
}

/// How the pipeline of a way of drawing differs from the others.
fn parts(drawing: Drawing) -> PipelineParts {
    let (module, entries) = match drawing {
        Drawing::Solid | Drawing::Ghost => (Module::Mesh, ["mesh_vertex", "mesh_fragment"]),
        Drawing::Lines(Lines::Plain, _) => (Module::Lines, ["line_vertex", "line_fragment"]),
        Drawing::Lines(Lines::Edges, _) => (Module::Lines, ["edge_vertex", "edge_fragment"]),
        Drawing::Lines(Lines::Arrows, _) => (Module::Arrows, ["arrow_vertex", "arrow_fragment"]),
        Drawing::Lines(Lines::Marks, _) => (Module::Marks, ["mark_vertex", "mark_fragment"]),
        Drawing::Boxes => (Module::Boxes, ["box_vertex", "box_fragment"]),
        Drawing::Capsules => (Module::Capsules, ["capsule_vertex", "capsule_fragment"]),
    };
    let buffers: &[_] = match drawing {
        Drawing::Solid | Drawing::Ghost => &CORNERS,
        Drawing::Lines(..) | Drawing::Boxes => &[],
        Drawing::Capsules => &CAPSULES,
    };
    let depth = match drawing {
        Drawing::Solid => (CompareFunction::Less, true),
        Drawing::Ghost | Drawing::Capsules => (CompareFunction::Less, false),
        Drawing::Boxes => (CompareFunction::LessEqual, false),
        Drawing::Lines(_, Seen::InFront) => (CompareFunction::LessEqual, true),
        Drawing::Lines(_, Seen::Behind) => (CompareFunction::Greater, false),
        Drawing::Lines(_, Seen::OnTop) => (CompareFunction::Always, false),
    };
    PipelineParts { module, entries, buffers, depth: Some(depth) }
}

/// Corners of triangles, and their colours.
static CORNERS: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    of_each(VertexStepMode::Vertex, 12, &vertex_attr_array![0 => Float32x3]),
    of_each(VertexStepMode::Vertex, 4, &vertex_attr_array![1 => Unorm8x4]),
];

/// Corners that all capsules share, and each capsule.
static CAPSULES: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    of_each(VertexStepMode::Vertex, 16, &vertex_attr_array![0 => Float32x4]),
    of_each(VertexStepMode::Instance, 48, &vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32]),
];

/// Bytes of a point: where it is, and its number.
pub(super) const POINT_BYTES: u64 = 16;

const fn of_each(
    step_mode: VertexStepMode,
    array_stride: u64,
    attributes: &'static [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'static>> {
    Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
}

/// A pipeline with this layout, or else with that of its shader.
fn pipeline(
    device: &Device,
    label: &str,
    layout: Option<&wgpu::PipelineLayout>,
    shader: &wgpu::ShaderModule,
    &PipelineParts { entries: [vertex, fragment], buffers, depth, .. }: &PipelineParts,
    target: wgpu::ColorTargetState,
) -> wgpu::RenderPipeline {
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout,
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(vertex),
            compilation_options: compilation_options.clone(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: depth.map(|(depth_compare, depth_write)| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(depth_write),
            depth_compare: Some(depth_compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: depth.map_or(1, |_| SAMPLES),
            ..wgpu::MultisampleState::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(fragment),
            compilation_options,
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn module(device: &Device, module: Module) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(&format!("{module:?}")),
        source: wgpu::ShaderSource::Wgsl(module.text().into()),
    })
}

fn layer_layout(device: &Device) -> wgpu::BindGroupLayout {
    let uniform = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty: BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: wgpu::BufferSize::new(size_of::<LayerUniform>() as u64),
        },
        count: None,
    };
    let colour_maps = wgpu::BindGroupLayoutEntry {
        binding: 1,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty: BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("view::layers"),
        entries: &[uniform, colour_maps],
    })
}

fn points_layout(device: &Device) -> wgpu::BindGroupLayout {
    let points = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: ShaderStages::VERTEX,
        ty: BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: wgpu::BufferSize::new(POINT_BYTES),
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("lines::points"),
        entries: &[points],
    })
}

/// All colour maps, one in each row.
fn colour_maps(device: &Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let colours = ColourMap::ALL.iter().flat_map(|map| map.colours());
    let texels: Vec<u8> = colours.flat_map(|&[red, green, blue]| [red, green, blue, 255]).collect();
    let descriptor = wgpu::TextureDescriptor {
        label: Some("view::colour_maps"),
        size: wgpu::Extent3d {
            width: STEPS as u32,
            height: ColourMap::ALL.len() as u32,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let texture = device.create_texture_with_data(queue, &descriptor, TextureDataOrder::LayerMajor, &texels);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
