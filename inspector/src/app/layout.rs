//! Where panels are at first, and which of them a tile shows.

use egui_tiles::{Container, Tile, TileId, Tiles, Tree};

use crate::panels::PANELS;

/// A tile: the name of the panel that it shows.
pub(super) type Pane = String;

/// Panels that share a place: in the middle, below it, to the right, and below that. A panel that is not among them
/// is with the last.
const TABS: [&[&str]; 4] = [
    &["scene"],
    &["rays", "ray", "problems"],
    &["methods"],
    &["pixels", "coherence", "timings", "length-table", "what-if"],
];

/// The scene in the middle, numbers to its right.
pub(super) fn at_first() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut names = TABS.map(<[&str]>::to_vec);
    let others = PANELS.iter().map(|entry| entry.name).filter(|name| !TABS.concat().contains(name));
    names[TABS.len() - 1].extend(others);
    let tabs = names.map(|names| {
        let panes = names.into_iter().map(|name| tiles.insert_pane(name.to_owned())).collect();
        tiles.insert_tab_tile(panes)
    });
    let [middle, right] = [0, 2].map(|first| tiles.insert_vertical_tile(tabs[first..first + 2].to_vec()));
    let root = tiles.insert_horizontal_tile(vec![middle, right]);
    share(&mut tiles, root, &[(middle, 1.5), (right, 1.0)]);
    share(&mut tiles, middle, &[(tabs[0], 2.4), (tabs[1], 1.0)]);
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
    let is_known = |tile: &Tile<Pane>| match tile {
        Tile::Pane(name) => PANELS.iter().any(|entry| entry.name == name),
        Tile::Container(_) => true,
    };
    kept.filter(|tree| PANELS.iter().all(|entry| tree.tiles.find_pane(&entry.name.to_owned()).is_some()))
        .filter(|tree| tree.tiles.tiles().all(is_known))
}

pub(super) fn bring_forward(tree: &mut Tree<Pane>, panel: &str) {
    tree.make_active(|_, tile| matches!(tile, Tile::Pane(name) if name == panel));
}
