//! A recording from options to a finished dump: scene, device, loop, files.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use formats::manifest::{
    Backend as BackendName, CameraPose, End, Features as FeatureNames, Header, ImageDigest, MethodRecord,
    Options, Outcome, Place as ArrayPlace, SceneArray, SceneSummary, Source,
};
use formats::npy::MaterialMask;
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;
use scenes::features::Features;
use scenes::{Camera, Scene};
use sha2::{Digest, Sha256};

use crate::backend::{Backend, MethodPlan, Setup};
use crate::capture::Capture;
use crate::cpu::CpuBackend;
use crate::device::{self, Device};
use crate::gpu::Gpu;
use crate::gpu::backend::GpuBackend;
use crate::observer::{MeasuredQueue, Plan, Recorder};
use crate::options::RecordOptions;
use crate::progress::Progress;
use crate::stages::shade::tables::ShadeTables;
use crate::stages::trace::TraceKernel;
use crate::stages::trace::cpu::CpuTracer;
use crate::wavefront;

/// A finished recording.
pub struct Recorded {
    /// The dump.
    pub path: PathBuf,
    /// Scene, adapter and settings in a line each.
    pub headline: Vec<String>,
    /// Methods, in order.
    pub methods: Vec<MethodPlan>,
    /// Every queue of the measured pass.
    pub queues: Vec<MeasuredQueue>,
    /// Things the user should know.
    pub notices: Vec<String>,
}

impl Recorded {
    /// The summary of the dump as JSON.
    ///
    /// # Errors
    /// If the dump cannot be read back.
    pub fn json(&self) -> Result<String> {
        let dump = formats::reader::Dump::open(&self.path)?;
        Ok(serde_json::to_string_pretty(&formats::summary::Summary::new(&self.path, dump.manifest()))?)
    }
}

/// Records a scene.
///
/// # Errors
/// One sentence on what went wrong with scene, device or disk.
pub fn record(options: &RecordOptions) -> Result<Recorded> {
    let start = Instant::now();
    DumpWriter::check(&options.out, options.force)?;
    let scene = scenes::load(&options.scene)?;
    let camera = choose_camera(&scene, options.camera.as_deref())?;
    let device = device::open(options)?;
    let setup = Arc::new(setup(&scene, &camera, options)?);
    device.check_capacity(&setup, &scene, options)?;
    let mut notices = scene.notices.clone();
    notices.extend(device.notices());
    let header = header(&scene, &setup, options, &device, &notices);
    let run = Run { plan: plan(&setup, options), scene: &scene, setup: &setup, options, header, start };
    let headline = headline(&run.header, &setup);
    // The backend comes first: what does not fit a device is refused before anything is written.
    let (path, queues) = match device {
        Device::Cpu(cpu) => cpu.pool.install(|| run.on(&mut cpu_backend(&scene, &setup, options)?))?,
        Device::Gpu(gpu) => run.on(&mut gpu_backend(gpu.gpu, &scene, &setup, options)?)?,
    };
    Ok(Recorded { path, headline, methods: setup.methods.clone(), queues, notices })
}

fn plan(setup: &Setup, options: &RecordOptions) -> Plan {
    Plan {
        methods: setup.methods.clone(),
        passes: options.passes,
        repeats: options.repeats,
        keep: options.keep,
        keep_passes: options.keep_passes,
        tolerates_mismatches: options.trace == TraceKernel::RayQuery,
        counts_work: options.trace != TraceKernel::RayQuery,
    }
}

/// Everything of a recording but the device.
struct Run<'a> {
    plan: Plan,
    scene: &'a Scene,
    setup: &'a Setup,
    options: &'a RecordOptions,
    header: Header,
    start: Instant,
}

impl Run<'_> {
    /// Records on a backend; returns the dump and what was measured.
    fn on<B: Backend>(&self, backend: &mut B) -> Result<(PathBuf, Vec<MeasuredQueue>)> {
        let options = self.options;
        let writer = DumpWriter::create(&options.out, self.header.clone(), options.force)?;
        let mut capture = Capture::start(writer)?;
        write_scene(&mut capture, self.scene, options)?;
        for method in &self.setup.methods {
            capture.method(method_record(method))?;
        }
        let progress = self.progress();
        let mut recorder = Recorder::new(&self.plan, &mut capture, &progress);
        wavefront::run(backend, options.passes, options.bounces, &mut recorder)?;
        recorder.finish(backend)?;
        let measured = recorder.measured;
        progress.finish();
        let image = self.write_image(backend, &mut capture)?;
        let wall_ns = self.start.elapsed().as_nanos() as u64;
        let path = capture.finish(End { outcome: Outcome::Complete, image: Some(image), wall_ns })?;
        Ok((path, measured))
    }

    fn progress(&self) -> Progress {
        let pixels = u64::from(self.setup.width) * u64::from(self.setup.height);
        let repeats = u64::from(self.options.repeats);
        let traces = repeats + self.setup.methods.len() as u64 * (2 + 2 * repeats);
        Progress::new(self.options.passes, self.options.bounces, pixels, traces)
    }

    fn write_image<B: Backend>(&self, backend: &mut B, capture: &mut Capture) -> Result<ImageDigest> {
        let image = backend.image(self.options.passes)?;
        let (width, height) = (self.setup.width, self.setup.height);
        let digest = Sha256::digest(bytemuck::cast_slice::<_, u8>(&image));
        if self.options.keep.image {
            capture.whole_array(ArrayPlace::Image, &[height.into(), width.into(), 3], &image)?;
        }
        Ok(ImageDigest { width, height, sha256: digest.into() })
    }
}

fn cpu_backend(scene: &Scene, setup: &Arc<Setup>, options: &RecordOptions) -> Result<CpuBackend> {
    let bvh = device::hierarchy(scene, options.trace)?.context("threads trace a hierarchy of their own")?;
    Ok(CpuBackend::new(Arc::clone(setup), CpuTracer::new(scene, &bvh)))
}

fn gpu_backend(gpu: Gpu, scene: &Scene, setup: &Arc<Setup>, options: &RecordOptions) -> Result<GpuBackend> {
    let bvh = device::hierarchy(scene, options.trace)?;
    GpuBackend::new(gpu, scene, bvh.as_ref(), Arc::clone(setup), options.trace)
}

fn choose_camera(scene: &Scene, name: Option<&str>) -> Result<Camera> {
    let Some(name) = name else {
        return scene
            .cameras
            .first()
            .cloned()
            .with_context(|| format!("scene '{}' has no camera", scene.name));
    };
    match scene.cameras.iter().find(|camera| camera.name == name) {
        Some(camera) => Ok(camera.clone()),
        None => {
            let names: Vec<_> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
            bail!("scene '{}' has no camera '{name}'; it has {}", scene.name, names.join(", "))
        }
    }
}

/// What kernels depend on, for a scene seen by one of its cameras.
///
/// # Errors
/// None beyond those of layouts, which options have checked already.
pub fn setup(scene: &Scene, camera: &Camera, options: &RecordOptions) -> Result<Setup> {
    let bounds = scene.bounds();
    let unit = UnitSpace::from_bounds(bounds.min, bounds.max);
    let lights = scene.lights.len();
    let methods = options.methods.iter().map(|method| {
        Ok(MethodPlan {
            name: method.name.clone(),
            base: method.name.clone(),
            text: method.layout.text().to_owned(),
            layout: method.layout.expand(lights)?,
            termination: method.termination,
            key_bits: options.key_bits,
            two_point_length: options.two_point_length,
            for_closest: method.applies_to(formats::ray::Kind::Closest),
        })
    });
    Ok(Setup {
        tables: Arc::new(ShadeTables::new(scene)),
        features: Features::of(scene),
        light_sites: Setup::light_sites(scene, &unit),
        unit,
        camera: camera.clone(),
        width: options.width,
        height: options.height,
        bounces: options.bounces,
        seed: options.seed,
        roulette: options.russian_roulette,
        methods: methods.collect::<Result<_>>()?,
        table_bits: options.table_bits,
        table_layout: options.table_method.layout.expand(lights)?,
    })
}

fn header(
    scene: &Scene,
    setup: &Setup,
    options: &RecordOptions,
    device: &Device,
    notices: &[String],
) -> Header {
    let bounds = scene.bounds();
    let names = |list: Vec<&'static str>| list.into_iter().map(str::to_owned).collect();
    Header {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        options: manifest_options(setup, options, device),
        scene: SceneSummary {
            name: scene.name.clone(),
            content_hash: scenes::hash::content_hash(scene),
            bounds_min: bounds.min,
            bounds_max: bounds.max,
            triangles: scene.triangles.len() as u64,
            vertices: scene.positions.len() as u64,
        },
        camera: CameraPose {
            eye: setup.camera.eye,
            forward: setup.camera.forward,
            right: setup.camera.right,
            up: setup.camera.up,
            yfov_radians: setup.camera.yfov_radians,
        },
        lights: setup.light_sites.clone(),
        backend: device.backend(),
        adapter: device.adapter(),
        limits: device.limits(),
        self_check: device.self_check(),
        ieee_arithmetic: device.ieee_arithmetic(),
        features: FeatureNames {
            used: names(setup.features.used()),
            skipped: names(setup.features.skipped()),
        },
        time_source: device.time_source(),
        notices: notices.to_vec(),
        source: Source::Traced,
    }
}

fn manifest_options(setup: &Setup, options: &RecordOptions, device: &Device) -> Options {
    let names = setup.methods.iter().map(|method| method.name.clone());
    Options {
        width: options.width,
        height: options.height,
        bounces: options.bounces,
        passes: options.passes,
        repeats: options.repeats,
        seed: options.seed,
        camera: setup.camera.name.clone(),
        methods: [formats::key::method::UNSORTED.to_owned()].into_iter().chain(names).collect(),
        key_bits: options.key_bits,
        two_point_length: options.two_point_length,
        table_bits: options.table_bits,
        table_method: options.table_method.name.clone(),
        table_layout: options.table_method.layout.text().to_owned(),
        trace_kernel: options.trace.name().to_owned(),
        threads: device.threads(),
        keep: options.keep.words(),
        keep_passes: if options.keep_passes == crate::options::KeepPasses::All { "all" } else { "measured" }
            .to_owned(),
        russian_roulette: options.russian_roulette,
    }
}

fn method_record(plan: &MethodPlan) -> MethodRecord {
    MethodRecord {
        name: plan.name.clone(),
        text: plan.text.clone(),
        layout: plan.layout.bits().iter().map(|coordinate| coordinate.name().to_owned()).collect(),
        termination: plan.termination,
        key_bits: plan.key_bits,
        base: plan.base.clone(),
        two_point_length: plan.two_point_length,
    }
}

fn headline(header: &Header, setup: &Setup) -> Vec<String> {
    let options = &header.options;
    let backend = if header.backend == BackendName::Cpu {
        format!("cpu, {} threads", options.threads)
    } else {
        "gpu".to_owned()
    };
    vec![
        format!(
            "scene    {} ({} triangles), camera '{}'",
            header.scene.name, header.scene.triangles, options.camera
        ),
        format!("device   {} ({backend}), trace kernel {}", header.adapter.name, options.trace_kernel),
        format!(
            "run      {}×{}, {} bounces, {} passes, {} repeats, {}-bit keys, seed {}",
            setup.width,
            setup.height,
            setup.bounces,
            options.passes,
            options.repeats,
            options.key_bits,
            setup.seed
        ),
        format!("scene uses {}; skipped: {}", list(&header.features.used), list(&header.features.skipped)),
    ]
}

fn list(words: &[String]) -> String {
    if words.is_empty() { "nothing special".to_owned() } else { words.join(", ") }
}

/// Geometry for the inspector and for replays, with alpha masks where a material has one.
fn write_scene(capture: &mut Capture, scene: &Scene, options: &RecordOptions) -> Result<()> {
    if !options.keep.scene {
        return Ok(());
    }
    let place = ArrayPlace::Scene;
    let (vertices, triangles) = (scene.positions.len() as u64, scene.triangles.len() as u64);
    capture.whole_array(place(SceneArray::Positions), &[vertices, 3], &scene.positions)?;
    capture.whole_array(place(SceneArray::Triangles), &[triangles, 3], &scene.triangles)?;
    capture.whole_array(place(SceneArray::Materials), &[triangles], &scene.triangle_materials)?;
    if scene.materials.iter().all(|material| material.alpha_cutoff.is_none()) {
        return Ok(());
    }
    if !scene.uvs.is_empty() {
        capture.whole_array(place(SceneArray::Uvs), &[vertices, 2], &scene.uvs)?;
    }
    let mut textures: Vec<u32> = Vec::new();
    let mut masks = Vec::new();
    for material in &scene.materials {
        let mut mask = MaterialMask { texture: MaterialMask::NO_TEXTURE, cutoff: 0.0 };
        if material.alpha_cutoff.is_some() {
            mask.cutoff = material.alpha_threshold() as f32 / 255.0;
            if let Some(texture) = material.base_color_texture {
                let known = textures.iter().position(|&known| known == texture);
                mask.texture = known.unwrap_or(textures.len()) as u32;
                if known.is_none() {
                    textures.push(texture);
                }
            }
        }
        masks.push(mask);
    }
    capture.whole_array(place(SceneArray::Masks), &[masks.len() as u64], &masks)?;
    for (number, &texture) in (0u32..).zip(&textures) {
        let texture = &scene.textures[texture as usize];
        let alpha: Vec<u8> = texture.rgba.iter().map(|texel| texel[3]).collect();
        let shape = [u64::from(texture.height), u64::from(texture.width)];
        capture.whole_array(place(SceneArray::Mask(number)), &shape, &alpha)?;
    }
    Ok(())
}
