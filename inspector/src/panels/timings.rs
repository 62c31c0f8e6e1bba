//! The stages of each method against tracing unsorted rays, the fastest first: what ends left of the line is faster in
//! the median.

use egui::{Align2, RichText};
use egui_plot::{AxisHints, Bar, BarChart, PlotPoint, Text, VLine};
use formats::key::method::{CONTROL, UNSORTED};
use formats::manifest::{LEFT_ALONE, Stage};

use super::notes::{hint, legend, marked, name_at, still};
use crate::analysis::timing::{stacked, stage_name};
use crate::analysis::{OrderAnalysis, QueueAnalysis};
use crate::model::Context;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::theme::Theme;

pub(super) struct TimingsPanel;

/// Height of a bar and its name, points: enough for both to be read.
const BAR_ROW: f32 = 19.0;

/// Right of the longest bar, for the net speedups, points.
const ROOM_FOR_NET: f32 = 74.0;

/// Height of the axis below the bars and the names above them, points.
const AXIS: f32 = 64.0;

impl Panel for TimingsPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let queue = match measured(context) {
            Ok(queue) => queue,
            Err(reason) => return hint(ui, &reason),
        };
        let height = queue.orders.len() as f32 * BAR_ROW + AXIS;
        egui::ScrollArea::vertical().show(ui, |ui| plot(ui, queue, ui.available_height().max(height)));
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let rows: Vec<Vec<String>> = measured(context)?.orders.iter().flat_map(quantities).collect();
        Ok(Data::new(&["order", "quantity", "value"], rows.into_iter()))
    }
}

/// The times of the selected queue, or why there are none.
fn measured(context: &Context) -> Result<&QueueAnalysis, String> {
    let recording = context.recording().ok_or("no recording is open")?;
    if recording.times.is_none() {
        return Err(
            "the recording is not finished: times are shown once it is (F5 reads it again)".to_owned()
        );
    }
    let found = recording.times_of(context.selection.queue).filter(|queue| !queue.orders.is_empty());
    found.ok_or_else(|| "no method was measured on these rays; the last pass is the measured one".to_owned())
}

/// The times and speedups of an order.
fn quantities(order: &OrderAnalysis) -> Vec<Vec<String>> {
    let row = |quantity: String, value: f64| vec![order.method.clone(), quantity, value.to_string()];
    let stages = order.stages.iter().flat_map(|stage| {
        let (name, time) = (stage.stage.name(), &stage.time);
        [
            (format!("{name}_median_ns"), time.median_ns),
            (format!("{name}_first_quartile_ns"), time.quartiles_ns.0),
            (format!("{name}_third_quartile_ns"), time.quartiles_ns.1),
            (format!("{name}_samples"), time.samples_ns.len() as f64),
        ]
    });
    let speedups = [("trace_speedup", &order.trace_speedup), ("net_speedup", &order.net_speedup)];
    let speedups = speedups
        .into_iter()
        .filter(|_| !order.is_left_alone())
        .filter_map(|(name, speedup)| speedup.known().map(|speedup| (name.to_owned(), speedup.ratio)));
    stages.chain(speedups).map(|(quantity, value)| row(quantity, value)).collect()
}

/// A stage of the way that an order is traced, in milliseconds.
fn milliseconds(order: &OrderAnalysis, stage: Stage) -> f64 {
    let found = order.stage(stage).filter(|_| order.way.counts(stage));
    found.map_or(0.0, |found| found.time.median_ns / 1e6)
}

/// The orders of a queue with the milliseconds that each takes, from below: what gains least, …, what gains most,
/// unsorted; by the net speedup at the right, where there is one. And the time of unsorted rays.
fn by_gain(queue: &QueueAnalysis) -> (Vec<(&OrderAnalysis, f64)>, Option<f64>) {
    let total = |order: &OrderAnalysis| stacked().map(|(_, stage)| milliseconds(order, stage)).sum::<f64>();
    let mut orders: Vec<(&OrderAnalysis, f64)> =
        queue.orders.iter().map(|order| (order, total(order))).collect();
    let break_even = orders.iter().find(|(order, _)| order.method == UNSORTED).map(|(_, takes)| *takes);
    let gain = |(order, takes): &(&OrderAnalysis, f64)| match order.net_speedup.known() {
        _ if order.method == UNSORTED => f64::INFINITY,
        Some(net) => net.ratio,
        None => break_even.unwrap_or(1.0) / takes,
    };
    orders.sort_by(|a, b| gain(a).total_cmp(&gain(b)));
    (orders, break_even)
}

fn plot(ui: &mut egui::Ui, queue: &QueueAnalysis, height: f32) {
    let theme = Theme::of(ui.ctx());
    let (orders, break_even) = by_gain(queue);
    let mut charts: Vec<BarChart> = Vec::new();
    let names: Vec<String> = orders.iter().map(|(order, _)| order.method.clone()).collect();
    let line = ui.horizontal_wrapped(|ui| {
        ui.label(format!("Bounce {}, {} rays:", queue.bounce, queue.kind));
        for (at, stage) in stacked() {
            let times: Vec<f64> = orders.iter().map(|(order, _)| milliseconds(order, stage)).collect();
            if times.iter().all(|time| *time == 0.0) {
                continue;
            }
            let (name, colour) = (stage_name(stage), theme.stage(at));
            legend(ui, colour, name);
            let bars = times.iter().enumerate();
            let bars =
                bars.map(|(row, time)| Bar::new(row as f64, *time).name(&names[row]).width(0.7).fill(colour));
            let said = move |bar: &Bar, _: &BarChart| format!("{}: {name} {:.3} ms", bar.name, bar.value);
            let chart = BarChart::new(name, bars.collect()).color(colour).horizontal();
            let chart = chart.element_formatter(Box::new(said));
            charts.push(chart.stack_on(&charts.iter().collect::<Vec<_>>()));
        }
        ui.label(
            "- - -  break-even: the trace of unsorted rays;  bars are medians;  at the right: net speedup, the median of \
             its rounds (\u{2248} may be chance)",
        );
    });
    let height = height - line.response.rect.height() - ui.spacing().item_spacing.y;
    let width = longest_name(ui, &names);
    // Names are shown however near the bars are to each other: there is room for each.
    let rows = AxisHints::new_y()
        .min_thickness(width)
        .label_spacing(4.0..=8.0)
        .formatter(move |mark, _| name_at(&names, mark.value));
    let longest = orders.iter().map(|(_, takes)| *takes).fold(0.0, f64::max);
    let for_bars = ui.available_width() - width;
    let room = f64::from(for_bars / (for_bars - ROOM_FOR_NET).max(ROOM_FOR_NET)).max(1.0);
    still("timings", height.max(80.0))
        .include_x(0.0)
        .include_x(longest * room)
        .set_margin_fraction(egui::vec2(0.02, 0.03))
        .show_grid([true, false])
        .custom_x_axes(vec![AxisHints::new_x().label("milliseconds").label_spacing(30.0..=60.0)])
        .custom_y_axes(vec![rows])
        .y_grid_spacer(egui_plot::uniform_grid_spacer(|_| [1.0, 1.0, 1.0]))
        .show(ui, |plot| {
            for chart in charts {
                plot.bar_chart(chart);
            }
            if let Some(break_even) = break_even {
                let line = VLine::new("break-even: unsorted trace", break_even).color(theme.reference());
                plot.vline(line.style(egui_plot::LineStyle::dashed_dense()).width(1.5));
            }
            for (row, (order, _)) in orders.iter().enumerate() {
                let Some(net) = order.net_speedup.known() else { continue };
                let is_own = !order.is_left_alone() && order.method != CONTROL;
                let verdict = theme.verdict(net.verdict).filter(|_| is_own);
                let colour = verdict.unwrap_or(theme.reference());
                let text = if order.is_left_alone() { LEFT_ALONE.to_owned() } else { marked(net) };
                let text = RichText::new(format!("  {text}")).color(colour);
                let text = Text::new("net speedup", PlotPoint::new(longest, row as f64), text);
                plot.text(text.anchor(Align2::LEFT_CENTER));
            }
        });
}

fn longest_name(ui: &egui::Ui, names: &[String]) -> f32 {
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    longest as f32 * 0.55 * ui.text_style_height(&egui::TextStyle::Body)
}
