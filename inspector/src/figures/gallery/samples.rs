//! Sample figures: each kind of content, and whatever is hard to lay out.

use crate::figures::model::*;

const METHODS: [&str; 9] = [
    "unsorted",
    "origin",
    "reis",
    "costa",
    "aila",
    "octahedron",
    "two-point",
    "two-point-adaptive",
    "two-point-real",
];
const SCENES: [&str; 7] = [
    "Crytek Sponza",
    "Country Kitchen",
    "Bistro Exterior",
    "San Miguel",
    "Living Room",
    "Breakfast Room",
    "Hairball",
];

pub(super) fn all() -> Vec<Figure> {
    let decades = |label: &str| Axis::logarithmic(label, 10);
    vec![
        speedups(),
        stages(),
        sort_rates(),
        correlation(),
        tables(),
        photograph(),
        pixel_costs(),
        bandwidths(),
        hard("tiny-numbers", Axis::linear, &[1e-9, 2.5e-9, 4e-9]),
        hard("huge-numbers", Axis::from_zero, &[3.2e12, 7.7e12, 9.9e12]),
        hard("one-point", Axis::linear, &[42.0]),
        hard("equal-values", decades, &[5.0, 5.0, 5.0]),
        hard("short-decade", decades, &[110.0, 140.0, 190.0]),
        hard("many-decades", decades, &[1e-9, 1.0, 1e9]),
        frames(),
        rows_of("one-row", "two-point-adaptive bits", 1, &["series 0"]),
        rows_of("twenty-rows", "two-point-adaptive bits", 20, &["series 0", "series 1", "series 2"]),
        distributions(),
        markup(),
        two_in_a_row(),
        names_above_none(),
    ]
}

pub(super) fn point(x: f64, y: f64, spread: f64) -> Point {
    let spread = (spread > 0.0).then_some((y * (1.0 - spread), y * (1.0 + 1.5 * spread)));
    Point { x, y, spread, n: 10, of: Of::detail(format!("sample at {x}")) }
}

pub(super) fn figure(name: &str, panels: Vec<Panel>) -> Figure {
    Figure {
        name: name.into(),
        title: format!("Sample: {name}"),
        caption: "What a sample shows.".into(),
        settings: vec!["Adapter: a card, driver 1".into(), "n = 10, median and interquartile range".into()],
        panels,
    }
}

/// A number between 0 and 1 that looks random.
fn noise(seed: usize) -> f64 {
    ((seed as f64 * 12.9898).sin() * 43_758.547).fract().abs()
}

/// Series in which each number is found by a function of series and category.
fn named<'a>(
    labels: &'a [&str],
    places: usize,
    point: impl Fn(usize, usize) -> Point + 'a,
) -> impl Iterator<Item = Series> + 'a {
    let of = move |(at, label): (usize, &&str)| {
        Series::new(*label, at, (0..places).map(|x| point(at, x)).collect())
    };
    labels.iter().enumerate().map(of)
}

fn speedups() -> Figure {
    let panel = |title: &str, seed: usize| {
        let value = |at: usize, x: usize| point(x as f64, 0.8 + noise(at * 7 + x + seed), 0.04);
        let y = Axis::ratios("trace speedup over pixel order");
        let dots = Content::Dots(named(&METHODS, SCENES.len(), value).collect());
        Panel::new(title, Axis::categories("", SCENES), y, dots).with_reference("break-even", 1.0)
    };
    figure("speedups", vec![panel("Secondary rays", 0), panel("Shadow rays", 100)])
}

fn stages() -> Figure {
    let stages = ["key", "sort", "gather", "trace", "accumulate"];
    let panel = |bounce: usize| {
        let value = |at: usize, x: usize| point(x as f64, noise(at + 9 * x + bounce), 0.1);
        let stacks = Content::Stacks(named(&stages, METHODS.len(), value).collect());
        let (x, y) = (Axis::categories("", METHODS), Axis::from_zero("time (ms)"));
        Panel::new(format!("Bounce {bounce}"), x, y, stacks).with_reference("unsorted trace", 1.9)
    };
    figure("stages", (1..5).map(panel).collect())
}

fn sort_rates() -> Figure {
    let value = |at: usize, step: usize| {
        let n = (step as f64 + 10.0).exp2();
        point(n, n / (40.0 + 0.02 * (at + 1) as f64 * n) * 1e3, 0.05)
    };
    let lines = named(&["8 bits", "16 bits", "32 bits", "64 bits"], 15, value).collect();
    let (x, y) = (Axis::logarithmic("keys", 2), Axis::logarithmic("rate (Mkeys/s)", 10));
    figure("sort-rates", vec![Panel::new("", x, y, Content::Lines(lines))])
}

fn correlation() -> Figure {
    let value = |at: usize, sample: usize| {
        let area = 10f64.powf(noise(at * 31 + sample) * 3.0 - 2.0);
        point(area, 0.4 + area.sqrt() * (1.0 + noise(sample + 77 * at)), 0.0)
    };
    let mut clouds: Vec<Series> = named(&METHODS, 12, value).collect();
    for cloud in &mut clouds {
        cloud.label.push_str(" with a name that is longer than any legend likes to have it");
    }
    let panel = Panel::new(
        "Capsule area against trace time, all scenes, bounces and kinds",
        Axis::logarithmic("mean capsule area (unit space)", 10),
        Axis::from_zero("time per ray relative to pixel order, which is the baseline of everything (×)"),
        Content::Scatter(clouds),
    );
    figure("correlation", vec![panel.with_reference("break-even", 1.0)])
}

fn picture((width, height): (u32, u32), colour: impl Fn(u32) -> [u8; 3], bar: Option<ColourBar>) -> Content {
    Content::Picture(Picture {
        width,
        height,
        rgb: (0..width * height).map(colour).collect(),
        colour_bar: bar,
    })
}

fn tables() -> Figure {
    let ramp =
        |at: u32| [(at * 4) as u8, (255.0 * (f64::from(at) / 63.0).sqrt()) as u8, (255 - at * 3) as u8];
    let panel = |seed: u32| {
        let colours = (0..64).map(ramp).collect();
        let bar = ColourBar { label: "rays per cell".into(), range: (0.0, 12_500.0), colours };
        let cell = |cell: u32| ramp((cell * seed / 17 + (cell ^ (cell >> 6))) % 64);
        let (x, y) = (Axis::from_zero("cell column"), Axis::from_zero("cell row"));
        Panel::new(format!("Bounce {seed}"), x, y, picture((64, 64), cell, Some(bar)))
    };
    figure("tables", vec![panel(1), panel(2), panel(3)])
}

/// A panel without ticks.
fn photo(title: &str, content: Content) -> Panel {
    Panel::new(title, Axis::from_zero(""), Axis::from_zero(""), content)
}

/// Pictures beside maps with colour bars, all as high as each other.
fn pixel_costs() -> Figure {
    let (width, height) = (64, 36);
    let colour = |at: u32| [(at % width * 4) as u8, (at / width * 7) as u8, 90];
    let bar = |highest| ColourBar {
        label: "nodes visited and triangles tested for each pixel".into(),
        range: (0.0, highest),
        colours: (0..64).map(colour).collect(),
    };
    let pair = |(scene, highest): (&str, f64)| {
        let of = |bar| picture((width, height), colour, bar);
        [
            photo(&format!("{scene}: picture"), of(None)),
            photo(&format!("{scene}: work per pixel"), of(Some(bar(highest)))),
        ]
    };
    figure("pixel-costs", SCENES.into_iter().zip([185.0, 2.1e5, 293.0]).flat_map(pair).collect())
}

/// A row a method, its bounces as small dots.
fn frames() -> Figure {
    let bounce = |at: usize, bounce: usize| point(at as f64, 0.7 + noise(at + 9 * bounce), 0.2);
    let parts = named(&METHODS, 5, bounce).map(|series| Series { is_part: true, ..series });
    let frames = METHODS
        .iter()
        .enumerate()
        .map(|(at, label)| Series::new(*label, at, vec![point(at as f64, 1.1, 0.1)]));
    let (x, y) = (Axis::categories("", METHODS), Axis::ratios("net speedup"));
    let panel = Panel::new("Secondary rays", x, y, Content::Dots(parts.chain(frames).collect()));
    figure("frames", vec![panel.with_reference("unsorted", 1.0)])
}

/// Dots over three decades; not every series has one at every stage, and panels differ in their names.
fn bandwidths() -> Figure {
    let stages = ["key", "sort", "gather", "trace", "trace through indices", "accumulate"];
    let panel = |stages: &[&str]| {
        let rate = |at: usize, stage: usize| 10f64.powf(2.0 - stage as f64 + 0.5 * noise(at + 9 * stage));
        let value = |at: usize, stage: usize| point(stage as f64, rate(at, stage), 0.3);
        let mut dots: Vec<Series> = named(&METHODS, stages.len(), value).collect();
        dots[0].points.retain(|point| point.x == 3.0);
        let (x, y) =
            (Axis::categories("", stages.iter().copied()), Axis::logarithmic("bandwidth (GB/s)", 10));
        Panel::new(format!("{} stages", stages.len()), x, y, Content::Dots(dots))
    };
    figure("bandwidths", vec![panel(&stages[..4]), panel(&stages)])
}

fn photograph() -> Figure {
    let (width, height) = (320, 180);
    let colour = |at: u32| [(at % width * 255 / width) as u8, (at / width * 255 / height) as u8, 90];
    figure("photograph", vec![photo("Camera nave", picture((width, height), colour, None))])
}

fn hard(name: &str, y: fn(&str) -> Axis, values: &[f64]) -> Figure {
    let points = values.iter().enumerate().map(|(at, &y)| point(at as f64, y, 0.02)).collect();
    let lines = Content::Lines(vec![Series::new("series", 1, points)]);
    figure(name, vec![Panel::new("", Axis::linear("bounce"), y("value (unit)"), lines)])
}

fn rows_of(name: &str, label: &str, rows: usize, labels: &[&str]) -> Figure {
    let value = |one: usize, x: usize| point(x as f64, 1.0 + noise(one * 40 + x), 0.05);
    let dots = named(labels, rows, value).collect();
    let x = Axis::categories("", (0..rows).map(|at| format!("{label} {}", 8 + at)));
    let panel = Panel::new("", x, Axis::from_zero("rate (Mrays/s)"), Content::Dots(dots));
    figure(name, vec![panel.with_reference("break-even", 1.0)])
}

fn distributions() -> Figure {
    let share = |method: usize, percent: usize| {
        let part = percent as f64 / 100.0;
        let area = 10f64.powf(4.0 * part - 3.0 + 0.2 * method as f64);
        point(area, part * part * (3.0 - 2.0 * part), 0.0)
    };
    let panel = |scene: &str| {
        let lines = Content::Lines(named(&METHODS, 101, share).collect());
        let (x, y) = (Axis::logarithmic("capsule area", 10), Axis::from_zero("part of all groups"));
        Panel::new(format!("{scene}, secondary rays"), x, y, lines)
    };
    figure("distributions", SCENES.into_iter().map(panel).collect())
}

/// Names with everything that SVG, HTML, CSV or LaTeX could trip over.
fn markup() -> Figure {
    let hostile = "a_b & <c>, \"d\" 50 % #1 $x^2$ {~} \\e 2 × 3 ≥ µs";
    let named = Point { of: Of::detail(hostile), ..point(0.0, 1.5, 0.1) };
    let dots = Content::Dots(vec![Series::new(hostile, 2, vec![named, point(1.0, 0.7, 0.0)])]);
    let x = Axis::categories("", ["R&D <scene>", "50 % #1_a"]);
    let panel = Panel::new(hostile, x, Axis::from_zero(hostile), dots);
    figure("markup", vec![panel.with_reference("a & b_c", 1.0)])
}

/// Dots that rows do not name, some of them below 0.
fn two_in_a_row() -> Figure {
    let labels = ["what it takes", "what it saves"];
    let panel = |title: &str| {
        let value = |at: usize, row: usize| match at {
            0 => point(row as f64, 40.0 * (noise(row) - 0.3), 0.0),
            _ => point(row as f64, 40.0 * noise(row + 5), 0.1),
        };
        let dots = Content::Dots(named(&labels, METHODS.len(), value).collect());
        Panel::new(title, Axis::categories("", METHODS), Axis::from_zero("ns per ray"), dots)
    };
    figure("two-in-a-row", SCENES.into_iter().take(4).map(panel).collect())
}

/// Panels of which one in the right column names its rows and the one below it need not.
fn names_above_none() -> Figure {
    let panel = |title: &str, rows: &[&str]| {
        let value = |_, row: usize| point(row as f64, 1.0 + noise(row), 0.0);
        let dots = Content::Dots(named(&["what it takes"], rows.len(), value).collect());
        Panel::new(title, Axis::categories("", rows.iter().copied()), Axis::from_zero("time"), dots)
    };
    let panels = vec![
        panel("sponza: secondary rays", &["unsorted", "two-point"]),
        panel("sponza: shadow rays", &["unsorted", "light-octahedron"]),
        panel("sponza (replay elsewhere): secondary rays", &["unsorted", "two-point"]),
        panel("sponza (replay elsewhere): shadow rays", &["unsorted", "two-point"]),
    ];
    figure("names-above-none", panels)
}
