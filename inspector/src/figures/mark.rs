//! The one element of charts and legends: points that plotters places, and what SVG draws there.

use plotters::element::{Drawable, PointCollection};
use plotters::style::text_anchor::Pos;
use plotters_backend::BackendCoord;

use super::style::{
    Colour, LINE_STROKE, MARKER_RADIUS, Marker, REFERENCE_COLOUR, REFERENCE_DASH, Style, TEXT_SIZE, style,
};
use super::svg::{Drawn, Paint, Svg, UNITS_PER_POINT, units};

/// Width of the outlines of bars and markers, points.
const OUTLINE_STROKE: f64 = 0.4;
/// Width of lines across a panel, points.
const REFERENCE_STROKE: f64 = 0.9;
/// Width of what leads from a line to its name, points.
const LEADER_STROKE: f64 = 0.35;
/// Half the width of the dot of a part, points.
const PART_RADIUS: f64 = 1.1;
/// Width of the spread of a number in a row, points.
const EXTENT_STROKE: f64 = 2.2;
/// Width of the lines of spreads, points.
const WHISKER_STROKE: f64 = 0.7;
/// Half the width of the end of a spread, points.
const CAP: f64 = 1.65;
/// Shortest half of a spread that is drawn, units: of a shorter one only its end would be seen.
const SHORTEST_WHISKER: u32 = 3;

/// What draws at the places of some points.
type Draw<'t> = dyn Fn(&mut Svg, &[BackendCoord]) + 't;

/// An element of a chart or a legend: points, and how they are drawn once plotters has placed them.
pub(crate) struct Mark<'t, C> {
    points: Vec<C>,
    draw: Box<Draw<'t>>,
}

impl<'t, C> Mark<'t, C> {
    /// `draw` is given as many places as there are points.
    pub(crate) fn new(points: impl Into<Vec<C>>, draw: impl Fn(&mut Svg, &[BackendCoord]) + 't) -> Self {
        Self { points: points.into(), draw: Box::new(draw) }
    }
}

impl<'a, C> PointCollection<'a, C> for &'a Mark<'_, C> {
    type Point = &'a C;
    type IntoIter = &'a [C];

    fn point_iter(self) -> &'a [C] {
        &self.points
    }
}

impl<C> Drawable<Svg> for Mark<'_, C> {
    fn draw<I: Iterator<Item = BackendCoord>>(&self, at: I, svg: &mut Svg, _: (u32, u32)) -> Drawn {
        (self.draw)(svg, &at.collect::<Vec<_>>());
        Ok(())
    }
}

/// The line of a style, without markers.
pub(crate) fn line<C>(points: Vec<C>, number: usize) -> Mark<'static, C> {
    let Style { colour, dash, .. } = style(number);
    let paint = Paint { dash, ..Paint::line(colour.ink(), LINE_STROKE) };
    Mark::new(points, move |svg, at| svg.path(at, false, paint))
}

/// The line across a panel.
pub(crate) fn reference<C>(ends: [C; 2]) -> Mark<'static, C> {
    let paint = Paint { dash: REFERENCE_DASH, ..Paint::line(REFERENCE_COLOUR, REFERENCE_STROKE) };
    Mark::new(ends, move |svg, at| svg.path(at, false, paint))
}

/// From the end of a line to its name.
pub(crate) fn leader<C>(places: [C; 3]) -> Mark<'static, C> {
    Mark::new(places, move |svg, at| svg.path(at, false, Paint::line(REFERENCE_COLOUR, LEADER_STROKE)))
}

/// A bar of a style from corner to corner.
pub(crate) fn bar<C>(corners: [C; 2], number: usize, tooltip: String) -> Mark<'static, C> {
    let Style { colour, .. } = style(number);
    Mark::new(corners, move |svg, at| {
        let outline = Paint::line(Colour::BLACK, OUTLINE_STROKE);
        svg.rectangle([at[0], at[1]], Paint { fill: Some(colour), tooltip: &tooltip, ..outline });
    })
}

/// The marker of a style.
pub(crate) fn marker<C>(place: C, number: usize, tooltip: String) -> Mark<'static, C> {
    Mark::new([place], move |svg, at| shape(svg, at[0], number, &tooltip))
}

/// Words at an angle, clockwise, with this point of them at a place.
pub(crate) fn words(text: &str, place: BackendCoord, anchor: Pos, degrees: i32) -> Mark<'_, BackendCoord> {
    Mark::new([place], move |svg, at| svg.text(text, at[0], TEXT_SIZE * UNITS_PER_POINT, anchor, degrees))
}

/// Half of a spread, from a number to an end of it.
pub(crate) fn whisker(ends: [(f64, f64); 2], colour: Colour) -> Mark<'static, (f64, f64)> {
    let (paint, cap) = (Paint::line(colour, WHISKER_STROKE), units(CAP));
    Mark::new(ends, move |svg, at| {
        let (x, y) = at[1];
        if at[0].1.abs_diff(y) >= SHORTEST_WHISKER {
            svg.path(at, false, paint);
            svg.path(&[(x - cap, y), (x + cap, y)], false, paint);
        }
    })
}

/// A small dot of a style, for a part of what a marker stands for.
pub(crate) fn dot<C>(place: C, number: usize, tooltip: String) -> Mark<'static, C> {
    let Style { colour, .. } = style(number);
    Mark::new([place], move |svg, at| {
        let paint = Paint { fill: Some(colour), tooltip: &tooltip, ..Paint::line(Colour::WHITE, 0.2) };
        svg.circle(at[0], units(PART_RADIUS) as u32, paint);
    })
}

/// A spread along its row, from end to end.
pub(crate) fn extent<C>(ends: [C; 2], number: usize) -> Mark<'static, C> {
    let paint = Paint::line(style(number).colour.ink(), EXTENT_STROKE);
    Mark::new(ends, move |svg, at| svg.path(at, false, paint))
}

/// Draws the marker of a style.
fn shape(svg: &mut Svg, (x, y): BackendCoord, number: usize, tooltip: &str) {
    let Style { colour, marker, .. } = style(number);
    // Corners around the centre; `turn` is a part of a whole turn.
    let corners = |count: usize, turn: f64, radius: f64| -> Vec<BackendCoord> {
        let corner = |at: usize| {
            let angle = (at as f64 / count as f64 + turn) * std::f64::consts::TAU;
            let radius = radius * MARKER_RADIUS;
            (x + units(radius * angle.sin()), y - units(radius * angle.cos()))
        };
        (0..count).map(corner).collect()
    };
    let edged = |edge: Colour, width: f64| Paint { fill: Some(colour), tooltip, ..Paint::line(edge, width) };
    let (filled, radius) = (edged(Colour::WHITE, OUTLINE_STROKE), units(MARKER_RADIUS) as u32);
    let open = Paint { fill: Some(Colour::WHITE), ..edged(colour, LINE_STROKE) };
    let crossed = |turn: f64| {
        let ends = corners(4, turn, 1.1);
        [ends[0], (x, y), ends[2], (x, y), ends[1], (x, y), ends[3]]
    };
    match marker {
        Marker::Cross => svg.path(&crossed(0.125), false, open),
        Marker::Plus => svg.path(&crossed(0.0), false, open),
        Marker::Circle => svg.circle((x, y), radius, filled),
        Marker::Ring => svg.circle((x, y), radius, open),
        Marker::Square => svg.path(&corners(4, 0.125, 1.25), true, filled),
        Marker::Diamond => svg.path(&corners(4, 0.0, 1.35), true, filled),
        Marker::Triangle => svg.path(&corners(3, 0.0, 1.35), true, filled),
        Marker::TriangleDown => svg.path(&corners(3, 0.5, 1.35), true, filled),
        Marker::Pentagon => svg.path(&corners(5, 0.0, 1.2), true, edged(Colour::BLACK, 0.5)),
    }
}
