//! Random numbers and the few functions of them that sampling needs; the same bits everywhere.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, u32x8};

use super::eight::Vec3x8;
use super::wgsl::wgsl_f32_array;

/// A stream of numbers that depends on seed, pixel, pass and stream alone: no state survives a
/// kernel, so any order of rays draws the same numbers.
///
/// Hash and step: PCG-RXS-M-XS 32 (Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT 2020).
#[derive(Clone, Copy, Debug)]
pub struct Random(u32);

#[inline(always)]
fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

impl Random {
    /// The stream of a pixel, by itself.
    pub fn new(seed: [u32; 2], pixel: u32, pass: u32, stream: u32) -> Self {
        Self::of_pixel(Self::of_queue(seed, pass, stream), pixel)
    }

    /// What a stream of all pixels has in common. Stream 0 belongs to camera rays, stream b + 1 to the surfaces that
    /// bounce b hits.
    pub fn of_queue(seed: [u32; 2], pass: u32, stream: u32) -> u32 {
        let salt = pcg(seed[0].wrapping_add(pcg(seed[1])));
        pcg(stream.wrapping_add(pcg(pass.wrapping_add(salt))))
    }

    /// The stream of a pixel, of those that have that in common.
    #[inline(always)]
    pub fn of_pixel(queue: u32, pixel: u32) -> Self {
        Self(pcg(pixel.wrapping_add(queue)))
    }

    /// The next number in [0, 1), a multiple of 2⁻²⁴.
    #[inline(always)]
    pub fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        (pcg(self.0) >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// The streams of eight pixels.
#[derive(Clone, Copy, Debug)]
pub struct RandomX8<S: Simd>(u32x8<S>);

#[inline(always)]
fn pcg_x8<S: Simd>(value: u32x8<S>) -> u32x8<S> {
    let state = value * 747_796_405 + 2_891_336_453;
    let word = ((state >> ((state >> 28) + 4)) ^ state) * 277_803_737;
    (word >> 22) ^ word
}

impl<S: Simd> RandomX8<S> {
    /// As [`Random::of_pixel`].
    #[inline(always)]
    pub fn of_pixels(queue: u32, pixels: u32x8<S>) -> Self {
        Self(pcg_x8(pixels + queue))
    }

    /// As [`Random::draw`].
    #[inline(always)]
    pub fn draw(&mut self) -> f32x8<S> {
        self.0 += 0x9e37_79b9;
        let drawn: i32x8<S> = (pcg_x8(self.0) >> 8).bitcast();
        drawn.to_float::<f32x8<S>>() * (1.0 / 16_777_216.0)
    }
}

/// Coefficients of sin(πx/2) = x·Σ c[i]·x^2i for |x| ≤ ½, by Taylor; error below 2·10⁻⁹.
pub const SINE: [f32; 5] =
    [std::f32::consts::FRAC_PI_2, -0.645_964_1, 0.079_692_63, -0.004_681_754, 0.000_160_441_2];
/// Coefficients of cos(πx/2) = Σ c[i]·x^2i for |x| ≤ ½, by Taylor; error below 3·10⁻⁸.
pub const COSINE: [f32; 5] = [1.0, -1.233_700_6, 0.253_669_5, -0.020_863_48, 0.000_919_260_3];

/// Sine and cosine of a full turn times `turns`, for `turns` in [0, 1].
#[inline(always)]
pub fn sine_cosine<S: Simd>(turns: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let quarters = turns * 4.0;
    let nearest = (quarters + 0.5).floor();
    let x = quarters - nearest;
    let x2 = x * x;
    let sine = x * (SINE[0] + x2 * (SINE[1] + x2 * (SINE[2] + x2 * (SINE[3] + x2 * SINE[4]))));
    let cosine = COSINE[0] + x2 * (COSINE[1] + x2 * (COSINE[2] + x2 * (COSINE[3] + x2 * COSINE[4])));
    let quarter: u32x8<S> = nearest.to_int::<i32x8<S>>().bitcast();
    let is_even = (quarter & 1).simd_eq(0);
    let (sine, cosine) = (is_even.select(sine, cosine), is_even.select(cosine, sine));
    let signed = |value: f32x8<S>, quarters: u32x8<S>| {
        let bits: u32x8<S> = value.bitcast();
        (bits ^ (quarters & 2) << 30).bitcast()
    };
    (signed(sine, quarter), signed(cosine, quarter + 1))
}

/// Directions around +z with density cos/π.
#[inline(always)]
pub fn cosine_hemisphere<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> Vec3x8<S> {
    let radius = a.sqrt();
    let (sine, cosine) = sine_cosine(b);
    Vec3x8::new(radius * cosine, radius * sine, (1.0 - a).max(0.0).sqrt())
}

/// The same in WGSL.
pub(super) fn wgsl() -> String {
    wgsl_f32_array("SINE", &SINE) + &wgsl_f32_array("COSINE", &COSINE) + include_str!("random.wgsl")
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn sine_and_cosine_are_close_to_f64() {
        for first in (0..=1_000_000u32).step_by(8) {
            let turns: [f32; 8] = std::array::from_fn(|lane| (first + lane as u32) as f32 / 1_000_007.0);
            let (sines, cosines) = dispatch!(Level::new(), simd => {
                let (sines, cosines) = sine_cosine(turns.simd_into(simd));
                (sines.to_array(), cosines.to_array())
            });
            for ((turns, sine), cosine) in turns.into_iter().zip(sines).zip(cosines) {
                let angle = f64::from(turns) * std::f64::consts::TAU;
                assert!((f64::from(sine) - angle.sin()).abs() < 5e-7, "sine of {turns} turns");
                assert!((f64::from(cosine) - angle.cos()).abs() < 5e-7, "cosine of {turns} turns");
            }
        }
    }

    #[test]
    fn eight_streams_are_those_of_their_pixels() {
        let (queue, pixels) = (Random::of_queue([1, 2], 3, 4), [0, 1, 2, 77, 1 << 20, 5, 6, u32::MAX]);
        let mut alone = pixels.map(|pixel| Random::of_pixel(queue, pixel));
        let drawn = dispatch!(Level::new(), simd => {
            let mut together = RandomX8::of_pixels(queue, pixels.simd_into(simd));
            [(); 3].map(|()| together.draw().to_array())
        });
        for drawn in drawn {
            assert_eq!(drawn, alone.each_mut().map(Random::draw));
        }
    }

    #[test]
    fn numbers_are_uniform_and_streams_differ() {
        let mut sums = [0.0f64; 4];
        for pixel in 0..100_000 {
            let mut random = Random::new([1, 2], pixel, 3, 4);
            let (a, b) = (f64::from(random.draw()), f64::from(random.draw()));
            assert!((0.0..1.0).contains(&a));
            for (sum, value) in sums.iter_mut().zip([a, a * a, a * b, b]) {
                *sum += value / 100_000.0;
            }
        }
        for (found, expected) in sums.iter().zip([0.5, 1.0 / 3.0, 0.25, 0.5]) {
            assert!((found - expected).abs() < 0.005, "{sums:?}");
        }
        let first = |seed, pixel, pass, stream| Random::new(seed, pixel, pass, stream).draw();
        let base = first([0, 0], 5, 1, 1);
        for other in [
            first([1, 0], 5, 1, 1),
            first([0, 1], 5, 1, 1),
            first([0, 0], 6, 1, 1),
            first([0, 0], 5, 2, 1),
            first([0, 0], 5, 1, 2),
        ] {
            assert_ne!(base, other);
        }
    }
}
