//! Panels as tiles show them, each with a menu of what can be saved of it.

use std::collections::BTreeMap;

use egui_tiles::{Tabs, Tile, TileId, Tiles, UiResponse};

use super::layout::{Pane, place};
use crate::model::Context;
use crate::panels::{PANELS, Panel};

/// What was asked of a panel, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    SavePicture,
    SaveData,
    CopyData,
    ShowCommand,
}

const WISHES: [(Wish, &str, &str); 4] = [
    (Wish::SavePicture, "Save picture...", "This panel as it is on the screen, as a PNG"),
    (Wish::SaveData, "Save data...", "The numbers behind this panel, as CSV"),
    (Wish::CopyData, "Copy data", "The numbers behind this panel as text, to be pasted into a table"),
    (
        Wish::ShowCommand,
        "Show command...",
        "Saves the session, and gives the command that draws this panel of it without a window",
    ),
];

pub(super) struct PanelTiles<'a> {
    pub(super) panels: &'a mut [Box<dyn Panel>],
    pub(super) context: &'a mut Context,
    /// Where panels were drawn, by their names.
    pub(super) places: &'a mut BTreeMap<&'static str, egui::Rect>,
    pub(super) wish: &'a mut Option<(&'static str, Wish)>,
}

impl egui_tiles::Behavior<Pane> for PanelTiles<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        let Some(at) = place(pane) else { return UiResponse::None };
        self.places.insert(PANELS[at].name, ui.max_rect());
        if let Some(panel) = self.panels.get_mut(at) {
            egui::Frame::new().inner_margin(6.0).show(ui, |ui| {
                ui.set_clip_rect(ui.max_rect().expand(4.0).intersect(ui.clip_rect()));
                panel.show(ui, self.context);
            });
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        place(pane).and_then(|at| self.panels.get(at)).map_or("", |panel| panel.title()).into()
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<Pane>,
        ui: &mut egui::Ui,
        _tile: TileId,
        tabs: &Tabs,
        _scroll_offset: &mut f32,
    ) {
        let Some(Tile::Pane(pane)) = tabs.active.and_then(|tile| tiles.get(tile)) else { return };
        let Some(at) = place(pane) else { return };
        ui.add_space(4.0);
        let menu = ui.menu_button("...", |ui| {
            for (wish, name, about) in WISHES {
                if ui.button(name).on_hover_text(about).clicked() {
                    *self.wish = Some((PANELS[at].name, wish));
                    ui.close();
                }
            }
        });
        menu.response.on_hover_text(format!("Save or copy {}", self.panels[at].title()));
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}
