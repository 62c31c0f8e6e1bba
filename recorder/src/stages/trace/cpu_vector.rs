//! Eight numbers side by side, one of each ray, for kernels that trace rays together: with AVX2 and without,
//! with the same results.

/// Eight numbers.
pub(super) trait Vector: Copy {
    /// The same number eight times.
    fn splat(value: f32) -> Self;
    /// These.
    fn load(values: &[f32; 8]) -> Self;
    /// The numbers.
    fn store(self) -> [f32; 8];
    /// `self + other`.
    fn add(self, other: Self) -> Self;
    /// `self − other`.
    fn sub(self, other: Self) -> Self;
    /// `self · other`.
    fn mul(self, other: Self) -> Self;
    /// The lower one, `other` if they are equal.
    fn min(self, other: Self) -> Self;
    /// The higher one, `other` if they are equal.
    fn max(self, other: Self) -> Self;
    /// Bit `lane` set where `self <= other`.
    fn le(self, other: Self) -> u32;
    /// The four columns of eight rows.
    fn columns(rows: [&[f32; 4]; 8]) -> [Self; 4];
    /// For each lane one of four numbers, by its place: 0 to 3.
    fn pick(from: &[f32; 4], places: &[u32; 8]) -> Self;
}

/// One number after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, result: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| result(self.0[lane], other.0[lane])))
    }
}

impl Vector for Portable {
    fn splat(value: f32) -> Self {
        Self([value; 8])
    }

    fn load(values: &[f32; 8]) -> Self {
        Self(*values)
    }

    fn store(self) -> [f32; 8] {
        self.0
    }

    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    fn le(self, other: Self) -> u32 {
        (0..8).fold(0, |bits, lane| bits | u32::from(self.0[lane] <= other.0[lane]) << lane)
    }

    fn columns(rows: [&[f32; 4]; 8]) -> [Self; 4] {
        std::array::from_fn(|column| Self(rows.map(|row| row[column])))
    }

    fn pick(from: &[f32; 4], places: &[u32; 8]) -> Self {
        Self(places.map(|place| from[place as usize % 4]))
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::Vector;

    /// All at once; made and used by functions with AVX2 alone.
    #[derive(Clone, Copy, Debug)]
    pub(in super::super) struct Avx2(__m256);

    // SAFETY of every block: the caller has AVX2, by this type's contract. What is read are references.
    impl Vector for Avx2 {
        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_set1_ps(value) })
        }

        #[inline(always)]
        fn load(values: &[f32; 8]) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_loadu_ps(values.as_ptr()) })
        }

        #[inline(always)]
        fn store(self) -> [f32; 8] {
            bytemuck::cast(self.0)
        }

        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn le(self, other: Self) -> u32 {
            // SAFETY: see above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }

        #[inline(always)]
        fn columns(rows: [&[f32; 4]; 8]) -> [Self; 4] {
            // SAFETY: see above.
            unsafe { columns(rows) }
        }

        #[inline(always)]
        fn pick(from: &[f32; 4], places: &[u32; 8]) -> Self {
            // SAFETY: see above.
            unsafe { pick(from, places) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn columns(rows: [&[f32; 4]; 8]) -> [Avx2; 4] {
        let row = |at: usize| bytemuck::cast::<[f32; 4], __m128>(*rows[at]);
        let two = |at: usize| _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(row(at)), row(at + 4));
        let (a, b, c, d) = (two(0), two(1), two(2), two(3));
        let (ab_low, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd_low, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        [
            Avx2(_mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low)),
            Avx2(_mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low)),
            Avx2(_mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high)),
            Avx2(_mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high)),
        ]
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn pick(from: &[f32; 4], places: &[u32; 8]) -> Avx2 {
        let from = bytemuck::cast::<[f32; 4], __m128>(*from);
        Avx2(_mm256_permutevar_ps(_mm256_set_m128(from, from), bytemuck::cast(*places)))
    }
}
