// Tiles for graphics cards: one workgroup counts and sorts a tile together. Threads of a subgroup
// find their peers, those with the same digit, by ballots (Ashkiani et al. 2016), so that ranks are
// stable; the tile is put in order in workgroup memory, so that what is written together lies
// together. Works for every size of subgroup, as long as subgroups are full and at most SUBGROUPS.

const ROWS: u32 = TILE_KEYS / TILE_THREADS;

// The keys of a thread, `step` apart. All of them are asked for before one is waited for: no branch lies between two
// reads, and behind the last key stands that key again.
fn load_keys(keys: ptr<function, array<u32, ROWS>>, first: u32, step: u32, source: u32) {
    let last = sort_pass.count - 1u;
    switch source {
        case FROM_A: { for (var row = 0u; row < ROWS; row++) { (*keys)[row] = keys_a[min(first + row * step, last)]; } }
        case FROM_B: { for (var row = 0u; row < ROWS; row++) { (*keys)[row] = keys_b[min(first + row * step, last)]; } }
        case FROM_LOW_WORDS: { for (var row = 0u; row < ROWS; row++) { (*keys)[row] = low_words[min(first + row * step, last)]; } }
        default: { for (var row = 0u; row < ROWS; row++) { (*keys)[row] = high_words[min(first + row * step, last)]; } }
    }
}

// Their indices.
fn load_indices(indices: ptr<function, array<u32, ROWS>>, first: u32, step: u32, source: u32) {
    let last = sort_pass.count - 1u;
    switch source {
        case FROM_A: { for (var row = 0u; row < ROWS; row++) { (*indices)[row] = order_a[min(first + row * step, last)]; } }
        case FROM_B: { for (var row = 0u; row < ROWS; row++) { (*indices)[row] = order_b[min(first + row * step, last)]; } }
        default: { for (var row = 0u; row < ROWS; row++) { (*indices)[row] = first + row * step; } }
    }
}

var<workgroup> bin_counts: array<atomic<u32>, BINS>;

@compute @workgroup_size(TILE_THREADS)
fn count(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let plan = plan_pass();
    let tile = linear_workgroup(group, groups);
    if !plan.runs || tile >= sort_pass.tiles {
        return;
    }
    for (var bin = thread; bin < BINS; bin += TILE_THREADS) {
        atomicStore(&bin_counts[bin], 0u);
    }
    let first = tile * TILE_KEYS + thread;
    var keys: array<u32, ROWS>;
    load_keys(&keys, first, TILE_THREADS, plan.source);
    workgroupBarrier();
    for (var row = 0u; row < ROWS; row++) {
        if first + row * TILE_THREADS < sort_pass.count {
            atomicAdd(&bin_counts[bin_of(keys[row])], 1u);
        }
    }
    workgroupBarrier();
    for (var bin = thread; bin < BINS; bin += TILE_THREADS) {
        tile_counts[bin * sort_pass.tiles + tile] = atomicLoad(&bin_counts[bin]);
    }
}

// [subgroup][bin]: keys of a bin in a subgroup's stretch; then, those in the stretches before.
var<workgroup> subgroup_counts: array<atomic<u32>, SUBGROUPS * BINS>;
// Where a bin begins in the sorted tile.
var<workgroup> bin_starts: array<u32, BINS>;
// Where a bin of this tile begins among all keys, less its start in the tile.
var<workgroup> bin_offsets: array<u32, BINS>;
// The tile in order: first its keys, then its indices.
var<workgroup> sorted: array<u32, TILE_KEYS>;

// The lanes (lanes_32.wgsl or lanes_128.wgsl) whose key is valid and has the same bin.
fn peers_of(bin: u32, valid: bool) -> Lanes {
    var peers = ballot(valid);
    for (var bit = 0u; bit < DIGIT_BITS; bit++) {
        let is_set = ((bin >> bit) & 1u) == 1u;
        let lanes = ballot(is_set);
        peers &= select(~lanes, lanes, is_set);
    }
    return peers;
}

var<workgroup> subgroup_sums: array<u32, SUBGROUPS>;

// The sum over the threads before this one, subgroup by subgroup.
fn sum_before(value: u32, subgroup: u32, lane: u32, lanes: u32) -> u32 {
    var sum = subgroupExclusiveAdd(value);
    if lane == lanes - 1u {
        subgroup_sums[subgroup] = sum + value;
    }
    workgroupBarrier();
    for (var other = 0u; other < subgroup; other++) {
        sum += subgroup_sums[other];
    }
    workgroupBarrier();
    return sum;
}

// From counts to starts: of the bins in the tile, and of each subgroup in the bins.
fn place_bins(tile: u32, subgroup: u32, lane: u32, lanes: u32) {
    let thread = subgroup * lanes + lane;
    // Each thread takes a run of bins, in order, so that a sum over threads gives the starts.
    let run = BINS / TILE_THREADS;
    var sum = 0u;
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        var in_bin = 0u;
        for (var subgroup = 0u; subgroup < SUBGROUPS; subgroup++) {
            let in_stretch = atomicLoad(&subgroup_counts[subgroup * BINS + bin]);
            atomicStore(&subgroup_counts[subgroup * BINS + bin], in_bin);
            in_bin += in_stretch;
        }
        bin_starts[bin] = sum;
        sum += in_bin;
    }
    let in_tile = sum_before(sum, subgroup, lane, lanes);
    var total = 0u;
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        bin_starts[bin] += in_tile;
        total += totals.bins[bin];
    }
    var bin_start = sum_before(total, subgroup, lane, lanes);
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        bin_offsets[bin] = bin_start + tile_counts[bin * sort_pass.tiles + tile] - bin_starts[bin];
        bin_start += totals.bins[bin];
    }
    workgroupBarrier();
}

@compute @workgroup_size(TILE_THREADS)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(subgroup_invocation_id) lane: u32,
    @builtin(subgroup_size) lanes: u32,
) {
    let plan = plan_pass();
    let tile = linear_workgroup(group, groups);
    if !plan.runs || tile >= sort_pass.tiles {
        return;
    }
    for (var entry = thread; entry < SUBGROUPS * BINS; entry += TILE_THREADS) {
        atomicStore(&subgroup_counts[entry], 0u);
    }
    // A subgroup has a stretch of the tile of its own and walks it row by row.
    let first = tile * TILE_KEYS + subgroup * lanes * ROWS + lane;
    var keys: array<u32, ROWS>;
    var indices: array<u32, ROWS>;
    load_keys(&keys, first, lanes, plan.source);
    load_indices(&indices, first, lanes, plan.source);
    workgroupBarrier();

    var ranks: array<u32, ROWS>;
    for (var row = 0u; row < ROWS; row++) {
        let valid = first + row * lanes < sort_pass.count;
        let bin = bin_of(keys[row]);
        let peers = peers_of(bin, valid);
        let leader = first_lane(peers);
        var before = 0u;
        if valid && lane == leader {
            before = atomicAdd(&subgroup_counts[subgroup * BINS + bin], count_lanes(peers));
        }
        // A lane without a key is nobody's peer and may ask anyone; it does not use the answer.
        before = subgroupShuffle(before, select(lane, leader, valid));
        ranks[row] = before + count_lanes(peers & lanes_below(lane));
    }
    workgroupBarrier();
    place_bins(tile, subgroup, lane, lanes);

    for (var row = 0u; row < ROWS; row++) {
        let bin = bin_of(keys[row]);
        ranks[row] += bin_starts[bin] + atomicLoad(&subgroup_counts[subgroup * BINS + bin]);
        if first + row * lanes < sort_pass.count {
            sorted[ranks[row]] = keys[row];
        }
    }
    workgroupBarrier();
    let in_tile = min(TILE_KEYS, sort_pass.count - tile * TILE_KEYS);
    var sorted_keys: array<u32, ROWS>;
    for (var row = 0u; row < ROWS; row++) {
        sorted_keys[row] = sorted[row * TILE_THREADS + thread];
    }
    workgroupBarrier();
    for (var row = 0u; row < ROWS; row++) {
        if first + row * lanes < sort_pass.count {
            sorted[ranks[row]] = indices[row];
        }
    }
    workgroupBarrier();
    for (var row = 0u; row < ROWS; row++) {
        let rank = row * TILE_THREADS + thread;
        if rank < in_tile {
            let slot = bin_offsets[bin_of(sorted_keys[row])] + rank;
            write_pair(slot, Pair(sorted_keys[row], sorted[rank]), plan);
        }
    }
}
