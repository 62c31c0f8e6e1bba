// Glowing spheres, composed in where a scene has them.

fn sample_sphere(emitter: Emitter, point: vec3<f32>, a: f32, b: f32) -> LightSample {
    let to_centre = emitter.position - point;
    let distance2 = dot3(to_centre, to_centre);
    let radius2 = emitter.extent * emitter.extent;
    if distance2 <= radius2 {
        return LightSample();
    }
    let distance = sqrt(distance2);
    let sine2_max = radius2 / distance2;
    let one_minus_cosine_max = sine2_max / (1.0 + sqrt(1.0 - sine2_max));
    let one_minus_cosine = a * one_minus_cosine_max;
    let cosine = 1.0 - one_minus_cosine;
    let sine2 = one_minus_cosine * (2.0 - one_minus_cosine);
    let sine = sqrt(sine2);
    let turn = sine_cosine(b);
    let axis = to_centre * (1.0 / distance);
    let frame = basis(axis);
    let direction = normalize3(frame.tangent * (sine * turn.y) + frame.bitangent * (sine * turn.x) + axis * cosine);
    let t_max = distance * cosine - sqrt(max(radius2 - distance2 * sine2, 0.0));
    return LightSample(direction, t_max, emitter.power * (2.0 * one_minus_cosine_max / radius2), 0.0, emitter.light);
}
