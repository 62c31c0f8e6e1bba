// The light that each ray met, and its shadow ray: the twin of `stages::shade::path`.
//
// Candidates for the next queues go to the place of their path; `compact` removes the holes, which
// are where t_max is 0.

fn cast_shadow_ray(index: u32, pixel: u32, direction: vec3<f32>, throughput: vec3<f32>, surface: SurfaceData) -> bool {
    var random = random_start(params.seed, pixel, params.pass_index, params.bounce + 1u);
    let light = sample_light(surface.origin, &random);
    if dot3(light.direction, surface.geometric_normal) <= 0.0 || light.t_max <= 0.0 {
        return false;
    }
    let reflection = surface_new(surface.base_color, surface.metallic, surface.roughness);
    let frame = basis(surface.shading_normal);
    let out_direction = to_local(frame, surface.shading_normal, -direction);
    let found = bsdf_evaluate(reflection, out_direction, to_local(frame, surface.shading_normal, light.direction));
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

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= params.count {
        return;
    }
    let index = params.first + item;
    let pixel = path_ids[index];
    let direction = directions[index].xyz;
    let state = path_state(index);
    let surface = surfaces[item];
    var has_ray = false;
    var met: vec3<f32>;
    if is_miss(surface) {
        met = missed_radiance(direction, state);
    } else {
        met = emitted_radiance(direction, state, surface);
        if params.emitter_count > 0u {
            has_ray = cast_shadow_ray(index, pixel, direction, state.color, surface);
        }
    }
    if !has_ray {
        shadow_directions[index].w = 0.0;
    }
    if any(met != vec3(0.0)) {
        film[pixel] = film[pixel] + vec4(met, 0.0);
    }
}
