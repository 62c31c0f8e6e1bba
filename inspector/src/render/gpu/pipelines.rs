//! One pipeline for each way of drawing.

use std::collections::BTreeMap;

use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    BindingType, CompareFunction, Device, ShaderStages, TextureFormat, VertexStepMode, vertex_attr_array,
};

use super::super::frame::LayerUniform;
use super::shaders;
use crate::colour_map::{ColourMap, STEPS};

/// Of pictures: sRGB as it is, without conversion.
pub(super) const PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Samples to a pixel: what every adapter has.
pub(super) const SAMPLES: u32 = 4;

/// A way of drawing: each has a pipeline, made when something is first drawn so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Way {
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
    made: BTreeMap<Way, wgpu::RenderPipeline>,
    modules: BTreeMap<&'static str, wgpu::ShaderModule>,
    pub(super) copy: wgpu::RenderPipeline,
    layer_layout: wgpu::BindGroupLayout,
    points_layout: wgpu::BindGroupLayout,
    picture_layout: wgpu::BindGroupLayout,
    colour_maps: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

/// How a pipeline differs from the others.
struct Kind {
    /// Name of its module, which others may share.
    module: &'static str,
    shader: fn() -> String,
    entries: [&'static str; 2],
    vertices: Vertices,
    depth: (CompareFunction, bool),
}

/// Where a pipeline's vertices come from.
enum Vertices {
    /// Vertex buffers.
    Buffers(&'static [Option<wgpu::VertexBufferLayout<'static>>]),
    /// The shader, which reads two points by their number.
    Points,
}

impl Pipelines {
    pub(super) fn new(device: &Device, queue: &wgpu::Queue, window: wgpu::TextureFormat) -> Self {
        let layer_layout = layer_layout(device);
        let picture_layout = picture_layout(device);
        Self {
            made: BTreeMap::new(),
            modules: BTreeMap::new(),
            copy: copy_pipeline(device, &picture_layout, window),
            colour_maps: colour_maps(device, queue),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("copy::sampler"),
                ..wgpu::SamplerDescriptor::default()
            }),
            points_layout: points_layout(device),
            layer_layout,
            picture_layout,
        }
    }

    /// Makes what draws in this way, unless it was made before.
    pub(super) fn make(&mut self, device: &Device, way: Way) {
        let Self { made, modules, layer_layout, points_layout, .. } = self;
        made.entry(way).or_insert_with(|| {
            let kind = kind(way);
            let shader = modules.entry(kind.module);
            let shader = shader.or_insert_with(|| module(device, kind.module, (kind.shader)()));
            let layout = match kind.vertices {
                Vertices::Buffers(_) => pipeline_layout(device, &[layer_layout]),
                Vertices::Points => pipeline_layout(device, &[layer_layout, points_layout]),
            };
            pipeline(device, &layout, shader, (way, &kind))
        });
    }

    /// What draws in this way, once it was made.
    pub(super) fn get(&self, way: Way) -> Option<&wgpu::RenderPipeline> {
        self.made.get(&way)
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
            layout: &self.picture_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(picture) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        })
    }
}

/// How the pipeline of a way differs from the others.
fn kind(way: Way) -> Kind {
    match way {
        Way::Solid | Way::Ghost => Kind {
            module: "mesh",
            shader: shaders::mesh,
            entries: ["mesh_vertex", "mesh_fragment"],
            vertices: Vertices::Buffers(&CORNERS),
            depth: (CompareFunction::Less, way == Way::Solid),
        },
        Way::Lines(lines, seen) => {
            let (module, shader, entries): (_, fn() -> String, _) = match lines {
                Lines::Plain => ("lines", shaders::lines, ["line_vertex", "line_fragment"]),
                Lines::Edges => ("lines", shaders::lines, ["edge_vertex", "edge_fragment"]),
                Lines::Arrows => ("arrows", shaders::arrows, ["arrow_vertex", "arrow_fragment"]),
                Lines::Marks => ("marks", shaders::marks, ["mark_vertex", "mark_fragment"]),
            };
            Kind {
                module,
                shader,
                entries,
                vertices: Vertices::Points,
                depth: match seen {
                    Seen::InFront => (CompareFunction::LessEqual, true),
                    Seen::Behind => (CompareFunction::Greater, false),
                    Seen::OnTop => (CompareFunction::Always, false),
                },
            }
        }
        Way::Boxes => Kind {
            module: "boxes",
            shader: shaders::boxes,
            entries: ["box_vertex", "box_fragment"],
            vertices: Vertices::Points,
            depth: (CompareFunction::LessEqual, false),
        },
        Way::Capsules => Kind {
            module: "capsules",
            shader: shaders::capsules,
            entries: ["capsule_vertex", "capsule_fragment"],
            vertices: Vertices::Buffers(&CAPSULES),
            depth: (CompareFunction::Less, false),
        },
    }
}

/// Corners of triangles.
static CORNERS: [Option<wgpu::VertexBufferLayout<'static>>; 1] =
    [of_each(VertexStepMode::Vertex, 12, &vertex_attr_array![0 => Float32x3])];

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

fn pipeline(
    device: &Device,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    (way, kind): (Way, &Kind),
) -> wgpu::RenderPipeline {
    let (depth_compare, depth_write) = kind.depth;
    let buffers = match kind.vertices {
        Vertices::Buffers(buffers) => buffers,
        Vertices::Points => &[],
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(&format!("view::{way:?}")),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(kind.entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(depth_write),
            depth_compare: Some(depth_compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(kind.entries[1]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: PICTURE_FORMAT,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn copy_pipeline(
    device: &Device,
    picture_layout: &wgpu::BindGroupLayout,
    window: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let shader = module(device, "copy", shaders::copy());
    let entry = if window.is_srgb() { "copy_to_linear" } else { "copy_to_gamma" };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("copy"),
        layout: Some(&pipeline_layout(device, &[picture_layout])),
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("copy_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(window.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn module(device: &Device, label: &str, text: String) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    })
}

fn pipeline_layout(device: &Device, bindings: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &bindings.iter().map(|&layout| Some(layout)).collect::<Vec<_>>(),
        immediate_size: 0,
    })
}

fn texture_entry(binding: u32, visibility: ShaderStages, filterable: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
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
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("view::layers"),
        entries: &[uniform, texture_entry(1, ShaderStages::VERTEX_FRAGMENT, false)],
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

fn picture_layout(device: &Device) -> wgpu::BindGroupLayout {
    let sampler = wgpu::BindGroupLayoutEntry {
        binding: 1,
        visibility: ShaderStages::FRAGMENT,
        ty: BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("copy::picture"),
        entries: &[texture_entry(0, ShaderStages::FRAGMENT, true), sampler],
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
