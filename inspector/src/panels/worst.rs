//! What is worst: the groups of an order with the largest capsules, the triangles whose rays cost most.

use super::notes::{found, headings, missing, select};
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

const TRIANGLE_COLUMNS: [(&str, &str); 5] = [
    ("triangle", "Its number in the scene; a click selects the ray that costs most of those that end at it"),
    ("material", "Number of its material"),
    ("rays", "Rays of the queue that end at it"),
    ("a ray", "Nodes visited and triangles tested, mean over these rays"),
    ("of all", "Nodes and triangles of these rays over those of all rays of the queue"),
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
        let mean = groups.mean_area.max(f64::MIN_POSITIVE);
        let chosen = table(ui, "worst", COLUMNS, worst, |&at| {
            let group = groups.groups.get(at)?;
            let lanes = group.lanes.map_or("-".to_owned(), |lanes| format!("{lanes:.3}"));
            let of_mean = format!("{:.2}", group.area / mean);
            let cells = [
                count(at as u64),
                format!("{:.4}", group.area),
                of_mean,
                format!("{:.3}", group.spread),
                lanes,
            ];
            Some((context.selection.group == Some(at), cells))
        });
        if let Some(&group) = chosen {
            select(ui, context, Some(order.places.ray(groups.places(group).start)));
        }
    }
}

/// A row for each triangle; a click selects its costliest ray.
pub(super) fn costliest_triangles(ui: &mut egui::Ui, context: &mut Context) {
    let Some((triangles, all)) = found(ui, context.costliest()) else { return };
    let Some(queue) = found(ui, context.queue()) else { return };
    let materials = queue.materials.as_ref().ok();
    let chosen = table(ui, "costliest", TRIANGLE_COLUMNS, &triangles, |costly| {
        let material = costly.triangle.and_then(|triangle| materials?.get(triangle as usize));
        let cells = [
            costly.triangle.map_or("none".to_owned(), |triangle| count(u64::from(triangle))),
            material.map_or("-".to_owned(), u32::to_string),
            count(costly.rays),
            format!("{:.1}", costly.steps as f64 / costly.rays as f64),
            format!("{:.2} %", 100.0 * costly.steps as f64 / all.max(1) as f64),
        ];
        Some((context.selection.rays().contains(&costly.costliest_ray), cells))
    });
    if let Some(costly) = chosen {
        select(ui, context, Some(costly.costliest_ray));
    }
}

/// A row for each item: whether it is the selected one, and its cells. The item whose first cell was clicked.
fn table<'a, T>(
    ui: &mut egui::Ui,
    name: &str,
    columns: [(&'static str, &'static str); 5],
    items: &'a [T],
    row: impl Fn(&T) -> Option<(bool, [String; 5])>,
) -> Option<&'a T> {
    let mut chosen = None;
    egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
        egui::Grid::new(name).striped(true).num_columns(5).spacing([18.0, 2.0]).show(ui, |ui| {
            headings(ui, columns);
            for item in items {
                let Some((is_selected, [first, rest @ ..])) = row(item) else { continue };
                if ui.selectable_label(is_selected, first).clicked() {
                    chosen = Some(item);
                }
                rest.into_iter().for_each(|cell| drop(ui.label(cell)));
                ui.end_row();
            }
        });
    });
    chosen
}
