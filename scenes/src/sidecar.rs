//! The sidecar of a scene file: `SCENE.rayscope.toml` beside it adds cameras, lights and a sky.
//!
//! ```toml
//! [[camera]]
//! name = "nave"
//! eye = [-11.0, 1.5, 0.0]
//! target = [10.0, 3.0, 0.0]
//! up = [0.0, 1.0, 0.0]
//! yfov_degrees = 60.0
//!
//! [[light]]                              # a glowing sphere, as Light::Sphere
//! position = [0.0, 7.5, 0.0]
//! radius = 0.05
//! intensity = [220.0, 210.0, 190.0]
//!
//! [environment]                          # at most one, as Environment
//! zenith = [0.9, 0.95, 1.0]
//! nadir = [0.6, 0.58, 0.55]
//! ```

use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::camera::{Camera, CameraError};
use crate::shown::shown;
use crate::{Environment, Light, files};

/// The longest sidecar that is read, bytes.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// What a sidecar adds to its scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sidecar {
    /// In the order of the file.
    pub cameras: Vec<Camera>,
    /// Spheres, in the order of the file.
    pub lights: Vec<Light>,
    /// The sky, if it has one.
    pub environment: Option<Environment>,
}

/// Why a sidecar was refused. Each message is the rest of a sentence that names the file. Lines,
/// cameras and lights are counted from 1.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum SidecarError {
    #[error("it cannot be read")]
    Read { source: io::Error },
    /// It is not TOML, or has keys or values that a sidecar does not have.
    #[error("line {line}: {}", shown(message))]
    Line { line: usize, message: String },
    #[error("camera {number} (\"{}\")", shown(name))]
    Camera { number: usize, name: String, source: CameraError },
    #[error("{what} has {field} {found}, expected {expected}")]
    Light { what: String, field: &'static str, found: String, expected: &'static str },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entries {
    #[serde(default)]
    camera: Vec<CameraEntry>,
    #[serde(default)]
    light: Vec<LightEntry>,
    environment: Option<Environment>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    name: String,
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    yfov_degrees: f32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightEntry {
    position: [f32; 3],
    radius: f32,
    intensity: [f32; 3],
}

/// Where the sidecar of a scene file is, should it have one.
pub fn path_beside(scene: &Path) -> PathBuf {
    scene.with_extension("rayscope.toml")
}

/// Reads a sidecar. `None` if there is no such file.
///
/// # Errors
/// If it cannot be read, is not a sidecar, or has impossible cameras or lights.
pub fn read(path: &Path) -> Result<Option<Sidecar>, SidecarError> {
    let text = files::read(path, MAX_FILE_BYTES).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    });
    match text {
        Ok(text) => parse(&text).map(Some),
        Err(source) if source.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(SidecarError::Read { source }),
    }
}

/// Parses the text of a sidecar.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str) -> Result<Sidecar, SidecarError> {
    let entries: Entries = toml::from_str(text).map_err(|error| SidecarError::Line {
        line: 1 + error.span().map_or(0, |span| text[..span.start].matches('\n').count()),
        message: error.message().replace('\n', " "),
    })?;
    let cameras = entries.camera.into_iter().zip(1..).map(|(entry, number)| {
        let CameraEntry { name, eye, target, up, yfov_degrees } = entry;
        let camera = Camera::look_at(&shown(&name), eye, target, up, yfov_degrees.to_radians());
        camera.map_err(|source| SidecarError::Camera { number, name, source })
    });
    let lights = entries.light.into_iter().zip(1..).map(|(entry, number)| sphere(number, &entry));
    Ok(Sidecar {
        cameras: cameras.collect::<Result<_, _>>()?,
        lights: lights.collect::<Result<_, _>>()?,
        environment: entries.environment.map(checked_sky).transpose()?,
    })
}

fn sphere(number: usize, entry: &LightEntry) -> Result<Light, SidecarError> {
    let &LightEntry { position, radius, intensity } = entry;
    let refuse = |field, found, expected| {
        let what = format!("light {number}");
        Err(SidecarError::Light { what, field, found, expected })
    };
    if !position.iter().all(|x| x.is_finite()) {
        return refuse("position", format!("{position:?}"), "finite numbers");
    }
    if !(radius > 0.0 && radius.is_finite()) {
        return refuse("radius", radius.to_string(), "a finite number above 0");
    }
    if !is_light(intensity) {
        return refuse("intensity", format!("{intensity:?}"), LIGHT);
    }
    Ok(Light::Sphere { position, radius, intensity })
}

fn checked_sky(sky: Environment) -> Result<Environment, SidecarError> {
    for (field, radiance) in [("zenith", sky.zenith), ("nadir", sky.nadir)] {
        if !radiance.iter().all(|channel| channel.is_finite() && *channel >= 0.0) {
            let (what, found) = ("the environment".into(), format!("{radiance:?}"));
            return Err(SidecarError::Light { what, field, found, expected: "finite numbers of at least 0" });
        }
    }
    Ok(sky)
}

const LIGHT: &str = "finite numbers of at least 0, one of them above";

fn is_light(color: [f32; 3]) -> bool {
    color.iter().all(|channel| channel.is_finite() && *channel >= 0.0)
        && color.iter().any(|&channel| channel > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = "[[camera]]\nname = \"a\"\neye = [0, 0, 0]\ntarget = [0, 0, -2.5]\n\
                          up = [0.0, 1.0, 0.0]\nyfov_degrees = 60.0\n";
    const LIGHT: &str = "[[light]]\nposition = [1.0, 2.0, 3.0]\nradius = 0.5\nintensity = [4.0, 5.0, 6.0]\n";

    fn error(text: &str) -> String {
        use std::error::Error;
        let error = parse(text).unwrap_err();
        match error.source() {
            Some(source) => format!("{error}: {source}"),
            None => error.to_string(),
        }
    }

    #[test]
    fn everything_is_read() {
        let sky = "[environment]\nzenith = [1, 2, 3]\nnadir = [0.25, 0, 0]\n";
        let sidecar = parse(&format!("{CAMERA}{LIGHT}{CAMERA}{sky}")).unwrap();
        assert_eq!(sidecar.cameras.len(), 2);
        assert_eq!(sidecar.cameras[0].forward, [0.0, 0.0, -1.0]);
        assert!((sidecar.cameras[0].yfov_radians - std::f32::consts::FRAC_PI_3).abs() < 1e-6);
        let [position, intensity] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        assert_eq!(sidecar.lights, [Light::Sphere { position, radius: 0.5, intensity }]);
        let environment = Environment { zenith: [1.0, 2.0, 3.0], nadir: [0.25, 0.0, 0.0] };
        assert_eq!(sidecar.environment, Some(environment));
        assert_eq!(parse("").unwrap(), Sidecar::default());
    }

    #[test]
    fn unknown_keys_are_refused_with_their_line() {
        let text = format!("{LIGHT}colour = [1, 1, 1]\n");
        let message = error(&text);
        assert!(message.starts_with("line 5: unknown field `colour`"), "{message}");
        let message = error("# nothing\n\n[camera2]\n");
        assert!(message.starts_with("line 3: unknown field `camera2`"), "{message}");
    }

    #[test]
    fn wrong_and_missing_values_are_refused_with_their_line() {
        let message = error(&LIGHT.replace("0.5", "\"wide\""));
        assert!(message.starts_with("line 3: invalid type"), "{message}");
        let message = error(&LIGHT.replace("radius = 0.5\n", ""));
        assert!(message.starts_with("line 1: missing field `radius`"), "{message}");
        assert!(!error("[[light").contains('\n'));
    }

    #[test]
    fn impossible_cameras_and_lights_are_refused() {
        let message = error(&CAMERA.replace("60.0", "180.0"));
        assert!(message.starts_with("camera 1 (\"a\"): its vertical field of view is 180°"), "{message}");
        assert!(error(&LIGHT.replace("0.5", "0.0")).starts_with("light 1 has radius 0"));
        assert!(error(&LIGHT.replace("0.5", "nan")).starts_with("light 1 has radius NaN"));
        assert!(error(&LIGHT.replace("2.0", "inf")).starts_with("light 1 has position"));
        assert!(error(&LIGHT.replace("5.0", "-5.0")).starts_with("light 1 has intensity"));
        let sky = "[environment]\nzenith = [1, 2, nan]\nnadir = [0.25, 0, 0]\n";
        assert!(error(sky).starts_with("the environment has zenith"));
    }
}
