//! Which style a method has: the same in all figures of some recordings and in the window that shows them.

use formats::key::method::{AUTO, BUILTIN, CONTROL, IN_ALL, SHUFFLED, UNSORTED};

use crate::analysis::RecordingAnalysis;
use crate::analysis::summary::distinct;

/// The number of a method's style: its place among `unsorted`, the built-in ones of `all`, the other orders without a
/// layout, and those that were measured besides; after all of them for one that was not.
pub fn method_style<'a>(
    recordings: impl Iterator<Item = &'a RecordingAnalysis> + Clone,
    method: &str,
) -> usize {
    let of_all = BUILTIN[..IN_ALL].iter().map(|(name, ..)| *name);
    let known: Vec<&str> = [UNSORTED].into_iter().chain(of_all).chain([CONTROL, AUTO, SHUFFLED]).collect();
    if let Some(place) = known.iter().position(|name| *name == method) {
        return place;
    }
    let measured = measured_methods(recordings).into_iter().map(|(name, _)| name);
    let names = distinct(known.into_iter().chain(measured));
    names.iter().position(|name| *name == method).unwrap_or(names.len())
}

/// Every method that was measured, each once, with whether it is a variant of another in all its orders:
/// `unsorted`, the built-in ones in their order, users', variants.
pub(super) fn measured_methods<'a>(
    recordings: impl Iterator<Item = &'a RecordingAnalysis> + Clone,
) -> Vec<(&'a str, bool)> {
    let orders = || recordings.clone().flat_map(RecordingAnalysis::measured).flat_map(|queue| &queue.orders);
    let is_variant = |method: &str| {
        orders().filter(|order| order.method == method).all(|order| order.base != order.method)
    };
    let names = distinct(orders().map(|order| order.method.as_str()));
    let mut methods: Vec<(&str, bool)> = names.into_iter().map(|name| (name, is_variant(name))).collect();
    methods.sort_by_key(|&(method, is_variant)| {
        let builtin = BUILTIN.iter().position(|(name, ..)| *name == method);
        (method != UNSORTED, builtin.unwrap_or(BUILTIN.len()), is_variant)
    });
    methods
}
