//! The row above the picture, what is beside it, and what is written on it.

use egui::{FontId, Rect, Slider, Ui, vec2};
use formats::metrics::quantity::Quantity;

use super::super::filter_box::filter_box;
use super::options::{
    Axis, CapsuleChoice, MeshMode, Navigation, Side, SpaceOptions, StandPoint, VisitChoice,
};
use super::view::{SpaceView, stand};
use crate::colour_map::ColourMap;
use crate::model::colour_by::ColourBy;
use crate::model::{Absent, Context};
use crate::panels::notes::{Lacking, choose};
use crate::render::camera::Camera;
use crate::render::geometry::RayEnd;
use crate::theme::Theme;

/// Width of the filter, points.
const FILTER_WIDTH: f32 = 170.0;

impl SpaceView {
    /// Where it is seen from, and which rays are shown.
    pub(in crate::panels) fn controls(&mut self, ui: &mut Ui, context: &mut Context) {
        cameras(ui, self, context);
        filter_box(ui, context, FILTER_WIDTH);
    }

    /// What is shown and how, to be changed.
    pub(in crate::panels) fn properties(&mut self, ui: &mut Ui, context: &mut Context) {
        what_is_shown(ui, &mut self.options);
        ui.separator();
        colours(ui, &mut self.options, context);
        ui.separator();
        details(ui, &mut self.options);
        if let Some(camera) = &mut self.camera {
            ui.separator();
            typed(ui, camera);
        }
    }
}

fn what_is_shown(ui: &mut Ui, options: &mut SpaceOptions) {
    ui.checkbox(&mut options.curve, "Curve").on_hover_text("A line through the rays in their order");
    ui.checkbox(&mut options.rays, "Rays").on_hover_text("A line from each origin to where the ray ended");
    ui.checkbox(&mut options.ends, "Hit points").on_hover_text(
        "Where each ray ended: a disc at a surface, a ring where it hit nothing, a cross at an occluder",
    );
    ui.checkbox(&mut options.capsules, "Capsules of groups")
        .on_hover_text("The hull of a sphere around a group's origins and one around its ends");
    ui.checkbox(&mut options.cells, "Cells of the length table")
        .on_hover_text("Those that were touched, where their rays start, coloured by their mean length");
    ui.checkbox(&mut options.path, "Path of the selected ray")
        .on_hover_text("Its rays in all bounces; thin ones go to lights");
    if options.path {
        ui.checkbox(&mut options.path_group, "Paths of its whole group")
            .on_hover_text("Those of all rays that are traced together with it");
    }
    let visits =
        [(VisitChoice::Hidden, "none"), (VisitChoice::Ray, "the ray's"), (VisitChoice::Group, "its group's")];
    row(ui, "Boxes visited", &mut options.visits, &visits);
    if options.visits != VisitChoice::Hidden {
        ui.add(Slider::new(&mut options.visit_levels, 0..=32).text("levels below the root"));
    }
}

/// What colours stand for, and which ones.
fn colours(ui: &mut Ui, options: &mut SpaceOptions, context: &mut Context) {
    let fields = context.order().map_or(Vec::new(), |order| order.readable_fields());
    let fields = fields.into_iter().map(|(field, _)| ColourBy::Field(field));
    let choices = Quantity::ALL.iter().map(|&quantity| ColourBy::Quantity(quantity)).chain(fields);
    let choices = choices.map(|choice| (choice, choice.name(), Some(choice.title())));
    let now = format!("by {}", options.colour_by.name());
    if choose(ui, ("colour by", &now), &mut options.colour_by, choices) {
        // A range of other numbers says nothing of these.
        options.range = None;
    }
    ui.checkbox(&mut options.near_mean, "Mean over near rays")
        .on_hover_text("Of about ten that end near each other");
    let maps = ColourMap::ALL.map(|map| (map, map.name().to_owned(), None));
    choose(ui, ("colour map", options.map.name()), &mut options.map, maps);
}

fn cameras(ui: &mut Ui, view: &mut SpaceView, context: &Context) {
    let Some(recording) = context.recording() else { return };
    for (point, name, about) in [
        (StandPoint::Recorded, "Camera", "Where the recording's camera stood (C)"),
        (StandPoint::Overview, "Overview", "All of the scene, from outside (R)"),
    ] {
        if ui.button(name).on_hover_text(about).clicked() {
            view.place(context.selection.recording, stand(point, recording));
        }
    }
    let is_flying = view.options.navigation == Navigation::Fly;
    let toggle = ui.selectable_label(is_flying, "Fly");
    if toggle.on_hover_text("Dragging turns the head, W A S D Q E fly (G)").clicked() {
        view.options.navigation = if is_flying { Navigation::Orbit } else { Navigation::Fly };
    }
}

/// A camera as numbers.
fn typed(ui: &mut Ui, camera: &mut Camera) {
    ui.label("Camera, unit space").on_hover_text("The scene's largest side is 1");
    ui.add(egui::Label::new(egui::RichText::new(camera.to_string()).monospace()).wrap());
    if ui.button("Copy").on_hover_text("As `inspector shot --camera` takes it").clicked() {
        ui.ctx().copy_text(camera.to_string());
    }
    let mut text = String::new();
    let line = egui::TextEdit::singleline(&mut text).hint_text("paste a camera here").desired_width(140.0);
    if ui.add(line).changed()
        && let Ok(pasted) = text.parse()
    {
        *camera = pasted;
    }
}

fn row<T: PartialEq + Copy>(ui: &mut Ui, title: &str, chosen: &mut T, choices: &[(T, &str)]) {
    ui.horizontal_wrapped(|ui| {
        ui.label(title);
        for (choice, name) in choices {
            ui.selectable_value(chosen, *choice, *name);
        }
    });
}

fn details(ui: &mut Ui, options: &mut SpaceOptions) {
    let modes = [
        (MeshMode::Solid, "solid"),
        (MeshMode::Ghost, "see-through"),
        (MeshMode::Wire, "edges"),
        (MeshMode::Hidden, "hidden"),
    ];
    row(ui, "Surfaces", &mut options.mesh, &modes);
    ui.add(Slider::new(&mut options.ghost_opacity, 0.02..=1.0).text("opacity if see-through or edges"));
    row(ui, "Cut across", &mut options.clip_axis, &[(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")]);
    ui.add(Slider::new(&mut options.clip_at, 0.0..=1.0).text("cut at"))
        .on_hover_text("Part of the scene's extent along that axis");
    row(ui, "Keep", &mut options.clip_keeps, &[(Side::Below, "below"), (Side::Above, "above")]);
    ui.separator();
    row(
        ui,
        "Curve through",
        &mut options.curve_end,
        &[(RayEnd::Origin, "origins"), (RayEnd::Termination, "hit points")],
    );
    ui.checkbox(&mut options.arrows, "arrow heads on rays");
    ui.add(Slider::new(&mut options.detail, 2..=4_194_304).logarithmic(true).text("rays at most"));
    ui.add(Slider::new(&mut options.line_width, 0.5..=6.0).text("width of lines"));
    ui.add(Slider::new(&mut options.hidden_opacity, 0.0..=1.0).text("opacity of hidden lines"));
    ui.separator();
    let capsules = [
        (CapsuleChoice::Selected, "the selected group"),
        (CapsuleChoice::Worst, "the worst"),
        (CapsuleChoice::Spread, "some"),
    ];
    row(ui, "Capsules of", &mut options.capsule_choice, &capsules);
    ui.add(Slider::new(&mut options.capsule_count, 1..=2000).logarithmic(true).text("capsules at most"));
    ui.add(Slider::new(&mut options.capsule_opacity, 0.02..=1.0).text("opacity of capsules and cells"));
    ui.add(Slider::new(&mut options.cell_count, 1..=100_000).logarithmic(true).text("cells at most"));
    ui.separator();
    ui.label("Colours from and to these percentiles");
    ui.add(Slider::new(&mut options.percentiles.0, 0.0..=50.0).text("lowest"));
    ui.add(Slider::new(&mut options.percentiles.1, 50.0..=100.0).text("highest"));
}

/// Writes on the picture.
pub(super) fn overlay(ui: &Ui, rect: Rect, text: &str, problems: &[&Absent]) {
    let painter = ui.painter().with_clip_rect(rect);
    let write = |at, text: &str, colour| {
        let galley = painter.layout(text.to_owned(), FontId::proportional(12.5), colour, rect.width() - 16.0);
        let back = Rect::from_min_size(at, galley.size()).expand(3.0);
        painter.rect_filled(back, 3.0, ui.visuals().panel_fill.gamma_multiply(0.8));
        painter.galley(at, galley, colour);
    };
    write(rect.left_top() + vec2(8.0, 7.0), text, ui.visuals().text_color());
    let below = rect.left_top() + vec2(8.0, 29.0);
    let reasons = problems.iter().filter_map(|problem| match problem {
        Absent::Awaited => None,
        Absent::Impossible(reason) => Some(reason.as_str()),
    });
    let reasons = reasons.collect::<Vec<_>>().join("\n");
    if !reasons.is_empty() {
        Lacking::note(ui.ctx(), &reasons);
        write(below, &reasons, Theme::of(ui.ctx()).problem());
    } else if !problems.is_empty() {
        write(below, "reading the recording", ui.visuals().weak_text_color());
    }
}
