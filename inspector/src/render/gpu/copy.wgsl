// A finished picture, into the window.
@group(0) @binding(0) var picture: texture_2d<f32>;

struct CopyPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn copy_vertex(@builtin(vertex_index) corner: u32) -> CopyPoint {
    let at = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 2.0;
    var point: CopyPoint;
    point.position = vec4<f32>(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0);
    point.at = at;
    return point;
}

fn colour_at(at: vec2<f32>) -> vec3<f32> {
    return textureLoad(picture, vec2<i32>(at * vec2<f32>(textureDimensions(picture))), 0).rgb;
}

@fragment
fn copy_to_gamma(point: CopyPoint) -> @location(0) vec4<f32> {
    return vec4<f32>(colour_at(point.at), 1.0);
}

// Windows whose format makes sRGB of linear colours.
@fragment
fn copy_to_linear(point: CopyPoint) -> @location(0) vec4<f32> {
    let colour = colour_at(point.at);
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(high, low, colour <= vec3<f32>(0.04045)), 1.0);
}
