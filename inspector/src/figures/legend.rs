//! The legend below the axes: one entry per series or line across a panel, whatever the panels.

use super::canvas::{Anchor, Canvas, Rectangle, Stroke, Text};
use super::model::{Content, Figure};
use super::style::{
    LINE_HEIGHT, LINE_STROKE, MARKER_RADIUS, REFERENCE_COLOUR, REFERENCE_DASHES, TEXT_SIZE, style,
};
use super::text;

const SAMPLE_WIDTH: f64 = 24.0;
const SAMPLE_GAP: f64 = 4.0;
const ENTRY_GAP: f64 = 14.0;
const ROW_HEIGHT: f64 = TEXT_SIZE * LINE_HEIGHT + 2.0;

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

/// The dash of the line across a panel with this number.
pub(crate) fn reference_stroke(number: usize) -> Stroke<'static> {
    Stroke { colour: REFERENCE_COLOUR, width: 0.9, dash: REFERENCE_DASHES[number % REFERENCE_DASHES.len()] }
}

/// An entry with its place in a row.
struct Placed {
    entry: Entry,
    lines: Vec<String>,
    left: f64,
    width: f64,
}

/// A legend that has been laid out.
pub(crate) struct Legend {
    rows: Vec<Vec<Placed>>,
    width: f64,
}

impl Legend {
    /// Entries in as many rows as they need.
    pub(crate) fn new(entries: Vec<Entry>, width: f64) -> Self {
        let mut rows: Vec<Vec<Placed>> = Vec::new();
        let mut left = f64::INFINITY;
        for entry in entries {
            let lines = text::wrap(&entry.label, TEXT_SIZE, width - SAMPLE_WIDTH - SAMPLE_GAP);
            let entry_width = SAMPLE_WIDTH + SAMPLE_GAP + text::widest(&lines, TEXT_SIZE);
            if left + entry_width > width {
                rows.push(Vec::new());
                left = 0.0;
            }
            let placed = Placed { entry, lines, left, width: entry_width };
            left += entry_width + ENTRY_GAP;
            if let Some(row) = rows.last_mut() {
                row.push(placed);
            }
        }
        Self { rows, width }
    }

    /// How much room it takes, points.
    pub(crate) fn height(&self) -> f64 {
        self.rows.iter().map(|row| row_height(row)).sum()
    }

    /// Draws it with its upper left corner here.
    pub(crate) fn draw(&self, canvas: &mut Canvas, left: f64, mut top: f64) {
        let used = self.rows.iter().filter_map(|row| row.last()).map(|last| last.left + last.width);
        let start = left + 0.5 * (self.width - used.fold(0.0, f64::max)).max(0.0);
        for row in &self.rows {
            for placed in row {
                draw_entry(canvas, placed, start + placed.left, top);
            }
            top += row_height(row);
        }
    }
}

fn row_height(row: &[Placed]) -> f64 {
    let lines = row.iter().map(|placed| placed.lines.len()).max().unwrap_or(1);
    ROW_HEIGHT + (lines.max(1) - 1) as f64 * TEXT_SIZE * LINE_HEIGHT
}

fn draw_entry(canvas: &mut Canvas, placed: &Placed, left: f64, top: f64) {
    let middle = top + 0.5 * ROW_HEIGHT;
    let (from, to) = ((left, middle), (left + SAMPLE_WIDTH, middle));
    let centre = (left + 0.5 * SAMPLE_WIDTH, middle);
    match placed.entry.sample {
        Sample::Line(number) => {
            let style = style(number);
            canvas.line(
                from,
                to,
                Stroke { colour: style.colour.ink(), width: LINE_STROKE, dash: style.dash },
            );
            canvas.marker(centre, MARKER_RADIUS, style.marker, style.colour, "");
        }
        Sample::Marker(number) => {
            let style = style(number);
            canvas.marker(centre, MARKER_RADIUS, style.marker, style.colour, "");
        }
        Sample::Bar(number) => {
            let style = style(number);
            let area =
                Rectangle { left: left + 3.0, top: middle - 4.0, width: SAMPLE_WIDTH - 5.0, height: 8.0 };
            canvas.bar(area, style.colour, style.hatch, "");
        }
        Sample::Reference(number) => canvas.line(from, to, reference_stroke(number)),
    }
    for (at, line) in placed.lines.iter().enumerate() {
        canvas.text(Text {
            text: line,
            place: (
                left + SAMPLE_WIDTH + SAMPLE_GAP,
                middle + 0.36 * TEXT_SIZE + at as f64 * TEXT_SIZE * LINE_HEIGHT,
            ),
            size: TEXT_SIZE,
            anchor: Anchor::Start,
            rotate_degrees: 0.0,
        });
    }
}
