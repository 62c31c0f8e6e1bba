//! Arrays that belong together, and those that speak for themselves: rays, path indices, lights, throughput.

use super::{Check, Queue, Subject};
use crate::key::method::{AUTO, CONTROL, SHUFFLED};
use crate::manifest::{MethodArray, Place, QueueArray, QueueId};
use crate::npy::Element;
use crate::queue_check::QueueRules;
use crate::reader::DumpState;

pub(super) fn check(subject: &Subject<'_>) -> Vec<Check> {
    let mut structure = Check::new("queues");
    let mut rays = Check::new("rays");
    let mut path_ids = Check::new("path indices");
    let mut lights = Check::new("lights");
    let mut throughput = Check::new("throughput");
    for &queue in subject.queues.keys() {
        check_structure(subject, queue, &mut structure);
        check_entries(subject, queue, QueueArray::Rays, QueueRules::ray_fault, &mut rays);
        check_entries(subject, queue, QueueArray::PathIds, QueueRules::path_id_fault, &mut path_ids);
        check_entries(subject, queue, QueueArray::Lights, QueueRules::light_fault, &mut lights);
        let carried = QueueArray::Throughput;
        check_entries(subject, queue, carried, QueueRules::throughput_fault, &mut throughput);
    }
    let throughput = (throughput.checked > 0).then_some(throughput);
    [structure, rays, path_ids, lights].into_iter().chain(throughput).collect()
}

fn check_structure(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let &Queue { record, ref places, .. } = &subject.queues[&queue];
    let is_complete = subject.dump.state() == DumpState::Complete;
    check.require(record.is_some() || !is_complete, || {
        format!("{queue}: there are arrays, but no record of it")
    });
    let mut rays = record.map(|record| (record.rays, "its record"));
    let per_ray = places.iter().filter_map(|place| match place {
        Place::Queue(_, array) if array.is_per_ray() => Some((place, array.name())),
        Place::Method(_, method, array) => {
            let has_no_keys =
                [AUTO, CONTROL, SHUFFLED].contains(&method.as_str()) && *array == MethodArray::Permutation;
            check.require(has_no_keys || subject.methods.contains_key(method.as_str()), || {
                format!("{place}: there is no record of this method")
            });
            Some((place, array.name()))
        }
        _ => None,
    });
    let lengths: Vec<_> = per_ray
        .filter_map(|(place, name)| Some((place, name, *subject.dump.record(place)?.shape.first()?)))
        .collect();
    for (place, name, found) in lengths {
        let (expected, of) = *rays.get_or_insert((found, name));
        check.require(found == expected, || format!("{place} has {found} entries, {of} has {expected}"));
    }
}

/// Checks the entries of an array by what is wrong with one of them, if the array was kept.
fn check_entries<T: Element>(
    subject: &Subject<'_>,
    queue: QueueId,
    array: QueueArray,
    fault: impl Fn(&QueueRules, &[T], usize) -> Option<String> + Sync,
    check: &mut Check,
) {
    let Some(entries) = subject.queue_array::<T>(queue, array) else {
        if array == QueueArray::Rays {
            let absence = subject.queue_absence(queue, array);
            check.not_checked.push(format!("{queue}: rays were {absence}"));
        }
        return;
    };
    let rules = QueueRules::new(queue, &subject.dump.manifest().header);
    let fault = |at| fault(&rules, &entries, at);
    let describe = |at| format!("{queue}/{}.npy: {}", array.name(), fault(at).unwrap_or_default());
    check.each(entries.len(), |at| fault(at).is_none(), describe);
}
