//! Rays that another tracer wrote, traced through a scene and recorded as one queue.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use formats::files::read_plain;
use formats::key::LightSite;
use formats::manifest::{QueueId, Source};
use formats::npy::{self, Dtype};
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;
use formats::writer::DumpWriter;
use sha2::{Digest, Sha256};

use crate::backends::RecordedRays;
use crate::machine;
use crate::options::RecordOptions;
use crate::recording::{RaySource, Recorded, Run, choose_camera, header, setup};

/// Directions whose length differs from 1 by less than this are taken as they are.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Everything that `recorder import` was asked for.
#[derive(Clone, Debug)]
pub struct ImportOptions {
    /// An NPY file: rays as recordings hold them, or `<f4` (N, 6) origin and direction, or `<f4` (N, 8)
    /// origin, t_min, direction, t_max.
    pub rays: PathBuf,
    /// What they ask for.
    pub kind: Kind,
    /// Their bounce.
    pub bounce: u32,
    /// The rest; width and height are made from the number of rays.
    pub run: RecordOptions,
}

/// Traces the rays of a file through a scene and records them with all methods.
///
/// # Errors
/// One sentence on what is wrong with the rays, the scene, the device or the disk.
pub fn import(options: &ImportOptions) -> Result<Recorded> {
    let start = Instant::now();
    let sources = [&options.rays, Path::new(&options.run.scene)];
    DumpWriter::check(&options.run.out, options.run.force, &sources)?;
    let (rays, sha256) = read(&options.rays)?;
    let run = RecordOptions {
        width: rays.len() as u32,
        height: 1,
        passes: 1,
        bounces: options.bounce + 1,
        ..options.run.clone()
    };
    let scene = scenes::load(&run.scene)?;
    let camera = choose_camera(&scene, run.camera.as_deref())?;
    let device = machine::open(&run.device)?;
    let setup = Arc::new(setup(&scene, &camera, &run)?);
    device.check_capacity(&setup, &scene, &run)?;
    let path_ids: Vec<u32> = (0..rays.len() as u32).collect();
    let lights = match options.kind {
        Kind::Closest => Vec::new(),
        Kind::Shadow => {
            ensure!(
                !setup.light_sites.is_empty(),
                "the scene has no light that shadow rays could be sent to; add one in {}.rayscope.toml",
                scene.name
            );
            rays.iter().map(|ray| nearest_light(ray, &setup.unit, &setup.light_sites)).collect()
        }
    };
    let mut notices = scene.notices.clone();
    notices.extend(device.notices());
    let name = options.rays.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let header = header(&scene, &setup, &run, &device, notices, Source::Imported { name, sha256 });
    let queue = RecordedRays {
        id: QueueId { pass: 0, bounce: options.bounce, kind: options.kind },
        rays: &rays,
        path_ids: &path_ids,
        lights: &lights,
        lengths: None,
    };
    let rays = RaySource::Recorded(vec![queue]);
    Run { scene: &scene, setup, options: &run, header, rays, recorded: None, calibration: Vec::new(), start }
        .on(device)
}

/// The rays of a file, and its SHA-256.
fn read(path: &Path) -> Result<(Vec<Ray>, [u8; 32])> {
    let bytes = read_plain(path, u64::MAX).with_context(|| format!("cannot read {}", path.display()))?;
    let rays = parse(&bytes).with_context(|| path.display().to_string())?;
    Ok((rays, Sha256::digest(&bytes).into()))
}

fn parse(bytes: &[u8]) -> Result<Vec<Ray>> {
    let header = npy::parse_header(bytes)?;
    let shape = header.shape.as_slice();
    let data = &bytes[header.data_offset..];
    let expected = npy::data_bytes(header.dtype, shape).unwrap_or(u64::MAX);
    ensure!(data.len() as u64 == expected, "there are {} bytes of data, expected {expected}", data.len());
    let rays: Vec<Ray> = match (header.dtype, shape) {
        (Dtype::Ray, [_]) => bytemuck::pod_collect_to_vec(data),
        (Dtype::F4, [_, 8]) => bytemuck::pod_collect_to_vec(data),
        (Dtype::F4, [_, 6]) => {
            let rows: Vec<[[f32; 3]; 2]> = bytemuck::pod_collect_to_vec(data);
            let ray = |[origin, direction]: [[f32; 3]; 2]| Ray {
                origin,
                t_min: 0.0,
                direction,
                t_max: f32::INFINITY,
            };
            rows.into_iter().map(ray).collect()
        }
        (dtype, shape) => bail!(
            "found {dtype} {shape:?}, expected <f4 (N, 6) with origin and direction, <f4 (N, 8) with origin, t_min, direction and t_max, or {} (N,)",
            Dtype::Ray.descr()
        ),
    };
    ensure!(!rays.is_empty(), "there are no rays");
    ensure!(
        rays.len() < u32::MAX as usize,
        "{} rays are more than path indices of 32 bits can name",
        rays.len()
    );
    rays.into_iter()
        .enumerate()
        .map(|(row, ray)| checked(ray).with_context(|| format!("ray {row}")))
        .collect()
}

/// The ray with a unit direction, distances in world units.
fn checked(ray: Ray) -> Result<Ray> {
    ensure!(ray.origin.iter().all(|value| value.is_finite()), "the origin {:?} is not finite", ray.origin);
    ensure!(
        ray.direction.iter().all(|value| value.is_finite()),
        "the direction {:?} is not finite",
        ray.direction
    );
    let length = ray.direction.iter().map(|&value| f64::from(value).powi(2)).sum::<f64>().sqrt();
    ensure!(length > 0.0, "the direction is zero");
    let mut checked = ray;
    if (length - 1.0).abs() >= UNIT_TOLERANCE {
        let scaled = |distance: f32| (f64::from(distance) * length) as f32;
        checked.direction = ray.direction.map(|value| (f64::from(value) / length) as f32);
        (checked.t_min, checked.t_max) = (scaled(ray.t_min), scaled(ray.t_max));
    }
    ensure!(
        checked.t_min >= 0.0 && checked.t_min < f32::INFINITY && checked.t_max >= checked.t_min,
        "t_min {} and t_max {} are no range of distances from 0 on",
        ray.t_min,
        ray.t_max
    );
    Ok(checked)
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

    fn file(dtype: Dtype, shape: &[u64], values: &[f32]) -> Vec<u8> {
        let mut bytes = npy::header(dtype, shape);
        bytes.extend_from_slice(bytemuck::cast_slice(values));
        bytes
    }

    #[test]
    fn the_three_forms_are_read() {
        let wide = [1.0, 2.0, 3.0, 0.5, 0.0, 0.0, 2.0, 4.0];
        let expected = Ray { origin: [1.0, 2.0, 3.0], t_min: 1.0, direction: [0.0, 0.0, 1.0], t_max: 8.0 };
        assert_eq!(parse(&file(Dtype::F4, &[1, 8], &wide)).unwrap(), [expected]);
        assert_eq!(parse(&file(Dtype::Ray, &[1], &wide)).unwrap(), [expected]);
        let narrow = parse(&file(Dtype::F4, &[1, 6], &[1.0, 2.0, 3.0, 0.0, -1.0, 0.0])).unwrap();
        assert_eq!((narrow[0].t_min, narrow[0].t_max), (0.0, f32::INFINITY));
    }

    #[test]
    fn other_files_are_refused() {
        let nan = [0.0, f32::NAN, 0.0, 0.0, 0.0, 1.0];
        let zero = [0.0; 6];
        for (bytes, expected) in [
            (file(Dtype::F4, &[1, 6], &nan), "ray 0"),
            (file(Dtype::F4, &[1, 6], &zero), "ray 0"),
            (file(Dtype::F4, &[1, 6], &zero[..5]), "bytes of data"),
            (file(Dtype::F4, &[0, 6], &[]), "no rays"),
            (file(Dtype::U4, &[1, 6], &zero), "expected <f4 (N, 6)"),
            (file(Dtype::F4, &[2, 3], &zero), "expected <f4 (N, 6)"),
            (b"hello".to_vec(), "NumPy"),
        ] {
            let message = format!("{:#}", parse(&bytes).unwrap_err());
            assert!(message.contains(expected), "{message}");
        }
    }

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
