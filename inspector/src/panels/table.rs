//! The length table as a picture: cells whose addresses are near lie near each other, and parts of the table that no
//! ray came to are left out.

use std::sync::Arc;

use formats::length_table::{LengthCell, TABLE_BITS_MAX, mean_length};
use formats::manifest::QueueId;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::colour_bar;
use super::estimate_plot::{self, EstimatePlot};
use super::notes::{found, select};
use super::picture::{Painted, Picture};
use super::table_fill::{self, FillPlot};
use crate::colour_map::ColourMap;
use crate::model::{Context, Queue};
use crate::output::{count, counted};
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::render::cell_box::{cell_of_pixel, pixel_of_cell};
use crate::render::range::Values;
use crate::theme::{Theme, opaque};

/// What is shown of the table: its cells as a picture, by one of their numbers, or how right they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TableView {
    #[default]
    #[serde(alias = "fill")]
    Mean,
    #[serde(alias = "histograms")]
    Count,
    Estimates,
}

/// What can be shown: what it is called, and what it is.
const VIEWS: [(TableView, &str, &str); 3] = [
    (TableView::Mean, "mean length", "Mean of the lengths added to a cell; a dummy of 0.25 counts"),
    (TableView::Count, "count", "Rays added to a cell"),
    (TableView::Estimates, "estimates", "Lengths that the table gives for these rays, against traced ones"),
];

#[derive(Default)]
pub(super) struct TablePanel {
    view: TableView,
    estimates: EstimatePlot,
    /// The cell whose first ray is to be selected as soon as it is known.
    chosen: Option<u32>,
    picture: Picture<(u64, QueueId, TableView, bool, Arc<Blocks>)>,
    fill: FillPlot,
    /// Of which recording, queue and size of the picture, and the blocks.
    blocks: Option<((u64, QueueId, egui::Vec2), Arc<Blocks>)>,
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
            let (touched, all) = (count(cells.len() as u64), count(1u64 << bits));
            let touched = format!("{touched} of {all} cells touched; parts without any are left out");
            ui.add(egui::Label::new(egui::RichText::new(touched).weak()).truncate());
        });
        if cells.is_empty() {
            ui.label("No ray was added before this bounce: two-point-adaptive assumes the same length, 0.25, for all.");
        } else {
            ui.horizontal_wrapped(|ui| estimate_plot::worth(ui, context));
        }
        match self.view {
            TableView::Estimates => self.estimates.show(ui, context),
            TableView::Mean | TableView::Count => self.cells(ui, context, &queue),
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let queue = context.queue()?;
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
    fn cells(&mut self, ui: &mut egui::Ui, context: &mut Context, queue: &Arc<Queue>) {
        let Ok(cells) = &queue.cells else { return };
        let rows = if context.selection.cell.is_some() { 2.0 } else { 0.0 };
        let lines =
            ui.text_style_height(&egui::TextStyle::Small) + rows * ui.spacing().interact_size.y + 24.0;
        let below = lines + table_fill::HEIGHT + colour_bar::height(ui);
        let room = (ui.available_size() - egui::vec2(0.0, below)).max(egui::vec2(64.0, 64.0));
        let Some(opening) = context.recording().map(|recording| recording.opening) else { return };
        let (view, theme) = (self.view, Theme::of(ui.ctx()));
        let room_pixels = (room * ui.ctx().pixels_per_point()).round();
        let of_table = (opening, queue.id, room_pixels);
        let blocks = match &self.blocks {
            Some((known, blocks)) if *known == of_table => blocks,
            _ => &self.blocks.insert((of_table, Arc::new(Blocks::of(cells, room_pixels)))).1,
        };
        let key = (opening, queue.id, view, ui.visuals().dark_mode, blocks.clone());
        let (of, within) = (queue.clone(), blocks.clone());
        let make = move || paint(of.cells.as_deref().unwrap_or_default(), &within, view, theme);
        let picture =
            |ui: &mut egui::Ui| self.picture.show(ui, context.waker(), ("table", key), blocks.size(), make);
        let shown = ui.allocate_ui(room, picture).inner;
        let under_pointer = shown.pixel.and_then(|pixel| blocks.first_touched(cells, pixel));
        if shown.response.clicked() {
            context.selection.cell = under_pointer;
            self.chosen = under_pointer;
        }
        if let Some(pixel) = context.selection.cell.and_then(|cell| blocks.pixel(cell)) {
            let stroke = egui::Stroke::new(1.5, theme.selected_mark());
            let mark = shown.rect_of(pixel).expand(3.0);
            shown.painter.rect_stroke(mark, 0.0, stroke, egui::StrokeKind::Outside);
        }
        let (logarithm, title) = match view {
            TableView::Count => (Some(10.0), "rays added to a cell"),
            _ => (None, "mean length in the cell, unit lengths"),
        };
        self.picture.legend(ui, MAP, logarithm, title);
        self.fill.show(ui, context);
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
                let is_now = context.selection.rays().contains(&(ray as usize));
                if ui.selectable_label(is_now, ray.to_string()).clicked() {
                    next = Some(ray as usize);
                }
            }
            if rays.len() > LISTED {
                ui.weak("...");
            }
        });
        if next.is_some() {
            select(ui, context, next);
        }
    }
}

/// Rays of a cell that are listed one by one.
const LISTED: usize = 5;

/// Pixels across a block, of which each has the cells of consecutive addresses.
const BLOCK: u32 = 16;
/// The same and the gap to the next one.
const STEP: u32 = BLOCK + 1;

/// The blocks of the table that have touched cells, in rows by their addresses.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Blocks {
    /// Cells across a pixel, as a power of two: more than one where there are more than are seen.
    log2_side: u32,
    /// Addresses of cells over the cells of a block, ascending.
    touched: Vec<u32>,
    columns: u32,
}

impl Blocks {
    /// For a picture in so many pixels.
    fn of(cells: &[LengthCell], room: egui::Vec2) -> Self {
        let with = |log2_side: u32| {
            let mut touched: Vec<u32> =
                cells.iter().map(|cell| cell.cell >> (2 * (BLOCK.ilog2() + log2_side))).collect();
            touched.dedup();
            let columns = (touched.len() as f32 * room.x / room.y).sqrt().ceil().max(1.0) as u32;
            Self { log2_side, touched, columns }
        };
        let mut blocks = with(0);
        // At the latest the largest table is one block.
        while (blocks.columns * STEP) as f32 > room.x.max(256.0) && blocks.bits() < TABLE_BITS_MAX {
            blocks = with(blocks.log2_side + 1);
        }
        blocks
    }

    fn size(&self) -> [usize; 2] {
        let rows = (self.touched.len() as u32).div_ceil(self.columns).max(1);
        [self.columns, rows].map(|blocks| (blocks * STEP - 1) as usize)
    }

    /// Address bits of a block's cells.
    fn bits(&self) -> u32 {
        2 * (BLOCK.ilog2() + self.log2_side)
    }

    /// The pixel of a cell; `None` if its block has no touched one.
    fn pixel(&self, cell: u32) -> Option<[u32; 2]> {
        let at = self.touched.binary_search(&(cell >> self.bits())).ok()? as u32;
        let (column, row) = pixel_of_cell(cell & ((1 << self.bits()) - 1));
        let within = |along: u32| along >> self.log2_side;
        Some([at % self.columns * STEP + within(column), at / self.columns * STEP + within(row)])
    }

    /// The first touched cell of a pixel, or else its first one; `None` between blocks.
    fn first_touched(&self, cells: &[LengthCell], [column, row]: [u32; 2]) -> Option<u32> {
        if column % STEP == BLOCK || row % STEP == BLOCK {
            return None;
        }
        let block = self.touched.get((row / STEP * self.columns + column / STEP) as usize)?;
        let within = [column, row].map(|along| (along % STEP) << self.log2_side);
        let first = block << self.bits() | cell_of_pixel(within[0], within[1]);
        let end = first + (1 << (2 * self.log2_side));
        let at = cells.partition_point(|cell| cell.cell < first);
        Some(cells.get(at).map(|cell| cell.cell).filter(|&cell| cell < end).unwrap_or(first))
    }
}

/// The colours of cells, those that they have in space.
const MAP: ColourMap = ColourMap::Turbo;

/// A pixel has the mean of its touched cells.
fn paint(cells: &[LengthCell], blocks: &Blocks, view: TableView, theme: Theme) -> Painted {
    // A damaged cell may count no ray at all.
    let cells = || cells.iter().filter(|cell| cell.count >= 2);
    let value = |cell: &LengthCell| match view {
        TableView::Count => ((cell.count - 1) as f32).log10(),
        _ => mean_length(cell.sum, cell.count),
    };
    let values = Values::of(cells().map(value).collect::<Vec<f32>>().into_par_iter());
    let range = values.percentiles(2.0, 98.0);
    let [width, height] = blocks.size();
    let mut sums = vec![(0.0f32, 0u32); width * height];
    for cell in cells() {
        if let Some([column, row]) = blocks.pixel(cell.cell) {
            let (sum, touched) = &mut sums[row as usize * width + column as usize];
            *sum += value(cell);
            *touched += 1;
        }
    }
    let is_gap = |at: usize| {
        at % width % STEP as usize == BLOCK as usize || at / width % STEP as usize == BLOCK as usize
    };
    let colour = |(at, (sum, touched)): (usize, (f32, u32))| match touched {
        0 if is_gap(at) => theme.left_out(),
        0 => theme.nothing(),
        touched => opaque(MAP.colour(range.part(sum / touched as f32))),
    };
    let pixels = sums.into_iter().enumerate().map(colour).collect();
    Painted { pixels, range, values }
}

fn described(cells: &[LengthCell], cell: u32) -> String {
    match cells.binary_search_by_key(&cell, |known| known.cell) {
        Ok(at) if cells[at].count >= 2 => {
            let LengthCell { count: with_dummy, sum, .. } = cells[at];
            let mean = mean_length(sum, with_dummy);
            let rays = counted(u64::from(with_dummy) - 1, "ray", "rays");
            format!("cell {cell:05x}: {rays}, mean length {mean:.4}")
        }
        _ => format!("cell {cell:05x}: no ray yet, so a length of 0.25 is assumed"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cell_is_in_a_pixel_of_its_own_block() {
        let cells: Vec<LengthCell> =
            [0, 255, 256, 70_000, 70_001, 0xf_ffff].map(|cell| LengthCell { cell, count: 2, sum: 1 }).into();
        for room in [egui::vec2(400.0, 300.0), egui::vec2(1000.0, 20.0), egui::vec2(8.0, 900.0)] {
            let blocks = Blocks::of(&cells, room);
            let mut pixels: Vec<[u32; 2]> = Vec::new();
            for LengthCell { cell, .. } in &cells {
                let pixel = blocks.pixel(*cell).unwrap();
                assert!((0..2).all(|along| (pixel[along] as usize) < blocks.size()[along]), "{pixel:?}");
                assert_eq!(blocks.first_touched(&cells, pixel), Some(*cell));
                pixels.push(pixel);
            }
            pixels.sort_unstable();
            pixels.dedup();
            assert_eq!(pixels.len(), cells.len());
            // No block without a touched cell, and none between blocks.
            assert_eq!((blocks.touched.len(), blocks.pixel(1000)), (4, None));
            assert_eq!(blocks.first_touched(&cells, [BLOCK, 0]), None);
        }
    }

    #[test]
    fn a_full_table_fits() {
        let cells: Vec<LengthCell> = (0..1 << 20).map(|cell| LengthCell { cell, count: 2, sum: 1 }).collect();
        let blocks = Blocks::of(&cells, egui::vec2(500.0, 400.0));
        let [width, height] = blocks.size();
        assert!(width <= 500 && height <= 500, "{width} x {height}");
        let first = blocks.first_touched(&cells, blocks.pixel(0x5_4321).unwrap()).unwrap();
        assert_eq!(first >> (2 * blocks.log2_side), 0x5_4321 >> (2 * blocks.log2_side));
    }
}
