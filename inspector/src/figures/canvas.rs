//! Writes SVG: strokes, shapes, hatches and text, in points from the upper left corner.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;

use formats::text::printable;

use super::style::{Colour, FONT_FAMILY, Hatch, Marker};

/// A rectangle, points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rectangle {
    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stroke<'a> {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
    pub(crate) dash: &'a [f64],
}

/// Which end of a text its place is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Text<'a> {
    pub(crate) text: &'a str,
    /// Of the baseline.
    pub(crate) place: (f64, f64),
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    /// Clockwise around the place.
    pub(crate) rotate_degrees: f64,
}

/// An SVG that is being written.
#[derive(Debug)]
pub(crate) struct Canvas {
    prefix: String,
    body: String,
    definitions: BTreeMap<String, String>,
}

impl Canvas {
    /// An empty one; every id in it starts with `prefix`.
    pub(crate) fn new(prefix: &str) -> Self {
        let is_word = |character: char| character.is_ascii_alphanumeric() || character == '-';
        let prefix = prefix.chars().map(|character| if is_word(character) { character } else { '-' });
        Self { prefix: prefix.collect(), body: String::new(), definitions: BTreeMap::new() }
    }

    /// The whole file: this many points wide and high.
    pub(crate) fn finish(self, width: f64, height: f64, title: &str) -> String {
        let definitions: String = self.definitions.into_values().collect();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"'{FONT_FAMILY}', Arial, Helvetica, sans-serif\" \
             role=\"img\">\n<title>{}</title>\n<defs>{definitions}</defs>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            escape(title),
            self.body,
            width = Short(width),
            height = Short(height),
        )
    }

    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.polyline(&[from, to], stroke);
    }

    pub(crate) fn polyline(&mut self, points: &[(f64, f64)], stroke: Stroke) {
        let path = path_of(points);
        self.write(format_args!("<path d=\"{path}\" fill=\"none\"{}/>\n", stroke_of(stroke)));
    }

    /// A rectangle of one colour.
    pub(crate) fn fill(&mut self, area: Rectangle, colour: Colour) {
        self.write(format_args!("<rect{} fill=\"#{}\"/>\n", area_of(area), colour.hex()));
    }

    /// The outline of a rectangle.
    pub(crate) fn frame(&mut self, area: Rectangle, stroke: Stroke) {
        self.write(format_args!("<rect{} fill=\"none\"{}/>\n", area_of(area), stroke_of(stroke)));
    }

    /// A rectangle with colour and hatch; `tooltip` appears where it is pointed at.
    pub(crate) fn bar(&mut self, area: Rectangle, colour: Colour, hatch: Hatch, tooltip: &str) {
        let fill = match hatch {
            Hatch::Solid => format!("#{}", colour.hex()),
            hatch => format!("url(#{})", self.hatch(colour, hatch)),
        };
        let stroke = stroke_of(Stroke { colour: Colour::BLACK, width: 0.4, dash: &[] });
        let title = tooltip_of(tooltip);
        self.write(format_args!("<rect{} fill=\"{fill}\"{stroke}>{title}</rect>\n", area_of(area)));
    }

    /// The shape at a point; `tooltip` appears where it is pointed at.
    pub(crate) fn marker(
        &mut self,
        centre: (f64, f64),
        radius: f64,
        marker: Marker,
        colour: Colour,
        tooltip: &str,
    ) {
        let title = tooltip_of(tooltip);
        let hex = colour.hex();
        let shape = |sides: usize, turn: f64, radius: f64| {
            let corner = |at: usize| {
                let angle = (at as f64 / sides as f64 + turn) * std::f64::consts::TAU;
                (centre.0 + radius * angle.sin(), centre.1 - radius * angle.cos())
            };
            format!("{}Z", path_of(&(0..sides).map(corner).collect::<Vec<_>>()))
        };
        let (x, y) = centre;
        let outline = format!("fill=\"#{hex}\" stroke=\"#ffffff\" stroke-width=\"0.4\"");
        let open = format!("fill=\"#ffffff\" stroke=\"#{hex}\" stroke-width=\"1.1\"");
        let crossed = |turn: f64| {
            let [a, b, c, d] = [0.0, 0.5, 0.25, 0.75].map(|part| {
                let angle: f64 = (part + turn) * std::f64::consts::TAU;
                (x + 1.1 * radius * angle.sin(), y - 1.1 * radius * angle.cos())
            });
            format!("{}{}", path_of(&[a, b]), path_of(&[c, d]))
        };
        let (path, paint) = match marker {
            Marker::Circle => (circle(centre, radius), outline),
            Marker::Ring => (circle(centre, radius), open),
            Marker::Square => (shape(4, 0.125, 1.25 * radius), outline),
            Marker::Diamond => (shape(4, 0.0, 1.35 * radius), outline),
            Marker::Triangle => (shape(3, 0.0, 1.35 * radius), outline),
            Marker::TriangleDown => (shape(3, 0.5, 1.35 * radius), outline),
            Marker::Pentagon => (
                shape(5, 0.0, 1.2 * radius),
                format!("fill=\"#{hex}\" stroke=\"#000000\" stroke-width=\"0.5\""),
            ),
            Marker::Cross => (crossed(0.125), open),
            Marker::Plus => (crossed(0.0), open),
        };
        self.write(format_args!("<path d=\"{path}\" {paint}>{title}</path>\n"));
    }

    /// One line of text.
    pub(crate) fn text(&mut self, text: Text) {
        let anchor = match text.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y) = (Short(text.place.0), Short(text.place.1));
        let turn = match text.rotate_degrees {
            0.0 => String::new(),
            degrees => format!(" transform=\"rotate({degrees} {x} {y})\""),
        };
        let (size, words) = (text.size, escape(text.text));
        self.write(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\"{turn}>{words}</text>\n"
        ));
    }

    /// A picture stretched over an area. `source` is a data URI.
    pub(crate) fn picture(&mut self, area: Rectangle, source: &str, is_magnified: bool) {
        let rendering = if is_magnified {
            " image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\""
        } else {
            ""
        };
        self.write(format_args!(
            "<image{} preserveAspectRatio=\"none\"{rendering} href=\"{source}\"/>\n",
            area_of(area)
        ));
    }

    fn write(&mut self, what: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(what);
    }

    /// The id of a pattern of hatches on a colour.
    fn hatch(&mut self, colour: Colour, hatch: Hatch) -> String {
        let id = format!("{}-{hatch:?}-{}", self.prefix, colour.hex()).to_lowercase();
        let lines = match hatch {
            Hatch::Solid => "",
            // Beyond the corners, so that the ends of neighbouring tiles meet.
            Hatch::Rising => "M-1,1L1,-1M0,4L4,0M3,5L5,3",
            Hatch::Falling => "M-1,3L1,5M0,0L4,4M3,-1L5,1",
            Hatch::Crossed => "M0,0L4,4M4,0L0,4",
            Hatch::Level => "M0,2L4,2",
            Hatch::Upright => "M2,0L2,4",
            Hatch::Dotted => "M0.5,1L1.5,1M2.5,3L3.5,3",
            Hatch::Grid => "M0,2L4,2M2,0L2,4",
        };
        let (background, foreground) = (colour.hex(), colour.contrast().hex());
        let width = if hatch == Hatch::Dotted { 1.0 } else { 0.6 };
        self.definitions.entry(id.clone()).or_insert_with(|| {
            format!(
                "<pattern id=\"{id}\" width=\"4\" height=\"4\" patternUnits=\"userSpaceOnUse\">\
                 <rect width=\"4\" height=\"4\" fill=\"#{background}\"/>\
                 <path d=\"{lines}\" fill=\"none\" stroke=\"#{foreground}\" stroke-width=\"{width}\"/></pattern>"
            )
        });
        id
    }
}

/// A coordinate with two digits after the point at most.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", (self.0 * 100.0).round() / 100.0)
    }
}

fn path_of(points: &[(f64, f64)]) -> String {
    let mut path = String::new();
    for (at, (x, y)) in points.iter().enumerate() {
        let verb = if at == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{verb}{},{}", Short(*x), Short(*y));
    }
    path
}

fn circle((x, y): (f64, f64), radius: f64) -> String {
    let (left, right, radius, y) = (Short(x - radius), Short(x + radius), Short(radius), Short(y));
    format!("M{left},{y}A{radius},{radius} 0 1 1 {right},{y}A{radius},{radius} 0 1 1 {left},{y}Z")
}

fn area_of(area: Rectangle) -> String {
    let (left, top) = (Short(area.left), Short(area.top));
    let (width, height) = (Short(area.width), Short(area.height));
    format!(" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"")
}

fn stroke_of(stroke: Stroke) -> String {
    let dash = match stroke.dash {
        [] => String::new(),
        lengths => {
            let lengths: Vec<String> = lengths.iter().map(f64::to_string).collect();
            format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
        }
    };
    format!(" stroke=\"#{}\" stroke-width=\"{}\"{dash}", stroke.colour.hex(), stroke.width)
}

fn tooltip_of(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<title>{}</title>", escape(text)) }
}

/// Text as XML and HTML want it, in elements and in quoted attributes. Characters that XML forbids,
/// or that turn the direction of the text around them, become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\n' | '\t' => escaped.push(character),
            '\u{fffe}' | '\u{ffff}' => escaped.push(' '),
            other if matches!(printable(other.encode_utf8(&mut [0; 4])), Cow::Owned(_)) => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}
