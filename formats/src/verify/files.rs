//! Every array's file: plain, as long as recorded, with its header and checksum, and no other files.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{Check, Subject};
use crate::manifest::{ArrayRecord, Place};
use crate::reader::{Dump, DumpState};
use crate::recover::{damage, strays};
use crate::text::shown;

/// Notes what is wrong with the files of arrays, before any of them is read for what it means: of a replay,
/// also with those that it reads of its source.
pub(super) fn find_damage(subject: &Subject<'_>) {
    let dump = subject.dump;
    let damages_of = |dump: &Dump, arrays: Vec<&ArrayRecord>, prefix: &str| -> Vec<_> {
        let found = arrays.into_par_iter().filter_map(|array| {
            Some((array.place.clone(), format!("{prefix}{}", damage(dump.root(), array)?)))
        });
        found.collect()
    };
    let mut damages = damages_of(dump, dump.manifest().arrays.iter().collect(), "");
    if let Some(source) = dump.source() {
        let is_read = |array: &&ArrayRecord| {
            dump.record(&array.place).is_none() && !matches!(array.place, Place::Method(..))
        };
        let arrays = source.manifest().arrays.iter().filter(is_read).collect();
        damages.extend(damages_of(source, arrays, "its source: "));
    }
    damages.into_iter().for_each(|(place, damage)| subject.note_fault(&place, damage));
}

/// After all other checks, since a file may be damaged while they are made.
pub(super) fn check(subject: Subject<'_>) -> Check {
    let dump = subject.dump;
    let arrays = &dump.manifest().arrays;
    let mut check = Check::new("files");
    check.checked = arrays.len() as u64;
    subject.faults.into_inner().into_values().for_each(|fault| check.problems.add(fault));
    if dump.state() == DumpState::Partial {
        check.not_checked.push("files that no record names: the recording is not finished".to_owned());
        return check;
    }
    let known: BTreeSet<String> = arrays.iter().map(|array| array.place.to_string()).collect();
    match strays(dump.root(), &known) {
        Ok(strays) => {
            for stray in strays {
                let stray = shown(&stray.to_string_lossy());
                check.problems.add(format!("{stray}: no record names this file"));
            }
        }
        Err(error) => check.problems.add(format!("{}: {error}", dump.root().display())),
    }
    check
}
