//! How coherent each order's groups are: the areas of their capsules.

use egui_plot::{Line, Plot, PlotPoints, PlotResponse, VLine};
use formats::metrics::quantity::Quantity;

use super::brush::brush;
use super::notes::{found, group_widths, hint, power_of_ten, swatch};
use super::worst::{WorstGroups, costliest_triangles};
use crate::model::Context;
use crate::model::coherences::OrderCoherence;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::theme::Theme;

#[derive(Default)]
pub(super) struct CoherencePanel {
    worst: WorstGroups,
    /// Whether triangles are listed in place of groups.
    triangles: bool,
}

impl Panel for CoherencePanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let b = context.selection.method.clone();
        let a = context.selection.baseline.clone();
        let a = a.recording.is_none().then_some(a.method).filter(|a| *a != b);
        let known = context.all_coherences(ui.ctx().cumulative_frame_nr());
        let Some((orders, total)) = found(ui, known) else { return };
        if total == 0 {
            return hint(ui, "no method was measured on these rays; the last pass is the measured one");
        }
        ui.horizontal_wrapped(|ui| {
            group_widths(ui, "Capsule areas of groups of", context);
            if orders.len() < total {
                ui.weak(format!("{} of {total} orders so far", orders.len()));
            }
        });
        let median = |method: &str| {
            let order = orders.iter().find(|order| order.method == method)?;
            order.coherence.known()?.area_quantiles.get(50).copied()
        };
        ui.horizontal_wrapped(|ui| compared(ui, context, a.as_deref(), &b, median));
        let style = |order: &OrderCoherence| {
            let is_chosen = order.method == b || Some(&order.method) == a.as_ref();
            is_chosen.then(|| context.style_of(&order.method))
        };
        let styles: Vec<Option<usize>> = orders.iter().map(style).collect();
        let played = played_area(context);
        let plot = distribution(ui, &orders, &styles, played, 0.5 * ui.available_height());
        let area_at = |x: f32| 10f64.powf(plot.transform.value_from_position(egui::pos2(x, 0.0)).x);
        brush(ui, &plot.response, (Quantity::Area, area_at), context);
        ui.horizontal_wrapped(|ui| {
            ui.selectable_value(&mut self.triangles, false, "Groups with the largest capsules");
            ui.selectable_value(&mut self.triangles, true, "Triangles whose rays cost most");
        });
        if self.triangles {
            costliest_triangles(ui, context);
        } else {
            self.worst.show(ui, context);
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let (orders, total) = context.all_coherences(0)?;
        if orders.len() < total {
            return Err("not all orders are known yet; try again once the panel shows them".to_owned());
        }
        let rows: Vec<Vec<String>> = orders.iter().flat_map(quantities).collect();
        Ok(Data::new(&["order", "quantity", "value"], rows.into_iter()))
    }

    fn state(&self) -> serde_json::Value {
        serde_json::json!({ "triangles": self.triangles })
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        self.triangles = serde_json::from_value(state["triangles"].clone())?;
        Ok(())
    }
}

/// The numbers of an order: means, lane utilisation, and the areas below which so many percent of rays are.
fn quantities(order: &OrderCoherence) -> Vec<Vec<String>> {
    let row = |quantity: String, value: f64| vec![order.method.clone(), quantity, value.to_string()];
    let coherence = order.coherence.known().into_iter().flat_map(|coherence| {
        let quantiles = coherence.area_quantiles.iter().enumerate();
        let quantiles =
            quantiles.map(|(percent, area)| (format!("capsule_area_percentile_{percent}"), *area));
        [
            ("mean_capsule_area".to_owned(), coherence.mean_capsule_area),
            ("mean_direction_spread".to_owned(), coherence.mean_direction_spread),
        ]
        .into_iter()
        .chain(quantiles)
    });
    let lanes = order.lanes.known().into_iter().flatten();
    let lanes = lanes.map(|lanes| (format!("lane_utilisation_{}", lanes.width), lanes.utilisation));
    coherence.chain(lanes).map(|(quantity, value)| row(quantity, value)).collect()
}

/// In place of the logarithm of 0.
const LEAST_AREA: f64 = 1e-9;

/// The capsule area of the group that the playhead is at.
fn played_area(context: &mut Context) -> Option<f64> {
    let order = context.order().ok()?;
    let place = context.playhead.place(order.len())?;
    let width = context.selection.group_width;
    order.group(place / width.rays(), width).map(|group| group.area)
}

/// By how much the groups of B are smaller than those of A, and which lines they are.
fn compared(
    ui: &mut egui::Ui,
    context: &Context,
    a: Option<&str>,
    b: &str,
    median: impl Fn(&str) -> Option<f64>,
) {
    let known = |method: &str| Some((method.to_owned(), median(method)?));
    for (method, area) in a.and_then(known).into_iter().chain(known(b)) {
        swatch(ui, context.style_of(&method));
        ui.label(format!("{method}: median {area:.3}"));
    }
    if let Some((of_a, of_b)) = a.and_then(&median).zip(median(b)).filter(|(_, of_b)| *of_b > 0.0) {
        ui.strong(format!("{:.1} times as small in the median", of_a / of_b));
    }
    ui.weak("others grey");
}

/// Share of the rays whose groups have a smaller capsule, for each order.
fn distribution(
    ui: &mut egui::Ui,
    orders: &[OrderCoherence],
    styles: &[Option<usize>],
    played: Option<f64>,
    height: f32,
) -> PlotResponse<()> {
    let theme = Theme::of(ui.ctx());
    let line = |(order, style): (&OrderCoherence, &Option<usize>)| {
        let coherence = order.coherence.known()?;
        let steps = coherence.area_quantiles.len().saturating_sub(1).max(1) as f64;
        let quantiles = coherence.area_quantiles.iter().enumerate();
        let points = quantiles.map(|(at, area)| [area.max(LEAST_AREA).log10(), 100.0 * at as f64 / steps]);
        let (colour, width) = style.map_or((theme.left_out(), 1.0), |style| (theme.series(style), 3.0));
        let line = Line::new(order.method.clone(), points.collect::<PlotPoints<'_>>());
        // A band would fill the steps of a few groups.
        Some((style.is_some(), line.color(colour).width(width).allow_band(false)))
    };
    let mut lines: Vec<(bool, Line<'_>)> = orders.iter().zip(styles).filter_map(line).collect();
    // A and B are drawn over the others.
    lines.sort_by_key(|(is_chosen, _)| *is_chosen);
    Plot::new("areas")
        .height(height.max(80.0))
        .allow_scroll(false)
        .allow_drag(false)
        .include_y(0.0)
        .include_y(100.0)
        .x_axis_label("capsule area, unit space")
        .y_axis_label("rays below, %")
        .x_axis_formatter(|mark, _| power_of_ten(mark.value))
        .show(ui, |plot| {
            for (_, line) in lines {
                plot.line(line);
            }
            if let Some(area) = played {
                let mark = VLine::new("group at the playhead", area.max(LEAST_AREA).log10());
                plot.vline(mark.color(theme.selected_mark()));
            }
        })
}
