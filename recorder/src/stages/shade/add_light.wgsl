// Adds the light of the shadow rays that nothing blocked.

fn run_item(index: u32) {
    // Only +inf says that no occluder was found.
    if bitcast<u32>(distances[index]) == 0x7f800000u {
        let pixel = path_ids[index];
        film[pixel] = film[pixel] + vec4(bitcast<vec3<f32>>(states[index].xyz), 0.0);
    }
}
