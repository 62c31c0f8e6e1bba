//! The method `auto` on a machine: its candidates, and what it chooses for a queue.

use anyhow::{Context, Result};
use formats::auto::{Calibrated, sample, sampled_area};
use formats::key::{Extent, KEY_BITS_MIN, LAYOUT_BITS, Method};
use formats::manifest::{CalibrationRecord, Choice, FORMAT_VERSION, QueueId, Way};
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;

use crate::backends::{Array, Backend, Queue};
use crate::clock::{Clock, Sample};
use crate::options::in_range;
use crate::stages::setup::{MethodPlan, Setup};

/// What a calibration tries on closest and on shadow rays: methods with fewer bits than the usual 32, which cost less to
/// sort. On threads one pass sorts 15 bits and two sort 20; on GPUs two and three do. Shadow rays, which take less time,
/// gain by 20 bits what the second pass costs.
const CANDIDATES: [&[(&str, u32)]; 2] = [
    &[("origin", 15), ("aila", 15), ("aila", 20), ("octahedron", 15), ("octahedron", 20), ("two-point", 20)],
    &[("origin", 15), ("aila", 15), ("octahedron", 15), ("origin-light", 15)],
];

/// Names and bits of the orders that a calibration tries on rays of a kind.
pub const fn tried_on(kind: Kind) -> &'static [(&'static str, u32)] {
    CANDIDATES[kind as usize]
}

/// Chooses orders by a calibration.
#[derive(Clone, Debug)]
pub struct Auto {
    /// What was measured before.
    pub calibration: Vec<CalibrationRecord>,
    /// Fewest rays that get an order. At hand, since a lookup in the calibration waits for memory, 2 µs that a queue of
    /// a few hundred rays feels.
    fewest_rays: u64,
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

/// The candidates of a run: those of a calibration that there is, or all.
///
/// # Errors
/// If a calibration names a method or bits that there are not.
pub fn candidates(calibration: &[CalibrationRecord], extent: Extent, length: f32) -> Result<Vec<MethodPlan>> {
    let measured = calibration.iter().flat_map(|queue| &queue.candidates).map(|candidate| &candidate.choice);
    let mut all: Vec<(&str, u32)> =
        measured.map(|choice| (choice.method.as_str(), choice.key_bits)).collect();
    if calibration.is_empty() {
        all = CANDIDATES.concat();
    }
    let mut wanted: Vec<(&str, u32)> = Vec::new();
    for candidate in all {
        if !wanted.contains(&candidate) {
            wanted.push(candidate);
        }
    }
    let plan = |&(name, bits): &(&str, u32)| {
        in_range("key-bits", bits, KEY_BITS_MIN, LAYOUT_BITS)?;
        Ok(MethodPlan::new(&Method::builtin(name)?, extent, bits, length)?)
    };
    wanted.iter().map(plan).collect()
}

/// Room for the sample of a queue, touched before a clock starts.
pub fn room(rays: usize) -> Vec<Ray> {
    let nothing = Ray { origin: [0.0; 3], t_min: 0.0, direction: [0.0; 3], t_max: 0.0 };
    vec![nothing; sample(rays).map(|range| range.len()).sum()]
}

impl Auto {
    /// For a run whose methods end with the candidates.
    pub fn new(setup: &Setup, calibration: Vec<CalibrationRecord>) -> Self {
        let candidates = setup.candidates().iter().map(|plan| (plan.name.clone(), plan.key_bits)).collect();
        let fewest_rays = Calibrated { queues: &calibration, version: FORMAT_VERSION }.fewest_rays();
        Self { calibration, fewest_rays, unit: setup.unit, first: setup.named().len(), candidates }
    }

    /// Looks at the sample of a queue, if that has anything to say, and chooses, timed on the processor's clock.
    ///
    /// # Errors
    /// Any of the backend.
    pub fn decide<B: Backend>(&self, backend: &mut B, rays: &B::Rays) -> Result<(Decision, Sample)> {
        let mut sampled = room(rays.len());
        let mut clock = Clock::of_processor();
        let (area, candidate, order) = clock.time(|| {
            if (rays.len() as u64) < self.fewest_rays {
                return anyhow::Ok((0.0, None, None));
            }
            let QueueId { bounce, kind, .. } = rays.id();
            let calibrated = Calibrated { queues: &self.calibration, version: FORMAT_VERSION };
            let count = rays.len() as u64;
            let area = match calibrated.is_worth_a_look(bounce, kind, count) {
                true => self.area(backend, rays, &mut sampled)?,
                false => 0.0,
            };
            let candidate = calibrated.decide(bounce, kind, count, area);
            let order = candidate.map(|candidate| self.order(&candidate.choice)).transpose()?;
            anyhow::Ok((area, candidate, order))
        })?;
        let decision = Decision { area, choice: candidate.map(|candidate| candidate.choice.clone()), order };
        Ok((decision, clock.last()))
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

    fn order(&self, choice: &Choice) -> Result<(usize, Way)> {
        let is_it = |(name, bits): &(String, u32)| *name == choice.method && *bits == choice.key_bits;
        let at = self.candidates.iter().position(is_it).context("a calibration names other orders")?;
        Ok((self.first + at, choice.way))
    }
}
