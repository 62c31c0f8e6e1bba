//! What the colours of a picture stand for: a bar with its unit, and above it how many values have which colour.

use egui::text::{LayoutJob, TextWrapping};
use egui::{Rect, Response, Sense, Ui, pos2, vec2};

use crate::colour_map::ColourMap;
use crate::figures::axis::ratio_label;
use crate::render::range::{ValueRange, Values};
use crate::theme::opaque;

/// Height of the bar itself.
const BAR: f32 = 12.0;
/// Parts of the histogram above it.
const BINS: usize = 96;
const BINS_HEIGHT: f32 = 18.0;
/// Height of the histogram and the bar, above the text.
pub(super) const HANDLE: f32 = BINS_HEIGHT + BAR;

/// Height of all of it, points.
pub(super) fn height(ui: &Ui) -> f32 {
    HANDLE + 2.0 * ui.text_style_height(&egui::TextStyle::Body) + 2.0
}

/// A bar: what it stands for, and the numbers behind it.
pub(super) struct ColourBar<'a> {
    pub(super) range: ValueRange,
    pub(super) map: ColourMap,
    /// The base, where values are logarithms.
    pub(super) logarithm: Option<f32>,
    pub(super) title: &'a str,
    pub(super) values: Option<&'a Values>,
}

impl ColourBar<'_> {
    /// The bar over all values `across`.
    pub(super) fn show(&self, ui: &mut Ui, width: f32, across: ValueRange) -> Response {
        let text_height = ui.text_style_height(&egui::TextStyle::Body);
        let (rect, response) = ui.allocate_exact_size(vec2(width, height(ui)), Sense::click_and_drag());
        let painter = ui.painter();
        let counts = self.values.map_or(vec![0; BINS], |values| values.histogram(across, BINS));
        let most = counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        let step = rect.width() / BINS as f32;
        let bar_top = rect.top() + BINS_HEIGHT;
        for (at, count) in counts.into_iter().enumerate() {
            let value = across.low + (at as f32 + 0.5) / BINS as f32 * (across.high - across.low);
            let left = rect.left() + at as f32 * step;
            let high = (BINS_HEIGHT - 2.0) * count as f32 / most;
            painter.rect_filled(
                Rect::from_min_max(pos2(left, bar_top), pos2(left + step + 0.5, bar_top + BAR)),
                0.0,
                opaque(self.map.colour(self.range.part(value))),
            );
            let bin = Rect::from_min_max(pos2(left, bar_top - high), pos2(left + step - 0.5, bar_top - 1.0));
            if high > 0.0 {
                painter.rect_filled(bin, 0.0, ui.visuals().weak_text_color());
            }
        }
        let (line, font) = (bar_top + BAR + 2.0, egui::TextStyle::Body.resolve(ui.style()));
        let mut title =
            LayoutJob::simple_singleline(self.title.to_owned(), font.clone(), ui.visuals().text_color());
        title.wrap = TextWrapping::truncate_at_width(width);
        let title = painter.layout_job(title);
        let (is_cut, left) = (title.elided, rect.center().x - 0.5 * title.size().x);
        painter.galley(pos2(left, line + text_height), title, ui.visuals().text_color());
        let mut taken: Vec<Rect> = Vec::new();
        let middle = (self.logarithm == Some(2.0)).then_some(0.0);
        for value in [self.range.low, self.range.high].into_iter().chain(middle) {
            // Under its end, but on the bar; the later of two that would touch is left out.
            let text = match self.logarithm {
                Some(2.0) => ratio_label(f64::from(value.exp2())),
                Some(base) => number(base.powf(value)),
                None => number(value),
            };
            let text = painter.layout_no_wrap(text, font.clone(), ui.visuals().text_color());
            let x = rect.left() + across.part(value) * rect.width() - 0.5 * text.size().x;
            let x = x.clamp(rect.left(), (rect.right() - text.size().x).max(rect.left()));
            let place = Rect::from_min_size(pos2(x, line), text.size());
            if taken.iter().all(|other| !other.expand(4.0).intersects(place)) {
                painter.galley(place.min, text, ui.visuals().text_color());
                taken.push(place);
            }
        }
        if is_cut { response.on_hover_text(self.title) } else { response }
    }
}

fn number(value: f32) -> String {
    match value.abs() {
        // Whole numbers are so but for the logarithm that they were.
        size if size < 1000.0 && (size - size.round()).abs() <= 1e-5 * size => format!("{}", value.round()),
        size if size >= 1000.0 => crate::output::count(size as u64),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}
