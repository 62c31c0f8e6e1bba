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
    vec![
        speedups(),
        stages(),
        sort_rates(),
        correlation(),
        tables(),
        photograph(),
        pixel_costs(),
        bandwidths(),
        hard("tiny-numbers", Scale::Linear { from_zero: false }, &[1e-9, 2.5e-9, 4e-9]),
        hard("huge-numbers", Scale::Linear { from_zero: true }, &[3.2e12, 7.7e12, 9.9e12]),
        hard("one-point", Scale::Linear { from_zero: false }, &[42.0]),
        hard("equal-values", Scale::Logarithmic { base: 10 }, &[5.0, 5.0, 5.0]),
        hard("short-decade", Scale::Logarithmic { base: 10 }, &[110.0, 140.0, 190.0]),
        hard("many-decades", Scale::Logarithmic { base: 10 }, &[1e-9, 1.0, 1e9]),
        bars_of("one-category", "two-point-adaptive bits", 1, 1),
        bars_of("twenty-categories", "two-point-adaptive bits", 20, 3),
        bars_of("twenty-short-names", "n =", 20, 1),
        distributions(),
        markup(),
    ]
}

pub(super) fn point(x: f64, y: f64, spread: f64) -> Point {
    let spread = (spread > 0.0).then_some((y * (1.0 - spread), y * (1.0 + 1.5 * spread)));
    Point { x, y, spread, n: 10, name: format!("sample at {x}") }
}

fn axis(label: &str, scale: Scale) -> Axis {
    Axis { label: label.into(), scale }
}

fn names(names: &[&str]) -> Scale {
    Scale::Categories(names.iter().map(|name| (*name).to_owned()).collect())
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

fn series(label: &str, style: usize, points: Vec<Point>) -> Series {
    Series { label: label.into(), style, points }
}

/// A number between 0 and 1 that looks random.
fn noise(seed: usize) -> f64 {
    ((seed as f64 * 12.9898).sin() * 43_758.547).fract().abs()
}

fn break_even() -> Reference {
    Reference { label: "break-even".into(), y: 1.0, span: None }
}

fn speedups() -> Figure {
    let panel = |title: &str, seed: usize| Panel {
        title: title.into(),
        x: axis("", names(&SCENES)),
        y: axis("trace speedup over pixel order (×)", Scale::Linear { from_zero: true }),
        content: Content::Bars(
            METHODS
                .iter()
                .enumerate()
                .map(|(at, method)| {
                    let points =
                        (0..SCENES.len()).map(|x| point(x as f64, 0.8 + noise(at * 7 + x + seed), 0.04));
                    series(method, at, points.collect())
                })
                .collect(),
        ),
        references: vec![
            break_even(),
            Reference { label: "mean of the paper, RTX 2080 Ti".into(), y: 1.63, span: Some((0.5, 4.5)) },
        ],
    };
    figure("speedups", vec![panel("Secondary rays", 0), panel("Shadow rays", 100)])
}

fn stages() -> Figure {
    let stages = ["key", "sort", "gather", "trace", "accumulate"];
    let panel = |bounce: usize| Panel {
        title: format!("Bounce {bounce}"),
        x: axis("", names(&METHODS)),
        y: axis("time (ms)", Scale::Linear { from_zero: true }),
        content: Content::Stacks(
            stages
                .iter()
                .enumerate()
                .map(|(at, stage)| {
                    let points = (0..METHODS.len()).map(|x| point(x as f64, noise(at + 9 * x + bounce), 0.1));
                    series(stage, at, points.collect())
                })
                .collect(),
        ),
        references: vec![Reference { label: "unsorted trace".into(), y: 1.9, span: None }],
    };
    figure("stages", (1..5).map(panel).collect())
}

fn sort_rates() -> Figure {
    let line = |at: usize, name: &str| {
        let points = (10..25).map(|power| {
            let n = f64::from(power).exp2();
            point(n, n / (40.0 + 0.02 * (at + 1) as f64 * n) * 1e3, 0.05)
        });
        series(name, at, points.collect())
    };
    let panel = Panel {
        title: String::new(),
        x: axis("keys", Scale::Logarithmic { base: 2 }),
        y: axis("rate (Mkeys/s)", Scale::Logarithmic { base: 10 }),
        content: Content::Lines(vec![
            line(0, "8 bits"),
            line(1, "16 bits"),
            line(2, "32 bits"),
            line(3, "64 bits"),
        ]),
        references: Vec::new(),
    };
    figure("sort-rates", vec![panel])
}

fn correlation() -> Figure {
    let cloud = |at: usize| {
        let points = (0..12).map(|sample| {
            let area = 10f64.powf(noise(at * 31 + sample) * 3.0 - 2.0);
            point(area, 0.4 + area.sqrt() * (1.0 + noise(sample + 77 * at)), 0.0)
        });
        let name = format!("{} with a name that is longer than any legend likes to have it", METHODS[at]);
        series(&name, at, points.collect())
    };
    let panel = Panel {
        title: "Capsule area against trace time, all scenes, bounces and kinds".into(),
        x: axis("mean capsule area (unit space)", Scale::Logarithmic { base: 10 }),
        y: axis(
            "time per ray relative to pixel order, which is the baseline of everything (×)",
            Scale::Linear { from_zero: true },
        ),
        content: Content::Scatter((0..9).map(cloud).collect()),
        references: vec![break_even()],
    };
    figure("correlation", vec![panel])
}

fn tables() -> Figure {
    let side = 64u32;
    let ramp =
        |at: u32| [(at * 4) as u8, (255.0 * (f64::from(at) / 63.0).sqrt()) as u8, (255 - at * 3) as u8];
    let picture = |seed: u32| Picture {
        width: side,
        height: side,
        rgb: (0..side * side).map(|cell| ramp((cell * seed / 17 + (cell ^ (cell >> 6))) % 64)).collect(),
        colour_bar: Some(ColourBar {
            label: "rays per cell".into(),
            range: (0.0, 12_500.0),
            colours: (0..64).map(ramp).collect(),
        }),
    };
    let panel = |seed: u32| Panel {
        title: format!("Bounce {seed}"),
        x: axis("cell column", Scale::Linear { from_zero: true }),
        y: axis("cell row", Scale::Linear { from_zero: true }),
        content: Content::Picture(picture(seed)),
        references: Vec::new(),
    };
    figure("tables", vec![panel(1), panel(2), panel(3)])
}

/// Pictures beside maps with colour bars, all as high as each other.
fn pixel_costs() -> Figure {
    let (width, height) = (64, 36);
    let colour = |at: u32| [(at % width * 4) as u8, (at / width * 7) as u8, 90];
    let picture =
        |colour_bar| Picture { width, height, rgb: (0..width * height).map(colour).collect(), colour_bar };
    let bar = |highest| ColourBar {
        label: "nodes visited and triangles tested for each pixel".into(),
        range: (0.0, highest),
        colours: (0..64).map(colour).collect(),
    };
    let panel = |title: String, colour_bar| Panel {
        title,
        x: axis("", Scale::Linear { from_zero: true }),
        y: axis("", Scale::Linear { from_zero: true }),
        content: Content::Picture(picture(colour_bar)),
        references: Vec::new(),
    };
    let pair = |(at, highest): (usize, f64)| {
        let (picture, work) = (format!("{}: picture", SCENES[at]), format!("{}: work per pixel", SCENES[at]));
        [panel(picture, None), panel(work, Some(bar(highest)))]
    };
    figure("pixel-costs", [185.0, 2.1e5, 293.0].into_iter().enumerate().flat_map(pair).collect())
}

/// Bars over three decades; not every series has a bar at every stage, and panels differ in their names.
fn bandwidths() -> Figure {
    let stages = ["key", "sort", "gather", "trace", "trace through indices", "accumulate"];
    let panel = |stages: &[&str]| {
        let bars = METHODS.iter().enumerate().map(|(at, method)| {
            let own = (0..stages.len()).filter(|stage| at > 0 || *stage == 3);
            let rate = |stage: usize| 10f64.powf(2.0 - stage as f64 + 0.5 * noise(at + 9 * stage));
            series(method, at, own.map(|stage| point(stage as f64, rate(stage), 0.3)).collect())
        });
        Panel {
            title: format!("{} stages", stages.len()),
            x: axis("stage", names(stages)),
            y: axis("bandwidth (GB/s)", Scale::Logarithmic { base: 10 }),
            content: Content::Bars(bars.collect()),
            references: Vec::new(),
        }
    };
    figure("bandwidths", vec![panel(&stages[..4]), panel(&stages)])
}

fn photograph() -> Figure {
    let (width, height) = (320, 180);
    let colour = |at: u32| [(at % width * 255 / width) as u8, (at / width * 255 / height) as u8, 90];
    let panel = Panel {
        title: "Camera nave".into(),
        x: axis("", Scale::Linear { from_zero: true }),
        y: axis("", Scale::Linear { from_zero: true }),
        content: Content::Picture(Picture {
            width,
            height,
            rgb: (0..width * height).map(colour).collect(),
            colour_bar: None,
        }),
        references: Vec::new(),
    };
    figure("photograph", vec![panel])
}

fn hard(name: &str, scale: Scale, values: &[f64]) -> Figure {
    let points = values.iter().enumerate().map(|(at, &y)| point(at as f64, y, 0.02)).collect();
    let panel = Panel {
        title: String::new(),
        x: axis("bounce", Scale::Linear { from_zero: false }),
        y: axis("value (unit)", scale),
        content: Content::Lines(vec![series("series", 1, points)]),
        references: Vec::new(),
    };
    figure(name, vec![panel])
}

fn bars_of(name: &str, label: &str, categories: usize, count: usize) -> Figure {
    let labels: Vec<String> = (0..categories).map(|at| format!("{label} {}", 8 + at)).collect();
    let bars = (0..count).map(|one| {
        let points = (0..categories).map(|x| point(x as f64, 1.0 + noise(one * 40 + x), 0.05));
        series(&format!("series {one}"), one, points.collect())
    });
    let panel = Panel {
        title: String::new(),
        x: axis("order", Scale::Categories(labels)),
        y: axis("rate (Mrays/s)", Scale::Linear { from_zero: true }),
        content: Content::Bars(bars.collect()),
        references: vec![break_even()],
    };
    figure(name, vec![panel])
}

fn distributions() -> Figure {
    let panel = |at: usize| Panel {
        title: format!("{}, secondary rays", SCENES[at]),
        x: axis("capsule area", Scale::Logarithmic { base: 10 }),
        y: axis("part of all groups", Scale::Linear { from_zero: true }),
        content: Content::Lines(
            (0..9)
                .map(|method| {
                    let points = (0..=100).map(|step| {
                        let part = f64::from(step) / 100.0;
                        let area = 10f64.powf(4.0 * part - 3.0 + 0.2 * method as f64);
                        point(area, part * part * (3.0 - 2.0 * part), 0.0)
                    });
                    series(METHODS[method], method, points.collect())
                })
                .collect(),
        ),
        references: Vec::new(),
    };
    figure("distributions", (0..7).map(panel).collect())
}

/// Names with everything that SVG, HTML, CSV or LaTeX could trip over.
fn markup() -> Figure {
    let hostile = "a_b & <c>, \"d\" 50 % #1 $x^2$ {~} \\e 2 × 3 ≥ µs";
    let bars = series(
        hostile,
        2,
        vec![Point { name: hostile.into(), ..point(0.0, 1.5, 0.1) }, point(1.0, 0.7, 0.0)],
    );
    let panel = Panel {
        title: hostile.into(),
        x: axis(hostile, names(&["R&D <scene>", "50 % #1_a"])),
        y: axis("ratio (%)", Scale::Linear { from_zero: true }),
        content: Content::Bars(vec![bars]),
        references: vec![Reference { label: "a & b_c".into(), y: 1.0, span: None }],
    };
    figure("markup", vec![panel])
}
