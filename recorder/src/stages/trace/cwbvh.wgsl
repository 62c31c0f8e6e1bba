// Traversal of the compressed wide hierarchy: the same on threads is `stages::trace::cpu_cwbvh`.

struct WideRay {
    origin: vec3<f32>,
    inverse: vec3<f32>,
}

fn planes(word: u32, origin: f32, inverse: f32) -> vec4<f32> {
    return (vec4<f32>(unpack4xU8(word)) - origin) * inverse;
}

// Bits of four boxes that the ray enters before `limit`; `near` and `far` are quantised planes by axis.
fn enter_four(ray: WideRay, t_min: f32, limit: f32, near: vec3<u32>, far: vec3<u32>) -> u32 {
    let enters = max(
        max(planes(near.x, ray.origin.x, ray.inverse.x), planes(near.y, ray.origin.y, ray.inverse.y)),
        max(planes(near.z, ray.origin.z, ray.inverse.z), vec4(t_min)),
    );
    let leaves = min(
        min(planes(far.x, ray.origin.x, ray.inverse.x), planes(far.y, ray.origin.y, ray.inverse.y)),
        planes(far.z, ray.origin.z, ray.inverse.z),
    ) * PADDING;
    let bits = select(vec4(0u), vec4(1u, 2u, 4u, 8u), enters <= min(leaves, vec4(limit)));
    return bits.x | bits.y | bits.z | bits.w;
}

// One bit per triangle of the four children in `hits`, which are leaves.
fn leaf_triangles(meta_bytes: u32, hits: u32) -> u32 {
    let bytes = unpack4xU8(meta_bytes);
    let is_hit = (vec4(hits) & vec4(1u, 2u, 4u, 8u)) != vec4(0u);
    let bits = select(vec4(0u), (bytes >> vec4(5u)) << (bytes & vec4(31u)), is_hit);
    return bits.x | bits.y | bits.z | bits.w;
}

// Moves bit `slot` to bit `slot ^ octant`.
fn in_order(slots: u32, octant: u32) -> u32 {
    var s = slots;
    s = select(s, ((s >> 1u) & 0x55u) | ((s << 1u) & 0xaau), (octant & 1u) != 0u);
    s = select(s, ((s >> 2u) & 0x33u) | ((s << 2u) & 0xccu), (octant & 2u) != 0u);
    return select(s, ((s >> 4u) & 0x0fu) | ((s << 4u) & 0xf0u), (octant & 4u) != 0u);
}

fn traverse(query: ptr<function, Query>) {
    let inverse = (*query).inverse;
    let is_negative = inverse < vec3(0.0);
    let octant = select(4u, 0u, is_negative.x) | select(2u, 0u, is_negative.y) | select(1u, 0u, is_negative.z);
    var stack: array<vec2<u32>, CWBVH_STACK>;
    var waiting = 0u;
    var current = 0u;
    loop {
        if COUNT {
            (*query).work.x += 1u;
        }
        let head = nodes[5u * current];
        let links = nodes[5u * current + 1u];
        let x = nodes[5u * current + 2u];
        let y = nodes[5u * current + 3u];
        let z = nodes[5u * current + 4u];
        let exponents = vec3(head.w & 255u, (head.w >> 8u) & 255u, (head.w >> 16u) & 255u);
        let imask = head.w >> 24u;
        let steps = bitcast<vec3<f32>>((vec3(254u) - exponents) << vec3(23u));
        let step_size = bitcast<vec3<f32>>(exponents << vec3(23u));
        let ray = WideRay(((*query).origin - bitcast<vec3<f32>>(head.xyz)) * steps, inverse * step_size);
        let near_x = select(x.xy, x.zw, is_negative.x);
        let far_x = select(x.zw, x.xy, is_negative.x);
        let near_y = select(y.xy, y.zw, is_negative.y);
        let far_y = select(y.zw, y.xy, is_negative.y);
        let near_z = select(z.xy, z.zw, is_negative.z);
        let far_z = select(z.zw, z.xy, is_negative.z);
        let t_min = (*query).t_min;
        let limit = query_limit(query);
        let hits = enter_four(ray, t_min, limit, vec3(near_x.x, near_y.x, near_z.x), vec3(far_x.x, far_y.x, far_z.x))
            | (enter_four(ray, t_min, limit, vec3(near_x.y, near_y.y, near_z.y), vec3(far_x.y, far_y.y, far_z.y)) << 4u);
        let in_leaves = hits & ~imask;
        var rest = leaf_triangles(links.z, in_leaves) | leaf_triangles(links.w, in_leaves >> 4u);
        while rest != 0u {
            let offset = firstLeadingBit(rest);
            rest ^= 1u << offset;
            if query_test(query, links.y + offset) {
                return;
            }
        }
        var group = vec2(links.x, (in_order(hits & imask, octant) << 24u) | imask);
        if (group.y >> 24u) == 0u {
            if waiting == 0u {
                return;
            }
            waiting -= 1u;
            group = stack[waiting];
        }
        let place = firstLeadingBit(group.y);
        group.y ^= 1u << place;
        if (group.y >> 24u) != 0u {
            stack[waiting] = group;
            waiting += 1u;
        }
        let slot = (place - 24u) ^ octant;
        let below = group.y & ((1u << slot) - 1u) & 255u;
        current = group.x + countOneBits(below);
    }
}
