//! The length table as a picture: cells whose addresses are near lie near each other.

use std::sync::Arc;

use egui::Color32;
use formats::length_table::{LengthCell, mean_length};
use formats::manifest::QueueId;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::notes::found;
use super::picture::Picture;
use super::table_plots::{EstimatePlot, histograms};
use crate::colour_map::ColourMap;
use crate::model::{Context, Queue};
use crate::output::{count, counted};
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::render::cell_box::{cell_of_pixel, pixel_of_cell};
use crate::render::range::Values;
use crate::theme::Theme;

/// What is shown of the table: its cells as a picture, by one of their numbers, or plots of all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TableView {
    #[default]
    Mean,
    Count,
    Fill,
    Histograms,
    Estimates,
}

/// What can be shown: what it is called, and what it is.
const VIEWS: [(TableView, &str, &str); 5] = [
    (
        TableView::Mean,
        "mean length",
        "Mean of the lengths added, over the longest mean; a dummy of 0.25 counts",
    ),
    (TableView::Count, "count", "Rays added, by powers of two"),
    (TableView::Fill, "fill", "Cells that any ray was added to"),
    (TableView::Histograms, "histograms", "How many cells have how many rays, and which mean length"),
    (TableView::Estimates, "estimates", "Lengths that the table gives for these rays, against traced ones"),
];

#[derive(Default)]
pub(super) struct TablePanel {
    view: TableView,
    estimates: EstimatePlot,
    /// The cell whose first ray is to be selected as soon as it is known.
    chosen: Option<u32>,
    picture: Picture<(u64, QueueId, TableView, bool, Blocks)>,
}

impl Panel for TablePanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(queue) = found(ui, context.queue()) else { return };
        let Some(cells) = found(ui, queue.cells.as_deref()) else { return };
        let Some(bits) = context.recording().map(|open| open.dump.manifest().header.options.table_bits)
        else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            for (view, name, about) in VIEWS {
                ui.selectable_value(&mut self.view, view, name).on_hover_text(about);
            }
            let (touched, all) = (cells.len() as u64, 1u64 << bits);
            let fill = 100.0 * touched as f64 / all as f64;
            let fill = format!("{} of {} cells touched ({fill:.1} %)", count(touched), count(all));
            ui.add(egui::Label::new(egui::RichText::new(fill).weak()).extend());
        });
        match self.view {
            TableView::Histograms => histograms(ui, cells),
            TableView::Estimates => self.estimates.show(ui, context),
            TableView::Mean | TableView::Count | TableView::Fill => self.cells(ui, context, &queue, bits),
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

    fn state(&self) -> serde_json::Value {
        serde_json::json!({ "view": self.view })
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        self.view = serde_json::from_value(state["view"].clone())?;
        Ok(())
    }
}

impl TablePanel {
    /// The cells as a picture, and what is in the one under the pointer or in the selected one.
    fn cells(&mut self, ui: &mut egui::Ui, context: &mut Context, queue: &Arc<Queue>, bits: u32) {
        let Ok(cells) = &queue.cells else { return };
        let lines = ui.text_style_height(&egui::TextStyle::Small) + 2.0 * ui.spacing().interact_size.y + 16.0;
        let room = ui.available_size() - egui::vec2(0.0, lines);
        let blocks = Blocks::fitting(bits, room.min_elem() * ui.ctx().pixels_per_point());
        let Some(opening) = context.recording().map(|recording| recording.opening) else { return };
        let theme = Theme::of(ui.ctx());
        let view = self.view;
        let key = (opening, queue.id, view, ui.visuals().dark_mode, blocks);
        let of = queue.clone();
        let make = move || of.cells.as_ref().map_or(Vec::new(), |cells| pixels(cells, blocks, view, theme));
        let picture =
            |ui: &mut egui::Ui| self.picture.show(ui, context.waker(), ("table", key), blocks.size(), make);
        let shown = ui.allocate_ui(room, picture).inner;
        let under_pointer = shown.pixel.map(|pixel| blocks.first_touched(cells, pixel));
        if shown.response.clicked() {
            context.selection.cell = under_pointer;
            self.chosen = under_pointer;
        }
        if let Some(cell) = context.selection.cell {
            let mark = shown.rect_of(blocks.pixel(cell)).expand(3.0);
            let stroke = egui::Stroke::new(1.5, theme.selected_mark());
            ui.painter().rect_stroke(mark, 0.0, stroke, egui::StrokeKind::Outside);
        }
        if let Some(cell) = under_pointer.or(context.selection.cell) {
            ui.small(described(cells, cell));
        }
        if let Some(cell) = context.selection.cell {
            self.rays_of(ui, context, cell);
        }
    }

    /// The rays of the queue that find their length in a cell: the first of them, and all as a filter.
    fn rays_of(&mut self, ui: &mut egui::Ui, context: &mut Context, cell: u32) {
        let Some(rays) = context.rays_of_cell(cell) else {
            ui.spinner();
            return;
        };
        if self.chosen.take() == Some(cell) {
            context.select_ray(rays.first().map(|&ray| ray as usize));
        }
        let mut next = None;
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{} of this queue", counted(rays.len() as u64, "ray", "rays")))
                .on_hover_text("Rays of the queue whose length the selected cell estimates");
            let filter = format!("cell == {cell:#x}");
            let is_filter = context.selection.filter.text() == filter;
            let button = egui::Button::selectable(is_filter, "filter these");
            let about = "Shows these rays alone, here and in the other panels; again: all rays";
            if ui.add_enabled(!rays.is_empty(), button).on_hover_text(about).clicked() {
                context.selection.filter.set(if is_filter { "" } else { &filter });
            }
            for &ray in rays.iter().take(LISTED) {
                let is_now = context.selection.ray == Some(ray as usize);
                if ui.selectable_label(is_now, ray.to_string()).clicked() {
                    next = Some(ray as usize);
                }
            }
            if rays.len() > LISTED {
                ui.weak("...");
            }
        });
        if next.is_some() {
            context.select_ray(next);
        }
    }
}

/// Rays of a cell that are listed one by one.
const LISTED: usize = 5;

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

fn pixels(cells: &[LengthCell], blocks: Blocks, view: TableView, theme: Theme) -> Vec<Color32> {
    // A damaged cell may count no ray at all.
    let cells = || cells.iter().filter(|cell| cell.count >= 2);
    let value = |cell: &LengthCell| match view {
        TableView::Fill => 1.0,
        TableView::Count => ((cell.count - 1) as f32).log2(),
        _ => mean_length(cell.sum, cell.count),
    };
    let values: Vec<f32> = cells().map(value).collect();
    let sorted = Values::of(values.par_iter().copied());
    let largest = sorted.percentiles(0.0, LONGEST_PERCENTILE).high.max(f32::MIN_POSITIVE);
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
        let part = match (touched, view) {
            (0, _) => return theme.nothing(),
            (touched, TableView::Fill) => touched as f32 / all,
            (touched, _) => sum / touched as f32 / largest,
        };
        // The first colours of the map are hard to tell from an untouched cell.
        let [red, green, blue] = ColourMap::Viridis.colour(0.2 + 0.8 * part);
        Color32::from_rgb(red, green, blue)
    };
    sums.into_iter().map(colour).collect()
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
