//! The length table as a picture: cells whose addresses are near lie near each other.

use egui::Color32;
use formats::length_table::{LengthCell, mean_length};
use formats::manifest::QueueId;

use super::missing;
use super::picture::Picture;
use crate::model::{Context, Queue};
use crate::output::count;
use crate::panels::Panel;
use crate::render::cell_box::{cell_of_pixel, pixel_of_cell};
use crate::render::colour_map::ColourMap;
use crate::theme::Theme;

/// What cells are coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Colouring {
    /// Whether a ray was added.
    Fill,
    /// Rays added, logarithmic.
    Count,
    /// Mean length.
    #[default]
    Mean,
}

impl Colouring {
    const ALL: [(Self, &str, &str); 3] = [
        (
            Self::Mean,
            "mean length",
            "Mean of the lengths added, over the longest mean; a dummy of 0.25 counts",
        ),
        (Self::Count, "count", "Rays added, by powers of two"),
        (Self::Fill, "fill", "Cells that any ray was added to"),
    ];
}

/// The panel.
#[derive(Default)]
pub(super) struct TablePanel {
    colouring: Colouring,
    picture: Picture<(usize, QueueId, Colouring, bool)>,
}

impl Panel for TablePanel {
    fn title(&self) -> &'static str {
        "Length table"
    }

    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let queue = match context.queue() {
            Ok(queue) => queue,
            Err(reason) => return missing(ui, &reason),
        };
        let cells: &[LengthCell] = match &queue.cells {
            Ok(cells) => cells,
            Err(reason) => return missing(ui, reason),
        };
        let Some(bits) = context.recording().map(|open| open.dump.manifest().header.options.table_bits)
        else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            for (colouring, name, about) in Colouring::ALL {
                ui.selectable_value(&mut self.colouring, colouring, name).on_hover_text(about);
            }
            let (touched, all) = (cells.len() as u64, 1u64 << bits);
            let fill = 100.0 * touched as f64 / all as f64;
            ui.weak(format!("{} of {} cells touched ({fill:.1} %)", count(touched), count(all)));
        });
        let size = [1usize << bits.div_ceil(2), 1 << (bits / 2)];
        let (selection, theme) = (&context.selection, Theme::of(ui.ctx()));
        let key = (selection.recording, selection.queue, self.colouring, ui.visuals().dark_mode);
        let line = ui.text_style_height(&egui::TextStyle::Small) + 8.0;
        let shown = ui
            .allocate_ui(ui.available_size() - egui::vec2(0.0, line), |ui| {
                self.picture.show(ui, ("table", key), size, || pixels(cells, size, self.colouring, theme))
            })
            .inner;
        let under_pointer = shown.pixel.map(|[column, row]| cell_of_pixel(column, row));
        if shown.response.clicked() {
            select(context, &queue, under_pointer);
        }
        if let Some(cell) = context.selection.cell {
            let (column, row) = pixel_of_cell(cell);
            let mark = shown.rect_of([column, row]).expand(3.0);
            let stroke = egui::Stroke::new(1.5, theme.selected_mark());
            ui.painter().rect_stroke(mark, 0.0, stroke, egui::StrokeKind::Outside);
        }
        if let Some(cell) = under_pointer.or(context.selection.cell) {
            ui.small(described(cells, cell));
        }
    }
}

fn pixels(cells: &[LengthCell], size: [usize; 2], colouring: Colouring, theme: Theme) -> Vec<Color32> {
    let mean = |cell: &LengthCell| mean_length(cell.sum, cell.count);
    let rays = |cell: &LengthCell| ((cell.count - 1) as f32).log2();
    let largest = |of: fn(&LengthCell) -> f32| cells.iter().map(of).fold(f32::MIN_POSITIVE, f32::max);
    let (longest, most) = (largest(mean), largest(rays).max(1.0));
    let mut pixels = vec![theme.nothing(); size[0] * size[1]];
    // A damaged cell may count no ray at all.
    for cell in cells.iter().filter(|cell| cell.count >= 2) {
        let value = match colouring {
            Colouring::Fill => 0.75,
            Colouring::Count => 0.1 + 0.9 * rays(cell) / most,
            Colouring::Mean => mean(cell) / longest,
        };
        let [red, green, blue] = ColourMap::Viridis.colour(value);
        let (column, row) = pixel_of_cell(cell.cell);
        if let Some(pixel) = pixels.get_mut(row as usize * size[0] + column as usize) {
            *pixel = Color32::from_rgb(red, green, blue);
        }
    }
    pixels
}

/// Selects a cell, and the first ray that finds its length there.
fn select(context: &mut Context, queue: &Queue, cell: Option<u32>) {
    context.selection.cell = cell;
    let encoder = context
        .recording()
        .and_then(|recording| formats::stored_table::cell_encoder(&recording.dump.manifest().header));
    let (Some(encoder), Some(cell)) = (encoder, cell) else { return };
    let is_there = |ray: &formats::ray::Ray| encoder.encode(ray, 0.0, 0) == u64::from(cell);
    context.select_ray(queue.traced.rays().iter().position(is_there));
}

fn described(cells: &[LengthCell], cell: u32) -> String {
    match cells.binary_search_by_key(&cell, |known| known.cell) {
        Ok(at) if cells[at].count >= 2 => {
            let LengthCell { count: with_dummy, sum, .. } = cells[at];
            let mean = mean_length(sum, with_dummy);
            format!("cell {cell:05x}: {} rays, mean length {mean:.4}", count(u64::from(with_dummy) - 1))
        }
        _ => format!("cell {cell:05x}: no ray yet, so a length of 0.25 is assumed"),
    }
}
