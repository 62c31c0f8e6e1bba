//! The length table as a picture: cells whose addresses are near lie near each other.

use egui::Color32;
use formats::length_table::{LengthCell, mean_length};
use formats::manifest::QueueId;

use super::missing;
use super::picture::Picture;
use crate::model::{Context, Queue};
use crate::output::count;
use crate::panels::Panel;
use crate::panels::data::Data;
use crate::render::cell_box::{cell_of_pixel, pixel_of_cell};
use crate::render::colour_map::ColourMap;
use crate::render::range::ValueRange;
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
    picture: Picture<(usize, QueueId, Colouring, bool, Blocks)>,
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
        let line = ui.text_style_height(&egui::TextStyle::Small) + 8.0;
        let room = ui.available_size() - egui::vec2(0.0, line);
        let blocks = Blocks::fitting(bits, room.min_elem() * ui.ctx().pixels_per_point());
        let (selection, theme) = (&context.selection, Theme::of(ui.ctx()));
        let key = (selection.recording, selection.queue, self.colouring, ui.visuals().dark_mode, blocks);
        let make = || pixels(cells, blocks, self.colouring, theme);
        let shown =
            ui.allocate_ui(room, |ui| self.picture.show(ui, ("table", key), blocks.size(), make)).inner;
        let under_pointer = shown.pixel.map(|pixel| blocks.first_touched(cells, pixel));
        if shown.response.clicked() {
            select(context, &queue, under_pointer);
        }
        if let Some(cell) = context.selection.cell {
            let mark = shown.rect_of(blocks.pixel(cell)).expand(3.0);
            let stroke = egui::Stroke::new(1.5, theme.selected_mark());
            ui.painter().rect_stroke(mark, 0.0, stroke, egui::StrokeKind::Outside);
        }
        if let Some(cell) = under_pointer.or(context.selection.cell) {
            ui.small(described(cells, cell));
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let queue = context.queue().map_err(|reason| reason.to_string())?;
        let all = queue.cells.as_ref().map_err(String::clone)?.len();
        let rows = (0..all).filter_map(move |at| {
            let LengthCell { cell, count, sum } = *queue.cells.as_ref().ok()?.get(at)?;
            Some(vec![cell.to_string(), count.to_string(), mean_length(sum, count).to_string()])
        });
        Ok(Data::new(&["cell", "count", "mean_length"], rows))
    }
}

/// Cells as pixels: blocks of cells with consecutive addresses, where the picture has fewer pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Blocks {
    /// Address bits of the table.
    bits: u32,
    /// Cells across a block, as a power of two.
    log2_side: u32,
}

impl Blocks {
    /// With pixels that are seen in a square of so many pixels.
    fn fitting(bits: u32, pixels: f32) -> Self {
        let log2_cells = bits.div_ceil(2);
        let log2_pixels = pixels.max(1.0).log2().floor() as u32;
        Self { bits, log2_side: log2_cells.saturating_sub(log2_pixels).min(bits / 2) }
    }

    fn size(self) -> [usize; 2] {
        [self.bits.div_ceil(2), self.bits / 2].map(|log2| 1 << (log2 - self.log2_side))
    }

    fn pixel(self, cell: u32) -> [u32; 2] {
        let (column, row) = pixel_of_cell(cell);
        [column >> self.log2_side, row >> self.log2_side]
    }

    /// The first touched cell of a pixel, or else the first one.
    fn first_touched(self, cells: &[LengthCell], [column, row]: [u32; 2]) -> u32 {
        let first = cell_of_pixel(column << self.log2_side, row << self.log2_side);
        let end = first + (1 << (2 * self.log2_side));
        let at = cells.partition_point(|cell| cell.cell < first);
        cells.get(at).map(|cell| cell.cell).filter(|&cell| cell < end).unwrap_or(first)
    }
}

/// Percent of the cells whose means are told apart; longer ones share the last colour.
const LONGEST_PERCENTILE: f32 = 98.0;

fn pixels(cells: &[LengthCell], blocks: Blocks, colouring: Colouring, theme: Theme) -> Vec<Color32> {
    // A damaged cell may count no ray at all.
    let cells = || cells.iter().filter(|cell| cell.count >= 2);
    let value = |cell: &LengthCell| match colouring {
        Colouring::Fill => 1.0,
        Colouring::Count => ((cell.count - 1) as f32).log2(),
        Colouring::Mean => mean_length(cell.sum, cell.count),
    };
    let values: Vec<f32> = cells().map(value).collect();
    let largest = ValueRange::of_percentiles(&values, 0.0, LONGEST_PERCENTILE).high.max(f32::MIN_POSITIVE);
    let [width, height] = blocks.size();
    let mut sums = vec![(0.0f32, 0u32); width * height];
    for (cell, value) in cells().zip(values) {
        let [column, row] = blocks.pixel(cell.cell);
        if let Some((sum, touched)) = sums.get_mut(row as usize * width + column as usize) {
            *sum += value;
            *touched += 1;
        }
    }
    let all = (1u32 << (2 * blocks.log2_side)) as f32;
    let colour = |(sum, touched): (f32, u32)| {
        let part = match (touched, colouring) {
            (0, _) => return theme.nothing(),
            (touched, Colouring::Fill) => touched as f32 / all,
            (touched, _) => sum / touched as f32 / largest,
        };
        // The first colours of the map are hard to tell from an untouched cell.
        let [red, green, blue] = ColourMap::Viridis.colour(0.2 + 0.8 * part);
        Color32::from_rgb(red, green, blue)
    };
    sums.into_iter().map(colour).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_consecutive_cells() {
        for bits in [8, 9, 20, 21] {
            let blocks = Blocks::fitting(bits, 100.0);
            let [width, height] = blocks.size();
            assert!(width <= 100 && (width * height) << (2 * blocks.log2_side) == 1 << bits, "{bits} bits");
            for cell in (0..1u32 << bits).step_by(97) {
                let first = blocks.first_touched(&[], blocks.pixel(cell));
                assert_eq!(first >> (2 * blocks.log2_side), cell >> (2 * blocks.log2_side));
                let touched = [LengthCell { cell, count: 2, sum: 1 }];
                assert_eq!(blocks.first_touched(&touched, blocks.pixel(cell)), cell);
            }
        }
    }
}
