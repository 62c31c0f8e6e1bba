// Base-colour textures, composed in where a scene has them.

fn texel_color(material: MaterialData, x: i32, y: i32) -> vec3<f32> {
    let width = i32(material.texture_width);
    let height = i32(material.texture_height);
    let column = clamp((x + width) % width, 0, width - 1);
    let row = clamp((y + height) % height, 0, height - 1);
    let rgba = tables[i32(material.texture_first) + row * width + column];
    return vec3(
        bitcast<f32>(tables[rgba & 255u]),
        bitcast<f32>(tables[(rgba >> 8u) & 255u]),
        bitcast<f32>(tables[(rgba >> 16u) & 255u]),
    );
}

fn texture_color(material: MaterialData, u: f32, v: f32) -> vec3<f32> {
    let x = (u - floor(u)) * f32(material.texture_width) - 0.5;
    let y = (v - floor(v)) * f32(material.texture_height) - 0.5;
    let left = floor(x);
    let top = floor(y);
    let fx = x - left;
    let fy = y - top;
    let column = i32(left);
    let row = i32(top);
    let above = texel_color(material, column, row) * (1.0 - fx) + texel_color(material, column + 1, row) * fx;
    let below = texel_color(material, column, row + 1) * (1.0 - fx) + texel_color(material, column + 1, row + 1) * fx;
    return above * (1.0 - fy) + below * fy;
}

fn texture_factor(triangle: vec4<u32>, material: MaterialData, u: f32, v: f32) -> vec3<f32> {
    if material.texture_width == 0u {
        return vec3(1.0);
    }
    let a = uvs[triangle.x];
    let b = uvs[triangle.y];
    let c = uvs[triangle.z];
    let at = a + (b - a) * u + (c - a) * v;
    return texture_color(material, at.x, at.y);
}
