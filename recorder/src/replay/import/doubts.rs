//! What imported rays may have wrong without being impossible: an end or a path that was left out, another space than
//! the scene's.

use formats::key::LightSite;
use formats::ray::{Kind, Ray};
use scenes::Scene;

use super::queues::{Queue, Queues};

/// Share of the scene's largest side that a ray may start outside of its box without a word: a camera may.
const NEAR: f64 = 1.0;

/// Sentences on what looks wrong; the last one, which there always is, says where rays start and where the scene lies.
pub(super) fn of(queues: &Queues, scene: &Scene, lights: &[LightSite]) -> Vec<String> {
    let of_all_rays = [far_away(queues, scene), endless(queues, lights)];
    let strays = queues.list.iter().filter_map(|queue| stray_paths(queues, queue));
    of_all_rays.into_iter().flatten().chain(strays).chain(Some(places(queues, scene))).collect()
}

fn rays(queues: &Queues) -> impl Iterator<Item = &Ray> {
    queues.list.iter().flat_map(|queue| &queue.rays)
}

/// How many rays start far outside of the scene, if any do: keys end at its box, and one such ray has a capsule that
/// outweighs all others.
fn far_away(queues: &Queues, scene: &Scene) -> Option<String> {
    let bounds = scene.bounds();
    let (low, high) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
    let side = (0..3).map(|axis| high[axis] - low[axis]).fold(f64::MIN_POSITIVE, f64::max);
    let outside = |ray: &Ray| {
        let beyond = |axis: usize| {
            let at = f64::from(ray.origin[axis]);
            (low[axis] - at).max(at - high[axis])
        };
        (0..3).map(beyond).fold(0.0, f64::max) / side
    };
    let far: Vec<f64> = rays(queues).map(outside).filter(|sides| *sides > NEAR).collect();
    let farthest = far.iter().copied().fold(0.0, f64::max);
    (!far.is_empty()).then(|| {
        format!(
            "{} of {} rays start far outside of the scene, the farthest {farthest:.2e} times its largest side from \
             its box: they have the keys of rays at its border, and means of capsule areas are mostly theirs",
            far.len(),
            rays(queues).count()
        )
    })
}

/// How many shadow rays go on behind a light that has a place.
fn endless(queues: &Queues, lights: &[LightSite]) -> Option<String> {
    let is_placed = |light: &u32| matches!(lights.get(*light as usize), Some(LightSite::Placed { .. }));
    let shadow = || queues.list.iter().filter(|queue| queue.id.kind == Kind::Shadow);
    let endless = shadow().flat_map(|queue| queue.rays.iter().zip(&queue.lights));
    let endless = endless.filter(|(ray, light)| ray.t_max.is_infinite() && is_placed(light)).count();
    let all: usize = shadow().map(|queue| queue.rays.len()).sum();
    (endless > 0).then(|| {
        format!(
            "{endless} of {all} shadow rays have no end (t_max is infinite): what lies behind their lights is in \
             their way, too"
        )
    })
}

/// A later queue has the paths that are left, which are hardly the first ones.
fn stray_paths(queues: &Queues, queue: &Queue) -> Option<String> {
    let count = queue.rays.len();
    let is_shorter = queues.list.iter().any(|other| other.id < queue.id && other.rays.len() > count);
    let are_first = queue.path_ids.iter().zip(0..).all(|(&path, at): (_, u32)| path == at);
    (is_shorter && are_first).then(|| {
        format!(
            "bounce {}, {}: fewer rays than before, of paths 0 to {}; without the right path_ids.npy rays of \
             different paths are joined",
            queue.id.bounce,
            queue.id.kind,
            count - 1
        )
    })
}

fn places(queues: &Queues, scene: &Scene) -> String {
    let ends = [(f32::INFINITY, f32::min as fn(f32, f32) -> f32), (f32::NEG_INFINITY, f32::max)];
    let [low, high] = ends
        .map(|(none, pick)| [0, 1, 2].map(|axis| rays(queues).map(|ray| ray.origin[axis]).fold(none, pick)));
    let bounds = scene.bounds();
    // Five digits, whatever the unit.
    let digits =
        |x: f32| if x == 0.0 { 0 } else { (4.0 - x.abs().log10().floor()).clamp(0.0, 45.0) as usize };
    let number = |x: f32| format!("{x:.0$}", digits(x));
    let corner = |corner: [f32; 3]| format!("({})", corner.map(number).join(", "));
    let [low, high, min, max] = [low, high, bounds.min, bounds.max].map(corner);
    format!("rays start between {low} and {high}; the scene lies between {min} and {max}")
}
