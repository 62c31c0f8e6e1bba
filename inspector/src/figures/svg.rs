//! A figure as SVG: panels in a grid, the legend below them.
//!
//! plotters was meant to draw these. It has no tooltips, no hatches, no dashes but chains of strokes,
//! no slanted or wrapped labels, and whole pixels alone, so only its background would have been left.

use super::canvas::Canvas;
use super::frame::{Frame, LINE, Room};
use super::legend::{Legend, entries, reference_labels};
use super::model::{Content, Figure, Panel, Scale};
use super::style::Width;
use super::tick_labels::Direction;
use super::{FigureError, marks};

/// Between panels, points.
const GAP: f64 = 8.0;
/// Around the whole, points.
const EDGE: f64 = 3.0;
/// Highest picture, points.
const TALLEST_PICTURE: f64 = 300.0;
/// The least that a bar needs to be told from its neighbours, points.
const NARROWEST_BAR: f64 = 2.3;

/// Draws a figure. Ids in the SVG start with `prefix`, so that several can be part of one page.
///
/// # Errors
/// If the figure contradicts itself: see [`Figure::check`].
pub fn draw(figure: &Figure, width: Width, prefix: &str) -> Result<String, FigureError> {
    figure.check()?;
    let page = width.points();
    let Layout { columns, cell, frames } = layout(figure, width);
    let reference_labels = reference_labels(figure);
    let mut canvas = Canvas::new(prefix);
    let mut top = EDGE;
    for row in frames.chunks(columns) {
        let largest = |part: fn(&Frame) -> f64| row.iter().map(part).fold(0.0, f64::max);
        let above = largest(|frame| frame.top);
        for (at, frame) in row.iter().enumerate() {
            let left = EDGE + at as f64 * (cell + GAP) + frame.left;
            let plot = frame.draw(&mut canvas, left, top + above);
            marks::draw(&mut canvas, frame, plot, &reference_labels)?;
            frame.draw_colour_bar(&mut canvas, plot);
        }
        top += above + largest(|frame| frame.height + frame.bottom) + GAP;
    }
    let legend = Legend::new(entries(figure), page - 2.0 * EDGE);
    legend.draw(&mut canvas, EDGE, top - 0.5 * GAP);
    let height = top - GAP + legend.height() + 2.0 * EDGE;
    Ok(canvas.finish(page, height.ceil(), &figure.title))
}

/// The panels of a figure in their grid.
pub(crate) struct Layout<'a> {
    /// Panels beside each other.
    pub(crate) columns: usize,
    /// Width of one with all that stands around it, points.
    pub(crate) cell: f64,
    /// All of them, row by row.
    pub(crate) frames: Vec<Frame<'a>>,
}

/// Measures all panels.
pub(crate) fn layout(figure: &Figure, width: Width) -> Layout<'_> {
    let columns = columns(figure, width);
    let cell = (width.points() - 2.0 * EDGE - (columns - 1) as f64 * GAP) / columns as f64;
    Layout { columns, cell, frames: measure(figure, columns, cell) }
}

/// Panels beside each other.
fn columns(figure: &Figure, width: Width) -> usize {
    let panels = figure.panels.len().max(1);
    if panels.is_multiple_of(2) && figure.panels.iter().all(is_picture) {
        // A picture and what belongs to it stand beside each other.
        return 2;
    }
    let most = match (width, panels) {
        (Width::OneColumn, 1..=3) => 1,
        (Width::OneColumn, _) => 2,
        (Width::TwoColumn, 4) => 2,
        (Width::TwoColumn, _) => panels.min(3),
    };
    let widest = figure.panels.iter().map(least_width).fold(0.0, f64::max);
    (2..=most).rev().find(|&columns| width.points() / columns as f64 >= widest).unwrap_or(1)
}

/// How much room a panel needs for its bars and the words beside them, points.
fn least_width(panel: &Panel) -> f64 {
    let Scale::Categories(names) = &panel.x.scale else { return 110.0 };
    let bars = match &panel.content {
        Content::Bars(series) => names.len() * (series.len() + 1),
        _ => 2 * names.len(),
    };
    // No name is left out for want of room.
    50.0 + (bars as f64 * NARROWEST_BAR).max(names.len() as f64 * LINE)
}

/// All panels, those above each other lined up.
fn measure(figure: &Figure, columns: usize, cell: f64) -> Vec<Frame<'_>> {
    let height = (0.62 * cell).clamp(90.0, 180.0);
    let room_of = |panel: &Panel| Room {
        cell_width: cell,
        height: if is_picture(panel) { (1.3 * cell).min(TALLEST_PICTURE) } else { height },
        left: 0.0,
        turn: Direction::Level,
    };
    let mut rooms: Vec<Room> = figure.panels.iter().map(room_of).collect();
    // What one panel needs, those beside or below it get: room on the left, turned labels, low pictures.
    // Turned labels may need more room on the left, and lower pictures lower colour bars.
    for _ in 0..2 {
        let frames = figure.panels.iter().zip(&rooms);
        let frames: Vec<Frame> = frames.map(|(panel, &room)| Frame::measure(figure, panel, room)).collect();
        let turn = frames.iter().map(|frame| frame.x_ticks.direction).max().unwrap_or(Direction::Level);
        for (at, (room, frame)) in rooms.iter_mut().zip(&frames).enumerate() {
            let above = frames.iter().skip(at % columns).step_by(columns);
            room.left = above.map(|frame| frame.left).fold(0.0, f64::max);
            room.turn = turn;
            if is_picture(frame.panel) {
                let row = frames.chunks(columns).nth(at / columns).unwrap_or_default();
                let pictures = row.iter().filter(|frame| is_picture(frame.panel));
                room.height = pictures.map(|frame| frame.height).fold(room.height, f64::min);
            }
        }
    }
    figure.panels.iter().zip(rooms).map(|(panel, room)| Frame::measure(figure, panel, room)).collect()
}

fn is_picture(panel: &Panel) -> bool {
    matches!(panel.content, Content::Picture(_))
}
