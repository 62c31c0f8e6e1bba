// The kernels that do not depend on how a tile is spread over threads.

var<workgroup> seen_here: array<atomic<u32>, 2>;

// Finds out which bits differ in the word that the digit is in.
@compute @workgroup_size(EXAMINE_THREADS)
fn examine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if thread < 2u {
        atomicStore(&seen_here[thread], 0u);
    }
    workgroupBarrier();
    let first = linear_workgroup(group, groups) * EXAMINE_THREADS * EXAMINE_KEYS_PER_THREAD + thread;
    let is_low = sort_pass.digit < DIGITS_PER_WORD;
    let last = sort_pass.count - 1u;
    var ones = 0u;
    var zeros = 0u;
    // Behind the last key stands that key again, which says nothing new: so reads wait for no branch.
    if is_low {
        for (var row = 0u; row < EXAMINE_KEYS_PER_THREAD; row++) {
            let word = low_words[min(first + row * EXAMINE_THREADS, last)];
            ones |= word;
            zeros |= ~word;
        }
    } else {
        for (var row = 0u; row < EXAMINE_KEYS_PER_THREAD; row++) {
            let word = high_words[min(first + row * EXAMINE_THREADS, last)];
            ones |= word;
            zeros |= ~word;
        }
    }
    atomicOr(&seen_here[0], ones);
    atomicOr(&seen_here[1], zeros);
    workgroupBarrier();
    if thread < 2u {
        let word = select(2u, 0u, is_low);
        atomicOr(&totals.seen[word + thread], atomicLoad(&seen_here[thread]));
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
        totals.bins[group.x] = scan_sums[SCAN_THREADS - 1u];
    }
}
