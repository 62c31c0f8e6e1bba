// Traversal of the binary hierarchy: the same on threads is `stages::trace::cpu_bvh2`.

fn bvh2_near(query: ptr<function, Query>, low: vec3<f32>, high: vec3<f32>) -> vec2<f32> {
    let a = (low - (*query).origin) * (*query).inverse;
    let b = (high - (*query).origin) * (*query).inverse;
    let near = min(a, b);
    let far = max(a, b);
    // x: where the ray enters, y: where it leaves.
    return vec2(
        max(max(max((*query).t_min, near.x), near.y), near.z),
        min(min(far.x, far.y), far.z) * PADDING,
    );
}

// First leaf slot or child in the low 28 bits, number of triangles above.
fn bvh2_reference(low: vec4<u32>, high: vec4<u32>) -> u32 {
    return (low.w << 28u) | high.w;
}

// No reference: leaves end before the last slot that one can name.
const BVH2_NOTHING = 0xffffffffu;

// References that wait, and where the ray enters them.
struct Waiting {
    entries: array<vec2<u32>, BVH2_STACK>,
    count: u32,
}

// The next one that is not beyond the hit.
fn bvh2_next(waiting: ptr<function, Waiting>, query: ptr<function, Query>) -> u32 {
    let limit = query_limit(query);
    while (*waiting).count != 0u {
        (*waiting).count -= 1u;
        let entry = (*waiting).entries[(*waiting).count];
        if ANY || bitcast<f32>(entry.y) <= limit {
            return entry.x;
        }
    }
    return BVH2_NOTHING;
}

// Lanes search for leaves together and test triangles together: see Aila and Laine 2009, "while-while".
fn traverse(query: ptr<function, Query>) {
    var waiting: Waiting;
    var current = bvh2_reference(nodes[0], nodes[1]);
    while current != BVH2_NOTHING {
        while (current >> 28u) == 0u {
            if COUNT {
                (*query).work.x += 1u;
            }
            let low_0 = nodes[2u * current];
            let high_0 = nodes[2u * current + 1u];
            let low_1 = nodes[2u * current + 2u];
            let high_1 = nodes[2u * current + 3u];
            let limit = query_limit(query);
            let slab_0 = bvh2_near(query, bitcast<vec3<f32>>(low_0.xyz), bitcast<vec3<f32>>(high_0.xyz));
            let slab_1 = bvh2_near(query, bitcast<vec3<f32>>(low_1.xyz), bitcast<vec3<f32>>(high_1.xyz));
            let is_hit_0 = slab_0.x <= min(slab_0.y, limit);
            let is_hit_1 = slab_1.x <= min(slab_1.y, limit);
            let child_0 = bvh2_reference(low_0, high_0);
            let child_1 = bvh2_reference(low_1, high_1);
            if is_hit_0 && is_hit_1 {
                let second_is_nearer = slab_1.x < slab_0.x;
                waiting.entries[waiting.count] = vec2(
                    select(child_1, child_0, second_is_nearer),
                    bitcast<u32>(select(slab_1.x, slab_0.x, second_is_nearer)),
                );
                waiting.count += 1u;
                current = select(child_0, child_1, second_is_nearer);
            } else if is_hit_0 || is_hit_1 {
                current = select(child_1, child_0, is_hit_0);
            } else {
                current = bvh2_next(&waiting, query);
            }
        }
        let first = current & 0x0fffffffu;
        let count = select(current >> 28u, 0u, current == BVH2_NOTHING);
        for (var slot = first; slot < first + count; slot++) {
            if query_test(query, slot) {
                return;
            }
        }
        current = bvh2_next(&waiting, query);
    }
}
