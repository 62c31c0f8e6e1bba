//! What is below the picture: the slider along the order, and the colour bars with their histograms.

use egui::{Id, Response, Slider, Ui, pos2};
use formats::metrics::quantity::Quantity;

use super::layers::AREAS;
use super::options::{SpaceOptions, VisitChoice};
use super::view::SpaceView;
use crate::model::Context;
use crate::model::colour_by::ColourBy;
use crate::model::selection::Playhead;
use crate::panels::colour_bar::{self, ColourBar};
use crate::render::range::ValueRange;
use crate::theme::Theme;

/// Width from which sliders have names, points.
const NAMES_FROM: f32 = 440.0;
/// Of the order, each second that it plays.
const PLAYED_PER_SECOND: f32 = 0.08;

impl SpaceView {
    /// Height of what is below the picture.
    pub(in crate::panels) fn height_below(ui: &Ui, context: &Context) -> f32 {
        let slider = if context.is_bare { 0.0 } else { ui.spacing().interact_size.y };
        slider + colour_bar::height(ui) + 16.0
    }

    /// The slider along the order, and what colours stand for.
    pub(in crate::panels) fn below(&mut self, ui: &mut Ui, context: &mut Context) {
        if !context.is_bare {
            slider(ui, &mut self.options);
        }
        context.playhead = Playhead { until: self.options.until, window: self.options.window };
        colour_bars(ui, self);
    }
}

fn slider(ui: &mut Ui, options: &mut SpaceOptions) {
    ui.horizontal(|ui| {
        let name = if options.is_playing { "Stop" } else { "Play" };
        if ui.button(name).on_hover_text("Moves along the order (space)").clicked() {
            options.is_playing = !options.is_playing;
            if options.is_playing && options.until >= 1.0 {
                options.until = 0.0;
            }
        }
        let (is_wide, room) = (ui.available_width() > NAMES_FROM, ui.available_width());
        let named = |name| if is_wide { name } else { "" };
        ui.spacing_mut().slider_width = (room - if is_wide { 380.0 } else { 220.0 }).max(30.0);
        ui.add(Slider::new(&mut options.until, 0.0..=1.0).text(named("playhead")).fixed_decimals(3))
            .on_hover_text("Where in the order the rays shown end");
        ui.spacing_mut().slider_width = 60.0;
        ui.add(
            Slider::new(&mut options.window, 0.001..=1.0).logarithmic(true).text(named("shown before it")),
        )
        .on_hover_text("How much of the order before that is shown");
    });
    if options.is_playing {
        options.until += PLAYED_PER_SECOND * ui.input(|input| input.stable_dt).min(0.1);
        options.is_playing = options.until < 1.0;
        options.until = options.until.min(1.0);
        ui.ctx().request_repaint();
    }
}

/// The bars of what is shown, beside each other.
fn colour_bars(ui: &mut Ui, view: &mut SpaceView) {
    let (map, logarithm, range) = (view.map(), view.logarithm(), view.range());
    let SpaceView { options, layers, .. } = view;
    let by = options.colour_by;
    let own = layers.ray_values.as_ref();
    let has_values = !matches!(by, ColourBy::Quantity(Quantity::Place | Quantity::Bounce)) || own.is_some();
    let values = layers.values().filter(|_| has_values);
    let near = if options.near_mean { ", mean over rays that end near each other" } else { "" };
    let title = own.map_or_else(|| by.title() + near, |values| values.title.to_owned());
    let title = title.as_str();
    let rays = range.filter(|_| options.shows_rays()).map(|range| ColourBar {
        range,
        map,
        logarithm,
        title,
        values,
    });
    let bar = |range, title, logarithm| ColourBar { range, map: options.map, logarithm, title, values: None };
    let areas = bar(AREAS, "capsule area, unit space", Some(10.0));
    let areas = options.capsules.then_some(areas);
    let cells = layers.cells().map(|(range, ..)| bar(range, "mean length in the cell, unit lengths", None));
    let path = layers.paths().and_then(|_| layers.bounces()).map(|range| bar(range, "bounce", None));
    let visits = layers.visits().map(|(_, range)| {
        let of_ray = options.visits == VisitChoice::Ray;
        let title = if of_ray { "level below the root" } else { "rays of the group that enter the box" };
        bar(range, title, None)
    });
    let others: Vec<ColourBar<'_>> = areas.into_iter().chain(cells).chain(path).chain(visits).collect();
    let count = others.len() + usize::from(rays.is_some());
    let gap = 16.0;
    let width = (ui.available_width() - gap * count.saturating_sub(1) as f32) / count.max(1) as f32;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = gap;
        if let Some(bar) = rays {
            ray_bar(ui, options, width, &bar);
        }
        for bar in others {
            bar.show(ui, width, bar.range);
        }
    });
}

/// The bar of the rays; its ends can be dragged over the histogram of all values.
fn ray_bar(ui: &mut Ui, options: &mut SpaceOptions, width: f32, bar: &ColourBar<'_>) {
    let Some(all) = bar.values.map(|values| values.percentiles(0.0, 100.0)) else {
        bar.show(ui, width, bar.range);
        return;
    };
    // Few values that are far away would leave no room for the others.
    let beyond = 0.25 * (bar.range.high - bar.range.low);
    let across = ValueRange {
        low: bar.range.low.min(all.low.max(bar.range.low - beyond)),
        high: bar.range.high.max(all.high.min(bar.range.high + beyond)),
    };
    let response = bar.show(ui, width, across);
    let response = response.on_hover_text("Drag an end of the range; double click for percentiles");
    let rect = response.rect;
    let x_of = |value: f32| rect.left() + across.part(value) * rect.width();
    let ends = [x_of(bar.range.low), x_of(bar.range.high)];
    let marks = Theme::of(ui.ctx()).reference();
    for x in ends {
        let (top, bottom) = (rect.top(), rect.top() + colour_bar::HANDLE);
        ui.painter().vline(x, top..=bottom, egui::Stroke::new(1.5, marks));
        ui.painter().circle_filled(pos2(x, top + 2.0), 3.0, marks);
    }
    if response.double_clicked() {
        options.range = None;
    } else if let Some(pointer) = response.interact_pointer_pos() {
        options.range = dragged(ui, &response, pointer.x, ends, (bar.range, across)).or(options.range);
    }
}

/// The range while one of its ends is dragged.
fn dragged(
    ui: &Ui,
    response: &Response,
    x: f32,
    ends: [f32; 2],
    (range, across): (ValueRange, ValueRange),
) -> Option<(f32, f32)> {
    let id: Id = response.id.with("end");
    if response.drag_started() {
        let from = ui.input(|input| input.pointer.press_origin()).map_or(x, |origin| origin.x);
        let is_high = (from - ends[1]).abs() < (from - ends[0]).abs();
        ui.data_mut(|data| data.insert_temp(id, is_high));
    }
    if !response.dragged() {
        return None;
    }
    let is_high: bool = ui.data(|data| data.get_temp(id))?;
    let part = ((x - response.rect.left()) / response.rect.width().max(1.0)).clamp(0.0, 1.0);
    let value = across.low + part * (across.high - across.low);
    Some(if is_high { (range.low, value.max(range.low)) } else { (value.min(range.high), range.high) })
}
