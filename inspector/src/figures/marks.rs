//! What a panel shows inside its axes: lines, markers, bars, stacks, pictures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::axis::{Mapping, number};
use super::canvas::{Canvas, Rectangle, Stroke};
use super::frame::Frame;
use super::legend::reference_stroke;
use super::model::{Content, Picture, Point, Series};
use super::style::{Colour, LINE_STROKE, MARKER_RADIUS, style};
use super::{FigureError, raster};

/// Lines of more points than this have a marker at some of them only.
const MOST_MARKERS: usize = 40;
/// The part of its slot that a group of bars takes.
const GROUP_WIDTH: f64 = 0.8;
/// The part of its slot that a stack takes.
const STACK_WIDTH: f64 = 0.7;
/// Widest bar and widest stack, points.
const WIDEST_BAR: f64 = 24.0;
const WIDEST_STACK: f64 = 36.0;
/// Width of the lines of spreads, points.
const WHISKER_STROKE: f64 = 0.7;

/// Width of the bars of a panel, points.
pub(crate) fn bar_width(frame: &Frame) -> f64 {
    match &frame.panel.content {
        Content::Bars(series) => {
            (GROUP_WIDTH * frame.slot() / largest_group(series).max(1) as f64).min(WIDEST_BAR)
        }
        _ => (STACK_WIDTH * frame.slot()).min(WIDEST_STACK),
    }
}

/// Whether a series has a bar at a category.
fn has_bar(series: &Series, category: f64) -> bool {
    series.points.iter().any(|point| point.x == category && point.y.is_finite())
}

/// Most bars at one category.
pub(crate) fn largest_group(series: &[Series]) -> usize {
    let categories = series.iter().flat_map(|series| &series.points).map(|point| point.x);
    categories.map(|x| series.iter().filter(|one| has_bar(one, x)).count()).max().unwrap_or(0)
}

/// From a category to the middle of a series' bar there, in bars. Series without a bar there take no room.
pub(crate) fn place_in_group(series: &[Series], at: usize, category: f64) -> f64 {
    let count = |series: &[Series]| series.iter().filter(|one| has_bar(one, category)).count() as f64;
    count(&series[..at]) + 0.5 - 0.5 * count(series)
}

/// A line has a marker at every so many points.
pub(crate) fn marker_stride(series: &Series) -> usize {
    if series.points.len() > MOST_MARKERS { series.points.len().div_ceil(12) } else { 1 }
}

/// A panel's axes in their place.
struct Plot<'a> {
    x: &'a Mapping,
    y: &'a Mapping,
    area: Rectangle,
}

impl Plot<'_> {
    fn x(&self, value: f64) -> Option<f64> {
        Some(self.area.left + self.x.place(value)? * self.area.width)
    }

    fn y(&self, value: f64) -> Option<f64> {
        Some(self.area.bottom() - self.y.place(value)? * self.area.height)
    }

    fn point(&self, point: &Point) -> Option<(f64, f64)> {
        Some((self.x(point.x)?, self.y(point.y)?))
    }
}

/// Draws what a panel shows into its plot area. `reference_labels` give the dashes of lines across.
pub(crate) fn draw(
    canvas: &mut Canvas,
    frame: &Frame,
    area: Rectangle,
    reference_labels: &[String],
) -> Result<(), FigureError> {
    let plot = Plot { x: &frame.x, y: &frame.y, area };
    match &frame.panel.content {
        Content::Lines(series) => series.iter().for_each(|series| line(canvas, &plot, series)),
        Content::Scatter(series) => series.iter().for_each(|series| scatter(canvas, &plot, series)),
        Content::Bars(series) => bars(canvas, &plot, series, bar_width(frame)),
        Content::Stacks(series) => stacks(canvas, &plot, series, bar_width(frame)),
        Content::Picture(shown) => picture(canvas, area, shown)?,
    }
    for reference in &frame.panel.references {
        let (from, to) = match reference.span {
            Some((from, to)) => (plot.x(from), plot.x(to)),
            None => (Some(area.left), Some(area.right())),
        };
        if let (Some(from), Some(to), Some(y)) = (from, to, plot.y(reference.y)) {
            let number = reference_labels.iter().position(|label| *label == reference.label).unwrap_or(0);
            let inside = |x: f64| x.clamp(area.left, area.right());
            canvas.line((inside(from), y), (inside(to), y), reference_stroke(number));
        }
    }
    Ok(())
}

fn line(canvas: &mut Canvas, plot: &Plot, series: &Series) {
    let style = style(series.style);
    let stroke = Stroke { colour: style.colour.ink(), width: LINE_STROKE, dash: style.dash };
    let spread = Stroke { width: WHISKER_STROKE, dash: &[], ..stroke };
    // A point without a place, such as 0 on a logarithmic axis, leaves a gap.
    for run in series.points.split(|point| plot.point(point).is_none()) {
        let places: Vec<(f64, f64)> = run.iter().filter_map(|point| plot.point(point)).collect();
        if places.len() > 1 {
            canvas.polyline(&places, stroke);
        }
    }
    let stride = marker_stride(series);
    for (at, point) in series.points.iter().enumerate() {
        if let Some(place) = plot.point(point) {
            whisker(canvas, plot, place.0, point, 0.0, spread);
            // Markers of several long lines are not above each other.
            if (at + stride / 2 + series.style).is_multiple_of(stride) {
                canvas.marker(place, MARKER_RADIUS, style.marker, style.colour, &tooltip(series, point));
            }
        }
    }
}

fn scatter(canvas: &mut Canvas, plot: &Plot, series: &Series) {
    let style = style(series.style);
    let spread = Stroke { colour: style.colour.ink(), width: WHISKER_STROKE, dash: &[] };
    for point in &series.points {
        if let Some(place) = plot.point(point) {
            whisker(canvas, plot, place.0, point, 0.0, spread);
            canvas.marker(place, MARKER_RADIUS, style.marker, style.colour, &tooltip(series, point));
        }
    }
}

fn bars(canvas: &mut Canvas, plot: &Plot, series: &[Series], width: f64) {
    for (at, one) in series.iter().enumerate() {
        for point in &one.points {
            if let Some(category) = plot.x(point.x) {
                let centre = category + place_in_group(series, at, point.x) * width;
                bar(canvas, plot, one, point, (centre - 0.5 * width, width), plot.y.base(), point.y);
                bar_whisker(canvas, plot, centre, point, (width, one.style));
            }
        }
    }
}

fn stacks(canvas: &mut Canvas, plot: &Plot, series: &[Series], width: f64) {
    let mut tops: std::collections::BTreeMap<u64, f64> = std::collections::BTreeMap::new();
    let mut whiskers = Vec::new();
    for one in series {
        for point in one.points.iter().filter(|point| point.y.is_finite()) {
            let top = tops.entry(point.x.to_bits()).or_insert(0.0);
            let below = *top;
            *top += point.y;
            if let Some(centre) = plot.x(point.x) {
                let start = if below == 0.0 { plot.y.base() } else { below };
                bar(canvas, plot, one, point, (centre - 0.5 * width, width), start, *top);
                whiskers.push((centre, point, below));
            }
        }
    }
    // Above all bars, since the next bar starts where a spread is centred.
    for (centre, point, below) in whiskers {
        edged_whisker(canvas, plot, centre, point, below);
    }
}

/// A bar from one number to another; `across` is its left edge and its width.
fn bar(
    canvas: &mut Canvas,
    plot: &Plot,
    series: &Series,
    point: &Point,
    across: (f64, f64),
    from: f64,
    to: f64,
) {
    let (Some(from), Some(to)) = (plot.y(from), plot.y(to)) else { return };
    let style = style(series.style);
    let area = Rectangle { left: across.0, top: from.min(to), width: across.1, height: (from - to).abs() };
    canvas.bar(area, style.colour, style.hatch, &tooltip(series, point));
}

/// The spread of a bar: its part inside the bar is in the one of black and white that is seen there.
fn bar_whisker(canvas: &mut Canvas, plot: &Plot, x: f64, point: &Point, (width, number): (f64, usize)) {
    let Some((low, high)) = point.spread else { return };
    let low = plot.y(low).unwrap_or(plot.area.bottom());
    let (Some(high), Some(top)) = (plot.y(high), plot.y(point.y)) else { return };
    if (low - high).abs() < 0.3 {
        return;
    }
    let cap = (0.3 * width).min(1.6);
    let inside = style(number).colour.contrast();
    for (end, colour) in [(low, inside), (high, Colour::BLACK)] {
        let stroke = Stroke { colour, width: WHISKER_STROKE, dash: &[] };
        canvas.line((x, top), (x, end), stroke);
        canvas.line((x - cap, end), (x + cap, end), stroke);
    }
}

/// The spread of a number, with a white edge so that it is seen on dark bars.
fn edged_whisker(canvas: &mut Canvas, plot: &Plot, x: f64, point: &Point, below: f64) {
    whisker(canvas, plot, x, point, below, Stroke { colour: Colour::WHITE, width: 1.8, dash: &[] });
    whisker(
        canvas,
        plot,
        x,
        point,
        below,
        Stroke { colour: Colour::BLACK, width: WHISKER_STROKE, dash: &[] },
    );
}

/// The spread of a number.
fn whisker(canvas: &mut Canvas, plot: &Plot, x: f64, point: &Point, below: f64, stroke: Stroke) {
    let Some((low, high)) = point.spread else { return };
    let low = plot.y(low + below).unwrap_or(plot.area.bottom());
    let Some(high) = plot.y(high + below) else { return };
    // Nothing would be left of it between its ends.
    if (low - high).abs() < 0.3 {
        return;
    }
    let cap = 1.3 + 0.5 * stroke.width;
    canvas.line((x, low), (x, high), stroke);
    canvas.line((x - cap, low), (x + cap, low), stroke);
    canvas.line((x - cap, high), (x + cap, high), stroke);
}

fn picture(canvas: &mut Canvas, area: Rectangle, picture: &Picture) -> Result<(), FigureError> {
    let png = raster::picture_png(picture)?;
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
    // Cells that are larger than a dot of the print keep their edges.
    let is_magnified = f64::from(picture.width) < area.width * 2.0;
    canvas.picture(area, &source, is_magnified);
    Ok(())
}

/// What a number is, its spread and how many samples are behind it.
fn tooltip(series: &Series, point: &Point) -> String {
    let name = match (series.label.as_str(), point.name.as_str()) {
        (label, "") => label.to_owned(),
        ("", name) => name.to_owned(),
        (label, name) => format!("{label}, {name}"),
    };
    let spread =
        point.spread.map_or(String::new(), |(low, high)| format!(" ({} to {})", number(low), number(high)));
    let samples = if point.n > 0 { format!(", n = {}", point.n) } else { String::new() };
    format!("{name}: {}{spread}{samples}", number(point.y))
}
