//! Results of `recorder bench error`: run time against error, four curves; and of `recorder bench skip`.

use formats::bench_result::Rows;
use formats::bench_result::error::{ErrorRows, EstimatorRow, ImageRow, KeyBitsRow, PrecisionRow};
use formats::bench_result::skip::SkipRow;
use formats::key::method::UNSORTED;
use formats::length_table::TABLE_BITS_DEFAULT;
use formats::metrics::speedup::{Speedup, median, quantile};
use formats::ray::Kind;

use super::building::{bench_settings, by_label, figure, machine, method_style, rate};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};

const NO_CURVE: &str = "there is no result of `recorder bench error --json` with this curve";

/// The figure of one curve: the panels that each scene of each result gives.
fn curve<'a, T: 'a>(
    findings: &Findings<'a>,
    title: &str,
    caption: &str,
    rows: impl Fn(&'a ErrorRows) -> &'a [T],
    scene: impl Fn(&'a T) -> &'a str,
    panels: impl Fn(&[&'a T], &str) -> Vec<Panel>,
) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Error(_)));
    let several = benches().count() > 1;
    let mut made = Vec::new();
    for bench in benches() {
        let Rows::Error(errors) = &bench.rows else { continue };
        for of in distinct(rows(errors).iter().map(&scene)) {
            let own: Vec<&T> = rows(errors).iter().filter(|row| scene(row) == of).collect();
            let title = if several { format!("{of}, {}", machine(bench)) } else { of.to_owned() };
            made.extend(panels(&own, &title));
        }
    }
    figure(title, caption, bench_settings(benches()), made, NO_CURVE)
}

/// The panels of the rows of each kind.
fn each_kind<'a, T, const N: usize>(
    rows: &[&'a T],
    kind: impl Fn(&T) -> Kind,
    title: &str,
    panels: impl Fn(&[&'a T], &str) -> [Panel; N],
) -> Vec<Panel> {
    let of_kind = |one: Kind| {
        let own: Vec<&T> = rows.iter().copied().filter(|row| kind(row) == one).collect();
        panels(&own, &format!("{title}: {one} rays"))
    };
    Kind::ALL.into_iter().flat_map(of_kind).collect()
}

fn nanoseconds(samples_ns: &[u64], items: u64) -> Option<f64> {
    Some(median(samples_ns)? / items.max(1) as f64)
}

/// Trace rate and wrong answers of each way to test boxes and triangles, a marker a scene.
pub fn precision(findings: &Findings<'_>) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Error(_)));
    let several = distinct(benches().map(machine)).len() > 1;
    let mut all: Vec<(String, &PrecisionRow)> = Vec::new();
    for bench in benches() {
        let Rows::Error(errors) = &bench.rows else { continue };
        let place = |row: &PrecisionRow| {
            if several { format!("{}, {}", row.scene, machine(bench)) } else { row.scene.clone() }
        };
        all.extend(errors.precision.iter().map(|row| (place(row), row)));
    }
    let careful = |place: &str, kernel: &str| {
        let is_it = |(other, row): &&(String, &PrecisionRow)| {
            *other == place
                && row.kernel == kernel
                && row.triangle_test == "watertight"
                && row.box_test == "padded"
        };
        let (_, row) = all.iter().find(is_it)?;
        Some(rate(0.0, row.rays_timed, &row.samples_ns, Of::default())?.y)
    };
    let relative = |place: &str, row: &PrecisionRow| {
        let point = rate(0.0, row.rays_timed, &row.samples_ns, Of::default())?;
        let careful = careful(place, &row.kernel)?;
        let spread = point.spread.map(|(low, high)| (low / careful, high / careful));
        Some(Point { y: point.y / careful, spread, ..point })
    };
    let wrong = |_: &str, row: &PrecisionRow| {
        let errors = &row.errors;
        let wrong = errors.missed.saturating_add(errors.false_hits).saturating_add(errors.wrong_triangles);
        let per_million = wrong as f64 / errors.rays.max(1) as f64 * 1e6;
        Some(Point { x: 0.0, y: per_million, spread: None, n: errors.rays as usize, of: Of::default() })
    };
    let rates = Axis::ratios("trace rate (watertight, padded = 1)");
    let panels = if all.is_empty() {
        Vec::new()
    } else {
        vec![
            precision_panel(&all, "what the tests cost", rates, relative),
            precision_panel(&all, "what they are for", Axis::from_zero("wrong per million rays"), wrong),
        ]
    };
    figure(
        "Trace rate against lost and wrong hits",
        "Secondary rays of paths, by kernel, triangle test and box test. Rays traced a second over those of the same kernel with the watertight test and padded boxes, medians, from the first to the third quartile; and hits that were missed, made up or of the wrong triangle, against exact ones. What rounding of a ray's own coordinates explains is not counted.",
        bench_settings(benches()),
        panels,
        NO_CURVE,
    )
}

fn precision_panel(
    all: &[(String, &PrecisionRow)],
    title: &str,
    axis: Axis,
    of: impl Fn(&str, &PrecisionRow) -> Option<Point>,
) -> Panel {
    let test = |row: &PrecisionRow| {
        let triangle =
            if row.triangle_test == "moeller-trumbore" { "Möller–T." } else { &row.triangle_test };
        format!("{}, {triangle}, {}", row.kernel, row.box_test)
    };
    let tests = distinct(all.iter().map(|(_, row)| test(row)));
    let places = distinct(all.iter().map(|(place, _)| place.as_str()));
    let series = |(style, named): (usize, &&str)| {
        let points = all.iter().filter(|(place, _)| place == named).filter_map(|(place, row)| {
            let x = tests.iter().position(|known| *known == test(row))? as f64;
            let number = of(place, row)?;
            Some(Point { x, of: Of { scene: row.scene.clone(), ..Of::detail(test(row)) }, ..number })
        });
        Series { label: (*named).to_owned(), style, points: points.collect(), is_part: false }
    };
    let series = places.iter().enumerate().map(series).collect();
    Panel::new(title, Axis::categories("", tests.iter().cloned()), axis, Content::Dots(series))
}

/// Cost of the length table against the error of its estimates, and how it learns.
pub fn estimator(findings: &Findings<'_>) -> Made {
    curve(
        findings,
        "Cost of the length table against the error of its estimates",
        "Left of each pair: time to add a ray to the table and to ask it for one, against the mean error of the estimated length in units of the scene's largest extent, a line per method that addresses the table, a marker per size, and the constant length of two-point. Right: errors of tables of 2^20 cells as passes go by.",
        |rows| &rows.estimator,
        |row| &row.scene,
        |rows, title| {
            let panels = |own: &[&_], title: &str| {
                [cost_panel(findings, own, title), learning_panel(findings, own, title)]
            };
            each_kind(rows, |row| row.kind, title, panels)
        },
    )
}

/// A line per method that addresses a table, and the constant, which looks like the method that assumes it.
fn estimates<'a>(
    findings: &Findings<'_>,
    rows: &[&'a EstimatorRow],
    point: impl Fn(&'a EstimatorRow) -> Option<Point>,
) -> Content {
    let style =
        |method: &str| method_style(findings, if method == "constant" { "two-point" } else { method });
    Content::Lines(by_label(rows, |row| &row.table_method, style, point))
}

fn cost_panel(findings: &Findings<'_>, rows: &[&EstimatorRow], title: &str) -> Panel {
    let fixed = rows.iter().find(|row| row.table_bits == 0 && row.rays_timed > 0);
    let fixed_ns = fixed.and_then(|row| nanoseconds(&row.key_ns, row.rays_timed)).unwrap_or(0.0);
    let point = |row: &EstimatorRow| {
        let query_ns = nanoseconds(&row.key_ns, row.rays_timed)? - fixed_ns;
        let accumulate_ns = nanoseconds(&row.accumulate_ns, row.rays_timed).unwrap_or(0.0);
        (row.rays_timed > 0).then(|| Point {
            x: query_ns + accumulate_ns,
            y: row.error.mean_absolute,
            spread: None,
            n: row.error.n as usize,
            of: of_table(row, format!("2^{} cells", row.table_bits)),
        })
    };
    Panel::new(
        title,
        Axis::from_zero("accumulate and query (ns per ray)"),
        Axis::from_zero("mean error (unit lengths)"),
        estimates(findings, rows, point),
    )
}

/// What an error of estimates is of.
fn of_table(row: &EstimatorRow, detail: String) -> Of {
    Of {
        scene: row.scene.clone(),
        kind: row.kind.to_string(),
        method: row.table_method.clone(),
        ..Of::detail(detail)
    }
}

fn learning_panel(findings: &Findings<'_>, rows: &[&EstimatorRow], title: &str) -> Panel {
    let point = |row: &EstimatorRow| {
        [0, TABLE_BITS_DEFAULT].contains(&row.table_bits).then(|| Point {
            x: f64::from(row.pass),
            y: row.error.mean_absolute,
            spread: None,
            n: row.error.n as usize,
            of: of_table(row, format!("pass {}", row.pass)),
        })
    };
    Panel::new(
        title,
        Axis::marked("pass", rows.iter().map(|row| f64::from(row.pass))),
        Axis::from_zero("mean error (unit lengths)"),
        estimates(findings, rows, point),
    )
}

/// Key and sort time against capsule area and trace time.
pub fn key_bits(findings: &Findings<'_>) -> Made {
    let area = |row: &KeyBitsRow| Some((row.capsule_area, None));
    let trace = |row: &KeyBitsRow| {
        let milliseconds = |share| Some(quantile(&row.trace_ns, share)? / 1e6);
        Some((milliseconds(0.5)?, milliseconds(0.25).zip(milliseconds(0.75))))
    };
    curve(
        findings,
        "Key and sort time against capsule area and trace time",
        "A line per method, a marker per number of key bits, fewest to the left: what keys and their sort take, against the mean capsule area of groups of 64 rays and the trace time of gathered rays, whiskers from the first to the third quartile. The line across is canonical order.",
        |rows| &rows.key_bits,
        |row| &row.scene,
        |rows, title| {
            let panels = |own: &[&_], title: &str| {
                [
                    bits_panel(findings, own, title, "mean capsule area (unit space)", area),
                    bits_panel(findings, own, title, "trace time (ms)", trace),
                ]
            };
            each_kind(rows, |row| row.kind, title, panels)
        },
    )
}

fn bits_panel(
    findings: &Findings<'_>,
    rows: &[&KeyBitsRow],
    title: &str,
    axis: &str,
    of: impl Fn(&KeyBitsRow) -> Option<(f64, Option<(f64, f64)>)>,
) -> Panel {
    let point = |row: &KeyBitsRow| {
        let (y, spread) = of(row)?;
        Some(Point {
            x: (median(&row.key_ns)? + median(&row.sort_ns)?) / 1e6,
            y,
            spread: spread.filter(|_| row.trace_ns.len() > 1),
            n: row.trace_ns.len().max(1),
            of: Of {
                scene: row.scene.clone(),
                kind: row.kind.to_string(),
                bounce: Some(row.bounce),
                method: row.method.clone(),
                ..Of::detail(format!("{} bits", row.key_bits))
            },
        })
    };
    let (unsorted, sorted): (Vec<&KeyBitsRow>, Vec<&KeyBitsRow>) =
        rows.iter().partition(|row| row.method == UNSORTED);
    let lines = by_label(&sorted, |row| &row.method, |method| method_style(findings, method), point);
    let (x, y) = (Axis::logarithmic("key and sort time (ms)", 10), Axis::from_zero(axis));
    let panel = Panel::new(title, x, y, Content::Lines(lines));
    match unsorted.first().and_then(|row| of(row)) {
        Some((y, _)) => panel.with_reference("canonical order", y),
        None => panel,
    }
}

/// Wall time against the noise of the picture.
pub fn image(findings: &Findings<'_>) -> Made {
    curve(
        findings,
        "Noise of the picture against the time of all stages",
        "Mean squared error relative to a converged picture with another seed, after each pass, against the time of all stages of all passes so far when every queue but the camera's is traced in the order of a method, keys, sorts and gathers included. After as many passes all methods have the same picture, so that a curve further to the left is a faster renderer.",
        |rows| &rows.image,
        |row| &row.scene,
        |rows, title| vec![image_panel(findings, rows, title)],
    )
}

fn image_panel(findings: &Findings<'_>, rows: &[&ImageRow], title: &str) -> Panel {
    let point = |row: &ImageRow| {
        Some(Point {
            x: row.wall_ns as f64 / 1e9,
            y: row.relative_mse,
            spread: None,
            n: row.passes as usize,
            of: Of {
                scene: row.scene.clone(),
                method: row.method.clone(),
                ..Of::detail(format!("{} samples per pixel", row.passes))
            },
        })
    };
    Panel::new(
        title,
        Axis::logarithmic("time of all stages (s)", 10),
        Axis::logarithmic("relative MSE", 10),
        Content::Lines(by_label(rows, |row| &row.method, |method| method_style(findings, method), point)),
    )
}

/// What skipping saves of the time of each thing.
pub fn skipped(findings: &Findings<'_>) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Skip(_)));
    let panels = findings.benches.iter().filter_map(|bench| match &bench.rows {
        Rows::Skip(rows) => Some(skip_panel(rows, machine(bench))),
        _ => None,
    });
    figure(
        "What skipping saves",
        "Time with what the scene does not need, over the time without: medians and 95 % bootstrap intervals. At 1 nothing is saved.",
        bench_settings(benches()),
        panels,
        "there is no result of `recorder bench skip --json`",
    )
}

fn skip_panel(rows: &[SkipRow], title: String) -> Panel {
    // What it is a part of is said where that tells rows apart.
    let is_alone = |row: &SkipRow| rows.iter().all(|other| other.what != row.what || other.of == row.of);
    let name = |row: &SkipRow| match is_alone(row) {
        true => row.what.clone(),
        false => format!("{} ({})", row.what, row.of),
    };
    let ratio = |row: &SkipRow| Speedup::of(&row.done.samples_ns, &row.skipped.samples_ns);
    let timed: Vec<&SkipRow> = rows.iter().filter(|row| ratio(row).is_some()).collect();
    let names = distinct(timed.iter().map(|row| name(row)));
    let point = |row: &SkipRow| {
        let Speedup { ratio, interval } = ratio(row)?;
        Some(Point {
            x: names.iter().position(|known| *known == name(row))? as f64,
            y: ratio,
            spread: interval,
            n: row.done.samples_ns.len(),
            of: Of { scene: row.scene.clone(), ..Of::detail(format!("{} ({})", row.what, row.of)) },
        })
    };
    let scenes = distinct(timed.iter().map(|row| row.scene.as_str()));
    let style = |scene: &str| scenes.iter().position(|known| *known == scene).unwrap_or(0);
    Panel::new(
        title,
        Axis::categories("", names.iter().cloned()),
        Axis::ratios("time with it over time without"),
        Content::Dots(by_label(&timed, |row| &row.scene, style, point)),
    )
    .with_reference("nothing saved", 1.0)
}
