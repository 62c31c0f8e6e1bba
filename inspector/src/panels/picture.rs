//! A picture of numbers: made once for each thing that it shows, by another thread, drawn as large as fits with what
//! its colours stand for. The wheel enlarges it, dragging moves it, a double click shows all of it.

use std::sync::Arc;

use egui::{Color32, ColorImage, Pos2, Rect, Sense, TextureHandle, TextureOptions, vec2};

use super::colour_bar::ColourBar;
use crate::colour_map::ColourMap;
use crate::model::background::{Background, Waker};
use crate::render::range::{ValueRange, Values};

/// All of a picture.
const ALL: Rect = Rect { min: Pos2::ZERO, max: Pos2::new(1.0, 1.0) };
/// The least part of it that is shown.
const LEAST: f32 = 1.0 / 64.0;

/// What a picture is made of.
pub(super) struct Painted {
    /// Row by row.
    pub(super) pixels: Vec<Color32>,
    /// The numbers that are told apart by colours.
    pub(super) range: ValueRange,
    /// All of them.
    pub(super) values: Values,
}

type Made = (Arc<ColorImage>, ValueRange, Arc<Values>);

/// A picture that stays the same as long as its key does.
pub(super) struct Picture<Key> {
    making: Background<Key, Made, 1>,
    made: Option<(Key, TextureHandle, Made)>,
    /// The part of it that is shown.
    part: Rect,
}

impl<Key> Default for Picture<Key> {
    fn default() -> Self {
        Self { making: Background::default(), made: None, part: ALL }
    }
}

/// A picture as it was drawn.
pub(super) struct DrawnPicture {
    /// What was done to it.
    pub(super) response: egui::Response,
    /// Where it is, and what is outside of it is not painted.
    pub(super) painter: egui::Painter,
    /// The pixel under the pointer: column and row.
    pub(super) pixel: Option<[u32; 2]>,
    /// Where all of it would be.
    all: Rect,
    size: [usize; 2],
}

impl DrawnPicture {
    pub(super) fn rect_of(&self, [column, row]: [u32; 2]) -> Rect {
        let step = self.all.size() / vec2(self.size[0] as f32, self.size[1] as f32);
        Rect::from_min_size(self.all.min + vec2(column as f32, row as f32) * step, step)
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
        paint: impl FnOnce() -> Painted + Send + 'static,
    ) -> DrawnPicture {
        if self.made.as_ref().is_none_or(|(known, ..)| *known != key) {
            let make = move || {
                let Painted { pixels, range, values } = paint();
                (Arc::new(ColorImage::new(size, pixels)), range, Arc::new(values))
            };
            self.made = self.making.of(key.clone(), waker, make).ok().map(|made| {
                let options =
                    TextureOptions { minification: egui::TextureFilter::Linear, ..TextureOptions::NEAREST };
                (key, ui.ctx().load_texture(name, made.0.clone(), options), made.clone())
            });
        }
        let available = ui.available_size().max(vec2(32.0, 32.0));
        let (width, height) = (size[0].max(1) as f32, size[1].max(1) as f32);
        let scale = (available.x / width).min(available.y / height);
        let (rect, response) = ui.allocate_exact_size(vec2(width, height) * scale, Sense::click_and_drag());
        self.take_pointer(ui, &response);
        if let Some((_, texture, _)) = &self.made {
            ui.painter().image(texture.id(), rect, self.part, crate::theme::UNTINTED);
        } else {
            ui.put(rect, egui::Spinner::new());
        }
        let all = Rect::from_min_size(
            rect.min - self.part.min.to_vec2() * rect.size() / self.part.size(),
            rect.size() / self.part.size(),
        );
        let pixel = response.hover_pos().or(response.interact_pointer_pos()).map(|at| {
            let part = (at - all.min) / all.size();
            let place =
                |part: f32, size: usize| (part.clamp(0.0, 1.0) * size as f32).min(size as f32 - 1.0) as u32;
            [place(part.x, size[0]), place(part.y, size[1])]
        });
        DrawnPicture { response, painter: ui.painter_at(rect), pixel, all, size }
    }

    fn take_pointer(&mut self, ui: &egui::Ui, response: &egui::Response) {
        let (rect, shown) = (response.rect, self.part.size());
        if response.double_clicked() {
            self.part = ALL;
        } else if let Some(at) = response.hover_pos() {
            let scroll = ui.input(|input| input.smooth_scroll_delta.y);
            let size = (shown * (-0.003 * scroll).exp()).clamp(egui::Vec2::splat(LEAST), ALL.max.to_vec2());
            // What is under the pointer stays there.
            let moved =
                (at - rect.min) / rect.size() * (shown - size) - response.drag_delta() / rect.size() * size;
            let first = (self.part.min + moved).clamp(Pos2::ZERO, Pos2::ZERO + (ALL.max.to_vec2() - size));
            self.part = Rect::from_min_size(first, size);
        }
    }

    /// What its colours stand for, and the range of that, once it is made.
    pub(super) fn legend(
        &self,
        ui: &mut egui::Ui,
        map: ColourMap,
        logarithm: Option<f32>,
        title: &str,
    ) -> Option<(egui::Response, ValueRange)> {
        let (.., (_, range, values)) = self.made.as_ref()?;
        let bar = ColourBar { range: *range, map, logarithm, title, values: Some(&**values) };
        Some((bar.show(ui, ui.available_width(), *range), *range))
    }
}
