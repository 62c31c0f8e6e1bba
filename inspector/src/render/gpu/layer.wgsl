// What every layer is drawn with, as in LayerUniform, and the colour of a value.
struct Layer {
    clip_from_unit: mat4x4<f32>,
    eye: vec4<f32>,
    plain: vec4<f32>,
    cut: vec4<f32>,
    room: vec4<f32>,
    faded: vec4<f32>,
    viewport: vec2<f32>,
    width: f32,
    opacity: f32,
    low: f32,
    high: f32,
    map: u32,
    points_each: u32,
}

@group(0) @binding(0) var<uniform> layer: Layer;
@group(0) @binding(1) var colour_maps: texture_2d<f32>;

fn colour_of(value: f32) -> vec3<f32> {
    if layer.plain.a > 0.0 {
        return layer.plain.rgb;
    }
    // Values that are not known are grey. Bits are looked at, since a compiler may assume that no NaN comes.
    if (bitcast<u32>(value) & 0x7fffffffu) > 0x7f800000u {
        return vec3<f32>(0.5);
    }
    let span = layer.high - layer.low;
    let part = select(0.5, (value - layer.low) / span, span > 0.0);
    let last = i32(textureDimensions(colour_maps).x) - 1;
    let column = clamp(i32(round(part * f32(last))), 0, last);
    return textureLoad(colour_maps, vec2<i32>(column, i32(layer.map)), 0).rgb;
}

// Whether a point is beyond the clipping plane.
fn is_cut_away(p: vec3<f32>) -> bool {
    return dot(layer.cut.xyz, p) > layer.cut.w;
}

// Colours are mixed with their alpha already in them.
fn shown(colour: vec3<f32>, alpha: f32) -> vec4<f32> {
    return vec4<f32>(colour * alpha, alpha);
}
