//! The image of a recording and what each of its pixels cost.

use formats::manifest::{Place, QueueArray, QueueId};
use formats::metrics::lanes::work_of;
use formats::reader::{Dump, Loaded};

use super::{Metric, work};

/// The image and the work behind each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelCost {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Linear RGB, top row first.
    pub image: Vec<[f32; 3]>,
    /// Nodes visited and triangles tested for each pixel, over all bounces and both kinds of one pass.
    pub work: Vec<u32>,
    /// That pass.
    pub pass: u32,
}

impl PixelCost {
    /// Of the last pass whose work was kept.
    pub fn of(dump: &Dump) -> Metric<Self> {
        Self::read(dump).into()
    }

    fn read(dump: &Dump) -> Result<Self, String> {
        let manifest = dump.manifest();
        let options = &manifest.header.options;
        let (width, height) = (options.width, options.height);
        let pixels = u64::from(width) * u64::from(height);
        let image: Loaded<[f32; 3]> = dump.array(&Place::Image).map_err(|error| error.to_string())?;
        if image.len() as u64 != pixels {
            return Err(format!("the image has {} pixels, expected {width}×{height}", image.len()));
        }
        let has_work = |queue: &QueueId| dump.has(&Place::Queue(*queue, QueueArray::Work));
        let queues: Vec<QueueId> = manifest.queues.iter().map(|queue| queue.id).filter(has_work).collect();
        let pass = queues.iter().map(|queue| queue.pass).max();
        let pass = pass.ok_or("the work of the rays was not kept (`--keep` with work)")?;
        let mut cost = vec![0u32; image.len()];
        for &queue in queues.iter().filter(|queue| queue.pass == pass) {
            add(dump, queue, &mut cost)?;
        }
        Ok(Self { width, height, image: image.to_vec(), work: cost, pass })
    }
}

fn add(dump: &Dump, queue: QueueId, cost: &mut [u32]) -> Result<(), String> {
    let text = |error: formats::reader::ReadError| error.to_string();
    let work = work::work(dump, queue)?;
    let paths: Loaded<u32> = dump.array(&Place::Queue(queue, QueueArray::PathIds)).map_err(text)?;
    if work.len() != paths.len() {
        return Err(format!("{queue}/work.npy has {} rays, path_ids.npy {}", work.len(), paths.len()));
    }
    for (work, &path) in work.iter().zip(&*paths) {
        let pixels = cost.len();
        let pixel = cost.get_mut(path as usize);
        let pixel = pixel.ok_or_else(|| format!("{queue}/path_ids.npy names path {path} of {pixels}"))?;
        *pixel = pixel.saturating_add(work_of(work).min(u32::MAX.into()) as u32);
    }
    Ok(())
}
