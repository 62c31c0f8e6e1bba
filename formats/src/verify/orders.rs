//! Keys recomputed from the stored rays, and permutations: bijective, ascending in the keys, stable.

use rayon::prelude::*;

use super::report::findings;
use super::scene::method_problem;
use super::{Check, Findings, Queue, Subject};
use crate::auto;
use crate::key::method::{AUTO, CONTROL, SHUFFLED};
use crate::key::{Coordinate, Encoder, Facts, LayoutText, NO_FACTS, Termination};
use crate::length_table::LengthTable;
use crate::manifest::{MethodArray, MethodRecord, Place, QueueArray, QueueId};
use crate::metrics::order::Keys;
use crate::npy::Dtype;
use crate::permutation::{check_bijection, check_order};
use crate::ray::Ray;
use crate::reader::Loaded;
use crate::traced::Traced;

/// Rays whose keys a task makes.
const RAYS_PER_TASK: usize = 1 << 12;

pub(super) fn check(subject: &Subject<'_>) -> [Check; 2] {
    let mut keys_check = Check::new("keys");
    let mut permutations_check = Check::new("permutations");
    for (&queue, Queue { places, .. }) in &subject.queues {
        let has_orders = places.iter().any(|place| matches!(place, Place::Method(..)));
        // Once for all methods.
        let rays = has_orders.then(|| subject.queue_array::<Ray>(queue, QueueArray::Rays)).flatten();
        for place in places {
            match place {
                Place::Method(_, method, MethodArray::Keys) => {
                    check_keys(subject, queue, method, rays.as_deref(), &mut keys_check);
                }
                Place::Method(_, method, MethodArray::Permutation) => {
                    check_permutation(subject, queue, method, rays.as_deref(), &mut permutations_check);
                }
                _ => {}
            }
        }
    }
    [keys_check, permutations_check]
}

/// The keys of a method as they are stored.
fn stored_keys(subject: &Subject<'_>, place: &Place) -> Option<Keys> {
    match subject.dump.record(place)?.dtype {
        Dtype::U8 => subject.array(place).map(Keys::Wide),
        _ => subject.array(place).map(Keys::Narrow),
    }
}

fn check_permutation(
    subject: &Subject<'_>,
    queue: QueueId,
    method: &str,
    rays: Option<&[Ray]>,
    check: &mut Check,
) {
    let place = Place::Method(queue, method.to_owned(), MethodArray::Permutation);
    let Some(permutation) = subject.array::<u32>(&place) else { return };
    check.checked += permutation.len() as u64;
    let checked = check_bijection(&permutation, permutation.len()).and_then(|()| {
        match stored_keys(subject, &Place::Method(queue, method.to_owned(), MethodArray::Keys)) {
            // `queues` finds that their lengths differ.
            Some(keys) if keys.len() != permutation.len() => Ok(()),
            Some(keys) => check_order(&permutation, |ray| keys.at(ray)),
            None if method == CONTROL => check_order(&permutation, |_| 0),
            None if method == AUTO => match chosen_keys(subject, queue, rays) {
                Ok(None) => check_order(&permutation, |_| 0),
                Ok(Some(keys)) if keys.rays.len() != permutation.len() => Ok(()),
                Ok(Some(keys)) => {
                    let keys = keys.all();
                    check_order(&permutation, |ray| keys[ray])
                }
                Err(reason) => {
                    check.not_checked.push(format!("{place}: {reason}"));
                    Ok(())
                }
            },
            None => {
                let keys = Place::Method(queue, method.to_owned(), MethodArray::Keys);
                let reason = || format!("{place}: its keys were {}", subject.absence(&keys));
                let has_keys = subject.methods.get(method).is_none_or(|record| record.has_layout());
                check.not_checked.extend((method != SHUFFLED && has_keys).then(reason));
                Ok(())
            }
        }
    });
    if let Err(error) = checked {
        check.problems.add(format!("{place}: {error}"));
    }
}

/// The keys that `auto` sorted a queue by, none if it left the queue alone; the error says what is not there.
fn chosen_keys<'a>(
    subject: &Subject<'_>,
    queue: QueueId,
    rays: Option<&'a [Ray]>,
) -> Result<Option<Recomputed<'a>>, String> {
    let manifest = subject.dump.manifest();
    let decision = manifest.decisions.iter().find(|decision| decision.queue == queue);
    let Some(choice) = &decision.ok_or("there is no record of what was chosen")?.choice else {
        return Ok(None);
    };
    let method = auto::method_record(choice, &manifest.header)?;
    Recomputed::new(subject, queue, &method, rays).map(Some)
}

fn check_keys(subject: &Subject<'_>, queue: QueueId, name: &str, rays: Option<&[Ray]>, check: &mut Check) {
    let place = Place::Method(queue, name.to_owned(), MethodArray::Keys);
    let Some(keys) = stored_keys(subject, &place) else { return };
    // That the method has no record, or a wrong one, was found before.
    let Some(method) = subject.methods.get(name) else { return };
    if method_problem(method, subject.dump.manifest().header.extent()).is_some() {
        return;
    }
    let is_wide = matches!(keys, Keys::Wide(_));
    check.require(is_wide == (method.key_bits > 32), || {
        format!(
            "{place}: keys of {} bits are stored in {} bits",
            method.key_bits,
            if is_wide { 64 } else { 32 }
        )
    });
    if !method.has_layout() {
        return check.not_checked.push(format!("{place}: nobody says what these keys are"));
    }
    let recomputed = match Recomputed::new(subject, queue, method, rays) {
        Ok(recomputed) => recomputed,
        Err(reason) => return check.not_checked.push(format!("{place}: {reason}")),
    };
    if recomputed.rays.len() != keys.len() {
        return;
    }
    check.checked += keys.len() as u64;
    let all = recomputed.all();
    let found = findings(
        keys.len(),
        |ray| recomputed.has_light(ray) && all[ray] == keys.at(ray),
        |ray| {
            let expected = if recomputed.has_light(ray) {
                format!("{:#x}", all[ray])
            } else {
                "none, as its light does not exist".to_owned()
            };
            format!("{place}: ray {ray} has key {:#x}, expected {expected}", keys.at(ray))
        },
    );
    tolerated(subject, check).merge(found);
}

/// Where numbers belong that differ: on an adapter with other than IEEE arithmetic they may.
pub(super) fn tolerated<'a>(subject: &Subject<'_>, check: &'a mut Check) -> &'a mut Findings {
    if subject.is_exact() { &mut check.problems } else { &mut check.differences }
}

/// Makes the keys of a queue again.
struct Recomputed<'a> {
    encoder: Encoder,
    rays: &'a [Ray],
    lights: Option<Loaded<u32>>,
    light_count: u32,
    path_ids: Option<Loaded<u32>>,
    length: Length,
}

/// Where the length estimate of a ray comes from.
enum Length {
    Fixed(f32),
    Adaptive { cells: Encoder, table: LengthTable },
    Real(Traced),
}

impl<'a> Recomputed<'a> {
    /// The error says what is not there.
    fn new(
        subject: &Subject<'_>,
        queue: QueueId,
        method: &MethodRecord,
        rays: Option<&'a [Ray]>,
    ) -> Result<Self, String> {
        let header = &subject.dump.manifest().header;
        let absent = |what: &str, array| format!("the {what} {}", subject.queue_absence(queue, array));
        let rays = rays.ok_or_else(|| absent("rays were", QueueArray::Rays))?;
        let parsed = LayoutText::parse(&method.text).and_then(|text| text.expand(header.extent()));
        let layout = parsed.map_err(|error| error.message)?;
        let if_used = |needs: fn(Coordinate) -> bool, what: &str, array| -> Result<Option<_>, String> {
            let load = || subject.queue_array(queue, array).filter(|found| found.len() == rays.len());
            layout.uses(needs).then(|| load().ok_or_else(|| absent(what, array))).transpose()
        };
        let lights = if_used(Coordinate::needs_light, "lights were", QueueArray::Lights)?;
        let path_ids = if_used(Coordinate::needs_path, "path ids were", QueueArray::PathIds)?;
        let length = match method.termination {
            Termination::Unused => Length::Fixed(0.0),
            Termination::Fixed => Length::Fixed(method.two_point_length),
            Termination::Adaptive => {
                let stored = subject.queue_array(queue, QueueArray::Lengths);
                let stored = stored.ok_or_else(|| absent("length table was", QueueArray::Lengths))?;
                let cells = subject.cell_encoder().ok_or("the length table has no usable layout")?;
                let table = subject.table(&stored).map_err(|_| "the length table is damaged")?;
                Length::Adaptive { cells, table }
            }
            Termination::Real => {
                let absent = || format!("the traced lengths were {}", subject.traced_absence(queue));
                Length::Real(subject.traced(queue).ok_or_else(absent)?)
            }
        };
        let encoder = Encoder::new(&layout, method.key_bits, subject.unit, &header.lights);
        let light_count = header.lights.len() as u32;
        Ok(Self { encoder, rays, lights, light_count, path_ids, length })
    }

    /// Whether the light that a ray goes to exists, where keys are made from it.
    fn has_light(&self, ray: usize) -> bool {
        self.lights.as_ref().is_none_or(|lights| lights[ray] < self.light_count)
    }

    /// The keys of all rays; of those without a light any key.
    fn all(&self) -> Vec<u64> {
        let mut keys = vec![0; self.rays.len()];
        if self.lights.is_some() && self.light_count == 0 {
            return keys;
        }
        let last = self.light_count.saturating_sub(1);
        let parts = keys.par_chunks_mut(RAYS_PER_TASK).zip(self.rays.par_chunks(RAYS_PER_TASK));
        parts.enumerate().for_each(|(task, (keys, rays))| {
            let first = task * RAYS_PER_TASK;
            let light = |at: usize| self.lights.as_ref().map_or(0, |lights| lights[first + at].min(last));
            let path = |at: usize| self.path_ids.as_ref().map_or(0, |ids| ids[first + at]);
            let mut cell_of = Vec::new();
            if let Length::Adaptive { cells, .. } = &self.length {
                cell_of.resize(rays.len(), 0);
                cells.encode_all(rays, &NO_FACTS, &mut cell_of);
            }
            let length = |at: usize| match &self.length {
                Length::Fixed(length) => *length,
                Length::Adaptive { table, .. } => table.mean(cell_of[at]),
                Length::Real(traced) => traced.length(first + at),
            };
            self.encoder.encode_all(rays, &Facts { length, light, path }, keys);
        });
        keys
    }
}
