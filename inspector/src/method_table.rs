//! Analyses as text: methods beside each other, and what is missing for it.

use crate::analysis::summary::{MeanSpeedup, Rays};
use crate::analysis::{Analysis, MethodSummary, Metric};
use crate::output::{counted, table};

/// One line per kind of rays and method: geometric means over the bounces.
pub(crate) fn methods(analysis: &Analysis) -> String {
    if analysis.summaries.is_empty() {
        return "No method was measured on secondary or shadow rays.".to_owned();
    }
    let has_areas = analysis.summaries.iter().any(|summary| summary.capsule_area_ratio.known().is_some());
    let mut header = vec!["rays", "method", "bounces", "trace speedup", "net speedup"];
    header.extend(has_areas.then_some("capsule area"));
    let mut table = table(&header, 2);
    for summary in &analysis.summaries {
        let mut row = vec![
            summary.rays.name().to_owned(),
            summary.method.clone(),
            summary.queues.to_string(),
            speedup(&summary.trace_speedup),
            speedup(&summary.net_speedup),
        ];
        let ratio = summary.capsule_area_ratio.known();
        row.extend(has_areas.then(|| ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.3}×"))));
        table.add_row(row);
    }
    let mut lines = vec![
        "Methods: geometric means over bounces (lowest to highest) against unsorted rays".to_owned(),
        table.to_string(),
    ];
    lines.extend(Rays::ALL.into_iter().filter_map(|rays| significance(&analysis.summaries, rays)));
    lines.join("\n")
}

fn speedup(speedup: &Metric<MeanSpeedup>) -> String {
    match speedup.known() {
        None => "–".to_owned(),
        Some(MeanSpeedup { mean, n: 1, .. }) => format!("{mean:.2}×"),
        Some(MeanSpeedup { mean, lowest, highest, .. }) => {
            format!("{mean:.2}× ({lowest:.2} to {highest:.2})")
        }
    }
}

/// How many of the net speedups mean anything.
fn significance(summaries: &[MethodSummary], rays: Rays) -> Option<String> {
    let known = || {
        summaries
            .iter()
            .filter(|summary| summary.rays == rays)
            .filter_map(|summary| summary.net_speedup.known())
    };
    let total: usize = known().map(|mean| mean.n).sum();
    let faster: usize = known().map(|mean| mean.faster).sum();
    let slower: usize = known().map(|mean| mean.slower).sum();
    (total > 0).then(|| {
        format!(
            "{} rays, with all costs: {} measured, {faster} faster, {slower} slower, {} with no significant difference",
            rays.name(),
            counted(total as u64, "order", "orders"),
            total - faster - slower
        )
    })
}

/// One line per queue: what its table knows, how far estimates are off, how its best order does.
pub(crate) fn arrays(analysis: &Analysis) -> String {
    let mut parts = vec![orders(analysis), tables(analysis)];
    let mut lines = Vec::new();
    for line in &analysis.correlations {
        let kind = line.kind.map_or("all rays".to_owned(), |kind| format!("{kind} rays"));
        lines.push(match &line.correlation {
            Metric::Known(found) => format!(
                "{}, {kind}: Pearson {:.2}, Spearman {:.2}, n = {}",
                line.of, found.pearson, found.spearman, found.n
            ),
            Metric::Missing { missing } => format!("{}, {kind}: none: {missing}", line.of),
        });
    }
    parts.push(format!("Mean capsule area against trace time\n{}", lines.join("\n")));
    parts.extend(reasons(analysis));
    parts.join("\n\n")
}

fn orders(analysis: &Analysis) -> String {
    let header =
        ["kind", "method", "bounce", "capsule area", "direction spread", "lanes of 8", "of 32", "of 64"];
    let mut table = table(&header, 2);
    for queue in analysis.recordings.iter().flat_map(|recording| recording.measured()) {
        for order in &queue.orders {
            let coherence = order.coherence.known();
            let lanes = order.lanes.known().map_or(&[][..], |lanes| lanes);
            let mut row = vec![queue.kind.to_string(), order.method.clone(), queue.bounce.to_string()];
            row.push(coherence.map_or("–".into(), |found| format!("{:.6}", found.mean_capsule_area)));
            row.push(coherence.map_or("–".into(), |found| format!("{:.4}", found.mean_direction_spread)));
            let lane = |at: usize| lanes.get(at).map_or("–".into(), |lane| percent(lane.utilisation));
            row.extend([lane(0), lane(1), lane(2)]);
            table.add_row(row);
        }
    }
    format!(
        "Coherence: means over groups of {} rays, weighted by rays, in unit space; lane utilisation is a model\n{table}",
        analysis.group_width
    )
}

fn tables(analysis: &Analysis) -> String {
    let header = ["kind", "pass", "bounce", "table fill", "error of table", "error of constant"];
    let mut table = table(&header, 1);
    for queue in analysis.recordings.iter().flat_map(|recording| &recording.queues) {
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
    format!("Estimated lengths: mean |estimate − traced length| in unit lengths\n{table}")
}

/// Why numbers are missing, each reason once.
fn reasons(analysis: &Analysis) -> Option<String> {
    let mut reasons: Vec<&str> = Vec::new();
    for queue in analysis.recordings.iter().flat_map(|recording| recording.measured()) {
        let first = queue.orders.first();
        let of_order = first.map(|order| [order.coherence.reason(), order.lanes.reason()]);
        let of_queue = [queue.table.reason(), queue.estimators.reason()];
        for reason in of_order.into_iter().flatten().chain(of_queue).flatten() {
            if !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
    }
    // The first few name what the others lack as well, queue by queue.
    const SHOWN: usize = 4;
    let more = reasons.len().saturating_sub(SHOWN);
    let mut lines: Vec<String> =
        reasons.iter().take(SHOWN).map(|reason| format!("not known: {reason}")).collect();
    lines.extend((more > 0).then(|| format!("and {more} more of these")));
    (!lines.is_empty()).then(|| lines.join("\n"))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
