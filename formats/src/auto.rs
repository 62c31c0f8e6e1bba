//! The method `auto`: which order a queue gets.
//!
//! A calibration says what each candidate was worth on queues of known length and coherence. A queue gets the
//! best one of the calibrated queue that it is most like, of several that are level the one with the shortest keys,
//! or none if no interval lay clearly above 1. Everything is a function of the rays and the calibration, so that a
//! recording with its calibration can be repeated.

use std::ops::Range;

use rayon::prelude::*;

use crate::key::termination::bounded_length;
use crate::key::{KEY_BITS_MIN, LAYOUT_BITS, Method};
use crate::manifest::{CalibrationRecord, Candidate, Choice, Header, MethodRecord};
use crate::metrics::GROUP_RAYS;
use crate::metrics::capsule::{Capsule, Segment};
use crate::ray::{Kind, Ray};
use crate::unit_space::UnitSpace;

/// Groups that are looked at: enough that their mean settles within a tenth, few enough to cost nothing.
const GROUPS: usize = 32;

/// Groups that are worth a thread's while.
const FEWEST_GROUPS: usize = 4;

/// How long a ray is thought to be, in unit lengths, before it is traced: as `two-point` does.
const LENGTH: f32 = 0.25;

/// What a version of the format chooses by.
#[derive(Clone, Copy, Debug)]
struct Rule {
    /// How far net speedups drift between a calibration and its use, which no interval over a few rounds shows: it is
    /// the times of sorting and moving rays that do, with what else goes through the memory. By kind: the longer times
    /// of closest rays drift less. What an interval does not have beyond 1 is left alone.
    drift: [f64; 2],
    /// Orders whose net speedups are as near the best one's are level, and the shortest keys are taken: what drifts
    /// may be all that others have before them.
    level: Option<f64>,
    /// Whether a queue nearly as similar as the most similar is taken where it is of the same bounce.
    prefers_the_bounce: bool,
    /// Whether a queue is known by its bounce and number of rays, where it can: on a graphics card a look at rays waits
    /// for all that was submitted before, and took a fifth of what the rays took.
    knows_the_bounce: bool,
    /// Whether queues are left alone that are shorter than all that orders were measured on.
    leaves_short_alone: bool,
}

impl Rule {
    /// That of a version of the format.
    fn of(version: u32) -> Self {
        let at_first = Self {
            drift: [0.0, 0.0],
            level: None,
            prefers_the_bounce: false,
            knows_the_bounce: false,
            leaves_short_alone: false,
        };
        let of_9 = Self { drift: [0.03, 0.03], prefers_the_bounce: true, ..at_first };
        let of_10 = Self { level: Some(0.03), ..of_9 };
        let of_11 = Self { drift: [0.015, 0.03], level: Some(0.015), ..of_10 };
        let of_12 = Self { knows_the_bounce: true, ..of_11 };
        let of_13 = Self { leaves_short_alone: true, ..of_12 };
        match version {
            ..9 => at_first,
            9 => of_9,
            10 => of_10,
            11 => of_11,
            12 => of_12,
            13.. => of_13,
        }
    }
}

/// Two calibrated queues whose likeness to another differs by less, in natural logarithms, are equally alike:
/// areas of samples scatter by a tenth and more.
const BY_CHANCE: f64 = 0.25;

/// Where the sample of a queue lies: whole groups, evenly over its canonical order.
pub fn sample(rays: usize) -> impl Iterator<Item = Range<usize>> {
    let groups = (rays / GROUP_RAYS).min(GROUPS);
    (0..groups).map(move |group| {
        let first = group * (rays / GROUP_RAYS) / groups * GROUP_RAYS;
        first..first + GROUP_RAYS
    })
}

/// Mean capsule area of the sampled rays, group after group, each ray as long as it is thought to be before it is
/// traced; unit space. 0 for no rays.
pub fn sampled_area(unit: &UnitSpace, rays: &[Ray]) -> f64 {
    let segment = |ray: &Ray| {
        let length = bounded_length(unit, ray, unit.point(ray.origin), LENGTH);
        Segment::of(unit, ray, length)
    };
    let area = |group: &[Ray]| {
        let mut segments = [Segment::default(); GROUP_RAYS];
        segments.iter_mut().zip(group).for_each(|(kept, ray)| *kept = segment(ray));
        Capsule::around(&segments).map_or(0.0, |capsule| capsule.area())
    };
    // In parallel, summed in order.
    let areas: Vec<f64> = rays.par_chunks_exact(GROUP_RAYS).with_min_len(FEWEST_GROUPS).map(area).collect();
    areas.iter().sum::<f64>() / areas.len().max(1) as f64
}

/// A calibration, and the version of the format whose rule chooses by it.
#[derive(Clone, Copy, Debug)]
pub struct Calibrated<'a> {
    /// What was measured.
    pub queues: &'a [CalibrationRecord],
    /// Version of the format.
    pub version: u32,
}

impl<'a> Calibrated<'a> {
    /// Fewest rays that get an order: about as many as the shortest queue that any was measured on; [`u64::MAX`] if none
    /// was.
    pub fn fewest_rays(&self) -> u64 {
        let measured = self.queues.iter().filter(|queue| !queue.candidates.is_empty());
        match measured.map(|queue| queue.rays).min() {
            _ if !self.rule().leaves_short_alone => 0,
            Some(shortest) => (shortest as f64 * (-BY_CHANCE).exp()).ceil() as u64,
            None => u64::MAX,
        }
    }

    /// Whether a sample has anything to say: not of a short queue, nor of one of a calibrated bounce with about as many
    /// rays, nor where no order of any queue of this kind was surely worth its cost.
    pub fn is_worth_a_look(&self, bounce: u32, kind: Kind, rays: u64) -> bool {
        let mut candidates = self.of(kind).flat_map(|queue| &queue.candidates);
        rays >= self.fewest_rays()
            && self.known(bounce, kind, rays).is_none()
            && candidates.any(|candidate| self.is_sure(kind, candidate))
    }

    /// The order of a queue whose sample has this area; `None` to leave it alone.
    pub fn decide(&self, bounce: u32, kind: Kind, rays: u64, area: f64) -> Option<&'a Candidate> {
        if rays < self.fewest_rays() {
            return None;
        }
        let most_alike = match self.known(bounce, kind, rays) {
            Some(known) => &self.queues[known],
            None => self.most_alike(bounce, kind, rays, area)?,
        };
        let sure = || most_alike.candidates.iter().filter(|candidate| self.is_sure(kind, candidate));
        let fastest = sure().reduce(|best, other| if other.net > best.net { other } else { best })?;
        let Some(level) = self.rule().level else { return Some(fastest) };
        sure().filter(|candidate| candidate.net >= fastest.net - level).reduce(|best, other| {
            let bits = other.choice.key_bits.cmp(&best.choice.key_bits);
            if bits.is_lt() || bits.is_eq() && other.net > best.net { other } else { best }
        })
    }

    /// The calibrated queue that one with such a sample is most like.
    fn most_alike(&self, bounce: u32, kind: Kind, rays: u64, area: f64) -> Option<&'a CalibrationRecord> {
        let unlike =
            |other: &CalibrationRecord| apart(rays as f64, other.rays as f64) + apart(area, other.area);
        let nearest = self.of(kind).min_by(|a, b| unlike(a).total_cmp(&unlike(b)))?;
        let is_as_near = |other: &CalibrationRecord| unlike(other) <= unlike(nearest) + BY_CHANCE;
        let same_bounce = self.of(kind).find(|other| other.bounce == bounce && is_as_near(other));
        Some(if self.rule().prefers_the_bounce { same_bounce.unwrap_or(nearest) } else { nearest })
    }

    /// Number of the calibrated queue of the same bounce, if it has about as many rays: such a queue gets what that one
    /// does, whatever its sample says.
    pub fn known(&self, bounce: u32, kind: Kind, rays: u64) -> Option<usize> {
        let is_it = |other: &CalibrationRecord| {
            (other.bounce, other.kind) == (bounce, kind) && apart(rays as f64, other.rays as f64) <= BY_CHANCE
        };
        self.queues.iter().position(is_it).filter(|_| self.rule().knows_the_bounce)
    }

    fn of(&self, kind: Kind) -> impl Iterator<Item = &'a CalibrationRecord> {
        self.queues.iter().filter(move |queue| queue.kind == kind)
    }

    /// What may as well have cost something is left alone.
    fn is_sure(&self, kind: Kind, candidate: &Candidate) -> bool {
        candidate.net_low > 1.0 + self.rule().drift[kind as usize]
    }

    fn rule(&self) -> Rule {
        Rule::of(self.version)
    }
}

/// How far two quantities are apart, in natural logarithms.
fn apart(a: f64, b: f64) -> f64 {
    (a.max(f64::MIN_POSITIVE) / b.max(f64::MIN_POSITIVE)).ln().abs()
}

/// The method that was chosen, as a recording with this header has it.
///
/// # Errors
/// If it is none that is built in, or its keys have bits that none has.
pub fn method_record(choice: &Choice, header: &Header) -> Result<MethodRecord, String> {
    let Choice { method, key_bits, .. } = choice;
    let built_in = Method::builtin(method).map_err(|error| error.to_string())?;
    if !(KEY_BITS_MIN..=LAYOUT_BITS).contains(key_bits) {
        return Err(format!("{key_bits} bits, expected {KEY_BITS_MIN} to {LAYOUT_BITS}"));
    }
    let layout = built_in.layout.expand(header.extent()).map_err(|error| error.message)?;
    Ok(MethodRecord {
        name: built_in.name.clone(),
        text: built_in.layout.text().to_owned(),
        layout: layout.names(),
        termination: built_in.termination,
        key_bits: *key_bits,
        base: built_in.name,
        two_point_length: header.options.two_point_length,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::{FORMAT_VERSION, Way};

    fn calibrated(kind: Kind, rays: u64, area: f64, nets: &[(&str, f64)]) -> CalibrationRecord {
        let candidate = |&(method, net): &(&str, f64)| Candidate {
            choice: Choice { method: method.to_owned(), key_bits: 16, way: Way::Gathered },
            net,
            net_low: net - 0.04,
        };
        CalibrationRecord { bounce: 1, kind, rays, area, candidates: nets.iter().map(candidate).collect() }
    }

    #[test]
    fn a_queue_gets_what_was_best_for_the_one_it_is_most_like() {
        let calibration = [
            calibrated(Kind::Closest, 500_000, 0.01, &[("aila", 0.97), ("costa", 1.01)]),
            calibrated(Kind::Closest, 300_000, 1.0, &[("aila", 1.10), ("costa", 1.25)]),
            calibrated(Kind::Closest, 1_000, 1.0, &[("aila", 1.08), ("costa", 0.9)]),
            calibrated(Kind::Shadow, 500_000, 0.01, &[("octahedron", 1.4)]),
        ];
        let by = |queues| Calibrated { queues, version: FORMAT_VERSION };
        let chosen = |kind, rays, area| {
            let candidate = by(&calibration).decide(7, kind, rays, area);
            candidate.map(|candidate| candidate.choice.method.as_str())
        };
        assert_eq!(chosen(Kind::Closest, 500_000, 0.02), None, "none is surely worth its cost");
        assert_eq!(chosen(Kind::Closest, 400_000, 0.5), Some("costa"));
        assert_eq!(chosen(Kind::Closest, 2_000, 0.5), Some("aila"));
        assert_eq!(chosen(Kind::Shadow, 1_000, 0.0), Some("octahedron"));
        assert_eq!(by(&[]).decide(1, Kind::Shadow, 500_000, 1.0), None);
        let is_worth_a_look = |queues, bounce, kind, rays| by(queues).is_worth_a_look(bounce, kind, rays);
        assert!(is_worth_a_look(&calibration[..2], 7, Kind::Closest, 500_000));
        assert!(
            !is_worth_a_look(&calibration[..1], 7, Kind::Closest, 500_000),
            "no interval lies above 1.015"
        );
        assert!(!is_worth_a_look(&calibration[..2], 7, Kind::Shadow, 500_000), "none was calibrated");
    }

    #[test]
    fn a_queue_is_known_by_its_bounce_and_about_its_number_of_rays_since_version_12() {
        let mut calibration = [
            calibrated(Kind::Closest, 500_000, 1.0, &[("aila", 1.2)]),
            calibrated(Kind::Closest, 500_000, 9.0, &[("costa", 1.2)]),
        ];
        calibration[1].bounce = 2;
        let by = |version| Calibrated { queues: &calibration, version };
        let chosen = |version, bounce, rays| {
            let candidate = by(version).decide(bounce, Kind::Closest, rays, 0.0);
            candidate.map(|candidate| candidate.choice.method.clone()).unwrap()
        };
        assert_eq!(chosen(12, 2, 400_000), "costa");
        assert_eq!(chosen(11, 2, 400_000), "aila", "an area of 0 is more like 1 than 9");
        assert_eq!(chosen(12, 2, 300_000), "aila", "too few rays to be the same queue");
        assert!(!by(12).is_worth_a_look(2, Kind::Closest, 400_000));
        for (version, bounce, rays) in [(11, 2, 400_000), (12, 2, 300_000), (12, 3, 500_000)] {
            assert!(by(version).is_worth_a_look(bounce, Kind::Closest, rays), "{version}, {bounce}, {rays}");
        }
    }

    #[test]
    fn queues_shorter_than_all_that_were_measured_are_left_alone_since_version_13() {
        let calibration = [
            calibrated(Kind::Closest, 100, 1.0, &[]),
            calibrated(Kind::Closest, 10_000, 1.0, &[("aila", 1.2)]),
            calibrated(Kind::Shadow, 20_000, 1.0, &[("aila", 1.2)]),
        ];
        for (version, rays, is_left) in [(13, 7_788, true), (13, 7_789, false), (12, 7_788, false)] {
            let by = Calibrated { queues: &calibration, version };
            assert_eq!(by.decide(7, Kind::Closest, rays, 1.0).is_none(), is_left, "{version}, {rays} rays");
            assert_eq!(by.is_worth_a_look(7, Kind::Closest, rays), !is_left, "{version}, {rays} rays");
        }
        let nothing = Calibrated { queues: &calibration[..1], version: 13 };
        assert_eq!(nothing.fewest_rays(), u64::MAX);
    }

    /// Samples of two bounces of a room are often as alike as two samples of one bounce.
    #[test]
    fn what_samples_cannot_tell_the_bounce_decides_since_version_9() {
        let mut calibration = [
            calibrated(Kind::Shadow, 430_000, 2.4, &[("aila", 0.95)]),
            calibrated(Kind::Shadow, 400_000, 4.0, &[("aila", 1.2)]),
        ];
        calibration[1].bounce = 2;
        let chosen = |version, bounce, area| {
            Calibrated { queues: &calibration, version }.decide(bounce, Kind::Shadow, 430_000, area).is_some()
        };
        assert!(!chosen(9, 1, 3.3), "the first bounce, whose sample is a little more like the second");
        assert!(chosen(8, 1, 3.3), "so it was before");
        assert!(chosen(9, 2, 3.3));
        assert!(chosen(9, 1, 4.2), "too far apart to be a matter of chance");
    }

    #[test]
    fn a_gain_that_drift_may_take_back_is_left_since_version_9() {
        let calibration = [calibrated(Kind::Shadow, 1, 1.0, &[("aila", 1.06)])];
        let chosen =
            |version| Calibrated { queues: &calibration, version }.decide(1, Kind::Shadow, 1, 1.0).is_some();
        assert!(chosen(8) && !chosen(9), "its interval begins at 1.02");
    }

    #[test]
    fn of_orders_that_are_level_the_one_with_the_shortest_keys_is_taken_since_version_10() {
        let nets = [("aila", 1.30), ("octahedron", 1.28), ("costa", 1.275), ("origin", 1.26)];
        let mut calibration = [calibrated(Kind::Shadow, 1, 1.0, &nets)];
        for (candidate, key_bits) in calibration[0].candidates.iter_mut().zip([24, 12, 12, 10]) {
            candidate.choice.key_bits = key_bits;
        }
        let chosen = |version| {
            let candidate = Calibrated { queues: &calibration, version }.decide(1, Kind::Shadow, 1, 1.0);
            candidate.map(|candidate| candidate.choice.method.clone()).unwrap()
        };
        assert_eq!(chosen(9), "aila");
        assert_eq!(
            chosen(10),
            "octahedron",
            "0.02 less by half the bits; of 12 bits the fastest, and 10 are too slow"
        );
    }

    #[test]
    fn less_drifts_of_closest_rays_and_between_two_orders_since_version_11() {
        let mut calibration = [Kind::Closest, Kind::Shadow].map(|kind| {
            let mut queue = calibrated(kind, 1, 1.0, &[("aila", 1.065), ("origin", 1.062)]);
            queue.candidates[1].choice.key_bits = 12;
            queue
        });
        let chosen = |calibration: &[CalibrationRecord], version, kind| {
            let candidate = Calibrated { queues: calibration, version }.decide(1, kind, 1, 1.0);
            candidate.map(|candidate| candidate.choice.key_bits)
        };
        assert_eq!(chosen(&calibration, 11, Kind::Closest), Some(12), "level, and both begin above 1.015");
        assert_eq!(chosen(&calibration, 10, Kind::Closest), None, "below 1.03");
        assert_eq!(chosen(&calibration, 11, Kind::Shadow), None, "below 1.03");
        let nets = [1.10, 1.08];
        for queue in &mut calibration {
            queue.candidates.iter_mut().zip(nets).for_each(|(candidate, net)| {
                (candidate.net, candidate.net_low) = (net, net - 0.01);
            });
        }
        for kind in [Kind::Closest, Kind::Shadow] {
            assert_eq!(chosen(&calibration, 10, kind), Some(12), "{kind}: level within 0.03");
            assert_eq!(chosen(&calibration, 11, kind), Some(16), "{kind}: not within 0.015");
        }
    }

    #[test]
    fn the_sample_is_whole_groups_over_all_of_the_queue() {
        for rays in [0, 63, 64, 1_000, 2_048, 100_000] {
            let ranges: Vec<Range<usize>> = sample(rays).collect();
            assert_eq!(ranges.len(), (rays / GROUP_RAYS).min(GROUPS), "{rays} rays");
            assert!(ranges.iter().all(|range| range.len() == GROUP_RAYS && range.end <= rays));
            assert!(ranges.is_sorted_by(|a, b| a.end <= b.start));
        }
        assert!(sample(100_000).last().is_some_and(|range| range.start > 95_000));
    }

    #[test]
    fn rays_that_part_have_the_larger_area() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let rays = |apart: f32| -> Vec<Ray> {
            let ray = |at: usize| {
                let [x, y] = [(at % 8) as f32 - 3.5, (at / 8 % 8) as f32 - 3.5].map(|part| part * apart);
                let length = (x * x + y * y + 1.0).sqrt();
                let direction = [x / length, y / length, 1.0 / length];
                Ray { origin: [0.5, 0.5, 0.1], t_min: 0.0, direction, t_max: f32::INFINITY }
            };
            (0..2 * GROUP_RAYS).map(ray).collect()
        };
        let [close, apart] = [0.01, 0.3].map(|apart| sampled_area(&unit, &rays(apart)));
        assert!(apart > 10.0 * close && close > 0.0, "{close} {apart}");
        assert_eq!(sampled_area(&unit, &[]), 0.0);
    }
}
