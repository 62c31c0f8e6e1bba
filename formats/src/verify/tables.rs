//! Length tables: each is the one before it plus the traced lengths of the queue between them.

use rayon::prelude::*;

use super::orders::tolerated;
use super::{Check, Subject};
use crate::key::{Encoder, Facts};
use crate::length_table::{LengthCell, LengthTable};
use crate::manifest::{Place, QueueArray, QueueId};
use crate::ray::Kind;
use crate::reader::DumpState;

/// Rays that a thread adds at a time.
const RAYS_PER_TASK: usize = 8192;

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let mut check = Check::new("length tables");
    let Some(cells) = subject.cell_encoder() else {
        check.not_checked.push("the header does not say how rays find their cell".to_owned());
        return check;
    };
    // Closest and shadow rays have a table each.
    for kind in Kind::ALL {
        check_kind(subject, kind, &cells, &mut check);
    }
    check
}

fn check_kind(subject: &Subject<'_>, kind: Kind, cells: &Encoder, check: &mut Check) {
    let mut before: Option<(QueueId, Vec<LengthCell>)> = None;
    let mut is_first = true;
    let may_have_gaps = subject.dump.state() == DumpState::Recovered;
    for &queue in subject.queues.keys().filter(|queue| queue.kind == kind) {
        let place = Place::Queue(queue, QueueArray::Lengths);
        let Some(stored) = subject.array::<LengthCell>(&place) else {
            // Passes that were not kept have no arrays at all, and need no word.
            if !subject.queues[&queue].places.is_empty() {
                let absence = subject.absence(&place);
                check.not_checked.push(format!("{queue}: its length table was {absence}"));
            }
            before = None;
            is_first = false;
            continue;
        };
        check.checked += 1;
        let table = match subject.table(&stored) {
            Ok(table) => table,
            Err(error) => {
                check.problems.add(format!("{place}: {error}"));
                (before, is_first) = (None, false);
                continue;
            }
        };
        if is_first && queue.pass == 0 && (queue.bounce == 0 || !may_have_gaps) && !stored.is_empty() {
            let found = format!("{place}: {} cells are in use before any ray was traced", stored.len());
            tolerated(subject, check).add(found);
        }
        if let Some((earlier, expected)) =
            before.take().filter(|(earlier, _)| follows(*earlier, queue, may_have_gaps))
        {
            compare(subject, &place, &stored, &expected, earlier, check);
        }
        is_first = false;
        before = after(subject, queue, table, cells).map(|cells| (queue, cells));
        match &before {
            Some((_, expected)) => {
                let place = Place::Queue(queue, QueueArray::FinalLengths);
                if let Some(stored) = subject.array::<LengthCell>(&place) {
                    check.checked += 1;
                    compare(subject, &place, &stored, expected, queue, check);
                }
            }
            None => {
                let absence = subject.traced_absence(queue);
                check.not_checked.push(format!("{queue}: its traced lengths were {absence}"));
            }
        }
    }
}

/// Whether no queue of the same kind can lie between these two, of which a recovered recording may have
/// lost some.
fn follows(earlier: QueueId, later: QueueId, may_have_gaps: bool) -> bool {
    if may_have_gaps {
        later.pass == earlier.pass && later.bounce - earlier.bounce == 1
    } else {
        later.pass - earlier.pass <= 1
    }
}

/// The touched cells after a queue's traced lengths were added to the table that it read.
fn after(
    subject: &Subject<'_>,
    queue: QueueId,
    table: LengthTable,
    cells: &Encoder,
) -> Option<Vec<LengthCell>> {
    let traced = subject.traced_in(subject.table_maker(), queue)?;
    traced.rays().par_iter().enumerate().with_min_len(RAYS_PER_TASK).for_each(|(index, ray)| {
        table.add(cells.encode(ray, Facts::default()) as u32, traced.length(index));
    });
    Some(table.touched())
}

fn compare(
    subject: &Subject<'_>,
    place: &Place,
    found: &[LengthCell],
    expected: &[LengthCell],
    added: QueueId,
    check: &mut Check,
) {
    if found == expected {
        return;
    }
    let pairs = found.iter().zip(expected).enumerate();
    let first = pairs.clone().find(|(_, (found, expected))| found != expected);
    let problem = match first {
        Some((at, (found, expected))) => format!("entry {at} is {found:?}, expected {expected:?}"),
        None => format!("{} cells, expected {}", found.len(), expected.len()),
    };
    let found = format!("{place}: not the table before plus the lengths of {added}: {problem}");
    tolerated(subject, check).add(found);
}
