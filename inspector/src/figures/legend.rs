//! The legend below the axes: one entry per series or line across a panel, however many panels have it.

use super::model::{Content, Figure, Panel, Scale, Series};
use super::style::{LINE_HEIGHT, TEXT_SIZE};
use super::svg::{Area, text_style, units};
use super::{FigureError, mark, text};
use crate::analysis::summary::distinct;

const SAMPLE_WIDTH: f64 = 24.0;
const SAMPLE_GAP: f64 = 4.0;
const ENTRY_GAP: f64 = 14.0;
/// Between two rows.
const ROW_GAP: f64 = 2.0;

/// What is drawn before the words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sample {
    /// A line with a marker of this style.
    Line(usize),
    /// A marker of this style.
    Marker(usize),
    /// A bar of this style.
    Bar(usize),
    /// A line across a panel.
    Reference,
}

/// One thing that a figure shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LegendEntry {
    pub(crate) sample: Sample,
    pub(crate) label: String,
}

/// Everything that a figure shows, each once, in the order in which it appears: series first, unless they are named
/// beside it.
pub(crate) fn entries(figure: &Figure, has_names_beside: bool) -> Vec<LegendEntry> {
    let series = figure.panels.iter().filter(|_| !has_names_beside).flat_map(|panel| {
        let sample = match &panel.content {
            Content::Lines(_) => Sample::Line,
            Content::Scatter(_) | Content::Dots(_) => Sample::Marker,
            _ => Sample::Bar,
        };
        let entry = move |one: &Series| LegendEntry { sample: sample(one.style), label: one.label.clone() };
        panel.content.series().iter().filter(|series| !is_named_by_row(panel, series)).map(entry)
    });
    let references = figure.panels.iter().flat_map(|panel| &panel.reference);
    let references =
        references.map(|one| LegendEntry { sample: Sample::Reference, label: one.label.clone() });
    distinct(series.chain(references).filter(|entry| !entry.label.is_empty()))
}

/// Whether a row says what a series is, or what it is a part of.
fn is_named_by_row(panel: &Panel, series: &Series) -> bool {
    let Content::Dots(_) = panel.content else { return false };
    let rows = if let Scale::Categories(names) = &panel.x.scale { names.as_slice() } else { &[] };
    series.is_part || rows.contains(&series.label)
}

/// A legend that has been laid out.
pub(crate) struct Legend {
    /// Entries, their labels broken into lines, each with its place from the left.
    rows: Vec<Vec<(f64, LegendEntry)>>,
    /// Of the widest row, points.
    used: f64,
    /// Of the room for it, points.
    width: f64,
}

impl Legend {
    /// Entries in as many rows as they need.
    pub(crate) fn new(entries: Vec<LegendEntry>, width: f64) -> Self {
        let mut rows: Vec<Vec<(f64, LegendEntry)>> = Vec::new();
        let (mut left, mut used) = (f64::INFINITY, 0.0f64);
        for LegendEntry { sample, label } in entries {
            let label = text::wrap(&label, TEXT_SIZE, width - SAMPLE_WIDTH - SAMPLE_GAP);
            let entry_width = SAMPLE_WIDTH + SAMPLE_GAP + text::width(&label, TEXT_SIZE);
            if left + entry_width > width {
                rows.push(Vec::new());
                left = 0.0;
            }
            used = used.max(left + entry_width);
            if let Some(row) = rows.last_mut() {
                row.push((left, LegendEntry { sample, label }));
            }
            left += entry_width + ENTRY_GAP;
        }
        Self { rows, used, width }
    }

    /// How much room it takes, points.
    pub(crate) fn height(&self) -> f64 {
        self.rows.iter().map(|row| row_height(row)).sum()
    }

    /// Draws it with its upper left corner here, points.
    ///
    /// # Errors
    /// As plotters: none is known.
    pub(crate) fn draw(&self, page: &Area, (left, mut top): (f64, f64)) -> Result<(), FigureError> {
        let start = left + 0.5 * (self.width - self.used).max(0.0);
        for row in &self.rows {
            for (left, entry) in row {
                draw_entry(page, entry, start + left, top)?;
            }
            top += row_height(row);
        }
        Ok(())
    }
}

fn row_height(row: &[(f64, LegendEntry)]) -> f64 {
    row.iter().map(|(_, entry)| text::height(&entry.label, TEXT_SIZE)).fold(0.0, f64::max) + ROW_GAP
}

fn draw_entry(page: &Area, entry: &LegendEntry, left: f64, top: f64) -> Result<(), FigureError> {
    let middle = top + 0.5 * (TEXT_SIZE * LINE_HEIGHT + ROW_GAP);
    let at = |across: f64, down: f64| (units(left + across), units(middle + down));
    let ends = [at(0.0, 0.0), at(SAMPLE_WIDTH, 0.0)];
    let centre = at(0.5 * SAMPLE_WIDTH, 0.0);
    let no_tooltip = String::new();
    match entry.sample {
        Sample::Line(number) => {
            page.draw(&mark::line(ends.into(), number))?;
            page.draw(&mark::marker(centre, number, no_tooltip))?;
        }
        Sample::Marker(number) => page.draw(&mark::marker(centre, number, no_tooltip))?,
        Sample::Bar(number) => {
            let corners = [at(3.0, -4.0), at(SAMPLE_WIDTH - 2.0, 4.0)];
            page.draw(&mark::bar(corners, number, no_tooltip))?;
        }
        Sample::Reference => page.draw(&mark::reference(ends))?,
    }
    let place = at(SAMPLE_WIDTH + SAMPLE_GAP, -0.5 * TEXT_SIZE * LINE_HEIGHT);
    page.draw_text(&entry.label, &text_style(TEXT_SIZE), place)?;
    Ok(())
}
