//! The words at the ticks below an axis: level, broken into lines, slanted or upright, as they fit.

use super::axis::Mapping;
use super::style::{LINE_HEIGHT, TEXT_SIZE};
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

impl Direction {
    /// How far labels rise.
    pub(crate) fn degrees(self) -> i32 {
        match self {
            Self::Level => 0,
            Self::Slanted => 45,
            Self::Upright => 90,
        }
    }
}

/// Breaks the labels of categories, or leaves some out, so that they fit on an axis of this width with
/// `left` points beside it, turned by `least` or more.
pub(crate) fn fit_categories(axis: &mut Mapping, width: f64, left: f64, least: Direction) -> Direction {
    let slot = width / axis.ticks.len().max(1) as f64;
    let wrapped: Vec<String> =
        axis.ticks.iter().map(|tick| text::wrap(&tick.label, TEXT_SIZE, slot - APART)).collect();
    let fits =
        |label: &String| label.lines().count() <= MOST_LINES && text::width(label, TEXT_SIZE) <= slot - APART;
    if least == Direction::Level && wrapped.iter().all(fits) {
        axis.ticks.iter_mut().zip(wrapped).for_each(|(tick, label)| tick.label = label);
        return Direction::Level;
    }
    let line = TEXT_SIZE * LINE_HEIGHT;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let reaches_out = axis.ticks.iter().enumerate().any(|(at, tick)| {
        (text::width(&tick.label, TEXT_SIZE) + TEXT_SIZE) * half > left + (at as f64 + 0.5) * slot
    });
    if least <= Direction::Slanted && slot * half >= line && !reaches_out {
        return Direction::Slanted;
    }
    let stride = (line / slot).ceil().max(1.0) as usize;
    for (_, tick) in axis.ticks.iter_mut().enumerate().filter(|(at, _)| !at.is_multiple_of(stride)) {
        tick.label.clear();
    }
    Direction::Upright
}

/// Leaves out labels of a numeric axis that would touch the one before; gives whether there were any.
pub(crate) fn thin_out(axis: &mut Mapping, width: f64) -> bool {
    let mut end = f64::NEG_INFINITY;
    let mut are_some_left_out = false;
    let places: Vec<f64> =
        axis.ticks.iter().map(|tick| axis.place(tick.value).unwrap_or(0.0) * width).collect();
    for (tick, centre) in axis.ticks.iter_mut().zip(places).filter(|(tick, _)| !tick.label.is_empty()) {
        let half = 0.5 * text::width(&tick.label, TEXT_SIZE);
        if centre - half > end + APART {
            end = centre + half;
        } else {
            tick.label.clear();
            are_some_left_out = true;
        }
    }
    are_some_left_out
}

/// Room below the axis without the gap, points.
pub(crate) fn height(axis: &Mapping, direction: Direction) -> f64 {
    let largest = |size: fn(&str, f64) -> f64| {
        axis.ticks.iter().map(|tick| size(&tick.label, TEXT_SIZE)).fold(0.0, f64::max)
    };
    match direction {
        Direction::Level => largest(text::height),
        Direction::Slanted => (largest(text::width) + TEXT_SIZE) * std::f64::consts::FRAC_1_SQRT_2 + 1.0,
        Direction::Upright => largest(text::width) + 2.0,
    }
}

/// How far level labels reach beyond the end of the axis, points.
pub(crate) fn overhang(axis: &Mapping, width: f64) -> f64 {
    let end = |value: f64, label: &str| {
        axis.place(value).unwrap_or(0.0) * width + 0.5 * text::width(label, TEXT_SIZE) - width
    };
    axis.ticks.iter().map(|tick| end(tick.value, &tick.label)).fold(0.0, f64::max)
}
