// Traces one ray per thread. `ray_place` and `result_place` say which ray and where its result goes.

fn run_item(index: u32) {
    let place = ray_place(index);
    var query = query_new(origins[place], directions[place]);
    traverse(&query);
    write_result(result_place(index), &query);
}
