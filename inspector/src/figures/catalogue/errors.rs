//! Results of `recorder bench error`: run time against error, four curves; and of `recorder bench skip`.

use formats::bench_result::error::{ErrorRows, EstimatorRow, ImageRow, KeyBitsRow, PrecisionRow};
use formats::bench_result::skip::SkipRow;
use formats::bench_result::{BenchResult, Rows};
use formats::key::method::UNSORTED;
use formats::length_table::TABLE_BITS_DEFAULT;
use formats::metrics::speedup::{Speedup, geometric_mean, median};
use formats::ray::Kind;

use super::building::{self, bench_settings, by_label, figure, machine, range, rate};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};
use crate::output::counted;

const NO_CURVE: &str = "there is no result of `recorder bench error --json` with this curve";
/// A table's name for the length that two-point assumes.
const CONSTANT: &str = "constant";

fn benches<'a>(findings: &Findings<'a>) -> impl Iterator<Item = &'a BenchResult> + Clone {
    findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Error(_)))
}

/// A row with its scene.
type Placed<'a, T> = (String, &'a T);

/// The rows of a curve, each with its scene, and with its machine if there are several.
fn placed<'a, T: 'a>(
    findings: &Findings<'a>,
    rows: impl Fn(&'a ErrorRows) -> &'a [T],
    scene: impl Fn(&T) -> &str,
) -> Vec<Placed<'a, T>> {
    let several = distinct(benches(findings).map(machine)).len() > 1;
    let mut placed = Vec::new();
    for bench in benches(findings) {
        let Rows::Error(errors) = &bench.rows else { continue };
        let place = |row: &T| {
            if several { format!("{}, {}", scene(row), machine(bench)) } else { scene(row).to_owned() }
        };
        placed.extend(rows(errors).iter().map(|row| (place(row), row)));
    }
    placed
}

/// A figure of a curve.
fn curve(findings: &Findings<'_>, title: &str, caption: &str, panels: Vec<Panel>) -> Made {
    figure(title, caption, bench_settings(benches(findings)), panels, NO_CURVE)
}

fn nanoseconds(samples_ns: &[u64], items: u64) -> Option<f64> {
    Some(median(samples_ns)? / items.max(1) as f64)
}

/// Geometric mean over scenes, from the lowest to the highest; `None` for none.
fn mean(x: f64, numbers: &[f64], of: Of) -> Option<Point> {
    let y = geometric_mean(numbers.iter().copied())?;
    Some(Point { spread: range(numbers), ..Point::new(x, y, numbers.len(), of) })
}

/// What rays of a kind are called here, where camera rays are left out.
fn rays_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Closest => "secondary rays",
        Kind::Shadow => "shadow rays",
    }
}

/// Trace rate and errors of each way to test boxes and triangles, a marker a scene.
pub fn precision(findings: &Findings<'_>) -> Made {
    let all = placed(findings, |errors| &errors.precision, |row| &row.scene);
    let careful = |place: &str, kernel: &str| {
        let is_it = |(other, row): &&Placed<PrecisionRow>| {
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
    let of_rays = |row: &PrecisionRow, y: f64| Point::new(0.0, y, row.errors.rays as usize, Of::default());
    let wrong = |row: &PrecisionRow| {
        let errors = &row.errors;
        errors.missed.saturating_add(errors.false_hits).saturating_add(errors.wrong_triangles)
    };
    let mut panels = vec![
        precision_panel(
            &all,
            "what they cost",
            Axis::ratios("trace rate (watertight, padded = 1)"),
            relative,
        ),
        precision_panel(
            &all,
            "error of the distance",
            Axis::logarithmic("largest error (ulp of the coordinates)", 10),
            |_, row| Some(of_rays(row, row.errors.ulp.max)),
        ),
    ];
    if all.iter().any(|(_, row)| wrong(row) > 0) {
        let per_million = |_: &str, row: &PrecisionRow| {
            Some(of_rays(row, wrong(row) as f64 / row.errors.rays.max(1) as f64 * 1e6))
        };
        panels.push(precision_panel(
            &all,
            "wrong hits",
            Axis::from_zero("wrong per million rays"),
            per_million,
        ));
    }
    curve(
        findings,
        "Trace rate against errors of hits",
        "Secondary rays of paths, by kernel, triangle test and box test. Rays traced a second over those of the same kernel with the watertight test and padded boxes, medians, from the first to the third quartile; the largest error of a distance against the exact one; and, where there are any, hits that were missed, made up or of the wrong triangle. What rounding of a ray's own coordinates explains is not counted.",
        panels,
    )
}

fn precision_panel(
    all: &[Placed<PrecisionRow>],
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
        Series::new(*named, style, points.collect())
    };
    let series = places.iter().enumerate().map(series).collect();
    Panel::new(title, Axis::categories("", tests.iter().cloned()), axis, Content::Dots(series))
}

/// What a length table knows by its size and by pass, and what asking it costs.
pub fn estimator(findings: &Findings<'_>) -> Made {
    let all = placed(findings, |errors| &errors.estimator, |row| &row.scene);
    let is_last = |place: &str, row: &EstimatorRow| {
        let of_scene = all.iter().filter(|(other, _)| other == place).map(|(_, row)| row.pass);
        of_scene.max() == Some(row.pass)
    };
    let (sized, default): (Vec<_>, Vec<_>) = (
        all.iter().filter(|(place, row)| row.table_bits > 0 && is_last(place, row)).cloned().collect(),
        all.iter().filter(|(_, row)| row.table_bits == TABLE_BITS_DEFAULT).cloned().collect(),
    );
    let bits = |row: &EstimatorRow| f64::from(row.table_bits);
    let pass = |row: &EstimatorRow| f64::from(row.pass);
    let mut panels = Vec::new();
    for kind in Kind::ALL {
        let by_bits = Axis::marked("bits of the table's address", sized.iter().map(|(_, row)| bits(row)));
        let by_pass = Axis::marked("pass", default.iter().map(|(_, row)| pass(row)));
        panels.push(error_panel(findings, (&all, &sized), kind, by_bits, bits));
        panels.push(error_panel(findings, (&all, &default), kind, by_pass, pass));
    }
    panels.extend(Kind::ALL.map(|kind| cost_panel(findings, &all, kind)));
    curve(
        findings,
        "Errors of estimated lengths by the table's size and by pass, and their cost",
        "Mean error of the estimated length over that of the constant length of two-point, geometric means over scenes, a line per method that addresses the table: by the size of the table, in the last pass; and for tables of 2^20 cells as passes go by. Below: time to add a ray to such a table and to ask it for one, beyond that of a key with the constant.",
        panels,
    )
}

fn is_kind(kind: Kind) -> impl Fn(&&Placed<EstimatorRow>) -> bool {
    move |(_, row)| row.kind == kind
}

/// Errors over those of the constant, of the same scene and pass.
fn error_panel(
    findings: &Findings<'_>,
    (all, shown): (&[Placed<EstimatorRow>], &[Placed<EstimatorRow>]),
    kind: Kind,
    x: Axis,
    at: impl Fn(&EstimatorRow) -> f64,
) -> Panel {
    let ratio = |(place, row): &Placed<EstimatorRow>| {
        let is_constant = |(other, constant): &&Placed<EstimatorRow>| {
            other == place && constant.table_method == CONSTANT && constant.pass == row.pass
        };
        let (_, constant) = all.iter().filter(is_kind(kind)).find(is_constant)?;
        Some(row.error.mean_absolute / constant.error.mean_absolute)
    };
    let own: Vec<&Placed<EstimatorRow>> =
        shown.iter().filter(is_kind(kind)).filter(|(_, row)| row.table_method != CONSTANT).collect();
    let line = |method: &str| {
        let of_method = || own.iter().filter(|(_, row)| row.table_method == method);
        let mut places: Vec<f64> = distinct(of_method().map(|(_, row)| at(row)));
        places.sort_by(f64::total_cmp);
        let point = |x: f64| {
            let ratios: Vec<f64> =
                of_method().filter(|(_, row)| at(row) == x).filter_map(|row| ratio(row)).collect();
            mean(x, &ratios, Of { kind: kind.to_string(), method: method.to_owned(), ..Of::default() })
        };
        let points = places.into_iter().filter_map(point).collect();
        building::of_method(findings, method, points)
    };
    let methods = distinct(own.iter().map(|(_, row)| row.table_method.as_str()));
    let lines = Content::Lines(methods.into_iter().map(line).collect());
    let y = Axis::from_zero("mean error (constant = 1)");
    Panel::new(rays_of(kind), x, y, lines).with_reference("constant length", 1.0)
}

/// Time to add a ray to a table of the usual size and to ask it for one, a row a method, a marker a scene.
fn cost_panel(findings: &Findings<'_>, all: &[Placed<EstimatorRow>], kind: Kind) -> Panel {
    let timed: Vec<&Placed<EstimatorRow>> =
        all.iter().filter(is_kind(kind)).filter(|(_, row)| row.rays_timed > 0).collect();
    let default: Vec<&&Placed<EstimatorRow>> =
        timed.iter().filter(|(_, row)| row.table_bits == TABLE_BITS_DEFAULT).collect();
    let methods = distinct(default.iter().map(|(_, row)| row.table_method.as_str()));
    let point = |(place, row): &Placed<EstimatorRow>| {
        let fixed = timed.iter().find(|(other, row)| other == place && row.table_method == CONSTANT);
        let fixed_ns = fixed.and_then(|(_, row)| nanoseconds(&row.key_ns, row.rays_timed)).unwrap_or(0.0);
        let query_ns = nanoseconds(&row.key_ns, row.rays_timed)? - fixed_ns;
        let x = methods.iter().position(|method| *method == row.table_method)? as f64;
        let y = query_ns + nanoseconds(&row.accumulate_ns, row.rays_timed).unwrap_or(0.0);
        let (scene, method) = (row.scene.clone(), row.table_method.clone());
        let of = Of { scene, kind: kind.to_string(), method, ..Of::default() };
        Some(Point::new(x, y, row.key_ns.len(), of))
    };
    let dots = |method: &&str| {
        let own = default.iter().filter(|(_, row)| row.table_method == **method);
        building::of_method(findings, method, own.filter_map(|row| point(row)).collect())
    };
    let series = methods.iter().map(dots).collect();
    let y = Axis::from_zero("accumulate and query (ns per ray)");
    Panel::new(rays_of(kind), Axis::categories("", methods.iter().copied()), y, Content::Dots(series))
}

/// What bits of a key give and cost.
pub fn key_bits(findings: &Findings<'_>) -> Made {
    let all = placed(findings, |errors| &errors.key_bits, |row| &row.scene);
    let trace = |row: &KeyBitsRow| median(&row.trace_ns);
    let with_sort = |row: &KeyBitsRow| Some(trace(row)? + median(&row.key_ns)? + median(&row.sort_ns)?);
    let panels = Kind::ALL.into_iter().flat_map(|kind| {
        let rays = rays_of(kind);
        [
            bits_panel(findings, &all, kind, format!("{rays}: trace"), trace),
            bits_panel(findings, &all, kind, format!("{rays}: key and sort, too"), with_sort),
        ]
    });
    curve(
        findings,
        "Speedup by bits of the key, in tracing and with key and sort",
        "Trace time of unsorted rays over that of gathered rays, and over that with key and sort; geometric means over scenes of ratios of medians. Gather and scatter, which cost the same for any number of bits, are left out.",
        panels.collect(),
    )
}

fn bits_panel(
    findings: &Findings<'_>,
    all: &[Placed<KeyBitsRow>],
    kind: Kind,
    title: String,
    time: impl Fn(&KeyBitsRow) -> Option<f64>,
) -> Panel {
    let own: Vec<&Placed<KeyBitsRow>> = all.iter().filter(|(_, row)| row.kind == kind).collect();
    let speedup = |(place, row): &Placed<KeyBitsRow>| {
        let is_unsorted = |(other, unsorted): &&&Placed<KeyBitsRow>| {
            other == place && unsorted.method == UNSORTED && unsorted.bounce == row.bounce
        };
        let (_, unsorted) = own.iter().find(is_unsorted)?;
        Some(median(&unsorted.trace_ns)? / time(row)?)
    };
    let sorted = || own.iter().filter(|(_, row)| row.method != UNSORTED);
    let mut bits: Vec<u32> = distinct(sorted().map(|(_, row)| row.key_bits));
    bits.sort_unstable();
    let line = |method: &str| {
        let point = |bits: &u32| {
            let at = sorted().filter(|(_, row)| row.method == method && row.key_bits == *bits);
            let ratios: Vec<f64> = at.filter_map(|row| speedup(row)).collect();
            let of = Of { kind: kind.to_string(), method: method.to_owned(), ..Of::default() };
            mean(f64::from(*bits), &ratios, of)
        };
        let points = bits.iter().filter_map(point).collect();
        building::of_method(findings, method, points)
    };
    let lines = distinct(sorted().map(|(_, row)| row.method.as_str())).into_iter().map(line).collect();
    let x = Axis::marked("bits of the key", bits.iter().map(|&bits| f64::from(bits)));
    Panel::new(title, x, Axis::linear("speedup (×)"), Content::Lines(lines)).with_reference(UNSORTED, 1.0)
}

/// How much faster a picture of the same noise is, and how noise falls with time.
pub fn image(findings: &Findings<'_>) -> Made {
    let all = placed(findings, |errors| &errors.image, |row| &row.scene);
    let places = distinct(all.iter().map(|(place, _)| place.as_str()));
    let last = |place: &str| all.iter().filter(|(other, _)| other == place).map(|(_, row)| row.passes).max();
    let of = |row: &ImageRow| Of {
        scene: row.scene.clone(),
        method: row.method.clone(),
        ..Of::detail(counted(row.passes.into(), "sample per pixel", "samples per pixel"))
    };
    let methods =
        distinct(all.iter().filter(|(_, row)| row.speedup.is_some()).map(|(_, row)| row.method.as_str()));
    let faster = |row: &ImageRow| {
        let Speedup { ratio, interval } = row.speedup?;
        let x = methods.iter().position(|method| *method == row.method)? as f64;
        Some(Point { x, y: ratio, spread: interval, n: row.passes as usize, of: of(row) })
    };
    let noise = |row: &ImageRow| {
        Some(Point::new(row.wall_ns as f64 / 1e9, row.relative_mse, row.passes as usize, of(row)))
    };
    let series = |is_shown: &dyn Fn(&str, &ImageRow) -> bool, point: &dyn Fn(&ImageRow) -> Option<Point>| {
        let of_place = |(style, place): (usize, &&str)| {
            let own = all.iter().filter(|(other, row)| other == place && is_shown(other, row));
            let points = own.filter_map(|(_, row)| point(row)).collect();
            Series::new(*place, style, points)
        };
        places.iter().enumerate().map(of_place).collect::<Vec<_>>()
    };
    let rows = series(&|place, row| Some(row.passes) == last(place), &faster);
    let lines = series(&|_, row| row.method == UNSORTED, &noise);
    let panels = vec![
        Panel::new(
            "the same picture",
            Axis::categories("", methods.iter().copied()),
            Axis::ratios("time of all stages, unsorted over sorted"),
            Content::Dots(rows),
        )
        .with_reference(UNSORTED, 1.0),
        Panel::new(
            "unsorted",
            Axis::logarithmic("time of all stages (s)", 10),
            Axis::logarithmic("relative MSE", 10),
            Content::Lines(lines),
        ),
    ];
    curve(
        findings,
        "Time of a picture by method, and its noise against time",
        "Every queue but the camera's is traced in the order of a method, keys, sorts and gathers included. After as many passes all methods have the same picture, bit for bit: how much less time it takes than unsorted, after the last pass, with 95 % intervals, a marker a scene; and how the mean squared error of unsorted rays' picture, relative to a converged one with another seed, falls with time.",
        panels,
    )
}

/// What skipping saves of the time of each thing.
pub fn skipped(findings: &Findings<'_>) -> Made {
    let benches = || findings.benches.iter().filter(|bench| matches!(bench.rows, Rows::Skip(_)));
    let machines = distinct(benches().map(machine));
    let several = machines.len() > 1;
    let panels = machines.into_iter().map(|one| {
        let rows = benches().filter(|bench| machine(bench) == one).flat_map(|bench| match &bench.rows {
            Rows::Skip(rows) => rows.as_slice(),
            _ => &[],
        });
        skip_panel(&rows.collect::<Vec<_>>(), if several { one.clone() } else { String::new() })
    });
    figure(
        "What skipping saves",
        "Time with what the scene does not need, over the time without: medians and 95 % bootstrap intervals. At 1 nothing is saved.",
        bench_settings(benches()),
        panels,
        "there is no result of `recorder bench skip --json`",
    )
}

fn skip_panel(rows: &[&SkipRow], title: String) -> Panel {
    // What it is a part of is said where that tells rows apart.
    let is_alone = |row: &SkipRow| rows.iter().all(|other| other.what != row.what || other.of == row.of);
    let name = |row: &SkipRow| match is_alone(row) {
        true => row.what.clone(),
        false => format!("{} ({})", row.what, row.of),
    };
    let ratio = |row: &SkipRow| Speedup::of(&row.done.samples_ns, &row.skipped.samples_ns);
    let timed: Vec<&SkipRow> = rows.iter().copied().filter(|row| ratio(row).is_some()).collect();
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
