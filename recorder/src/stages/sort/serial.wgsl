// Tiles for adapters that compute on the CPU: each thread walks a stretch of keys of its own, with
// counters of its own, and no thread waits for another.

// [bin][thread]: a thread uses its own column alone, so no barrier is needed.
var<workgroup> columns: array<u32, BINS * TILE_THREADS>;

fn key_at(place: u32, source: u32) -> u32 {
    switch source {
        case FROM_A: { return keys_a[place]; }
        case FROM_B: { return keys_b[place]; }
        case FROM_LOW_WORDS: { return low_words[place]; }
        default: { return high_words[place]; }
    }
}

fn index_at(place: u32, source: u32) -> u32 {
    switch source {
        case FROM_A: { return order_a[place]; }
        case FROM_B: { return order_b[place]; }
        default: { return place; }
    }
}

@compute @workgroup_size(TILE_THREADS)
fn count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let plan = plan_pass();
    let tile = linear_workgroup(group, groups) * TILE_THREADS + thread;
    if !plan.runs || tile >= sort_pass.tiles {
        return;
    }
    for (var bin = 0u; bin < BINS; bin++) {
        columns[bin * TILE_THREADS + thread] = 0u;
    }
    let first = tile * TILE_KEYS;
    let end = min(first + TILE_KEYS, sort_pass.count);
    for (var place = first; place < end; place++) {
        columns[bin_of(key_at(place, plan.source)) * TILE_THREADS + thread] += 1u;
    }
    for (var bin = 0u; bin < BINS; bin++) {
        tile_counts[bin * sort_pass.tiles + tile] = columns[bin * TILE_THREADS + thread];
    }
}

@compute @workgroup_size(TILE_THREADS)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let plan = plan_pass();
    let tile = linear_workgroup(group, groups) * TILE_THREADS + thread;
    if !plan.runs || tile >= sort_pass.tiles {
        return;
    }
    var bin_start = 0u;
    for (var bin = 0u; bin < BINS; bin++) {
        columns[bin * TILE_THREADS + thread] = bin_start + tile_counts[bin * sort_pass.tiles + tile];
        bin_start += totals.bins[bin];
    }
    let first = tile * TILE_KEYS;
    let end = min(first + TILE_KEYS, sort_pass.count);
    for (var place = first; place < end; place++) {
        let pair = Pair(key_at(place, plan.source), index_at(place, plan.source));
        let column = bin_of(pair.key) * TILE_THREADS + thread;
        let slot = columns[column];
        columns[column] = slot + 1u;
        write_pair(slot, pair, plan);
    }
}
