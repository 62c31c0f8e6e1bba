//! How time and memory grow with triangles, rays, bounces, lights and threads, one of them at a time.
//!
//! Each size is measured by itself, smallest first: passes of the loop, a sample each, whose queues are keyed,
//! sorted, gathered and added to a table that nothing reads. The first pass of a size does not count.

use std::collections::BTreeMap;
use std::fs;

use anyhow::Result;
use formats::bench_result::growth::{GrowthPoint, GrowthRow};
use formats::bench_result::{BenchResult, Rows};
use formats::manifest::Stage;
use scenes::{Light, Scene, builtin, bvh};

use super::backends::{self, OnBackend};
use super::result;
use crate::backends::{Backend, Queue, Table};
use crate::clock::Clock;
use crate::machine::{self, Device};
use crate::options::{DeviceOptions, RecordOptions};
use crate::output::{say, typed};
use crate::recording::prepared;
use crate::wavefront::{self, Observer};

/// Built-in scenes whose triangles grow: one from very few, one to very many.
const GROWN: [&str; 2] = ["cornell", "city"];

/// What grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Size {
    /// Of the built-in scenes `cornell` and `city`.
    Triangles,
    /// By the size of the picture.
    Rays,
    /// Of each path.
    Bounces,
    /// Spheres beside the lights that the scene has.
    Lights,
    /// Of the cpu backend, as many as there are.
    Threads,
}

/// What to measure; sizes in ascending order.
#[derive(Clone, Debug)]
pub struct GrowthBench {
    /// What is to grow.
    pub only: Vec<Size>,
    /// The scene, file or built-in name, of all but triangles.
    pub scene: String,
    /// Triangles of the built-in scenes; what one of them cannot have it does without.
    pub triangles: Vec<u64>,
    /// Pictures, by width and height.
    pub pictures: Vec<[u32; 2]>,
    /// Bounces.
    pub bounces: Vec<u32>,
    /// Lights that are added.
    pub lights: Vec<u32>,
    /// Size of the run where it does not grow, its first method, device.
    pub run: RecordOptions,
}

/// Measures every size.
///
/// # Errors
/// One sentence on what went wrong with scene or device, and if there is no memory for the most triangles.
pub fn run(bench: &GrowthBench) -> Result<BenchResult> {
    let device = machine::open(&bench.run.device)?;
    let counts = |name: &str| {
        let scene = builtin::list().into_iter().find(|scene| scene.name == name);
        let range = scene.map_or(0..=0, |scene| scene.least_triangles..=scene.most_triangles);
        bench.triangles.iter().copied().filter(move |count| range.contains(count)).collect::<Vec<u64>>()
    };
    if bench.only.contains(&Size::Triangles) {
        for name in GROWN {
            counts(name).last().map_or(Ok(()), |&most| builtin::check(name, most))?;
        }
    }
    let base = peak_bytes().unwrap_or(0);
    let mut rows = Vec::new();
    for &size in &bench.only {
        let mut series = Series { size, base, run: &bench.run, rows: Vec::new() };
        if size == Size::Triangles {
            for name in GROWN {
                for count in counts(name) {
                    let scene = builtin::build(name, Some(count))?;
                    series.build(&device, &scene)?;
                    series.point(&device, &scene, scene.triangles.len() as u64, &bench.run)?;
                }
            }
        } else {
            series.over(bench, &device, &scenes::load(&bench.scene)?)?;
        }
        rows.extend(series.rows);
    }
    Ok(result(&device, Rows::Growth(rows)))
}

/// The costs of one size after the other.
struct Series<'a> {
    size: Size,
    /// Bytes that the program had at its most before any size was measured.
    base: u64,
    run: &'a RecordOptions,
    rows: Vec<GrowthRow>,
}

impl Series<'_> {
    /// All sizes but triangles.
    fn over(&mut self, bench: &GrowthBench, device: &Device, scene: &Scene) -> Result<()> {
        let run = || bench.run.clone();
        match (self.size, device) {
            (Size::Triangles, _) | (Size::Threads, Device::Gpu(_)) => Ok(()),
            (Size::Rays, _) => bench.pictures.iter().try_for_each(|&[width, height]| {
                self.point(device, scene, 0, &RecordOptions { width, height, ..run() })
            }),
            (Size::Bounces, _) => bench.bounces.iter().try_for_each(|&bounces| {
                self.point(device, scene, bounces.into(), &RecordOptions { bounces, ..run() })
            }),
            (Size::Lights, _) => bench.lights.iter().try_for_each(|&count| {
                let scene = with_lights(scene, count);
                self.point(device, &scene, scene.lights.len() as u64, &bench.run)
            }),
            (Size::Threads, Device::Cpu(cpu)) => {
                let most = cpu.pool.current_num_threads();
                let powers = (0..).map(|power| 1usize << power).take_while(|&threads| threads < most);
                powers.chain([most]).try_for_each(|threads| {
                    let options = DeviceOptions { threads: Some(threads), ..bench.run.device.clone() };
                    self.point(&machine::open(&options)?, scene, threads as u64, &bench.run)
                })
            }
        }
    }

    /// Builds the hierarchy of a scene as often as repeats are asked for, and once before.
    fn build(&mut self, device: &Device, scene: &Scene) -> Result<()> {
        let Some(kind) = device.kernel(&self.run.device).bvh_kind() else { return Ok(()) };
        let (mut clock, mut samples) = (Clock::of_processor(), Vec::new());
        forget_peak();
        for round in 0..=self.run.repeats {
            device.install(|| clock.time(|| bvh::build(scene, kind)).map(drop))?;
            samples.extend((round > 0).then_some(clock.last().elapsed_ns));
        }
        let n = scene.triangles.len() as u64;
        self.add(scene, n, "hierarchy", "ns", samples);
        self.add_peak(scene, n, "memory to build");
        Ok(())
    }

    /// Passes over a scene; n is the number of their rays where that is what grows.
    fn point(&mut self, device: &Device, scene: &Scene, n: u64, run: &RecordOptions) -> Result<()> {
        let setup = prepared(device, scene, run)?;
        let kernel = device.kernel(&run.device);
        let passes = backends::measure(device, scene, &setup, kernel, Passes { run })?;
        let n = if self.size == Size::Rays { passes.rays } else { n };
        say(format_args!("{}, {}: {n}", scene.name, typed(&self.size)));
        for (stage, samples) in passes.stages_ns {
            self.add(scene, n, stage.name(), "ns", samples);
        }
        self.add_peak(scene, n, "memory to trace");
        Ok(())
    }

    fn add_peak(&mut self, scene: &Scene, n: u64, cost: &str) {
        if let Some(peak) = peak_bytes() {
            self.add(scene, n, cost, "bytes", vec![peak.saturating_sub(self.base)]);
        }
    }

    /// Adds a point to the row of a cost, and the row if there is none.
    fn add(&mut self, scene: &Scene, n: u64, cost: &str, unit: &str, samples: Vec<u64>) {
        let point = GrowthPoint { n, samples };
        match self.rows.iter_mut().find(|row| row.scene == scene.name && row.cost == cost) {
            Some(row) => row.points.push(point),
            None => self.rows.push(GrowthRow {
                scene: scene.name.clone(),
                against: typed(&self.size),
                cost: cost.to_owned(),
                unit: unit.to_owned(),
                points: vec![point],
            }),
        }
    }
}

/// What passes took.
struct Took {
    /// A sample of each stage per pass.
    stages_ns: BTreeMap<Stage, Vec<u64>>,
    /// Rays of the last pass.
    rays: u64,
}

struct Passes<'a> {
    run: &'a RecordOptions,
}

impl OnBackend for Passes<'_> {
    type Output = Took;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Took> {
        let mut took = Took { stages_ns: BTreeMap::new(), rays: 0 };
        // What building or reading the hierarchy took is another cost.
        forget_peak();
        for round in 0..=self.run.repeats {
            let mut pass = Pass::default();
            wavefront::run(backend, 0..1, self.run.bounces, &mut pass)?;
            took.rays = pass.rays;
            if round > 0 {
                for (stage, ns) in pass.stages_ns {
                    took.stages_ns.entry(stage).or_default().push(ns);
                }
            }
        }
        Ok(took)
    }
}

/// Adds up the stages of a pass.
#[derive(Default)]
struct Pass {
    stages_ns: BTreeMap<Stage, u64>,
    rays: u64,
}

impl Pass {
    fn add<B: Backend>(&mut self, backend: &B, stage: Stage) {
        *self.stages_ns.entry(stage).or_default() += backend.elapsed_ns();
    }
}

impl<B: Backend> Observer<B> for Pass {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        self.add(backend, Stage::Trace);
        self.rays += rays.len() as u64;
        let keys = backend.key(rays, Some(hits), 0)?;
        self.add(backend, Stage::Key);
        let permutation = backend.sort(&keys)?;
        self.add(backend, Stage::Sort);
        backend.gather(rays, &permutation)?;
        self.add(backend, Stage::Gather);
        backend.accumulate(rays, hits, Table::Scratch)?;
        self.add(backend, Stage::Accumulate);
        Ok(())
    }

    fn ran(&mut self, backend: &B, stage: Stage, _: &B::Rays) -> Result<()> {
        self.add(backend, stage);
        Ok(())
    }
}

/// The scene with so many small sphere lights more, spread over its box at random, as bright together as one.
fn with_lights(scene: &Scene, count: u32) -> Scene {
    let (bounds, mut random) = (scene.bounds(), fastrand::Rng::with_seed(0));
    let extent = bounds.extent();
    let radius = 1e-3 * extent.into_iter().fold(0.0, f32::max);
    let sphere = |_| Light::Sphere {
        position: [0, 1, 2].map(|axis| bounds.min[axis] + random.f32() * extent[axis]),
        radius,
        intensity: [100.0 / count as f32; 3],
    };
    let mut lights: Vec<Light> = (0..count).map(sphere).collect();
    lights.extend(scene.lights.iter().cloned());
    Scene { lights, ..scene.clone() }
}

/// Lets the system count the most memory of this process from now on; where it cannot, peaks are those of all
/// sizes up to now.
fn forget_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The most memory that this process had, bytes; `None` where the system does not say.
fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}
