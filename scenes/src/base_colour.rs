//! The colour that each triangle of a scene has, seen from afar.

use rayon::prelude::*;

use crate::{Material, Scene, Texture};

/// Samples of a triangle along each of two edges, at most.
const ALONG_MAX: u32 = 8;

/// Base colour of each triangle, sRGB: the factor of its material times the mean of its texture over the
/// triangle, both linear, of texels that are no holes where there are any. A black surface that emits has the colour
/// of its light, scaled to a largest channel of 1.
pub fn of_triangles(scene: &Scene) -> Vec<[u8; 3]> {
    let linear: Vec<f32> = (0..=u8::MAX).map(linear_from_srgb).collect();
    let samples: Vec<[f32; 2]> = spread(ALONG_MAX * ALONG_MAX).collect();
    let triangles = scene.triangles.par_iter().zip(&scene.triangle_materials);
    let colour = |(corners, &material): (&[u32; 3], &u32)| {
        let material = &scene.materials[material as usize];
        let texture = material.base_color_texture.filter(|_| !scene.uvs.is_empty());
        let mean = texture.map_or([1.0; 3], |texture| {
            let uvs = corners.map(|corner| scene.uvs[corner as usize]);
            mean(&linear, &samples, &scene.textures[texture as usize], material, uvs)
        });
        let reflected = [0, 1, 2].map(|channel| material.base_color[channel] * mean[channel]);
        let brightest = material.emission.into_iter().fold(0.0, f32::max);
        let is_black_light = brightest > 0.0 && reflected == [0.0; 3];
        let seen =
            if is_black_light { material.emission.map(|channel| channel / brightest) } else { reflected };
        seen.map(|channel| srgb_from_linear(&linear, channel))
    };
    triangles.map(colour).collect()
}

/// Inverse of the sRGB transfer function (IEC 61966-2-1).
pub fn linear_from_srgb(byte: u8) -> f32 {
    let encoded = f64::from(byte) / 255.0;
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// The byte whose linear value is nearest.
fn srgb_from_linear(linear: &[f32], value: f32) -> u8 {
    let above = linear.partition_point(|&step| step < value).clamp(1, linear.len() - 1);
    let is_nearer_below = value - linear[above - 1] < linear[above] - value;
    (above - usize::from(is_nearer_below)) as u8
}

/// Linear mean of a texture over a triangle: the more texels it covers the more of the samples are taken.
fn mean(
    linear: &[f32],
    samples: &[[f32; 2]],
    texture: &Texture,
    material: &Material,
    uvs: [[f32; 2]; 3],
) -> [f32; 3] {
    let size = [texture.width as f32, texture.height as f32];
    let [a, b, c] = uvs.map(|uv| [uv[0] * size[0], uv[1] * size[1]]);
    let apart = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let longest = apart(a, b).max(apart(b, c)).max(apart(c, a));
    let along = (longest.ceil() as u32).clamp(2, ALONG_MAX);
    let threshold = material.alpha_threshold();
    let (mut sums, mut counts) = ([[0.0; 3]; 2], [0.0; 2]);
    for [u, v] in &samples[..(along * along) as usize] {
        let at = |axis: usize| a[axis] + (b[axis] - a[axis]) * u + (c[axis] - a[axis]) * v;
        let texel = texel(texture, [at(0), at(1)]);
        let is_hole = usize::from(u32::from(texel[3]) < threshold);
        for channel in 0..3 {
            sums[is_hole][channel] += linear[usize::from(texel[channel])];
        }
        counts[is_hole] += 1.0;
    }
    // A triangle that is nothing but a hole has the colour that the hole would have.
    let of = usize::from(counts[0] == 0.0);
    sums[of].map(|sum| sum / counts[of])
}

/// Weights of the second and the third corner, spread evenly over a triangle: fractions of multiples of the
/// inverse powers of the plastic number (Roberts 2018), folded. No texture repeats with them.
fn spread(count: u32) -> impl Iterator<Item = [f32; 2]> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    (1..=count).map(|at| {
        let [u, v] = STEPS.map(|step| (f64::from(at) * step).fract());
        let is_inside = u + v <= 1.0;
        [u, v].map(|along| if is_inside { along } else { 1.0 - along } as f32)
    })
}

/// The texel at a place, which wraps around.
fn texel(texture: &Texture, [x, y]: [f32; 2]) -> [u8; 4] {
    let wrapped = |along: f32, length: u32| {
        let turns = along / length as f32;
        (((turns - turns.floor()) * length as f32) as u32).min(length - 1)
    };
    let (column, row) = (wrapped(x, texture.width), wrapped(y, texture.height));
    texture.rgba[(row * texture.width + column) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle with this material and a texture, over these coordinates.
    fn scene(material: Material, texture: Texture, uvs: [[f32; 2]; 3]) -> Scene {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Scene {
            uvs: uvs.to_vec(),
            materials: vec![material],
            textures: vec![texture],
            ..Scene::of_geometry("triangle".to_owned(), corners, vec![[0, 1, 2]])
        }
    }

    fn textured() -> Material {
        Material { base_color: [1.0; 3], base_color_texture: Some(0), ..Material::default() }
    }

    #[test]
    fn bytes_come_back_and_others_are_rounded() {
        let linear: Vec<f32> = (0..=u8::MAX).map(linear_from_srgb).collect();
        for byte in 0..=u8::MAX {
            assert_eq!(srgb_from_linear(&linear, linear_from_srgb(byte)), byte);
        }
        assert_eq!([-1.0, 2.0].map(|value| srgb_from_linear(&linear, value)), [0, 255]);
        assert_eq!([0.5, 0.214].map(|value| srgb_from_linear(&linear, value)), [188, 127]);
    }

    #[test]
    fn a_plain_material_has_its_factor() {
        let material = Material { base_color: [1.0, 0.5, 0.0], ..Material::default() };
        let texture = Texture { width: 1, height: 1, rgba: vec![[9; 4]] };
        assert_eq!(of_triangles(&scene(material, texture, [[0.0; 2]; 3])), [[255, 188, 0]]);
    }

    #[test]
    fn a_black_light_has_the_colour_of_its_light() {
        let of = |base_color, emission| {
            let material = Material { base_color, emission, ..Material::default() };
            let texture = Texture { width: 1, height: 1, rgba: vec![[9; 4]] };
            of_triangles(&scene(material, texture, [[0.0; 2]; 3]))[0]
        };
        assert_eq!(of([0.0; 3], [8.0, 4.0, 0.0]), [255, 188, 0]);
        assert_eq!(of([0.0; 3], [0.0; 3]), [0; 3]);
        assert_eq!(of([0.5; 3], [8.0, 4.0, 0.0]), [188; 3]);
    }

    /// Halves of black and white are grey in linear light, and each triangle sees its own half.
    #[test]
    fn a_texture_is_averaged_over_the_triangle_in_linear_light() {
        let stripes = || Texture { width: 2, height: 1, rgba: vec![[0, 0, 0, 255], [255; 4]] };
        let over = |uvs| of_triangles(&scene(textured(), stripes(), uvs))[0];
        // The left half, the right half, and both halves many times over, as often as there are samples.
        assert_eq!(over([[0.1, 0.0], [0.4, 0.0], [0.1, 1.0]]), [0; 3]);
        assert_eq!(over([[-0.4, 0.0], [-0.1, 0.0], [-0.4, 1.0]]), [255; 3]);
        let grey = over([[0.0, 0.0], [16.0, 0.0], [0.0, 16.0]])[0];
        // Of 64 samples 8 % more may be black.
        assert!(grey.abs_diff(188) < 16, "{grey}");
        // A factor of a quarter of that.
        let dim = Material { base_color: [0.25; 3], ..textured() };
        let half = scene(dim, stripes(), [[0.5, 0.0], [1.0, 0.0], [0.5, 1.0]]);
        assert_eq!(of_triangles(&half), [[137; 3]]);
    }

    #[test]
    fn samples_are_spread_evenly() {
        for count in [4, 25, 64] {
            let all: Vec<[f32; 2]> = spread(count).collect();
            assert!(all.iter().all(|[u, v]| *u > 0.0 && *v > 0.0 && u + v <= 1.0));
            for axis in 0..2 {
                let mean = all.iter().map(|at| at[axis]).sum::<f32>() / count as f32;
                assert!((mean - 1.0 / 3.0).abs() < 0.6 / count as f32 + 0.003, "{mean} of {count}");
            }
        }
    }

    #[test]
    fn holes_lend_no_colour() {
        let texture = Texture { width: 2, height: 1, rgba: vec![[255, 0, 0, 0], [0, 255, 0, 255]] };
        let masked = Material { alpha_cutoff: Some(0.5), ..textured() };
        let both = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]];
        assert_eq!(of_triangles(&scene(masked.clone(), texture.clone(), both)), [[0, 255, 0]]);
        let hole = [[0.1, 0.0], [0.4, 0.0], [0.1, 1.0]];
        assert_eq!(of_triangles(&scene(masked, texture, hole)), [[255, 0, 0]]);
    }
}
