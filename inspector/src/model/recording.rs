//! An open recording.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use formats::folder::dump_of_partial;
use formats::hierarchy::Hierarchy;
use formats::key::method::{AUTO, UNSORTED, is_method_name};
use formats::manifest::{Header, MethodRecord, QueueId, QueueRecord, Source};
use formats::metrics::frame::{Frame, leaves_all_alone};
use formats::ray::Kind;
use formats::reader::{Dump, ReadError};
use formats::unit_space::UnitSpace;

use crate::analysis::image_plane::ImagePlane;
use crate::analysis::ranking::best;
use crate::analysis::{self, Depth, QueueAnalysis, RecordingAnalysis, Versus};
use crate::shown;

/// An open recording with its times.
#[derive(Debug)]
pub struct Recording {
    /// The dump.
    pub dump: Arc<Dump>,
    /// Its times; arrays are not read for them. None of a recording that is still being written.
    pub times: Option<RecordingAnalysis>,
    /// Whether sorting pays, in the words that end `inspector info`; nothing without times.
    pub verdict: Option<String>,
    /// What it is called.
    pub label: String,
    /// What its header says, with names that can be shown.
    pub shown: Header,
    queues: Vec<QueueRecord>,
    /// What each method that orders any rays gains over unsorted ones on the whole frame.
    over_unsorted: Vec<(String, Versus)>,
    /// A number of its own, another one each time that it is read again.
    pub opening: u64,
    /// The scene's hierarchy, read by the first that needs it.
    pub(super) hierarchy: Arc<OnceLock<Result<Hierarchy, String>>>,
}

impl Recording {
    /// Opens the recording in a folder.
    ///
    /// # Errors
    /// If there is none, or its manifest is damaged.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let dump = Dump::open_mapped(path)?;
        let options =
            analysis::AnalysisOptions { depth: Depth::Manifest, ..analysis::AnalysisOptions::default() };
        let analysis = analysis::analyse(std::slice::from_ref(&dump), &options).ok();
        let times = analysis.and_then(|analysis| analysis.recordings.into_iter().next());
        let verdict = times.as_ref().map(|_| Frame::of(dump.manifest()).meaning());
        let mut over_unsorted = times.as_ref().map_or_else(Vec::new, Versus::over_unsorted);
        over_unsorted.retain(|(method, _)| !leaves_all_alone(dump.manifest(), method));
        let name = dump.root().file_stem();
        let label = name.map_or_else(String::new, |name| shown::name(&name.to_string_lossy()));
        let shown = shown::header(&dump.manifest().header);
        let queues = queues(&dump);
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let opening = NEXT.fetch_add(1, Ordering::Relaxed);
        let (dump, hierarchy) = (Arc::new(dump), Arc::default());
        Ok(Self { dump, times, verdict, label, shown, queues, over_unsorted, opening, hierarchy })
    }

    /// Reads it again, by its final name if its recorder has ended since.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn again(&self) -> Result<Self, ReadError> {
        let root = self.dump.root();
        match dump_of_partial(root).filter(|_| !root.is_dir()) {
            Some(finished) => Self::open(&finished),
            None => Self::open(root),
        }
    }

    /// Its queues; those of its source if it is a replay without its own. Methods that cannot have an array
    /// by their name are left out.
    pub fn queues(&self) -> &[QueueRecord] {
        &self.queues
    }

    /// What is said of a queue; `None` if there is none.
    pub fn queue(&self, id: QueueId) -> Option<&QueueRecord> {
        self.queues.iter().find(|record| record.id == id)
    }

    /// The methods of a queue.
    pub fn methods(&self, queue: QueueId) -> &[String] {
        self.queue(queue).map_or(&[], |record| &record.methods)
    }

    /// The times of a queue; `None` if it has none.
    pub fn times_of(&self, queue: QueueId) -> Option<&QueueAnalysis> {
        self.times.as_ref()?.queues.iter().find(|found| found.id() == queue)
    }

    /// What a method gains over unsorted rays on the whole frame; `None` if it orders none of its rays.
    pub fn over_unsorted(&self, method: &str) -> Option<&Versus> {
        self.over_unsorted.iter().find(|(name, _)| name == method).map(|(_, versus)| versus)
    }

    /// Methods that were timed on other queues than this one, each with the kind of rays that it orders: that of this
    /// queue if it orders some of it.
    pub fn methods_elsewhere(&self, queue: QueueId) -> Vec<(String, Kind)> {
        let here = self.methods(queue);
        let timed =
            self.over_unsorted.iter().map(|(method, _)| method).filter(|method| !here.contains(method));
        let of = |method: &String| {
            let queues = self.queues.iter().filter(|record| record.methods.contains(method));
            let kind = queues.map(|record| record.id.kind).max_by_key(|kind| *kind == queue.kind);
            Some((method.clone(), kind?))
        };
        timed.filter_map(of).collect()
    }

    /// The method of a queue that gains most on the whole frame, see [`best`], and not `auto` where it left this queue
    /// alone; the first one if none was timed.
    pub fn best_method(&self, queue: QueueId) -> &str {
        let mut decisions = self.dump.manifest().decisions.iter();
        let is_left_alone = decisions.any(|one| one.queue == queue && one.choice.is_none());
        let methods = self.methods(queue).iter().filter(|method| !(is_left_alone && *method == AUTO));
        let methods: Vec<&String> = methods.collect();
        let first = || methods.iter().find(|method| **method != UNSORTED).map(|method| method.as_str());
        best(&self.over_unsorted, &methods).or_else(first).unwrap_or(UNSORTED)
    }

    /// What the manifest says of a method; `None` for `unsorted`.
    pub fn method(&self, name: &str) -> Option<&MethodRecord> {
        self.dump.manifest().methods.iter().find(|record| record.name == name)
    }

    /// Whether another tracer made its rays.
    pub fn is_imported(&self) -> bool {
        let mut dumps = [Some(&*self.dump), self.dump.source()].into_iter().flatten();
        dumps.any(|dump| matches!(dump.manifest().header.source, Source::Imported { .. }))
    }

    /// Where on a picture its paths start.
    pub fn image_plane(&self) -> ImagePlane {
        let options = &self.dump.manifest().header.options;
        ImagePlane::of(options.width, options.height)
    }

    /// The map from world space to unit space.
    pub fn unit(&self) -> UnitSpace {
        let scene = &self.dump.manifest().header.scene;
        UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max)
    }

    /// The queue that is selected first: secondary rays of the last pass, where orders differ most.
    pub fn first_queue(&self) -> Option<QueueId> {
        let queues = || self.queues().iter().map(|record| record.id);
        let pass = queues().map(|queue| queue.pass).max()?;
        let of_pass = || queues().filter(move |queue| queue.pass == pass);
        of_pass().find(|queue| queue.bounce == 1).or_else(|| of_pass().next())
    }
}

/// The queues of a recording: of a replay, which has none of its own, those of its source.
pub(crate) fn queue_records(dump: &Dump) -> &[QueueRecord] {
    let own = &dump.manifest().queues;
    match dump.source() {
        Some(source) if own.is_empty() => &source.manifest().queues,
        _ => own,
    }
}

fn queues(dump: &Dump) -> Vec<QueueRecord> {
    let mut queues = queue_records(dump).to_vec();
    queues.iter_mut().for_each(|queue| queue.methods.retain(|method| is_method_name(method)));
    queues
}
