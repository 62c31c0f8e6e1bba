//! Pinhole cameras.

/// A pinhole camera in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name to choose it by.
    pub name: String,
    /// Where it stands.
    pub eye: [f32; 3],
    /// Unit vector in which it looks.
    pub forward: [f32; 3],
    /// Unit vector to the right of the picture.
    pub right: [f32; 3],
    /// Unit vector to the top of the picture.
    pub up: [f32; 3],
    /// Vertical field of view in radians, in (0, π).
    pub yfov_radians: f32,
}
