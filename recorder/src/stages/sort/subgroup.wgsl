// One sweep, for graphics cards (Adinets and Merrill 2022): one look counts the keys of every digit's bins, then a
// pass is one dispatch. A workgroup puts a tile in order, says how many keys of each bin it has, and sums up what the
// tiles before it say. It waits for none of them: what has not been said within PATIENCE polls it counts itself, so
// that a pass ends on any device, whatever order its workgroups run in.
//
// Threads of a subgroup find their peers, those with the same digit, by ballots (Ashkiani et al. 2016), so that ranks
// are stable; the tile is put in order in workgroup memory, so that what is written together lies together. Works for
// every size of subgroup, as long as subgroups are full and at most SUBGROUPS.

const ROWS: u32 = TILE_KEYS / TILE_THREADS;

// [turn][tile][bin], turns 0 and 1 alternating over the passes that run: what a tile has said about a bin. 0 is
// nothing; else the low bits are a number of keys: those in the tile, or with those of all tiles before it.
@group(0) @binding(6) var<storage, read_write> tile_states: array<atomic<u32>>;

const IN_TILE: u32 = 1u << COUNT_BITS;
const UP_TO_TILE: u32 = 2u << COUNT_BITS;
const STATE_KEYS: u32 = IN_TILE - 1u;

var<workgroup> seen_here: array<atomic<u32>, 2>;
var<workgroup> digit_counts: array<atomic<u32>, DIGITS_PER_WORD * BINS>;

// Counts the keys in the bins of all digits of a word, and finds out which bits of it differ.
@compute @workgroup_size(LOOK_THREADS)
fn look(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    for (var entry = thread; entry < DIGITS_PER_WORD * BINS; entry += LOOK_THREADS) {
        atomicStore(&digit_counts[entry], 0u);
    }
    if thread < 2u {
        atomicStore(&seen_here[thread], 0u);
    }
    workgroupBarrier();
    let workgroup = linear_workgroup(group, groups);
    let first = workgroup * LOOK_THREADS * LOOK_KEYS_PER_THREAD + thread;
    let is_low = sort_pass.digit < DIGITS_PER_WORD;
    let last = sort_pass.count - 1u;
    var keys: array<u32, LOOK_KEYS_PER_THREAD>;
    // Behind the last key stands that key again: so reads wait for no branch.
    for (var row = 0u; row < LOOK_KEYS_PER_THREAD; row++) {
        let place = min(first + row * LOOK_THREADS, last);
        if is_low { keys[row] = low_words[place]; } else { keys[row] = high_words[place]; }
    }
    var ones = 0u;
    var zeros = 0u;
    let digits = countOneBits(extractBits(sort_pass.digits, sort_pass.digit, DIGITS_PER_WORD));
    for (var row = 0u; row < LOOK_KEYS_PER_THREAD; row++) {
        ones |= keys[row];
        zeros |= ~keys[row];
        let valid = first + row * LOOK_THREADS <= last;
        for (var digit = 0u; digit < digits; digit++) {
            let bin = digit * BINS + extractBits(keys[row], digit * DIGIT_BITS, DIGIT_BITS);
            if valid {
                atomicAdd(&digit_counts[bin], 1u);
            }
        }
    }
    atomicOr(&seen_here[0], ones);
    atomicOr(&seen_here[1], zeros);
    workgroupBarrier();
    for (var entry = thread; entry < digits * BINS; entry += LOOK_THREADS) {
        let count = atomicLoad(&digit_counts[entry]);
        if count != 0u {
            atomicAdd(&totals[sort_pass.half].bins[sort_pass.digit * BINS + entry], count);
        }
    }
    if thread < 2u {
        atomicOr(&totals[sort_pass.half].seen[select(2u, 0u, is_low) + thread], atomicLoad(&seen_here[thread]));
    }
    if !is_low {
        return;
    }
    if workgroup == 0u {
        clear_next_totals(thread, LOOK_THREADS);
    }
    // Nothing has been said before the first pass.
    let threads = groups.x * groups.y * LOOK_THREADS;
    for (var entry = workgroup * LOOK_THREADS + thread; entry < sort_pass.tiles * BINS; entry += threads) {
        atomicStore(&tile_states[entry], 0u);
    }
}

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

// [subgroup][bin]: keys of a bin in a subgroup's stretch; then, those in the stretches before.
var<workgroup> subgroup_counts: array<atomic<u32>, SUBGROUPS * BINS>;
// Where a bin begins in the sorted tile, and where the last one ends.
var<workgroup> bin_starts: array<u32, BINS + 1u>;
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

// The sum over the threads before this one, subgroup by subgroup. A barrier must come before the next call.
fn sum_before(value: u32, subgroup: u32, lane: u32, lanes: u32) -> u32 {
    var sum = subgroupExclusiveAdd(value);
    if lane == lanes - 1u {
        subgroup_sums[subgroup] = sum + value;
    }
    workgroupBarrier();
    for (var other = 0u; other < subgroup; other++) {
        sum += subgroup_sums[other];
    }
    return sum;
}

// What a tile says of a bin in which it has `count` keys; the first tile has none before it.
fn said(tile: u32, count: u32) -> u32 {
    return select(IN_TILE, UP_TO_TILE, tile == 0u) | count;
}

// Where the bins begin among all keys.
fn start_bins(subgroup: u32, lane: u32, lanes: u32) {
    let thread = subgroup * lanes + lane;
    // Each thread takes a run of bins, in order, so that a sum over threads gives the starts.
    let run = BINS / TILE_THREADS;
    var sum = 0u;
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        bin_offsets[bin] = sum;
        sum += atomicLoad(&totals[sort_pass.half].bins[sort_pass.digit * BINS + bin]);
    }
    let before = sum_before(sum, subgroup, lane, lanes);
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        bin_offsets[bin] += before;
    }
}

// From counts to starts: of the bins in the tile, and of each subgroup in the bins. Says what the tile has counted,
// and clears its places of the next turn.
fn place_bins(tile: u32, states: u32, subgroup: u32, lane: u32, lanes: u32) {
    let thread = subgroup * lanes + lane;
    let run = BINS / TILE_THREADS;
    let own = tile * BINS;
    // Of the two turns the other one.
    let next = sort_pass.tiles * BINS - states + own;
    var sum = 0u;
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        var in_bin = 0u;
        for (var stretch = 0u; stretch < SUBGROUPS; stretch++) {
            let in_stretch = atomicLoad(&subgroup_counts[stretch * BINS + bin]);
            atomicStore(&subgroup_counts[stretch * BINS + bin], in_bin);
            in_bin += in_stretch;
        }
        atomicStore(&tile_states[states + own + bin], said(tile, in_bin));
        atomicStore(&tile_states[next + bin], 0u);
        bin_starts[bin] = sum;
        sum += in_bin;
    }
    let before = sum_before(sum, subgroup, lane, lanes);
    for (var bin = thread * run; bin < (thread + 1u) * run; bin++) {
        bin_starts[bin] += before;
        bin_offsets[bin] -= bin_starts[bin];
    }
    if thread == TILE_THREADS - 1u {
        bin_starts[BINS] = before + sum;
    }
    workgroupBarrier();
}

// 1 + the last tile that some thread waits for; 0 if none does.
var<workgroup> waited_for: atomic<u32>;
var<workgroup> bin_counts: array<atomic<u32>, BINS>;

// The keys of a bin in the tiles before `tile`; each thread asks for another bin.
fn keys_before(bin: u32, tile: u32, states: u32, thread: u32, source: u32) -> u32 {
    var before = 0u;
    // Tiles that are still to be asked: those before `end`.
    var end = tile;
    loop {
        for (var polls = 0u; end > 0u && polls < PATIENCE; polls++) {
            // Several at once, since an answer takes long.
            var answers: array<u32, ASKED_AT_ONCE>;
            for (var ask = 0u; ask < ASKED_AT_ONCE; ask++) {
                answers[ask] = atomicLoad(&tile_states[states + (max(end, ask + 1u) - ask - 1u) * BINS + bin]);
            }
            for (var ask = 0u; ask < ASKED_AT_ONCE && end > 0u && answers[ask] != 0u; ask++) {
                before += answers[ask] & STATE_KEYS;
                end = select(0u, end - 1u, answers[ask] < UP_TO_TILE);
                polls = 0u;
            }
        }
        if end > 0u {
            atomicMax(&waited_for, end);
        }
        workgroupBarrier();
        let missing = atomicLoad(&waited_for);
        if missing == 0u {
            break;
        }
        // Its keys are as they were before the pass, which never writes where it reads.
        for (var other = thread; other < BINS; other += TILE_THREADS) {
            atomicStore(&bin_counts[other], 0u);
        }
        workgroupBarrier();
        if thread == 0u {
            atomicStore(&waited_for, 0u);
        }
        let first = (missing - 1u) * TILE_KEYS;
        for (var place = first + thread; place < first + TILE_KEYS; place += TILE_THREADS) {
            atomicAdd(&bin_counts[bin_of(key_at(place, source))], 1u);
        }
        workgroupBarrier();
        if end == missing {
            before += atomicLoad(&bin_counts[bin]);
            end -= 1u;
        }
        // Said for the tile, which may have said that much or more meanwhile.
        for (var other = thread; other < BINS; other += TILE_THREADS) {
            let count = atomicLoad(&bin_counts[other]);
            atomicMax(&tile_states[states + (missing - 1u) * BINS + other], said(missing - 1u, count));
        }
    }
    return before;
}

@compute @workgroup_size(TILE_THREADS)
fn sweep(
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
    // A subgroup has a stretch of the tile of its own and walks it row by row.
    let first = tile * TILE_KEYS + subgroup * lanes * ROWS + lane;
    var keys: array<u32, ROWS>;
    load_keys(&keys, first, lanes, plan.source);
    for (var entry = thread; entry < SUBGROUPS * BINS; entry += TILE_THREADS) {
        atomicStore(&subgroup_counts[entry], 0u);
    }
    if thread == 0u {
        atomicStore(&waited_for, 0u);
    }
    start_bins(subgroup, lane, lanes);

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
        // A lane without a key is nobody's peer and may ask anyone; it does not use the answer. The next row comes
        // after this one's counts, since it waits for what they gave.
        before = subgroupShuffle(before, select(lane, leader, valid));
        ranks[row] = before + count_lanes(peers & lanes_below(lane));
    }
    workgroupBarrier();
    let states = plan.turn * sort_pass.tiles * BINS;
    place_bins(tile, states, subgroup, lane, lanes);

    // Asked for only now, since registers are scarce while keys are ranked.
    var indices: array<u32, ROWS>;
    load_indices(&indices, first, lanes, plan.source);
    for (var row = 0u; row < ROWS; row++) {
        let bin = bin_of(keys[row]);
        ranks[row] += bin_starts[bin] + atomicLoad(&subgroup_counts[subgroup * BINS + bin]);
        if first + row * lanes < sort_pass.count {
            sorted[ranks[row]] = keys[row];
        }
    }
    for (var round = 0u; round < BINS / TILE_THREADS; round++) {
        let bin = round * TILE_THREADS + thread;
        let before = keys_before(bin, tile, states, thread, plan.source);
        let up_to_tile = before + bin_starts[bin + 1u] - bin_starts[bin];
        atomicStore(&tile_states[states + tile * BINS + bin], UP_TO_TILE | up_to_tile);
        bin_offsets[bin] += before;
        workgroupBarrier();
    }
    let in_tile = min(TILE_KEYS, sort_pass.count - tile * TILE_KEYS);
    var slots: array<u32, ROWS>;
    for (var row = 0u; row < ROWS; row++) {
        let rank = row * TILE_THREADS + thread;
        // Behind the keys of the last tile: some number, which is not used.
        let key = sorted[rank];
        slots[row] = bin_offsets[bin_of(key)] + rank;
        if rank < in_tile && plan.word_written == SAME_WORD {
            write_word(slots[row], key, plan);
        }
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
            write_index(slots[row], sorted[rank], plan);
            if plan.word_written == HIGH_WORD {
                write_word(slots[row], high_words[sorted[rank]], plan);
            }
        }
    }
}
