// Copies both halves of each ray into a sorted order.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let place = span.first + item;
    let index = order[place];
    gathered_origins[place] = origins[index];
    gathered_directions[place] = directions[index];
}
