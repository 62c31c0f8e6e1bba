//! The arithmetic of the built-in scenes: the same bits on every machine.
//!
//! Only `+ - * /`, square roots and rounding are used, which IEEE 754 defines to the last bit. The
//! sine of the standard library comes from the system's own and differs between systems, and
//! `powi` may: both stay out.

use glam::{DVec3, dvec3};

/// Sine and cosine of an angle given in turns (1 = a full circle).
///
/// Exact at multiples of a quarter turn, elsewhere within 1e-15; the sine and cosine of `t` and of
/// `t + 1` are the same bits when `t + 1` is exact, so closed curves close.
pub(super) fn sin_cos(turns: f64) -> (f64, f64) {
    let fraction = turns - turns.floor();
    let quarter = (4.0 * fraction).round();
    // In [-π/4, π/4], where the Taylor series below are exact to rounding.
    let angle = (fraction - 0.25 * quarter) * std::f64::consts::TAU;
    let square = angle * angle;
    let sine = angle * series(square, 6.0, &[20.0, 42.0, 72.0, 110.0, 156.0, 210.0]);
    let cosine = series(square, 2.0, &[12.0, 30.0, 56.0, 90.0, 132.0, 182.0, 240.0]);
    match quarter as u32 % 4 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// `1 - x/first · (1 - x/rest₀ · (1 - …))`: the common form of the two series.
fn series(x: f64, first: f64, rest: &[f64]) -> f64 {
    let tail = rest.iter().rev().fold(1.0, |inner, divisor| 1.0 - x / divisor * inner);
    1.0 - x / first * tail
}

/// A stream of pseudo-random numbers (SplitMix64: Steele, Lea and Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub(super) struct Dice {
    state: u64,
}

impl Dice {
    /// A stream of its own for every `seed`.
    pub(super) fn new(seed: u64) -> Self {
        let mut dice = Self { state: seed };
        // Without this, neighbouring seeds would give the same stream, shifted by a fraction.
        dice.state = dice.bits();
        dice
    }

    /// A stream of its own for every place of an infinite grid.
    pub(super) fn of_cell(seed: u64, x: i64, z: i64) -> Self {
        let mut row = Self::new(seed ^ (z as u64));
        Self::new(row.bits() ^ (x as u64))
    }

    /// The next 64 bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0 .. count; `count` ≥ 1.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// A unit vector, all equally likely.
    pub(super) fn direction(&mut self) -> DVec3 {
        let (sine, cosine) = sin_cos(self.unit());
        let y = self.between(-1.0, 1.0);
        let radius = (1.0 - y * y).sqrt();
        dvec3(radius * cosine, y, radius * sine)
    }

    /// Whether an event of this probability happens.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }
}

/// Smooth noise in [-1, 1] with features of size 1: random values on the integer grid, blended so
/// that slope and curvature are continuous.
pub(super) fn value_noise(seed: u64, x: f64, z: f64) -> f64 {
    let (cell_x, cell_z) = (x.floor(), z.floor());
    let corner =
        |dx: i64, dz: i64| 2.0 * Dice::of_cell(seed, cell_x as i64 + dx, cell_z as i64 + dz).unit() - 1.0;
    let (across, along) = (ease(x - cell_x), ease(z - cell_z));
    let near = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * across;
    let far = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * across;
    near + (far - near) * along
}

/// Value noise of several octaves, each half the size and half the height of the one before;
/// in [-2, 2].
pub(super) fn fractal_noise(seed: u64, x: f64, z: f64, octaves: u64) -> f64 {
    let mut total = 0.0;
    let mut height = 1.0;
    let mut frequency = 1.0;
    for octave in 0..octaves {
        // The shift keeps the grids of the octaves from meeting in the origin.
        let shift = 0.37 * octave as f64;
        total += height * value_noise(seed + octave, x * frequency + shift, z * frequency - shift);
        height *= 0.5;
        frequency *= 2.0;
    }
    total
}

/// From 0 to 1 with flat ends, for `t` in [0, 1].
pub(super) fn ease(t: f64) -> f64 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_agree_with_the_standard_library() {
        for step in -4000..4000 {
            let turns = f64::from(step) * 0.001_3;
            let (sine, cosine) = sin_cos(turns);
            let angle = turns * std::f64::consts::TAU;
            assert!((sine - angle.sin()).abs() < 4e-15, "sin({turns} turns) = {sine}");
            assert!((cosine - angle.cos()).abs() < 4e-15, "cos({turns} turns) = {cosine}");
        }
    }

    #[test]
    fn quarter_turns_are_exact_and_circles_close() {
        let quarters: Vec<_> = (0..5).map(|quarter| sin_cos(0.25 * f64::from(quarter))).collect();
        assert_eq!(quarters, [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]);
    }

    #[test]
    fn dice_are_uniform_and_differ_between_cells() {
        let mut dice = Dice::new(7);
        let mean = (0..10_000).map(|_| dice.unit()).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
        let mut first: Vec<u64> = (0..64).map(|i| Dice::of_cell(1, i % 8, i / 8).bits()).collect();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 64, "two cells of the grid share a stream");
    }

    #[test]
    fn noise_is_bounded_and_continuous_across_cells() {
        for step in -40..40 {
            // On the grid lines and half-way between them.
            let x = 0.5 * f64::from(step);
            for (below, above) in [
                (value_noise(3, x - 1e-9, 0.3), value_noise(3, x + 1e-9, 0.3)),
                (value_noise(3, 0.3, x - 1e-9), value_noise(3, 0.3, x + 1e-9)),
            ] {
                assert!(below.abs() <= 1.0);
                assert!((below - above).abs() < 1e-7, "jump at {x}: {below} to {above}");
            }
        }
    }
}
