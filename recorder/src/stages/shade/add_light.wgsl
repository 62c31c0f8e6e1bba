// Adds the light of the shadow rays that nothing blocked.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let index = span.first + item;
    // Only +inf says that no occluder was found.
    if bitcast<u32>(distances[index]) == 0x7f800000u {
        let pixel = path_ids[index];
        film[pixel] = film[pixel] + vec4(bitcast<vec3<f32>>(states[index].xyz), 0.0);
    }
}
