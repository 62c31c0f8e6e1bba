// Shades the hits of a queue: the twin of `stages::shade::path`.
//
// Candidates for the next queues go to the place of their path; `compact` removes the holes.

struct Outcome {
    emitted: vec3<f32>,
    has_shadow: bool,
    has_next: bool,
}

fn to_local(frame: Basis, normal: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot3(v, frame.tangent), dot3(v, frame.bitangent), dot3(v, normal));
}

fn to_world(frame: Basis, normal: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return frame.tangent * v.x + frame.bitangent * v.y + normal * v.z;
}

fn is_bright(color: vec3<f32>) -> bool {
    let brightness = luminance(color);
    return brightness > 0.0 && brightness < F32_MAX;
}

fn cast_shadow_ray(
    index: u32,
    surface: HitSurface,
    reflection: Surface,
    frame: Basis,
    out_direction: vec3<f32>,
    throughput: vec3<f32>,
    random: ptr<function, u32>,
) -> bool {
    let origin = surface.origin;
    let light = sample_light(origin, random);
    if dot3(light.direction, surface.geometric_normal) <= 0.0 || light.t_max <= 0.0 {
        return false;
    }
    let found = bsdf_evaluate(reflection, out_direction, to_local(frame, surface.shading_normal, light.direction));
    var weight = 1.0;
    if light.density > 0.0 && params.is_last == 0u {
        weight = power_heuristic(light.density, found.density);
    }
    let color = throughput * found.value * light.weight * weight;
    if !is_bright(color) {
        return false;
    }
    shadow_origins[index] = vec4(origin, 0.0);
    shadow_directions[index] = vec4(light.direction, light.t_max);
    shadow_states[index] = vec4(bitcast<vec3<u32>>(color), light.light);
    return true;
}

fn cast_next_ray(
    index: u32,
    surface: HitSurface,
    reflection: Surface,
    frame: Basis,
    out_direction: vec3<f32>,
    throughput: vec3<f32>,
    random: ptr<function, u32>,
) -> bool {
    let sample = bsdf_sample(reflection, out_direction, random);
    if sample.density < 0.0 {
        return false;
    }
    let direction = normalize3(to_world(frame, surface.shading_normal, sample.direction));
    if dot3(direction, surface.geometric_normal) <= 0.0 {
        return false;
    }
    var color = throughput * sample.weight;
    if params.roulette != 0u && params.bounce >= ROULETTE_FREE_BOUNCES {
        let survival = clamp(max(max(color.x, color.y), color.z), 0.05, 1.0);
        if random_next(random) >= survival {
            return false;
        }
        color = color * (1.0 / survival);
    }
    if !is_bright(color) {
        return false;
    }
    next_origins[index] = vec4(surface.origin, 0.0);
    next_directions[index] = vec4(direction, bitcast<f32>(infinity_bits));
    next_states[index] = bitcast<vec4<u32>>(vec4(color, sample.density));
    return true;
}

fn shade_path(index: u32, pixel: u32) -> Outcome {
    var outcome = Outcome();
    let direction = directions[index].xyz;
    let hit = hits[index];
    let state_bits = states[index];
    let state = PathState(bitcast<vec3<f32>>(state_bits.xyz), bitcast<f32>(state_bits.w));
    if hit.y == NO_TRIANGLE {
        outcome.emitted = missed_radiance(direction, state);
        return outcome;
    }
    let surface = hit_surface(direction, hit.y, bitcast<f32>(hit.z), bitcast<f32>(hit.w));
    outcome.emitted = emitted_radiance(direction, bitcast<f32>(hit.x), state, surface);
    let reflection = surface_new(surface.base_color, surface.material.metallic, surface.material.roughness);
    let frame = basis(surface.shading_normal);
    let out_direction = to_local(frame, surface.shading_normal, -direction);
    var random = random_start(params.seed, pixel, params.pass_index, params.bounce + 1u);
    if params.emitter_count > 0u {
        outcome.has_shadow = cast_shadow_ray(index, surface, reflection, frame, out_direction, state.color, &random);
    }
    if params.is_last == 0u {
        outcome.has_next = cast_next_ray(index, surface, reflection, frame, out_direction, state.color, &random);
    }
    return outcome;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= params.count {
        return;
    }
    let index = params.first + item;
    let pixel = path_ids[index];
    let outcome = shade_path(index, pixel);
    shadow_flags[index] = u32(outcome.has_shadow);
    next_flags[index] = u32(outcome.has_next);
    if any(outcome.emitted != vec3(0.0)) {
        film[pixel] = film[pixel] + vec4(outcome.emitted, 0.0);
    }
}
