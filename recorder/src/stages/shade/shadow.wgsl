// The light that each ray met, and its shadow ray: the same on threads is `stages::shade::path`.
//
// Candidates for the next queues go to the place of their path; `compact` removes the holes, which
// are where t_max is 0.

fn cast_shadow_ray(index: u32, direction: vec3<f32>, throughput: vec3<f32>, surface: SurfaceData) -> bool {
    var random = random_at(index);
    let light = sample_light(surface.origin, &random);
    if dot3(light.direction, surface.geometric_normal) <= 0.0 || light.t_max <= 0.0 {
        return false;
    }
    let at = reflection_at(surface, direction);
    let found = bsdf_evaluate(at.surface, at.out_direction, to_local(at, light.direction));
    var weight = 1.0;
    if light.density > 0.0 && params.is_last == 0u {
        weight = power_heuristic(light.density, found.density);
    }
    let color = throughput * found.value * light.weight * weight;
    if !is_bright(color) {
        return false;
    }
    shadow_directions[index] = vec4(light.direction, light.t_max);
    shadow_states[index] = vec4(bitcast<vec3<u32>>(color), light.light);
    return true;
}

fn run_item(index: u32) {
    let direction = directions[index].xyz;
    let state = path_state(index);
    let surface = surface_at(index);
    var has_ray = false;
    var met: vec3<f32>;
    if is_miss(surface) {
        met = missed_radiance(direction, state);
    } else {
        met = emitted_radiance(direction, state, surface);
        if params.emitter_count > 0u {
            has_ray = cast_shadow_ray(index, direction, state.color, surface);
        }
    }
    if !has_ray {
        shadow_directions[index].w = 0.0;
    }
    if any(met != vec3(0.0)) {
        let pixel = path_ids[index];
        film[pixel] = film[pixel] + vec4(met, 0.0);
    }
}
