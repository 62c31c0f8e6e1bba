//! The paths of pixels through all bounces of a pass.

use formats::key::method::UNSORTED;
use formats::manifest::{MethodArray, Place, QueueArray, QueueId};
use formats::metrics::capsule::Segment;
use formats::ray::Kind;
use formats::reader::{Dump, Loaded};
use formats::traced::Traced;
use rayon::prelude::*;

/// A ray of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRay {
    /// Its path.
    pub path: u32,
    /// Its queue.
    pub queue: QueueId,
    /// Its canonical index there.
    pub ray: usize,
    /// From its origin to where it ended, unit space.
    pub segment: Segment,
    /// Traced length, unit lengths.
    pub length: f32,
    /// Whether it ended at a surface.
    pub is_at_surface: bool,
    /// What its path carries when it leaves, linear RGB, or why that is not known; shadow rays have none.
    pub throughput: Option<Result<[f32; 3], String>>,
    /// Its place in orders A and B; `None` where the queue has no such order.
    pub places: [Option<usize>; 2],
}

/// What was traced in a queue, and which of its rays are on some paths: path and canonical index, as the paths come.
///
/// # Errors
/// If its arrays were not kept.
pub fn on_paths(dump: &Dump, queue: QueueId, paths: &[u32]) -> Result<(Traced, Vec<(u32, usize)>), String> {
    let place = Place::Queue(queue, QueueArray::PathIds);
    let path_ids: Loaded<u32> = dump.array(&place).map_err(|error| error.to_string())?;
    let traced = Traced::open(dump, queue).map_err(|error| error.to_string())?;
    let found = paths.iter().filter_map(|&path| Some((path, path_ids.binary_search(&path).ok()?)));
    let rays = found.filter(|(_, ray)| *ray < traced.rays().len()).collect();
    Ok((traced, rays))
}

impl PathRay {
    /// The rays of paths in a queue; none where its arrays were not kept.
    pub(super) fn of(dump: &Dump, queue: QueueId, paths: &[u32], methods: &[Option<String>; 2]) -> Vec<Self> {
        let Ok((traced, rays)) = on_paths(dump, queue, paths) else { return Vec::new() };
        let place = |method: &Option<String>, ray: usize| match method.as_deref()? {
            UNSORTED => Some(ray),
            method => {
                let place = Place::Method(queue, method.to_owned(), MethodArray::Permutation);
                let order: Loaded<u32> = dump.array(&place).ok()?;
                order.par_iter().position_any(|&index| index as usize == ray)
            }
        };
        let place_of_throughput = Place::Queue(queue, QueueArray::Throughput);
        let carried = (queue.kind == Kind::Closest).then(|| dump.array::<[f32; 3]>(&place_of_throughput));
        let throughput = |ray: usize| match carried.as_ref()? {
            Ok(carried) => carried.get(ray).map(|carried| Ok(*carried)),
            Err(reason) => Some(Err(reason.to_string())),
        };
        let of = |(path, ray)| {
            let length = traced.length(ray);
            Self {
                path,
                queue,
                ray,
                segment: Segment::of(traced.unit(), &traced.rays()[ray], length),
                length,
                is_at_surface: traced.is_at_surface(ray),
                throughput: throughput(ray),
                places: methods.each_ref().map(|method| place(method, ray)),
            }
        };
        rays.into_iter().map(of).collect()
    }
}
