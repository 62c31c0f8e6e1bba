// Reduce, then scan, for adapters that compute on the CPU or whose subgroups do not fit: each thread walks a stretch
// of keys of its own, with counters of its own, and no thread waits for another.

// [bin][tile]: keys of a bin in a tile; after the scan, those of the bin in the tiles before.
@group(0) @binding(6) var<storage, read_write> tile_counts: array<u32>;

var<workgroup> seen_here: array<atomic<u32>, 2>;

// Finds out which bits differ in the word that the digit is in.
@compute @workgroup_size(LOOK_THREADS)
fn look(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if thread < 2u {
        atomicStore(&seen_here[thread], 0u);
    }
    workgroupBarrier();
    let workgroup = linear_workgroup(group, groups);
    let first = workgroup * LOOK_THREADS * LOOK_KEYS_PER_THREAD + thread;
    let is_low = sort_pass.digit < DIGITS_PER_WORD;
    let last = sort_pass.count - 1u;
    var ones = 0u;
    var zeros = 0u;
    // Behind the last key stands that key again, which says nothing new: so reads wait for no branch.
    if is_low {
        for (var row = 0u; row < LOOK_KEYS_PER_THREAD; row++) {
            let word = low_words[min(first + row * LOOK_THREADS, last)];
            ones |= word;
            zeros |= ~word;
        }
    } else {
        for (var row = 0u; row < LOOK_KEYS_PER_THREAD; row++) {
            let word = high_words[min(first + row * LOOK_THREADS, last)];
            ones |= word;
            zeros |= ~word;
        }
    }
    atomicOr(&seen_here[0], ones);
    atomicOr(&seen_here[1], zeros);
    workgroupBarrier();
    if thread < 2u {
        let word = select(2u, 0u, is_low);
        atomicOr(&totals[sort_pass.half].seen[word + thread], atomicLoad(&seen_here[thread]));
    }
    if workgroup == 0u {
        clear_next_totals(thread, LOOK_THREADS);
    }
}

// [bin][thread]: a thread uses its own column alone, so no barrier is needed.
var<workgroup> columns: array<u32, BINS * TILE_THREADS>;

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

// One workgroup per bin: from the counts of its tiles to where each tile's keys begin in it.
@compute @workgroup_size(SCAN_THREADS)
fn scan(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if !plan_pass().runs {
        return;
    }
    let run = (sort_pass.tiles + SCAN_THREADS - 1u) / SCAN_THREADS;
    let start = group.x * sort_pass.tiles;
    let first = min(thread * run, sort_pass.tiles);
    let end = min(first + run, sort_pass.tiles);
    var sum = 0u;
    for (var tile = first; tile < end; tile++) {
        sum += tile_counts[start + tile];
    }
    var place = exclusive_sum(sum, thread);
    for (var tile = first; tile < end; tile++) {
        let count = tile_counts[start + tile];
        tile_counts[start + tile] = place;
        place += count;
    }
    if thread == SCAN_THREADS - 1u {
        atomicStore(&totals[sort_pass.half].bins[group.x], scan_sums[SCAN_THREADS - 1u]);
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
        bin_start += atomicLoad(&totals[sort_pass.half].bins[bin]);
    }
    let first = tile * TILE_KEYS;
    let end = min(first + TILE_KEYS, sort_pass.count);
    for (var place = first; place < end; place++) {
        let key = key_at(place, plan.source);
        let index = index_at(place, plan.source);
        let column = bin_of(key) * TILE_THREADS + thread;
        let slot = columns[column];
        columns[column] = slot + 1u;
        write_index(slot, index, plan);
        if plan.word_written == SAME_WORD {
            write_word(slot, key, plan);
        } else if plan.word_written == HIGH_WORD {
            write_word(slot, high_words[index], plan);
        }
    }
}
