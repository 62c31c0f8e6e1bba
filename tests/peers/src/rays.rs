//! The scene and the rays of a recording.

use std::path::Path;

use anyhow::{Context, Result};
use formats::manifest::{Place, QueueArray, QueueId, SceneArray};
use formats::ray::{Kind, Ray};
use formats::reader::Dump;
use scenes::Scene;

/// Rays of one kind, in the order in which they are traced.
pub struct Queue {
    /// What they are called in tables.
    pub name: &'static str,
    /// Nearest hits or any.
    pub kind: Kind,
    /// The rays.
    pub rays: Vec<Ray>,
}

/// Name, kind and bounce; see [`shuffled`] for those that are.
const QUEUES: [(&str, Kind, u32); 5] = [
    ("camera", Kind::Closest, 0),
    ("secondary", Kind::Closest, 2),
    ("shuffled", Kind::Closest, 2),
    ("shadow", Kind::Shadow, 0),
    ("secondary-shadow", Kind::Shadow, 2),
];

/// The triangles of a recording, without its alpha masks, which peers have no word for, and the queues of its
/// last pass whose names are wanted, all of them if none is.
///
/// # Errors
/// If the recording cannot be read or has no such queue.
pub fn read(path: &Path, wanted: &[String]) -> Result<(Scene, Vec<Queue>)> {
    let dump = Dump::open(path)?;
    let positions = dump.array::<[f32; 3]>(&Place::Scene(SceneArray::Positions))?.to_vec();
    let triangles = dump.array::<[u32; 3]>(&Place::Scene(SceneArray::Triangles))?.to_vec();
    let header = &dump.manifest().header;
    let pass = header.options.passes - 1;
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name);
    let queue = |(name, kind, bounce)| {
        let place = Place::Queue(QueueId { pass, bounce, kind }, QueueArray::Rays);
        let rays = dump.array::<Ray>(&place).with_context(|| {
            format!("no {name} rays in {}; record at least 3 bounces of a scene with lights", path.display())
        })?;
        let rays = if name == "shuffled" { shuffled(&rays) } else { rays.to_vec() };
        Ok(Queue { name, kind, rays })
    };
    let queues: Result<Vec<Queue>> =
        QUEUES.into_iter().filter(|(name, ..)| is_wanted(name)).map(queue).collect();
    Ok((Scene::of_geometry(header.scene.name.clone(), positions, triangles), queues?))
}

/// Without any order.
fn shuffled(rays: &[Ray]) -> Vec<Ray> {
    let mut shuffled = rays.to_vec();
    fastrand::Rng::with_seed(1).shuffle(&mut shuffled);
    shuffled
}
