// Counts results that differ from those of canonical order.

fn run_item(index: u32) {
    if differs(index) {
        atomicAdd(&counter[0], 1u);
    }
}
