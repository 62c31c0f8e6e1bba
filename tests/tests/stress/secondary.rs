//! Secondary rays as recordings have them, held against the oracle.

use std::path::PathBuf;
use std::sync::Arc;

use formats::ray::{Kind, Ray};
use rayon::prelude::*;
use recorder::backends::cpu::CpuBackend;
use recorder::backends::{Array, Backend, Queue, collected};
use recorder::cli::parse_record;
use recorder::oracle::{Deviation, Oracle, Verdict};
use recorder::recording;
use recorder::stages::setup::Setup;
use recorder::stages::trace::TraceKernel;
use recorder::stages::trace::cpu::CpuTracer;
use recorder::wavefront::{self, Observer};
use scenes::Scene;
use scenes::bvh::{BvhKind, build};

use crate::runner::{self, kernels, trace};

/// Distances are off by no more than this, in ulps of the coordinate scale, for all rays but
/// [`OUTLIERS`] of them.
const USUAL_ULPS: f64 = 8.0;
const OUTLIERS: f64 = 0.001;
/// Bounces that are traced.
const BOUNCES: u32 = 6;

/// Collects the closest rays of all bounces but the first.
struct Secondary(Vec<Ray>);

impl<B: Backend> Observer<B> for Secondary {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, _: &B::Hits) -> anyhow::Result<()> {
        let id = rays.id();
        if id.kind == Kind::Closest && id.bounce > 0 {
            self.0.extend(collected::<Ray, B>(backend, Array::Rays(rays))?);
        }
        Ok(())
    }
}

/// So many secondary rays of the scene's first camera, spread evenly over its picture and bounces.
fn secondary_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    // Paths end on the way, most of them outdoors.
    let height = (count as f64 / 4.0 / (16.0 / 9.0)).sqrt().ceil() as u32;
    let options = parse_record(
        ["builtin:cornell", "--out", "unused", "--methods", "unsorted"].into_iter().map(Into::into),
    );
    let setup = recording::setup(scene, &scene.cameras[0], &options.unwrap()).unwrap();
    let setup = Arc::new(Setup { width: height * 16 / 9, height, bounces: BOUNCES, ..setup });
    let tracer = CpuTracer::new(scene, &build(scene, BvhKind::Cwbvh).unwrap());
    let mut backend = CpuBackend::new(setup, Arc::new(tracer));
    let (mut found, mut passes) = (Secondary(Vec::new()), 0);
    while found.0.len() < count && passes < 16 {
        passes += 1;
        wavefront::run(&mut backend, 0..1, BOUNCES, &mut found).unwrap();
    }
    let Secondary(rays) = found;
    let wanted = count.min(rays.len());
    (0..wanted).map(|number| rays[number * rays.len() / wanted]).collect()
}

/// Holds every kernel's answers against the oracle; those of own kernels must be right.
fn check(scene: &Scene, count: usize) {
    let rays = secondary_rays(scene, count);
    let oracle = Oracle::new(scene);
    let name = &scene.name;
    for (backend, kernel) in kernels() {
        // Of a million rays, the GPU's share is a tenth.
        let step = if backend == runner::Backend::Gpu && rays.len() > 100_000 { 10 } else { 1 };
        let rays: Vec<Ray> = rays.iter().step_by(step).copied().collect();
        let answers = trace(backend, kernel, scene, &rays);
        let judged: Vec<_> =
            rays.par_iter().zip(&answers.hits).map(|(ray, hit)| oracle.judge(ray, hit)).collect();
        let of = |verdict| judged.iter().filter(|judgement| judgement.verdict == verdict).count();
        let mut deviations: Vec<Deviation> = judged.iter().filter_map(|judgement| judgement.t).collect();
        deviations.sort_by(|a, b| a.ulps.total_cmp(&b.ulps));
        let usual = deviations.iter().filter(|deviation| deviation.ulps <= USUAL_ULPS).count();
        let share = usual as f64 / deviations.len() as f64;
        let worst = deviations.last().copied().unwrap_or(Deviation { ulps: 0.0, tolerance_ulps: 0.0 });
        // Any blocker will do, which takes longer to find.
        let shadows = rays.par_iter().zip(&answers.distances).step_by(10);
        let wrong_shadows = shadows
            .filter(|(ray, distance)| !oracle.judge_occlusion(ray, **distance).verdict.is_right())
            .count();
        println!(
            "{name:18} {:9} triangles, {:20} {:8} rays: {} tied, {} missed, {} wrong, {} false, {wrong_shadows} wrong of every tenth as shadow rays; t within {USUAL_ULPS} ulps in {:.4} %, off by {:.1} at most where {:.1} may be",
            scene.triangles.len(),
            answers.name,
            rays.len(),
            of(Verdict::Tied),
            of(Verdict::Missed),
            of(Verdict::WrongTriangle),
            of(Verdict::FalseHit),
            100.0 * share,
            worst.ulps,
            worst.tolerance_ulps,
        );
        if kernel == TraceKernel::RayQuery {
            continue;
        }
        let first = judged.iter().position(|judgement| !judgement.verdict.is_right());
        let first = first.map(|at| (rays[at], answers.hits[at], oracle.closest(&rays[at])));
        assert!(first.is_none(), "{name}, {}: {first:?}", answers.name);
        assert_eq!(wrong_shadows, 0, "{name}, {}", answers.name);
        assert!(
            share >= 1.0 - OUTLIERS,
            "{name}, {}: only {share} are within {USUAL_ULPS} ulps",
            answers.name
        );
        let far_off = deviations.iter().filter(|deviation| deviation.ulps > deviation.tolerance_ulps).count();
        assert_eq!(far_off, 0, "{name}, {}: beyond the tolerance", answers.name);
    }
}

#[test]
fn of_built_in_scenes() {
    for name in [
        "cornell",
        "apartment?triangles=20000",
        "atrium?triangles=20000",
        "city?triangles=20000",
        "hairball?triangles=20000",
    ] {
        check(&scenes::load(&format!("builtin:{name}")).unwrap(), 8000);
    }
}

/// `RAYSCOPE_SCENES=FOLDER cargo test -p tests --test stress -- --ignored --nocapture scene_files`: a million
/// rays of every `.glb` file of a folder.
#[test]
#[ignore = "takes minutes a scene, and wants scene files"]
fn of_scene_files() {
    let folder = PathBuf::from(std::env::var("RAYSCOPE_SCENES").expect("RAYSCOPE_SCENES names a folder"));
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "glb"));
    files.sort();
    assert!(!files.is_empty(), "no .glb files there");
    for file in files {
        check(&scenes::load(file.to_str().unwrap()).unwrap(), 1_000_000);
    }
}
