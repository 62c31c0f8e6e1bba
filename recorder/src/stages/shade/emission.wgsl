// Triangles that emit light, composed in where a scene has them.

fn sample_triangle(emitter: Emitter, point: vec3<f32>, a: f32, b: f32) -> LightSample {
    let p = emitter.position;
    let q = emitter.direction;
    let r = emitter.third_corner;
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

fn emitted_radiance(direction: vec3<f32>, state: PathState, surface: SurfaceData) -> vec3<f32> {
    let radiance = surface.emission;
    let brightness = luminance(radiance);
    if brightness <= 0.0 {
        return vec3(0.0);
    }
    let cosine = -dot3(direction, surface.geometric_normal);
    let light_density = brightness * params.emission_density * (surface.t * surface.t) / max(cosine, 1e-6);
    return state.color * radiance * emission_weight(state.density, light_density);
}
