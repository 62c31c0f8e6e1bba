//! Queue by queue, what each order takes, stage by stage, and what that comes to: the details beneath a
//! [`super::frame`].

use super::frame::{COLUMNS, Costs, shortened};
use super::samples::Samples;
use super::speedup::{Speedup, StageSamples, median};
use crate::key::method::{AUTO, UNSORTED};
use crate::manifest::{LEFT_ALONE, Manifest, QueueId, QueueRecord, Stage, TimingRecord, Way};
use crate::ray::Kind;
use crate::text::{count, one_line, wrapped};

/// Most characters of a choice of `auto` that are shown.
const LONGEST_CHOICE: usize = 200;

/// All queues of a recording, each with a heading and a table of the orders that were measured on it.
pub fn text(manifest: &Manifest) -> String {
    if manifest.queues.is_empty() {
        return "No queue was complete.".to_owned();
    }
    let about = "Queues: medians in ms; speedups over unsorted rays of the same round, ≈ where 1 lies within the \
                 95 % interval; net ones count the trace through indices where it has a *, else gather, trace and \
                 scatter.";
    let (samples, costs) = (Samples::of(manifest), Costs::of(manifest));
    let queues = manifest.queues.iter().map(|queue| {
        let heading = wrapped(&heading(manifest, queue), COLUMNS, 2);
        format!("\n\n{heading}{}", table(manifest, &samples, &costs, queue.id))
    });
    wrapped(about, COLUMNS, 0) + &queues.collect::<String>()
}

fn heading(manifest: &Manifest, queue: &QueueRecord) -> String {
    let QueueId { pass, bounce, kind } = queue.id;
    let mut parts = vec![format!("Pass {pass}, bounce {bounce}, {kind}: {} rays", count(queue.rays))];
    // Stages that serve both kinds stand above the first.
    let is_shared = |timing: &&TimingRecord| {
        kind == Kind::Closest && (timing.pass, timing.bounce, timing.kind) == (pass, bounce, None)
    };
    let shared = manifest.timings.iter().filter(is_shared);
    parts.extend(
        shared.map(|timing| format!("{} {} ms", timing.stage.name(), milliseconds(&timing.samples_ns))),
    );
    let decision = manifest.decisions.iter().find(|decision| decision.queue == queue.id);
    parts.extend(decision.map(|decision| format!("auto: {}", one_line(&decision.chosen(), LONGEST_CHOICE))));
    // Only a driver's own traversal may do so.
    let differing = queue.mismatches.iter().filter(|mismatch| mismatch.rays > 0).map(|mismatch| {
        format!(
            "{} rays found something else in the order of {}",
            count(mismatch.rays),
            shortened(&mismatch.method)
        )
    });
    parts.extend(differing);
    parts.join("; ")
}

/// A line an order, those that the recording names first; nothing if none was timed.
fn table<'a>(manifest: &'a Manifest, samples: &Samples<'a>, costs: &Costs<'_>, queue: QueueId) -> String {
    let named = &manifest.header.options.methods;
    let timed = samples.orders().filter(|(of, _)| *of == queue);
    let mut orders: Vec<(&str, &StageSamples)> =
        timed.filter_map(|(_, method)| Some((method, samples.get(queue, method)?))).collect();
    let place = |method: &str| (method != UNSORTED, named.iter().position(|name| name == method));
    orders.sort_by_key(|(method, _)| place(method));
    let is_timed = |stage: &Stage| orders.iter().any(|(_, own)| !own.of(*stage).is_empty());
    let stages: Vec<Stage> = Stage::OF_ORDERS.into_iter().filter(is_timed).collect();
    if stages.is_empty() {
        return String::new();
    }
    let titles: String = stages.iter().map(|&stage| format!("{:>8}", title(stage))).collect();
    let mut text = format!("\n{:<19}{titles}  trace×  net speedup", "method");
    let unsorted = samples.get(queue, UNSORTED).map(StageSamples::traced);
    let is_alone = manifest.decisions.iter().any(|one| one.queue == queue && one.choice.is_none());
    for (method, own) in orders {
        let way = samples.way(queue, method);
        let cell = |&stage: &Stage| {
            let mark = if stage == Stage::TraceIndirect && way == Way::Indices { "*" } else { "" };
            let ms = milliseconds(own.of(stage));
            format!("{:>8}", if ms.is_empty() { ms } else { mark.to_owned() + &ms })
        };
        let times: String = stages.iter().map(cell).collect();
        let over = |times: &[u64]| unsorted.and_then(|unsorted| Speedup::of(unsorted, times));
        let [trace, net] = match method {
            UNSORTED => [String::new(), String::new()],
            AUTO if is_alone => [String::new(), LEFT_ALONE.to_owned()],
            _ => {
                let trace =
                    over(own.traced()).map_or(String::new(), |of| format!("{}{:.2}", of.mark(), of.ratio));
                let net = || over(&own.totals(way)).map_or(String::new(), |of| of.to_string());
                [trace, costs.remark(method).map_or_else(net, str::to_owned)]
            }
        };
        let line = format!("{:<19}{times}{trace:>8}  {net}", shortened(method));
        text += &format!("\n{}", line.trim_end());
    }
    text
}

/// What a stage is called at the head of a column.
fn title(stage: Stage) -> &'static str {
    match stage {
        Stage::TraceIndirect => "indices",
        Stage::Accumulate => "accum.",
        other => other.name(),
    }
}

/// Three digits or more; nothing without samples.
fn milliseconds(samples_ns: &[u64]) -> String {
    let Some(ms) = median(samples_ns).map(|ns| ns / 1e6) else { return String::new() };
    let decimals = match ms {
        _ if ms < 1.0 => 3,
        _ if ms < 10.0 => 2,
        _ => usize::from(ms < 100.0),
    };
    format!("{ms:.decimals$}")
}
