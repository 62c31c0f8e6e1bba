//! All orders of the selected queue by what they gain, as far as it is known.

use formats::key::method::{AUTO, UNSORTED};
use formats::ray::Kind;

use super::absent::Absent;
use super::coherences::OrderCoherence;
use super::context::Context;
use super::what_if::WHAT_IF;
use crate::analysis::Metric;
use crate::analysis::ranking::{Elsewhere, RankedOrder, rank};

impl Context {
    /// How coherent each order of the queue is, that of *What if* too, as far as it is known; and how many there are.
    /// More is found in later frames.
    ///
    /// # Errors
    /// Why nothing can be known.
    pub fn all_coherences(&mut self, frame: u64) -> Result<(Vec<OrderCoherence>, usize), Absent> {
        let (known, all) = self.coherences(frame)?;
        let mut known = known.to_vec();
        if !self.methods().iter().any(|method| method == WHAT_IF) {
            return Ok((known, all));
        }
        known.extend(match self.what_if_coherence() {
            Ok(found) => Some(found.clone()),
            Err(Absent::Impossible(why)) => Some(OrderCoherence::missing(WHAT_IF, &why)),
            Err(Absent::Awaited) => None,
        });
        Ok((known, all + 1))
    }

    /// All orders of the recording, the one that gains most first, also those that order other rays alone. How coherent
    /// they are is found in later frames.
    pub fn ranking(&mut self, frame: u64) -> Vec<RankedOrder> {
        let methods = self.methods();
        let coherences = self.all_coherences(frame).map(|(known, _)| known);
        let unknown = coherences.as_ref().err().cloned();
        let known = coherences.unwrap_or_default();
        let Some(recording) = self.recording() else { return Vec::new() };
        let times = recording.times.as_ref();
        let of = |name: &str| known.iter().find(|order| order.method == name);
        let unsorted = of(UNSORTED).map(|order| &order.coherence);
        let ranked = |method: String| {
            let reason = match (times, &*method) {
                (_, WHAT_IF) => "it was made here, not measured; `recorder replay` measures it",
                (None, _) => "the recording is not finished",
                (_, AUTO) => "it left all secondary and shadow rays alone",
                _ => "it was not measured on secondary or shadow rays",
            };
            let found = of(&method);
            let frame = recording.over_unsorted(&method);
            let order = RankedOrder::timed(times, frame, method, reason);
            match (found, &unknown) {
                (Some(found), _) => order.with(&found.coherence, &found.lanes, unsorted),
                (None, Some(Absent::Impossible(why))) => {
                    order.with(&Metric::missing(why), &Metric::missing(why), unsorted)
                }
                (None, _) => order,
            }
        };
        let elsewhere = |(method, kind): (String, Kind)| {
            let frame = recording.over_unsorted(&method);
            let (elsewhere, why) = match kind {
                kind if kind == self.selection.queue.kind => {
                    (Elsewhere::OtherBounces, "it does not order these rays")
                }
                Kind::Closest => (Elsewhere::OtherKind(kind), "it orders closest rays alone"),
                Kind::Shadow => (Elsewhere::OtherKind(kind), "it orders shadow rays alone"),
            };
            let order = RankedOrder::timed(times, frame, method, why);
            let order = order.with(&Metric::missing(why), &Metric::missing(why), None);
            RankedOrder { elsewhere: Some(elsewhere), ..order }
        };
        // Of a pass that was not measured there is no table.
        let others =
            if methods.is_empty() { Vec::new() } else { recording.methods_elsewhere(self.selection.queue) };
        let mut ranking: Vec<RankedOrder> =
            methods.into_iter().map(ranked).chain(others.into_iter().map(elsewhere)).collect();
        rank(&mut ranking);
        ranking
    }
}
