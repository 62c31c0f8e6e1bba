//! The words below an axis: level, broken into lines, slanted or upright, whatever fits.

use super::axis::Mapping;
use super::canvas::{Anchor, Canvas, Rectangle, Text};
use super::frame::{HALF_CAPITAL, LINE, TICK_GAP};
use super::style::TEXT_SIZE;
use super::text;

/// Between two labels beside each other, points.
const APART: f64 = 5.0;
/// Lines of a label, at most.
const MOST_LINES: usize = 3;

/// How labels are turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Direction {
    /// As all other words.
    Level,
    /// Rising at 45 degrees, ending at the tick.
    Slanted,
    /// Read from below.
    Upright,
}

/// One entry per tick: its lines, or none if it is left out.
#[derive(Clone, Debug)]
pub(crate) struct TickLabels {
    pub(crate) direction: Direction,
    labels: Vec<Vec<String>>,
}

impl TickLabels {
    /// Labels of categories on an axis of this width with `left` points beside it, turned by `least` or
    /// more.
    pub(crate) fn of_categories(names: &[String], width: f64, left: f64, least: Direction) -> Self {
        let slot = width / names.len().max(1) as f64;
        let wrapped: Vec<Vec<String>> =
            names.iter().map(|name| text::wrap(name, TEXT_SIZE, slot - APART)).collect();
        let fits =
            |lines: &Vec<String>| lines.len() <= MOST_LINES && text::widest(lines, TEXT_SIZE) <= slot - APART;
        if least == Direction::Level && wrapped.iter().all(fits) {
            return Self { direction: Direction::Level, labels: wrapped };
        }
        let whole = |stride: usize| {
            let is_shown = |at: usize| at.is_multiple_of(stride);
            let lines =
                |(at, name): (usize, &String)| if is_shown(at) { vec![name.clone()] } else { Vec::new() };
            names.iter().enumerate().map(lines).collect()
        };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let reaches_out = |(at, name): (usize, &String)| {
            let tick = left + (at as f64 + 0.5) * slot;
            (text::width(name, TEXT_SIZE) + TEXT_SIZE) * half > tick
        };
        let is_wide = slot * half >= LINE;
        if least <= Direction::Slanted && is_wide && !names.iter().enumerate().any(reaches_out) {
            return Self { direction: Direction::Slanted, labels: whole(1) };
        }
        Self { direction: Direction::Upright, labels: whole((LINE / slot).ceil().max(1.0) as usize) }
    }

    /// Whether all labels of a numeric axis have their place beside each other.
    pub(crate) fn fit_level(mapping: &Mapping, width: f64) -> bool {
        let mut end = f64::NEG_INFINITY;
        mapping.ticks.iter().filter(|tick| !tick.label.is_empty()).all(|tick| {
            let half = 0.5 * text::width(&tick.label, TEXT_SIZE);
            let centre = mapping.place(tick.value).unwrap_or(0.0) * width;
            let is_free = centre - half > end + APART;
            end = centre + half;
            is_free
        })
    }

    /// Labels of a numeric axis; those that would touch the one before are left out.
    pub(crate) fn of_numbers(mapping: &Mapping, width: f64) -> Self {
        let mut end = f64::NEG_INFINITY;
        let labels = mapping.ticks.iter().map(|tick| {
            let half = 0.5 * text::width(&tick.label, TEXT_SIZE);
            let centre = mapping.place(tick.value).unwrap_or(0.0) * width;
            if tick.label.is_empty() || centre - half <= end + APART {
                return Vec::new();
            }
            end = centre + half;
            vec![tick.label.clone()]
        });
        Self { direction: Direction::Level, labels: labels.collect() }
    }

    /// How far labels rise.
    pub(crate) fn degrees(&self) -> u32 {
        match self.direction {
            Direction::Level => 0,
            Direction::Slanted => 45,
            Direction::Upright => 90,
        }
    }

    /// Room below the axis without the gap, points.
    pub(crate) fn height(&self) -> f64 {
        let widest = self.labels.iter().map(|lines| text::widest(lines, TEXT_SIZE)).fold(0.0, f64::max);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        match self.direction {
            Direction::Level => self.labels.iter().map(Vec::len).max().unwrap_or(0) as f64 * LINE,
            Direction::Slanted => (widest + TEXT_SIZE) * half + 1.0,
            Direction::Upright => widest + 2.0,
        }
    }

    /// How far the last label reaches beyond the end of the axis, points.
    pub(crate) fn overhang(&self, mapping: &Mapping, width: f64) -> f64 {
        if self.direction != Direction::Level {
            return 0.0;
        }
        let ends = mapping.ticks.iter().zip(&self.labels).map(|(tick, lines)| {
            let centre = mapping.place(tick.value).unwrap_or(0.0) * width;
            centre + 0.5 * text::widest(lines, TEXT_SIZE) - width
        });
        ends.fold(0.0, f64::max)
    }

    /// Draws them below the plot area.
    pub(crate) fn draw(&self, canvas: &mut Canvas, mapping: &Mapping, plot: Rectangle) {
        for (tick, lines) in mapping.ticks.iter().zip(&self.labels) {
            let x = plot.left + mapping.place(tick.value).unwrap_or(0.0) * plot.width;
            let y = plot.bottom() + TICK_GAP;
            for (at, line) in lines.iter().enumerate() {
                let (place, anchor, rotate_degrees) = match self.direction {
                    Direction::Level => ((x, y + TEXT_SIZE + at as f64 * LINE), Anchor::Middle, 0.0),
                    Direction::Slanted => ((x + 0.25 * TEXT_SIZE, y + 0.5 * TEXT_SIZE), Anchor::End, -45.0),
                    Direction::Upright => ((x + HALF_CAPITAL * TEXT_SIZE, y), Anchor::End, -90.0),
                };
                canvas.text(Text { text: line, place, size: TEXT_SIZE, anchor, rotate_degrees });
            }
        }
    }
}
