//! The camera of a view in space: it orbits a point, flies, or stands where the recording's camera stood.

use std::fmt;
use std::str::FromStr;

use formats::manifest::CameraPose;
use formats::unit_space::UnitSpace;
use glam::{Mat4, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Nearest and farthest depth that is drawn, unit lengths.
const NEAR: f32 = 0.0008;
const FAR: f32 = 30.0;
/// Steepest look up and down, radians.
const STEEPEST: f32 = 1.55;
/// Distance to the point that a recorded camera is thought to look at, unit lengths.
const RECORDED_DISTANCE: f32 = 0.35;

/// Looks at a point from a distance; unit space, y upwards.
///
/// As text it is its numbers: target x, y, z, yaw, pitch, distance, field of view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Camera {
    /// The point that it looks at and orbits.
    pub target: Vec3,
    /// Direction of sight around the y axis, radians; 0 looks along +z.
    pub yaw: f32,
    /// Direction of sight above the horizon, radians.
    pub pitch: f32,
    /// Distance to the target, unit lengths.
    pub distance: f32,
    /// Vertical field of view, radians.
    pub yfov_radians: f32,
}

/// Field of view of an overview, radians.
const OVERVIEW_YFOV: f32 = 0.8;

impl From<Camera> for String {
    fn from(camera: Camera) -> Self {
        camera.to_string()
    }
}

impl TryFrom<String> for Camera {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for Camera {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { target, yaw, pitch, distance, yfov_radians } = self;
        write!(formatter, "{} {} {} {yaw} {pitch} {distance} {yfov_radians}", target.x, target.y, target.z)
    }
}

impl FromStr for Camera {
    type Err = String;

    /// Reads the numbers of a camera; the field of view may be left out.
    fn from_str(text: &str) -> Result<Self, String> {
        let is_between = |character: char| character.is_whitespace() || character == ',';
        let numbers: Result<Vec<f32>, _> =
            text.split(is_between).filter(|word| !word.is_empty()).map(str::parse).collect();
        match numbers.as_deref() {
            Ok(&[x, y, z, yaw, pitch, distance, ref rest @ ..])
                if rest.len() < 2 && [x, y, z, yaw, pitch].iter().all(|number| number.is_finite()) =>
            {
                let yfov_radians = rest.first().copied().unwrap_or(OVERVIEW_YFOV);
                if distance.is_finite() && distance > 0.0 && (0.01..3.1).contains(&yfov_radians) {
                    return Ok(Self { target: Vec3::new(x, y, z), yaw, pitch, distance, yfov_radians });
                }
                Err(format!("'{text}': the distance must be above 0 and the field of view 0.01 to 3.1"))
            }
            _ => Err(format!(
                "'{text}': expected target x, y, z, yaw, pitch, distance and, if wanted, the field of view, \
                 as Copy in the scene's Properties gives them"
            )),
        }
    }
}

impl Camera {
    /// All of a box from 0 to `sides`, seen from above one of its corners.
    pub fn overview(sides: [f32; 3]) -> Self {
        let sides = Vec3::from(sides);
        Self {
            target: 0.5 * sides,
            yaw: 0.7,
            pitch: -0.55,
            distance: 1.25 * sides.length(),
            yfov_radians: OVERVIEW_YFOV,
        }
    }

    /// Where the recording's camera stood. A roll is left out.
    pub fn recorded(pose: &CameraPose, unit: &UnitSpace) -> Self {
        let forward = Vec3::from(pose.forward).normalize_or(Vec3::Z);
        let eye = Vec3::from(unit.point(pose.eye));
        Self {
            target: eye + RECORDED_DISTANCE * forward,
            yaw: forward.x.atan2(forward.z),
            pitch: forward.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST),
            distance: RECORDED_DISTANCE,
            yfov_radians: pose.yfov_radians,
        }
    }

    /// Unit vector in which it looks.
    pub fn forward(&self) -> Vec3 {
        let (sine, cosine) = self.pitch.sin_cos();
        Vec3::new(cosine * self.yaw.sin(), sine, cosine * self.yaw.cos())
    }

    /// Unit vector to the right of the picture.
    pub fn right(&self) -> Vec3 {
        self.forward().cross(Vec3::Y).normalize_or(Vec3::X)
    }

    /// Unit vector to the top of the picture.
    pub fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }

    /// Where it stands.
    pub fn eye(&self) -> Vec3 {
        self.target - self.distance * self.forward()
    }

    /// Turns around the target; radians.
    pub fn orbit(&mut self, yaw: f32, pitch: f32) {
        self.yaw += yaw;
        self.pitch = (self.pitch + pitch).clamp(-STEEPEST, STEEPEST);
    }

    /// Turns around its own place; radians.
    pub fn look(&mut self, yaw: f32, pitch: f32) {
        let eye = self.eye();
        self.orbit(yaw, pitch);
        self.target = eye + self.distance * self.forward();
    }

    /// Moves along its right, its up and its line of sight; unit lengths.
    pub fn fly(&mut self, right: f32, up: f32, forward: f32) {
        self.target += right * self.right() + up * self.up() + forward * self.forward();
    }

    /// Comes so many times nearer to the target.
    pub fn zoom(&mut self, times: f32) {
        self.distance = (self.distance / times.max(1e-3)).clamp(0.004, 20.0);
    }

    /// Looks at all of a box, from where it looked before.
    pub fn frame(&mut self, low: Vec3, high: Vec3) {
        self.target = 0.5 * (low + high);
        self.distance = (0.65 * (high - low).length() / (0.5 * self.yfov_radians).tan()).clamp(0.01, 20.0);
    }

    /// From unit space to clip space, depth 0 at the near end.
    pub fn clip_from_unit(&self, aspect: f32) -> Mat4 {
        let (right, up, forward, eye) = (self.right(), self.up(), self.forward(), self.eye());
        let row = |axis: Vec3| axis.extend(-axis.dot(eye));
        let (x, y, z) = (row(right), row(up), row(forward));
        let scale = 1.0 / (0.5 * self.yfov_radians).tan();
        let depth = FAR / (FAR - NEAR);
        let z_clip = z * depth - Vec4::new(0.0, 0.0, 0.0, depth * NEAR);
        Mat4::from_cols(x * (scale / aspect.max(1e-3)), y * scale, z_clip, z).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(camera: &Camera, point: Vec3) -> Vec4 {
        camera.clip_from_unit(2.0) * point.extend(1.0)
    }

    #[test]
    fn the_target_is_in_the_middle_and_depths_ascend() {
        let camera = Camera::overview([1.0, 0.4, 0.7]);
        let middle = clip(&camera, camera.target);
        assert!((middle.x / middle.w).abs() < 1e-5 && (middle.y / middle.w).abs() < 1e-5, "{middle}");
        assert!((middle.w - camera.distance).abs() < 1e-5);
        let depth = |at: f32| {
            let at = clip(&camera, camera.eye() + at * camera.forward());
            at.z / at.w
        };
        assert!(depth(NEAR).abs() < 1e-2 && (depth(FAR) - 1.0).abs() < 1e-4);
        assert!(depth(0.1) < depth(0.2) && depth(0.2) < depth(5.0));
    }

    #[test]
    fn cameras_are_read_as_they_are_written() {
        let mut camera = Camera::overview([1.0, 0.4, 0.7]);
        camera.orbit(0.123_456_7, -0.1);
        assert_eq!(camera.to_string().parse(), Ok(camera));
        let six: Camera = "1, 2 3 0.5 -0.25 2".parse().unwrap();
        assert_eq!((six.target.y, six.distance, six.yfov_radians), (2.0, 2.0, OVERVIEW_YFOV));
        for wrong in ["", "1 2 3", "1 2 3 4 5 x", "1 2 3 4 5 0", "1 2 3 4 5 inf", "1 2 3 4 5 6 7 8"] {
            assert!(wrong.parse::<Camera>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = Camera::overview([1.0; 3]);
        let right = clip(&camera, camera.target + 0.1 * camera.right());
        let up = clip(&camera, camera.target + 0.1 * camera.up());
        assert!(right.x > 0.0 && up.y > 0.0 && camera.up().y > 0.0);
        let half = (0.5 * camera.yfov_radians).tan() * camera.distance;
        let top = clip(&camera, camera.target + half * camera.up());
        assert!((top.y / top.w - 1.0).abs() < 1e-5, "{top}");
    }

    #[test]
    fn a_recorded_camera_stands_and_looks_as_it_did() {
        let unit = UnitSpace::from_bounds([-2.0, 0.0, 1.0], [2.0, 4.0, 3.0]);
        let pose = CameraPose {
            eye: [0.5, 1.0, 2.0],
            forward: [0.6, 0.0, -0.8],
            right: [0.8, 0.0, 0.6],
            up: [0.0, 1.0, 0.0],
            yfov_radians: 1.0,
        };
        let camera = Camera::recorded(&pose, &unit);
        assert!((camera.eye() - Vec3::from(unit.point(pose.eye))).length() < 1e-6);
        assert!((camera.forward() - Vec3::from(pose.forward)).length() < 1e-6);
        assert!((camera.right() - Vec3::from(pose.right)).length() < 1e-6);
        let mut turned = camera;
        turned.look(0.3, 0.1);
        assert!((turned.eye() - camera.eye()).length() < 1e-6);
    }
}
