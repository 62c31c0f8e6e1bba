// Lanes of a subgroup of any size, a bit each.

alias Lanes = vec4<u32>;

fn ballot(is_in: bool) -> Lanes {
    return subgroupBallot(is_in);
}

// Those below this one.
fn lanes_below(lane: u32) -> Lanes {
    let word = vec4<u32>(0u, 1u, 2u, 3u);
    let part = vec4<u32>((1u << (lane % 32u)) - 1u);
    let full = vec4<u32>(0xffffffffu);
    return select(select(vec4<u32>(0u), part, word == vec4<u32>(lane / 32u)), full, word < vec4<u32>(lane / 32u));
}

fn count_lanes(lanes: Lanes) -> u32 {
    let ones = countOneBits(lanes);
    return ones.x + ones.y + ones.z + ones.w;
}

fn first_lane(lanes: Lanes) -> u32 {
    if lanes.x != 0u { return countTrailingZeros(lanes.x); }
    if lanes.y != 0u { return 32u + countTrailingZeros(lanes.y); }
    if lanes.z != 0u { return 64u + countTrailingZeros(lanes.z); }
    return 96u + countTrailingZeros(lanes.w);
}
