//! Arrays that belong together, and those that speak for themselves: rays, path indices, lights.

use super::{Check, Queue, Subject};
use crate::manifest::{Place, QueueArray, QueueId};
use crate::queue_check::QueueRules;
use crate::ray::Ray;
use crate::reader::DumpState;

pub(super) fn check(subject: &Subject<'_>) -> Vec<Check> {
    let mut structure = Check::new("queues");
    let mut rays = Check::new("rays");
    let mut path_ids = Check::new("path indices");
    let mut lights = Check::new("lights");
    for &queue in subject.queues.keys() {
        check_structure(subject, queue, &mut structure);
        check_rays(subject, queue, &mut rays);
        check_path_ids(subject, queue, &mut path_ids);
        check_lights(subject, queue, &mut lights);
    }
    vec![structure, rays, path_ids, lights]
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
            check.require(subject.methods.contains_key(method.as_str()), || {
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

fn check_rays(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let Some(rays) = subject.queue_array::<Ray>(queue, QueueArray::Rays) else {
        check.not_checked.push(format!("{queue}: rays were not kept"));
        return;
    };
    let rules = QueueRules::new(queue, &subject.dump.manifest().header);
    check_entries(queue, QueueArray::Rays, rays.len(), |at| rules.ray_fault(&rays, at), check);
}

fn check_path_ids(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let Some(ids) = subject.queue_array::<u32>(queue, QueueArray::PathIds) else { return };
    let rules = QueueRules::new(queue, &subject.dump.manifest().header);
    check_entries(queue, QueueArray::PathIds, ids.len(), |at| rules.path_id_fault(&ids, at), check);
}

fn check_lights(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let Some(lights) = subject.queue_array::<u32>(queue, QueueArray::Lights) else { return };
    let rules = QueueRules::new(queue, &subject.dump.manifest().header);
    check_entries(queue, QueueArray::Lights, lights.len(), |at| rules.light_fault(&lights, at), check);
}

fn check_entries(
    queue: QueueId,
    array: QueueArray,
    entries: usize,
    fault: impl Fn(usize) -> Option<String> + Sync,
    check: &mut Check,
) {
    let describe = |at| format!("{queue}/{}.npy: {}", array.name(), fault(at).unwrap_or_default());
    check.each(entries, |at| fault(at).is_none(), describe);
}
