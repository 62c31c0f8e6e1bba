//! Key bits: what keys and sort cost, and how coherent and how fast the order is.

use anyhow::Result;
use formats::bench_result::error::KeyBitsRow;
use formats::key::method::UNSORTED;
use formats::manifest::Stage;
use formats::metrics::GROUP_RAYS;
use formats::metrics::capsule::{Capsule, Segment};
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;
use rayon::prelude::*;

use super::super::backends::OnBackend;
use super::Bench;
use super::estimator::traced_lengths;
use crate::backends::{Array, Backend, Queue, collected};
use crate::measure::{Measured, Queued, Subject};
use crate::replay::variants::Sweep;
use crate::stages::setup::Setup;
use crate::wavefront::{self, Observer};

/// The queues that are measured, or those of the last bounce if there are fewer: incoherent rays, and the
/// shadow rays of the surface before.
const SECONDARY_BOUNCE: u32 = 2;
const SHADOW_BOUNCE: u32 = 1;

/// Measures every method at every number of key bits.
pub(super) fn run(bench: Bench<'_>) -> Result<Vec<KeyBitsRow>> {
    let options = bench.options;
    let mut setup = Setup::clone(&*bench.setup(&options.run)?);
    let sweep = Sweep { key_bits: options.key_bits.clone(), ..Sweep::default() };
    setup.methods = sweep.plans(
        &options.run.orders.methods,
        setup.extent(),
        options.run.key_bits,
        options.run.two_point_length,
    )?;
    let setup = std::sync::Arc::new(setup);
    bench.measure(&setup, Orders { bench, setup: &setup, rows: Vec::new() })
}

struct Orders<'a> {
    bench: Bench<'a>,
    setup: &'a Setup,
    rows: Vec<KeyBitsRow>,
}

impl OnBackend for Orders<'_> {
    type Output = Vec<KeyBitsRow>;

    fn run<B: Backend>(mut self, backend: &mut B) -> Result<Vec<KeyBitsRow>> {
        let run = &self.bench.options.run;
        wavefront::run(backend, 0..run.passes, run.bounces, &mut self)?;
        Ok(self.rows)
    }
}

impl<B: Backend> Observer<B> for Orders<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let id = rays.id();
        let run = &self.bench.options.run;
        let wanted = match id.kind {
            Kind::Closest => SECONDARY_BOUNCE,
            Kind::Shadow => SHADOW_BOUNCE,
        };
        if id.pass + 1 != run.passes || id.bounce != wanted.min(run.bounces - 1) {
            return Ok(());
        }
        let unit = self.bench.unit();
        let copied: Vec<Ray> = collected(backend, Array::Rays(rays))?;
        let lengths = traced_lengths(backend, id.kind, &unit, &copied, hits)?;
        let area = |order: &[u32]| mean_capsule_area(&unit, &copied, &lengths, order);
        let methods = (0..self.setup.methods.len()).map(Subject::Method);
        // Canonical order is gathered like the others: what was just written is read faster.
        let orders = [Subject::Control].into_iter().chain(methods).collect();
        let measured = Measured { orders, repeats: run.repeats, seed: run.seed };
        let queue = Queued { rays, hits, methods: &self.setup.methods, foreign: &[], auto: None };
        let mut areas = Vec::new();
        let orders = queue.warm_up(backend, &measured, |backend, _, _, permutation| {
            areas.push(area(&collected(backend, Array::Permutation(permutation))?));
            Ok(())
        })?;
        for (entry, capsule_area) in queue.measure(backend, &measured, &orders)?.into_iter().zip(areas) {
            let (method, key_bits) = match entry.subject {
                Subject::Method(number) => {
                    let plan = &self.setup.methods[number];
                    (plan.base.as_str(), plan.key_bits)
                }
                _ => (UNSORTED, 0),
            };
            let samples_ns = |stage| entry.stages.of(stage).to_vec();
            self.rows.push(KeyBitsRow {
                scene: self.bench.scene.name.clone(),
                bounce: id.bounce,
                kind: id.kind,
                method: method.to_owned(),
                key_bits,
                rays: copied.len() as u64,
                capsule_area,
                key_ns: samples_ns(Stage::Key),
                sort_ns: samples_ns(Stage::Sort),
                trace_ns: samples_ns(Stage::Trace),
            });
        }
        Ok(())
    }
}

/// Mean capsule area of an order, weighted by rays, unit space; 0 for no rays.
fn mean_capsule_area(unit: &UnitSpace, rays: &[Ray], lengths: &[f32], order: &[u32]) -> f64 {
    let of_group = |group: &[u32]| {
        let segment = |&at: &u32| Segment::of(unit, &rays[at as usize], lengths[at as usize]);
        let segments: Vec<Segment> = group.iter().map(segment).collect();
        Capsule::around(&segments).map_or(0.0, |capsule| capsule.area() * group.len() as f64)
    };
    let areas: Vec<f64> = order.par_chunks(GROUP_RAYS).map(of_group).collect();
    areas.iter().sum::<f64>() / order.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of the rays are all alike, the others spread over a line: groups of the sorted order have no
    /// area or that of a capsule, those of an order that mixes them are all large.
    #[test]
    fn areas_are_means_over_rays_of_an_order() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let ray = |x: f32| Ray { origin: [x, 0.0, 0.0], t_min: 0.0, direction: [0.0, 1.0, 0.0], t_max: 1.0 };
        let count = GROUP_RAYS as u32;
        let spread = |at: u32| at as f32 / (count - 1) as f32;
        let rays: Vec<Ray> =
            (0..2 * count).map(|at| ray(if at < count { 0.5 } else { spread(at - count) })).collect();
        let lengths = vec![0.25; rays.len()];
        let sorted: Vec<u32> = (0..2 * count).collect();
        let mixed: Vec<u32> = (0..count).flat_map(|at| [at, at + count]).collect();
        // A capsule of two spheres of radius 1/2, a quarter apart.
        let capsule = std::f64::consts::PI * (4.0 * 0.25 + 2.0 * 0.5 * 0.25);
        let area = |order: &[u32]| mean_capsule_area(&unit, &rays, &lengths, order);
        assert!((area(&sorted) - 0.5 * capsule).abs() < 1e-6, "{}", area(&sorted));
        assert!(area(&mixed) > 0.2 * capsule && area(&mixed) < capsule);
        assert_eq!(mean_capsule_area(&unit, &[], &[], &[]), 0.0);
    }
}
