// Random numbers and functions of them: the same on threads is `stages::random`.

fn pcg(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn random_start(seed: vec2<u32>, pixel: u32, pass_index: u32, stream: u32) -> u32 {
    let salt = pcg(seed.x + pcg(seed.y));
    let at = pcg(stream + pcg(pass_index + salt));
    return pcg(pixel + at);
}

fn random_next(state: ptr<function, u32>) -> f32 {
    *state = *state + 0x9e3779b9u;
    return f32(pcg(*state) >> 8u) * (1.0 / 16777216.0);
}

// As if `count` numbers had been drawn.
fn random_skip(state: ptr<function, u32>, count: u32) {
    *state = *state + count * 0x9e3779b9u;
}

// (sine, cosine)
fn sine_cosine(turns: f32) -> vec2<f32> {
    let quarters = turns * 4.0;
    let nearest = floor(quarters + 0.5);
    let x = quarters - nearest;
    let x2 = x * x;
    let sine = x * (SINE[0] + x2 * (SINE[1] + x2 * (SINE[2] + x2 * (SINE[3] + x2 * SINE[4]))));
    let cosine = COSINE[0] + x2 * (COSINE[1] + x2 * (COSINE[2] + x2 * (COSINE[3] + x2 * COSINE[4])));
    switch u32(nearest) & 3u {
        case 0u: { return vec2(sine, cosine); }
        case 1u: { return vec2(cosine, -sine); }
        case 2u: { return vec2(-sine, -cosine); }
        default: { return vec2(-cosine, sine); }
    }
}

fn cosine_hemisphere(a: f32, b: f32) -> vec3<f32> {
    let radius = sqrt(a);
    let turn = sine_cosine(b);
    return vec3(radius * turn.y, radius * turn.x, sqrt(max(1.0 - a, 0.0)));
}
