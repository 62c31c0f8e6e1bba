//! Where panels are at first, and which of them a tile shows.

use egui_tiles::{Container, Tile, TileId, Tiles, Tree};

use crate::panels::PANELS;

/// A tile: the name of the panel that it shows.
pub(super) type Pane = String;

/// The scene in the middle, numbers to its right.
pub(super) fn at_first() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut pane = |name: &str| tiles.insert_pane(name.to_owned());
    let [navigator, problems] = ["navigator", "problems"].map(&mut pane);
    let pictures = ["order", "table"].map(&mut pane);
    let numbers = ["coherence", "what-if", "timings"].map(&mut pane);
    let rays = ["ray", "rays"].map(&mut pane);
    let scenes = ["scene", "compare"].map(&mut pane);
    let tabs = |tiles: &mut Tiles<Pane>, of: &[TileId]| tiles.insert_tab_tile(of.to_vec());
    let left_parts = [tabs(&mut tiles, &[navigator]), tabs(&mut tiles, &[rays[0], problems])];
    let left = tiles.insert_vertical_tile(left_parts.to_vec());
    let middle_parts = [tabs(&mut tiles, &scenes), tabs(&mut tiles, &[rays[1]])];
    let middle = tiles.insert_vertical_tile(middle_parts.to_vec());
    let right = [tabs(&mut tiles, &pictures), tabs(&mut tiles, &numbers)];
    let right = tiles.insert_vertical_tile(right.to_vec());
    let root = tiles.insert_horizontal_tile(vec![left, middle, right]);
    share(&mut tiles, root, &[(left, 0.66), (middle, 1.5), (right, 1.1)]);
    share(&mut tiles, left, &[(left_parts[0], 1.5), (left_parts[1], 1.0)]);
    share(&mut tiles, middle, &[(middle_parts[0], 2.2), (middle_parts[1], 1.0)]);
    Tree::new(egui::Id::unique("tiles"), root, tiles)
}

fn share(tiles: &mut Tiles<Pane>, container: TileId, shares: &[(TileId, f32)]) {
    if let Some(Tile::Container(Container::Linear(linear))) = tiles.get_mut(container) {
        for (tile, share) in shares {
            linear.shares.set_share(*tile, *share);
        }
    }
}

/// A layout of an earlier run, unless that one had other panels.
pub(super) fn of_all_panels(kept: Option<Tree<Pane>>) -> Option<Tree<Pane>> {
    kept.filter(|tree| PANELS.iter().all(|entry| tree.tiles.find_pane(&entry.name.to_owned()).is_some()))
}

/// Brings a panel to the front of its tabs.
pub(super) fn bring_forward(tree: &mut Tree<Pane>, panel: &str) {
    tree.make_active(|_, tile| matches!(tile, Tile::Pane(name) if name == panel));
}

/// Place of a panel in [`PANELS`].
pub(super) fn place(name: &str) -> Option<usize> {
    PANELS.iter().position(|entry| entry.name == name)
}
