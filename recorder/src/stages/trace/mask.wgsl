// Holes of alpha masks: the same on threads is `stages::trace::mask`, composed in where a scene has them.

fn mask_texel(at: f32, size: u32) -> u32 {
    return min(u32((at - floor(at)) * f32(size)), size - 1u);
}

fn is_hole(triangle: u32, u: f32, v: f32) -> bool {
    let at = masks[triangle];
    if at == 0u {
        return false;
    }
    let mask = load_mask(at);
    let w = rounded((1.0 - u) - v);
    let x = (rounded(w * mask.uv_a.x) + rounded(u * mask.uv_b.x)) + rounded(v * mask.uv_c.x);
    let y = (rounded(w * mask.uv_a.y) + rounded(u * mask.uv_b.y)) + rounded(v * mask.uv_c.y);
    let place = mask.first + mask_texel(y, mask.height) * mask.width + mask_texel(x, mask.width);
    let alpha = (masks[place / 4u] >> (8u * (place % 4u))) & 255u;
    return alpha < mask.threshold;
}
