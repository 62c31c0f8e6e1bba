//! plotters' drawing backend that writes SVG, 16 units to a point, with what plotters has no word for:
//! dashes, tooltips, pictures, and words at any angle.

use std::borrow::Cow;
use std::convert::Infallible;
use std::fmt::{Arguments, Write as _};

use formats::text::printable;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, ShapeStyle, TextStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::style::{Colour, FONT_FAMILY, LINE_HEIGHT};
use super::{FigureError, text};

/// Units per point, since plotters counts in whole ones.
pub(crate) const UNITS_PER_POINT: f64 = 16.0;

/// From the top of a line of text to its baseline, in sizes: capitals stand in the middle of the line.
const BASELINE: f64 = 0.5 * LINE_HEIGHT + 0.36;

/// A part of the page.
pub(crate) type Area = DrawingArea<Svg, Shift>;
/// What drawing a shape gives.
pub(crate) type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl From<DrawingAreaErrorKind<Infallible>> for FigureError {
    fn from(cause: DrawingAreaErrorKind<Infallible>) -> Self {
        Self::Render(cause.to_string())
    }
}

/// Points in units.
pub(crate) fn units(points: f64) -> i32 {
    (points * UNITS_PER_POINT).round() as i32
}

/// A line of this many points.
pub(crate) fn stroke(colour: Colour, width: f64) -> ShapeStyle {
    let Colour([red, green, blue]) = colour;
    ShapeStyle { color: RGBAColor(red, green, blue, 1.0), filled: false, stroke_width: units(width) as u32 }
}

/// Black text of this many points.
pub(crate) fn text_style(size: f64) -> TextStyle<'static> {
    FontDesc::new(FontFamily::Name(FONT_FAMILY), size * UNITS_PER_POINT, FontStyle::Normal).into()
}

/// How a shape is painted: plotters' colour or line, and what plotters has no word for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Paint<'a> {
    /// The colour inside.
    pub(crate) fill: Option<Colour>,
    /// Colour and width of the line, or of the outline, units.
    pub(crate) line: Option<(Colour, u32)>,
    /// Lengths of the strokes and gaps of the line, points; none for a full one.
    pub(crate) dash: &'a [f64],
    /// What is said where the shape is pointed at.
    pub(crate) tooltip: &'a str,
}

impl Paint<'_> {
    /// A line of this many points.
    pub(crate) fn line(colour: Colour, width: f64) -> Self {
        Self { line: Some((colour, units(width) as u32)), ..Self::default() }
    }

    /// As plotters has it. Its colours may be transparent, ours are not.
    fn of(style: &impl BackendStyle, is_filled: bool) -> Self {
        let (red, green, blue) = style.color().rgb;
        let colour = Colour([red, green, blue]);
        let line = (!is_filled).then_some((colour, style.stroke_width()));
        Self { fill: is_filled.then_some(colour), line, ..Self::default() }
    }
}

/// An SVG that is being written.
pub(crate) struct Svg {
    /// Units across and down.
    size: (u32, u32),
    body: String,
}

impl Svg {
    /// An empty one of this many points.
    pub(crate) fn new((width, height): (f64, f64)) -> Self {
        Self { size: (units(width) as u32, units(height) as u32), body: String::new() }
    }

    /// The whole file.
    pub(crate) fn finish(&self, title: &str) -> String {
        let (width, height) = self.size;
        let points = |units: u32| f64::from(units) / UNITS_PER_POINT;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}pt\" height=\"{}pt\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"'{FONT_FAMILY}', Arial, Helvetica, sans-serif\" \
             role=\"img\">\n<title>{}</title>\n{}</svg>\n",
            points(width),
            points(height),
            escape(title),
            self.body,
        )
    }

    /// A rectangle from corner to corner.
    pub(crate) fn rectangle(&mut self, corners: [BackendCoord; 2], paint: Paint) {
        self.shape("rect", &area_of(corners), paint);
    }

    /// A line through points, back to the first one if it is closed.
    pub(crate) fn path(&mut self, points: &[BackendCoord], is_closed: bool, paint: Paint) {
        let corners: Vec<String> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
        let end = if is_closed { "Z" } else { "" };
        self.shape("path", &format!("d=\"M{}{end}\"", corners.join("L")), paint);
    }

    /// A circle.
    pub(crate) fn circle(&mut self, (x, y): BackendCoord, radius: u32, paint: Paint) {
        self.shape("circle", &format!("cx=\"{x}\" cy=\"{y}\" r=\"{radius}\""), paint);
    }

    /// Lines of text, turned clockwise around their anchor; `size` in units.
    pub(crate) fn text(&mut self, text: &str, (x, y): BackendCoord, size: f64, anchor: Pos, degrees: i32) {
        let side = match anchor.h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        let line_height = size * LINE_HEIGHT;
        let height = text.lines().count() as f64 * line_height;
        let top = match anchor.v_pos {
            VPos::Top => 0.0,
            VPos::Center => -0.5 * height,
            VPos::Bottom => -height,
        };
        let turn =
            if degrees == 0 { String::new() } else { format!(" transform=\"rotate({degrees} {x} {y})\"") };
        for (at, line) in text.lines().enumerate() {
            let baseline = f64::from(y) + top + at as f64 * line_height + BASELINE * size;
            let (baseline, line) = (baseline.round(), escape(line));
            self.write(format_args!(
                "<text x=\"{x}\" y=\"{baseline}\" font-size=\"{size}\" text-anchor=\"{side}\"{turn}>{line}</text>\n"
            ));
        }
    }

    /// A picture stretched from corner to corner. `source` is a data URI.
    pub(crate) fn picture(&mut self, corners: [BackendCoord; 2], source: &str, is_magnified: bool) {
        let rendering = if is_magnified {
            " image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\""
        } else {
            ""
        };
        let area = area_of(corners);
        self.write(format_args!(
            "<image {area} preserveAspectRatio=\"none\"{rendering} href=\"{source}\"/>\n"
        ));
    }

    fn write(&mut self, what: Arguments) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(what);
    }

    fn shape(&mut self, tag: &str, geometry: &str, paint: Paint) {
        let Paint { fill, line, dash, tooltip } = paint;
        let fill = fill.map_or("none".to_owned(), |colour| format!("#{}", colour.hex()));
        let line = line.map_or(String::new(), |(colour, width)| {
            format!(" stroke=\"#{}\" stroke-width=\"{width}\"", colour.hex())
        });
        let lengths: Vec<String> = dash.iter().map(|&length| units(length).to_string()).collect();
        let dash = if dash.is_empty() {
            String::new()
        } else {
            format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
        };
        let title =
            if tooltip.is_empty() { String::new() } else { format!("<title>{}</title>", escape(tooltip)) };
        self.write(format_args!("<{tag} {geometry} fill=\"{fill}\"{line}{dash}>{title}</{tag}>\n"));
    }
}

/// What our charts use; any other shape plotters would draw in pixels of a unit each.
impl DrawingBackend for Svg {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        self.draw_rect((x, y), (x + 1, y + 1), &colour, true)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        one: BackendCoord,
        other: BackendCoord,
        style: &S,
        is_filled: bool,
    ) -> Drawn {
        self.rectangle([one, other], Paint::of(style, is_filled));
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        self.path(&path.into_iter().collect::<Vec<_>>(), false, Paint::of(style, false));
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, place: BackendCoord) -> Drawn {
        let degrees = match style.transform() {
            FontTransform::None => 0,
            FontTransform::Rotate90 => 90,
            FontTransform::Rotate180 => 180,
            FontTransform::Rotate270 => -90,
        };
        self.text(text, place, style.size(), style.anchor(), degrees);
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok((text::width(text, style.size()).ceil() as u32, text::height(text, style.size()).ceil() as u32))
    }
}

fn area_of([(x, y), (other_x, other_y)]: [BackendCoord; 2]) -> String {
    let (left, top) = (x.min(other_x), y.min(other_y));
    let (width, height) = (x.abs_diff(other_x), y.abs_diff(other_y));
    format!("x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_what_plotters_has_no_word_for() {
        let mut svg = Svg::new((10.0, 20.0));
        let line = Paint::line(Colour::BLACK, 0.5);
        let fill = Some(Colour([1, 2, 3]));
        svg.rectangle([(16, 32), (0, 0)], Paint { fill, tooltip: "<1>", ..line });
        svg.path(&[(0, 0), (16, 8)], false, Paint { dash: &[2.0, 1.0], ..line });
        svg.text("one\ntwo", (160, 80), 128.0, Pos::new(HPos::Right, VPos::Center), -45);
        let file = svg.finish("title");
        for part in [
            "width=\"10pt\" height=\"20pt\" viewBox=\"0 0 160 320\"",
            "<rect x=\"0\" y=\"0\" width=\"16\" height=\"32\" fill=\"#010203\" \
             stroke=\"#000000\" stroke-width=\"8\"><title>&lt;1&gt;</title></rect>",
            "<path d=\"M0,0L16,8\" fill=\"none\" stroke=\"#000000\" stroke-width=\"8\" \
             stroke-dasharray=\"32 16\"></path>",
            "<text x=\"160\" y=\"49\" font-size=\"128\" text-anchor=\"end\" \
             transform=\"rotate(-45 160 80)\">one</text>",
            "<text x=\"160\" y=\"203\"",
        ] {
            assert!(file.contains(part), "no {part} in {file}");
        }
    }

    #[test]
    fn plotters_is_told_the_size_of_text_in_our_font() {
        let svg = Svg::new((10.0, 20.0));
        let (width, height) = svg.estimate_text_size("00\n0", &text_style(10.0)).unwrap();
        assert_eq!((width, height), (178, 384), "digits are 0.556 wide, lines 1.2 high");
    }
}
