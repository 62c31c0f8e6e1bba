//! Pinhole cameras.

use glam::DVec3;

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

/// Why a camera cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum CameraError {
    #[error("its eye or its direction is not finite")]
    NotFinite,
    #[error("its eye and its target are the same point, or its forward axis has no length")]
    NoForward,
    #[error("its up vector has no length or lies along the view direction")]
    NoUp,
    #[error("its vertical field of view is {degrees}°, expected more than 0° and less than 180°")]
    FieldOfView { degrees: f32 },
}

impl Camera {
    /// A camera at `eye` that has `target` in the middle of the picture and `up` towards its top.
    ///
    /// # Errors
    /// If the eye is at the target, `up` is parallel to the view, `yfov_radians` is not in (0, π),
    /// or a number is not finite.
    pub fn look_at(
        name: &str,
        eye: [f32; 3],
        target: [f32; 3],
        up: [f32; 3],
        yfov_radians: f32,
    ) -> Result<Self, CameraError> {
        let [eye, target, up] = [eye, target, up].map(|v| DVec3::from_array(v.map(f64::from)));
        Self::from_axes(name, eye, target - eye, up, yfov_radians)
    }

    /// A camera that looks along `forward`, of any length; only the part of `up` across it counts.
    pub(crate) fn from_axes(
        name: &str,
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        yfov_radians: f32,
    ) -> Result<Self, CameraError> {
        /// Below this sine of the angle between them, `up` says nothing about which way is up.
        const MIN_SINE: f64 = 1e-6;

        let eye = eye.to_array().map(|x| x as f32);
        if !(forward.is_finite() && up.is_finite() && eye.iter().all(|x| x.is_finite())) {
            return Err(CameraError::NotFinite);
        }
        let forward = forward.try_normalize().ok_or(CameraError::NoForward)?;
        let across = forward.cross(up.try_normalize().ok_or(CameraError::NoUp)?);
        if across.length() < MIN_SINE {
            return Err(CameraError::NoUp);
        }
        let right = across.normalize();
        // Checked as the f32 that it is, so that NaN is refused too.
        if !(yfov_radians > 0.0 && yfov_radians < std::f32::consts::PI) {
            return Err(CameraError::FieldOfView { degrees: yfov_radians.to_degrees() });
        }
        let axis = |v: DVec3| v.to_array().map(|x| x as f32);
        Ok(Self {
            name: name.into(),
            eye,
            forward: axis(forward),
            right: axis(right),
            up: axis(right.cross(forward)),
            yfov_radians,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn look_at_gives_a_right_handed_orthonormal_frame() {
        let camera = Camera::look_at("c", [1.0, 2.0, 3.0], [1.0, 2.0, -7.0], [0.3, 5.0, 0.0], 1.0);
        let camera = camera.unwrap();
        assert_eq!(camera.forward, [0.0, 0.0, -1.0]);
        // Up leans to the side, so right leans down.
        let right = DVec3::new(5.0, -0.3, 0.0).normalize();
        let found = DVec3::from_array(camera.right.map(f64::from));
        assert!((found - right).length() < 1e-6, "{found}");
        for (a, b, expected) in
            [(camera.up, camera.up, 1.0), (camera.up, camera.forward, 0.0), (camera.up, camera.right, 0.0)]
        {
            assert!((dot(a, b) - expected).abs() < 1e-6);
        }
        assert!(camera.up[1] > 0.9);
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let make = |target, up, yfov| Camera::look_at("c", [1.0; 3], target, up, yfov).unwrap_err();
        let (up, ahead) = ([0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
        assert_eq!(make([1.0; 3], up, 1.0), CameraError::NoForward);
        assert_eq!(make([1.0, 9.0, 1.0], up, 1.0), CameraError::NoUp);
        assert_eq!(make(ahead, [0.0; 3], 1.0), CameraError::NoUp);
        assert_eq!(make([f32::NAN, 0.0, 0.0], up, 1.0), CameraError::NotFinite);
        for yfov in [0.0, std::f32::consts::PI, f32::NAN] {
            assert!(matches!(make(ahead, up, yfov), CameraError::FieldOfView { .. }));
        }
    }
}
