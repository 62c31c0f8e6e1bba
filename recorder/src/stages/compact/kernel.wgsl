// Exclusive prefix sum over the flags of live items in three dispatches: sums of tiles, places of
// tiles, places of items.

struct ScanSpan {
    // Items, live or not.
    count: u32,
    // Tiles of SCAN_THREADS * ITEMS_PER_THREAD items; the last may be shorter.
    tiles: u32,
}

@group(0) @binding(0) var<storage, read> directions: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> places: array<u32>;
// Sums of the tiles, then the places where they begin, and the total of all at the end.
@group(0) @binding(2) var<storage, read_write> tile_places: array<u32>;

var<immediate> span: ScanSpan;

fn sum_of(first: u32, end: u32) -> u32 {
    var sum = 0u;
    for (var item = first; item < end; item++) {
        sum += u32(is_live(item));
    }
    return sum;
}

@compute @workgroup_size(SCAN_THREADS)
fn sum_tiles(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let tile = linear_workgroup(group, groups);
    if tile >= span.tiles {
        return;
    }
    let first = (tile * SCAN_THREADS + thread) * ITEMS_PER_THREAD;
    let sum = sum_of(first, min(first + ITEMS_PER_THREAD, span.count));
    exclusive_sum(sum, thread);
    if thread == 0u {
        tile_places[tile] = scan_sums[SCAN_THREADS - 1u];
    }
}

// One workgroup: each thread takes a run of tiles.
@compute @workgroup_size(SCAN_THREADS)
fn place_tiles(@builtin(local_invocation_index) thread: u32) {
    let run = (span.tiles + SCAN_THREADS - 1u) / SCAN_THREADS;
    let first = min(thread * run, span.tiles);
    let end = min(first + run, span.tiles);
    var sum = 0u;
    for (var tile = first; tile < end; tile++) {
        sum += tile_places[tile];
    }
    var place = exclusive_sum(sum, thread);
    for (var tile = first; tile < end; tile++) {
        let count = tile_places[tile];
        tile_places[tile] = place;
        place += count;
    }
    if thread == 0u {
        tile_places[span.tiles] = scan_sums[SCAN_THREADS - 1u];
    }
}

@compute @workgroup_size(SCAN_THREADS)
fn place_items(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let tile = linear_workgroup(group, groups);
    if tile >= span.tiles {
        return;
    }
    let first = (tile * SCAN_THREADS + thread) * ITEMS_PER_THREAD;
    let end = min(first + ITEMS_PER_THREAD, span.count);
    var place = tile_places[tile] + exclusive_sum(sum_of(first, end), thread);
    for (var item = first; item < end; item++) {
        places[item] = place;
        place += u32(is_live(item));
    }
}
