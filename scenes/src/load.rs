//! The one way in: from what a user types to a scene that is complete.

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};

use crate::builtin::{self, BuiltinError};
use crate::bvh::EXTENT_LIMIT;
use crate::camera::CameraError;
use crate::gltf::{self, GltfError};
use crate::shown::{shown, shown_path};
use crate::sidecar::{self, Sidecar, SidecarError};
use crate::{Camera, Environment, Light, Scene, automatic, brightness, files};

/// The longest scene file that is read, bytes: a GLB file counts its bytes with 32 bits.
const MAX_FILE_BYTES: u64 = u32::MAX as u64;

/// What a built-in scene's name starts with.
const BUILTIN_PREFIX: &str = "builtin:";

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum LoadError {
    /// No such file, one that may not be read, or a folder or device.
    #[error("cannot read {}", shown_path(path))]
    Read { path: PathBuf, source: io::Error },
    #[error("{} is empty, expected a glTF or GLB file", shown_path(path))]
    Empty { path: PathBuf },
    #[error(
        "{} is not a scene, expected a name that ends in .gltf or .glb, or builtin:NAME",
        shown_path(path)
    )]
    UnknownFormat { path: PathBuf },
    #[error("cannot load {}", shown_path(path))]
    Gltf { path: PathBuf, source: GltfError },
    #[error("cannot use the sidecar {}", shown_path(path))]
    Sidecar { path: PathBuf, source: SidecarError },
    #[error(
        "{} has no camera and none can be made for it; give it one in {}",
        shown_path(path),
        shown_path(sidecar)
    )]
    AutomaticCamera { path: PathBuf, sidecar: PathBuf, source: CameraError },
    /// Rays would miss all of its triangles. Compressed ones, which are not read, may all be one point.
    #[error(
        "cannot trace {}, which is {extent:?} units large, expected at least {EXTENT_LIMIT:.1e}; scale the scene up, or export it without compression",
        shown_path(path)
    )]
    TooSmall { path: PathBuf, extent: f32 },
    /// No such built-in scene, or not of this size.
    #[error(transparent)]
    Builtin(#[from] BuiltinError),
    #[error(
        "\"{}\" is not a parameter of a built-in scene, expected triangles=N, as in builtin:atrium?triangles=100000",
        shown(parameter)
    )]
    BuiltinParameter { parameter: String },
}

/// Loads a scene from a `.gltf` or `.glb` file, with the sidecar beside it, or builds
/// `builtin:NAME` or `builtin:NAME?triangles=N`.
///
/// Cameras: those of the file, then those of the sidecar, names made unique; without any, one named
/// `auto` that sees the scene. Lights: punctual lights of the file, spheres of the sidecar, emissive
/// primitives, environment; without any, or with none but dim emissive ones, a sky, and a sphere if the
/// camera is in a closed room.
/// What was made up is said in the scene's notices.
///
/// # Errors
/// If there is no such scene or it cannot be traced, in one sentence that says why.
pub fn load(source: &str) -> Result<Scene, LoadError> {
    match source.strip_prefix(BUILTIN_PREFIX) {
        Some(name) => load_builtin(name),
        None => load_file(Path::new(source)),
    }
}

fn load_builtin(name: &str) -> Result<Scene, LoadError> {
    let (name, parameter) =
        name.split_once('?').map_or((name, None), |(name, parameter)| (name, Some(parameter)));
    let count = |parameter: &str| match parameter.strip_prefix("triangles=").map(str::parse) {
        Some(Ok(count)) => Ok(count),
        _ => Err(LoadError::BuiltinParameter { parameter: parameter.into() }),
    };
    Ok(builtin::build(name, parameter.map(count).transpose()?)?)
}

fn load_file(path: &Path) -> Result<Scene, LoadError> {
    let bytes = read_file(path)?;
    let name = path.file_stem().map_or_else(String::new, |stem| shown(&stem.to_string_lossy()));
    let folder = path.parent().unwrap_or(Path::new(""));
    let scene = gltf::import(name, &bytes, folder);
    drop(bytes);
    let mut scene = scene.map_err(|source| LoadError::Gltf { path: path.into(), source })?;
    let extent = scene.bounds().extent().into_iter().fold(0.0, f32::max);
    if extent < EXTENT_LIMIT {
        return Err(LoadError::TooSmall { path: path.into(), extent });
    }

    let sidecar_path = sidecar::path_beside(path);
    match sidecar::read(&sidecar_path) {
        Ok(Some(sidecar)) => add_sidecar(&mut scene, sidecar),
        Ok(None) => {}
        Err(source) => return Err(LoadError::Sidecar { path: sidecar_path, source }),
    }
    make_names_unique(&mut scene.cameras);
    if let Err(source) = complete(&mut scene, &sidecar_path) {
        return Err(LoadError::AutomaticCamera { path: path.into(), sidecar: sidecar_path, source });
    }
    Ok(scene)
}

/// The bytes of what is a scene file by its name and kind.
fn read_file(path: &Path) -> Result<Vec<u8>, LoadError> {
    let is_scene = |extension: &std::ffi::OsStr| {
        extension.eq_ignore_ascii_case("gltf") || extension.eq_ignore_ascii_case("glb")
    };
    if !path.extension().is_some_and(is_scene) {
        return Err(LoadError::UnknownFormat { path: path.into() });
    }
    let bytes =
        files::read(path, MAX_FILE_BYTES).map_err(|source| LoadError::Read { path: path.into(), source })?;
    match bytes.is_empty() {
        true => Err(LoadError::Empty { path: path.into() }),
        false => Ok(bytes),
    }
}

/// Adds what a sidecar has, in the order that numbers lights.
fn add_sidecar(scene: &mut Scene, sidecar: Sidecar) {
    scene.cameras.extend(sidecar.cameras);
    let sky = sidecar.environment.map(Light::Environment);
    add_lights(&mut scene.lights, sidecar.lights.into_iter().chain(sky).collect());
}

/// Appends numbers to names that are taken.
fn make_names_unique(cameras: &mut [Camera]) {
    let mut taken = HashSet::new();
    // Per name, what to try next: counting up from 2 for each camera would take quadratic time.
    let mut next: HashMap<String, u64> = HashMap::new();
    for camera in cameras {
        let name = camera.name.clone();
        while !taken.insert(camera.name.clone()) {
            let number = next.entry(name.clone()).or_insert(2);
            camera.name = format!("{name}-{number}");
            *number += 1;
        }
    }
}

/// Makes up a camera and a light where there is none, and says if the picture will be black.
fn complete(scene: &mut Scene, sidecar: &Path) -> Result<(), CameraError> {
    if scene.cameras.is_empty() {
        let camera = automatic::camera(scene)?;
        scene.cameras.push(camera);
        scene.notices.push("no camera was found: \"auto\" was made to see the scene".into());
    }
    // Who places a light wants it; surfaces that glow a little are no reason to leave out the sky.
    let has_placed = scene.lights.iter().any(|light| !matches!(light, Light::Emissive { .. }));
    let is_dark = brightness::is_dark(scene, &scene.cameras[0]);
    if scene.lights.is_empty() || is_dark && !has_placed {
        let found =
            if scene.lights.is_empty() { "no light was found" } else { "what glows is too dim to see by" };
        let lights = automatic::lights(scene, &scene.cameras[0]);
        let what = match lights.len() {
            1 => "a sky was",
            _ => "a sky and a lamp in the room of the first camera were",
        };
        add_lights(&mut scene.lights, lights);
        scene.notices.push(format!("{found}: {what} made"));
    } else if is_dark {
        let help = help_against_darkness(&automatic::lights(scene, &scene.cameras[0]));
        scene.notices.push(format!(
            "the first camera's picture will be nearly black, since the lights are too dim or cannot reach what it sees; {help} in {} would help",
            shown_path(sidecar)
        ));
    }
    Ok(())
}

/// Adds lights where they belong in the order that numbers them: spheres before what glows, a sky last.
fn add_lights(lights: &mut Vec<Light>, more: Vec<Light>) {
    let (sky, spheres): (Vec<_>, Vec<_>) =
        more.into_iter().partition(|light| matches!(light, Light::Environment(_)));
    let is_emissive = |light: &Light| matches!(light, Light::Emissive { .. });
    let place = lights.iter().position(is_emissive).unwrap_or(lights.len());
    lights.splice(place..place, spheres);
    lights.extend(sky);
}

/// The lines of a sidecar that would light the scene as these lights do, on one line.
fn help_against_darkness(lights: &[Light]) -> String {
    match lights.first() {
        Some(Light::Sphere { position, radius, intensity }) => format!(
            "a [[light]] with position = {position:?}, radius = {radius:?}, intensity = {intensity:?}"
        ),
        Some(Light::Environment(Environment { zenith, nadir })) => {
            format!("an [environment] with zenith = {zenith:?}, nadir = {nadir:?}")
        }
        _ => "a [[light]]".into(),
    }
}
