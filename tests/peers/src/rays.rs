//! The scene and the rays of a recording.

use std::path::Path;

use anyhow::{Result, ensure};
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

/// So many rays a queue has at least, if there are so many: of a shorter one, traced again and again, a processor
/// learns by heart where each ray branches.
const ENOUGH: usize = 1 << 16;

/// Name, kind and bounce; see [`shuffled`] for those that are.
const QUEUES: [(&str, Kind, u32); 5] = [
    ("camera", Kind::Closest, 0),
    ("secondary", Kind::Closest, 2),
    ("shuffled", Kind::Closest, 2),
    ("shadow", Kind::Shadow, 0),
    ("secondary-shadow", Kind::Shadow, 2),
];

/// The triangles of a recording, without its alpha masks, which peers have no word for, and the queues whose names
/// are wanted, all of them if none is: of the last pass, and of those before it that were kept until rays are enough.
///
/// # Errors
/// If the recording cannot be read or has no such queue.
pub fn read(path: &Path, wanted: &[String]) -> Result<(Scene, Vec<Queue>)> {
    let dump = Dump::open(path)?;
    let positions = dump.array::<[f32; 3]>(&Place::Scene(SceneArray::Positions))?.to_vec();
    let triangles = dump.array::<[u32; 3]>(&Place::Scene(SceneArray::Triangles))?.to_vec();
    let header = &dump.manifest().header;
    let passes = 0..header.options.passes;
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name);
    let queue = |(name, kind, bounce)| {
        let mut rays = Vec::new();
        for pass in passes.clone().rev() {
            let place = Place::Queue(QueueId { pass, bounce, kind }, QueueArray::Rays);
            if rays.len() < ENOUGH && dump.has(&place) {
                rays.extend_from_slice(&dump.array::<Ray>(&place)?);
            }
        }
        ensure!(
            !rays.is_empty(),
            "no {name} rays in {}; record at least 3 bounces of a scene with lights",
            path.display()
        );
        if name == "shuffled" {
            fastrand::Rng::with_seed(1).shuffle(&mut rays);
        }
        Ok(Queue { name, kind, rays })
    };
    let queues: Result<Vec<Queue>> =
        QUEUES.into_iter().filter(|(name, ..)| is_wanted(name)).map(queue).collect();
    Ok((Scene::of_geometry(header.scene.name.clone(), positions, triangles), queues?))
}
