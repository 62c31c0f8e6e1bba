//! How coherent each order's groups are: the areas of their capsules.

use egui_plot::{Line, Plot, PlotPoints};
use serde::{Deserialize, Serialize};

use super::notes::{found, hint, power_of_ten};
use super::order_table::order_table;
use super::worst::WorstGroups;
use crate::model::Context;
use crate::model::coherences::OrderCoherence;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::theme::Theme;

/// Height of a row of the table below, points.
const ROW: f32 = 23.0;

/// What is listed below the plot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Listed {
    /// The means of every order.
    #[default]
    Orders,
    /// The worst groups of the selected order.
    Groups,
}

#[derive(Default)]
pub(super) struct CoherencePanel {
    listed: Listed,
    worst: WorstGroups,
}

impl Panel for CoherencePanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let (width, method) = (context.selection.group_width, context.selection.method.clone());
        let known = context.coherences(ui.ctx().cumulative_frame_nr());
        let Some((orders, total)) = found(ui, known) else { return };
        if total == 0 {
            return hint(ui, "no method was measured on these rays; the last pass is the measured one");
        }
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("Capsule areas of groups of {} rays", width.rays())).on_hover_text(
                "The hull of a sphere around a group's origins and one around its ends, in unit space",
            );
            if orders.len() < total {
                ui.weak(format!("{} of {total} orders so far", orders.len()));
            }
        });
        let rows = total as f32 + 2.0;
        let table_height = (rows * ROW).min(0.5 * ui.available_height());
        distribution(ui, orders, &method, ui.available_height() - table_height - 12.0);
        ui.horizontal_wrapped(|ui| {
            for (listed, name, about) in [
                (Listed::Orders, "orders", "The means of every order"),
                (
                    Listed::Groups,
                    "worst groups",
                    "Groups of the order with the largest capsules, the worst first",
                ),
            ] {
                ui.selectable_value(&mut self.listed, listed, name).on_hover_text(about);
            }
        });
        match self.listed {
            Listed::Orders => {
                let scrolled = egui::ScrollArea::both().auto_shrink([false, true]);
                scrolled.show(ui, |ui| order_table(ui, ("means", 18.0), None, orders, &[32]));
            }
            Listed::Groups => self.worst.show(ui, context),
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let (orders, total) = context.coherences(0)?;
        if orders.len() < total {
            return Err("not all orders are known yet; try again once the panel shows them".to_owned());
        }
        let rows: Vec<Vec<String>> = orders.iter().flat_map(quantities).collect();
        Ok(Data::new(&["order", "quantity", "value"], rows.into_iter()))
    }

    fn state(&self) -> serde_json::Value {
        serde_json::json!({ "listed": self.listed })
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        self.listed = serde_json::from_value(state["listed"].clone())?;
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

/// Share of the rays whose groups have a smaller capsule, for each order.
fn distribution(ui: &mut egui::Ui, orders: &[OrderCoherence], chosen: &str, height: f32) {
    let theme = Theme::of(ui.ctx());
    let line = |(number, order): (usize, &OrderCoherence)| {
        let coherence = order.coherence.known()?;
        let steps = coherence.area_quantiles.len().saturating_sub(1).max(1) as f64;
        let quantiles = coherence.area_quantiles.iter().enumerate();
        let points = quantiles.map(|(at, area)| [area.max(1e-9).log10(), 100.0 * at as f64 / steps]);
        let width = if order.method == chosen { 3.5 } else { 1.3 };
        let line = Line::new(order.method.clone(), points.collect::<PlotPoints<'_>>());
        Some(line.color(theme.series(number)).width(width))
    };
    let lines: Vec<Line<'_>> = orders.iter().enumerate().filter_map(line).collect();
    Plot::new("areas")
        .height(height.max(80.0))
        .allow_scroll(false)
        .include_y(0.0)
        .include_y(100.0)
        .x_axis_label("capsule area, unit space")
        .y_axis_label("rays below, %")
        .x_axis_formatter(|mark, _| power_of_ten(mark.value))
        .show(ui, |plot| {
            for line in lines {
                plot.line(line);
            }
        });
}
