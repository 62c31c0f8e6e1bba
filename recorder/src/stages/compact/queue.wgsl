// Moves the live candidates of a queue together, in canonical order.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let index = span.first + item;
    if flags[index] == 0u {
        return;
    }
    let place = places[index];
    live_origins[place] = origins[index];
    live_directions[place] = directions[index];
    live_states[place] = states[index];
    live_path_ids[place] = path_ids[index];
}
