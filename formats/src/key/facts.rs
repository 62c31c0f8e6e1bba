//! What keys are made from beside the ray itself.

/// What is known of a ray beside itself; layouts that do not need it ignore it.
///
/// Of many rays each is a function of the ray's index among them, which is only asked if the layout needs it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts<Length = f32, Light = u32, Path = u32> {
    /// Estimate of its length, unit lengths.
    pub length: Length,
    /// Index of the light that a shadow ray is sent to.
    pub light: Light,
    /// Index of its path: y · width + x of its pixel.
    pub path: Path,
}

/// What is asked for each of many rays.
type Ask<T> = fn(usize) -> T;

/// For many rays and a layout that needs nothing of it.
pub const NO_FACTS: Facts<Ask<f32>, Ask<u32>, Ask<u32>> =
    Facts { length: |_| 0.0, light: |_| 0, path: |_| 0 };
