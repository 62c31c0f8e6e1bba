//! What the figures share: axes, styles, settings, and the rule that nothing empty is drawn.

use formats::bench_result::BenchResult;
use formats::key::method::{BUILTIN, UNSORTED};
use formats::ray::Kind;

use super::{Material, Skipped};
use crate::analysis::summary::{Rays, distinct};
use crate::analysis::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Figure, Panel, Point, Scale, Series};

/// An axis of numbers; `from_zero` as in [`Scale::Linear`].
pub fn linear(label: &str, from_zero: bool) -> Axis {
    Axis { label: label.to_owned(), scale: Scale::Linear { from_zero } }
}

/// An axis by powers of `base`.
pub fn logarithmic(label: &str, base: u32) -> Axis {
    Axis { label: label.to_owned(), scale: Scale::Logarithmic { base } }
}

/// An axis of numbers that is marked where they were measured.
pub fn marked(label: &str, numbers: impl IntoIterator<Item = f64>) -> Axis {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    Axis { label: label.to_owned(), scale: Scale::Marked(numbers) }
}

/// An axis of names.
pub fn categories(label: &str, names: impl IntoIterator<Item = impl Into<String>>) -> Axis {
    let names = names.into_iter().map(Into::into).collect();
    Axis { label: label.to_owned(), scale: Scale::Categories(names) }
}

/// A figure of these panels, without what is empty.
///
/// # Errors
/// If nothing is left: with `reason`.
pub fn figure(parts: Figure, reason: impl Into<String>) -> Result<Figure, Skipped> {
    let panels: Vec<Panel> = parts.panels.into_iter().filter_map(without_empty).collect();
    if panels.is_empty() { Err(Skipped::because(reason)) } else { Ok(Figure { panels, ..parts }) }
}

fn without_empty(panel: Panel) -> Option<Panel> {
    let kept = |series: Vec<Series>| {
        let series: Vec<Series> = series
            .into_iter()
            .filter(|series| series.points.iter().any(|point| point.y.is_finite()))
            .collect();
        (!series.is_empty()).then_some(series)
    };
    let content = match panel.content {
        Content::Lines(series) => Content::Lines(kept(series)?),
        Content::Scatter(series) => Content::Scatter(kept(series)?),
        Content::Bars(series) => Content::Bars(kept(series)?),
        Content::Stacks(series) => Content::Stacks(kept(series)?),
        Content::Picture(picture) => Content::Picture(picture),
    };
    Some(Panel { content, ..panel })
}

/// The style of a method: the same number in every figure. Users' methods and variants come after the
/// built-in ones, in the order in which the recordings have them.
pub fn method_style(material: &Material<'_>, method: &str) -> usize {
    if method == UNSORTED {
        return 0;
    }
    if let Some(place) = BUILTIN.iter().position(|(name, ..)| *name == method) {
        return place + 1;
    }
    let others = measured_methods(material).into_iter().map(|(name, _)| name);
    let mut others =
        others.filter(|name| *name != UNSORTED && !BUILTIN.iter().any(|(builtin, ..)| builtin == name));
    others.position(|name| name == method).unwrap_or(0) + BUILTIN.len() + 1
}

/// Every method that was measured, each once, with whether it is a variant of another in all its orders:
/// `unsorted`, the built-in ones in their order, users', variants.
fn measured_methods<'a>(material: &Material<'a>) -> Vec<(&'a str, bool)> {
    let recordings = &material.analysis.recordings;
    let orders = || recordings.iter().flat_map(RecordingAnalysis::measured).flat_map(|queue| &queue.orders);
    let is_variant = |method: &str| {
        orders().filter(|order| order.method == method).all(|order| order.base != order.method)
    };
    let names = distinct(orders().map(|order| order.method.as_str()));
    let mut methods: Vec<(&str, bool)> = names.into_iter().map(|name| (name, is_variant(name))).collect();
    methods.sort_by_key(|&(method, is_variant)| {
        let builtin = BUILTIN.iter().position(|(name, ..)| *name == method);
        (method != UNSORTED, builtin.unwrap_or(BUILTIN.len()), is_variant)
    });
    methods
}

/// The methods of figures that set methods beside each other: `unsorted`, the built-in ones, users'.
/// Variants, which sweeps show, are among them only if nothing else was measured.
pub fn methods<'a>(material: &Material<'a>) -> Vec<&'a str> {
    let measured = measured_methods(material);
    let is_plain = |(method, is_variant): &&(&str, bool)| !is_variant && *method != UNSORTED;
    let has_plain = measured.iter().any(|method| is_plain(&method));
    measured
        .into_iter()
        .filter(|(_, is_variant)| !(has_plain && *is_variant))
        .map(|(method, _)| method)
        .collect()
}

/// The recordings of such figures: those in which one of [`methods`] was measured besides `unsorted`, or
/// all if there is none.
pub fn recordings<'a>(material: &Material<'a>) -> Vec<&'a RecordingAnalysis> {
    let methods = methods(material);
    let is_shown =
        |order: &OrderAnalysis| order.method != UNSORTED && methods.contains(&order.method.as_str());
    let all = || material.analysis.recordings.iter();
    let shown: Vec<&RecordingAnalysis> = all()
        .filter(|recording| recording.measured().any(|queue| queue.orders.iter().any(is_shown)))
        .collect();
    if shown.is_empty() { all().collect() } else { shown }
}

/// The measured queues of a recording with these rays.
pub fn queues(recording: &RecordingAnalysis, rays: Rays) -> impl Iterator<Item = &QueueAnalysis> {
    recording.measured().filter(move |queue| Rays::of(queue) == Some(rays))
}

/// A method's order in a queue.
pub fn order<'a>(queue: &'a QueueAnalysis, method: &str) -> Option<&'a OrderAnalysis> {
    queue.orders.iter().find(|order| order.method == method)
}

/// A series of a method.
pub fn of_method(material: &Material<'_>, method: &str, points: Vec<Point>) -> Series {
    Series { label: method.to_owned(), style: method_style(material, method), points }
}

/// What a panel of one recording is called: the rays, and the recording if there are several.
pub fn panel_title(material: &Material<'_>, recording: &RecordingAnalysis, rays: &str) -> String {
    if material.analysis.recordings.len() > 1 {
        format!("{}: {rays}", recording.label)
    } else {
        rays.to_owned()
    }
}

/// `closest rays`, `shadow rays`.
pub fn kind_title(kind: Kind) -> String {
    format!("{kind} rays")
}

/// `secondary rays`, `shadow rays`.
pub fn rays_title(rays: Rays) -> String {
    format!("{} rays", rays.name())
}

/// Scene, machine and settings of each recording, a line each.
pub fn settings(material: &Material<'_>) -> Vec<String> {
    let line = |recording: &RecordingAnalysis| {
        let options = &recording.options;
        let driver = if recording.adapter.driver.is_empty() {
            String::new()
        } else {
            format!(", {}", recording.adapter.driver)
        };
        format!(
            "{}: scene {} ({} triangles), camera {}, {}{driver}; {}×{}, {} bounces, {} passes, {} repeats, {}-bit keys, table of 2^{} cells by {}, seed {}; timed by {}",
            recording.label,
            recording.scene,
            recording.triangles,
            options.camera,
            recording.configuration,
            options.width,
            options.height,
            options.bounces,
            options.passes,
            options.repeats,
            options.key_bits,
            options.table_bits,
            options.table_method,
            options.seed,
            recording.time_source
        )
    };
    material.analysis.recordings.iter().map(line).collect()
}

/// Machine and settings of each benchmark, a line each.
pub fn bench_settings<'a>(benches: impl IntoIterator<Item = &'a BenchResult>) -> Vec<String> {
    let line = |bench: &BenchResult| {
        format!(
            "{}: {}, version {}, timed by {}",
            bench.command,
            machine(bench),
            bench.program_version,
            bench.time_source
        )
    };
    benches.into_iter().map(line).collect()
}

/// What ran a benchmark.
pub fn machine(bench: &BenchResult) -> String {
    let mut parts = vec![bench.backend.clone(), bench.adapter.clone()];
    parts.extend((!bench.driver.is_empty()).then(|| bench.driver.clone()));
    parts.extend((bench.threads > 0).then(|| format!("{} threads", bench.threads)));
    parts.join(", ")
}

/// Why no order of any recording has a number: the first reason that one gives, or `otherwise`.
pub fn reason<'a, T: 'a>(
    material: &Material<'a>,
    metric: impl Fn(&'a OrderAnalysis) -> &'a Metric<T>,
    otherwise: &str,
) -> String {
    let queues = material.analysis.recordings.iter().flat_map(RecordingAnalysis::measured);
    let orders = queues.flat_map(|queue| &queue.orders).filter(|order| order.method != UNSORTED);
    let mut reasons = orders.filter_map(|order| metric(order).reason());
    reasons.next().unwrap_or(otherwise).to_owned()
}

/// The lowest and highest of some numbers; `None` for fewer than two.
pub fn range(numbers: &[f64]) -> Option<(f64, f64)> {
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (numbers.len() > 1).then_some((low, high))
}
