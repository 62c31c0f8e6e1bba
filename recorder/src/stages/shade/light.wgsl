// Picking and sampling lights: the twin of `stages::shade::emitters`.

var<private> infinity_bits: u32 = 0x7f800000u;

// A `t_max` of 0 says that the pick brings nothing.
struct LightSample {
    direction: vec3<f32>,
    t_max: f32,
    weight: vec3<f32>,
    density: f32,
    light: u32,
}

fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    return params.nadir + (params.zenith - params.nadir) * (0.5 * direction.y + 0.5);
}

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

fn sample_triangle(emitter: Emitter, point: vec3<f32>, a: f32, b: f32) -> LightSample {
    let triangle = triangles[emitter.triangle];
    let p = positions[triangle.x].xyz;
    let q = positions[triangle.y].xyz;
    let r = positions[triangle.z].xyz;
    let root = sqrt(a);
    let u = root * (1.0 - b);
    let v = root * b;
    let normal = normalize3(cross3(q - p, r - p));
    let on_light = p + (q - p) * u + (r - p) * v;
    let facing = select(normal, -normal, dot3(normal, point - on_light) < 0.0);
    let to_light = offset_origin(on_light, facing, q - p, r - p) - point;
    let distance2 = dot3(to_light, to_light);
    let distance = sqrt(distance2);
    let direction = to_light * (1.0 / distance);
    let cosine = -dot3(direction, facing);
    if !(cosine > 1e-6 && distance > 0.0) {
        return LightSample();
    }
    let density_over_area = 1.0 / emitter.extent;
    let density = density_over_area * distance2 / cosine;
    let light_density = density * emitter.probability;
    return LightSample(direction, distance * SHORT_OF_TRIANGLE, emitter.power * (1.0 / density), light_density, emitter.light);
}

fn sample_sky(emitter: Emitter, a: f32, b: f32) -> LightSample {
    let z = 1.0 - 2.0 * a;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let turn = sine_cosine(b);
    let direction = vec3(radius * turn.y, radius * turn.x, z);
    return LightSample(direction, bitcast<f32>(infinity_bits), sky_radiance(direction) * (4.0 * PI), params.sky_density, emitter.light);
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
    var sample: LightSample;
    switch emitter.shape {
        case EMITTER_SPHERE: { sample = sample_sphere(emitter, point, a, b); }
        case EMITTER_POINT, EMITTER_SPOT: { sample = sample_point(emitter, point); }
        case EMITTER_DIRECTIONAL: {
            sample = LightSample(-emitter.direction, bitcast<f32>(infinity_bits), emitter.power, 0.0, emitter.light);
        }
        case EMITTER_TRIANGLE: { sample = sample_triangle(emitter, point, a, b); }
        default: { sample = sample_sky(emitter, a, b); }
    }
    sample.weight = sample.weight * pick;
    return sample;
}
