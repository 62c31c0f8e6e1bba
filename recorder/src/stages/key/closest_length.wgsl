// Traced length of a closest ray: to its hit, or to the exit on a miss.

fn traced_length(ray: UnitRay, index: u32) -> f32 {
    let hit = hits[index].xy;
    if hit.y == NO_TRIANGLE {
        return exit_length(ray.origin, ray.direction);
    }
    return bitcast<f32>(hit.x) * unit.scale;
}
