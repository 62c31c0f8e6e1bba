//! A recording from options to a finished dump: scene, device, loop, files.

mod header;
mod run;
mod scene_arrays;

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use formats::key::{Extent, LightSite};
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;
use scenes::features::Features;
use scenes::{Camera, Scene};

pub(crate) use header::header;
pub use run::Recorded;
pub(crate) use run::{RaySource, Run};

use crate::auto::candidates;
use crate::machine::{self, Device};
use crate::options::RecordOptions;
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::shade::tables::ShadeTables;
use crate::stages::trace::Precision;

/// Records a scene.
///
/// # Errors
/// One sentence on what went wrong with scene, device or disk.
pub fn record(options: &RecordOptions) -> Result<Recorded> {
    let start = Instant::now();
    DumpWriter::check(&options.out, options.force, &[])?;
    let mut scene = scenes::load(&options.scene)?;
    if let Some(radius) = options.light_radius {
        scene.give_points_a_radius(radius);
    }
    let device = machine::open(&options.device)?;
    let setup = prepared(&device, &scene, options)?;
    let mut notices = scene.notices.clone();
    notices.extend(device.notices());
    Run::of_paths(&device, &scene, setup, options, notices, start).on(device)
}

/// The camera of this name, be it a view chosen automatically, or the first.
///
/// # Errors
/// If there is none.
pub(crate) fn choose_camera(scene: &Scene, name: Option<&str>) -> Result<Camera> {
    let Some(name) = name else {
        let first = scene.cameras.first().cloned();
        return first.with_context(|| format!("scene '{}' has no camera", scene.name));
    };
    if let Some(camera) = scene.cameras.iter().find(|camera| camera.name == name) {
        return Ok(camera.clone());
    }
    if let Some(view) = scenes::views::view(scene, name) {
        return view.with_context(|| format!("no camera can be made for scene '{}'", scene.name));
    }
    // One that cannot be used was left out, and said why.
    let why = format!("the camera \"{name}\" ");
    if let Some(notice) = scene.notices.iter().find(|notice| notice.starts_with(&why)) {
        bail!("{notice}");
    }
    let names: Vec<_> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    bail!(
        "scene '{}' has no camera '{name}'; it has {}, and views chosen automatically: auto, auto-2 to auto-{}",
        scene.name,
        names.join(", "),
        scenes::views::VIEWS_MAX
    )
}

/// What kernels depend on, for a scene that fits the device, seen by the camera that was asked for.
///
/// # Errors
/// If there is no such camera, it does not fit, or a layout needs a picture and the rays have none.
pub(crate) fn prepared(device: &Device, scene: &Scene, options: &RecordOptions) -> Result<Arc<Setup>> {
    let camera = choose_camera(scene, options.camera.as_deref())?;
    let mut setup = setup(scene, &camera, options)?;
    if options.orders.auto {
        let (extent, length) = (setup.extent(), options.two_point_length);
        setup = setup.with_candidates(candidates(device.backend(), &[], extent, length)?);
    }
    let setup = Arc::new(setup);
    device.check_capacity(&setup, scene)?;
    Ok(setup)
}

/// What kernels depend on, for a scene seen by one of its cameras.
///
/// # Errors
/// If a layout needs a picture, and the rays have none; options have checked the rest.
pub fn setup(scene: &Scene, camera: &Camera, options: &RecordOptions) -> Result<Setup> {
    let bounds = scene.bounds();
    let unit = UnitSpace::from_bounds(bounds.min, bounds.max);
    let setup = without_methods(scene, camera, options, unit, Setup::light_sites(scene, &unit))?;
    let extent = setup.extent();
    let plan = |method| MethodPlan::new(method, extent, options.key_bits, options.two_point_length);
    let methods = options.orders.methods.iter().map(plan).collect::<Result<_, _>>()?;
    Ok(Setup { methods, ..setup })
}

/// What kernels depend on, without methods. Unit space and lights are given, since recordings have no arrays of
/// lights: a replay takes both from the header.
///
/// # Errors
/// None: options have checked the table's method.
pub(crate) fn without_methods(
    scene: &Scene,
    camera: &Camera,
    options: &RecordOptions,
    unit: UnitSpace,
    light_sites: Vec<LightSite>,
) -> Result<Setup> {
    Ok(Setup {
        tables: Arc::new(ShadeTables::new(scene)),
        features: Features::of(scene),
        light_sites,
        unit,
        camera: camera.clone(),
        width: options.width,
        height: options.height,
        bounces: options.bounces,
        seed: options.seed,
        roulette: options.russian_roulette,
        methods: Vec::new(),
        candidates: 0,
        table_bits: options.table_bits,
        table_layout: options.table_method.layout.expand(Extent::NOTHING)?,
        precision: Precision::default(),
    })
}
