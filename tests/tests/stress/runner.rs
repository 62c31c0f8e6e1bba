//! One runner for all cases: every kernel of every backend traces a case's rays, and the oracle judges.

use std::sync::OnceLock;

use formats::ray::{Hit, Kind, Ray};
use rayon::prelude::*;
use recorder::device::{AdapterRequest, Gpu};
use recorder::machine::GpuDevice;
use recorder::oracle::{Oracle, Verdict};
use recorder::stages::trace::cpu::CpuTracer;
use recorder::stages::trace::gpu::{Hits, RayArrays, Tracer};
use recorder::stages::trace::{Order, TraceKernel, hits as cpu_hits};
use scenes::Scene;
use scenes::bvh::build;
use scenes::features::Features;
use tests::drivers::skipped;

/// A scene, rays, and what is promised of them.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) rays: Vec<Ray>,
    pub(crate) promise: Promise,
    /// The GPU traces this many of the rays, and the oracle judges as many.
    pub(crate) sample: usize,
}

/// What must be true of every ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Promise {
    /// It hits something: it starts inside a closed surface.
    Closed,
    /// Nothing beyond what the oracle says.
    AsTheOracleSays,
}

impl Case {
    pub(crate) fn closed(name: impl Into<String>, scene: Scene, rays: Vec<Ray>) -> Self {
        let sample = rays.len();
        Self { name: name.into(), scene, rays, promise: Promise::Closed, sample }
    }

    pub(crate) fn open(name: impl Into<String>, scene: Scene, rays: Vec<Ray>) -> Self {
        Self { promise: Promise::AsTheOracleSays, ..Self::closed(name, scene, rays) }
    }

    pub(crate) fn sample(self, sample: usize) -> Self {
        Self { sample, ..self }
    }
}

/// What traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Backend {
    Cpu,
    Gpu,
}

/// The device that all cases share, with ray queries where the adapter has them.
pub(crate) fn gpu() -> &'static GpuDevice {
    static GPU: OnceLock<GpuDevice> = OnceLock::new();
    GPU.get_or_init(|| {
        let gpu = Gpu::open_with_ray_query(&AdapterRequest::Any)
            .or_else(|_| Gpu::open(&AdapterRequest::Any))
            .unwrap_or_else(|error| panic!("GPU tests need an adapter; tests/run installs one: {error}"));
        GpuDevice::checked(gpu).unwrap()
    })
}

/// Every kernel on every backend that has it.
pub(crate) fn kernels() -> Vec<(Backend, TraceKernel)> {
    let own = [TraceKernel::Cwbvh, TraceKernel::Bvh2];
    let for_threads = [TraceKernel::Wide, TraceKernel::Lanes, TraceKernel::Packet];
    let mut all: Vec<_> = for_threads.map(|kernel| (Backend::Cpu, kernel)).into();
    all.extend(own.map(|kernel| (Backend::Cpu, kernel)));
    all.extend(own.map(|kernel| (Backend::Gpu, kernel)));
    if gpu().gpu.adapter().ray_query {
        all.push((Backend::Gpu, TraceKernel::RayQuery));
    } else {
        skipped("ray-query against the oracle", "the adapter has no ray queries");
    }
    all
}

/// What one kernel answered.
pub(crate) struct Answers {
    pub(crate) name: String,
    pub(crate) hits: Vec<Hit>,
    pub(crate) distances: Vec<f32>,
}

/// Traces rays, as closest and as shadow rays.
pub(crate) fn trace(backend: Backend, kernel: TraceKernel, scene: &Scene, rays: &[Ray]) -> Answers {
    let bvh = kernel.bvh_kind().map(|kind| build(scene, kind).unwrap());
    let name = match backend {
        Backend::Cpu => format!("{} on threads", kernel.name()),
        Backend::Gpu => format!("{} on the gpu", kernel.name()),
    };
    let kinds = Kind::ALL;
    let [hits, distances]: [Vec<u8>; 2] = match backend {
        Backend::Cpu => {
            let tracer = CpuTracer::new(scene, &bvh.unwrap()).with_kernel(kernel);
            kinds.map(|kind| {
                let hits = cpu_hits::Hits::new(kind, rays.len());
                tracer.trace(rays, Order::Stored, &hits);
                hits.bytes(0..rays.len())
            })
        }
        Backend::Gpu => {
            let gpu = &gpu().gpu;
            let features = Features::of(scene);
            let mut tracer = Tracer::new(gpu, scene, bvh.as_ref(), kernel, &features).unwrap();
            let uploaded = RayArrays::upload(gpu, "stress", rays).unwrap();
            kinds.map(|kind| {
                let hits = Hits::new(gpu, "stress::hits", kind, rays.len()).unwrap();
                tracer.trace(gpu, &uploaded, Order::Stored, &hits).unwrap();
                bytemuck::cast_slice(&gpu.read_vec(&hits.words).unwrap()).to_vec()
            })
        }
    };
    let (hits, distances) = (bytemuck::pod_collect_to_vec(&hits), bytemuck::pod_collect_to_vec(&distances));
    Answers { name, hits, distances }
}

/// What came of a kernel's answers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) rays: usize,
    /// Rays that hit nothing.
    pub(crate) escaped: usize,
    pub(crate) tied: usize,
    pub(crate) missed: usize,
    pub(crate) wrong: usize,
    pub(crate) false_hits: usize,
    /// The same of shadow rays: missed or falsely hit.
    pub(crate) wrong_shadows: usize,
    /// Largest error of a distance, in ulps of the coordinate scale.
    pub(crate) worst_ulps: f64,
    /// Distances beyond the tolerance.
    pub(crate) far_off: usize,
    /// A ray that something is wrong with.
    pub(crate) example: Option<String>,
}

impl Tally {
    fn joined(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            escaped: self.escaped + other.escaped,
            tied: self.tied + other.tied,
            missed: self.missed + other.missed,
            wrong: self.wrong + other.wrong,
            false_hits: self.false_hits + other.false_hits,
            wrong_shadows: self.wrong_shadows + other.wrong_shadows,
            worst_ulps: self.worst_ulps.max(other.worst_ulps),
            far_off: self.far_off + other.far_off,
            example: self.example.or(other.example),
        }
    }

    fn of_ray(oracle: &Oracle, ray: &Ray, hit: &Hit, distance: f32) -> Self {
        let judgement = oracle.judge(ray, hit);
        let shadow = oracle.judge_occlusion(ray, distance);
        let is = |verdict| usize::from(judgement.verdict == verdict);
        let deviation = judgement.t;
        let mut tally = Self {
            rays: 1,
            escaped: 0,
            tied: is(Verdict::Tied),
            missed: is(Verdict::Missed),
            wrong: is(Verdict::WrongTriangle),
            false_hits: is(Verdict::FalseHit),
            wrong_shadows: usize::from(!shadow.verdict.is_right()),
            worst_ulps: deviation.map_or(0.0, |t| t.ulps),
            far_off: deviation.map_or(0, |t| usize::from(t.ulps > t.tolerance_ulps)),
            example: None,
        };
        if tally.faults() > 0 {
            let exact = oracle.closest(ray);
            tally.example = Some(format!(
                "{ray:?}: {hit:?} {judgement:?}, exactly {exact:?}; shadow {distance} {shadow:?}"
            ));
        }
        tally
    }

    /// Everything that must not be.
    pub(crate) fn faults(&self) -> usize {
        self.missed + self.wrong + self.false_hits + self.wrong_shadows + self.far_off
    }
}

fn escaped(hit: &Hit, distance: f32) -> bool {
    !hit.is_hit() || distance == f32::INFINITY
}

/// Whether products with a component are denormal: where those are 0, another of two triangles at an edge may be hit.
fn underflows(ray: &Ray) -> bool {
    ray.direction
        .iter()
        .any(|component| (f32::MIN_POSITIVE..1e-25).contains(&component.abs()) || component.is_subnormal())
}

/// Runs a case on everything. Own kernels must do no wrong, and find the same with any hierarchy and
/// the backend; of ray queries it is counted and shown.
pub(crate) fn run(case: &Case) {
    let oracle = Oracle::new(&case.scene);
    let mut expected: Option<Vec<Hit>> = None;
    for (backend, kernel) in kernels() {
        let count = if backend == Backend::Cpu { case.rays.len() } else { case.sample.min(case.rays.len()) };
        let rays = &case.rays[..count];
        let answers = trace(backend, kernel, &case.scene, rays);
        let judged = case.sample.min(count);
        let judge = |index: usize| {
            Tally::of_ray(&oracle, &rays[index], &answers.hits[index], answers.distances[index])
        };
        let mut tally = (0..judged).into_par_iter().map(judge).reduce(Tally::default, Tally::joined);
        let escapes = |index: &usize| escaped(&answers.hits[*index], answers.distances[*index]);
        let escaping: Vec<usize> = (0..count).filter(escapes).collect();
        tally.escaped = escaping.len();
        println!(
            "{:44} {:20} {count:8} rays, {judged:7} judged: {:7} escaped {:7} tied {:5} missed {:5} wrong {:5} false {:5} shadows {:5} far off, {:.1} ulps",
            case.name,
            answers.name,
            tally.escaped,
            tally.tied,
            tally.missed,
            tally.wrong,
            tally.false_hits,
            tally.wrong_shadows,
            tally.far_off,
            tally.worst_ulps
        );
        if kernel == TraceKernel::RayQuery {
            continue;
        }
        if case.promise == Promise::Closed {
            let first = escaping.first().map(|&index| rays[index]);
            assert_eq!(tally.escaped, 0, "{}, {}: rays escaped, first {first:?}", case.name, answers.name);
        }
        assert_eq!(tally.faults(), 0, "{}, {}: {:?}", case.name, answers.name, tally.example);
        let expected = expected.get_or_insert_with(|| answers.hits.clone());
        let flushes = backend == Backend::Gpu && gpu().self_check.flushes_denormals;
        let other = (0..count)
            .filter(|&index| !(flushes && underflows(&rays[index])))
            .find(|&index| answers.hits[index] != expected[index]);
        let other = other.map(|index| (rays[index], answers.hits[index], expected[index]));
        assert!(other.is_none(), "{}, {} finds something else: {other:?}", case.name, answers.name);
    }
}
