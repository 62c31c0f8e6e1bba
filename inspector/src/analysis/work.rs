//! The work of a queue's rays, if it is that of the recording's own trace kernel.

use formats::manifest::{Place, QueueArray, QueueId};
use formats::ray::Work;
use formats::reader::{Dump, Loaded};

/// Maps the work of a queue. A replay takes that of its source only if both ran the same kernel on the
/// same backend, since another kernel visits other nodes.
///
/// # Errors
/// Why there is none.
pub fn work(dump: &Dump, queue: QueueId) -> Result<Loaded<Work>, String> {
    let place = Place::Queue(queue, QueueArray::Work);
    let kernel = |dump: &Dump| {
        let header = &dump.manifest().header;
        (header.options.trace_kernel.clone(), header.backend)
    };
    let other =
        dump.source().filter(|source| dump.record(&place).is_none() && kernel(source) != kernel(dump));
    match other {
        Some(source) => Err(format!(
            "{place} of {} is the work of another kernel; `recorder replay --keep work` records this one's",
            source.root().display()
        )),
        None => dump.array(&place).map_err(|error| error.to_string()),
    }
}
