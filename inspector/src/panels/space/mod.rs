//! The scene in space, with rays, the curve of their order, capsules and table cells: what panels show it with.
//!
//! - [`options`]: what is shown, and how
//! - [`layers`]: from a selection to vertices, made anew only when it changes; `places`: of which places
//! - [`meshes`]: surfaces, read once for all views
//! - `view`: a view, and the frame that comes of it
//! - `controls`: the row above the picture; `bars`: the slider and the colour bars below
//! - `input`: pointer and keys

mod bars;
mod controls;
mod input;
pub mod layers;
pub mod meshes;
pub mod options;
mod places;
mod view;

use std::sync::Arc;

use egui::Sense;

use super::filter_box;
use crate::model::{Absent, Context};
use crate::render::gpu::FrameCallback;
use crate::theme::Theme;

pub(super) use self::view::SpaceState;
pub use self::view::{SpaceView, ViewSetup, cut};

impl SpaceView {
    /// What is shown, to be changed.
    pub(super) fn controls(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        controls::above(ui, self, context);
    }

    /// The picture with the slider and the colour bar below it, in all the room that there is.
    pub(super) fn picture_and_slider(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let below = bars::height_below(ui);
        self.picture(ui, context, ui.available_size() - egui::vec2(0.0, below));
        bars::below(ui, self);
    }

    /// The picture alone. Pointer and keys move the camera and choose rays.
    pub(super) fn picture(&mut self, ui: &mut egui::Ui, context: &mut Context, size: egui::Vec2) {
        let (rect, response) =
            ui.allocate_exact_size(size.max(egui::vec2(16.0, 16.0)), Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        let pixels = [rect.width(), rect.height()].map(|side| (side * scale).round().max(1.0) as u32);
        input::take(ui, &response, self, context);
        if let Some(frame) = self.frame(Theme::of(ui.ctx()), pixels, context) {
            let refusal = (self.refusal.clone(), context.waker().clone());
            let (view, format, frame) = (self.view, self.format, Arc::new(frame));
            let callback = FrameCallback { view, format, frame, refusal };
            ui.painter().add(callback.shape(rect));
        }
        let text = self.showing();
        let filter = filter_box::problem(context).map(|error| Absent::from(format!("filter: {error}")));
        let refused = self.refusal.reason().map(|reason| Absent::from(format!("not all is drawn: {reason}")));
        let problems = [self.layers.problem(), self.mesh_problem.as_ref(), filter.as_ref(), refused.as_ref()];
        controls::overlay(ui, rect, &text, &problems.into_iter().flatten().collect::<Vec<_>>());
    }

    /// The slider along the order and the colour bar.
    pub(super) fn slider(&mut self, ui: &mut egui::Ui) {
        bars::below(ui, self);
    }

    /// Height of the slider and the colour bar.
    pub(super) fn slider_height(ui: &egui::Ui) -> f32 {
        bars::height_below(ui)
    }
}
