//! The row above the picture, what is written on it, the slider and the colour bar below.

use egui::{Align2, Color32, ComboBox, FontId, Rect, Slider, Ui, pos2, vec2};

use super::super::filter_box::filter_box;
use super::layers::AREAS;
use super::options::{CapsuleChoice, MeshMode, StandPoint};
use super::{SpaceView, stand};
use crate::model::value::ColourBy;
use crate::model::{Absent, Context};
use crate::render::camera::Camera;
use crate::render::colour_map::ColourMap;
use crate::render::geometry::RayEnd;
use crate::render::range::{ValueRange, Values};
use crate::theme::Theme;

/// Height of the colour bar itself.
const BAR: f32 = 12.0;
/// Parts of the histogram above it.
const BINS: usize = 96;
/// Width of the filter, points.
const FILTER_WIDTH: f32 = 170.0;
/// Height of the histogram.
const BINS_HEIGHT: f32 = 18.0;
/// Of the order, each second that it plays.
const PLAYED_PER_SECOND: f32 = 0.08;

/// What is shown.
pub(super) fn above(ui: &mut Ui, view: &mut SpaceView, context: &mut Context) {
    ui.horizontal_wrapped(|ui| {
        let options = &mut view.options;
        ui.toggle_value(&mut options.curve, "Curve").on_hover_text("A line through the rays in their order");
        ui.toggle_value(&mut options.rays, "Rays")
            .on_hover_text("A line from each origin to where the ray ended");
        ui.toggle_value(&mut options.ends, "Ends").on_hover_text("A dot where each ray ended");
        ui.toggle_value(&mut options.capsules, "Capsules")
            .on_hover_text("The hull of a sphere around a group's origins and one around its ends");
        ui.menu_button("Show", |ui| details(ui, view));
        let options = &mut view.options;
        ComboBox::from_id_salt("colour by")
            .selected_text(format!("by {}", options.colour_by.name()))
            .show_ui(ui, |ui| {
                for choice in ColourBy::ALL {
                    ui.selectable_value(&mut options.colour_by, choice, choice.name())
                        .on_hover_text(choice.title());
                }
            });
        ComboBox::from_id_salt("colour map").selected_text(options.map.name()).show_ui(ui, |ui| {
            for map in ColourMap::ALL {
                ui.selectable_value(&mut options.map, map, map.name());
            }
        });
        cameras(ui, view, context);
        filter_box(ui, context, FILTER_WIDTH);
    });
}

fn cameras(ui: &mut Ui, view: &mut SpaceView, context: &Context) {
    let Some(recording) = context.recording() else { return };
    for (point, name, about) in [
        (StandPoint::Recorded, "Camera", "Where the recording's camera stood (C)"),
        (StandPoint::Overview, "Overview", "All of the scene, from outside (R)"),
    ] {
        if ui.button(name).on_hover_text(about).clicked() {
            view.camera = Some((context.selection.recording, stand(point, recording)));
        }
    }
    if let Some((_, camera)) = &mut view.camera {
        ui.menu_button("View", |ui| typed(ui, camera));
    }
}

/// A camera as numbers.
fn typed(ui: &mut Ui, camera: &mut Camera) {
    ui.label("Unit space: the scene's largest side is 1");
    let Camera { target, yaw, pitch, distance, .. } = camera;
    for (name, value) in [
        ("target x", &mut target.x),
        ("target y", &mut target.y),
        ("target z", &mut target.z),
        ("yaw", yaw),
        ("pitch", pitch),
        ("distance", distance),
    ] {
        ui.add(egui::DragValue::new(value).speed(0.005).prefix(format!("{name} ")));
    }
    let Camera { target, yaw, pitch, distance, .. } = *camera;
    if ui.button("Copy").clicked() {
        let text = format!("{} {} {} {yaw} {pitch} {distance}", target.x, target.y, target.z);
        ui.ctx().copy_text(text);
    }
}

fn details(ui: &mut Ui, view: &mut SpaceView) {
    let options = &mut view.options;
    ui.label("Surfaces");
    ui.horizontal(|ui| {
        for (mode, name) in
            [(MeshMode::Solid, "solid"), (MeshMode::Ghost, "see-through"), (MeshMode::Hidden, "hidden")]
        {
            ui.selectable_value(&mut options.mesh, mode, name);
        }
    });
    ui.add(Slider::new(&mut options.ghost_opacity, 0.02..=1.0).text("opacity if see-through"));
    ui.add(Slider::new(&mut options.cut, 0.0..=1.0).text("cut away above"));
    ui.add(Slider::new(&mut options.hidden_opacity, 0.0..=1.0).text("opacity of hidden lines"));
    ui.separator();
    ui.label("Curve through");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut options.curve_end, RayEnd::Origin, "origins");
        ui.selectable_value(&mut options.curve_end, RayEnd::Termination, "ends");
    });
    ui.add(Slider::new(&mut options.detail, 2..=4_194_304).logarithmic(true).text("rays at most"));
    ui.add(Slider::new(&mut options.line_width, 0.5..=6.0).text("width of lines"));
    ui.separator();
    ui.label("Capsules of");
    ui.horizontal(|ui| {
        for (choice, name) in [
            (CapsuleChoice::Selected, "the selected group"),
            (CapsuleChoice::Worst, "the worst"),
            (CapsuleChoice::Spread, "some"),
        ] {
            ui.selectable_value(&mut options.capsule_choice, choice, name);
        }
    });
    ui.add(Slider::new(&mut options.capsule_count, 1..=2000).logarithmic(true).text("capsules at most"));
    ui.add(Slider::new(&mut options.capsule_opacity, 0.02..=1.0).text("opacity of capsules"));
    ui.separator();
    ui.label("Colours from and to these percentiles");
    ui.add(Slider::new(&mut options.percentiles.0, 0.0..=50.0).text("lowest"));
    ui.add(Slider::new(&mut options.percentiles.1, 50.0..=100.0).text("highest"));
}

/// Writes on the picture.
pub(super) fn overlay(ui: &Ui, rect: Rect, text: &str, problem: Option<&Absent>) {
    let painter = ui.painter().with_clip_rect(rect);
    let write = |at, text: &str, colour| {
        let galley = painter.layout(text.to_owned(), FontId::proportional(12.5), colour, rect.width() - 16.0);
        let back = Rect::from_min_size(at, galley.size()).expand(3.0);
        painter.rect_filled(back, 3.0, ui.visuals().panel_fill.gamma_multiply(0.8));
        painter.galley(at, galley, colour);
    };
    write(rect.left_top() + vec2(8.0, 7.0), text, ui.visuals().text_color());
    let below = rect.left_top() + vec2(8.0, 29.0);
    match problem {
        None => {}
        Some(Absent::Awaited) => write(below, "reading the recording", ui.visuals().weak_text_color()),
        Some(Absent::Impossible(reason)) => write(below, reason, Theme::of(ui.ctx()).problem()),
    }
}

/// Height of what is below the picture.
pub(super) fn height_below(ui: &Ui) -> f32 {
    let text = ui.text_style_height(&egui::TextStyle::Body);
    ui.spacing().interact_size.y + BINS_HEIGHT + BAR + text + 18.0
}

/// The slider along the order, and what colours stand for.
pub(super) fn below(ui: &mut Ui, view: &mut SpaceView) {
    let options = &mut view.options;
    ui.horizontal(|ui| {
        let name = if options.is_playing { "Stop" } else { "Play" };
        if ui.button(name).on_hover_text("Moves along the order (space)").clicked() {
            options.is_playing = !options.is_playing;
            if options.is_playing && options.until >= 1.0 {
                options.until = 0.0;
            }
        }
        let rest = (ui.available_width() - 290.0).max(40.0);
        ui.spacing_mut().slider_width = rest;
        ui.add(Slider::new(&mut options.until, 0.0..=1.0).text("until").fixed_decimals(3))
            .on_hover_text("Where in the order the rays shown end");
        ui.spacing_mut().slider_width = 60.0;
        ui.add(Slider::new(&mut options.window, 0.001..=1.0).logarithmic(true).text("part"))
            .on_hover_text("How much of the order before that is shown");
    });
    if options.is_playing {
        options.until += PLAYED_PER_SECOND * ui.input(|input| input.stable_dt).min(0.1);
        options.is_playing = options.until < 1.0;
        options.until = options.until.min(1.0);
        ui.ctx().request_repaint();
    }
    colour_bars(ui, view);
}

/// A bar for rays, for capsules, or for both beside each other.
fn colour_bars(ui: &mut Ui, view: &SpaceView) {
    let options = &view.options;
    let by = options.colour_by;
    let values = view.layers.values().filter(|_| by != ColourBy::Place);
    let rays = view.layers.range().filter(|_| options.shows_rays()).map(|range| (range, by.title(), values));
    let capsules = options.capsules.then_some((AREAS, "capsule area, log10", None));
    let bars: Vec<_> = rays.into_iter().chain(capsules).collect();
    let gap = 16.0;
    let width = (ui.available_width() - gap * bars.len().saturating_sub(1) as f32) / bars.len().max(1) as f32;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = gap;
        for (range, title, values) in bars {
            colour_bar(ui, options.map, width, (range, title), values);
        }
    });
}

fn colour_bar(
    ui: &mut Ui,
    map: ColourMap,
    width: f32,
    (range, title): (ValueRange, &str),
    values: Option<&Values>,
) {
    let text_height = ui.text_style_height(&egui::TextStyle::Body);
    let height = BINS_HEIGHT + BAR + text_height + 2.0;
    let (rect, _) = ui.allocate_exact_size(vec2(width, height), egui::Sense::hover());
    let painter = ui.painter();
    let counts = values.map_or(vec![0; BINS], |values| values.histogram(range, BINS));
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let step = rect.width() / BINS as f32;
    let bar_top = rect.top() + BINS_HEIGHT;
    for (at, count) in counts.into_iter().enumerate() {
        let [red, green, blue] = map.colour((at as f32 + 0.5) / BINS as f32);
        let colour = Color32::from_rgb(red, green, blue);
        let left = rect.left() + at as f32 * step;
        let high = (BINS_HEIGHT - 2.0) * count as f32 / most;
        painter.rect_filled(
            Rect::from_min_max(pos2(left, bar_top), pos2(left + step + 0.5, bar_top + BAR)),
            0.0,
            colour,
        );
        let bin = Rect::from_min_max(pos2(left, bar_top - high), pos2(left + step - 0.5, bar_top - 1.0));
        if high > 0.0 {
            painter.rect_filled(bin, 0.0, ui.visuals().weak_text_color());
        }
    }
    let line = bar_top + BAR + 2.0;
    let font = egui::TextStyle::Body.resolve(ui.style());
    let colour = ui.visuals().text_color();
    for (x, align, text) in [
        (rect.left(), Align2::LEFT_TOP, number(range.low)),
        (rect.center().x, Align2::CENTER_TOP, title.to_owned()),
        (rect.right(), Align2::RIGHT_TOP, number(range.high)),
    ] {
        painter.text(pos2(x, line), align, text, font.clone(), colour);
    }
}

fn number(value: f32) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if size >= 1000.0 => crate::output::count(size as u64),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}
