//! Views of any scene chosen automatically: `auto`, `auto-2` …

use crate::camera::CameraError;
use crate::{Camera, Scene, automatic};

/// The most that are chosen.
pub const VIEWS_MAX: u32 = 16;

/// Names of the first `count`.
pub fn names(count: u32) -> Vec<String> {
    (1..=count as usize).map(automatic::view_name).collect()
}

/// The view of this name: the first is what a scene without cameras is seen from, later ones are as unlike those
/// before as can be. The same scene has the same views on every machine. `None` if no view is called so, or
/// the scene has none that many.
///
/// # Errors
/// If the scene is so small or large that no camera can be made for it.
pub fn view(scene: &Scene, name: &str) -> Option<Result<Camera, CameraError>> {
    let count = names(VIEWS_MAX).iter().position(|known| known == name)? + 1;
    automatic::views(scene, count).nth(count - 1)
}
