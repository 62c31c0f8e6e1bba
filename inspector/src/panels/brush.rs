//! Dragging along the axis of a number: the rays within that range alone pass the filter, in all panels.

use egui::{Rect, Response, Ui};
use formats::metrics::quantity::Quantity;

use crate::model::Context;
use crate::theme::Theme;

/// Of the colour of what is selected, behind which numbers are still read.
const OPACITY: f32 = 0.25;

/// Marks what is dragged over, and sets the filter once it is let go; what reaches an end of the axis is open there. A
/// click takes that filter away. `value_at` is the number at a horizontal place of the screen.
pub(super) fn brush(
    ui: &Ui,
    response: &Response,
    (quantity, value_at): (Quantity, impl Fn(f32) -> f64),
    context: &mut Context,
) {
    let (name, rect) = (quantity.name(), response.rect);
    let filter = &mut context.selection.filter;
    if response.clicked() && filter.text().starts_with(name) {
        filter.set("");
    }
    let id = response.id.with("brush");
    if response.drag_started() {
        let from = ui.input(|input| input.pointer.press_origin()).map(|from| from.x);
        ui.data_mut(|data| data.insert_temp(id, from));
    }
    let from: Option<f32> = ui.data(|data| data.get_temp(id)).flatten();
    let (Some(from), Some(to)) = (from, response.interact_pointer_pos().map(|to| to.x)) else { return };
    let band = Rect::from_x_y_ranges(from.min(to)..=from.max(to), rect.y_range()).intersect(rect);
    if response.dragged() {
        let colour = Theme::of(ui.ctx()).selected_mark().gamma_multiply(OPACITY);
        ui.painter().rect_filled(band, 0.0, colour);
    }
    if response.drag_stopped() {
        let bound = |at: f32, sign: &str| format!("{name} {sign} {}", rounded(value_at(at)));
        let low = (band.left() > rect.left()).then(|| bound(band.left(), ">="));
        let high = (band.right() < rect.right()).then(|| bound(band.right(), "<="));
        let bounds: Vec<String> = low.into_iter().chain(high).collect();
        filter.set(&bounds.join(" && "));
    }
}

/// To four digits, as many as a pixel can tell apart.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().max(f64::MIN_POSITIVE).log10().floor() - 3.0);
    // Divided by a whole number, so that no digits come after them.
    if unit < 1.0 { (value / unit).round() / (1.0 / unit).round() } else { (value / unit).round() * unit }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn numbers_have_four_digits() {
        for (value, expected) in
            [(0.012_345, "0.01235"), (12.3456, "12.35"), (-1_234_567.0, "-1235000"), (0.0, "0")]
        {
            assert_eq!(rounded(value).to_string(), expected);
        }
    }
}
