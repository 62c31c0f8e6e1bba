// Copies both halves of each ray into a sorted order.

fn run_item(place: u32) {
    let index = order[place];
    gathered_origins[place] = origins[index];
    gathered_directions[place] = directions[index];
}
