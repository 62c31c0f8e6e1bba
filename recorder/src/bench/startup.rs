//! What happens before the first ray: reading a scene, its hierarchy, copies for the device, pipelines.

use anyhow::Result;
use formats::bench_result::skip::StartupRow;
use formats::bench_result::{BenchResult, Rows};
use scenes::Scene;
use scenes::bvh::{self, Bvh};

use super::{Runs, result};
use crate::backends::gpu::kernels::Kernels;
use crate::backends::gpu::scene::SceneArrays;
use crate::clock::Clock;
use crate::device::Gpu;
use crate::machine::{self, Device};
use crate::options::RecordOptions;
use crate::recording::{choose_camera, setup};
use crate::stages::compact::gpu::Scan;
use crate::stages::setup::Setup;
use crate::stages::sort::gpu::Sorter;
use crate::stages::trace::TraceKernel;
use crate::stages::trace::cpu::CpuTracer;
use crate::stages::trace::gpu::Tracer;

/// Starts each scene as often as repeats are asked for, with and without the hierarchy in the cache.
///
/// # Errors
/// One sentence on what went wrong with scene or device.
pub fn run(options: &Runs) -> Result<BenchResult> {
    let mut steps = Steps::new();
    let mut open = || steps.timed("device", || machine::open(&options.run.device));
    let mut device = open()?;
    for _ in 1..options.run.repeats {
        device = open()?;
    }
    let kernel = device.kernel(&options.run.device);
    let mut rows = steps.rows("", 0, kernel);
    for name in &options.scenes {
        let mut steps = Steps::new();
        let mut scene = scenes::load(name)?;
        for _ in 0..options.run.repeats {
            scene = start(&device, name, &options.run, &mut steps)?;
        }
        rows.extend(steps.rows(&scene.name, scene.triangles.len() as u64, kernel));
    }
    Ok(result(&device, Rows::Startup(rows)))
}

/// Samples by step, in the order in which steps were first taken.
struct Steps {
    clock: Clock,
    samples_ns: Vec<(&'static str, Vec<u64>)>,
}

impl Steps {
    fn new() -> Self {
        Self { clock: Clock::of_processor(), samples_ns: Vec::new() }
    }

    fn timed<T>(&mut self, step: &'static str, work: impl FnOnce() -> T) -> T {
        let value = self.clock.time(work);
        let elapsed_ns = self.clock.last().elapsed_ns;
        match self.samples_ns.iter_mut().find(|(known, _)| *known == step) {
            Some((_, samples_ns)) => samples_ns.push(elapsed_ns),
            None => self.samples_ns.push((step, vec![elapsed_ns])),
        }
        value
    }

    fn rows(self, scene: &str, triangles: u64, kernel: TraceKernel) -> Vec<StartupRow> {
        let row = |(step, samples_ns): (&str, Vec<u64>)| StartupRow {
            scene: scene.to_owned(),
            triangles,
            kernel: kernel.name().to_owned(),
            step: step.to_owned(),
            samples_ns,
        };
        self.samples_ns.into_iter().map(row).collect()
    }
}

fn start(device: &Device, name: &str, run: &RecordOptions, steps: &mut Steps) -> Result<Scene> {
    let scene = steps.timed("parse", || scenes::load(name))?;
    let camera = choose_camera(&scene, run.camera.as_deref())?;
    let setup = steps.timed("tables", || setup(&scene, &camera, run))?;
    let mut hierarchy = None;
    let kernel = device.kernel(&run.device);
    if let Some(kind) = kernel.bvh_kind() {
        let built = steps.timed("hierarchy, built", || bvh::build(&scene, kind))?;
        drop(built);
        let folder = bvh::default_cache_folder();
        // Whoever comes first leaves it there for the next.
        bvh::load_or_build(&scene, kind, folder.as_deref())?;
        let cached = || bvh::load_or_build(&scene, kind, folder.as_deref());
        hierarchy = Some(steps.timed("hierarchy, from the cache", cached)?.0);
    }
    match device {
        Device::Cpu(cpu) => {
            let Some(bvh) = &hierarchy else {
                anyhow::bail!("threads have no ray queries; use --backend gpu")
            };
            steps.timed("leaves", || drop(cpu.pool.install(|| CpuTracer::new(&scene, bvh))));
        }
        Device::Gpu(device) => on_gpu(&device.gpu, &scene, &setup, hierarchy.as_ref(), kernel, steps)?,
    }
    Ok(scene)
}

fn on_gpu(
    gpu: &Gpu,
    scene: &Scene,
    setup: &Setup,
    bvh: Option<&Bvh>,
    kernel: TraceKernel,
    steps: &mut Steps,
) -> Result<()> {
    let mut tracer = steps.timed("upload", || -> Result<Tracer> {
        let arrays = SceneArrays::new(gpu, &setup.tables, &setup.features)?;
        let tracer = Tracer::new(gpu, scene, bvh, kernel, &setup.features)?;
        gpu.wait("uploading the scene", None)?;
        drop(arrays);
        Ok(tracer)
    })?;
    steps.timed("pipelines", || -> Result<()> {
        Kernels::new(gpu, setup)?;
        Sorter::new(gpu)?;
        Scan::new(gpu)?;
        tracer.compile(gpu)
    })
}
