//! The length table in numbers: how many rays and which mean lengths its cells have, and how far its
//! estimates are from the lengths that were traced.

use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use egui_plot::{Bar, BarChart, Line, Plot, PlotImage, PlotPoint, PlotPoints, uniform_grid_spacer};
use formats::length_table::{LengthCell, mean_length};
use formats::manifest::QueueId;

use super::notes::{missing, power_of_ten};
use crate::colour_map::ColourMap;
use crate::model::Context;
use crate::model::estimates::{BINS, Estimates};
use crate::output::count;
use crate::theme::Theme;

/// Steps of logarithms that are marked: every one, and every second and fourth where there is little room.
const DECADES: [f64; 3] = [1.0, 2.0, 4.0];
/// Of the plot of estimates with its labels, so that both of its axes are about as long.
const WIDTH_TO_HEIGHT: f32 = 1.1;
/// Bars of the histogram of mean lengths.
const BARS: usize = 48;

/// How many cells have how many rays, by powers of two, and which mean length.
pub(super) fn histograms(ui: &mut egui::Ui, cells: &[LengthCell]) {
    let theme = Theme::of(ui.ctx());
    let (counts, means) = (count_bars(cells), mean_bars(cells));
    let height = 0.5 * (ui.available_height() - ui.spacing().item_spacing.y);
    let chart = |bars| BarChart::new("cells", bars).color(theme.series(1));
    let plot = |name: &'static str, label: &'static str| {
        Plot::new(name)
            .height(height)
            .allow_scroll(false)
            .include_y(0.0)
            .x_axis_label(label)
            .y_axis_label("cells")
            .y_axis_formatter(|mark, _| short(mark.value))
    };
    plot("rays of a cell", "rays added to a cell, by powers of two")
        .x_axis_formatter(|mark, _| power_of_two(mark.value))
        .x_grid_spacer(uniform_grid_spacer(|_| DECADES))
        .show(ui, |plot| plot.bar_chart(chart(counts)));
    plot("mean of a cell", "mean length of a cell, unit lengths")
        .show(ui, |plot| plot.bar_chart(chart(means)));
}

/// A bar for each power of two of rays added.
fn count_bars(cells: &[LengthCell]) -> Vec<Bar> {
    let mut bars = [0u32; 32];
    // One of them is the dummy.
    cells.iter().for_each(|cell| bars[cell.count.saturating_sub(1).max(1).ilog2() as usize] += 1);
    let last = bars.iter().rposition(|&high| high > 0).unwrap_or(0);
    let bar = |(at, high): (usize, &u32)| Bar::new(at as f64 + 0.5, f64::from(*high)).width(0.94);
    bars[..=last].iter().enumerate().map(bar).collect()
}

/// A bar for each of some equal ranges of mean lengths.
fn mean_bars(cells: &[LengthCell]) -> Vec<Bar> {
    let means: Vec<f64> =
        cells.iter().map(|cell| f64::from(mean_length(cell.sum, cell.count.max(1)))).collect();
    let longest = means.iter().copied().fold(0.05, f64::max);
    let mut bars = [0u32; BARS];
    let bin = |mean: f64| ((mean / longest * BARS as f64) as usize).min(BARS - 1);
    means.into_iter().for_each(|mean| bars[bin(mean)] += 1);
    let width = longest / BARS as f64;
    let bar =
        |(at, high): (usize, &u32)| Bar::new((at as f64 + 0.5) * width, f64::from(*high)).width(0.94 * width);
    bars.iter().enumerate().map(bar).collect()
}

fn power_of_two(exponent: f64) -> String {
    let is_whole = (exponent - exponent.round()).abs() < 1e-6 && exponent >= 0.0;
    if is_whole { count(2f64.powi(exponent.round() as i32) as u64) } else { String::new() }
}

/// A number in few characters: `12k`.
fn short(value: f64) -> String {
    match value.abs() {
        size if size >= 1e6 => format!("{}M", value / 1e6),
        size if size >= 1e4 => format!("{}k", value / 1e3),
        _ => value.to_string(),
    }
}

/// The plot of estimates against lengths, whose picture is made once for each queue.
#[derive(Default)]
pub(super) struct EstimatePlot {
    made: Option<((usize, QueueId, bool), TextureHandle)>,
}

impl EstimatePlot {
    pub(super) fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let estimates = match context.estimates() {
            Ok(Some(estimates)) => estimates,
            Ok(None) => {
                ui.spinner();
                return;
            }
            Err(reason) => return missing(ui, &reason),
        };
        let [within, untouched] =
            [estimates.within_factor_two, estimates.untouched].map(|share| format!("{:.1} %", 100.0 * share));
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{within} of the rays within a factor of two"))
                .on_hover_text("Rays whose estimate is at least half and at most twice their traced length");
            ui.weak(format!("{untouched} from untouched cells"))
                .on_hover_text("Rays whose estimate is that of a cell that no ray was added to yet: 0.25");
        });
        let theme = Theme::of(ui.ctx());
        let key = (context.selection.recording, context.selection.queue, ui.visuals().dark_mode);
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
        Plot::new("estimates")
            .width(ui.available_width().min(WIDTH_TO_HEIGHT * ui.available_height()))
            .height(ui.available_height())
            .set_margin_fraction(egui::vec2(0.0, 0.0))
            .allow_scroll(false)
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
        let [red, green, blue] = ColourMap::Viridis.colour(part as f32);
        Color32::from_rgb(red, green, blue)
    };
    estimates.counts.chunks(BINS).rev().flatten().map(|&rays| colour(rays)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_in_one_bar() {
        let cell = |count, mean: f64| LengthCell {
            cell: 0,
            count,
            sum: (mean * f64::from(1u32 << 24)) as u64 * u64::from(count),
        };
        let cells = [cell(2, 0.1), cell(3, 0.1), cell(5, 0.5), cell(1000, 1.5)];
        let heights = |bars: Vec<Bar>| bars.iter().map(|bar| bar.value).collect::<Vec<f64>>();
        assert_eq!(heights(count_bars(&cells)), [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let means = heights(mean_bars(&cells));
        assert_eq!(means.iter().sum::<f64>(), 4.0);
        assert_eq!((means[3], means[BARS - 1]), (2.0, 1.0));
    }
}
