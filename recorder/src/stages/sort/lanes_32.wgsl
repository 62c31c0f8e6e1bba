// Lanes of a subgroup of at most 32, a bit each.

alias Lanes = u32;

fn ballot(is_in: bool) -> Lanes {
    return subgroupBallot(is_in).x;
}

// Those below this one.
fn lanes_below(lane: u32) -> Lanes {
    return (1u << lane) - 1u;
}

fn count_lanes(lanes: Lanes) -> u32 {
    return countOneBits(lanes);
}

fn first_lane(lanes: Lanes) -> u32 {
    return countTrailingZeros(lanes);
}
