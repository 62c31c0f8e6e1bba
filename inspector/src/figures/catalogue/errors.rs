//! Results of `recorder bench error`: run time against error, four curves; and of `recorder bench skip`.

use formats::bench_result::error::{ErrorRows, EstimatorRow, ImageRow, KeyBitsRow, PrecisionRow};
use formats::bench_result::skip::SkipRow;
use formats::bench_result::{BenchResult, Rows};
use formats::key::method::UNSORTED;
use formats::metrics::speedup::{Speedup, median, quantile};
use formats::ray::Kind;

use super::building::{
    bench_settings, categories, figure, kind_title, linear, logarithmic, machine, marked, method_style,
};
use super::{Material, Skipped};
use crate::analysis::summary::distinct;
use crate::figures::model::{Content, Figure, Panel, Point, Reference, Series};

const NO_ERROR: &str = "there is no result of `recorder bench error --json` with this curve";

/// Results with errors, each with its machine.
fn results<'a>(material: &Material<'a>) -> Vec<(&'a BenchResult, &'a ErrorRows)> {
    let rows = |bench: &'a BenchResult| match &bench.rows {
        Rows::Error(rows) => Some((bench, &**rows)),
        _ => None,
    };
    material.benches.iter().filter_map(rows).collect()
}

/// The figure of one curve: the panels that each scene of each result gives.
fn curve<'a, T: 'a>(
    material: &Material<'a>,
    [name, title, caption]: [&str; 3],
    rows: impl Fn(&'a ErrorRows) -> &'a [T],
    scene: impl Fn(&'a T) -> &'a str,
    panels: impl Fn(&[&'a T], &str) -> Vec<Panel>,
) -> Result<Figure, Skipped> {
    let results = results(material);
    let several = results.len() > 1;
    let mut made = Vec::new();
    for (bench, errors) in &results {
        for of in distinct(rows(errors).iter().map(&scene)) {
            let own: Vec<&T> = rows(errors).iter().filter(|row| scene(row) == of).collect();
            let title = if several { format!("{of}, {}", machine(bench)) } else { of.to_owned() };
            made.extend(panels(&own, &title));
        }
    }
    let parts = Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        settings: bench_settings(results.iter().map(|(bench, _)| *bench)),
        panels: made,
    };
    figure(parts, NO_ERROR)
}

fn nanoseconds(samples_ns: &[u64], items: u64) -> Option<f64> {
    Some(median(samples_ns)? / items.max(1) as f64)
}

/// Trace rate against wrong answers.
pub fn precision(material: &Material<'_>) -> Result<Figure, Skipped> {
    let words = [
        "precision-error",
        "Trace rate against lost and wrong hits",
        "Secondary rays of paths: hits that were missed, made up or of the wrong triangle, against exact ones, per million rays, and million rays traced a second: medians, whiskers from the first to the third quartile. What rounding of a ray's own coordinates explains is not counted.",
    ];
    curve(
        material,
        words,
        |rows| &rows.precision,
        |row| &row.scene,
        |rows, title| vec![precision_panel(rows, title)],
    )
}

fn precision_panel(rows: &[&PrecisionRow], title: &str) -> Panel {
    let series = |(style, row): (usize, &&PrecisionRow)| {
        let errors = &row.errors;
        let wrong = errors.missed.saturating_add(errors.false_hits).saturating_add(errors.wrong_triangles);
        let rate = |ns: f64| row.rays_timed as f64 / ns.max(f64::MIN_POSITIVE) * 1e3;
        let label = format!("{}, {}, {} boxes", row.kernel, row.triangle_test, row.box_test);
        let quartiles = quantile(&row.samples_ns, 0.75).zip(quantile(&row.samples_ns, 0.25));
        let point = median(&row.samples_ns).map(|ns| Point {
            x: wrong as f64 / errors.rays.max(1) as f64 * 1e6,
            y: rate(ns),
            spread: quartiles
                .filter(|_| row.samples_ns.len() > 1)
                .map(|(slow, fast)| (rate(slow), rate(fast))),
            n: row.samples_ns.len(),
            name: format!("{}, {label}: {wrong} of {} rays", row.scene, errors.rays),
        });
        Series { label, style, points: point.into_iter().collect() }
    };
    Panel {
        title: title.to_owned(),
        x: linear("wrong answers per million rays", true),
        y: linear("trace rate (Mrays/s)", true),
        content: Content::Scatter(rows.iter().enumerate().map(series).collect()),
        references: Vec::new(),
    }
}

/// Cost of the length table against the error of its estimates, and how it learns.
pub fn estimator(material: &Material<'_>) -> Result<Figure, Skipped> {
    let words = [
        "estimator-cost",
        "Cost of the length table against the error of its estimates",
        "Left of each pair: time to add a ray to the table and to ask it for one, against the mean error of the estimated length in units of the scene's largest extent, a line per method that addresses the table, a marker per size, and the constant length of two-point. Right: errors of tables of 2^20 cells as passes go by.",
    ];
    curve(
        material,
        words,
        |rows| &rows.estimator,
        |row| &row.scene,
        |rows, title| {
            let of_kind = |kind: Kind| -> Vec<Panel> {
                let own: Vec<&EstimatorRow> = rows.iter().filter(|row| row.kind == kind).copied().collect();
                let title = format!("{title}: {}", kind_title(kind));
                vec![cost_panel(material, &own, &title), learning_panel(material, &own, &title)]
            };
            Kind::ALL.into_iter().flat_map(of_kind).collect()
        },
    )
}

/// Table methods in their order, the constant (which has no table) first.
fn table_methods<'a>(rows: &[&'a EstimatorRow]) -> Vec<&'a str> {
    distinct(rows.iter().map(|row| row.table_method.as_str()))
}

/// The constant looks like the method that assumes it.
fn estimate_style(material: &Material<'_>, method: &str) -> usize {
    method_style(material, if method == "constant" { "two-point" } else { method })
}

fn cost_panel(material: &Material<'_>, rows: &[&EstimatorRow], title: &str) -> Panel {
    let fixed = rows.iter().find(|row| row.table_bits == 0 && row.rays_timed > 0);
    let fixed_ns = fixed.and_then(|row| nanoseconds(&row.key_ns, row.rays_timed)).unwrap_or(0.0);
    let point = |row: &&EstimatorRow| {
        let query_ns = nanoseconds(&row.key_ns, row.rays_timed)? - fixed_ns;
        let accumulate_ns = nanoseconds(&row.accumulate_ns, row.rays_timed).unwrap_or(0.0);
        Some(Point {
            x: query_ns + accumulate_ns,
            y: row.error.mean_absolute,
            spread: None,
            n: row.error.n as usize,
            name: format!("{}, 2^{} cells by {}", row.scene, row.table_bits, row.table_method),
        })
    };
    let series = |method: &str| Series {
        label: method.to_owned(),
        style: estimate_style(material, method),
        points: rows
            .iter()
            .filter(|row| row.table_method == method && row.rays_timed > 0)
            .filter_map(point)
            .collect(),
    };
    Panel {
        title: title.to_owned(),
        x: linear("accumulate and query (ns per ray)", true),
        y: linear("mean error (unit lengths)", true),
        content: Content::Lines(table_methods(rows).into_iter().map(series).collect()),
        references: Vec::new(),
    }
}

/// Address bits of the tables whose learning is shown: the default.
const LEARNING_BITS: u32 = formats::length_table::TABLE_BITS_DEFAULT;

fn learning_panel(material: &Material<'_>, rows: &[&EstimatorRow], title: &str) -> Panel {
    let point = |row: &&EstimatorRow| Point {
        x: f64::from(row.pass),
        y: row.error.mean_absolute,
        spread: None,
        n: row.error.n as usize,
        name: format!("{}, pass {}, by {}", row.scene, row.pass, row.table_method),
    };
    let is_shown = |row: &&&EstimatorRow| row.table_bits == LEARNING_BITS || row.table_bits == 0;
    let series = |method: &str| Series {
        label: method.to_owned(),
        style: estimate_style(material, method),
        points: rows.iter().filter(is_shown).filter(|row| row.table_method == method).map(point).collect(),
    };
    Panel {
        title: title.to_owned(),
        x: marked("pass", rows.iter().map(|row| f64::from(row.pass))),
        y: linear("mean error (unit lengths)", true),
        content: Content::Lines(table_methods(rows).into_iter().map(series).collect()),
        references: Vec::new(),
    }
}

/// Key and sort time against capsule area and trace time.
pub fn key_bits(material: &Material<'_>) -> Result<Figure, Skipped> {
    let words = [
        "key-bits-cost",
        "Key and sort time against capsule area and trace time",
        "A line per method, a marker per number of key bits, fewest to the left: what keys and their sort take, against the mean capsule area of groups of 64 rays and the trace time of gathered rays, whiskers from the first to the third quartile. The line across is canonical order.",
    ];
    curve(
        material,
        words,
        |rows| &rows.key_bits,
        |row| &row.scene,
        |rows, title| {
            let of_kind = |kind: Kind| -> Vec<Panel> {
                let own: Vec<&KeyBitsRow> = rows.iter().filter(|row| row.kind == kind).copied().collect();
                let title = format!("{title}: {}", kind_title(kind));
                let area = |row: &KeyBitsRow| Some((row.capsule_area, None));
                let trace = |row: &KeyBitsRow| {
                    let milliseconds = |share| Some(quantile(&row.trace_ns, share)? / 1e6);
                    Some((median(&row.trace_ns)? / 1e6, milliseconds(0.25).zip(milliseconds(0.75))))
                };
                vec![
                    bits_panel(material, &own, &title, "mean capsule area (unit space)", area),
                    bits_panel(material, &own, &title, "trace time (ms)", trace),
                ]
            };
            Kind::ALL.into_iter().flat_map(of_kind).collect()
        },
    )
}

fn bits_panel(
    material: &Material<'_>,
    rows: &[&KeyBitsRow],
    title: &str,
    axis: &str,
    of: impl Fn(&KeyBitsRow) -> Option<(f64, Option<(f64, f64)>)>,
) -> Panel {
    let point = |row: &&KeyBitsRow| {
        let (y, spread) = of(row)?;
        Some(Point {
            x: (median(&row.key_ns)? + median(&row.sort_ns)?) / 1e6,
            y,
            spread: spread.filter(|_| row.trace_ns.len() > 1),
            n: row.trace_ns.len().max(1),
            name: format!("{}, bounce {}, {}, {} bits", row.scene, row.bounce, row.method, row.key_bits),
        })
    };
    let methods = distinct(rows.iter().map(|row| row.method.as_str()));
    let series = |method: &str| Series {
        label: method.to_owned(),
        style: method_style(material, method),
        points: rows.iter().filter(|row| row.method == method).filter_map(point).collect(),
    };
    let unsorted = rows.iter().find(|row| row.method == UNSORTED);
    let reference = unsorted.and_then(|row| of(row)).map(|(y, _)| Reference {
        label: "canonical order".to_owned(),
        y,
        span: None,
    });
    Panel {
        title: title.to_owned(),
        x: logarithmic("key and sort time (ms)", 10),
        y: linear(axis, true),
        content: Content::Lines(
            methods.into_iter().filter(|method| *method != UNSORTED).map(series).collect(),
        ),
        references: reference.into_iter().collect(),
    }
}

/// Wall time against the noise of the picture.
pub fn image(material: &Material<'_>) -> Result<Figure, Skipped> {
    let words = [
        "image-error",
        "Noise of the picture against wall time",
        "Mean squared error relative to a converged picture with another seed, after each pass, against the wall time of all passes so far when every queue but the camera's is traced in the order of a method, keys, sorts and gathers included. After as many passes all methods have the same picture, so that a curve further to the left is a faster renderer.",
    ];
    curve(
        material,
        words,
        |rows| &rows.image,
        |row| &row.scene,
        |rows, title| vec![image_panel(material, rows, title)],
    )
}

fn image_panel(material: &Material<'_>, rows: &[&ImageRow], title: &str) -> Panel {
    let point = |row: &&ImageRow| Point {
        x: row.wall_ns as f64 / 1e9,
        y: row.relative_mse,
        spread: None,
        n: row.passes as usize,
        name: format!("{}, {}, {} samples per pixel", row.scene, row.method, row.passes),
    };
    let series = |method: &str| Series {
        label: method.to_owned(),
        style: method_style(material, method),
        points: rows.iter().filter(|row| row.method == method).map(point).collect(),
    };
    Panel {
        title: title.to_owned(),
        x: logarithmic("wall time (s)", 10),
        y: logarithmic("relative MSE", 10),
        content: Content::Lines(
            distinct(rows.iter().map(|row| row.method.as_str())).into_iter().map(series).collect(),
        ),
        references: Vec::new(),
    }
}

/// What skipping saves of the time of each thing.
pub fn skipped(material: &Material<'_>) -> Result<Figure, Skipped> {
    let rows = |bench: &BenchResult| match &bench.rows {
        Rows::Skip(rows) => rows.clone(),
        _ => Vec::new(),
    };
    let benches = || material.benches.iter().filter(|bench| matches!(bench.rows, Rows::Skip(_)));
    let parts = Figure {
        name: "skipped".to_owned(),
        title: "What skipping saves".to_owned(),
        caption: "Time with what the scene does not need, over the time without: medians, whiskers are 95 % bootstrap intervals. At 1 nothing is saved.".to_owned(),
        settings: bench_settings(benches()),
        panels: benches().map(|bench| skip_panel(&rows(bench), machine(bench))).collect(),
    };
    figure(parts, "there is no result of `recorder bench skip --json`")
}

fn skip_panel(rows: &[SkipRow], title: String) -> Panel {
    // What it is a part of is said where that tells rows apart.
    let is_alone = |row: &SkipRow| rows.iter().all(|other| other.what != row.what || other.of == row.of);
    let name = |row: &SkipRow| match is_alone(row) {
        true => row.what.clone(),
        false => format!("{} ({})", row.what, row.of),
    };
    let ratio = |row: &SkipRow| Speedup::of(&row.done.samples_ns, &row.skipped.samples_ns);
    let timed: Vec<(&SkipRow, Speedup)> = rows.iter().filter_map(|row| Some((row, ratio(row)?))).collect();
    let mut names: Vec<String> = Vec::new();
    for (row, _) in &timed {
        if !names.contains(&name(row)) {
            names.push(name(row));
        }
    }
    let scenes = distinct(timed.iter().map(|(row, _)| row.scene.as_str()));
    let series = |(style, scene): (usize, &str)| {
        let own = timed.iter().filter(|(row, _)| row.scene == scene);
        let point = |(row, ratio): &(&SkipRow, Speedup)| {
            let place = names.iter().position(|known| *known == name(row))?;
            Some(Point {
                x: place as f64,
                y: ratio.ratio,
                spread: ratio.interval,
                n: row.done.samples_ns.len(),
                name: format!("{scene}: {} ({})", row.what, row.of),
            })
        };
        Series { label: scene.to_owned(), style, points: own.filter_map(point).collect() }
    };
    Panel {
        title,
        content: Content::Bars(scenes.into_iter().enumerate().map(series).collect()),
        x: categories("skipped", names.iter().cloned()),
        y: linear("time with it over time without", true),
        references: vec![Reference { label: "nothing saved".to_owned(), y: 1.0, span: None }],
    }
}
