//! What the kernel counted of each ray, and what it found, by the ray's way through the hierarchy.

use super::{Check, Subject};
use crate::hierarchy::{Hierarchy, HierarchyError};
use crate::manifest::{Place, QueueArray, SceneArray};
use crate::ray::Work;
use crate::reader::ReadError;
use crate::traced::Results;

/// The kernel whose hierarchy is kept.
const KERNEL: &str = "wide";

/// No check where no hierarchy was kept.
pub(super) fn check(subject: &Subject<'_>) -> Option<Check> {
    if !subject.dump.has(&Place::Scene(SceneArray::NodeBoxes)) {
        return None;
    }
    let mut check = Check::new("work");
    let hierarchy = match Hierarchy::open(subject.dump) {
        Ok(hierarchy) => {
            check.require(true, String::new);
            hierarchy
        }
        Err(HierarchyError::Read(error @ ReadError::NoSuchArray { .. })) => {
            check.not_checked.push(format!("ways through the hierarchy: {error}"));
            return Some(check);
        }
        Err(error) => {
            check.require(false, || error.to_string());
            return Some(check);
        }
    };
    let kernel = &subject.dump.manifest().header.options.trace_kernel;
    if kernel != KERNEL {
        check
            .not_checked
            .push(format!("{kernel} counted it, and the hierarchy that was kept is that of {KERNEL}"));
        return Some(check);
    }
    for &queue in subject.queues.keys() {
        let Some(traced) = subject.traced(queue) else { continue };
        let rays = traced.rays();
        let work = subject.queue_array::<Work>(queue, QueueArray::Work);
        // `queues` finds arrays that do not belong together.
        let Some(work) = work.filter(|work| work.len() == rays.len()) else { continue };
        let traversal = |index: usize| hierarchy.traversal(&rays[index], queue.kind);
        let is_right = |index: usize| {
            let traversal = traversal(index);
            let is_found = match traced.results() {
                Results::Hits(hits) => hits[index] == traversal.hit,
                Results::Distances(distances) => distances[index] == traversal.hit.t,
            };
            is_found && work[index] == traversal.work()
        };
        check.each(rays.len(), is_right, |index| {
            let (found, traversal) = (work[index], traversal(index));
            format!(
                "{queue}/work.npy: ray {index} has {} nodes and {} triangles, its way through the hierarchy {} and {}, \
                 where it meets {:?}",
                found.nodes,
                found.triangles,
                traversal.work().nodes,
                traversal.work().triangles,
                traversal.hit
            )
        });
    }
    Some(check)
}
