// Adds traced lengths to the table: 64-bit sums as two words, so that no order and no wrap matters.

fn run_item(index: u32) {
    let ray = unit_ray(origins[index].xyz, directions[index].xyz, directions[index].w);
    let cell = table_cell(ray, Facts()).x;
    let added = fixed_point(traced_length(ray, index));
    let before = atomicAdd(&sums[2u * cell], added);
    if before + added < before {
        atomicAdd(&sums[2u * cell + 1u], 1u);
    }
    atomicAdd(&counts[cell], 1u);
}
