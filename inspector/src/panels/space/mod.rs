//! The scene in space, with rays, the curve of their order, capsules and table cells: what panels show it with.
//!
//! - [`options`]: what is shown, and how
//! - [`layers`]: from a selection to vertices, made anew only when it changes; `places`: of which places
//! - [`meshes`]: surfaces, read once for all views
//! - `view`: a view, and the picture that comes of it
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

use super::filter_box;
use crate::model::{Absent, Context};
use crate::render::gpu::PictureCallback;
use crate::theme::Theme;

pub(super) use self::view::{RATIOS, SpaceState};
pub use self::view::{SpaceView, ViewSetup, cut, room};

impl SpaceView {
    /// The picture alone. Pointer and keys move the camera and choose rays.
    pub(super) fn picture(&mut self, ui: &mut egui::Ui, context: &mut Context, size: egui::Vec2) {
        let size = size.max(egui::vec2(16.0, 16.0));
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        let pixels = [rect.width(), rect.height()].map(|side| (side * scale).round().max(1.0) as u32);
        input::take(ui, &response, self, context);
        if let Some(picture) = self.space_picture(Theme::of(ui.ctx()), pixels, context) {
            let refusal = (self.refusal.clone(), context.waker().clone());
            let (view, format, picture) = (self.view, self.format, Arc::new(picture));
            let callback = PictureCallback { view, format, picture, refusal };
            ui.painter().add(callback.shape(rect));
        }
        let filter = filter_box::said(context).map(|said| Absent::from(format!("filter: {said}")));
        let refused = self.refusal.reason().map(|reason| Absent::from(format!("not all is drawn: {reason}")));
        let drawn = [self.layers.problem.as_ref(), self.mesh_problem.as_ref()];
        let problems = drawn.into_iter().chain([filter.as_ref(), refused.as_ref()]).flatten();
        controls::overlay(ui, rect, &self.showing(), &problems.collect::<Vec<_>>());
    }
}
