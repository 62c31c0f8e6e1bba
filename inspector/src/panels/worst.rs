//! The groups of an order with the largest capsules, the worst first.

use super::notes::{found, headings, missing};
use crate::analysis::GroupWidth;
use crate::model::{Absent, Context};
use crate::output::count;

/// Groups in the list.
const LISTED: usize = 100;

const COLUMNS: [(&str, &str); 5] = [
    ("group", "Number of the group in the order, from 0; a click selects it and its first ray"),
    ("area", "Area of the group's capsule, unit space"),
    ("of the mean", "Area over the mean area of the order's groups"),
    ("spread", "1 - |sum of directions| / n: 0 if all rays are parallel"),
    ("lanes", "Share of their time in which the group's lanes work. A model"),
];

#[derive(Default)]
pub(super) struct WorstGroups {
    /// Of which order and width, and the groups.
    known: Option<((u64, GroupWidth), Vec<usize>)>,
}

impl WorstGroups {
    /// A row for each group; a click selects it with its first ray.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(order) = found(ui, context.order()) else { return };
        let width = context.selection.group_width;
        let Some(groups) = context.groups(&order) else { return missing(ui, Absent::Awaited) };
        let key = (order.serial, width);
        let worst = match &self.known {
            Some((known, worst)) if *known == key => worst,
            _ => &self.known.insert((key, groups.worst(LISTED))).1,
        };
        let mean = groups.mean_area().max(f64::MIN_POSITIVE);
        let mut chosen = None;
        egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            egui::Grid::new("worst").striped(true).num_columns(5).spacing([18.0, 2.0]).show(ui, |ui| {
                headings(ui, COLUMNS);
                for &at in worst {
                    let Some(group) = groups.groups.get(at) else { continue };
                    let is_now = context.selection.group == Some(at);
                    if ui.selectable_label(is_now, count(at as u64)).clicked() {
                        chosen = Some(at);
                    }
                    ui.label(format!("{:.4}", group.area));
                    ui.label(format!("{:.2}", group.area / mean));
                    ui.label(format!("{:.3}", group.spread));
                    ui.label(group.lanes.map_or("-".to_owned(), |lanes| format!("{lanes:.3}")));
                    ui.end_row();
                }
            });
        });
        if let Some(group) = chosen {
            context.select_ray(Some(order.places.ray(groups.places(group).start)));
        }
    }
}
