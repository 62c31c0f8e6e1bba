//! Cameras and lights for scenes that come without, by looking around with a few rays.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use crate::camera::CameraError;
use crate::{Camera, Environment, Light, Scene};

/// How many directions [`look_around`] looks in.
const DIRECTIONS: usize = 14;
/// The first this many of them are level.
const LEVEL_DIRECTIONS: usize = 8;
/// The direction that looks up.
const UP: usize = 8;
/// An eye that sees this many fronts of surfaces is in a room or a yard. A solid thing shows only
/// backs from inside, and a window, a door or a missing roof may let some directions escape.
const ROOM_FRONTS: usize = 12;
/// A place from which no more than this many directions escape gets no light from a sky to speak of.
const CLOSED_ESCAPES: usize = 1;
/// An eye keeps this share of the scene's largest extent from all surfaces.
const MIN_CLEARANCE: f64 = 0.01;
/// Half of 60°.
const HALF_FIELD_OF_VIEW_RADIANS: f64 = TAU / 12.0;
/// Turned by so much again and again, directions stay apart however many there are.
const GOLDEN_ANGLE_RADIANS: f64 = TAU * 0.381_966_011_250_105;

/// What one ray met.
#[derive(Clone, Copy)]
struct Sight {
    /// Infinite if nothing.
    distance: f64,
    /// Whether it was the front of a triangle (anticlockwise corners).
    is_front: bool,
}

const NOTHING: Sight = Sight { distance: f64::INFINITY, is_front: false };

impl Sight {
    /// Whether it is nearer; of two coincident triangles the front counts, in any order of the
    /// threads.
    fn comes_before(self, other: Self) -> bool {
        (self.distance, !self.is_front) < (other.distance, !other.is_front)
    }
}

/// A camera named `auto`: inside if the scene is a room, where there is most space about, looking
/// along the longest view; else from above a corner, far enough to see everything.
pub(crate) fn camera(scene: &Scene) -> Result<Camera, CameraError> {
    views(scene, 1).next().unwrap_or(Err(CameraError::NoForward))
}

/// Such a camera, and others that are as unlike it and each other as can be, at most `count`: in a room from other
/// places or in other directions, else all round.
pub(crate) fn views(scene: &Scene, count: usize) -> impl Iterator<Item = Result<Camera, CameraError>> {
    let bounds = scene.bounds();
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from_array(corner.map(f64::from)));
    let room = Room::of(scene, min, max);
    let poses: Vec<(DVec3, DVec3)> = match room.first() {
        // A little down: floors have more to show than ceilings.
        Some(first) => {
            let views = room.views(first, count).into_iter();
            views.map(|view| (view.eye, view.forward - 0.1 * DVec3::Y)).collect()
        }
        None => all_round(scene, min, max, count),
    };
    let yfov_radians = (2.0 * HALF_FIELD_OF_VIEW_RADIANS) as f32;
    poses.into_iter().zip(1..).map(move |((eye, forward), number)| {
        Camera::from_axes(&view_name(number), eye, forward, DVec3::Y, yfov_radians)
    })
}

/// `auto`, `auto-2`, `auto-3` …
pub(crate) fn view_name(number: usize) -> String {
    if number == 1 { "auto".to_owned() } else { format!("auto-{number}") }
}

/// Eyes and directions from above: the first sees everything, the others most of the triangles, which may be a town in
/// the middle of a plain.
fn all_round(scene: &Scene, min: DVec3, max: DVec3, count: usize) -> Vec<(DVec3, DVec3)> {
    let whole = match 0.5 * (max - min).length() {
        0.0 => 1.0,
        radius => radius,
    };
    let distance = |radius: f64| radius / HALF_FIELD_OF_VIEW_RADIANS.sin();
    // Off every diagonal, so that flat scenes are not seen edge-on.
    let back = DVec3::new(0.75, 0.55, 1.0).normalize();
    let far = |back: DVec3| 0.5 * (min + max) + back * distance(whole);
    let backs: Vec<DVec3> = (0..count)
        .map(|number| DQuat::from_rotation_y(number as f64 * GOLDEN_ANGLE_RADIANS) * back)
        .collect();
    let near: Vec<DVec3> = match (count > 1).then(|| most(scene)) {
        Some((middle, radius)) => backs.iter().map(|&back| middle + back * distance(radius)).collect(),
        None => Vec::new(),
    };
    // Only who is inside of something sees backs.
    let is_outside = |sights: &[Sight; DIRECTIONS]| {
        sights.iter().all(|sight| sight.is_front || !sight.distance.is_finite())
    };
    let sights = look_around(scene, &near);
    let outside = near.into_iter().zip(sights).map(|(eye, sights)| is_outside(&sights).then_some(eye));
    let near = std::iter::once(None).chain(outside.skip(1));
    backs.iter().zip(near).map(|(&back, near)| (near.unwrap_or(far(back)), -back)).collect()
}

/// The middle of the triangles, and how far from there four fifths of them lie at most.
fn most(scene: &Scene) -> (DVec3, f64) {
    /// So many say enough.
    const TRIANGLES: usize = 1 << 16;

    let step = scene.triangles.len().div_ceil(TRIANGLES).max(1);
    let triangles = (0..scene.triangles.len()).step_by(step);
    let centre = |triangle| scene.corners(triangle).map(|corner| DVec3::from_array(corner.map(f64::from)));
    let centres: Vec<DVec3> =
        triangles.map(|triangle| centre(triangle).iter().sum::<DVec3>() / 3.0).collect();
    let at_share = |mut values: Vec<f64>, share: f64| {
        values.sort_by(f64::total_cmp);
        values.get((share * values.len() as f64) as usize).copied().unwrap_or_default()
    };
    let axis = |axis: usize| at_share(centres.iter().map(|centre| centre[axis]).collect(), 0.5);
    let middle = DVec3::from_array([0, 1, 2].map(axis));
    (middle, at_share(centres.iter().map(|centre| centre.distance(middle)).collect(), 0.8))
}

/// Places in a room, and what is seen from them.
struct Room {
    places: Vec<(DVec3, [Sight; DIRECTIONS])>,
    /// The scene's largest.
    extent: f64,
}

/// A place and a level direction.
#[derive(Clone, Copy)]
struct View {
    eye: DVec3,
    forward: DVec3,
    /// How far it is to what is looked at.
    distance: f64,
    /// Mean distance, by logarithms, of that and of what lies to both sides.
    depth: f64,
}

impl Room {
    /// Where one can stand in a room; nowhere if the scene is not one.
    fn of(scene: &Scene, min: DVec3, max: DVec3) -> Self {
        let extent = max - min;
        let mut eyes = Vec::new();
        // Two heights: the bounds of a house have more than one storey, or a cellar.
        for y in [0.55, 0.3] {
            for x in [0.2, 0.5, 0.8] {
                for z in [0.2, 0.5, 0.8] {
                    eyes.push(min + extent * DVec3::new(x, y, z));
                }
            }
        }
        let extent = extent.max_element();
        let clearance = MIN_CLEARANCE * extent;
        let seen = look_around(scene, &eyes);
        let is_spacious = |sights: &[Sight; DIRECTIONS]| {
            let fronts = sights.iter().filter(|sight| sight.is_front).count();
            fronts >= ROOM_FRONTS && sights.iter().all(|sight| sight.distance > clearance)
        };
        let places = eyes.into_iter().zip(seen).filter(|(_, sights)| is_spacious(sights)).collect();
        Self { places, extent }
    }

    /// Where there is most space about, along the longest view.
    fn first(&self) -> Option<View> {
        // The mean of logarithms, so that a niche with one long view does not win.
        let space = |sights: &[Sight; DIRECTIONS]| -> f64 {
            sights.iter().map(|sight| sight.distance.min(self.extent).ln()).sum()
        };
        let place = self.places.iter().max_by(|(_, a), (_, b)| space(a).total_cmp(&space(b)))?;
        self.views_from(place).max_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The level views from a place that something ends.
    fn views_from(&self, (eye, sights): &(DVec3, [Sight; DIRECTIONS])) -> impl Iterator<Item = View> {
        let (eye, directions) = (*eye, directions());
        let distances: [f64; LEVEL_DIRECTIONS] = std::array::from_fn(|at| sights[at].distance);
        let capped = distances.map(|distance| distance.min(self.extent));
        (0..LEVEL_DIRECTIONS).filter(move |&at| distances[at].is_finite()).map(move |at| {
            let side = |step: usize| capped[(at + step) % LEVEL_DIRECTIONS];
            let depth = (side(0) * side(1) * side(LEVEL_DIRECTIONS - 1)).cbrt();
            View { eye, forward: directions[at], distance: distances[at], depth }
        })
    }

    /// The first view, then always the one that is deepest and furthest from those before, by where it stands and by
    /// what it looks at.
    fn views(&self, first: View, count: usize) -> Vec<View> {
        let all: Vec<View> = self.places.iter().flat_map(|place| self.views_from(place)).collect();
        let target = |view: &View| view.eye + view.distance * view.forward;
        let apart = |a: &View, b: &View| a.eye.distance(b.eye) + target(a).distance(target(b));
        let mut chosen = vec![first];
        while chosen.len() < count {
            let value = |view: &View| {
                let nearest = chosen.iter().map(|other| apart(view, other)).fold(f64::INFINITY, f64::min);
                nearest * view.depth
            };
            match all.iter().max_by(|a, b| value(a).total_cmp(&value(b))) {
                Some(view) if value(view) > 0.0 => chosen.push(*view),
                _ => break,
            }
        }
        chosen
    }
}

/// A sky, and where `camera` is in a closed room a lamp above it, first.
pub(crate) fn lights(scene: &Scene, camera: &Camera) -> Vec<Light> {
    let sights = sights(scene, camera);
    let sky = Light::Environment(Environment { zenith: [0.9, 0.95, 1.0], nadir: [0.6, 0.58, 0.55] });
    let distances: Vec<f64> = sights.iter().map(|sight| sight.distance).filter(|d| d.is_finite()).collect();
    let height = sights[UP].distance;
    if !are_closed(&sights) {
        return vec![sky];
    }
    // Half-way to the ceiling, and as bright as makes a white wall at the mean distance white.
    let mean_distance = (distances.iter().map(|d| d.ln()).sum::<f64>() / distances.len() as f64).exp();
    let intensity = std::f64::consts::PI * mean_distance * mean_distance;
    let radius = (0.02 * mean_distance).min(0.1 * height) as f32;
    let intensity = [1.0, 0.95, 0.85].map(|channel| (channel * intensity) as f32);
    if radius == 0.0 || !intensity.iter().all(|&channel| channel.is_finite() && channel > 0.0) {
        // Too small or too large a room for a lamp in f32.
        return vec![sky];
    }
    let eye = DVec3::from_array(camera.eye.map(f64::from));
    let position = (eye + 0.5 * height * DVec3::Y).to_array().map(|x| x as f32);
    vec![Light::Sphere { position, radius, intensity }, sky]
}

/// Whether `camera` is in a room that gets no light from outside to speak of.
pub(crate) fn is_closed(scene: &Scene, camera: &Camera) -> bool {
    are_closed(&sights(scene, camera))
}

fn are_closed(sights: &[Sight; DIRECTIONS]) -> bool {
    let met = sights.iter().filter(|sight| sight.distance.is_finite()).count();
    met + CLOSED_ESCAPES >= DIRECTIONS && sights[UP].distance.is_finite()
}

/// What a camera sees about it.
fn sights(scene: &Scene, camera: &Camera) -> [Sight; DIRECTIONS] {
    let eye = DVec3::from_array(camera.eye.map(f64::from));
    look_around(scene, &[eye]).into_iter().next().unwrap_or([NOTHING; DIRECTIONS])
}

/// Unit vectors: level ones all round, up, down, and four half-way up. None lies along an axis or in
/// a diagonal plane, where the edges of built things are.
fn directions() -> [DVec3; DIRECTIONS] {
    let around = |step: usize, steps: usize, height: f64| {
        let angle = TAU * (step as f64 + 0.29) / steps as f64;
        DVec3::new(angle.cos(), height, angle.sin()).normalize()
    };
    std::array::from_fn(|index| match index {
        0..LEVEL_DIRECTIONS => around(index, LEVEL_DIRECTIONS, 0.0),
        UP => DVec3::new(0.011, 1.0, 0.007).normalize(),
        9 => DVec3::new(0.007, -1.0, 0.011).normalize(),
        _ => around(index, 4, 0.9),
    })
}

/// What every eye sees in all [`directions`]. Without a hierarchy: the few rays meet each triangle
/// once, which takes less time than building one.
fn look_around(scene: &Scene, eyes: &[DVec3]) -> Vec<[Sight; DIRECTIONS]> {
    /// Enough work for a thread to be woken.
    const TRIANGLES_AT_A_TIME: usize = 4096;

    let directions = directions();
    let nothing = || vec![[NOTHING; DIRECTIONS]; eyes.len()];
    let look_at = |mut seen: Vec<[Sight; DIRECTIONS]>, triangles: &[[u32; 3]]| {
        for triangle in triangles {
            let [a, b, c] =
                triangle.map(|vertex| DVec3::from_array(scene.positions[vertex as usize].map(f64::from)));
            let edges = [b - a, c - a];
            for (sights, &eye) in seen.iter_mut().zip(eyes) {
                let corner = Corner { from_eye: a - eye, edges };
                for (sight, &direction) in sights.iter_mut().zip(&directions) {
                    if let Some(nearer) = corner.sight(direction, *sight) {
                        *sight = nearer;
                    }
                }
            }
        }
        seen
    };
    let nearest = |mut a: Vec<[Sight; DIRECTIONS]>, b: Vec<[Sight; DIRECTIONS]>| {
        for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
            if b.comes_before(*a) {
                *a = *b;
            }
        }
        a
    };
    let pieces = scene.triangles.par_chunks(TRIANGLES_AT_A_TIME);
    pieces.fold(nothing, look_at).reduce(nothing, nearest)
}

/// A triangle, seen from an eye.
struct Corner {
    from_eye: DVec3,
    edges: [DVec3; 2],
}

impl Corner {
    /// The intersection with a ray from the eye, if it comes before `known` (Möller & Trumbore
    /// 1997). A ray that slips through between two triangles does no harm here.
    fn sight(&self, direction: DVec3, known: Sight) -> Option<Sight> {
        let [ab, ac] = self.edges;
        let across = direction.cross(ac);
        let determinant = ab.dot(across);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let u = -self.from_eye.dot(across) * inverse;
        let turned = ab.cross(self.from_eye);
        let v = direction.dot(turned) * inverse;
        let distance = ac.dot(turned) * inverse;
        let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
        let sight = Sight { distance, is_front: determinant > 0.0 };
        (is_hit && sight.comes_before(known)).then_some(sight)
    }
}
