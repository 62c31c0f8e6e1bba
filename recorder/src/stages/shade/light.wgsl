// Picking lights: the same on threads is `stages::shade::emitters`. `sample_emitter` knows the shapes that a scene has.

// A `t_max` of 0 says that the pick brings nothing.
struct LightSample {
    direction: vec3<f32>,
    t_max: f32,
    weight: vec3<f32>,
    density: f32,
    light: u32,
}

fn sample_light(point: vec3<f32>, random: ptr<function, u32>) -> LightSample {
    let slot_number = random_next(random);
    let choice = random_next(random);
    let a = random_next(random);
    let b = random_next(random);
    let slot = min(u32(slot_number * f32(params.emitter_count)), params.emitter_count - 1u);
    var emitter = emitters[slot];
    if choice >= emitter.keep {
        emitter = emitters[emitter.other];
    }
    let pick = 1.0 / emitter.probability;
    var sample = sample_emitter(emitter, point, a, b);
    sample.weight = sample.weight * pick;
    return sample;
}
