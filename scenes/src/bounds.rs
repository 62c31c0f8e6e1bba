//! Axis-aligned boxes.

/// Axis-aligned box in world space; `min > max` on every axis when it holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub min: [f32; 3],
    /// Highest corner.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box that holds no point.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The smallest box around `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a [f32; 3]>) -> Self {
        let mut bounds = Self::EMPTY;
        for point in points {
            bounds.grow(point);
        }
        bounds
    }

    /// Enlarges the box so that it holds `point`.
    pub fn grow(&mut self, point: &[f32; 3]) {
        for ((min, max), &x) in self.min.iter_mut().zip(&mut self.max).zip(point) {
            *min = min.min(x);
            *max = max.max(x);
        }
    }

    /// The smallest box around two.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1, 2].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// Extent along each axis.
    pub fn extent(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.max[axis] - self.min[axis])
    }

    /// The point half-way between the corners.
    pub fn centre(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| 0.5 * self.min[axis] + 0.5 * self.max[axis])
    }
}
