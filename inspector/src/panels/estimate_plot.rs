//! How far the estimates of the length table are from the lengths that were traced.

use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use egui_plot::{Line, Plot, PlotImage, PlotPoint, PlotPoints, uniform_grid_spacer};
use formats::manifest::QueueId;
use formats::metrics::quantity::Quantity;

use super::brush::brush;
use super::notes::{found, power_of_ten};
use crate::analysis::estimates::{BINS, Estimates};
use crate::colour_map::ColourMap;
use crate::model::Context;
use crate::theme::{Theme, opaque};

/// Steps of logarithms that are marked: every one, and every second and fourth where there is little room.
const DECADES: [f64; 3] = [1.0, 2.0, 4.0];
/// Of the plot of estimates with its labels, so that both of its axes are about as long.
const WIDTH_TO_HEIGHT: f32 = 1.1;

/// What it is of: the opening of a recording, the queue, and whether the page is dark.
type PlotKey = (Option<u64>, QueueId, bool);

/// The plot of estimates against lengths, whose picture is made once for each queue of an opened recording.
#[derive(Default)]
pub(super) struct EstimatePlot {
    made: Option<(PlotKey, TextureHandle)>,
}

/// How good the table's estimates are, in words; nothing while that is not known.
pub(super) fn worth(ui: &mut egui::Ui, context: &mut Context) {
    let Ok(estimates) = context.estimates() else { return };
    let [within, untouched] =
        [estimates.within_factor_two, estimates.untouched].map(|share| format!("{:.1} %", 100.0 * share));
    ui.label(format!("Its estimates: {within} of the rays within a factor of two"))
        .on_hover_text("Rays whose estimate is at least half and at most twice their traced length");
    ui.weak(format!("{untouched} from untouched cells"))
        .on_hover_text("Rays whose estimate is that of a cell that no ray was added to yet: 0.25");
}

impl EstimatePlot {
    pub(super) fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(estimates) = found(ui, context.estimates()) else { return };
        let theme = Theme::of(ui.ctx());
        let opening = context.recording().map(|recording| recording.opening);
        let key = (opening, context.selection.queue, ui.visuals().dark_mode);
        if self.made.as_ref().is_none_or(|(known, _)| *known != key) {
            let image = ColorImage::new([BINS, BINS], pixels(&estimates, theme));
            self.made = Some((key, ui.ctx().load_texture("estimates", image, TextureOptions::NEAREST)));
        }
        let Some((_, texture)) = &self.made else { return };
        let (low, high) = (estimates.low, estimates.high);
        let middle = PlotPoint::new(0.5 * (low + high), 0.5 * (low + high));
        let side = (high - low) as f32;
        let image = PlotImage::new("rays", texture.id(), middle, [side, side]);
        let right = PlotPoints::from(vec![[low, low], [high, high]]);
        let plot = Plot::new("estimates")
            .width(ui.available_width().min(WIDTH_TO_HEIGHT * ui.available_height()))
            .height(ui.available_height())
            .set_margin_fraction(egui::vec2(0.0, 0.0))
            .allow_scroll(false)
            .allow_drag(false)
            .x_axis_label("traced length, unit lengths")
            .y_axis_label("estimated length")
            // The corner has the label of the other axis.
            .x_axis_formatter(
                |mark, _| if mark.value > low { power_of_ten(mark.value) } else { String::new() },
            )
            .y_axis_formatter(|mark, _| power_of_ten(mark.value))
            .x_grid_spacer(uniform_grid_spacer(|_| DECADES))
            .y_grid_spacer(uniform_grid_spacer(|_| DECADES))
            .show(ui, |plot| {
                plot.image(image);
                plot.line(Line::new("estimate = length", right).color(theme.reference()).width(1.2));
            });
        let length_at = |x: f32| 10f64.powf(plot.transform.value_from_position(egui::pos2(x, 0.0)).x);
        brush(ui, &plot.response, (Quantity::Length, length_at), context);
    }
}

/// A pixel for each pair of bins, bright where many rays are; the longest estimates in the first row.
fn pixels(estimates: &Estimates, theme: Theme) -> Vec<Color32> {
    let most = f64::from(estimates.counts.iter().copied().max().unwrap_or(1).max(1)).ln_1p();
    let colour = |rays: u32| {
        if rays == 0 {
            return theme.nothing();
        }
        // The first colours of the map are hard to tell from where no ray is.
        let part = 0.2 + 0.8 * f64::from(rays).ln_1p() / most;
        opaque(ColourMap::Viridis.colour(part as f32))
    };
    estimates.counts.chunks(BINS).rev().flatten().map(|&rays| colour(rays)).collect()
}
