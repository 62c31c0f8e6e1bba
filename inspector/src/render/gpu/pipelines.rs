//! One pipeline for each way of drawing.

use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{BindingType, CompareFunction, Device, ShaderStages, VertexStepMode, vertex_attr_array};

use super::super::colour_map::{ColourMap, STEPS};
use super::super::frame::LayerUniform;
use super::shaders;
use super::target::{DEPTH_FORMAT, PICTURE_FORMAT, SAMPLES};

/// All pipelines, and what they share.
pub(super) struct Pipelines {
    pub(super) solid: wgpu::RenderPipeline,
    pub(super) ghost: wgpu::RenderPipeline,
    pub(super) strips: LinePipelines,
    pub(super) segments: LinePipelines,
    pub(super) arrows: LinePipelines,
    pub(super) marks: LinePipelines,
    pub(super) boxes: wgpu::RenderPipeline,
    pub(super) capsules: wgpu::RenderPipeline,
    pub(super) copy: wgpu::RenderPipeline,
    layer_layout: wgpu::BindGroupLayout,
    picture_layout: wgpu::BindGroupLayout,
    colour_maps: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

/// Lines by what surfaces do to them.
pub(super) struct LinePipelines {
    pub(super) seen: wgpu::RenderPipeline,
    pub(super) hidden: wgpu::RenderPipeline,
    pub(super) on_top: wgpu::RenderPipeline,
}

/// How a pipeline differs from the others.
struct Kind<'a> {
    label: &'a str,
    shader: &'a wgpu::ShaderModule,
    entries: [&'a str; 2],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    topology: wgpu::PrimitiveTopology,
    depth: (CompareFunction, bool),
    cull: Option<wgpu::Face>,
}

impl Pipelines {
    pub(super) fn new(device: &Device, queue: &wgpu::Queue, window: wgpu::TextureFormat) -> Self {
        let layer_layout = layer_layout(device);
        let picture_layout = picture_layout(device);
        let layout = pipeline_layout(device, &layer_layout);
        let [mesh, lines, arrows, marks, boxes, capsules] = [
            ("mesh", shaders::mesh()),
            ("lines", shaders::lines()),
            ("arrows", shaders::arrows()),
            ("marks", shaders::marks()),
            ("boxes", shaders::boxes()),
            ("capsules", shaders::capsules()),
        ]
        .map(|(label, text)| module(device, label, text));
        let of_lines =
            |shader, entries, stride| LinePipelines::new(device, &layout, (shader, entries), stride);
        let corners = [Some(wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Float32x3],
        })];
        let surface = |label, depth| {
            let kind = Kind {
                label,
                shader: &mesh,
                entries: ["mesh_vertex", "mesh_fragment"],
                buffers: &corners,
                topology: wgpu::PrimitiveTopology::TriangleList,
                depth,
                cull: None,
            };
            pipeline(device, &layout, &kind)
        };
        Self {
            solid: surface("mesh::solid", (CompareFunction::Less, true)),
            ghost: surface("mesh::ghost", (CompareFunction::Less, false)),
            strips: of_lines(&lines, ["line_vertex", "line_fragment"], 16),
            segments: of_lines(&lines, ["line_vertex", "line_fragment"], 32),
            arrows: of_lines(&arrows, ["arrow_vertex", "arrow_fragment"], 32),
            marks: of_lines(&marks, ["mark_vertex", "mark_fragment"], 32),
            boxes: box_pipeline(device, &layout, &boxes),
            capsules: capsule_pipeline(device, &layout, &capsules),
            copy: copy_pipeline(device, &picture_layout, window),
            colour_maps: colour_maps(device, queue),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("copy::sampler"),
                ..wgpu::SamplerDescriptor::default()
            }),
            layer_layout,
            picture_layout,
        }
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

impl LinePipelines {
    /// For points of 16 bytes, `stride` bytes from one line's first point to the next line's.
    fn new(
        device: &Device,
        layout: &wgpu::PipelineLayout,
        (shader, entries): (&wgpu::ShaderModule, [&str; 2]),
        stride: u64,
    ) -> Self {
        let buffers = two_points(stride);
        let of = |label, depth| {
            let kind = Kind {
                label,
                shader,
                entries,
                buffers: &buffers,
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                depth,
                cull: None,
            };
            pipeline(device, layout, &kind)
        };
        Self {
            seen: of("lines::seen", (CompareFunction::LessEqual, true)),
            hidden: of("lines::hidden", (CompareFunction::Greater, false)),
            on_top: of("lines::on_top", (CompareFunction::Always, false)),
        }
    }
}

/// The first and the second point of a line, or of a box, one after the other for each instance.
fn two_points(stride: u64) -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
    const FROM: [wgpu::VertexAttribute; 1] = vertex_attr_array![0 => Float32x4];
    const TO: [wgpu::VertexAttribute; 1] = vertex_attr_array![1 => Float32x4];
    [&FROM, &TO].map(|attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: stride,
            step_mode: VertexStepMode::Instance,
            attributes,
        })
    })
}

fn box_pipeline(
    device: &Device,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
) -> wgpu::RenderPipeline {
    let kind = Kind {
        label: "boxes",
        shader,
        entries: ["box_vertex", "box_fragment"],
        buffers: &two_points(32),
        topology: wgpu::PrimitiveTopology::TriangleList,
        depth: (CompareFunction::LessEqual, false),
        cull: None,
    };
    pipeline(device, layout, &kind)
}

fn capsule_pipeline(
    device: &Device,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
) -> wgpu::RenderPipeline {
    let corners = wgpu::VertexBufferLayout {
        array_stride: 16,
        step_mode: VertexStepMode::Vertex,
        attributes: &vertex_attr_array![0 => Float32x4],
    };
    let capsules = wgpu::VertexBufferLayout {
        array_stride: 48,
        step_mode: VertexStepMode::Instance,
        attributes: &vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32],
    };
    let kind = Kind {
        label: "capsules",
        shader,
        entries: ["capsule_vertex", "capsule_fragment"],
        buffers: &[Some(corners), Some(capsules)],
        topology: wgpu::PrimitiveTopology::TriangleList,
        depth: (CompareFunction::Less, false),
        cull: None,
    };
    pipeline(device, layout, &kind)
}

fn pipeline(device: &Device, layout: &wgpu::PipelineLayout, kind: &Kind<'_>) -> wgpu::RenderPipeline {
    let (depth_compare, depth_write) = kind.depth;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(kind.label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: kind.shader,
            entry_point: Some(kind.entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: kind.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: kind.topology,
            cull_mode: kind.cull,
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(depth_write),
            depth_compare: Some(depth_compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: kind.shader,
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
        layout: Some(&pipeline_layout(device, picture_layout)),
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

fn pipeline_layout(device: &Device, bindings: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(bindings)],
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
    let colour = |map: ColourMap, at: usize| {
        let [red, green, blue] = map.colour(at as f32 / (STEPS - 1) as f32);
        [red, green, blue, 255]
    };
    let texels: Vec<u8> =
        ColourMap::ALL.iter().flat_map(|&map| (0..STEPS).flat_map(move |at| colour(map, at))).collect();
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
