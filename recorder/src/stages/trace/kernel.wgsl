// Traces one ray per thread. `place_of` says which ray, and where its result goes.

fn run_item(index: u32) {
    let place = place_of(index);
    var query = query_new(origins[place], directions[place]);
    traverse(&query);
    write_result(place, &query);
}
