// Traces one ray per thread. `ray_place` and `result_place` say which ray and where its result goes.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let item = (group.y * groups.x + group.x) * 64u + lane;
    if item >= span.count {
        return;
    }
    let index = span.first + item;
    let place = ray_place(index);
    var query = query_new(origins[place], directions[place]);
    traverse(&query);
    write_result(result_place(index), &query);
}
