//! Pictures on every backend, and their means with standard errors.

use std::sync::Arc;

use recorder::backends::cpu::CpuBackend;
use recorder::backends::gpu::GpuBackend;
use recorder::backends::{Backend, picture};
use recorder::cli::parse_record;
use recorder::device::{AdapterRequest, Gpu};
use recorder::recording;
use recorder::stages::setup::Setup;
use recorder::stages::trace::TraceKernel;
use recorder::stages::trace::cpu::CpuTracer;
use recorder::wavefront;
use scenes::Scene;
use scenes::bvh::{BvhKind, build};

/// Pixels across and down.
pub(crate) const SIZE: u32 = 128;
const PASSES: u32 = 2;

/// A mean and its standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub(crate) mean: f64,
    pub(crate) error: f64,
}

impl Estimate {
    /// Of independent samples.
    pub(crate) fn of(samples: impl IntoIterator<Item = f64>) -> Self {
        let samples: Vec<f64> = samples.into_iter().collect();
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let variance = samples.iter().map(|sample| (sample - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { mean, error: (variance / count).sqrt() }
    }
}

fn setup(scene: &Scene, bounces: u32, roulette: bool) -> Setup {
    let words = ["builtin:cornell", "--out", "unused", "--methods", "unsorted", "--seed", "7"];
    let options = parse_record(words.into_iter().map(Into::into)).unwrap();
    let setup = recording::setup(scene, &scene.cameras[0], &options).unwrap();
    Setup { width: SIZE, height: SIZE, bounces, roulette, ..setup }
}

fn green(mut backend: impl Backend, bounces: u32) -> Vec<f64> {
    wavefront::run(&mut backend, 0..PASSES, bounces, &mut ()).unwrap();
    let image = picture(&mut backend, PASSES).unwrap();
    assert!(image.iter().flatten().all(|value| value.is_finite() && *value >= 0.0), "a pixel is no radiance");
    image.into_iter().map(|[_, green, _]| f64::from(green)).collect()
}

/// Green values of the picture on threads and on the GPU, with names.
pub(crate) fn pictures(scene: &Scene, bounces: u32, roulette: bool) -> [(&'static str, Vec<f64>); 2] {
    let setup = Arc::new(setup(scene, bounces, roulette));
    let bvh = build(scene, BvhKind::Cwbvh).unwrap();
    let threads = CpuBackend::new(Arc::clone(&setup), Arc::new(CpuTracer::new(scene, &bvh)));
    let gpu = Gpu::open(&AdapterRequest::Any)
        .unwrap_or_else(|error| panic!("GPU tests need an adapter; tests/run installs one: {error}"));
    let gpu = GpuBackend::new(gpu, scene, Some(&bvh), setup, TraceKernel::Cwbvh).unwrap();
    [("threads", green(threads, bounces)), ("gpu", green(gpu, bounces))]
}

/// Renders on every backend with paths that do not end by chance, and compares the picture's mean with what is
/// known. `known` may have an error of its own.
pub(crate) fn expect(what: &str, scene: &Scene, bounces: u32, known: Estimate) {
    compare(what, &pictures(scene, bounces, false), known);
}

/// The same with paths that end by chance.
pub(crate) fn expect_with_roulette(what: &str, scene: &Scene, bounces: u32, known: Estimate) {
    compare(&format!("{what}, roulette"), &pictures(scene, bounces, true), known);
}

fn compare(what: &str, pictures: &[(&'static str, Vec<f64>)], known: Estimate) {
    let mut wrong = Vec::new();
    for (backend, pixels) in pictures {
        let found = Estimate::of(pixels.iter().copied());
        // What is exact in theory is rounded in f32.
        let rounding = 2e-6 * known.mean;
        let error = found.error.hypot(known.error).hypot(rounding);
        let apart = (found.mean - known.mean) / error;
        println!(
            "{what:44} {backend:8} {:.6} ± {:.6}, known {:.6} ± {:.6}: {apart:+.2} standard errors",
            found.mean, found.error, known.mean, known.error
        );
        if apart.abs() > 3.0 {
            wrong.push(*backend);
        }
        assert!(error < 0.02 * known.mean, "{what} on {backend}: {found:?} says too little");
    }
    assert!(wrong.is_empty(), "{what}: wrong on {wrong:?}, see above");
}

/// A known value without error.
pub(crate) fn exactly(mean: f64) -> Estimate {
    Estimate { mean, error: 0.0 }
}

/// The mean over all pixels of what a formula gives for the camera's ray of each place in the picture.
pub(crate) fn mean_over_picture(scene: &Scene, radiance: impl Fn([f64; 3], [f64; 3]) -> f64) -> f64 {
    const STEPS: u32 = 4 * SIZE;
    let camera = &scene.cameras[0];
    let half = f64::from(0.5 * camera.yfov_radians).tan();
    let eye = camera.eye.map(f64::from);
    let at = |step: u32| half * (2.0 * (f64::from(step) + 0.5) / f64::from(STEPS) - 1.0);
    let mut sum = 0.0;
    for (row, column) in (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column))) {
        let along = |axis: usize| {
            f64::from(camera.forward[axis])
                + at(column) * f64::from(camera.right[axis])
                + at(row) * f64::from(camera.up[axis])
        };
        let direction = [0, 1, 2].map(along);
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        sum += radiance(eye, direction.map(|x| x / length));
    }
    sum / f64::from(STEPS * STEPS)
}
