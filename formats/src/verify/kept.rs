//! What the header says was kept: it is there, and nothing else is.

use std::collections::BTreeSet;

use super::{Check, Subject};
use crate::key::method::{UNSORTED, WITHOUT_LAYOUT};
use crate::manifest::check::{ALL_PASSES, PASSES_MAX};
use crate::manifest::{
    Manifest, MethodArray, Place, QueueArray, QueueId, QueueRecord, SceneArray, Source, TimingRecord,
};
use crate::reader::DumpState;
use crate::text::shown;

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let mut check = Check::new("kept");
    let manifest = subject.dump.manifest();
    if subject.dump.state() != DumpState::Complete {
        check.not_checked.push("what was kept: the recording did not end, or lost something".to_owned());
        return check;
    }
    let keep: BTreeSet<&str> = manifest.header.options.keep.iter().map(String::as_str).collect();
    for place in promised(manifest).filter(|place| keep.contains(place.kept_with())) {
        check.require(subject.dump.has(&place), || {
            format!("there is no {place}, but {} were kept by the header", place.kept_with())
        });
    }
    if manifest.header.source == Source::Traced {
        for array in &manifest.arrays {
            let word = array.place.kept_with();
            check.require(keep.contains(word), || {
                format!("there is {}, but the header does not say that {word} were kept", array.place)
            });
        }
        check_passes(manifest, &mut check);
        check_lengths(manifest, &mut check);
    }
    check_orders(manifest, keep.contains("caches") && is_counted(manifest), &mut check);
    check
}

/// The first version of the format whose scenes have colours.
const COLOURS_SINCE: u32 = 8;

/// Where the arrays are that a recording has if it keeps everything.
fn promised(manifest: &Manifest) -> impl Iterator<Item = Place> + '_ {
    let scene = [
        SceneArray::Positions,
        SceneArray::Triangles,
        SceneArray::Materials,
        SceneArray::NodeBoxes,
        SceneArray::NodeChildren,
        SceneArray::LeafTriangles,
    ];
    let has_colours = manifest.version >= COLOURS_SINCE;
    let scene = scene.into_iter().chain(has_colours.then_some(SceneArray::Colours)).map(Place::Scene);
    let image = (manifest.header.source == Source::Traced).then_some(Place::Image);
    scene.chain(image).chain(manifest.queues.iter().flat_map(|queue| promised_of(manifest, queue)))
}

fn promised_of<'a>(manifest: &'a Manifest, queue: &'a QueueRecord) -> impl Iterator<Item = Place> + 'a {
    let of_queue = QueueArray::ALL.into_iter().filter(|array| match array {
        // Of the last queue of its kind alone.
        QueueArray::FinalLengths => false,
        QueueArray::Work => is_counted(manifest),
        // Recorded rays come without it.
        QueueArray::Throughput => manifest.header.source == Source::Traced && array.applies_to(queue.id.kind),
        _ => array.applies_to(queue.id.kind),
    });
    let unclaimed = manifest.methods.iter().filter(|record| !record.has_layout());
    let unclaimed: BTreeSet<&str> = unclaimed.map(|record| record.name.as_str()).collect();
    let of_methods = queue.methods.iter().filter(|method| *method != UNSORTED).flat_map(move |method| {
        let has_no_key = WITHOUT_LAYOUT.contains(&method.as_str()) || unclaimed.contains(method.as_str());
        let has_key = move |array: &MethodArray| *array != MethodArray::Keys || !has_no_key;
        let arrays = MethodArray::ALL.into_iter().filter(has_key);
        arrays.map(|array| Place::Method(queue.id, method.clone(), array))
    });
    of_queue.map(|array| Place::Queue(queue.id, array)).chain(of_methods)
}

/// Whether nodes and triangles were counted, and caches modelled: a driver's own traversal shows neither.
fn is_counted(manifest: &Manifest) -> bool {
    manifest.header.options.trace_kernel != "ray-query"
}

/// The passes whose queues are there are those that `--keep-passes` names.
fn check_passes(manifest: &Manifest, check: &mut Check) {
    let options = &manifest.header.options;
    // More are a fault of the header.
    for pass in 0..options.passes.min(PASSES_MAX) {
        let is_kept = options.keep_passes == ALL_PASSES || pass + 1 == options.passes;
        let is_there = manifest.queues.iter().any(|queue| queue.id.pass == pass);
        check.require(is_kept == is_there, || {
            let found = if is_there { "queues" } else { "no queue" };
            format!("pass {pass} of {} has {found}, kept: {}", options.passes, options.keep_passes)
        });
    }
}

/// All methods of a recording assume the header's length; those of a replay may be variants.
fn check_lengths(manifest: &Manifest, check: &mut Check) {
    let expected = manifest.header.options.two_point_length;
    for method in &manifest.methods {
        let found = method.two_point_length;
        check.require(found == expected, || {
            let name = shown(&method.name);
            format!("method {name} assumes a length of {found}, the header says {expected}")
        });
    }
}

/// An order that was measured has its times, and modelled caches if those were kept.
fn check_orders(manifest: &Manifest, keeps_caches: bool, check: &mut Check) {
    let times = manifest.timings.iter().filter_map(|timing| {
        let &TimingRecord { pass, bounce, kind, ref method, .. } = timing;
        Some((QueueId { pass, bounce, kind: kind? }, method.as_str()))
    });
    let caches = manifest.caches.iter().map(|cache| (cache.queue, cache.method.as_str()));
    let (times, caches): (BTreeSet<_>, BTreeSet<_>) = (times.collect(), caches.collect());
    for QueueRecord { id, methods, .. } in &manifest.queues {
        for method in methods {
            let (order, name) = ((*id, method.as_str()), || shown(method));
            check.require(times.contains(&order), || format!("there are no times of {} in {id}", name()));
            let is_modelled = !keeps_caches || caches.contains(&order);
            check.require(is_modelled, || format!("there are no caches of {} in {id}", name()));
        }
    }
}
