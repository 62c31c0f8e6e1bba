// Points, spots and parallel light, composed in where a scene has any of them.

fn sample_point(emitter: Emitter, point: vec3<f32>) -> LightSample {
    let to_light = emitter.position - point;
    let distance2 = dot3(to_light, to_light);
    if distance2 <= 0.0 {
        return LightSample();
    }
    let distance = sqrt(distance2);
    let direction = to_light * (1.0 / distance);
    var falloff = 1.0;
    if emitter.shape == EMITTER_SPOT {
        let cosine = -dot3(direction, emitter.direction);
        let linear = clamp(cosine * emitter.cone_scale + emitter.extent, 0.0, 1.0);
        falloff = linear * linear;
    }
    if falloff <= 0.0 {
        return LightSample();
    }
    return LightSample(direction, distance, emitter.power * (falloff / distance2), 0.0, emitter.light);
}

fn sample_directional(emitter: Emitter) -> LightSample {
    return LightSample(-emitter.direction, bitcast<f32>(infinity_bits), emitter.power, 0.0, emitter.light);
}
