//! How every figure looks: widths, sizes, colours, markers and dashes, in one place.
//!
//! Colours are those of Okabe and Ito (2008), which people with any colour vision tell apart. None of
//! them stands alone: each style has a marker and a dash of its own, so that grey print works.

use clap::ValueEnum;

/// Family name of the embedded font.
pub const FONT_FAMILY: &str = "Liberation Sans";
/// The embedded font: Liberation Sans 2.1.5, SIL Open Font License 1.1.
pub const FONT: &[u8] = include_bytes!("../../assets/LiberationSans-Regular.ttf");
/// Size of ticks, legends and axis labels, points: what is still read at column width.
pub const TEXT_SIZE: f64 = 8.0;
/// Size of panel titles, points.
pub const TITLE_SIZE: f64 = 9.0;
/// From one line of text to the next, in sizes.
pub const LINE_HEIGHT: f64 = 1.2;
/// Pixels per inch of rasterised figures.
pub const DOTS_PER_INCH: f64 = 300.0;
/// Points per inch.
pub const POINTS_PER_INCH: f64 = 72.0;
/// Width of axes and of the outlines of bars, points.
pub const AXIS_STROKE: f64 = 0.5;
/// Width of the lines of series, points.
pub const LINE_STROKE: f64 = 1.1;
/// Half the width of a marker, points.
pub const MARKER_RADIUS: f64 = 2.3;
/// Of grid lines.
pub const GRID_COLOUR: Colour = Colour([0xe2, 0xe2, 0xe2]);
/// Of lines across a panel.
pub const REFERENCE_COLOUR: Colour = Colour([0x60, 0x60, 0x60]);

/// A colour, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// Black.
    pub const BLACK: Self = Self([0; 3]);
    /// White.
    pub const WHITE: Self = Self([255; 3]);

    /// Six hexadecimal digits.
    pub fn hex(self) -> String {
        let [red, green, blue] = self.0;
        format!("{red:02x}{green:02x}{blue:02x}")
    }

    /// Seen on white as a thin line: itself, or darker if it is too light.
    pub fn ink(self) -> Self {
        if self.luma() < 190.0 { self } else { Self(self.0.map(|part| (f64::from(part) * 0.72) as u8)) }
    }

    fn luma(self) -> f64 {
        let [red, green, blue] = self.0.map(f64::from);
        0.299 * red + 0.587 * green + 0.114 * blue
    }
}

/// How wide a figure is: columns of a two-column page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Width {
    /// 3.5 in (89 mm).
    OneColumn,
    /// 7 in (178 mm).
    TwoColumn,
}

impl Width {
    /// In points.
    pub fn points(self) -> f64 {
        match self {
            Self::OneColumn => 3.5 * POINTS_PER_INCH,
            Self::TwoColumn => 7.0 * POINTS_PER_INCH,
        }
    }
}

/// The shape at the points of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    TriangleDown,
    /// ×
    Cross,
    /// +
    Plus,
    /// ⬟
    Pentagon,
    /// ○
    Ring,
}

/// How one series is told from the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Colour of its lines, markers and bars.
    pub colour: Colour,
    /// Shape of its points.
    pub marker: Marker,
    /// Lengths of the strokes and gaps of its lines, points; none for a full line.
    pub dash: &'static [f64],
}

/// Styles with a colour of their own.
pub const COLOURS: usize = 9;

const PALETTE: [Colour; COLOURS] = [
    Colour([0x00, 0x00, 0x00]), // black
    Colour([0x00, 0x72, 0xb2]), // blue
    Colour([0xd5, 0x5e, 0x00]), // vermilion
    Colour([0x00, 0x9e, 0x73]), // bluish green
    Colour([0xe6, 0x9f, 0x00]), // orange
    Colour([0xcc, 0x79, 0xa7]), // reddish purple
    Colour([0x56, 0xb4, 0xe9]), // sky blue
    Colour([0xf0, 0xe4, 0x42]), // yellow
    Colour([0x99, 0x99, 0x99]), // grey
];
const MARKERS: [Marker; 9] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
    Marker::TriangleDown,
    Marker::Cross,
    Marker::Plus,
    Marker::Pentagon,
    Marker::Ring,
];
const DASHES: [&[f64]; 5] = [&[], &[5.0, 2.0], &[1.5, 1.5], &[5.0, 1.5, 1.2, 1.5], &[8.0, 1.5, 2.5, 1.5]];
/// The first of the styles of stages, which no method has: tracing is pale, what sorting adds to it is not.
pub const STAGE_STYLES: usize = 1000;
const STAGE_COLOURS: [Colour; 8] = [
    Colour([0x25, 0x25, 0x25]), // decide
    Colour([0x54, 0x27, 0x8f]), // key
    Colour([0x80, 0x7d, 0xba]), // sort
    Colour([0xbc, 0xbd, 0xdc]), // gather
    Colour([0xdf, 0xe5, 0xea]), // trace
    Colour([0x9a, 0xa5, 0xae]), // scatter
    Colour([0xc7, 0xd0, 0xd8]), // trace through indices
    Colour([0x3d, 0x4a, 0x54]), // accumulate
];
/// Dash of the line across a panel.
pub(crate) const REFERENCE_DASH: &[f64] = &[3.0, 2.0];

/// The style of this number: the same in every figure. The first 9 differ in colour and in marker;
/// later ones repeat colours with other markers; stages have those from [`STAGE_STYLES`] on.
pub fn style(number: usize) -> Style {
    if let Some(stage) = number.checked_sub(STAGE_STYLES) {
        let colour = STAGE_COLOURS[stage % STAGE_COLOURS.len()];
        return Style { colour, marker: Marker::Square, dash: &[] };
    }
    let round = number / COLOURS;
    Style {
        colour: PALETTE[number % COLOURS],
        marker: MARKERS[(number + round) % MARKERS.len()],
        dash: DASHES[(number + 2 * round) % DASHES.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_styles_look_the_same_in_colour_or_in_grey() {
        let styles: Vec<Style> = (0..40).map(style).collect();
        for (at, one) in styles.iter().enumerate() {
            for (other_at, other) in styles[..at].iter().enumerate() {
                assert!(
                    (one.colour, one.marker) != (other.colour, other.marker),
                    "styles {at} and {other_at} are the same"
                );
                if at < 9 {
                    assert_ne!(one.marker, other.marker, "styles {at} and {other_at} in grey");
                }
            }
        }
    }

    #[test]
    fn lines_are_seen_on_white() {
        for colour in PALETTE {
            assert!(colour.ink().luma() < 190.0, "{colour:?}");
            assert_eq!(colour == colour.ink(), colour != PALETTE[7], "yellow alone is too light");
        }
    }
}
