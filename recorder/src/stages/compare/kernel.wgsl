// Counts results that differ from those of canonical order.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let index = span.first + item;
    if differs(index) {
        atomicAdd(&counter[0], 1u);
    }
}
