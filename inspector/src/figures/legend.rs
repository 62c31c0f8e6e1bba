//! The legend below the axes: one entry per series or line across a panel, however many panels have it.

use super::model::{Content, Figure};
use super::style::{LINE_HEIGHT, TEXT_SIZE};
use super::svg::{Area, units, words};
use super::{FigureError, mark, text};

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
    /// A line across a panel with this dash.
    Reference(usize),
}

/// One thing that a figure shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) sample: Sample,
    pub(crate) label: String,
}

/// Everything that a figure shows, each once, in the order in which it appears: series first.
pub(crate) fn entries(figure: &Figure) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |entry: Entry| {
        if !entry.label.is_empty() && !entries.contains(&entry) {
            entries.push(entry);
        }
    };
    for panel in &figure.panels {
        let sample = match &panel.content {
            Content::Lines(_) => Sample::Line,
            Content::Scatter(_) => Sample::Marker,
            _ => Sample::Bar,
        };
        for series in panel.content.series() {
            add(Entry { sample: sample(series.style), label: series.label.clone() });
        }
    }
    for (number, label) in reference_labels(figure).into_iter().enumerate() {
        add(Entry { sample: Sample::Reference(number), label });
    }
    entries
}

/// The labels of the lines across panels, each once; its place decides the dash.
pub(crate) fn reference_labels(figure: &Figure) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for reference in figure.panels.iter().flat_map(|panel| &panel.references) {
        if !labels.contains(&reference.label) {
            labels.push(reference.label.clone());
        }
    }
    labels
}

/// An entry with its place in a row.
struct Placed {
    sample: Sample,
    /// Broken into lines.
    label: String,
    left: f64,
}

/// A legend that has been laid out.
pub(crate) struct Legend {
    rows: Vec<Vec<Placed>>,
    /// Of the widest row, points.
    used: f64,
    /// Of the room for it, points.
    width: f64,
}

impl Legend {
    /// Entries in as many rows as they need.
    pub(crate) fn new(entries: Vec<Entry>, width: f64) -> Self {
        let mut rows: Vec<Vec<Placed>> = Vec::new();
        let (mut left, mut used) = (f64::INFINITY, 0.0f64);
        for Entry { sample, label } in entries {
            let label = text::wrap(&label, TEXT_SIZE, width - SAMPLE_WIDTH - SAMPLE_GAP);
            let entry_width = SAMPLE_WIDTH + SAMPLE_GAP + text::width(&label, TEXT_SIZE);
            if left + entry_width > width {
                rows.push(Vec::new());
                left = 0.0;
            }
            used = used.max(left + entry_width);
            if let Some(row) = rows.last_mut() {
                row.push(Placed { sample, label, left });
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
            for placed in row {
                draw_entry(page, placed, start + placed.left, top)?;
            }
            top += row_height(row);
        }
        Ok(())
    }
}

fn row_height(row: &[Placed]) -> f64 {
    row.iter().map(|placed| text::height(&placed.label, TEXT_SIZE)).fold(0.0, f64::max) + ROW_GAP
}

fn draw_entry(page: &Area, placed: &Placed, left: f64, top: f64) -> Result<(), FigureError> {
    let middle = top + 0.5 * (TEXT_SIZE * LINE_HEIGHT + ROW_GAP);
    let at = |across: f64, down: f64| (units(left + across), units(middle + down));
    let ends = [at(0.0, 0.0), at(SAMPLE_WIDTH, 0.0)];
    let centre = at(0.5 * SAMPLE_WIDTH, 0.0);
    let no_tooltip = String::new();
    match placed.sample {
        Sample::Line(number) => {
            page.draw(&mark::line(ends.into(), number))?;
            page.draw(&mark::marker(centre, number, no_tooltip))?;
        }
        Sample::Marker(number) => page.draw(&mark::marker(centre, number, no_tooltip))?,
        Sample::Bar(number) => {
            let corners = [at(3.0, -4.0), at(SAMPLE_WIDTH - 2.0, 4.0)];
            page.draw(&mark::bar(corners, number, no_tooltip))?;
        }
        Sample::Reference(number) => page.draw(&mark::reference(ends, number))?,
    }
    let place = at(SAMPLE_WIDTH + SAMPLE_GAP, -0.5 * TEXT_SIZE * LINE_HEIGHT);
    page.draw_text(&placed.label, &words(TEXT_SIZE), place)?;
    Ok(())
}
