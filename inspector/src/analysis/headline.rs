//! One view, unsorted and sorted: how large the capsule is of the group that each pixel's ray is traced with.

use std::cmp::Ordering;

use formats::key::method::UNSORTED;
use formats::manifest::{Place, QueueArray, QueueId};
use formats::metrics::group::Group;
use formats::metrics::order::Places;
use formats::ray::Kind;
use formats::reader::{Dump, Loaded};
use formats::traced::Traced;

use super::frame::traced;
use super::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// The first queue of secondary rays, in canonical order and in the one that gains most.
#[derive(Clone, Debug, PartialEq)]
pub struct Headline {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Bounce of the queue.
    pub bounce: u32,
    /// Unsorted, sorted.
    pub views: [View; 2],
}

/// One order of the queue.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The method, or `unsorted`.
    pub method: String,
    /// Trace of unsorted rays over that in this order, median over rounds; 1 for unsorted ones.
    pub speedup: f64,
    /// The same over all that the order costs; `None` if that is not known.
    pub net: Option<f64>,
    /// Rays traced a second in this order, millions: unsorted ones by the median of their trace, sorted ones as many
    /// times that as the speedup says, so that both say the same.
    pub mrays_per_second: f64,
    /// For each pixel, top row first, the area of the capsule around the group that its ray is in, unit space; none
    /// where a pixel has no ray.
    pub areas: Vec<Option<f64>>,
}

impl Headline {
    /// Of a recording, by the method of `methods` that has the best net speedup of that queue, or else the best of the
    /// trace.
    pub fn of(recording: &RecordingAnalysis, methods: &[&str], group_width: usize) -> Metric<Self> {
        let read = || -> Result<Self, String> {
            let is_first = |queue: &&QueueAnalysis| queue.kind == Kind::Closest && queue.bounce > 0;
            let queue = recording.measured().filter(is_first).min_by_key(|queue| queue.bounce);
            let queue = queue.ok_or("no method was measured on secondary rays")?;
            let unsorted = queue.order(UNSORTED).ok_or("the trace of unsorted rays was not timed")?;
            let rate = traced(unsorted).ok_or("the trace of unsorted rays was not timed")?.mrays_per_second;
            let sorted = best(queue, methods).ok_or("no method has a trace speedup of secondary rays")?;
            let dump = Dump::open(&recording.root).map_err(|error| error.to_string())?;
            let pixels = Pixels::open(&dump, recording, queue, group_width)?;
            let (width, height) = (recording.options.width, recording.options.height);
            let view = |order: &OrderAnalysis, speedup: f64, net| -> Result<View, String> {
                let (method, areas) = (order.method.clone(), pixels.areas(&order.method)?);
                Ok(View { method, speedup, net, mrays_per_second: rate * speedup, areas })
            };
            let (order, speedup, net) = sorted;
            let views = [view(unsorted, 1.0, None)?, view(order, speedup, net)?];
            Ok(Self { width, height, bounce: queue.bounce, views })
        };
        read().into()
    }
}

/// The order that gains most, how many times as fast as unsorted rays it is traced, and net of all.
fn best<'a>(queue: &'a QueueAnalysis, methods: &[&str]) -> Option<(&'a OrderAnalysis, f64, Option<f64>)> {
    let is_meant =
        |order: &&OrderAnalysis| methods.contains(&order.method.as_str()) && !order.is_left_alone();
    let known = queue.orders.iter().filter(is_meant).filter_map(|order| {
        Some((order, order.trace_speedup.known()?.ratio, order.net_speedup.known().map(|line| line.ratio)))
    });
    // None is less than any number.
    known.max_by(|(_, a, net_a), (_, b, net_b)| {
        net_a.partial_cmp(net_b).unwrap_or(Ordering::Equal).then(a.total_cmp(b))
    })
}

/// What the views of a queue share.
struct Pixels<'a> {
    dump: &'a Dump,
    queue: QueueId,
    traced: Traced,
    lengths: Vec<f32>,
    paths: Loaded<u32>,
    count: usize,
    group_width: usize,
}

impl<'a> Pixels<'a> {
    fn open(
        dump: &'a Dump,
        recording: &RecordingAnalysis,
        queue: &QueueAnalysis,
        group_width: usize,
    ) -> Result<Self, String> {
        let queue = queue.id();
        let traced = Traced::open(dump, queue).map_err(|error| error.to_string())?;
        let paths: Loaded<u32> =
            dump.array(&Place::Queue(queue, QueueArray::PathIds)).map_err(|error| error.to_string())?;
        let (rays, named) = (traced.rays().len(), paths.len());
        if named != rays {
            return Err(format!(
                "{queue}/path_ids.npy has {named} entries for {rays} rays; `inspector verify` says what is wrong"
            ));
        }
        // What a header says is believed where there are as many pixels.
        let image: Loaded<[f32; 3]> = dump.array(&Place::Image).map_err(|error| error.to_string())?;
        let (width, height, count) = (recording.options.width, recording.options.height, image.len());
        if u64::from(width) * u64::from(height) != count as u64 {
            return Err(format!("the image has {count} pixels, expected {width}×{height}"));
        }
        if let Some(path) = paths.iter().find(|&&path| path as usize >= count) {
            return Err(format!("{queue}/path_ids.npy names path {path} of {count}"));
        }
        Ok(Self { dump, queue, lengths: traced.lengths(), traced, paths, count, group_width })
    }

    /// For each pixel the area of its group by a method.
    fn areas(&self, method: &str) -> Result<Vec<Option<f64>>, String> {
        let of_group = |rays: &[u32]| {
            let group = Group::of(&self.traced, &self.lengths, None, rays.iter().map(|&ray| ray as usize));
            let area = group.map(|group| group.area).filter(|area| area.is_finite());
            rays.iter().map(|&ray| (self.paths[ray as usize], area)).collect::<Vec<_>>()
        };
        let of_chunk = |rays: &[u32]| rays.chunks(self.group_width).flat_map(of_group).collect::<Vec<_>>();
        let mut areas = vec![None; self.count];
        let places = Places::open(self.dump, self.queue, method, self.traced.rays().len())?;
        for (path, area) in places.chunks(of_chunk).into_iter().flatten() {
            areas[path as usize] = area;
        }
        Ok(areas)
    }
}
