// The two ends of a line on the screen.
struct LineEnds {
    from_clip: vec4<f32>,
    to_clip: vec4<f32>,
    // Unit vector from one to the other, pixels.
    along: vec2<f32>,
    length_pixels: f32,
    // Whether any of it is before the eye, and whether its second point is.
    is_seen: bool,
    is_end_seen: bool,
}

// Nothing nearer than this is projected.
const NEAREST: f32 = 0.0008;

fn cut_at_eye(inside: vec4<f32>, other: vec4<f32>) -> vec4<f32> {
    if other.w >= NEAREST {
        return other;
    }
    return mix(inside, other, (inside.w - NEAREST) / (inside.w - other.w));
}

fn line_ends(a: vec3<f32>, b: vec3<f32>) -> LineEnds {
    // A little nearer to the eye, so that lines on a surface are seen.
    let nearer = 0.003;
    let from_clip = layer.clip_from_unit * vec4<f32>(mix(a, layer.eye.xyz, nearer), 1.0);
    let to_clip = layer.clip_from_unit * vec4<f32>(mix(b, layer.eye.xyz, nearer), 1.0);
    var ends: LineEnds;
    ends.is_seen = from_clip.w >= NEAREST || to_clip.w >= NEAREST;
    ends.is_end_seen = to_clip.w >= NEAREST;
    if !ends.is_seen {
        return ends;
    }
    ends.from_clip = cut_at_eye(to_clip, from_clip);
    ends.to_clip = cut_at_eye(from_clip, to_clip);
    let half_view = 0.5 * layer.viewport;
    let along = (ends.to_clip.xy / ends.to_clip.w - ends.from_clip.xy / ends.from_clip.w) * half_view;
    ends.length_pixels = length(along);
    ends.along = select(vec2<f32>(1.0, 0.0), along / max(ends.length_pixels, 1e-6), ends.length_pixels > 1e-3);
    return ends;
}
