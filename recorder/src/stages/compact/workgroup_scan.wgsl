// The sum over the threads of a workgroup (Hillis and Steele 1986): short, and made of barriers
// alone, so that it needs no subgroups. Its log n rounds are few beside the items of each thread.

var<workgroup> scan_sums: array<u32, SCAN_THREADS>;

fn exclusive_sum(value: u32, thread: u32) -> u32 {
    scan_sums[thread] = value;
    workgroupBarrier();
    var inclusive = value;
    for (var reach = 1u; reach < SCAN_THREADS; reach *= 2u) {
        if thread >= reach {
            inclusive += scan_sums[thread - reach];
        }
        workgroupBarrier();
        scan_sums[thread] = inclusive;
        workgroupBarrier();
    }
    return inclusive - value;
}
