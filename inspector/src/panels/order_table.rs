//! How coherent orders are, as a table: a row for each.

use formats::key::method::UNSORTED;

use super::notes::{headings, legend};
use crate::model::coherences::OrderCoherence;
use crate::theme::Theme;

const COLUMNS: [(&str, &str); 4] = [
    ("order", "How the rays are sorted"),
    ("mean area", "Of the capsules of the groups, weighted by rays, in unit space"),
    ("of unsorted", "Mean area over that of unsorted rays"),
    ("spread", "1 - |sum of directions| / n of a group: 0 if all rays are parallel"),
];

/// The mean capsule area of unsorted rays, if it is known.
fn unsorted_area(orders: &[OrderCoherence]) -> Option<f64> {
    let unsorted = orders.iter().find(|order| order.method == UNSORTED)?;
    // Single rays have capsules without area.
    unsorted.coherence.known().map(|known| known.mean_capsule_area).filter(|&area| area > 0.0)
}

/// A row for each recorded order, with lane utilisation for these widths; before them one for an order that was
/// made here, by its name, which is awaited if it is `None`. `gap` lies between columns, points.
pub(super) fn order_table(
    ui: &mut egui::Ui,
    (id, gap): (&str, f32),
    made: Option<(&str, Option<&OrderCoherence>)>,
    recorded: &[OrderCoherence],
    widths: &[usize],
) {
    let (theme, unsorted) = (Theme::of(ui.ctx()), unsorted_area(recorded));
    let rows = recorded.iter().enumerate();
    let rows = rows.map(|(number, order)| (theme.series(number), order.method.as_str(), Some(order)));
    let rows = made.into_iter().map(|(name, order)| (theme.selected_mark(), name, order)).chain(rows);
    let columns = COLUMNS.len() + widths.len();
    egui::Grid::new(id).striped(true).num_columns(columns).spacing([gap, 2.0]).show(ui, |ui| {
        let lanes: Vec<(String, String)> = widths.iter().map(lanes_heading).collect();
        let lanes = lanes.iter().map(|(name, about)| (name.as_str(), about.as_str()));
        headings(ui, COLUMNS.into_iter().chain(lanes));
        for (colour, name, order) in rows {
            legend(ui, colour, name);
            match order {
                Some(order) => numbers(ui, order, unsorted, widths),
                None => drop(ui.spinner()),
            }
            ui.end_row();
        }
    });
}

fn lanes_heading(width: &usize) -> (String, String) {
    let about = format!("Share of their time in which {width} lanes work that wait for each other. A model");
    (format!("lanes {width}"), about)
}

fn numbers(ui: &mut egui::Ui, order: &OrderCoherence, unsorted: Option<f64>, widths: &[usize]) {
    let OrderCoherence { coherence, lanes, .. } = order;
    let mut cell = |text: Option<String>, reason: Option<&str>| {
        match (text, reason) {
            (Some(text), _) => ui.label(text),
            (None, Some(reason)) => ui.weak("none").on_hover_text(reason),
            (None, None) => ui.label("\u{2013}"),
        };
    };
    let (known, reason) = (coherence.known(), coherence.reason());
    cell(known.map(|known| format!("{:.4}", known.mean_capsule_area)), reason);
    let part = known.zip(unsorted).map(|(known, area)| known.mean_capsule_area / area);
    cell(part.map(|part| format!("{part:.3}")), reason);
    cell(known.map(|known| format!("{:.3}", known.mean_direction_spread)), reason);
    for width in widths {
        let found = lanes.known().and_then(|lanes| lanes.iter().find(|lanes| lanes.width == *width));
        let text = found.map(|lanes| format!("{:.3}", lanes.utilisation));
        cell(text, lanes.reason().or(Some("no ray did any work")));
    }
}
