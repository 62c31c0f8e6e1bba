//! All orders in one table, the one that gains most on the whole frame first: a click makes one B, with shift A.

use egui::{Align, Label, Layout, RichText, Ui, pos2, vec2};
use egui_extras::{Column, TableBuilder, TableRow};
use formats::key::method::{CONTROL, UNSORTED};
use formats::ray::Kind;

use super::notes::{hint, swatch};
use crate::analysis::Metric;
use crate::analysis::ranking::{Elsewhere, RankedOrder};
use crate::analysis::timing::{SpeedupLine, Verdict};
use crate::model::Context;
use crate::model::what_if::WHAT_IF;
use crate::output::times;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::shown;
use crate::theme::Theme;

/// Height of a row, points.
const ROW: f32 = 20.0;
/// What lines by bounce reach from 1 at least, so that what noise does looks small.
const LEAST_REACH: f64 = 1.1;

/// Names of the columns, their widths in points, and what they are.
const COLUMNS: [(&str, f32, &str); 7] = [
    ("", 20.0, "Which of the orders are A and B"),
    ("method", 0.0, "How rays are sorted; unsorted is the order of pixels"),
    (
        "net",
        52.0,
        "Unsorted trace over all that tracing in this order takes, key and sort included, on the whole frame, as in the strip; \u{2248} is no significant difference, ? no interval",
    ),
    (
        "trace",
        52.0,
        "Unsorted trace over the trace of rays gathered in this order, on the whole frame; net may trace them through indices, and then be the larger one",
    ),
    (
        "by bounce",
        66.0,
        "Net speedup from bounce to bounce of the selected kind of rays, that of the trace where there is no net, all rows on one scale; the line across is 1: as fast as unsorted",
    ),
    (
        "area",
        52.0,
        "Mean capsule area of a group over that of unsorted rays, of the selected bounce: small is coherent",
    ),
    (
        "SIMD",
        44.0,
        "SIMD utilisation of a warp of 32: the share of its lanes that work, of the selected bounce. A model",
    ),
];

pub(super) struct MethodsPanel;

impl Panel for MethodsPanel {
    fn show(&mut self, ui: &mut Ui, context: &mut Context) {
        let Some(recording) = context.recording() else { return hint(ui, "no recording is open") };
        let verdict = recording.verdict.clone();
        let ranking = context.ranking(ui.ctx().cumulative_frame_nr());
        if ranking.is_empty() {
            return hint(ui, "no method was measured on these rays; the last pass is the measured one");
        }
        if let Some(verdict) = verdict {
            let first = verdict.split("; ").next().unwrap_or_default();
            ui.label(first).on_hover_text(&verdict);
        }
        ui.weak("Speedups over unsorted rays, whole frame. Click: B. Shift-click: A.");
        let by_bounce = ranking.iter().flat_map(|order| &order.by_bounce).filter(|(_, ratio)| *ratio > 0.0);
        let reach = by_bounce.map(|(_, ratio)| ratio.log2().abs()).fold(LEAST_REACH.log2(), f64::max);
        let mut chosen = None;
        egui::ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
            let mut table = TableBuilder::new(ui)
                .striped(true)
                .sense(egui::Sense::click())
                .cell_layout(Layout::left_to_right(Align::Center));
            for (_, width, _) in COLUMNS {
                table = table.column(match width {
                    0.0 => Column::remainder().at_least(130.0).clip(true),
                    width => Column::exact(width),
                });
            }
            table.header(ROW, header).body(|body| {
                body.rows(ROW, ranking.len(), |mut row| {
                    let order = &ranking[row.index()];
                    row.set_selected(order.method == context.selection.method);
                    cells(&mut row, order, reach, context);
                    if row.response().clicked() {
                        chosen = Some(order.method.clone());
                    }
                });
            });
        });
        if let Some(method) = chosen {
            context.go_where_measured(&method);
            if ui.input(|input| input.modifiers.shift) {
                context.hold_against(None, &method);
            } else {
                context.order_by(&method);
            }
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let number = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
        let row = move |order: RankedOrder| {
            let speedup = |of: &Metric<SpeedupLine>| {
                let (low, high) = of.known().and_then(|line| line.interval).unzip();
                [order.gain(of), low, high].map(number)
            };
            let of_rays = [order.area.as_ref(), order.lanes.as_ref()];
            let of_rays = of_rays.map(|of| number(of.and_then(Metric::known).copied()));
            let numbers = speedup(&order.net).into_iter().chain(speedup(&order.trace)).chain(of_rays);
            std::iter::once(order.method.clone()).chain(numbers).collect()
        };
        let header = [
            "method",
            "net_speedup",
            "net_speedup_low",
            "net_speedup_high",
            "trace_speedup",
            "trace_speedup_low",
            "trace_speedup_high",
            "capsule_area_ratio",
            "simd_utilisation_32",
        ];
        Ok(Data::new(&header, context.ranking(0).into_iter().map(row)))
    }
}

fn header(mut row: TableRow<'_, '_>) {
    for (name, _, about) in COLUMNS {
        row.col(|ui| {
            ui.add(Label::new(RichText::new(name).strong()).selectable(false)).on_hover_text(about);
        });
    }
}

fn cells(row: &mut TableRow<'_, '_>, order: &RankedOrder, reach: f64, context: &Context) {
    let style = context.style_of(&order.method);
    let selection = &context.selection;
    let is_a = selection.baseline.recording.is_none() && selection.baseline.method == order.method;
    let is_b = selection.method == order.method;
    row.col(|ui| {
        let mark = [("A", is_a), ("B", is_b)].into_iter().filter(|(_, is_it)| *is_it).map(|(name, _)| name);
        ui.add(Label::new(RichText::new(mark.collect::<String>()).strong()).selectable(false));
    });
    row.col(|ui| {
        swatch(ui, style);
        let name = RichText::new(if order.method == CONTROL { "control: 1 is right" } else { &order.method });
        let name = if is_b { name.strong() } else { name };
        ui.add(Label::new(name).selectable(false).truncate()).on_hover_text(about(context, &order.method));
        if let Some(elsewhere) = order.elsewhere {
            let only = match elsewhere {
                Elsewhere::OtherBounces => "other bounces",
                Elsewhere::OtherKind(Kind::Closest) => "closest only",
                Elsewhere::OtherKind(Kind::Shadow) => "shadow only",
            };
            let only = Label::new(RichText::new(only).weak().small()).selectable(false);
            ui.add(only).on_hover_text("A click goes to these rays");
        }
    });
    for of in [&order.net, &order.trace] {
        row.col(|ui| speedup(ui, order, of));
    }
    row.col(|ui| sparkline(ui, &order.by_bounce, reach, Theme::of(ui.ctx()).series(style)));
    row.col(|ui| of_rays(ui, order.area.as_ref(), times));
    row.col(|ui| of_rays(ui, order.lanes.as_ref(), |lanes| format!("{:.0} %", 100.0 * lanes)));
}

/// How the keys of a method are made.
fn about(context: &Context, method: &str) -> String {
    let layout = context.recording().and_then(|recording| recording.method(method));
    let made = context.what_if.as_ref().filter(|_| method == WHAT_IF).map(|settings| settings.text.clone());
    let about = layout.map(|record| shown::name(&record.text)).or(made);
    about.unwrap_or_else(|| "the order of pixels".to_owned())
}

fn plain(ui: &mut Ui, text: impl Into<RichText>) -> egui::Response {
    ui.add(Label::new(text.into()).selectable(false))
}

fn none(ui: &mut Ui, why: &str) {
    plain(ui, RichText::new("\u{2013}").weak()).on_hover_text(why);
}

fn speedup(ui: &mut Ui, order: &RankedOrder, of: &Metric<SpeedupLine>) {
    match of {
        _ if order.method == UNSORTED => drop(plain(ui, times(1.0))),
        Metric::Known(line) => {
            let sign = match line.verdict {
                Verdict::NoSignificantDifference | Verdict::WithinControl => "\u{2248}",
                Verdict::Unknown => "?",
                Verdict::Faster | Verdict::Slower => "",
            };
            plain(ui, format!("{sign}{}", times(line.ratio))).on_hover_text(format!(
                "{} {} (n = {})",
                line.verdict.words(),
                line.interval_text(),
                line.n
            ));
        }
        Metric::Missing { missing } => none(ui, missing),
    }
}

fn of_rays(ui: &mut Ui, of: Option<&Metric<f64>>, text: fn(f64) -> String) {
    match of {
        None => drop(ui.add(egui::Spinner::new().size(10.0))),
        Some(Metric::Known(number)) => drop(plain(ui, text(*number))),
        Some(Metric::Missing { missing }) => none(ui, missing),
    }
}

/// Speedups from bounce to bounce, on a logarithmic scale that reaches as far up from 1 as down.
fn sparkline(ui: &mut Ui, by_bounce: &[(u32, f64)], reach: f64, colour: egui::Color32) {
    let (rect, response) = ui.allocate_exact_size(vec2(58.0, ROW - 4.0), egui::Sense::hover());
    if by_bounce.is_empty() {
        return;
    }
    let said = by_bounce.iter().map(|(bounce, ratio)| format!("bounce {bounce}: {}", times(*ratio)));
    response.on_hover_text(said.collect::<Vec<_>>().join("\n"));
    let y_of = |ratio: f64| {
        let part = 0.5 - 0.5 * (ratio.max(f64::MIN_POSITIVE).log2() / reach).clamp(-1.0, 1.0) as f32;
        rect.top() + part * rect.height()
    };
    let weak = ui.visuals().weak_text_color().gamma_multiply(0.5);
    ui.painter().hline(rect.x_range(), y_of(1.0), egui::Stroke::new(1.0, weak));
    let step = rect.width() / by_bounce.len().saturating_sub(1).max(1) as f32;
    let points = by_bounce.iter().enumerate();
    let points: Vec<egui::Pos2> =
        points.map(|(at, (_, ratio))| pos2(rect.left() + at as f32 * step, y_of(*ratio))).collect();
    if let [only] = points[..] {
        ui.painter().circle_filled(only, 2.5, colour);
    }
    ui.painter().line(points, egui::Stroke::new(2.0, colour));
}
