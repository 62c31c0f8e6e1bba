//! Precision: what watertight triangles and padded boxes cost, and what is lost without them.
//!
//! Rays are those of paths that the careful kernel traced, so that every variant is asked the same
//! questions; answers are held against the exact ones of [`crate::oracle`].

use std::sync::Arc;

use anyhow::Result;
use formats::bench_result::error::{Distribution, HitErrors, PrecisionRow};
use formats::manifest::QueueId;
use formats::ray::{Hit, Kind, Ray};
use rayon::prelude::*;
use scenes::Scene;

use super::super::backends::{Configuration, OnBackend, OnBackends, measure, measure_all};
use super::super::queues::strata;
use super::Bench;
use crate::backends::{Array, Backend, Queue, RecordedRays, collected};
use crate::machine::Device;
use crate::measure::sampled;
use crate::oracle::{ExactHit, Oracle, Verdict};
use crate::stages::setup::Setup;
use crate::stages::trace::{Order, Precision, TraceKernel};
use crate::wavefront;

/// Name of tests that are the driver's affair.
const DRIVER: &str = "driver";

/// Traces the secondary rays of a scene with every kernel and every test.
pub(super) fn run(bench: Bench<'_>) -> Result<Vec<PrecisionRow>> {
    let run = &bench.options.run;
    let setup = bench.setup(run)?;
    let wanted = (bench.options.rays / (run.bounces.max(2) as usize - 1)).max(1);
    let sample = Sample { bounces: run.bounces, wanted };
    let rays = measure(bench.device, bench.scene, &setup, TraceKernel::Cwbvh, sample)?;
    let mut variants = Vec::new();
    for kernel in bench.device.kernels() {
        variants.extend(Precision::ALL.map(|precision| (kernel, precision)));
    }
    if let Device::Gpu(device) = bench.device
        && device.gpu.has(wgpu::Features::EXPERIMENTAL_RAY_QUERY)
    {
        variants.push((TraceKernel::RayQuery, Precision::default()));
    }
    let configuration = |&(kernel, precision): &(TraceKernel, Precision)| Configuration {
        // A queue has a pixel for each ray.
        setup: Arc::new(Setup { precision, width: rays.len() as u32, height: 1, ..Setup::clone(&setup) }),
        kernel,
    };
    let configurations: Vec<Configuration> = variants.iter().map(configuration).collect();
    let tracing = Tracing { rays: &rays, repeats: run.repeats };
    let traced = measure_all(bench.device, bench.scene, &configurations, tracing)?;
    let judge = Judge::new(bench.scene, &rays);
    let row = |((kernel, precision), traced): (&(TraceKernel, Precision), Traced)| {
        let is_driver = *kernel == TraceKernel::RayQuery;
        let name = |name: &str| if is_driver { DRIVER } else { name }.to_owned();
        PrecisionRow {
            scene: bench.scene.name.clone(),
            triangles: bench.scene.triangles.len() as u64,
            kernel: kernel.name().to_owned(),
            triangle_test: name(precision.triangles.name()),
            box_test: name(precision.boxes.name()),
            bounces: format!("1-{}", run.bounces - 1),
            errors: judge.errors(&traced.hits),
            rays_timed: rays.len() as u64,
            samples_ns: traced.samples_ns,
        }
    };
    Ok(variants.iter().zip(traced).map(row).collect())
}

/// Collects secondary rays, as many of each bounce.
struct Sample {
    bounces: u32,
    /// Most rays of a bounce.
    wanted: usize,
}

impl OnBackend for Sample {
    type Output = Vec<Ray>;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Vec<Ray>> {
        let mut sampled = Vec::new();
        let mut sample = |backend: &mut B, rays: &B::Rays, _: &B::Hits| {
            let id = rays.id();
            if id.kind == Kind::Closest && id.bounce > 0 {
                let queue: Vec<Ray> = collected(backend, Array::Rays(rays))?;
                sampled.extend(strata(rays.len(), self.wanted).map(|at| queue[at]));
            }
            Ok(())
        };
        wavefront::run(backend, 0..1, self.bounces, &mut sample)?;
        Ok(sampled)
    }
}

/// Traces the same rays with every backend, in rounds.
struct Tracing<'a> {
    rays: &'a [Ray],
    repeats: u32,
}

/// What one backend found, and how long it took each time.
struct Traced {
    hits: Vec<Hit>,
    samples_ns: Vec<u64>,
}

impl OnBackends for Tracing<'_> {
    type Output = Vec<Traced>;

    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<Vec<Traced>> {
        let path_ids: Vec<u32> = (0..self.rays.len() as u32).collect();
        let queue = RecordedRays {
            id: QueueId { pass: 0, bounce: 1, kind: Kind::Closest },
            rays: self.rays,
            path_ids: &path_ids,
            lights: &[],
            lengths: None,
        };
        let mut found = Vec::new();
        let mut queues = Vec::new();
        for backend in &mut backends {
            let rays = backend.upload(queue)?;
            let hits = backend.trace(&rays, Order::Stored)?;
            found.push(collected(backend, Array::Hits(&hits))?);
            queues.push(rays);
        }
        let samples = sampled(backends.len(), self.repeats, 0, |at| {
            backends[at].trace(&queues[at], Order::Stored)?;
            Ok(backends[at].elapsed_ns())
        })?;
        let traced = |(hits, samples_ns)| Traced { hits, samples_ns };
        Ok(found.into_iter().zip(samples).map(traced).collect())
    }
}

/// The exact answers, against which others are held.
struct Judge<'a> {
    oracle: Oracle,
    rays: &'a [Ray],
    exact: Vec<Option<ExactHit>>,
}

impl<'a> Judge<'a> {
    fn new(scene: &Scene, rays: &'a [Ray]) -> Self {
        let oracle = Oracle::new(scene);
        let exact = rays.par_iter().map(|ray| oracle.closest(ray)).collect();
        Self { oracle, rays, exact }
    }

    fn errors(&self, hits: &[Hit]) -> HitErrors {
        let answers = self.rays.par_iter().zip(&self.exact).zip(hits);
        let outcomes = answers.map(|((ray, exact), hit)| {
            let judgement = self.oracle.judge(ray, hit);
            let relative = exact
                .filter(|exact| exact.triangle == hit.triangle && exact.t > 0.0)
                .map(|exact| (f64::from(hit.t) - exact.t).abs() / exact.t);
            let ulps = judgement.t.filter(|_| relative.is_some()).map(|deviation| deviation.ulps);
            (judgement.verdict, relative, ulps)
        });
        let outcomes: Vec<(Verdict, Option<f64>, Option<f64>)> = outcomes.collect();
        let count = |verdict| outcomes.iter().filter(|(found, ..)| *found == verdict).count() as u64;
        HitErrors {
            rays: hits.len() as u64,
            missed: count(Verdict::Missed),
            false_hits: count(Verdict::FalseHit),
            wrong_triangles: count(Verdict::WrongTriangle),
            tied: count(Verdict::Tied),
            relative: Distribution::of(outcomes.iter().filter_map(|(_, relative, _)| *relative).collect()),
            ulp: Distribution::of(outcomes.iter().filter_map(|(.., ulps)| *ulps).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares one behind the other, at z = 1 and z = 2, of two triangles each.
    fn squares() -> Scene {
        let corners = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        Scene::of_geometry(
            "squares".to_owned(),
            [corners(1.0), corners(2.0)].concat(),
            vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        )
    }

    /// Straight ahead from z = 0.
    fn ahead(x: f32, y: f32) -> Ray {
        Ray { origin: [x, y, 0.0], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: f32::INFINITY }
    }

    #[test]
    fn every_kind_of_wrong_answer_is_counted_as_what_it_is() {
        let rays = [ahead(0.75, 0.25), ahead(0.25, 0.75), ahead(0.75, 0.5), ahead(3.0, 3.0), ahead(4.0, 4.0)];
        let scene = squares();
        let judge = Judge::new(&scene, &rays);
        let hit = |t, triangle, u, v| Hit { t, triangle, u, v };
        let right =
            [hit(1.0, 0, 0.5, 0.25), hit(1.0, 1, 0.25, 0.5), hit(1.0, 0, 0.25, 0.5), Hit::MISS, Hit::MISS];
        let all_right = judge.errors(&right);
        assert_eq!(all_right, HitErrors { rays: 5, ..HitErrors::default() });
        // Through the first square to the second, nothing at all, a hit out of nowhere, and one that is
        // right but for an eighth of its distance.
        let wrong =
            [hit(2.0, 2, 0.5, 0.25), Hit::MISS, hit(1.125, 0, 0.25, 0.5), hit(1.0, 0, 0.1, 0.1), Hit::MISS];
        let found = judge.errors(&wrong);
        assert_eq!((found.wrong_triangles, found.missed, found.false_hits, found.tied), (1, 1, 1, 0));
        assert_eq!((found.relative.median, found.relative.max), (0.125, 0.125));
        // The coordinate scale is 1, whose ulp is 2^-23.
        assert_eq!(found.ulp.max, 0.125 * f64::from(1 << 23));
    }
}
