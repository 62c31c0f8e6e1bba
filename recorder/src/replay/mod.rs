//! Measures recorded rays again, without tracing paths: other methods, other bits, another device.
//!
//! - [`variants`]: methods at several key bits, lengths and shares of the origin; [`split`]: layouts with those
//! - [`queues`]: recorded queues, checked
//! - `geometry`: the scene as a recording holds it
//! - [`import`]: rays from any other tracer

mod geometry;
pub mod import;
pub mod queues;
pub mod split;
pub mod variants;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use formats::key::method::{AUTO, CONTROL, SHUFFLED};
use formats::key::{LayoutText, Method};
use formats::manifest::check::ALL_PASSES;
use formats::manifest::{CalibrationRecord, FORMAT_VERSION, Header, Manifest, MethodRecord, Source};
use formats::reader::{Dump, DumpState};
use formats::text::one_line;
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;
use scenes::Camera;

use crate::auto::candidates;
use crate::foreign::Foreign;
use crate::machine::description::Description;
use crate::machine::{self, Device};
use crate::options::{AskedOrders, BackendChoice, DeviceOptions, Keep, KeepPasses, RecordOptions};
use crate::recording::{RaySource, Recorded, Run, header, without_methods};
use crate::stages::trace::TraceKernel;
use queues::RecordedQueue;
use variants::Sweep;

/// Everything that `recorder replay` was asked for; what is not given is as it was recorded.
#[derive(Clone, Debug)]
pub struct ReplayOptions {
    /// The recording.
    pub source: PathBuf,
    /// Where the new one goes.
    pub out: PathBuf,
    /// What to measure.
    pub orders: Option<AskedOrders>,
    /// Key bits, lengths and shares of the origin.
    pub sweep: Sweep,
    /// Address bits of the length tables.
    pub table_bits: Option<u32>,
    /// Method that addresses them.
    pub table_method: Option<Method>,
    /// Timed repeats.
    pub repeats: Option<u32>,
    /// Where and how to trace; with what was recorded if it names no kernel.
    pub device: DeviceOptions,
    /// Arrays to keep: keys, permutations, work, caches.
    pub keep: Keep,
    /// Whether an existing recording may be replaced.
    pub force: bool,
}

/// Measures the rays of a recording again.
///
/// # Errors
/// One sentence on what went wrong with the recording, device or disk.
pub fn replay(options: &ReplayOptions) -> Result<Recorded> {
    let start = Instant::now();
    let asked = Dump::open(&options.source)?;
    let dump = match (&asked.manifest().header.source, asked.source()) {
        (Source::Replayed { name, .. }, None) => bail!(
            "{} is a replay of {1}, which is not in the same folder, or is another recording by now; replay {1} itself",
            options.source.display(),
            one_line(name, 80)
        ),
        (_, Some(source)) => source,
        (_, None) => &asked,
    };
    DumpWriter::check(&options.out, options.force, &[asked.root(), dump.root()])?;
    check(&asked, dump)?;
    let recorded = &asked.manifest().header;
    let cannot = || format!("{} cannot be replayed", options.source.display());
    let theirs: Vec<&str> = dump.manifest().foreign_orders().map(|order| order.name.as_str()).collect();
    let ours = asked.manifest().methods.iter().filter(|record| !theirs.contains(&record.name.as_str()));
    let mut run_options =
        run_options(options, recorded, ours, &dump.manifest().header).with_context(cannot)?;
    if let Some(taken) =
        run_options.orders.methods.iter().find(|method| theirs.contains(&method.name.as_str()))
    {
        bail!("the recording has an order '{}' of another tracer; give your layout another name", taken.name);
    }
    run_options.device.check()?;
    // What else was typed was checked before. How many rays there are was settled when they were recorded:
    // imported ones may be more than a picture is wide.
    RecordOptions { width: 1, height: 1, ..run_options.clone() }.check_run().map_err(|error| {
        anyhow!("{} was recorded with what no recorder takes: {error}", options.source.display())
    })?;
    let queues = queues::open(dump, !run_options.keep.lengths)?;
    let scene = geometry::scene(dump).with_context(cannot)?;
    let camera = camera(recorded);
    let device = open(options, &mut run_options.device)?;
    let unit = UnitSpace::from_bounds(recorded.scene.bounds_min, recorded.scene.bounds_max);
    let mut setup = without_methods(&scene, &camera, &run_options, unit, recorded.lights.clone())?;
    let (bits, length) = (recorded.options.key_bits, recorded.options.two_point_length);
    setup.methods = options.sweep.plans(&run_options.orders.methods, setup.extent(), bits, length)?;
    let calibration = calibration(asked.manifest(), &device, &run_options);
    if run_options.orders.auto {
        let (extent, length) = (setup.extent(), run_options.two_point_length);
        setup = setup.with_candidates(candidates(device.backend(), calibration, extent, length)?);
    }
    let setup = Arc::new(setup);
    device.check_capacity(&setup, &scene)?;
    let mut notices: Vec<String> = device.notices();
    notices.extend(apart(dump.root(), &options.out)?);
    let foreign = Foreign::recorded(dump, setup.extent(), &mut notices).with_context(cannot)?;
    let source =
        Source::Replayed { name: folder_name(dump.root())?, manifest_sha256: dump.manifest_sha256()? };
    let mut header = Header {
        scene: recorded.scene.clone(),
        camera: recorded.camera,
        features: recorded.features.clone(),
        ..header(&scene, &setup, &run_options, &device, notices, source)
    };
    header.options.methods.extend(foreign.methods.iter().map(|method| method.name.clone()));
    let run = Run {
        scene: &scene,
        setup,
        options: &run_options,
        kernel: device.kernel(&run_options.device),
        header,
        rays: RaySource::Recorded(queues.iter().map(RecordedQueue::rays).collect()),
        foreign,
        recorded: Some(dump),
        calibration: calibration.to_vec(),
        start,
    };
    run.on(device)
}

/// Opens the device of a run. Ray queries that were recorded, and not asked for now, are done without where there is no
/// such device, which then traces by a kernel of its own.
fn open(asked: &ReplayOptions, run: &mut DeviceOptions) -> Result<Device> {
    match machine::open(run) {
        Err(_) if run.trace == Some(TraceKernel::RayQuery) && asked.device.trace.is_none() => {
            run.trace = None;
            machine::open(run)
        }
        device => device,
    }
}

/// Refuses a recording that is not finished, or says what no recorder writes.
fn check(asked: &Dump, source: &Dump) -> Result<()> {
    if source.state() == DumpState::Partial {
        bail!(
            "{} is not finished; wait for its recorder, or run `inspector recover` on it",
            source.root().display()
        );
    }
    for read in [asked, source] {
        if let Some(problem) = read.manifest().header.problems().first() {
            bail!("{} cannot be replayed: {problem}; run `inspector verify` on it", read.root().display());
        }
    }
    Ok(())
}

/// What a recording knows about orders, if it was made as this run is: on the same device, by the same kernel, and
/// by this version, since others time, try and choose other things.
fn calibration<'a>(
    recorded: &'a Manifest,
    device: &Device,
    options: &RecordOptions,
) -> &'a [CalibrationRecord] {
    let (header, kernel) = (&recorded.header, device.kernel(&options.device));
    let description = Description::of(device);
    let is_same = recorded.version == FORMAT_VERSION
        && header.adapter == description.adapter
        && header.options.threads == description.threads
        && header.options.trace_kernel == kernel.name()
        && header.options.two_point_length == options.two_point_length;
    if is_same { &recorded.calibration } else { &[] }
}

/// The options of a run over what was recorded in `source`, by default those of `recorded`.
fn run_options<'a>(
    options: &ReplayOptions,
    recorded: &Header,
    methods: impl Iterator<Item = &'a MethodRecord>,
    source: &Header,
) -> Result<RecordOptions> {
    let before = &recorded.options;
    let has = |name: &str| before.methods.iter().any(|method| method == name);
    let orders = match &options.orders {
        Some(orders) => orders.clone(),
        None => AskedOrders {
            methods: recorded_methods(methods)?,
            control: has(CONTROL),
            shuffled: has(SHUFFLED),
            auto: has(AUTO),
        },
    };
    let table_method = match &options.table_method {
        Some(method) => method.clone(),
        None => Method {
            layout: LayoutText::parse(&before.table_layout)?,
            ..Method::builtin(&before.table_method)?
        },
    };
    let recorded_kernel = TraceKernel::from_str(&before.trace_kernel, false).ok().with_context(|| {
        format!("it names an unknown trace kernel '{}'", one_line(&before.trace_kernel, 80))
    })?;
    // `wide` is what threads take by themselves, GPUs have no kernel for threads, and threads no ray queries.
    let is_missing = |kernel: TraceKernel| match kernel {
        TraceKernel::RayQuery => options.device.backend == BackendChoice::Cpu,
        _ => options.device.asks_for_gpu() && !kernel.is_for_gpus(),
    };
    let recorded_kernel =
        Some(recorded_kernel).filter(|&kernel| kernel != TraceKernel::Wide && !is_missing(kernel));
    let trace = options.device.trace.or(recorded_kernel);
    let mut keep = options.keep;
    let table_bits = options.table_bits.unwrap_or(before.table_bits);
    // Tables of other addresses are made anew, and belong to what differs.
    keep.lengths =
        table_bits != source.options.table_bits || table_method.layout.text() != source.options.table_layout;
    Ok(RecordOptions {
        scene: recorded.scene.name.clone(),
        out: options.out.clone(),
        width: before.width,
        height: before.height,
        bounces: before.bounces,
        passes: before.passes,
        repeats: options.repeats.unwrap_or(before.repeats),
        seed: before.seed,
        light_radius: None,
        camera: Some(before.camera.clone()),
        orders,
        key_bits: options.sweep.key_bits.first().copied().unwrap_or(before.key_bits),
        two_point_length: options.sweep.lengths.first().copied().unwrap_or(before.two_point_length),
        table_bits,
        table_method,
        device: DeviceOptions { trace, ..options.device.clone() },
        keep,
        keep_passes: if before.keep_passes == ALL_PASSES { KeepPasses::All } else { KeepPasses::Measured },
        russian_roulette: before.russian_roulette,
        force: options.force,
    })
}

/// The methods of a recording, without the variants of a sweep.
fn recorded_methods<'a>(records: impl Iterator<Item = &'a MethodRecord>) -> Result<Vec<Method>> {
    let mut methods: Vec<Method> = Vec::new();
    for record in records {
        if methods.iter().any(|method| method.name == record.base) {
            continue;
        }
        let built_in = Method::builtin(&record.base).ok();
        let is_variant = record.name != record.base;
        methods.push(match built_in.filter(|method| is_variant || method.layout.text() == record.text) {
            Some(method) => method,
            None => Method {
                name: record.base.clone(),
                layout: LayoutText::parse(&record.text)?,
                termination: record.termination,
            },
        });
    }
    Ok(methods)
}

fn camera(recorded: &Header) -> Camera {
    let pose = &recorded.camera;
    Camera {
        name: recorded.options.camera.clone(),
        eye: pose.eye,
        forward: pose.forward,
        right: pose.right,
        up: pose.up,
        yfov_radians: pose.yfov_radians,
    }
}

/// A word about a source that readers of the replay will not find.
fn apart(source: &Path, out: &Path) -> Result<Option<String>> {
    let folder = |path: &Path| std::path::absolute(path).map(|path| path.parent().map(Path::to_owned));
    let of_source = folder(&std::fs::canonicalize(source)?)?;
    let of_out = folder(out)?.and_then(|folder| std::fs::canonicalize(folder).ok());
    Ok((of_source != of_out).then(|| {
        format!(
            "{} lies in another folder; put it beside the replay, where readers look for it",
            source.display()
        )
    }))
}

/// The name of a recording's folder, by which a replay finds it: its own, not that of a link to it.
fn folder_name(path: &Path) -> Result<String> {
    let path = std::fs::canonicalize(path)?;
    let name = path.file_name().and_then(|name| name.to_str()).map(str::to_owned);
    name.with_context(|| format!("the name of {} is not UTF-8; rename it", path.display()))
}
