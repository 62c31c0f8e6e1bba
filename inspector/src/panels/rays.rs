//! All rays of the queue in the chosen order, as a table of which only the rows in sight are made.
//!
//! The table scrolls by rows, not by pixels: f32 cannot tell the rows of a long table apart.

use egui_extras::{Column, TableBuilder};
use formats::traced::Results;

use super::missing;
use crate::model::key::ReadKey;
use crate::model::{Context, Order};
use crate::output::count;
use crate::panels::Panel;
use crate::panels::data::Data;

/// Rows that the wheel goes at a time.
const WHEEL_ROWS: f32 = 3.0;

/// The panel.
#[derive(Default)]
pub(super) struct RaysPanel {
    window: RowWindow,
    /// The ray that was last scrolled to.
    seen: Option<usize>,
}

/// Which rows are in sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RowWindow {
    first: usize,
    /// What the wheel has left over of a row.
    rest: f32,
}

impl RowWindow {
    /// Goes down by so many rows, no farther than the last row.
    fn scroll(&mut self, rows: f32, all: usize, in_sight: usize) {
        let wanted = self.rest + rows;
        let whole = wanted.trunc();
        self.rest = wanted - whole;
        let last = all.saturating_sub(in_sight);
        let first = self.first as i128 + whole as i128;
        self.first = usize::try_from(first.max(0)).unwrap_or(usize::MAX).min(last);
    }

    /// Brings a row into sight.
    fn reveal(&mut self, row: usize, all: usize, in_sight: usize) {
        if !(self.first..self.first + in_sight).contains(&row) {
            self.first = row.saturating_sub(in_sight / 2).min(all.saturating_sub(in_sight));
        }
    }
}

impl Panel for RaysPanel {
    fn title(&self) -> &'static str {
        "Rays"
    }

    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let order = match context.order() {
            Ok(order) => order,
            Err(reason) => return missing(ui, &reason),
        };
        let row_height = ui.text_style_height(&egui::TextStyle::Monospace) + 4.0;
        let all = order.len();
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{} rays by {}", count(all as u64), order.method));
            let last = all.saturating_sub(1);
            ui.add(egui::DragValue::new(&mut self.window.first).range(0..=last).prefix("from place "))
                .on_hover_text("The first row in sight; drag, or type a place");
        });
        let in_sight = (((ui.available_height() - 2.5 * row_height) / row_height) as usize).clamp(1, 500);
        let selected = context.selection.ray;
        if self.seen != selected {
            self.seen = selected;
            if let Some(&place) = selected.and_then(|ray| order.place_of_ray().get(ray)) {
                self.window.reveal(place as usize, all, in_sight);
            }
        }
        if ui.rect_contains_pointer(ui.max_rect()) {
            let wheel = ui.input(|input| input.smooth_scroll_delta.y);
            self.window.scroll(-wheel / row_height * WHEEL_ROWS / 3.0, all, in_sight);
        }
        self.window.scroll(0.0, all, in_sight);
        let rows = self.window.first..(self.window.first + in_sight).min(all);
        if let Some(ray) = table(ui, context, &order, rows, row_height) {
            context.select_ray(Some(ray));
            self.seen = Some(ray);
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let order = context.order().map_err(|reason| reason.to_string())?;
        let width = context.recording().map_or(1, |open| open.dump.manifest().header.options.width);
        let rows = (0..order.len()).map(move |place| cells(&order, place, width).to_vec());
        Ok(Data::new(&COLUMNS.map(|(name, _)| name), rows))
    }
}

const COLUMNS: [(&str, &str); 8] = [
    ("place", "Place in the order"),
    ("ray", "Canonical index: the place in pixel order"),
    ("pixel", "Column and row of the image"),
    ("key", "What the rays are sorted by"),
    ("origin", "World units"),
    ("direction", "Unit vector"),
    ("length", "Traced length, unit lengths"),
    ("hit", "Triangle of a closest ray; whether a shadow ray found its light"),
];

/// Shows these rows; the ray of the one that was clicked.
fn table(
    ui: &mut egui::Ui,
    context: &Context,
    order: &Order,
    rows: std::ops::Range<usize>,
    row_height: f32,
) -> Option<usize> {
    let width = context.recording().map_or(1, |open| open.dump.manifest().header.options.width);
    let mut clicked = None;
    egui::ScrollArea::horizontal().show(ui, |ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        TableBuilder::new(ui)
            .striped(true)
            .vscroll(false)
            .sense(egui::Sense::click())
            .columns(Column::auto().at_least(58.0).clip(false), COLUMNS.len() - 1)
            .column(Column::remainder().at_least(60.0))
            .header(row_height, |mut header| {
                for (name, about) in COLUMNS {
                    header.col(|ui| {
                        ui.strong(name).on_hover_text(about);
                    });
                }
            })
            .body(|body| {
                body.rows(row_height, rows.len(), |mut row| {
                    let place = rows.start + row.index();
                    let ray = order.places.ray(place);
                    row.set_selected(context.selection.ray == Some(ray));
                    for text in cells(order, place, width) {
                        row.col(|ui| {
                            ui.add(
                                egui::Label::new(egui::RichText::new(text).monospace())
                                    .selectable(false)
                                    .extend(),
                            );
                        });
                    }
                    if row.response().clicked() {
                        clicked = Some(ray);
                    }
                });
            });
    });
    clicked
}

fn cells(order: &Order, place: usize, width: u32) -> [String; COLUMNS.len()] {
    let (queue, ray_index) = (&order.queue, order.places.ray(place));
    let ray = &queue.traced.rays()[ray_index];
    let pixel = queue.path_ids[ray_index];
    let vector = |[x, y, z]: [f32; 3]| format!("{x:8.3} {y:8.3} {z:8.3}");
    let hit = match queue.traced.results() {
        Results::Hits(hits) if hits[ray_index].is_hit() => hits[ray_index].triangle.to_string(),
        Results::Hits(_) => "none".to_owned(),
        Results::Distances(distances) if distances[ray_index].is_finite() => "occluded".to_owned(),
        Results::Distances(_) => "light".to_owned(),
    };
    [
        place.to_string(),
        ray_index.to_string(),
        format!("{},{}", pixel % width.max(1), pixel / width.max(1)),
        ReadKey::of(order, ray_index).map_or_else(|_| "-".to_owned(), |key| key.hexadecimal()),
        vector(ray.origin),
        vector(ray.direction),
        format!("{:.4}", queue.lengths[ray_index]),
        hit,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hundred_million_rows_end_at_the_last_one() {
        let (all, in_sight) = (100_000_003, 37);
        let mut window = RowWindow::default();
        window.scroll(f32::MAX, all, in_sight);
        assert_eq!(window.first + in_sight, all);
        window.rest = 0.0;
        window.scroll(-1.0, all, in_sight);
        assert_eq!(window.first + in_sight, all - 1);
        window.reveal(all - 1, all, in_sight);
        assert_eq!(window.first + in_sight, all);
        window.reveal(99_999_990, all, in_sight);
        assert_eq!(window.first + in_sight, all);
        window.reveal(50_000_001, all, in_sight);
        assert!((window.first..window.first + in_sight).contains(&50_000_001));
    }

    #[test]
    fn parts_of_rows_add_up() {
        let mut window = RowWindow::default();
        for _ in 0..10 {
            window.scroll(0.25, 100, 10);
        }
        assert_eq!(window.first, 2);
        window.scroll(-1e9, 100, 10);
        assert_eq!(window.first, 0);
        window.scroll(5.0, 3, 10);
        assert_eq!(window.first, 0);
    }
}
