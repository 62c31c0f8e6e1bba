// The next ray of each path: the same on threads is `stages::shade::path`. A t_max of 0 says that the path ends.

fn cast_next_ray(index: u32, surface: SurfaceData) -> bool {
    var random = random_at(index);
    if params.emitter_count > 0u {
        random_skip(&random, LIGHT_DRAWS);
    }
    let at = reflection_at(surface, directions[index].xyz);
    let sample = bsdf_sample(at.surface, at.out_direction, &random);
    if sample.density < 0.0 {
        return false;
    }
    let direction = normalize3(to_world(at, sample.direction));
    if dot3(direction, surface.geometric_normal) <= 0.0 {
        return false;
    }
    var color = path_state(index).color * sample.weight;
    if params.roulette != 0u && params.bounce >= ROULETTE_FREE_BOUNCES {
        let survival = clamp(max(max(color.x, color.y), color.z), 0.05, 1.0);
        if random_next(&random) >= survival {
            return false;
        }
        color = color * (1.0 / survival);
    }
    if !is_bright(color) {
        return false;
    }
    next_directions[index] = vec4(direction, bitcast<f32>(infinity_bits));
    next_states[index] = bitcast<vec4<u32>>(vec4(color, sample.density));
    return true;
}

fn run_item(index: u32) {
    let surface = surface_at(index);
    var has_ray = false;
    if !is_miss(surface) {
        // Of the shadow ray, too.
        origins[index] = vec4(surface.origin, 0.0);
        if params.is_last == 0u {
            has_ray = cast_next_ray(index, surface);
        }
    }
    if !has_ray {
        next_directions[index].w = 0.0;
    }
}
