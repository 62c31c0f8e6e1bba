// Multiple importance sampling: how much a sample counts that two strategies could have drawn.

fn power_heuristic(a: f32, b: f32) -> f32 {
    let a2 = a * a;
    return a2 / (a2 + b * b);
}

fn emission_weight(density: f32, light_density: f32) -> f32 {
    if density > 0.0 {
        return power_heuristic(density, light_density);
    }
    return 1.0;
}
