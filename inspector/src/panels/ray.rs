//! One ray: where it runs, its key field by field, its group, and its path through the bounces.

use std::sync::Arc;

use egui::RichText;
use formats::key::decode::DecodedField;
use formats::ray::Kind;
use formats::traced::Results;

use super::notes::{cost, found, headings, hint};
use crate::analysis::GroupWidth;
use crate::model::key::ReadKey;
use crate::model::path::PathRay;
use crate::model::{Absent, Context, Order};
use crate::output::count;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::shown;
use crate::theme::Theme;

const PATH_COLUMNS: [(&str, &str); 6] = [
    ("ray", "Kind and bounce; a click selects it"),
    ("ends", "What the ray met"),
    ("throughput", "Factor of the light it meets on the way to the pixel: red, green, blue"),
    ("length", "From its origin to where it ended, unit lengths"),
    ("in A", "Its place in order A of its queue"),
    ("in B", "Its place in order B of its queue"),
];

/// Width of the longest name of a line, points.
const NAMES: f32 = 100.0;

#[derive(Default)]
pub(super) struct RayPanel {
    /// The order and width whose worst group is looked for.
    seeks_worst: Option<(u64, GroupWidth)>,
}

impl Panel for RayPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(order) = found(ui, context.order()) else { return };
        self.step(ui, context, &order);
        let Some(ray) = context.selection.ray.filter(|&ray| ray < order.len()) else {
            return hint(ui, "choose a ray: click a pixel, a row, a cell or a line in space");
        };
        egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            let rows = [places(context, &order, ray), facts(&order, ray)].concat();
            lines(ui, "geometry", &rows);
            ui.separator();
            key(ui, &order, ray);
            ui.separator();
            group(ui, context, &order, ray);
            ui.separator();
            path(ui, context, &order, ray);
        });
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let order = context.order()?;
        let ray = context.selection.ray.filter(|&ray| ray < order.len()).ok_or("no ray is chosen")?;
        let facts = [places(context, &order, ray), facts(&order, ray)].concat();
        let facts = facts.into_iter().map(|(name, value)| vec![name.to_owned(), value]);
        let key = ReadKey::of(&order, ray).ok();
        let bits = key.as_ref().map(|key| vec!["key".to_owned(), key.hexadecimal()]);
        let fields = key
            .into_iter()
            .flat_map(|key| key.fields)
            .map(|field| vec![field.bit.to_string(), range_text(&field, None)]);
        let rows: Vec<Vec<String>> = facts.chain(bits).chain(fields).collect();
        Ok(Data::new(&["what", "value"], rows.into_iter()))
    }
}

impl RayPanel {
    /// Goes along the order, ray by ray or group by group.
    fn step(&mut self, ui: &mut egui::Ui, context: &mut Context, order: &Arc<Order>) {
        let width = context.selection.group_width.rays();
        let now =
            context.selection.ray.and_then(|ray| order.place_of_ray().get(ray)).map(|&place| place as usize);
        let last = order.len().saturating_sub(1);
        let mut next = None;
        ui.horizontal_wrapped(|ui| {
            for (name, about, to) in [
                (
                    "< group",
                    "The first ray of the group before",
                    now.map(|at| (at / width).saturating_sub(1) * width),
                ),
                ("< ray", "The ray before in the order", now.map(|at| at.saturating_sub(1))),
                ("ray >", "The next ray of the order", Some(now.map_or(0, |at| (at + 1).min(last)))),
                (
                    "group >",
                    "The first ray of the next group",
                    Some(now.map_or(0, |at| ((at / width + 1) * width).min(last))),
                ),
            ] {
                let button = egui::Button::new(name);
                if ui.add_enabled(to.is_some() && !order.is_empty(), button).on_hover_text(about).clicked() {
                    next = to;
                }
            }
            if ui.button("worst group").on_hover_text("The group with the largest capsule").clicked() {
                self.seeks_worst = Some((order.serial, context.selection.group_width));
            }
        });
        self.seeks_worst.take_if(|sought| *sought != (order.serial, context.selection.group_width));
        if self.seeks_worst.is_some()
            && let Some(groups) = context.groups(order)
        {
            self.seeks_worst = None;
            next = groups.worst(1).first().map(|&group| groups.places(group).start);
        }
        if let Some(place) = next {
            context.select_ray(Some(order.places.ray(place)));
        }
    }
}

fn lines(ui: &mut egui::Ui, name: &'static str, rows: &[(&str, String)]) {
    // What is too long for a narrow window goes on in the next line.
    let widest = (ui.available_width() - NAMES).max(NAMES);
    egui::Grid::new(name).num_columns(2).max_col_width(widest).spacing([14.0, 3.0]).show(ui, |ui| {
        for (what, value) in rows {
            ui.add(egui::Label::new(*what).extend());
            ui.add(egui::Label::new(RichText::new(value).monospace()).wrap());
            ui.end_row();
        }
    });
}

/// Where a ray is in order A, if that is of the same recording, and in order B; with its keys.
fn places(context: &mut Context, b: &Arc<Order>, ray: usize) -> Vec<(&'static str, String)> {
    let is_own = context.selection.baseline.recording.is_none();
    let a = is_own.then(|| context.of_baseline(|_| None, |context| context.order().ok())).flatten();
    let row = |(name, order): (&'static str, Arc<Order>)| {
        let place = count(u64::from(*order.place_of_ray().get(ray)?));
        let key =
            ReadKey::of(&order, ray).map_or(String::new(), |key| format!(", key {}", key.hexadecimal()));
        Some((name, format!("{place} by {}{key}", shown::name(&order.method))))
    };
    let a = a.filter(|a| a.method != b.method).map(|a| ("place in A", a));
    a.into_iter().chain([("place in B", b.clone())]).filter_map(row).collect()
}

/// What there is to say of a ray, without its key.
fn facts(order: &Order, index: usize) -> Vec<(&'static str, String)> {
    let queue = &order.queue;
    let ray = &queue.traced.rays()[index];
    let vector = |[x, y, z]: [f32; 3]| format!("{x:.4} {y:.4} {z:.4}");
    let result = match queue.traced.results() {
        Results::Hits(hits) if hits[index].is_hit() => format!("triangle {}", hits[index].triangle),
        Results::Hits(_) => "no triangle".to_owned(),
        Results::Distances(distances) if distances[index].is_finite() => {
            format!("occluder at {:.4}", distances[index])
        }
        Results::Distances(_) => "its light".to_owned(),
    };
    let mut rows = vec![
        ("ray", format!("{} of {}", count(index as u64), count(order.len() as u64))),
        ("origin", vector(ray.origin)),
        ("unit space", vector(queue.traced.unit().point(ray.origin))),
        ("direction", vector(ray.direction)),
        ("length", format!("{:.5}, unit space", queue.lengths[index])),
        ("found", result),
    ];
    if let Ok(table) = &queue.table {
        rows.push(("table says", format!("{:.5}", table.mean(ray))));
    }
    if let Ok(work) = &queue.work {
        rows.push(("work", cost(work[index])));
    }
    rows
}

fn key(ui: &mut egui::Ui, order: &Order, ray: usize) {
    let key = match ReadKey::of(order, ray) {
        Ok(key) => key,
        Err(reason) => {
            ui.label(reason);
            return;
        }
    };
    let theme = Theme::of(ui.ctx());
    ui.label(format!("Key {}, {} bits; coordinates in 0 to 1", key.hexadecimal(), key.key_bits))
        .on_hover_text("Each bit with the colour of the coordinate that it comes from");
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        for (at, bit) in key.bits.iter().enumerate() {
            let digit = if key.bit(at) { "1" } else { "0" };
            let colour = theme.series_text(key.field_of(bit).unwrap_or(0));
            ui.label(RichText::new(digit).monospace().color(colour)).on_hover_text(bit.to_string());
        }
    });
    egui::Grid::new("fields").striped(true).num_columns(4).spacing([14.0, 2.0]).show(ui, |ui| {
        for (number, field) in key.fields.iter().enumerate() {
            ui.label(RichText::new(field.bit.to_string()).monospace().color(theme.series_text(number)));
            ui.monospace(format!("{:0bits$b}", field.value, bits = field.bits as usize));
            ui.monospace(format!("{} bits", field.bits));
            ui.monospace(range_text(field, Some(5)));
            ui.end_row();
        }
    });
}

fn group(ui: &mut egui::Ui, context: &mut Context, order: &Arc<Order>, ray: usize) {
    let width = context.selection.group_width;
    let at = order.place_of_ray()[ray] as usize / width.rays();
    let Some(group) = order.group(at, width) else { return };
    let mean = context.groups(order).map(|groups| groups.mean_area);
    let visits = match context.visits(order, ray) {
        Ok(visits) => {
            let (shared, of_ray) = visits.shared();
            format!("{of_ray}, {shared} of them with others of the group")
        }
        Err(absent) => absent.to_string(),
    };
    let of_mean = mean.map(|mean| if mean > 0.0 { group.area / mean } else { 1.0 });
    lines(
        ui,
        "group",
        &[
            (
                "group",
                format!("{} of {}", count(at as u64), count(order.len().div_ceil(width.rays()) as u64)),
            ),
            ("capsule area", format!("{:.5}", group.area)),
            ("of the mean", of_mean.map_or(Absent::Awaited.to_string(), |of_mean| format!("{of_mean:.2}"))),
            ("radii", format!("{:.4} and {:.4}", group.capsule.origin_radius, group.capsule.end_radius)),
            ("spread", format!("{:.4}", group.spread)),
            ("boxes visited", visits),
            ("lanes", group.lanes.map_or("not known".to_owned(), |lanes| format!("{lanes:.3}"))),
        ],
    );
}

/// The path of a ray through all bounces; a click on one of its rays selects it.
fn path(ui: &mut egui::Ui, context: &mut Context, order: &Order, ray: usize) {
    let pixel = order.queue.path_ids[ray];
    ui.label(format!("Path {}, all bounces", count(u64::from(pixel))));
    let now = context.selection.queue;
    let Some(found) = context.paths(vec![pixel]) else { return };
    let mut next = None;
    egui::Grid::new("path").striped(true).num_columns(6).spacing([14.0, 2.0]).show(ui, |ui| {
        headings(ui, PATH_COLUMNS);
        for PathRay { queue, ray, throughput, length, is_at_surface, places, .. } in found.iter() {
            let text = format!("{} {}", queue.kind, queue.bounce);
            if ui.selectable_label(*queue == now, text).clicked() {
                next = Some((*queue, *ray));
            }
            let ends = match (queue.kind, is_at_surface) {
                (Kind::Closest, true) => "at a surface",
                (Kind::Closest, false) => "nowhere",
                (Kind::Shadow, true) => "before its light",
                (Kind::Shadow, false) => "at its light",
            };
            ui.label(ends);
            let carried = throughput.as_ref().and_then(|carried| carried.as_ref().ok());
            ui.monospace(
                carried.map_or(String::new(), |carried| carried.map(|part| format!("{part:.3}")).join(" ")),
            );
            ui.monospace(format!("{length:.4}"));
            for place in places {
                ui.monospace(place.map_or("-".to_owned(), |place| count(place as u64)));
            }
            ui.end_row();
        }
    });
    let unknown = found.iter().find_map(|ray| ray.throughput.as_ref()?.as_ref().err());
    if let Some(reason) = unknown {
        ui.weak(reason);
    }
    if let Some((queue, ray)) = next {
        context.go_to(queue);
        context.select_ray(Some(ray));
    }
}

/// The range of a field, with so many decimals or all.
fn range_text(field: &DecodedField, decimals: Option<usize>) -> String {
    match (field.range(), decimals) {
        (Some((low, high)), Some(decimals)) => format!("{low:.decimals$} to {high:.decimals$}"),
        (Some((low, high)), None) => format!("{low} to {high}"),
        (None, _) => "hidden by ^".to_owned(),
    }
}
