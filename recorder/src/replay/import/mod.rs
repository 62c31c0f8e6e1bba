//! Queues that another tracer wrote, traced through a scene and recorded.
//!
//! - `queues`: what came, from a file of rays or a folder of queues
//! - `rays`: the forms that rays are read in
//! - `claims`: what the folder says of its keys
//! - `doubts`: what the rays may have wrong
//! - `verdict`: hits that came with the rays, judged by the oracle

mod claims;
mod doubts;
mod queues;
mod rays;
mod verdict;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use formats::key::LightSite;
use formats::manifest::{Check, Source};
use formats::queue_check::{QueueRays, QueueRules};
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;
use scenes::Scene;

use self::claims::Claims;
use self::queues::{Queue, Queues};
use crate::backends::RecordedRays;
use crate::foreign::Foreign;
use crate::machine;
use crate::options::RecordOptions;
use crate::recording::{RaySource, Recorded, Run, header, prepared};
use crate::stages::setup::Setup;

/// Everything that `recorder import` was asked for.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// Where the rays are.
    pub from: ImportFrom,
    /// Width and height of the picture whose pixels the paths are of, pixels, row by row; one row if it is not known.
    pub size: Option<[u32; 2]>,
    /// The rest; width, height and bounces are made from the above.
    pub run: RecordOptions,
}

/// Where imported rays are.
#[derive(Clone, Debug)]
pub enum ImportFrom {
    /// One queue: an NPY file with rays as recordings hold them, or `<f4` (N, 6) origin and direction, or
    /// `<f4` (N, 8) origin, t_min, direction, t_max.
    Rays {
        /// The file.
        file: PathBuf,
        /// What they ask for.
        kind: Kind,
        /// Their bounce.
        bounce: u32,
    },
    /// A folder of queues: `bounce-BB/KIND/rays.npy` and what belongs to them.
    Queues(PathBuf),
}

/// Traces queues through a scene and records them with all methods, and with the orders that they came with.
///
/// # Errors
/// One sentence on what is wrong with the queues, the scene, the device or the disk.
pub fn import(options: &ImportOptions) -> Result<Recorded> {
    let start = Instant::now();
    let (ImportFrom::Rays { file: from, .. } | ImportFrom::Queues(from)) = &options.from;
    let sources = [from, Path::new(&options.run.scene)];
    DumpWriter::check(&options.run.out, options.run.force, &sources)?;
    let mut queues = Queues::read(&options.from)?;
    let paths = queues.paths()?;
    let [width, height] = options.size.unwrap_or([paths, 1]);
    ensure!(
        u64::from(paths) <= u64::from(width) * u64::from(height),
        "{} has {paths} paths, more than a picture of {width}x{height} has pixels; see --size",
        from.display()
    );
    let run = RecordOptions {
        width,
        height,
        passes: 1,
        bounces: queues.list.iter().map(|queue| queue.id.bounce + 1).max().unwrap_or(1),
        ..options.run.clone()
    };
    let scene = scenes::load(&run.scene)?;
    let device = machine::open(&run.device)?;
    let setup = prepared(&device, &scene, &run)?;
    find_lights(&mut queues, &setup, &scene)?;
    let mut notices = scene.notices.clone();
    notices.extend(device.notices());
    notices.extend(doubts::of(&queues, &scene, &setup.light_sites));
    let foreign = foreign(&mut queues, &setup, &run, &mut notices)?;
    let name = from.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let sha256 = queues.sha256();
    let mut header = header(&scene, &setup, &run, &device, notices, Source::Imported { name, sha256 });
    header.options.methods.extend(foreign.methods.iter().map(|method| method.name.clone()));
    let rays: Vec<RecordedRays<'_>> = queues.list.iter().map(Queue::rays).collect();
    for &RecordedRays { id, rays, path_ids, lights, .. } in &rays {
        QueueRules::new(id, &header)
            .check(QueueRays { rays, path_ids, lights }, rays.len() as u64)
            .with_context(|| format!("{} cannot be imported", from.display()))?;
    }
    let verdict = verdict::judge(&scene, &queues.list);
    header.self_check.extend(verdict.clone());
    let run = Run {
        scene: &scene,
        setup,
        options: &run,
        kernel: device.kernel(&run.device),
        header,
        rays: RaySource::Recorded(rays),
        foreign,
        recorded: None,
        calibration: Vec::new(),
        start,
    };
    let mut recorded = run.on(device)?;
    let said = verdict.map(|Check { name, outcome, detail }| format!("{name}: {outcome} ({detail})"));
    recorded.notices.extend(said);
    Ok(recorded)
}

/// Gives each shadow ray of a queue without lights the one that it was most likely sent to.
fn find_lights(queues: &mut Queues, setup: &Setup, scene: &Scene) -> Result<()> {
    let shadow = queues.list.iter_mut().filter(|queue| queue.id.kind == Kind::Shadow);
    for queue in shadow {
        ensure!(
            !setup.light_sites.is_empty(),
            "the scene has no light that shadow rays could be sent to; add one in {}.rayscope.toml",
            scene.name
        );
        if queue.lights.is_empty() {
            let light = |ray| nearest_light(ray, &setup.unit, &setup.light_sites);
            queue.lights = queue.rays.iter().map(light).collect();
        }
    }
    Ok(())
}

/// The orders that came with the queues, by name; notes those that are none.
fn foreign(
    queues: &mut Queues,
    setup: &Setup,
    options: &RecordOptions,
    notices: &mut Vec<String>,
) -> Result<Foreign> {
    let claims = Claims::read(&queues.claims)?;
    let mut foreign = Foreign::default();
    for queue in &mut queues.list {
        foreign.orders.append(&mut queue.orders);
    }
    notices.extend(foreign.check());
    foreign.methods = claims.methods(&foreign.orders, setup, options)?;
    Ok(foreign)
}

/// The light that a shadow ray was most likely sent to, since files of rays do not say: of lights with a
/// place the one that the ray's line passes nearest to, seen from its origin; others by their direction.
fn nearest_light(ray: &Ray, unit: &UnitSpace, lights: &[LightSite]) -> u32 {
    let origin = unit.point(ray.origin);
    let miss = |light: &LightSite| {
        let towards = match *light {
            LightSite::Placed { centre } => std::array::from_fn(|axis| centre[axis] - origin[axis]),
            LightSite::Directional { direction, .. } => direction.map(|value| -value),
            // Any direction is one of the sky's; others go first.
            LightSite::Environment => return 1.0,
        };
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        1.0 - dot(towards, ray.direction) / dot(towards, towards).sqrt().max(f32::MIN_POSITIVE)
    };
    let misses = lights.iter().map(miss).enumerate();
    misses.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(light, _)| light as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadow_rays_find_their_light() {
        let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
        let lights = [
            LightSite::Environment,
            LightSite::Placed { centre: [0.0, 1.0, 0.0] },
            LightSite::Placed { centre: [1.0, 0.0, 0.0] },
        ];
        let ray = |direction| Ray { origin: [0.0; 3], t_min: 0.0, direction, t_max: 1.0 };
        assert_eq!(nearest_light(&ray([0.999, 0.02, 0.0]), &unit, &lights), 2);
        assert_eq!(nearest_light(&ray([0.0, 1.0, 0.0]), &unit, &lights), 1);
        assert_eq!(nearest_light(&ray([0.0, -1.0, 0.0]), &unit, &lights), 0);
    }
}
