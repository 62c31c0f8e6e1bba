// Moves the live candidates of a queue together, in canonical order. `move_item` says what moves.

fn run_item(index: u32) {
    if is_live(index) {
        move_item(index, places[index]);
    }
}
