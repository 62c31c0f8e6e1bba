//! Pictures of the window and of its panels.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use egui::ColorImage;

use crate::png_file;

/// Frames until the menu that asked for a picture is gone from it.
const FRAMES_BEFORE: u32 = 3;

/// What the window system gives back, on any thread.
pub(super) type Slot = Arc<Mutex<Option<Arc<ColorImage>>>>;

/// A picture that is waited for.
pub(super) struct Screenshot {
    pub(super) panel: Option<&'static str>,
    pub(super) path: PathBuf,
    pub(super) frames_before: u32,
    pub(super) taken: Option<Slot>,
}

impl Screenshot {
    pub(super) fn of(panel: Option<&'static str>, path: PathBuf) -> Self {
        Self { panel, path, frames_before: FRAMES_BEFORE, taken: None }
    }
}

/// Writes a part of a picture of the window, points; all of it if `None`.
pub(super) fn write(
    image: &ColorImage,
    rect: Option<egui::Rect>,
    scale: f32,
    path: &Path,
) -> anyhow::Result<()> {
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
