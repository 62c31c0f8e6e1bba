//! A figure as data: what is drawn, written as CSV and captioned is made from this alone.

use std::fmt;

/// A figure of one or more panels side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without extension, and the word for `--figure`.
    pub name: String,
    /// One line above it in the report.
    pub title: String,
    /// What is shown and how to read it, in sentences. Settings are not part of it.
    pub caption: String,
    /// Scene, machine, settings, n and spread: one line each, for the caption file.
    pub settings: Vec<String>,
    /// The panels, left to right and top to bottom.
    pub panels: Vec<Panel>,
}

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Above it: a scene, a kind of ray. Empty for a figure of one panel.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// What is drawn.
    pub content: Content,
    /// A line across it, such as break-even.
    pub reference: Option<Reference>,
}

impl Panel {
    /// Without a line across.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, content: Content) -> Self {
        Self { title: title.into(), x, y, content, reference: None }
    }

    /// A picture, without axes.
    pub fn picture(title: impl Into<String>, picture: Picture) -> Self {
        Self::new(title, Axis::from_zero(""), Axis::from_zero(""), Content::Picture(picture))
    }

    /// With a line across.
    pub fn with_reference(self, label: &str, y: f64) -> Self {
        Self { reference: Some(Reference { label: label.to_owned(), y }), ..self }
    }
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it shows, with its unit: `trace time (ms)`.
    pub label: String,
    /// How numbers become places.
    pub scale: Scale,
}

impl Axis {
    fn new(label: &str, scale: Scale) -> Self {
        Self { label: label.to_owned(), scale }
    }

    /// Of numbers, near 0 or not.
    pub fn linear(label: &str) -> Self {
        Self::new(label, Scale::Linear { from_zero: false })
    }

    /// Of numbers, with 0.
    pub fn from_zero(label: &str) -> Self {
        Self::new(label, Scale::Linear { from_zero: true })
    }

    /// By powers of `base`.
    pub fn logarithmic(label: &str, base: u32) -> Self {
        Self::new(label, Scale::Logarithmic { base })
    }

    /// Of numbers, marked where they were measured.
    pub fn marked(label: &str, numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers: Vec<f64> = numbers.into_iter().collect();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        Self::new(label, Scale::Marked(numbers))
    }

    /// Of ratios, 1 among them.
    pub fn ratios(label: &str) -> Self {
        Self::new(label, Scale::Ratio)
    }

    /// Of names.
    pub fn categories(label: &str, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self::new(label, Scale::Categories(names.into_iter().map(Into::into).collect()))
    }
}

/// How numbers become places on an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Evenly; starting at 0 if `from_zero`.
    Linear {
        /// Whether 0 is always shown.
        from_zero: bool,
    },
    /// By powers of this base: 2 or 10.
    Logarithmic {
        /// The base.
        base: u32,
    },
    /// Evenly, marked at these numbers, which are those measured.
    Marked(Vec<f64>),
    /// Evenly by ratio, around 1, marked at plain ratios: ½×, 1×, 1.2×.
    Ratio,
    /// Names at 0, 1, 2, …: coordinates are places in this list.
    Categories(Vec<String>),
}

/// What a panel shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Lines through their points, with markers.
    Lines(Vec<Series>),
    /// Markers alone.
    Scatter(Vec<Series>),
    /// Markers in rows, one row a category, numbers to the right; series that are parts of others are small. What
    /// is not named as its row is has its place in the legend.
    Dots(Vec<Series>),
    /// Bars that follow each other in rows, one row a category, numbers to the right.
    Stacks(Vec<Series>),
    /// A picture.
    Picture(Picture),
}

impl Content {
    /// Whether categories are rows, and numbers go to the right.
    pub fn is_in_rows(&self) -> bool {
        matches!(self, Self::Dots(_) | Self::Stacks(_))
    }

    /// Its series; none for a picture.
    pub fn series(&self) -> &[Series] {
        match self {
            Self::Lines(series) | Self::Scatter(series) | Self::Dots(series) | Self::Stacks(series) => series,
            Self::Picture(_) => &[],
        }
    }
}

/// Numbers that belong together: a method, a stage, a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// Which colour, marker and dash: one number per method or stage in every figure.
    pub style: usize,
    /// Its points.
    pub points: Vec<Point>,
    /// Whether its numbers are parts of another's, such as bounces of a frame.
    pub is_part: bool,
}

impl Series {
    /// Of numbers that are no parts.
    pub fn new(label: impl Into<String>, style: usize, points: Vec<Point>) -> Self {
        Self { label: label.into(), style, points, is_part: false }
    }
}

/// A number and how sure it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Coordinate to the right, or the place of a category.
    pub x: f64,
    /// Coordinate upwards.
    pub y: f64,
    /// What the spread reaches from and to, if it is known.
    pub spread: Option<(f64, f64)>,
    /// Samples behind it.
    pub n: usize,
    /// What it is of, for tooltips and the CSV.
    pub of: Of,
}

impl Point {
    /// A number whose spread is not known.
    pub fn new(x: f64, y: f64, n: usize, of: Of) -> Self {
        Self { x, y, spread: None, n, of }
    }
}

/// What a number is of. What does not apply, or is all of them, is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Of {
    /// The scene.
    pub scene: String,
    /// What measured it: backend, adapter, kernel and threads.
    pub machine: String,
    /// Which rays: `closest`, `shadow`, `secondary`.
    pub kind: String,
    /// The bounce.
    pub bounce: Option<u32>,
    /// The method, or whatever order it is.
    pub method: String,
    /// What else tells it from others: a stage, a pass, a test.
    pub detail: String,
}

impl Of {
    /// Of something else alone.
    pub fn detail(detail: impl Into<String>) -> Self {
        Self { detail: detail.into(), ..Self::default() }
    }
}

/// In words; the machine stands in the caption.
impl fmt::Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, kind, bounce, method, detail, .. } = self;
        let bounce = bounce.map(|bounce| format!("bounce {bounce}")).unwrap_or_default();
        let words = [scene, &bounce, kind, method, detail].into_iter().filter(|word| !word.is_empty());
        f.write_str(&words.map(String::as_str).collect::<Vec<_>>().join(", "))
    }
}

/// A line across a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// What it stands for.
    pub label: String,
    /// Where it cuts the upward axis.
    pub y: f64,
}

/// A picture with its colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// sRGB, top row first.
    pub rgb: Vec<[u8; 3]>,
    /// What the colours mean; `None` for a photograph.
    pub colour_bar: Option<ColourBar>,
}

/// What the colours of a picture mean.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourBar {
    /// What it shows, with its unit; empty if the panel's title says it.
    pub label: String,
    /// Value of the first colour and of the last.
    pub range: (f64, f64),
    /// Colours from the first to the last, sRGB.
    pub colours: Vec<[u8; 3]>,
}
