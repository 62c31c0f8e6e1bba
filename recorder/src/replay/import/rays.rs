//! Rays as other programs write them: three forms of NPY files.

use anyhow::{Context, Result, bail, ensure};
use formats::npy::{self, Dtype, NpyHeader};
use formats::ray::{ORIGIN_LIMIT, Ray};

/// Directions whose length differs from 1 by less than this are taken as they are.
const UNIT_TOLERANCE: f64 = 1e-6;

/// The rays of an NPY file with unit directions, and the length that each direction had: what distances given
/// along with them count in.
///
/// # Errors
/// What is wrong with the file, or with the first wrong ray.
pub(super) fn parse(bytes: &[u8]) -> Result<(Vec<Ray>, Vec<f64>)> {
    let header = npy::parse_header(bytes)?;
    let shape = header.shape.as_slice();
    let data = data(bytes, &header)?;
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

/// What follows the header of an NPY file.
///
/// # Errors
/// If it is not as long as that says.
pub(super) fn data<'a>(bytes: &'a [u8], header: &NpyHeader) -> Result<&'a [u8]> {
    let data = &bytes[header.data_offset..];
    let expected = npy::data_bytes(header.dtype, &header.shape).unwrap_or(u64::MAX);
    ensure!(data.len() as u64 == expected, "there are {} bytes of data, expected {expected}", data.len());
    Ok(data)
}

/// The ray with a unit direction, distances in world units, and the length that the direction had.
fn checked(ray: Ray) -> Result<(Ray, f64)> {
    ensure!(
        ray.origin.iter().all(|value| value.abs() <= ORIGIN_LIMIT),
        "the origin {:?} has a coordinate that is no number, or beyond {ORIGIN_LIMIT:e}: give rays in the scene's units",
        ray.origin
    );
    ensure!(
        ray.direction.iter().all(|value| value.is_finite()),
        "the direction {:?} is not finite",
        ray.direction
    );
    let length = ray.direction.iter().map(|&value| f64::from(value).powi(2)).sum::<f64>().sqrt();
    ensure!(length > 0.0, "the direction is zero");
    let length = if (length - 1.0).abs() < UNIT_TOLERANCE { 1.0 } else { length };
    let mut checked = ray;
    if length != 1.0 {
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
    Ok((checked, length))
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
        assert_eq!(parse(&file(Dtype::F4, &[1, 8], &wide)).unwrap(), (vec![expected], vec![2.0]));
        assert_eq!(parse(&file(Dtype::Ray, &[1], &wide)).unwrap().0, [expected]);
        let (narrow, _) = parse(&file(Dtype::F4, &[1, 6], &[1.0, 2.0, 3.0, 0.0, -1.0, 0.0])).unwrap();
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
}
