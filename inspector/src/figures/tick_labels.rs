//! The words at the ticks below an axis, as they fit.

use super::axis::Mapping;
use super::style::TEXT_SIZE;
use super::text;

/// Between two labels beside each other, points.
const APART: f64 = 5.0;

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
pub(crate) fn height(axis: &Mapping) -> f64 {
    axis.ticks.iter().map(|tick| text::height(&tick.label, TEXT_SIZE)).fold(0.0, f64::max)
}

/// How far labels reach beyond the end of the axis, points.
pub(crate) fn overhang(axis: &Mapping, width: f64) -> f64 {
    let end = |value: f64, label: &str| {
        axis.place(value).unwrap_or(0.0) * width + 0.5 * text::width(label, TEXT_SIZE) - width
    };
    axis.ticks.iter().map(|tick| end(tick.value, &tick.label)).fold(0.0, f64::max)
}
