//! Arrays that belong together, and those that speak for themselves: rays, path indices, lights.

use super::{Check, Subject};
use crate::key::method::UNSORTED;
use crate::manifest::{Place, QueueArray, QueueId};
use crate::ray::{Kind, Ray};
use crate::reader::DumpState;

/// How far the length of a unit vector may be from 1.
const UNIT_TOLERANCE: f64 = 1e-4;

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
    let manifest = subject.dump.manifest();
    let record = manifest.queues.iter().find(|record| record.id == queue);
    let is_complete = subject.dump.state() == DumpState::Complete;
    check.require(record.is_some() || !is_complete, || {
        format!("{queue}: there are arrays, but no record of it")
    });
    let has_record = |name: &str| manifest.methods.iter().any(|method| method.name == name);
    if let Some(record) = record {
        for method in &record.methods {
            let is_known = method == UNSORTED || has_record(method);
            check.require(is_known, || {
                format!("{queue}: there is no record of method {}", method.escape_debug())
            });
        }
    }
    let mut rays = record.map(|record| (record.rays, "its record"));
    let per_ray = subject.queues[&queue].iter().filter_map(|place| match place {
        Place::Queue(_, array) if array.is_per_ray() => Some((place, array.name())),
        Place::Method(_, method, array) => {
            check.require(has_record(method), || format!("{place}: there is no record of this method"));
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
    let problem = |index: usize| ray_problem(&rays[index], queue.kind);
    check.each(
        rays.len(),
        |index| problem(index).is_none(),
        |index| {
            format!("{queue}/rays.npy: ray {index} {}: {:?}", problem(index).unwrap_or_default(), rays[index])
        },
    );
}

/// What is wrong with a ray by itself, if anything.
fn ray_problem(ray: &Ray, kind: Kind) -> Option<&'static str> {
    let squared: f64 = ray.direction.iter().map(|&along| f64::from(along) * f64::from(along)).sum();
    if !ray.origin.iter().all(|along| along.is_finite()) {
        Some("has an origin that is not finite")
    } else if (squared.sqrt() - 1.0).abs().partial_cmp(&UNIT_TOLERANCE) != Some(std::cmp::Ordering::Less) {
        Some("has a direction that is no unit vector")
    } else if !(ray.t_min >= 0.0 && ray.t_min.is_finite()) {
        Some("has a t_min that is negative or not finite")
    } else if kind == Kind::Closest && ray.t_max != f32::INFINITY {
        Some("is a closest ray with a t_max other than infinity")
    } else if ray.t_max.is_nan() || ray.t_max < 0.0 {
        Some("has a t_max that is no distance")
    } else {
        None
    }
}

fn check_path_ids(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let Some(ids) = subject.queue_array::<u32>(queue, QueueArray::PathIds) else { return };
    let options = &subject.dump.manifest().header.options;
    let pixels = u64::from(options.width) * u64::from(options.height);
    let is_right =
        |index: usize| u64::from(ids[index]) < pixels && (index == 0 || ids[index - 1] < ids[index]);
    check.each(ids.len(), is_right, |index| {
        let before = index.checked_sub(1).map_or("nothing".to_owned(), |before| ids[before].to_string());
        format!(
            "{queue}/path_ids.npy: entry {index} is {} after {before}; expected ascending indices below {pixels}",
            ids[index]
        )
    });
}

fn check_lights(subject: &Subject<'_>, queue: QueueId, check: &mut Check) {
    let Some(lights) = subject.queue_array::<u32>(queue, QueueArray::Lights) else { return };
    let count = subject.dump.manifest().header.lights.len();
    let is_right = |index: usize| (lights[index] as usize) < count;
    check.each(lights.len(), is_right, |index| {
        format!("{queue}/lights.npy: ray {index} goes to light {} of {count}", lights[index])
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_of_a_ray_is_found() {
        let good = Ray { origin: [1.0; 3], t_min: 0.0, direction: [0.6, 0.0, -0.8], t_max: f32::INFINITY };
        assert_eq!(ray_problem(&good, Kind::Closest), None);
        assert_eq!(ray_problem(&Ray { t_max: 2.0, ..good }, Kind::Shadow), None);
        for (bad, kind, part) in [
            (Ray { origin: [0.0, f32::NAN, 0.0], ..good }, Kind::Closest, "origin"),
            (Ray { direction: [0.6, 0.0, -0.81], ..good }, Kind::Closest, "unit"),
            (Ray { direction: [f32::NAN; 3], ..good }, Kind::Closest, "unit"),
            (Ray { direction: [0.0; 3], ..good }, Kind::Closest, "unit"),
            (Ray { t_min: -1.0, ..good }, Kind::Closest, "t_min"),
            (Ray { t_min: f32::INFINITY, ..good }, Kind::Closest, "t_min"),
            (Ray { t_max: 2.0, ..good }, Kind::Closest, "t_max"),
            (Ray { t_max: f32::NAN, ..good }, Kind::Shadow, "t_max"),
            (Ray { t_max: -1.0, ..good }, Kind::Shadow, "t_max"),
        ] {
            assert!(ray_problem(&bad, kind).is_some_and(|problem| problem.contains(part)), "{bad:?}");
        }
    }
}
