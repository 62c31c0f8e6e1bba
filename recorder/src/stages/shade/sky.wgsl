// The sky, composed in where a scene has one.

fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    return params.nadir + (params.zenith - params.nadir) * (0.5 * direction.y + 0.5);
}

fn sample_sky(emitter: Emitter, a: f32, b: f32) -> LightSample {
    let z = 1.0 - 2.0 * a;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let turn = sine_cosine(b);
    let direction = vec3(radius * turn.y, radius * turn.x, z);
    return LightSample(direction, bitcast<f32>(infinity_bits), sky_radiance(direction) * (4.0 * PI), params.sky_density, emitter.light);
}

// What a ray finds that hits nothing.
fn missed_radiance(direction: vec3<f32>, state: PathState) -> vec3<f32> {
    if params.sky_density <= 0.0 {
        return vec3(0.0);
    }
    return state.color * sky_radiance(direction) * emission_weight(state.density, params.sky_density);
}
