//! All orders of some rays by what they gain, the best first.

use std::cmp::Ordering;

use formats::key::method::{REFERENCES, UNSORTED};
use formats::manifest::QueueId;
use formats::metrics::speedup::Verdict;
use formats::ray::Kind;

use super::coherence::{Coherence, LaneUtilisation, of_warp};
use super::summary::RayClass;
use super::timing::SpeedupLine;
use super::{Metric, QueueAnalysis, RecordingAnalysis, Versus};

/// One of the orders. Speedups are over unsorted rays, on the whole frame: closest and shadow rays of all bounces.
#[derive(Clone, Debug, PartialEq)]
pub struct RankedOrder {
    /// The method, `unsorted`, or an order that was made and not measured.
    pub method: String,
    /// With all that sorting costs.
    pub net: Metric<SpeedupLine>,
    /// Of the trace alone.
    pub trace: Metric<SpeedupLine>,
    /// The net speedup again, of secondary and of shadow rays; nothing where `auto` left them alone.
    pub by_rays: [GainOn; RayClass::ALL.len()],
    /// Of a queue: mean capsule area over that of unsorted rays; `None` while it is awaited.
    pub area: Option<Metric<f64>>,
    /// Of a queue: how much of a warp of 32 works; a model. `None` while it is awaited.
    pub lanes: Option<Metric<f64>>,
    /// Which rays it orders where those of the queue are not.
    pub elsewhere: Option<Elsewhere>,
}

/// What an order gains net on some of the rays.
#[derive(Clone, Debug, PartialEq)]
pub struct GainOn {
    /// Over all their bounces.
    pub all: Metric<SpeedupLine>,
    /// On each of the queues.
    pub by_bounce: Vec<(QueueId, Metric<SpeedupLine>)>,
}

/// Rays that an order has where a queue is not ordered by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elsewhere {
    /// Of the same kind.
    OtherBounces,
    /// Of the other kind, which is this one.
    OtherKind(Kind),
}

/// Of `auto`.
const ALONE: &str = "it left these rays alone";

/// The best is first.
pub fn rank(orders: &mut [RankedOrder]) {
    orders.sort_by(RankedOrder::by_gain);
}

/// Of `methods`, the one that is best on the whole frame, by what each gains over unsorted rays: that which gains most
/// net, one that surely pays before one that may do so by chance, as the sentence that ends `inspector info` has it; or
/// else most in tracing. `None` if none was timed.
pub fn best<'a>(over_unsorted: &[(String, Versus)], methods: &[&'a String]) -> Option<&'a str> {
    let of = |pick: fn(&Versus) -> &Metric<SpeedupLine>| {
        let line = |method: &str| {
            let (_, versus) = over_unsorted.iter().find(|(name, _)| name == method)?;
            pick(versus).known()
        };
        // What the control gains is the instrument's error.
        let methods = methods.iter().copied().filter(|method| !REFERENCES.contains(&method.as_str()));
        let lines = methods.filter_map(|method| Some((method, line(method)?)));
        let pays = |line: &SpeedupLine| line.verdict == Verdict::Faster;
        let best = lines.max_by(|(_, a), (_, b)| pays(a).cmp(&pays(b)).then(a.ratio.total_cmp(&b.ratio)));
        best.map(|(method, _)| method.as_str())
    };
    of(|versus| &versus.net).or_else(|| of(|versus| &versus.trace))
}

impl RankedOrder {
    /// What was measured of a method; nothing, for this reason, where it was not.
    pub fn timed(
        times: Option<&RecordingAnalysis>,
        frame: Option<&Versus>,
        method: String,
        reason: &str,
    ) -> Self {
        let line = |of: Option<&Metric<SpeedupLine>>| of.cloned().unwrap_or_else(|| Metric::missing(reason));
        let on = |rays: RayClass| {
            let all = times.and_then(|recording| recording.frame(rays, &method));
            let queues = times.into_iter().flat_map(|recording| recording.measured_of(rays));
            let net = |queue: &QueueAnalysis| match queue.order(&method) {
                Some(order) if order.is_left_alone() => Metric::missing(ALONE),
                Some(order) => order.net_speedup.clone(),
                None => Metric::missing("it was not measured on these rays"),
            };
            GainOn {
                all: match all {
                    Some(frame) if frame.left_alone => Metric::missing(ALONE),
                    _ => line(all.map(|frame| &frame.net_speedup)),
                },
                by_bounce: queues.map(|queue| (queue.id(), net(queue))).collect(),
            }
        };
        Self {
            net: line(frame.map(|frame| &frame.net)),
            trace: line(frame.map(|frame| &frame.trace)),
            by_rays: RayClass::ALL.map(on),
            area: None,
            lanes: None,
            elsewhere: None,
            method,
        }
    }

    /// With how coherent it is, beside unsorted rays.
    pub fn with(
        mut self,
        coherence: &Metric<Coherence>,
        lanes: &Metric<Vec<LaneUtilisation>>,
        unsorted: Option<&Metric<Coherence>>,
    ) -> Self {
        // Single rays have capsules without area.
        let unsorted =
            unsorted.and_then(Metric::known).map(|known| known.mean_capsule_area).filter(|area| *area > 0.0);
        self.area = Some(match (coherence, unsorted) {
            (Metric::Known(known), Some(unsorted)) => Metric::Known(known.mean_capsule_area / unsorted),
            (Metric::Known(_), None) => Metric::missing("the capsules of unsorted rays are not known"),
            (Metric::Missing { missing }, _) => Metric::missing(missing),
        });
        self.lanes = Some(match lanes {
            Metric::Known(lanes) => of_warp(lanes).ok_or("no ray did any work").into(),
            Metric::Missing { missing } => Metric::missing(missing),
        });
        self
    }

    /// How much faster it is than unsorted rays, which are as fast as themselves; `None` if that is not known.
    pub fn gain(&self, of: &Metric<SpeedupLine>) -> Option<f64> {
        if self.method == UNSORTED { Some(1.0) } else { of.known().map(|line| line.ratio) }
    }

    /// What surely pays, as [`best`] has it; by net speedup, then by that of the trace, then by area; what is not known
    /// comes last.
    fn by_gain(&self, other: &Self) -> Ordering {
        let largest =
            |of: fn(&Self) -> &Metric<SpeedupLine>| descending(self.gain(of(self)), other.gain(of(other)));
        let area = |order: &Self| order.area.as_ref().and_then(Metric::known).map(|area| -area);
        let pays = |order: &Self| {
            let is_faster = order.net.known().is_some_and(|line| line.verdict == Verdict::Faster);
            is_faster && !REFERENCES.contains(&order.method.as_str())
        };
        pays(other)
            .cmp(&pays(self))
            .then_with(|| largest(|order| &order.net))
            .then_with(|| largest(|order| &order.trace))
            .then_with(|| descending(area(self), area(other)))
    }
}

fn descending(one: Option<f64>, other: Option<f64>) -> Ordering {
    match (one, other) {
        (Some(one), Some(other)) => other.total_cmp(&one),
        _ => other.is_some().cmp(&one.is_some()),
    }
}

#[cfg(test)]
mod tests {
    use formats::key::method::CONTROL;

    use super::*;

    fn order(method: &str, net: Option<f64>, trace: Option<f64>, area: Option<f64>) -> RankedOrder {
        let line = |ratio: Option<f64>| {
            let of = |ratio| SpeedupLine { ratio, interval: None, verdict: Verdict::Unknown, n: 3 };
            ratio.map(of).ok_or("not timed").into()
        };
        RankedOrder {
            method: method.to_owned(),
            net: line(net),
            trace: line(trace),
            by_rays: RayClass::ALL.map(|_| GainOn { all: line(None), by_bounce: Vec::new() }),
            area: area.map(Metric::Known),
            lanes: None,
            elsewhere: None,
        }
    }

    #[test]
    fn the_best_net_is_first_and_what_is_not_known_last() {
        let sure = order("sure", Some(1.1), Some(1.1), None);
        let net = sure.net.clone().map(|line| SpeedupLine { verdict: Verdict::Faster, ..line });
        let mut orders = [
            RankedOrder { net, ..sure },
            order("what-if", None, None, Some(0.2)),
            order("two-point-real", None, None, Some(0.1)),
            order("slow", Some(0.9), Some(2.0), Some(0.1)),
            order("untimed", None, None, None),
            order("trace", None, Some(1.1), None),
            order(UNSORTED, None, None, Some(1.0)),
            order("fast", Some(1.2), Some(1.3), Some(0.9)),
        ];
        rank(&mut orders);
        let names = orders.each_ref().map(|order| order.method.as_str());
        assert_eq!(
            names,
            ["sure", "fast", UNSORTED, "slow", "trace", "two-point-real", "what-if", "untimed"]
        );
    }

    #[test]
    fn the_best_surely_pays_or_gains_most() {
        let all = |error: f64| {
            let frame = |(method, ratio, low): (&str, f64, f64)| {
                let (interval, verdict) = (Some((low, 2.0 * ratio)), Verdict::NoSignificantDifference);
                let verdict = if low > 1.0 { Verdict::Faster } else { verdict };
                let net = Metric::Known(SpeedupLine { ratio, interval, verdict, n: 7 }.beyond(error));
                (method.to_owned(), Versus { trace: net.clone(), net, rays: Vec::new() })
            };
            [(CONTROL, 1.5, 1.4), ("lucky", 1.3, 0.9), ("sure", 1.2, 1.02), ("surer", 1.1, 1.08)].map(frame)
        };
        let methods = all(0.0).map(|(method, _)| method);
        let methods = methods.each_ref();
        assert_eq!(best(&all(0.0), &methods), Some("sure"));
        assert_eq!(best(&all(0.05), &methods), Some("surer"), "what the control misses is no gain");
        assert_eq!(best(&all(0.0), &methods[..2]), Some("lucky"), "the control is no method");
        assert_eq!(best(&all(0.0), &methods[..1]), None);
    }
}
