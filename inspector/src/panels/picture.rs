//! A picture of numbers: made once for each thing that it shows, by another thread, drawn as large as fits.

use std::sync::Arc;

use egui::{Color32, ColorImage, Pos2, Rect, Sense, TextureHandle, TextureOptions, vec2};

use crate::model::background::{Background, Waker};

/// A picture that stays the same as long as its key does.
pub(super) struct Picture<Key> {
    making: Background<Key, Arc<ColorImage>, 1>,
    made: Option<(Key, TextureHandle)>,
}

impl<Key> Default for Picture<Key> {
    fn default() -> Self {
        Self { making: Background::default(), made: None }
    }
}

/// A picture as it was drawn.
pub(super) struct DrawnPicture {
    /// What was done to it.
    pub(super) response: egui::Response,
    /// Where it is.
    pub(super) rect: Rect,
    /// The pixel under the pointer: column and row.
    pub(super) pixel: Option<[u32; 2]>,
    size: [usize; 2],
}

impl DrawnPicture {
    pub(super) fn rect_of(&self, [column, row]: [u32; 2]) -> Rect {
        let step = self.rect.size() / vec2(self.size[0] as f32, self.size[1] as f32);
        Rect::from_min_size(self.rect.min + vec2(column as f32, row as f32) * step, step)
    }
}

impl<Key: PartialEq + Clone> Picture<Key> {
    /// Draws the picture of `key`, which `pixels` makes if it was another one before.
    pub(super) fn show(
        &mut self,
        ui: &mut egui::Ui,
        waker: &Waker,
        (name, key): (&str, Key),
        size: [usize; 2],
        pixels: impl FnOnce() -> Vec<Color32> + Send + 'static,
    ) -> DrawnPicture {
        if self.made.as_ref().is_none_or(|(known, _)| *known != key) {
            let make = move || Arc::new(ColorImage::new(size, pixels()));
            self.made = self.making.of(key.clone(), waker, make).ok().map(|image| {
                let options =
                    TextureOptions { minification: egui::TextureFilter::Linear, ..TextureOptions::NEAREST };
                (key, ui.ctx().load_texture(name, image.clone(), options))
            });
        }
        let available = ui.available_size().max(vec2(32.0, 32.0));
        let (width, height) = (size[0].max(1) as f32, size[1].max(1) as f32);
        let scale = (available.x / width).min(available.y / height);
        let (rect, response) = ui.allocate_exact_size(vec2(width, height) * scale, Sense::click());
        if let Some((_, texture)) = &self.made {
            let all = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter().image(texture.id(), rect, all, crate::theme::UNTINTED);
        } else {
            ui.put(rect, egui::Spinner::new());
        }
        let pixel = response.hover_pos().or(response.interact_pointer_pos()).map(|at| {
            let part = (at - rect.min) / rect.size();
            let place =
                |part: f32, size: usize| (part.clamp(0.0, 1.0) * size as f32).min(size as f32 - 1.0) as u32;
            [place(part.x, size[0]), place(part.y, size[1])]
        });
        DrawnPicture { response, rect, pixel, size }
    }
}
