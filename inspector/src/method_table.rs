//! Analyses as text: methods beside each other, and what is missing for it.

use formats::metrics::correlation::Correlation;
use formats::ray::Kind;
use formats::text::{count, one_line};

use crate::analysis::study::StudyGroup;
use crate::analysis::summary::{RayClass, distinct};
use crate::analysis::tables::Estimators;
use crate::analysis::{Analysis, CorrelationLine, OrderAnalysis, QueueAnalysis};
use crate::output::{counted, table};
use crate::shown;

/// Most methods of a group of recordings that are shown.
const MOST_METHODS: usize = 18;

/// Means over a study's recordings of one name on one machine: 80 columns, 25 lines.
pub(crate) fn study_group(group: &StudyGroup) -> String {
    let name =
        if group.name == "recording" { String::new() } else { format!("{}: ", shown::name(&group.name)) };
    let mut lines = vec![
        format!(
            "{name}{}; {} of {}",
            shown::name(&group.configuration),
            counted(group.views as u64, "view", "views"),
            counted(group.scenes.len() as u64, "scene", "scenes")
        ),
        "                     secondary rays               shadow rays".to_owned(),
        "method               trace    net  95 % interval  trace    net  95 % interval".to_owned(),
    ];
    let row = |rays: RayClass, method: &str| group.methods(rays).find(|row| row.method == method);
    let methods = distinct(
        RayClass::ALL.into_iter().flat_map(|rays| group.methods(rays)).map(|row| row.method.as_str()),
    );
    for method in methods.iter().take(MOST_METHODS) {
        let cells = RayClass::ALL.map(|rays| {
            let Some(row) = row(rays, method) else {
                return format!("{:>5} {:>6}  {:<13}", "–", "–", "");
            };
            let times = |ratio: f64| format!("{ratio:.2}×");
            let net = row.net.as_ref().map(|net| net.mean);
            let interval = net.and_then(|net| net.interval);
            format!(
                "{:>5} {:>6}  {:<13}",
                times(row.trace.mean.ratio),
                net.map_or("–".to_owned(), |net| times(net.ratio)),
                interval.map_or(String::new(), |(low, high)| format!("{low:.2} to {high:.2}"))
            )
        });
        lines.push(format!("{:<20} {}", one_line(method, 19), cells.join("  ")).trim_end().to_owned());
    }
    if methods.len() > MOST_METHODS {
        lines.push(format!("… and {} more", methods.len() - MOST_METHODS));
    }
    lines.join("\n")
}

/// What the arrays say: coherence of each order, length tables, correlations, and what is not known; over all bounces,
/// or of each one.
pub(crate) fn arrays(analysis: &Analysis, by_bounce: bool) -> String {
    let [coherence, lengths] = match by_bounce {
        false => [coherence(analysis), lengths(analysis)],
        true => [orders(analysis), tables(analysis)],
    };
    let parts = [coherence, lengths, correlations(analysis), reasons(analysis)];
    parts.into_iter().flatten().collect::<Vec<_>>().join("\n\n")
}

/// The mean of a number over queues, weighted by their rays; `None` if a queue lacks it, or there are none.
fn mean<'q>(
    queues: impl Iterator<Item = &'q QueueAnalysis>,
    of: impl Fn(&QueueAnalysis) -> Option<f64>,
) -> Option<f64> {
    let add = |(sum, rays), queue: &QueueAnalysis| {
        Some((sum + of(queue)? * queue.rays as f64, rays + queue.rays as f64))
    };
    let (sum, rays) = queues.map(Some).try_fold((0.0, 0.0), |sums, queue| add(sums, queue?))?;
    (rays > 0.0).then_some(sum / rays)
}

/// A line per method, its means over bounces: 80 columns. The smallest capsules of secondary rays come first.
fn coherence(analysis: &Analysis) -> Option<String> {
    let queues =
        |rays: RayClass| analysis.recordings.iter().flat_map(move |recording| recording.measured_of(rays));
    // Capsule area, direction spread, utilisation of 32 lanes.
    let means = |rays: RayClass, method: &str| {
        let own = || queues(rays).filter(|queue| queue.order(method).is_some());
        let of_order = |of: fn(&OrderAnalysis) -> Option<f64>| mean(own(), |queue| of(queue.order(method)?));
        [
            of_order(|order| Some(order.coherence.known()?.mean_capsule_area)),
            of_order(|order| Some(order.coherence.known()?.mean_direction_spread)),
            of_order(OrderAnalysis::warp_utilisation),
        ]
    };
    let all = RayClass::ALL.into_iter().flat_map(queues).flat_map(|queue| &queue.orders);
    let methods = distinct(all.map(|order| order.method.as_str()));
    let mut rows: Vec<(&str, [[Option<f64>; 3]; 2])> = methods
        .into_iter()
        .map(|method| (method, RayClass::ALL.map(|rays| means(rays, method))))
        .filter(|(_, means)| means.iter().flatten().any(Option::is_some))
        .collect();
    let area = |means: &[[Option<f64>; 3]; 2]| means.map(|[area, ..]| area.unwrap_or(f64::INFINITY));
    rows.sort_by(|(_, a), (_, b)| {
        let ([a, a_shadow], [b, b_shadow]) = (area(a), area(b));
        a.total_cmp(&b).then(a_shadow.total_cmp(&b_shadow))
    });
    let mut lines = vec![
        format!(
            "Coherence of groups of {} rays: means over all rays; lanes: 32 of them, a model.",
            analysis.group_width
        ),
        "                     secondary rays            shadow rays".to_owned(),
        "method               capsule  spread   lanes   capsule  spread   lanes".to_owned(),
    ];
    for (method, both) in &rows {
        let cells = both.map(|[area, spread, lanes]| {
            let number = |of: Option<f64>| match of {
                None => "–".to_owned(),
                Some(of) if of < 1000.0 => format!("{of:.3}"),
                Some(of) => format!("{of:.1e}"),
            };
            let lanes = lanes.map_or("–".to_owned(), percent);
            format!("{:>7} {:>7} {lanes:>7}", number(area), number(spread))
        });
        lines.push(format!("{:<20} {}", one_line(method, 19), cells.join("   ")));
    }
    (!rows.is_empty()).then(|| lines.join("\n"))
}

/// Whether the length table knows more than one length for all rays does: a line per kind.
fn lengths(analysis: &Analysis) -> Option<String> {
    let line = |kind: Kind| {
        let queues = || {
            let all = analysis.recordings.iter().flat_map(|recording| recording.measured());
            let has_lengths =
                |queue: &&QueueAnalysis| queue.table.known().is_some_and(|table| table.touched > 0);
            all.filter(move |queue| queue.kind == kind && queue.estimators.known().is_some())
                .filter(has_lengths)
        };
        let tables = queues().filter_map(|queue| queue.table.known());
        let fullest = tables.max_by(|a, b| a.fill.total_cmp(&b.fill))?;
        let error = |of: fn(&Estimators) -> f64| mean(queues(), |queue| queue.estimators.known().map(of));
        let (table, constant) = (error(|of| of.table.mean_absolute)?, error(|of| of.constant.mean_absolute)?);
        let cells =
            format!("{} of {} ({})", count(fullest.touched), count(fullest.cells), percent(fullest.fill));
        Some(format!("{:<15} {table:>10.4} {constant:>15.4} {cells:>34}", format!("{kind} rays")))
    };
    let lines: Vec<String> = Kind::ALL.into_iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| {
        format!(
            "Estimated lengths: mean |estimate − traced length|, unit lengths, over bounces\n\
             that find lengths in the table; its cells in use at the last of them.\n\
             \x20                    table    one constant                       cells in use\n{}",
            lines.join("\n")
        )
    })
}

fn orders(analysis: &Analysis) -> Option<String> {
    let header =
        ["kind", "method", "bounce", "capsule area", "direction spread", "lanes of 8", "of 32", "of 64"];
    let mut table = table(&header, 2);
    let mut is_known = false;
    for queue in analysis.recordings.iter().flat_map(|recording| recording.measured()) {
        for order in &queue.orders {
            let coherence = order.coherence.known();
            let lanes = order.lanes.known().map_or(&[][..], |lanes| lanes);
            is_known |= coherence.is_some() || !lanes.is_empty();
            let mut row = vec![queue.kind.to_string(), order.method.clone(), queue.bounce.to_string()];
            row.push(coherence.map_or("–".into(), |found| format!("{:.6}", found.mean_capsule_area)));
            row.push(coherence.map_or("–".into(), |found| format!("{:.4}", found.mean_direction_spread)));
            let lane = |at: usize| lanes.get(at).map_or("–".into(), |lane| percent(lane.utilisation));
            row.extend([lane(0), lane(1), lane(2)]);
            table.add_row(row);
        }
    }
    is_known.then(|| {
        format!(
            "Coherence: means over groups of {} rays, weighted by rays, in unit space; lane utilisation is a model\n{table}",
            analysis.group_width
        )
    })
}

fn tables(analysis: &Analysis) -> Option<String> {
    let header = ["kind", "pass", "bounce", "table fill", "error of table", "error of constant"];
    let mut table = table(&header, 1);
    let known = |queue: &&QueueAnalysis| queue.table.known().is_some() || queue.estimators.known().is_some();
    let queues = analysis.recordings.iter().flat_map(|recording| &recording.queues);
    for queue in queues.filter(known) {
        let fill = queue.table.known().map_or("–".into(), |fill| format!("{:.2} %", fill.fill * 100.0));
        let error = queue.estimators.known();
        table.add_row([
            queue.kind.to_string(),
            queue.pass.to_string(),
            queue.bounce.to_string(),
            fill,
            error.map_or("–".into(), |error| format!("{:.4}", error.table.mean_absolute)),
            error.map_or("–".into(), |error| format!("{:.4}", error.constant.mean_absolute)),
        ]);
    }
    let is_known = table.row_count() > 0;
    is_known.then(|| format!("Estimated lengths: mean |estimate − traced length| in unit lengths\n{table}"))
}

fn correlations(analysis: &Analysis) -> Option<String> {
    let line = |line: &CorrelationLine| {
        let kind = line.kind.map_or("all rays".to_owned(), |kind| format!("{kind} rays"));
        let Correlation { pearson, spearman, n } = line.correlation.known()?;
        Some(format!("{}, {kind}: Pearson {pearson:.2}, Spearman {spearman:.2}, n = {n}", line.of))
    };
    let lines: Vec<String> = analysis.correlations.iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| {
        format!("Correlation of mean capsule area with trace time, both unsorted = 1\n{}", lines.join("\n"))
    })
}

/// Why numbers are missing: for each kind of number the first reason, and how many queues lack it.
fn reasons(analysis: &Analysis) -> Option<String> {
    let queues = || analysis.recordings.iter().flat_map(|recording| recording.measured());
    let of_order = |of: fn(&OrderAnalysis) -> Option<&str>| -> Vec<&str> {
        queues().filter_map(|queue| queue.orders.iter().find_map(of)).collect()
    };
    let of_queue =
        |of: fn(&QueueAnalysis) -> Option<&str>| -> Vec<&str> { queues().filter_map(of).collect() };
    let missing = [
        ("capsules and direction spread", of_order(|order| order.coherence.reason())),
        ("lane utilisation", of_order(|order| order.lanes.reason())),
        ("fill of the length table", of_queue(|queue| queue.table.reason())),
        ("estimated lengths", of_queue(|queue| queue.estimators.reason())),
    ];
    let lines = missing.iter().filter_map(|(what, reasons)| {
        let queues = counted(reasons.len() as u64, "queue", "queues");
        Some(format!("{what}: not known in {queues}: {}", reasons.first()?))
    });
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then(|| {
        format!("{}\nWhat a recording holds is said with `recorder record --keep`.", lines.join("\n"))
    })
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
