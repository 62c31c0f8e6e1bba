//! Every array's file: plain, as long as recorded, with its header and checksum, and no other files.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::{Check, Subject};
use crate::reader::DumpState;
use crate::recover::{damage, strays};

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let dump = subject.dump;
    let arrays = &dump.manifest().arrays;
    let mut check = Check::new("files");
    check.checked = arrays.len() as u64;
    let damages: Vec<_> = arrays.par_iter().filter_map(|array| damage(dump.root(), array)).collect();
    damages.into_iter().for_each(|damage| check.problems.add(damage));
    if dump.state() == DumpState::Partial {
        check.not_checked.push("files that no record names: the recording is not finished".to_owned());
        return check;
    }
    let known: BTreeSet<String> = arrays.iter().map(|array| array.place.to_string()).collect();
    match strays(dump.root(), &known) {
        Ok(strays) => {
            for stray in strays {
                check.problems.add(format!("{}: no record names this file", stray.display()));
            }
        }
        Err(error) => check.problems.add(format!("{}: {error}", dump.root().display())),
    }
    check
}
