//! What the manifest says about a run before its first array.

use std::collections::BTreeSet;

use formats::key::method::{AUTO, CONTROL, SHUFFLED, UNSORTED};
use formats::manifest::{
    Backend, CameraPose, Features as FeatureNames, Header, MethodRecord, Options, SceneSummary, Source,
};
use formats::text::{counted, one_line};
use scenes::Scene;

use crate::machine::Device;
use crate::machine::description::Description;
use crate::options::RecordOptions;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::trace::TraceKernel;

/// Most characters of a name that the closing table shows.
const NAME_CHARACTERS: usize = 120;

/// The header of a run over a scene.
pub(crate) fn header(
    scene: &Scene,
    setup: &Setup,
    options: &RecordOptions,
    device: &Device,
    notices: Vec<String>,
    source: Source,
) -> Header {
    let bounds = scene.bounds();
    let kernel = device.kernel(&options.device);
    let device = Description::of(device);
    let names = |list: Vec<&'static str>| list.into_iter().map(str::to_owned).collect();
    Header {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        options: manifest_options(setup, options, kernel, device.threads),
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
        backend: device.backend,
        adapter: device.adapter,
        limits: device.limits,
        self_check: device.self_check,
        ieee_arithmetic: device.ieee_arithmetic,
        features: FeatureNames {
            used: names(setup.features.used()),
            skipped: names(setup.features.skipped()),
        },
        time_source: device.time_source.to_owned(),
        notices,
        source,
    }
}

fn manifest_options(setup: &Setup, options: &RecordOptions, kernel: TraceKernel, threads: u32) -> Options {
    let orders = &options.orders;
    let asked = [(orders.control, CONTROL), (orders.shuffled, SHUFFLED), (orders.auto, AUTO)];
    let asked = asked.into_iter().filter_map(|(is_asked, name)| is_asked.then_some(name));
    let without_layout = [UNSORTED].into_iter().chain(asked);
    let names = setup.named().iter().map(|method| method.name.clone());
    Options {
        width: options.width,
        height: options.height,
        bounces: options.bounces,
        passes: options.passes,
        repeats: options.repeats,
        seed: options.seed,
        camera: setup.camera.name.clone(),
        methods: without_layout.map(str::to_owned).chain(names).collect(),
        key_bits: options.key_bits,
        two_point_length: options.two_point_length,
        table_bits: options.table_bits,
        table_method: options.table_method.name.clone(),
        table_layout: options.table_method.layout.text().to_owned(),
        trace_kernel: kernel.name().to_owned(),
        threads,
        keep: options.keep.words(),
        keep_passes: options.keep_passes.word().to_owned(),
        russian_roulette: options.russian_roulette,
    }
}

pub(super) fn method_record(plan: &MethodPlan) -> MethodRecord {
    MethodRecord {
        name: plan.name.clone(),
        text: plan.text.clone(),
        layout: plan.layout.names(),
        termination: plan.termination,
        key_bits: plan.key_bits,
        base: plan.base.clone(),
        two_point_length: plan.two_point_length,
    }
}

pub(super) fn headline(header: &Header, setup: &Setup) -> Vec<String> {
    let options = &header.options;
    let backend = if header.backend == Backend::Cpu {
        format!("cpu, {}", counted(options.threads.into(), "thread", "threads"))
    } else {
        "gpu".to_owned()
    };
    vec![
        format!(
            "scene    {} ({} triangles), camera '{}'",
            one_line(&header.scene.name, NAME_CHARACTERS),
            header.scene.triangles,
            one_line(&options.camera, NAME_CHARACTERS)
        ),
        format!("device   {} ({backend}), trace kernel {}", header.adapter.name, options.trace_kernel),
        format!(
            "run      {}×{}, {}, {}, {}, {}-bit keys, seed {}",
            setup.width,
            setup.height,
            counted(setup.bounces.into(), "bounce", "bounces"),
            counted(options.passes.into(), "pass", "passes"),
            counted(options.repeats.into(), "repeat", "repeats"),
            key_bits(setup, options.key_bits),
            setup.seed
        ),
        format!("scene uses {}; it has no {}", list(&header.features.used), list(&header.features.skipped)),
    ]
}

/// The bits of keys of a run, in ascending order; those that were asked for where no method has keys.
fn key_bits(setup: &Setup, asked: u32) -> String {
    let bits: BTreeSet<u32> = setup.named().iter().map(|method| method.key_bits).collect();
    let bits = if bits.is_empty() { [asked].into() } else { bits };
    bits.iter().map(u32::to_string).collect::<Vec<_>>().join("/")
}

fn list(words: &[String]) -> String {
    if words.is_empty() {
        "nothing special".to_owned()
    } else {
        one_line(&words.join(", "), 2 * NAME_CHARACTERS)
    }
}
