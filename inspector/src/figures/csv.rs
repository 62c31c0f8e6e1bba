//! The numbers of a figure as CSV: one table of all of them for people and programs, and one a panel that
//! pgfplots reads.

use super::FigureError;
use super::model::{Axis, Content, Figure, Panel, Picture, Point, Scale};
use crate::analysis::summary::distinct;

/// Columns, before the two whose names carry the axes' labels and units.
const BEFORE: [&str; 5] = ["curve", "panel", "series", "name", "category"];
/// Columns after them.
const AFTER: [&str; 3] = ["low", "high", "n"];

/// The rows of a figure with their header. Series count from 0 over all panels (`curve`); lines across
/// a panel are rows without a curve, one for each end; a picture gives the colours of its bar.
///
/// # Errors
/// Only if memory ends.
pub fn write(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // The labels of all panels, each once.
    let labels = |axis: fn(&Panel) -> &Axis| {
        distinct(figure.panels.iter().map(|panel| axis(panel).label.as_str())).join(" | ")
    };
    let axes = [format!("x: {}", labels(|panel| &panel.x)), format!("y: {}", labels(|panel| &panel.y))];
    let header = BEFORE.map(str::to_owned).into_iter().chain(axes).chain(AFTER.map(str::to_owned));
    writer.write_record(header).map_err(failed)?;
    let mut curve = 0;
    for (at, panel) in figure.panels.iter().enumerate() {
        let title = if panel.title.is_empty() { format!("panel {}", at + 1) } else { panel.title.clone() };
        for series in panel.content.series() {
            for point in &series.points {
                let row = row(&curve.to_string(), &title, &series.label, panel, point);
                writer.write_record(row).map_err(failed)?;
            }
            curve += 1;
        }
        for (label, point) in references(panel).chain(colours(panel)) {
            writer.write_record(row("", &title, &label, panel, &point)).map_err(failed)?;
        }
    }
    finish(writer)
}

/// Series beside each other, four columns each: `x0,y0,below0,above0,x1,…`. `below` and `above` are
/// distances from y to the ends of its spread, 0 where that is unknown; short series end with `nan`.
///
/// # Errors
/// Only if memory ends.
pub fn panel(series: &[Vec<Point>]) -> Result<Vec<u8>, FigureError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = |at: usize| ["x", "y", "below", "above"].map(|name| format!("{name}{at}"));
    writer.write_record((0..series.len()).flat_map(header)).map_err(failed)?;
    for row in 0..series.iter().map(Vec::len).max().unwrap_or(0) {
        let of_series = |points: &Vec<Point>| points.get(row).map_or([f64::NAN; 4], numbers);
        let numbers = series.iter().flat_map(of_series);
        let words = numbers.map(|number| number.to_string().to_lowercase());
        writer.write_record(words).map_err(failed)?;
    }
    finish(writer)
}

fn numbers(point: &Point) -> [f64; 4] {
    let (low, high) = point.spread.unwrap_or((point.y, point.y));
    [point.x, point.y, (point.y - low).abs(), (high - point.y).abs()]
}

fn failed(cause: csv::Error) -> FigureError {
    FigureError::Render(cause.to_string())
}

fn finish(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, FigureError> {
    writer.into_inner().map_err(|cause| FigureError::Render(cause.to_string()))
}

fn row(curve: &str, panel_title: &str, series: &str, panel: &Panel, point: &Point) -> [String; 10] {
    let category = match &panel.x.scale {
        Scale::Categories(names) => names.get(point.x as usize).map_or("", String::as_str),
        _ => "",
    };
    let (low, high) = point.spread.unzip();
    let known = |end: Option<f64>| end.map_or(String::new(), |end| end.to_string());
    [
        curve.to_owned(),
        panel_title.to_owned(),
        series.to_owned(),
        point.name.clone(),
        category.to_owned(),
        point.x.to_string(),
        point.y.to_string(),
        known(low),
        known(high),
        point.n.to_string(),
    ]
}

/// Both ends of the line across a panel.
fn references(panel: &Panel) -> impl Iterator<Item = (String, Point)> {
    panel.reference.iter().flat_map(|line| {
        let end = |x| (line.label.clone(), bare_point(x, line.y, "reference line"));
        [end(f64::NEG_INFINITY), end(f64::INFINITY)]
    })
}

/// What the colours of a picture stand for: x counts them, y is their value.
fn colours(panel: &Panel) -> Vec<(String, Point)> {
    let Content::Picture(Picture { colour_bar: Some(bar), .. }) = &panel.content else { return Vec::new() };
    let ((low, high), last) = (bar.range, bar.colours.len().saturating_sub(1).max(1) as f64);
    let colour = |(at, [red, green, blue]): (usize, &[u8; 3])| {
        let value = low + (high - low) * at as f64 / last;
        (bar.label.clone(), bare_point(at as f64, value, &format!("colour {red} {green} {blue}")))
    };
    bar.colours.iter().enumerate().map(colour).collect()
}

/// A number of which nothing else is known.
pub(crate) fn bare_point(x: f64, y: f64, name: &str) -> Point {
    Point { x, y, spread: None, n: 0, name: name.to_owned() }
}
