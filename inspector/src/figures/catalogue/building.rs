//! What the figures share: series by method, settings, and the rule that nothing empty is drawn.

use formats::bench_result::BenchResult;
use formats::key::method::{REFERENCES, UNSORTED};
use formats::manifest::Stage;
use formats::metrics::speedup::{median, quantile};

use super::{Findings, Made};
use crate::analysis::summary::{MeanSpeedup, RayClass, distinct};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{Metric, OrderAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Figure, Of, Panel, Point, Scale, Series};
use crate::figures::style::STAGE_STYLES;
use crate::output::counted;

/// A figure of these panels, without what is empty. Its name is that in the catalogue.
///
/// # Errors
/// If nothing is left: with `reason`.
pub fn figure(
    title: impl Into<String>,
    caption: impl Into<String>,
    settings: Vec<String>,
    panels: impl IntoIterator<Item = Panel>,
    reason: impl Into<String>,
) -> Made {
    let mut panels: Vec<Panel> = panels.into_iter().filter_map(without_empty).collect();
    share_rows(&mut panels);
    if panels.is_empty() {
        return Err(reason.into());
    }
    Ok(Figure { name: String::new(), title: title.into(), caption: caption.into(), settings, panels })
}

/// Gives all panels in rows the rows of the one that has most, if those are theirs and few more: they can then be
/// compared across panels, and are named once.
fn share_rows(panels: &mut [Panel]) {
    let rows = |panel: &Panel| match &panel.x.scale {
        Scale::Categories(names) if panel.content.is_in_rows() => Some(names.clone()),
        _ => None,
    };
    let Some(all) = panels.iter().filter_map(rows).max_by_key(Vec::len) else { return };
    for panel in panels {
        let Some(own) = rows(panel).filter(|own| has_most(own, &all)) else { continue };
        let places: Option<Vec<usize>> =
            own.iter().map(|name| all.iter().position(|other| other == name)).collect();
        let Some(places) = places.filter(|places| places.is_sorted()) else { continue };
        panel.x.scale = Scale::Categories(all.clone());
        if let Content::Dots(series) | Content::Stacks(series) = &mut panel.content {
            for point in series.iter_mut().flat_map(|series| &mut series.points) {
                point.x = places.get(point.x as usize).map_or(point.x, |&place| place as f64);
            }
        }
    }
}

/// Whether so few rows are missing that their empty places are no loss: a quarter at most.
fn has_most(own: &[String], all: &[String]) -> bool {
    4 * own.len() >= 3 * all.len()
}

fn without_empty(mut panel: Panel) -> Option<Panel> {
    match &mut panel.content {
        Content::Lines(all) | Content::Scatter(all) | Content::Dots(all) | Content::Stacks(all) => {
            all.retain(|series| series.points.iter().any(|point| point.y.is_finite()));
            (!all.is_empty()).then_some(panel)
        }
        Content::Picture(_) => Some(panel),
    }
}

/// A panel for each of `kinds` of each recording.
pub fn each<'a, K: Copy>(
    kinds: impl IntoIterator<Item = K>,
    recordings: &[&'a RecordingAnalysis],
    panel: impl Fn(&'a RecordingAnalysis, K) -> Panel,
) -> Vec<Panel> {
    let of_kind = |kind| recordings.iter().map(move |recording| (*recording, kind));
    kinds.into_iter().flat_map(of_kind).map(|(recording, kind)| panel(recording, kind)).collect()
}

/// The series of each method of [`methods`].
pub fn by_method(findings: &Findings<'_>, points: impl Fn(&str) -> Vec<Point>) -> Vec<Series> {
    let of = |method| of_method(findings, method, points(method));
    methods(findings).into_iter().map(of).collect()
}

/// The series of each label that some rows have, in the order in which they come up.
pub fn by_label<'a, T>(
    rows: &[&'a T],
    label: impl Fn(&'a T) -> &'a str,
    style: impl Fn(&str) -> usize,
    point: impl Fn(&'a T) -> Option<Point>,
) -> Vec<Series> {
    let of = |name: &str| {
        let own = rows.iter().filter(|row| label(row) == name);
        Series::new(name, style(name), own.filter_map(|row| point(row)).collect())
    };
    distinct(rows.iter().map(|row| label(row))).into_iter().map(of).collect()
}

/// The style of a stage, in all figures the same.
pub fn stage_style(stage: Stage) -> usize {
    STAGE_STYLES + Stage::OF_ORDERS.iter().position(|other| *other == stage).unwrap_or(0)
}

/// A series of a method.
pub fn of_method(findings: &Findings<'_>, method: &str, points: Vec<Point>) -> Series {
    Series::new(method, method_style(findings, method), points)
}

/// What a number of a recording is of: rays of a kind, in all bounces or in one, in the order of a method.
pub fn of(recording: &RecordingAnalysis, rays: impl ToString, bounce: Option<u32>, method: &str) -> Of {
    Of {
        scene: recording.scene.clone(),
        machine: recording.configuration.clone(),
        kind: rays.to_string(),
        bounce,
        method: method.to_owned(),
        detail: String::new(),
    }
}

/// Millions of items a second at `x`, with quartiles; `None` for no samples.
pub fn rate(x: f64, items: u64, samples_ns: &[u64], of: Of) -> Option<Point> {
    let rate = |ns: f64| items as f64 / ns.max(f64::MIN_POSITIVE) * 1e3;
    let quartiles = (rate(quantile(samples_ns, 0.75)?), rate(quantile(samples_ns, 0.25)?));
    let n = samples_ns.len();
    Some(Point { x, y: rate(median(samples_ns)?), spread: (n > 1).then_some(quartiles), n, of })
}

/// Geometric mean of speedups at `x`, from the lowest to the highest; of one its interval. `None` for none.
pub fn mean_speedup<'a>(
    x: f64,
    speedups: impl IntoIterator<Item = &'a SpeedupLine>,
    of: Of,
) -> Option<Point> {
    let MeanSpeedup { mean, lowest, highest, interval, n, .. } = MeanSpeedup::of(speedups)?;
    Some(Point { x, y: mean, spread: if n > 1 { Some((lowest, highest)) } else { interval }, n, of })
}

/// The style of a method: the same number in every figure. Other methods and variants come after those of
/// `all`, in the order in which the recordings have them.
pub fn method_style(findings: &Findings<'_>, method: &str) -> usize {
    crate::figures::method_style::method_style(findings.analysis.recordings.iter(), method)
}

fn measured_methods<'a>(findings: &Findings<'a>) -> Vec<(&'a str, bool)> {
    crate::figures::method_style::measured_methods(findings.analysis.recordings.iter())
}

/// The methods of figures that set methods beside each other: `unsorted`, the built-in ones, users'.
/// Variants, which sweeps show, are among them only if nothing else was measured.
pub fn methods<'a>(findings: &Findings<'a>) -> Vec<&'a str> {
    let measured = measured_methods(findings);
    let has_plain = measured.iter().any(|(method, is_variant)| !is_variant && is_method(method));
    let shown = measured.into_iter().filter(|(_, is_variant)| !(has_plain && *is_variant));
    shown.map(|(method, _)| method).collect()
}

/// None of those that methods are held against.
pub fn is_method(name: &str) -> bool {
    !REFERENCES.contains(&name)
}

/// Recordings that have a row for every method in figures with panels for each.
const MOST_WITH_ALL: usize = 2;
/// Methods otherwise, so that five recordings fit on a page.
const MOST_METHODS: usize = 5;

/// Of [`methods`], those that have rows in a panel of these rays of a recording: all that were measured there, or,
/// where there are many recordings, those that are best net there, and all whose net is not known.
pub fn leading<'a>(findings: &Findings<'a>, recording: &RecordingAnalysis, rays: RayClass) -> Vec<&'a str> {
    let mut rows = methods(findings);
    rows.retain(|method| recording.frame(rays, method).is_some());
    if recordings(findings).len() <= MOST_WITH_ALL {
        return rows;
    }
    let frame = |method: &str| recording.frame(rays, method).filter(|frame| frame.is_candidate());
    let net = |method: &str| frame(method)?.net_speedup.known().map(|line| line.ratio);
    let mut nets: Vec<f64> = rows.iter().filter_map(|method| net(method)).collect();
    nets.sort_by(|a, b| b.total_cmp(a));
    let least = nets.get(MOST_METHODS - 1).copied().unwrap_or(f64::NEG_INFINITY);
    rows.retain(|method| match net(method) {
        Some(net) => net >= least,
        None => frame(method).is_some_and(|frame| frame.trace_speedup.known().is_some()),
    });
    rows
}

/// What a caption says of that.
pub fn left_out(findings: &Findings<'_>) -> String {
    if recordings(findings).len() <= MOST_WITH_ALL {
        return String::new();
    }
    format!(
        " Of more than {MOST_WITH_ALL} recordings each panel has the {MOST_METHODS} methods that are best net there."
    )
}

/// The recordings of such figures: those in which one of [`methods`] was measured besides `unsorted` and the control,
/// or all if there is none.
pub fn recordings<'a>(findings: &Findings<'a>) -> Vec<&'a RecordingAnalysis> {
    let methods = methods(findings);
    let is_shown =
        |order: &OrderAnalysis| is_method(&order.method) && methods.contains(&order.method.as_str());
    let all = || findings.analysis.recordings.iter();
    let shown: Vec<&RecordingAnalysis> = all()
        .filter(|recording| recording.measured().any(|queue| queue.orders.iter().any(is_shown)))
        .collect();
    if shown.is_empty() { all().collect() } else { shown }
}

/// Recordings with numbers, without those whose are all among those of one before them of the same scene.
pub fn without_repeated<'a, T: PartialEq>(
    recordings: Vec<&'a RecordingAnalysis>,
    numbers: impl Fn(&'a RecordingAnalysis) -> Vec<T>,
) -> Vec<&'a RecordingAnalysis> {
    let mut kept: Vec<(&RecordingAnalysis, Vec<T>)> = Vec::new();
    for recording in recordings {
        let own = numbers(recording);
        if own.is_empty() {
            continue;
        }
        let repeats = |(earlier, known): &(&RecordingAnalysis, Vec<T>)| {
            earlier.content_hash == recording.content_hash && own.iter().all(|number| known.contains(number))
        };
        if !kept.iter().any(repeats) {
            kept.push((recording, own));
        }
    }
    kept.into_iter().map(|(recording, _)| recording).collect()
}

/// Of [`recordings`], those that have this number of an order.
pub fn with_number<'a, T: 'a>(
    findings: &Findings<'a>,
    number: impl Fn(&'a OrderAnalysis) -> &'a Metric<T>,
) -> Vec<&'a RecordingAnalysis> {
    let has = |recording: &&'a RecordingAnalysis| {
        recording.measured().flat_map(|queue| &queue.orders).any(|order| number(order).known().is_some())
    };
    recordings(findings).into_iter().filter(has).collect()
}

/// A panel with a row for each method that has a number.
pub fn methods_in_rows(findings: &Findings<'_>, title: String, axis: Axis, series: Vec<Series>) -> Panel {
    let rows = rows_of(findings, &series);
    in_rows(&rows, title, axis, series)
}

/// The methods that have a number, those after all others that no recording of the figure has as an order: a study's
/// control.
pub fn rows_of(findings: &Findings<'_>, series: &[Series]) -> Vec<String> {
    let numbered = series.iter().filter(|series| !series.points.is_empty());
    let numbered = distinct(numbered.map(|series| series.label.as_str()));
    let known = methods(findings).into_iter().filter(|method| numbered.contains(method));
    distinct(known.chain(numbered.iter().copied())).into_iter().map(str::to_owned).collect()
}

/// A panel with these rows, which panels beside each other share.
pub fn in_rows(rows: &[String], title: String, axis: Axis, mut series: Vec<Series>) -> Panel {
    series.retain_mut(|series| {
        let row = rows.iter().position(|method| *method == series.label);
        series.points.iter_mut().for_each(|point| point.x = row.unwrap_or_default() as f64);
        row.is_some()
    });
    Panel::new(title, Axis::categories("", rows), axis, Content::Dots(series))
}

/// What a panel of one recording is called: the rays, and the recording if there are several.
pub fn panel_title(findings: &Findings<'_>, recording: &RecordingAnalysis, rays: &str) -> String {
    match findings.analysis.recordings.len() {
        0 | 1 => rays.to_owned(),
        _ => format!("{}: {rays}", recording.label),
    }
}

/// What a caption says of numbers that a figure is without, see [`lacking`](crate::analysis::lacking).
pub fn without<'a>(
    recordings: impl IntoIterator<Item = &'a RecordingAnalysis>,
    lacking: impl Fn(&RecordingAnalysis) -> Vec<String>,
) -> String {
    let lacking: Vec<String> = recordings.into_iter().flat_map(lacking).collect();
    if lacking.is_empty() {
        return String::new();
    }
    format!(" Missing: {}.", lacking.join("; "))
}

/// Scene, machine and settings of each recording that is in a figure, a line each.
pub fn settings<'a>(recordings: impl IntoIterator<Item = &'a RecordingAnalysis>) -> Vec<String> {
    let line = |recording: &RecordingAnalysis| {
        let options = &recording.options;
        let driver = if recording.adapter.driver.is_empty() {
            String::new()
        } else {
            format!(", {}", recording.adapter.driver)
        };
        format!(
            "{}: scene {} ({} triangles), camera {}, {}{driver}; {}×{}, {}, {}, {}, {} keys, table of 2^{} cells by {}, seed {}; timed by {}{}",
            recording.label,
            recording.scene,
            recording.triangles,
            options.camera,
            recording.configuration,
            options.width,
            options.height,
            counted(options.bounces.into(), "bounce", "bounces"),
            counted(options.passes.into(), "pass", "passes"),
            counted(options.repeats.into(), "repeat", "repeats"),
            recording.key_bits(),
            options.table_bits,
            options.table_method,
            options.seed,
            recording.time_source,
            recording.disturbed()
        )
    };
    recordings.into_iter().map(line).collect()
}

/// Machine and settings of each benchmark, a line each.
pub fn bench_settings<'a>(benches: impl IntoIterator<Item = &'a BenchResult>) -> Vec<String> {
    let line = |bench: &BenchResult| {
        let BenchResult { command, program_version, time_source, .. } = bench;
        format!("{command}: {}, version {program_version}, timed by {time_source}", machine(bench))
    };
    benches.into_iter().map(line).collect()
}

/// What ran a benchmark.
pub fn machine(bench: &BenchResult) -> String {
    let mut parts = vec![bench.backend.clone(), bench.adapter.clone()];
    parts.extend((!bench.driver.is_empty()).then(|| bench.driver.clone()));
    parts.extend((bench.threads > 0).then(|| counted(bench.threads.into(), "thread", "threads")));
    parts.join(", ")
}

/// Why no order of any recording has a number: the first reason that one gives, or `otherwise`.
pub fn reason<'a, T: 'a>(
    findings: &Findings<'a>,
    metric: impl Fn(&'a OrderAnalysis) -> &'a Metric<T>,
    otherwise: &str,
) -> String {
    let queues = findings.analysis.recordings.iter().flat_map(RecordingAnalysis::measured);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_row_is_on_no_other_ones() {
        let point = Point::new(7.0, 1.0, 1, Of::default());
        let series = ["aila", "control", "stray"].map(|label| Series::new(label, 0, vec![point.clone()]));
        let rows = ["aila", "control"].map(str::to_owned);
        let panel = in_rows(&rows, String::new(), Axis::ratios(""), series.into());
        let Content::Dots(series) = panel.content else { panic!("no dots") };
        let places = series.iter().map(|series| (series.label.as_str(), series.points[0].x));
        assert_eq!(places.collect::<Vec<_>>(), [("aila", 0.0), ("control", 1.0)]);
    }
}
