//! The numbers of a figure as CSV: one tidy table of all of them for people and programs, and one a panel that
//! pgfplots reads.

use super::FigureError;
use super::model::{Axis, Content, Figure, Of, Panel, Picture, Point, Scale};

/// Columns of the tidy table. `x_axis` and `x` say where to the right a number is, if that is a number or a name that
/// the columns before do not have; `metric` is what `value` is, with its unit.
const COLUMNS: [&str; 13] = [
    "scene", "machine", "kind", "bounce", "method", "detail", "x_axis", "x", "metric", "value", "low",
    "high", "n",
];

/// The rows of a figure with their header, one a number. A line across a panel is a row without an x; a picture gives
/// the colours of its bar.
///
/// # Errors
/// Only if memory ends.
pub fn write(figure: &Figure) -> Result<Vec<u8>, FigureError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS).map_err(failed)?;
    for panel in &figure.panels {
        for series in panel.content.series() {
            for point in &series.points {
                let Of { scene, machine, kind, method, detail, .. } = &point.of;
                let has_column =
                    |word: &str| [scene, machine, kind, method, detail].iter().any(|own| *own == word);
                let is_name = matches!(panel.x.scale, Scale::Categories(_));
                let x = x_of(panel, point).filter(|(_, x)| !(is_name && has_column(x)));
                // A series is named by what its numbers are of, or by what only the legend says.
                let more = if has_column(&series.label) { "" } else { series.label.as_str() };
                writer.write_record(row(panel, point, more, x)).map_err(failed)?;
            }
        }
        for (label, point) in references(panel).chain(colours(panel)) {
            writer.write_record(row(panel, &point, &label, None)).map_err(failed)?;
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

fn row(panel: &Panel, point: &Point, more: &str, x: Option<(&str, String)>) -> [String; 13] {
    let Of { scene, machine, kind, bounce, method, detail } = point.of.clone();
    let details = [detail.as_str(), more].into_iter().filter(|part| !part.is_empty());
    let metric = match &panel.content {
        Content::Picture(Picture { colour_bar: Some(bar), .. }) if panel.y.label.is_empty() => {
            if bar.label.is_empty() { panel.title.as_str() } else { bar.label.as_str() }
        }
        _ => panel.y.label.as_str(),
    };
    let (x_axis, x) = x.unwrap_or_default();
    let (low, high) = point.spread.unzip();
    let known = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    [
        scene,
        machine,
        kind,
        bounce.map_or(String::new(), |bounce| bounce.to_string()),
        method,
        details.collect::<Vec<_>>().join(", "),
        x_axis.to_owned(),
        x,
        metric.to_owned(),
        point.y.to_string(),
        known(low),
        known(high),
        point.n.to_string(),
    ]
}

/// Where to the right a number is: the axis and the place on it.
fn x_of<'a>(panel: &'a Panel, point: &Point) -> Option<(&'a str, String)> {
    let Axis { label, scale } = &panel.x;
    match scale {
        Scale::Categories(names) => Some((label, names.get(point.x as usize)?.clone())),
        // A bounce has a column.
        _ if point.of.bounce.map(f64::from) == Some(point.x) && label == "bounce" => None,
        _ => Some((label, point.x.to_string())),
    }
}

/// The line across a panel.
fn references(panel: &Panel) -> impl Iterator<Item = (String, Point)> {
    panel.reference.iter().map(|line| (line.label.clone(), bare_point(0.0, line.y, "line across")))
}

/// What the colours of a picture stand for.
fn colours(panel: &Panel) -> Vec<(String, Point)> {
    let Content::Picture(Picture { colour_bar: Some(bar), .. }) = &panel.content else { return Vec::new() };
    let ((low, high), last) = (bar.range, bar.colours.len().saturating_sub(1).max(1) as f64);
    let colour = |(at, [red, green, blue]): (usize, &[u8; 3])| {
        let value = low + (high - low) * at as f64 / last;
        (String::new(), bare_point(at as f64, value, &format!("colour {red} {green} {blue}")))
    };
    bar.colours.iter().enumerate().map(colour).collect()
}

/// A number of which nothing else is known.
pub(crate) fn bare_point(x: f64, y: f64, detail: &str) -> Point {
    Point::new(x, y, 0, Of::detail(detail))
}
