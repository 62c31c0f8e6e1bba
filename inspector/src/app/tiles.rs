//! Panels as tiles show them, each with a menu of what can be saved of it.

use std::collections::BTreeMap;

use egui_tiles::{Tabs, Tile, TileId, Tiles, UiResponse};

use super::ask::Asking;
use super::layout::Pane;
use super::{Panels, Task};
use crate::figures::catalogue::CATALOGUE;
use crate::model::Context;
use crate::panels::{self, PanelKind};

/// What can be done with a panel of this name: what it is called, and what it is.
type PanelTask = (fn(&'static str) -> Task, &'static str, &'static str);

const TASKS: [PanelTask; 4] = [
    (
        |panel| Task::Ask(Asking::SavePicture(Some(panel))),
        "Save picture...",
        "This panel as it is on the screen, as a PNG",
    ),
    (|panel| Task::Ask(Asking::SaveData(panel)), "Save data...", "The numbers behind this panel, as CSV"),
    (Task::CopyData, "Copy data", "The numbers behind this panel as text, to be pasted into a table"),
    (
        |panel| Task::Ask(Asking::SaveCommand(panel)),
        "Show command...",
        "Saves the session, and gives the command that draws this panel of it without a window",
    ),
];

pub(super) struct PanelTiles<'a> {
    pub(super) panels: &'a mut Panels,
    pub(super) context: &'a mut Context,
    /// Where panels were drawn, by their names.
    pub(super) places: &'a mut BTreeMap<&'static str, egui::Rect>,
    pub(super) task: &'a mut Option<Task>,
}

impl PanelTiles<'_> {
    /// Figures for a paper, of all that is open.
    fn figures(&mut self, ui: &mut egui::Ui, names: &[&str]) {
        for figure in CATALOGUE.iter().filter(|figure| names.contains(&figure.name)) {
            if ui.button(format!("{}...", figure.name)).on_hover_text(figure.description).clicked() {
                *self.task = Some(Task::Ask(Asking::ExportFigure(figure.name)));
                ui.close();
            }
        }
    }
}

impl egui_tiles::Behavior<Pane> for PanelTiles<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        let Some(PanelKind { name, .. }) = panels::of_name(pane) else { return UiResponse::None };
        self.places.insert(name, ui.max_rect());
        if let Some(panel) = self.panels.get_mut(name) {
            egui::Frame::new().inner_margin(6.0).show(ui, |ui| {
                ui.set_clip_rect(ui.max_rect().expand(4.0).intersect(ui.clip_rect()));
                panel.show(ui, self.context);
            });
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        panels::of_name(pane).map_or("", |panel| panel.title).into()
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
        let Some(panel) = panels::of_name(pane) else { return };
        ui.add_space(4.0);
        let menu = ui.menu_button("...", |ui| {
            for (task, name, about) in TASKS {
                if ui.button(name).on_hover_text(about).clicked() {
                    *self.task = Some(task(panel.name));
                    ui.close();
                }
            }
            if !panel.figures.is_empty() {
                ui.menu_button("Export figure", |ui| self.figures(ui, panel.figures));
            }
        });
        menu.response.on_hover_text(format!("Save or copy {}", panel.title));
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}
