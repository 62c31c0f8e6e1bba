//! Traced lengths: the rays of a queue and what came of them (docs/keys.md, "Traced length").

use std::path::PathBuf;

use rayon::prelude::*;

use crate::manifest::{Place, QueueArray, QueueId};
use crate::ray::{Hit, Kind, Ray};
use crate::reader::{Dump, Loaded, ReadError};
use crate::unit_space::UnitSpace;

/// Why a queue has no traced lengths.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what its fields mean")]
pub enum TracedError {
    /// Its rays, or their hits or distances, were not kept or cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Arrays of one queue that do not belong together.
    #[error(
        "{}: {queue} has {rays} rays and {results} results of them; `inspector verify` says what is wrong",
        dump.display()
    )]
    Lengths { dump: PathBuf, queue: QueueId, rays: usize, results: usize },
}

/// The rays of a queue and what came of them, equally many, in canonical order.
#[derive(Debug)]
pub struct Traced {
    unit: UnitSpace,
    rays: Loaded<Ray>,
    results: Results,
}

/// What came of a queue's rays.
#[derive(Debug)]
pub enum Results {
    /// Of closest rays.
    Hits(Loaded<Hit>),
    /// Of shadow rays: world units to the occluder, `+inf` for none.
    Distances(Loaded<f32>),
}

impl Results {
    fn len(&self) -> usize {
        match self {
            Self::Hits(hits) => hits.len(),
            Self::Distances(distances) => distances.len(),
        }
    }
}

impl Traced {
    /// Loads the rays of a queue and their results, those of its source if the dump is a replay.
    ///
    /// # Errors
    /// If either was not kept, cannot be read, or they do not belong together.
    pub fn open(dump: &Dump, queue: QueueId) -> Result<Self, TracedError> {
        let place = |array| Place::Queue(queue, array);
        let scene = &dump.manifest().header.scene;
        let rays: Loaded<Ray> = dump.array(&place(QueueArray::Rays))?;
        let results = match queue.kind {
            Kind::Closest => Results::Hits(dump.array(&place(QueueArray::Hits))?),
            Kind::Shadow => Results::Distances(dump.array(&place(QueueArray::Distances))?),
        };
        if results.len() != rays.len() {
            return Err(TracedError::Lengths {
                dump: dump.root().to_owned(),
                queue,
                rays: rays.len(),
                results: results.len(),
            });
        }
        Ok(Self { unit: UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max), rays, results })
    }

    /// The map from the rays' world space to unit space.
    pub fn unit(&self) -> &UnitSpace {
        &self.unit
    }

    /// The rays, world space.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// What came of them.
    pub fn results(&self) -> &Results {
        &self.results
    }

    /// Traced lengths of all rays in unit lengths, by all threads.
    pub fn lengths(&self) -> Vec<f32> {
        (0..self.rays.len()).into_par_iter().map(|ray| self.length(ray)).collect()
    }

    /// Whether a ray ended at a surface.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn is_at_surface(&self, ray: usize) -> bool {
        match &self.results {
            Results::Hits(hits) => hits[ray].is_hit(),
            Results::Distances(distances) => distances[ray].is_finite(),
        }
    }

    /// Traced length of a ray in unit lengths.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn length(&self, index: usize) -> f32 {
        let ray = &self.rays[index];
        match &self.results {
            Results::Hits(hits) => self.unit.closest_length(ray, &hits[index]),
            Results::Distances(distances) => self.unit.shadow_length(ray, distances[index]),
        }
    }
}
