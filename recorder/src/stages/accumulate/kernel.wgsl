// Adds traced lengths to the table: 64-bit sums as two words, so that no order and no wrap matters.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let index = span.first + item;
    let ray = unit_ray(origins[index].xyz, directions[index].xyz, directions[index].w);
    let cell = table_cell(ray, 0.0, 0u).x;
    let added = fixed_point(traced_length(ray, index));
    let before = atomicAdd(&sums[2u * cell], added);
    if before + added < before {
        atomicAdd(&sums[2u * cell + 1u], 1u);
    }
    atomicAdd(&counts[cell], 1u);
}
