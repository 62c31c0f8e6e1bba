// Traced length of a shadow ray: to the occluder found, no farther than the light or the exit.

fn traced_length(ray: UnitRay, index: u32) -> f32 {
    return min(min(distances[index] * unit.scale, ray.t_max), exit_length(ray.origin, ray.direction));
}
