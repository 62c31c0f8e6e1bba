//! The scene with rays, the curve of their order, capsules and table cells.

use super::notes::hint;
use super::space::{SpaceView, ViewSetup};
use crate::model::Context;
use crate::panels::data::Data;
use crate::panels::panel::Panel;

pub(super) struct Scene {
    view: SpaceView,
}

impl Scene {
    pub(super) fn new(setup: &ViewSetup) -> Self {
        Self { view: SpaceView::new(setup) }
    }
}

impl Panel for Scene {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        if context.recording().is_none() {
            return hint(ui, "no recording is open");
        }
        self.view.controls(ui, context);
        let room = ui.available_size() - egui::vec2(0.0, SpaceView::slider_height(ui));
        self.view.picture(ui, context, room);
        self.view.slider(ui);
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        self.view.data(context)
    }

    fn state(&self) -> serde_json::Value {
        serde_json::to_value(self.view.kept()).unwrap_or_default()
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        self.view.set_state(serde_json::from_value(state)?);
        Ok(())
    }

    fn space(&mut self) -> Option<&mut SpaceView> {
        Some(&mut self.view)
    }
}
