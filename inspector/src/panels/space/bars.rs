//! What is below the picture: the slider along the order, and the colour bars with their histograms.

use egui::{Align2, Color32, Id, Rect, Response, Sense, Slider, Ui, pos2, vec2};
use formats::metrics::quantity::Quantity;

use super::layers::{AREAS, BOUNCES};
use super::options::{SpaceOptions, VisitChoice};
use super::view::SpaceView;
use crate::colour_map::ColourMap;
use crate::figures::axis::ratio_label;
use crate::model::Context;
use crate::model::colour_by::ColourBy;
use crate::model::selection::Playhead;
use crate::render::range::{ValueRange, Values};
use crate::theme::Theme;

/// Height of the colour bar itself.
const BAR: f32 = 12.0;
/// Parts of the histogram above it.
const BINS: usize = 96;
const BINS_HEIGHT: f32 = 18.0;
/// Width from which sliders have names, points.
const NAMES_FROM: f32 = 440.0;
/// Of the order, each second that it plays.
const PLAYED_PER_SECOND: f32 = 0.08;

impl SpaceView {
    /// Height of what is below the picture.
    pub(in crate::panels) fn height_below(ui: &Ui, context: &Context) -> f32 {
        let text = ui.text_style_height(&egui::TextStyle::Body);
        let slider = if context.is_bare { 0.0 } else { ui.spacing().interact_size.y };
        slider + BINS_HEIGHT + BAR + 2.0 * text + 18.0
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

/// One of the bars: what it stands for, and the numbers behind it.
struct Bar<'a> {
    range: ValueRange,
    map: ColourMap,
    /// The base, where values are logarithms.
    logarithm: Option<f32>,
    title: &'a str,
    values: Option<&'a Values>,
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
    let rays =
        range.filter(|_| options.shows_rays()).map(|range| Bar { range, map, logarithm, title, values });
    let bar = |range, title, logarithm| Bar { range, map: options.map, logarithm, title, values: None };
    let areas = bar(AREAS, "capsule area, unit space", Some(10.0));
    let areas = options.capsules.then_some(areas);
    let cells = layers.cells().map(|(range, ..)| bar(range, "mean length in the cell, unit lengths", None));
    let path = layers.path().map(|_| bar(BOUNCES, "bounce", None));
    let visits = layers.visits().map(|(_, range)| {
        let of_ray = options.visits == VisitChoice::Ray;
        let title = if of_ray { "level below the root" } else { "rays of the group that enter the box" };
        bar(range, title, None)
    });
    let others: Vec<Bar<'_>> = areas.into_iter().chain(cells).chain(path).chain(visits).collect();
    let count = others.len() + usize::from(rays.is_some());
    let gap = 16.0;
    let width = (ui.available_width() - gap * count.saturating_sub(1) as f32) / count.max(1) as f32;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = gap;
        if let Some(bar) = rays {
            ray_bar(ui, options, width, &bar);
        }
        for bar in others {
            colour_bar(ui, width, &bar, bar.range);
        }
    });
}

/// The bar of the rays; its ends can be dragged over the histogram of all values.
fn ray_bar(ui: &mut Ui, options: &mut SpaceOptions, width: f32, bar: &Bar<'_>) {
    let Some(all) = bar.values.map(|values| values.percentiles(0.0, 100.0)) else {
        colour_bar(ui, width, bar, bar.range);
        return;
    };
    // Few values that are far away would leave no room for the others.
    let beyond = 0.25 * (bar.range.high - bar.range.low);
    let across = ValueRange {
        low: bar.range.low.min(all.low.max(bar.range.low - beyond)),
        high: bar.range.high.max(all.high.min(bar.range.high + beyond)),
    };
    let response = colour_bar(ui, width, bar, across);
    let response = response.on_hover_text("Drag an end of the range; double click for percentiles");
    let rect = response.rect;
    let x_of = |value: f32| rect.left() + across.part(value) * rect.width();
    let ends = [x_of(bar.range.low), x_of(bar.range.high)];
    let marks = Theme::of(ui.ctx()).reference();
    for x in ends {
        let (top, bottom) = (rect.top(), rect.top() + BINS_HEIGHT + BAR);
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

/// A bar over all values `across`, in the colours of its range.
fn colour_bar(ui: &mut Ui, width: f32, bar: &Bar<'_>, across: ValueRange) -> Response {
    let text_height = ui.text_style_height(&egui::TextStyle::Body);
    let height = BINS_HEIGHT + BAR + 2.0 * text_height + 2.0;
    let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click_and_drag());
    let painter = ui.painter();
    let counts = bar.values.map_or(vec![0; BINS], |values| values.histogram(across, BINS));
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
    let step = rect.width() / BINS as f32;
    let bar_top = rect.top() + BINS_HEIGHT;
    for (at, count) in counts.into_iter().enumerate() {
        let value = across.low + (at as f32 + 0.5) / BINS as f32 * (across.high - across.low);
        let [red, green, blue] = bar.map.colour(bar.range.part(value));
        let left = rect.left() + at as f32 * step;
        let high = (BINS_HEIGHT - 2.0) * count as f32 / most;
        painter.rect_filled(
            Rect::from_min_max(pos2(left, bar_top), pos2(left + step + 0.5, bar_top + BAR)),
            0.0,
            Color32::from_rgb(red, green, blue),
        );
        let bin = Rect::from_min_max(pos2(left, bar_top - high), pos2(left + step - 0.5, bar_top - 1.0));
        if high > 0.0 {
            painter.rect_filled(bin, 0.0, ui.visuals().weak_text_color());
        }
    }
    let (line, font) = (bar_top + BAR + 2.0, egui::TextStyle::Body.resolve(ui.style()));
    let below = pos2(rect.center().x, line + text_height);
    painter.text(below, Align2::CENTER_TOP, bar.title, font.clone(), ui.visuals().text_color());
    let mut taken: Vec<Rect> = Vec::new();
    let middle = (bar.logarithm == Some(2.0)).then_some(0.0);
    for value in [bar.range.low, bar.range.high].into_iter().chain(middle) {
        // Under its end, but on the bar; the later of two that would touch is left out.
        let text = match bar.logarithm {
            Some(2.0) => ratio_label(f64::from(value.exp2())),
            Some(base) => number(base.powf(value)),
            None => number(value),
        };
        let text = painter.layout_no_wrap(text, font.clone(), ui.visuals().text_color());
        let x = rect.left() + across.part(value) * rect.width() - 0.5 * text.size().x;
        let x = x.clamp(rect.left(), (rect.right() - text.size().x).max(rect.left()));
        let place = Rect::from_min_size(pos2(x, line), text.size());
        if taken.iter().all(|other| !other.expand(4.0).intersects(place)) {
            painter.galley(place.min, text, ui.visuals().text_color());
            taken.push(place);
        }
    }
    response
}

fn number(value: f32) -> String {
    match value.abs() {
        size if size < 1000.0 && size.fract() == 0.0 => format!("{value}"),
        size if size >= 1000.0 => crate::output::count(size as u64),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}
