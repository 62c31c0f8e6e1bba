//! What a panel shows inside its axes: lines, markers, stacks and pictures as plotters' series.

use std::collections::BTreeMap;
use std::iter::once;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::chart::ChartContext;
use plotters::coord::cartesian::Cartesian2d;

use super::axis::{Mapping, number};
use super::layout::Plot;
use super::mark::{Mark, bar, dot, extent, line, marker, reference, whisker};
use super::model::{Content, Picture, Point, Series};
use super::style::{Colour, style};
use super::svg::Svg;
use super::{FigureError, raster};

/// A panel's axes in their place.
pub(crate) type Chart<'a> = ChartContext<'a, Svg, Cartesian2d<Mapping, Mapping>>;

/// Lines of more points than this have a marker at some of them only.
const MOST_MARKERS: usize = 40;
/// The part of its row that a stack takes.
pub(crate) const STACK_HEIGHT: f64 = 0.7;

/// Lines with spreads, at most: those of more hide the lines, and stand in the CSV alone.
const MOST_WITH_SPREADS: usize = 4;

/// Whether the spreads of numbers are drawn.
pub(crate) fn has_spreads(content: &Content) -> bool {
    !matches!(content, Content::Lines(all) if all.len() > MOST_WITH_SPREADS)
}

/// A line has a marker at every so many points.
pub(crate) fn marker_stride(series: &Series) -> usize {
    if series.points.len() > MOST_MARKERS { series.points.len().div_ceil(12) } else { 1 }
}

/// Draws what a panel shows into its chart.
pub(crate) fn draw(chart: &mut Chart, plot: &Plot) -> Result<(), FigureError> {
    match &plot.panel.content {
        Content::Lines(all) => all.iter().try_for_each(|series| lines(chart, plot, series))?,
        Content::Scatter(all) => all.iter().try_for_each(|series| markers(chart, plot, series, 1))?,
        Content::Dots(all) => dots(chart, plot, all)?,
        Content::Stacks(all) => stacks(chart, plot, all)?,
        Content::Picture(shown) => picture(chart, plot, shown)?,
    }
    if let Some(line) = &plot.panel.reference {
        let ends = if plot.panel.content.is_in_rows() {
            [(line.y, plot.y.range.0), (line.y, plot.y.range.1)]
        } else {
            [(plot.x.range.0, line.y), (plot.x.range.1, line.y)]
        };
        chart.draw_series(once(reference(ends)))?;
    }
    Ok(())
}

/// Whether a point has a place, as 0 on a logarithmic axis has not.
fn has_place(plot: &Plot, point: &Point) -> bool {
    plot.x.place(point.x).is_some() && plot.y.place(point.y).is_some()
}

fn lines(chart: &mut Chart, plot: &Plot, series: &Series) -> Result<(), FigureError> {
    // A point without a place leaves a gap.
    let runs = series.points.split(|point| !has_place(plot, point)).filter(|run| run.len() > 1);
    chart.draw_series(
        runs.map(|run| line(run.iter().map(|point| (point.x, point.y)).collect(), series.style)),
    )?;
    markers(chart, plot, series, marker_stride(series))
}

/// Every so many points of a series with their markers, all with their spreads.
fn markers(chart: &mut Chart, plot: &Plot, series: &Series, stride: usize) -> Result<(), FigureError> {
    let ink = style(series.style).colour.ink();
    for (at, point) in series.points.iter().enumerate().filter(|(_, point)| has_place(plot, point)) {
        if has_spreads(&plot.panel.content) {
            spread(chart, point, ink)?;
        }
        // Markers of several long lines are not above each other.
        if (at + stride / 2 + series.style).is_multiple_of(stride) {
            chart.draw_series(once(marker((point.x, point.y), series.style, tooltip(series, point))))?;
        }
    }
    Ok(())
}

fn stacks(chart: &mut Chart, plot: &Plot, all: &[Series]) -> Result<(), FigureError> {
    let mut ends: BTreeMap<u64, f64> = BTreeMap::new();
    for series in all {
        for point in series.points.iter().filter(|point| point.y.is_finite()) {
            let end = ends.entry(point.x.to_bits()).or_insert(0.0);
            let before = *end;
            *end += point.y;
            let start = if before == 0.0 { plot.x.base() } else { before };
            let corners = [(start, point.x - 0.5 * STACK_HEIGHT), (*end, point.x + 0.5 * STACK_HEIGHT)];
            chart.draw_series(once(bar(corners, series.style, tooltip(series, point))))?;
        }
    }
    Ok(())
}

/// Spreads, then the parts of numbers, then the numbers.
fn dots(chart: &mut Chart, plot: &Plot, all: &[Series]) -> Result<(), FigureError> {
    let shown = |is_part: bool| {
        let series = all.iter().filter(move |series| series.is_part == is_part);
        let points = series.flat_map(|series| series.points.iter().map(move |point| (series, point)));
        points.filter(|(_, point)| plot.x.place(point.y).is_some())
    };
    for (series, point) in shown(false) {
        let ends = point.spread.map(|(low, high)| [(low, point.x), (high, point.x)]);
        chart.draw_series(ends.map(|ends| extent(ends, series.style)))?;
    }
    for (series, point) in shown(true) {
        chart.draw_series(once(dot((point.y, point.x), series.style, tooltip(series, point))))?;
    }
    for (series, point) in shown(false) {
        chart.draw_series(once(marker((point.y, point.x), series.style, tooltip(series, point))))?;
    }
    Ok(())
}

/// Draws both halves of the spread of a number: downwards and upwards.
fn spread(chart: &mut Chart, point: &Point, colour: Colour) -> Result<(), FigureError> {
    let ends = point.spread.into_iter().flat_map(|(low, high)| [low, high]);
    chart.draw_series(ends.map(|end| whisker([(point.x, point.y), (point.x, end)], colour)))?;
    Ok(())
}

fn picture(chart: &mut Chart, plot: &Plot, picture: &Picture) -> Result<(), FigureError> {
    let png = raster::picture_png(picture)?;
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
    // Cells that are larger than a dot of the print keep their edges.
    let is_magnified = f64::from(picture.width) < plot.width * 2.0;
    let corners = [(0.0, 0.0), (f64::from(picture.width), f64::from(picture.height))];
    let picture = Mark::new(corners, |svg, at| svg.picture([at[0], at[1]], &source, is_magnified));
    chart.draw_series(once(picture))?;
    Ok(())
}

/// What a number is, its spread and how many samples are behind it.
fn tooltip(series: &Series, point: &Point) -> String {
    let of = point.of.to_string();
    let name = match (series.label.as_str(), of.as_str()) {
        (label, "") => label.to_owned(),
        (label, of) if of.contains(label) => of.to_owned(),
        (label, of) => format!("{label}, {of}"),
    };
    let spread =
        point.spread.map_or(String::new(), |(low, high)| format!(" ({} to {})", number(low), number(high)));
    let samples = if point.n > 0 { format!(", n = {}", point.n) } else { String::new() };
    format!("{name}: {}{spread}{samples}", number(point.y))
}
