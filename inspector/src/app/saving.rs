//! Pictures and data of panels, into files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use egui::ColorImage;

use super::App;
use super::layout::place;
use crate::output::sentence;
use crate::panels::data::Data;
use crate::png_file;

/// Frames until the menu that asked for a picture is gone from it.
const FRAMES_BEFORE: u32 = 3;

/// What the window system gives back, on whatever thread.
type Slot = Arc<Mutex<Option<Arc<ColorImage>>>>;

/// A picture that is waited for.
pub(super) struct Picture {
    panel: Option<&'static str>,
    path: PathBuf,
    frames_before: u32,
    taken: Option<Slot>,
}

impl Picture {
    pub(super) fn of(panel: Option<&'static str>, path: PathBuf) -> Self {
        Self { panel, path, frames_before: FRAMES_BEFORE, taken: None }
    }
}

impl App {
    /// Asks for the picture, and writes it once it is there.
    pub(super) fn take_picture(&mut self, ui: &egui::Ui) {
        let Some(picture) = &mut self.picture else { return };
        ui.ctx().request_repaint();
        if picture.frames_before > 0 {
            picture.frames_before -= 1;
            return;
        }
        let Some(slot) = &picture.taken else {
            let slot = Slot::default();
            picture.taken = Some(slot.clone());
            let window = ui.ctx().clone();
            ui.ctx().request_screenshot(move |image| {
                *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
                window.request_repaint();
            });
            return;
        };
        let Some(image) = slot.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        let rect = picture.panel.and_then(|panel| self.places.get(panel)).copied();
        let written = write(&image, rect, ui.ctx().pixels_per_point(), &picture.path);
        self.picture = None;
        if let Err(error) = written {
            self.problem("the picture cannot be saved", sentence(&error));
        }
    }

    fn data(&mut self, panel: &'static str) -> Option<Data> {
        let found = place(panel).and_then(|at| self.panels.get_mut(at))?;
        match found.data(&mut self.context) {
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

fn write(image: &ColorImage, rect: Option<egui::Rect>, scale: f32, path: &Path) -> anyhow::Result<()> {
    let all = egui::Rect::from_min_size(
        egui::Pos2::ZERO,
        egui::vec2(image.width() as f32, image.height() as f32) / scale,
    );
    let image = image.region(&rect.map_or(all, |rect| rect.intersect(all)), Some(scale));
    let [width, height] = image.size.map(|side| side as u32);
    let rgba: Vec<u8> = image.pixels.iter().flat_map(egui::Color32::to_array).collect();
    png_file::write(path, [width, height], &rgba)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_a_panel_is_its_part_of_the_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("panel.png");
        let mut image = ColorImage::filled([40, 20], egui::Color32::BLACK);
        image[(20, 10)] = egui::Color32::WHITE;
        let rect = egui::Rect::from_min_size(egui::pos2(10.0, 5.0), egui::vec2(5.0, 40.0));
        write(&image, Some(rect), 2.0, &path).unwrap();
        let mut reader = png::Decoder::new(std::fs::File::open(&path).unwrap()).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (10, 10));
        assert_eq!(pixels.iter().position(|&part| part == 255), Some(0));
        assert_eq!(pixels.iter().filter(|&&part| part == 255).count(), 3);
    }
}
