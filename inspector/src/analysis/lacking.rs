//! What some queues of a recording lack of what others have, as where a file is damaged: means and figures are without
//! it.

use super::summary::distinct;
use super::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// Queues with an order that lacks a number which the same method has in another queue, a sentence each that says why.
pub fn of_orders<T>(
    recording: &RecordingAnalysis,
    number: impl Fn(&OrderAnalysis) -> &Metric<T>,
) -> Vec<String> {
    let orders =
        || measured(recording).flat_map(|queue| queue.orders.iter().map(move |order| (queue, order)));
    let known = orders().filter(|(_, order)| number(order).known().is_some());
    let known = distinct(known.map(|(_, order)| order.method.as_str()));
    let lacking = orders().filter(|(_, order)| known.contains(&order.method.as_str()));
    distinct(lacking.filter_map(|(queue, order)| Some(sentence(recording, queue, number(order).reason()?))))
}

/// Measured queues that lack a number which others have, a sentence each that says why.
pub fn of_queues<T>(
    recording: &RecordingAnalysis,
    number: impl Fn(&QueueAnalysis) -> &Metric<T>,
) -> Vec<String> {
    let is_known = measured(recording).any(|queue| number(queue).known().is_some());
    let lacking = measured(recording).filter(|_| is_known);
    lacking.filter_map(|queue| Some(sentence(recording, queue, number(queue).reason()?))).collect()
}

/// All of that.
pub fn all(recording: &RecordingAnalysis) -> Vec<String> {
    let found = [
        of_orders(recording, |order| &order.coherence),
        of_orders(recording, |order| &order.lanes),
        of_queues(recording, |queue| &queue.table),
        of_queues(recording, |queue| &queue.estimators),
    ];
    distinct(found.into_iter().flatten())
}

/// An empty queue lacks nothing.
fn measured(recording: &RecordingAnalysis) -> impl Iterator<Item = &QueueAnalysis> {
    recording.measured().filter(|queue| queue.rays > 0)
}

fn sentence(recording: &RecordingAnalysis, queue: &QueueAnalysis, why: &str) -> String {
    format!("{}, {}: {why}", recording.label, queue.id())
}
