//! The method `auto` on a machine: its candidates, and what it chooses for a queue.

use anyhow::{Context, Result};
use formats::auto::{Calibrated, sample, sampled_area};
use formats::key::{Extent, KEY_BITS_MIN, LAYOUT_BITS, Method};
use formats::manifest::{self, CalibrationRecord, Candidate, Choice, FORMAT_VERSION, QueueId, Way};
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;

use crate::backends::{Array, Backend, Queue};
use crate::clock::{Clock, Sample};
use crate::options::in_range;
use crate::stages::setup::{MethodPlan, Setup};

/// Methods, and the bits of their keys, that a calibration tries on closest and on shadow rays.
type Tried = [&'static [(&'static str, u32)]; 2];

/// One pass sorts 15 bits and two sort 20. Shadow rays, which take less time, gain by 20 what the second pass costs.
const ON_THREADS: Tried = [
    &[("origin", 15), ("aila", 15), ("aila", 20), ("octahedron", 15), ("octahedron", 20), ("two-point", 20)],
    &[("origin", 15), ("aila", 15), ("octahedron", 15), ("origin-light", 15)],
];

/// A pass sorts 8 bits and takes little beside a trace: closest rays gain by three passes more than those cost, shadow
/// rays hardly (docs/measurements/h100.md).
const ON_GPUS: Tried = [
    &[("aila", 16), ("aila", 24), ("octahedron", 24), ("two-point", 24), ("two-point", 32)],
    &[("aila", 16), ("origin-light", 16), ("origin-light", 24), ("light-octahedron", 16)],
];

/// Chooses orders by a calibration.
#[derive(Clone, Debug)]
pub struct Auto {
    calibration: Vec<CalibrationRecord>,
    /// Fewest rays that get an order. At hand, since a lookup in the calibration waits for memory, 2 µs that a queue of
    /// a few hundred rays feels.
    fewest_rays: u64,
    /// What a queue gets that is known by its bounce and number of rays, for each of the calibration. At hand, too.
    known: Vec<Option<(usize, Way)>>,
    unit: UnitSpace,
    /// Number of the first candidate among the methods of the run.
    first: usize,
    candidates: Vec<(String, u32)>,
}

/// What was chosen for a queue.
pub struct Decision {
    /// Mean capsule area of its sample, unit space; 0 where none was taken.
    pub area: f64,
    /// What was chosen.
    pub choice: Option<Choice>,
    /// Number of that method, and the way.
    pub order: Option<(usize, Way)>,
}

/// The candidates of a run, each for the kinds of rays that it is a candidate for: those of a calibration that there is,
/// or those that one tries on a backend.
///
/// # Errors
/// If a calibration names a method or bits that there are not.
pub fn candidates(
    backend: manifest::Backend,
    calibration: &[CalibrationRecord],
    extent: Extent,
    length: f32,
) -> Result<Vec<MethodPlan>> {
    let tried = match backend {
        manifest::Backend::Cpu => ON_THREADS,
        manifest::Backend::Gpu => ON_GPUS,
    };
    let mut all: Vec<(Kind, &str, u32)> = Vec::new();
    if calibration.is_empty() {
        for kind in Kind::ALL {
            all.extend(tried[kind as usize].iter().map(|&(name, bits)| (kind, name, bits)));
        }
    }
    for CalibrationRecord { kind, candidates, .. } in calibration {
        let choices = candidates.iter().map(|candidate| &candidate.choice);
        all.extend(choices.map(|choice| (*kind, choice.method.as_str(), choice.key_bits)));
    }
    let mut plans: Vec<MethodPlan> = Vec::new();
    for (kind, name, bits) in all {
        in_range("key-bits", bits, KEY_BITS_MIN, LAYOUT_BITS)?;
        let method = Method::builtin(name)?;
        let known = plans.iter().position(|plan| plan.name == name && plan.key_bits == bits);
        let at = known.unwrap_or(plans.len());
        if known.is_none() {
            let plan = MethodPlan::new(&method, extent, bits, length)?;
            plans.push(MethodPlan { for_kinds: [false; 2], ..plan });
        }
        plans[at].for_kinds[kind as usize] |= method.applies_to(kind);
    }
    Ok(plans)
}

/// Room for the sample of a queue, touched before a clock starts.
pub fn room(rays: usize) -> Vec<Ray> {
    let nothing = Ray { origin: [0.0; 3], t_min: 0.0, direction: [0.0; 3], t_max: 0.0 };
    vec![nothing; sample(rays).map(|range| range.len()).sum()]
}

impl Auto {
    /// For a run whose methods end with the candidates.
    ///
    /// # Errors
    /// If the calibration names others.
    pub fn new(setup: &Setup, calibration: Vec<CalibrationRecord>) -> Result<Self> {
        let plans = setup.candidates().iter();
        let candidates: Vec<(String, u32)> = plans.map(|plan| (plan.name.clone(), plan.key_bits)).collect();
        let first = setup.named().len();
        let calibrated = Calibrated { queues: &calibration, version: FORMAT_VERSION };
        let fewest_rays = calibrated.fewest_rays();
        let known = calibration.iter().map(|queue| {
            let candidate = calibrated.decide(queue.bounce, queue.kind, queue.rays, queue.area);
            candidate.map(|candidate| order_of(&candidate.choice, first, &candidates)).transpose()
        });
        let known = known.collect::<Result<Vec<_>>>()?;
        Ok(Self { calibration, fewest_rays, known, unit: setup.unit, first, candidates })
    }

    /// What was measured before.
    pub fn calibration(&self) -> &[CalibrationRecord] {
        &self.calibration
    }

    /// Looks at the sample of a queue, if that has anything to say, and chooses, timed on the processor's clock.
    ///
    /// # Errors
    /// Any of the backend.
    pub fn decide<B: Backend>(&self, backend: &mut B, rays: &B::Rays) -> Result<(Decision, Sample)> {
        let mut sampled = room(rays.len());
        let mut clock = Clock::of_processor();
        let (area, order) = clock.time(|| {
            let (QueueId { bounce, kind, .. }, count) = (rays.id(), rays.len() as u64);
            if count < self.fewest_rays {
                return anyhow::Ok((0.0, None));
            }
            let calibrated = Calibrated { queues: &self.calibration, version: FORMAT_VERSION };
            if let Some(at) = calibrated.known(bounce, kind, count) {
                return Ok((0.0, self.known[at]));
            }
            let area = match calibrated.is_worth_a_look(bounce, kind, count) {
                true => self.area(backend, rays, &mut sampled)?,
                false => 0.0,
            };
            let candidate = calibrated.decide(bounce, kind, count, area);
            let order = |candidate: &Candidate| order_of(&candidate.choice, self.first, &self.candidates);
            Ok((area, candidate.map(order).transpose()?))
        })?;
        let choice = order.map(|(number, way)| {
            let (method, key_bits) = self.candidates[number - self.first].clone();
            Choice { method, key_bits, way }
        });
        Ok((Decision { area, choice, order }, clock.last()))
    }

    /// Mean capsule area of the sample of a queue.
    ///
    /// # Errors
    /// Any of the backend.
    pub fn area<B: Backend>(&self, backend: &mut B, rays: &B::Rays, sampled: &mut [Ray]) -> Result<f64> {
        let mut at = 0;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(sampled);
        backend.read(Array::Sample(rays), &mut |piece| {
            bytes[at..at + piece.len()].copy_from_slice(piece);
            at += piece.len();
            Ok(())
        })?;
        Ok(sampled_area(&self.unit, sampled))
    }
}

/// Number of the chosen method where these candidates are the methods from number `first` on, and the way.
fn order_of(choice: &Choice, first: usize, candidates: &[(String, u32)]) -> Result<(usize, Way)> {
    let is_it = |(name, bits): &(String, u32)| *name == choice.method && *bits == choice.key_bits;
    let at = candidates.iter().position(is_it).context("a calibration names other orders")?;
    Ok((first + at, choice.way))
}
