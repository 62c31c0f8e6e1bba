// Which candidates of a queue live: those whose t_max is not 0, by its bits.

fn is_live(item: u32) -> bool {
    return bitcast<u32>(directions[item].w) != 0u;
}
