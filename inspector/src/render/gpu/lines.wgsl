// Lines as quads of so many pixels, one per instance, from a to b.
struct LinePoint {
    @builtin(position) position: vec4<f32>,
    @location(0) value: f32,
}

// Nothing nearer than this is projected.
const NEAREST: f32 = 0.0008;

fn cut_at_eye(inside: vec4<f32>, other: vec4<f32>) -> vec4<f32> {
    if other.w >= NEAREST {
        return other;
    }
    return mix(inside, other, (inside.w - NEAREST) / (inside.w - other.w));
}

@vertex
fn line_vertex(@builtin(vertex_index) corner: u32, @location(0) a: vec4<f32>, @location(1) b: vec4<f32>) -> LinePoint {
    // A little nearer to the eye, so that lines on a surface are seen.
    let nearer = 0.003;
    var from_clip = layer.clip_from_unit * vec4<f32>(mix(a.xyz, layer.eye.xyz, nearer), 1.0);
    var to_clip = layer.clip_from_unit * vec4<f32>(mix(b.xyz, layer.eye.xyz, nearer), 1.0);
    var point: LinePoint;
    let is_end = (corner & 1u) == 1u;
    point.value = select(a.w, b.w, is_end);
    if from_clip.w < NEAREST && to_clip.w < NEAREST {
        point.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return point;
    }
    let from_cut = cut_at_eye(to_clip, from_clip);
    let to_cut = cut_at_eye(from_clip, to_clip);
    let half_view = 0.5 * layer.viewport;
    let along_pixels = (to_cut.xy / to_cut.w - from_cut.xy / from_cut.w) * half_view;
    let length_pixels = length(along_pixels);
    let along = select(vec2<f32>(1.0, 0.0), along_pixels / max(length_pixels, 1e-6), length_pixels > 1e-3);
    let across = vec2<f32>(-along.y, along.x);
    let here = select(from_cut, to_cut, is_end);
    let side = select(-1.0, 1.0, (corner & 2u) == 2u);
    let out = select(-1.0, 1.0, is_end);
    let offset = 0.5 * layer.width * (side * across + out * along) / half_view;
    point.position = vec4<f32>(here.xy + offset * here.w, here.zw);
    return point;
}

@fragment
fn line_fragment(point: LinePoint) -> @location(0) vec4<f32> {
    return shown(colour_of(point.value), layer.opacity);
}
