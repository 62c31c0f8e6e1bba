// What a device must do right, and how it rounds: small kernels whose answers are known.

@group(0) @binding(0) var<storage, read> inputs: array<u32>;
@group(0) @binding(1) var<storage, read_write> outputs: array<u32>;
@group(0) @binding(2) var<storage, read_write> counters: array<atomic<u32>>;

var<workgroup> shared_values: array<u32, 64>;

// Counts to inputs[lane].
@compute @workgroup_size(64)
fn long_loops(@builtin(local_invocation_index) lane: u32) {
    let bound = inputs[lane];
    var count = 0u;
    loop {
        if count >= bound {
            break;
        }
        count += 1u;
    }
    outputs[lane] = count;
}

// Adds up 64 numbers by reading what neighbours wrote before a barrier.
@compute @workgroup_size(64)
fn barriers(@builtin(local_invocation_index) lane: u32) {
    shared_values[lane] = inputs[lane];
    workgroupBarrier();
    for (var distance = 1u; distance < 64u; distance *= 2u) {
        let other = shared_values[lane ^ distance];
        workgroupBarrier();
        shared_values[lane] += other;
        workgroupBarrier();
    }
    outputs[lane] = shared_values[lane];
}

// A 64-bit sum as two words, as the length table keeps it.
@compute @workgroup_size(64)
fn atomics(@builtin(global_invocation_id) id: vec3<u32>) {
    let added = inputs[id.x];
    let before = atomicAdd(&counters[0], added);
    if before + added < before {
        atomicAdd(&counters[1], 1u);
    }
    atomicAdd(&counters[2], 1u);
}

// Four floats.
fn row_at(place: u32) -> vec4<f32> {
    let first = 4u * place;
    return bitcast<vec4<f32>>(vec4(inputs[first], inputs[first + 1u], inputs[first + 2u], inputs[first + 3u]));
}

// Quotient, square root, a·b − c·d and a product, of four floats each, as the device does them.
@compute @workgroup_size(64)
fn rounding(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = row_at(id.x);
    outputs[4u * id.x] = bitcast<u32>(row.x / row.y);
    outputs[4u * id.x + 1u] = bitcast<u32>(sqrt(row.x));
    outputs[4u * id.x + 2u] = bitcast<u32>(row.x * row.y - row.z * row.w);
    outputs[4u * id.x + 3u] = bitcast<u32>(row.x * 1e-30);
}

// The same but the product, as kernels write them where it matters.
@compute @workgroup_size(64)
fn kernel_rounding(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = row_at(id.x);
    outputs[4u * id.x] = bitcast<u32>(quotient(row.x, row.y));
    outputs[4u * id.x + 1u] = bitcast<u32>(root(row.x));
    outputs[4u * id.x + 2u] = bitcast<u32>(rounded(row.x * row.y) - rounded(row.z * row.w));
}
