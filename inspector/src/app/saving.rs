//! Pictures and data of panels, into files.

use std::path::Path;
use std::sync::PoisonError;

use super::App;
use super::screenshot::{Slot, write};
use crate::output::sentence;
use crate::panels::data::Data;

impl App {
    /// Asks for the picture, and writes it once it is there.
    pub(super) fn take_screenshot(&mut self, ui: &egui::Ui) {
        let Some(screenshot) = &mut self.screenshot else { return };
        self.context.is_bare = screenshot.panel.is_some();
        ui.ctx().request_repaint();
        if screenshot.frames_before > 0 {
            screenshot.frames_before -= 1;
            return;
        }
        let Some(slot) = &screenshot.taken else {
            let slot = Slot::default();
            screenshot.taken = Some(slot.clone());
            let window = ui.ctx().clone();
            ui.ctx().request_screenshot(move |image| {
                *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
                window.request_repaint();
            });
            return;
        };
        let Some(image) = slot.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        let rect = screenshot.panel.and_then(|panel| self.places.get(panel)).copied();
        let written = write(&image, rect, ui.ctx().pixels_per_point(), &screenshot.path);
        (self.screenshot, self.context.is_bare) = (None, false);
        if let Err(error) = written {
            self.problem("the picture cannot be saved", sentence(&error));
        }
    }

    fn data(&mut self, panel: &'static str) -> Option<Data> {
        match self.panels.get_mut(panel)?.data(&mut self.context) {
            Ok(data) => Some(data),
            Err(why) => {
                self.problem(format!("there is no data of panel {panel}"), why);
                None
            }
        }
    }

    pub(super) fn save_data(&mut self, panel: &'static str, path: &Path) {
        let Some(data) = self.data(panel) else { return };
        if let Err(error) = data.write_csv(path) {
            self.problem("the data cannot be saved", error);
        }
    }

    pub(super) fn copy_data(&mut self, panel: &'static str, window: &egui::Context) {
        if let Some(data) = self.data(panel) {
            window.copy_text(data.text());
        }
    }
}
