//! Threads and every trace kernel of the GPU make the same picture, and a recording that verifies.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use formats::manifest::Place;
use formats::reader::Dump;
use tempfile::tempdir;
use tests::drivers::skipped;
use tests::programs::Program;
use tests::recordings::verify;

/// Radiance is clamped here, so that one bright path does not decide.
const BRIGHTEST: f32 = 10.0;

/// How far two pictures may be apart. What differs is rounding that grows over bounces.
struct Tolerance {
    /// Share of pixels that may differ by more than 1 %.
    pixels: f64,
    /// Relative difference of the means.
    mean: f64,
}

const OWN_KERNEL: Tolerance = Tolerance { pixels: 0.01, mean: 0.001 };
/// The driver's traversal breaks ties in its own way.
const DRIVERS_KERNEL: Tolerance = Tolerance { pixels: 0.03, mean: 0.003 };

fn record(folder: &Path, name: &str, scene: &str, options: &str) -> Vec<[f32; 3]> {
    let line = format!(
        "record {scene} --out {name}.raydump --width 128 --height 72 --bounces 4 --passes 2 --repeats 1 --methods two-point {options}"
    );
    Program::Recorder.run(folder, &line).succeeded();
    verify(folder, name);
    let dump = Dump::open(&folder.join(format!("{name}.raydump"))).unwrap();
    dump.array::<[f32; 3]>(&Place::Image).unwrap().to_vec()
}

fn assert_agree(left: &[[f32; 3]], right: &[[f32; 3]], tolerance: &Tolerance, what: &str) {
    assert_eq!(left.len(), right.len(), "{what}: number of pixels");
    let differ = |a: f32, b: f32| (a - b).abs() > 0.01 * a.max(b);
    let clamped = |pixel: &[f32; 3]| pixel.map(|value| value.min(BRIGHTEST));
    let different = left.iter().zip(right).filter(|(a, b)| {
        let (a, b) = (clamped(a), clamped(b));
        (0..3).any(|channel| differ(a[channel], b[channel]))
    });
    let share = different.count() as f64 / left.len() as f64;
    let mean = |pixels: &[[f32; 3]]| {
        pixels.iter().flat_map(clamped).map(f64::from).sum::<f64>() / (3 * pixels.len()) as f64
    };
    let (left_mean, right_mean) = (mean(left), mean(right));
    assert!(left_mean > 0.01, "{what}: the picture is black (mean {left_mean})");
    assert!(left.iter().flatten().all(|value| value.is_finite()), "{what}: a pixel is not finite");
    let apart = (left_mean - right_mean).abs() / left_mean;
    println!("{what}: {:.3} % of pixels differ, means by {:.4} %", 100.0 * share, 100.0 * apart);
    assert!(share <= tolerance.pixels, "{what}: {share} of the pixels differ by more than 1 %");
    assert!(apart <= tolerance.mean, "{what}: means {left_mean} and {right_mean}");
}

/// Whether an adapter here offers ray queries; where none does, asking for them must be refused.
fn has_ray_query(folder: &Path) -> bool {
    let tried = Program::Recorder.run(folder, "record builtin:cornell --out tried.raydump --width 8 --height 8 --bounces 1 --passes 1 --repeats 1 --methods unsorted --backend gpu --trace ray-query");
    if tried.code != Some(0) {
        tried.failed_with(1, &["ray"]);
    }
    tried.code == Some(0)
}

fn all_backends_agree(scene: &str) {
    let folder = tempdir().unwrap();
    let threads = record(folder.path(), "threads", scene, "--backend cpu");
    for kernel in ["cwbvh", "bvh2"] {
        let gpu = record(folder.path(), kernel, scene, &format!("--backend gpu --trace {kernel}"));
        assert_agree(&threads, &gpu, &OWN_KERNEL, &format!("{scene} with {kernel}"));
    }
    if has_ray_query(folder.path()) {
        let gpu = record(folder.path(), "ray-query", scene, "--backend gpu --trace ray-query");
        assert_agree(&threads, &gpu, &DRIVERS_KERNEL, &format!("{scene} with ray-query"));
    } else {
        skipped(&format!("{scene} with ray-query"), "the adapter has no ray queries");
    }
}

#[test]
fn on_the_cornell_box() {
    all_backends_agree("builtin:cornell");
}

#[test]
fn in_the_atrium() {
    all_backends_agree("builtin:atrium?triangles=20000");
}

#[test]
fn different_pictures_do_not_agree() {
    let folder = tempdir().unwrap();
    let first = record(folder.path(), "first", "builtin:cornell", "--backend cpu --seed 1");
    let second = record(folder.path(), "second", "builtin:cornell", "--backend cpu --seed 2");
    let compared = std::panic::catch_unwind(|| assert_agree(&first, &second, &OWN_KERNEL, "two seeds"));
    assert!(compared.is_err(), "the comparison accepts the noise of another seed");
}
