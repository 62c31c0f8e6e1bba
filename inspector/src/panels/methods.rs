//! All orders in one table, the one that gains most on the whole frame first: a click makes one B, with shift A. Below
//! it what B gains on each bounce.

use std::collections::BTreeSet;

use egui::{Align, Button, Grid, Label, Layout, RichText, Ui};
use egui_extras::{Column, TableBuilder, TableRow};
use formats::key::method::{CONTROL, UNSORTED};
use formats::manifest::QueueId;
use formats::ray::Kind;

use super::notes::{hint, marked, swatch};
use crate::analysis::Metric;
use crate::analysis::ranking::{Elsewhere, RankedOrder};
use crate::analysis::summary::RayClass;
use crate::analysis::timing::SpeedupLine;
use crate::model::Context;
use crate::model::what_if::WHAT_IF;
use crate::output::times;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::shown;
use crate::theme::Theme;

/// Height of a row, points.
const ROW: f32 = 20.0;

/// Names of the columns, their widths in points, and what they are.
const COLUMNS: [(&str, f32, &str); 8] = [
    ("", 20.0, "Which of the orders are A and B"),
    ("method", 0.0, "How rays are sorted; unsorted is the order of pixels"),
    (
        "net",
        54.0,
        "Unsorted trace over all that tracing in this order takes, key and sort included, on the whole frame, as in the strip; \u{2248} is no significant difference, ? no interval",
    ),
    ("secondary", 68.0, "The net speedup of secondary rays: closest rays after the camera's"),
    ("shadow", 54.0, "The net speedup of shadow rays"),
    (
        "trace",
        54.0,
        "Unsorted trace over the trace of rays gathered in this order, on the whole frame; net may trace them through indices, and then be the larger one",
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
        let QueueId { bounce, kind, .. } = context.selection.queue;
        ui.weak(format!(
            "Speedups of the whole frame; area, SIMD of bounce {bounce}, {kind}. Click: B. Shift-click: A."
        ));
        if let Some(order) = ranking.iter().find(|order| order.method == context.selection.method) {
            by_bounce(ui, order, context);
        }
        let mut chosen = None;
        egui::ScrollArea::horizontal().auto_shrink([false, false]).show(ui, |ui| {
            let mut table = TableBuilder::new(ui)
                .striped(true)
                .min_scrolled_height(0.0)
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
                    cells(&mut row, order, context);
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
            let speedups =
                [&order.net, &order.trace].into_iter().chain(order.by_rays.iter().map(|on| &on.all));
            let numbers = speedups.flat_map(speedup).chain(of_rays);
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
            "secondary_net_speedup",
            "secondary_net_speedup_low",
            "secondary_net_speedup_high",
            "shadow_net_speedup",
            "shadow_net_speedup_low",
            "shadow_net_speedup_high",
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

fn cells(row: &mut TableRow<'_, '_>, order: &RankedOrder, context: &Context) {
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
        let name =
            RichText::new(if order.method == CONTROL { "control: trace 1 is right" } else { &order.method });
        let name = if is_b { name.strong() } else { name };
        let name = if order.elsewhere.is_some() { name.weak() } else { name };
        let goes = match order.elsewhere {
            None => "",
            Some(Elsewhere::OtherBounces) => "\nIt orders other bounces: a click goes there",
            Some(Elsewhere::OtherKind(Kind::Closest)) => {
                "\nIt orders closest rays alone: a click goes to them"
            }
            Some(Elsewhere::OtherKind(Kind::Shadow)) => "\nIt orders shadow rays alone: a click goes to them",
        };
        let about = about(context, &order.method) + goes;
        ui.add(Label::new(name).selectable(false).truncate()).on_hover_text(about);
    });
    row.col(|ui| speedup(ui, order, &order.net));
    for on in &order.by_rays {
        row.col(|ui| speedup(ui, order, &on.all));
    }
    row.col(|ui| speedup(ui, order, &order.trace));
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

/// A speedup in the colour of its verdict; how sure it is on hover.
fn speedup(ui: &mut Ui, order: &RankedOrder, of: &Metric<SpeedupLine>) {
    match of {
        _ if order.method == UNSORTED => drop(plain(ui, times(1.0))),
        Metric::Known(line) => drop(plain(ui, verdict(ui, order, line)).on_hover_text(sure(line))),
        Metric::Missing { missing } => none(ui, missing),
    }
}

fn verdict(ui: &Ui, order: &RankedOrder, line: &SpeedupLine) -> RichText {
    let text = RichText::new(marked(line));
    match Theme::of(ui.ctx()).verdict(line.verdict) {
        Some(colour) if order.method != CONTROL => text.color(colour),
        _ => text,
    }
}

fn sure(line: &SpeedupLine) -> String {
    format!("{} {} (n = {})", line.verdict.words(), line.speedup().interval_text(), line.n)
}

/// What an order gains on each bounce; a click goes there. Nothing where it gains nothing by itself or was not timed.
fn by_bounce(ui: &mut Ui, order: &RankedOrder, context: &mut Context) {
    let nets = order.by_rays.iter().flat_map(|on| &on.by_bounce);
    let known: BTreeSet<u32> =
        nets.filter(|(_, net)| net.known().is_some()).map(|(id, _)| id.bounce).collect();
    if known.is_empty() || order.method == UNSORTED {
        return;
    }
    let mut chosen = None;
    egui::Panel::bottom("by bounce").resizable(false).show(ui, |ui| {
        let grid = |ui: &mut Ui| {
            let about = format!("The net speedup of {} on each bounce. Click: goes there", order.method);
            plain(ui, RichText::new("net of B, bounce").weak()).on_hover_text(about);
            known.iter().for_each(|bounce| drop(ui.strong(bounce.to_string())));
            ui.end_row();
            for (rays, on) in RayClass::ALL.iter().zip(&order.by_rays) {
                plain(ui, rays.name());
                for bounce in &known {
                    match on.by_bounce.iter().find(|(id, _)| id.bounce == *bounce) {
                        Some((id, Metric::Known(line))) => {
                            let is_here = *id == context.selection.queue;
                            let cell = ui.add(Button::selectable(is_here, verdict(ui, order, line)));
                            chosen = cell.on_hover_text(sure(line)).clicked().then_some(*id).or(chosen);
                        }
                        Some((_, Metric::Missing { missing })) => none(ui, missing),
                        None => drop(ui.label("")),
                    }
                }
                ui.end_row();
            }
        };
        let scroll = egui::ScrollArea::horizontal().auto_shrink([false, true]);
        scroll.show(ui, |ui| Grid::new("by bounce").show(ui, grid));
    });
    if let Some(queue) = chosen {
        context.go_to(queue);
        context.order_by(&order.method);
    }
}

fn of_rays(ui: &mut Ui, of: Option<&Metric<f64>>, text: fn(f64) -> String) {
    match of {
        None => drop(ui.add(egui::Spinner::new().size(10.0))),
        Some(Metric::Known(number)) => drop(plain(ui, text(*number))),
        Some(Metric::Missing { missing }) => none(ui, missing),
    }
}
