// Coordinates that keys are taken from: the same on threads is `formats::key`. `encode` is generated per layout.

struct UnitRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    // The ray's own end, unit lengths.
    t_max: f32,
}

// What is known of a ray beside itself.
struct Facts {
    length: f32,
    light: u32,
    path: u32,
}

fn unit_ray(origin: vec3<f32>, direction: vec3<f32>, t_max: f32) -> UnitRay {
    return UnitRay(rounded3(rounded3(origin - unit.min) * unit.scale), direction, t_max * unit.scale);
}

fn quantise(value: f32) -> u32 {
    if value > 0.0 {
        return u32(min(value * QUANTISE_SCALE, QUANTISE_LAST));
    }
    return 0u;
}

fn cartesian(x: f32) -> f32 {
    return (x + 1.0) * 0.5;
}

fn sign_of(x: f32) -> f32 {
    return select(-1.0, 1.0, x > 0.0);
}

fn octahedral(d: vec3<f32>) -> vec2<f32> {
    let sum = abs(d.x) + abs(d.y) + abs(d.z);
    if sum == 0.0 {
        return vec2(0.5);
    }
    var p = vec2(quotient(d.x, sum), quotient(d.y, sum));
    if d.z < 0.0 {
        p = vec2((1.0 - abs(p.y)) * sign_of(d.x), (1.0 - abs(p.x)) * sign_of(d.y));
    }
    return vec2(cartesian(p.x), cartesian(p.y));
}

fn paraboloid(d: vec3<f32>) -> vec2<f32> {
    let k = abs(d.z) + 1.0;
    return vec2(quotient(d.x, k) * 0.25 + select(0.75, 0.25, d.z < 0.0), quotient(d.y, k) * 0.5 + 0.5);
}

fn azimuth(x: f32, y: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let larger = max(ax, ay);
    if larger == 0.0 {
        return 0.5;
    }
    let z = quotient(min(ax, ay), larger);
    let z2 = z * z;
    var sum = ARCTANGENT[7];
    for (var i = 6; i >= 0; i--) {
        sum = rounded(sum * z2) + ARCTANGENT[i];
    }
    var angle = rounded(z * rounded(rounded(sum * z2) + 1.0));
    if ay > ax {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    if y < 0.0 {
        angle = -angle;
    }
    return rounded(angle * (0.5 * FRAC_1_PI)) + 0.5;
}

fn polar(z: f32) -> f32 {
    let a = min(abs(z), 1.0);
    var sum = ARCCOSINE[7];
    for (var i = 6; i >= 0; i--) {
        sum = rounded(sum * a) + ARCCOSINE[i];
    }
    var angle = rounded(root(1.0 - a) * sum);
    if z < 0.0 {
        angle = PI - angle;
    }
    return angle * FRAC_1_PI;
}

fn exit_along(origin: f32, direction: f32, side: f32, bounds: vec2<f32>) -> vec2<f32> {
    // x: largest near bound, y: smallest far bound; an empty interval says "never".
    if direction == 0.0 {
        if origin < 0.0 || origin > side {
            return vec2(1.0, 0.0);
        }
        return bounds;
    }
    let to_min = quotient(0.0 - origin, direction);
    let to_max = quotient(side - origin, direction);
    return vec2(max(bounds.x, min(to_min, to_max)), min(bounds.y, max(to_min, to_max)));
}

var<private> infinity_bits: u32 = 0x7f800000u;

fn exit_length(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    var bounds = vec2(0.0, bitcast<f32>(infinity_bits));
    bounds = exit_along(origin.x, direction.x, unit.sides.x, bounds);
    bounds = exit_along(origin.y, direction.y, unit.sides.y, bounds);
    bounds = exit_along(origin.z, direction.z, unit.sides.z, bounds);
    return select(bounds.y, 0.0, bounds.y < bounds.x);
}

fn bounded_length(ray: UnitRay, length: f32) -> f32 {
    return max(min(min(min(length, ray.t_max), exit_length(ray.origin, ray.direction)), LONGEST), 0.0);
}

fn end_quantised(origin: f32, length: f32, direction: f32) -> u32 {
    let step = (i32(length * STEP_ONE) * i32(direction * STEP_ONE)) >> STEP_SHIFT;
    return u32(clamp(i32(quantise(origin)) + step, 0, i32(QUANTISE_LAST)));
}

// Steps of `formats::key::hilbert`, by the same names.
fn mirrored(first: u32, level: u32) -> u32 {
    return first ^ (((1u << level) - 1u) & (0u - ((first >> level) & 1u)));
}

fn turned(first: u32, other: u32, level: u32) -> vec2<u32> {
    let below = (1u << level) - 1u;
    let is_set = 0u - ((other >> level) & 1u);
    let exchanged = (first ^ other) & below & ~is_set;
    return vec2(first ^ exchanged ^ (below & is_set), other ^ exchanged);
}

fn parity_above(word: u32) -> u32 {
    var parity = word >> 1u;
    parity ^= parity >> 1u;
    parity ^= parity >> 2u;
    parity ^= parity >> 4u;
    parity ^= parity >> 8u;
    return parity ^ (parity >> 16u);
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return rounded(a.x * b.x) + rounded(a.y * b.y) + rounded(a.z * b.z);
}
