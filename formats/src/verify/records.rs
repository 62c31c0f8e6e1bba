//! Records of queues, timings and caches: of what was recorded, and with numbers that can be.

use std::collections::{BTreeMap, BTreeSet};

use super::{Check, Subject};
use crate::key::method::{UNSORTED, WITHOUT_KEY};
use crate::manifest::{
    CacheRecord, Manifest, NAME_CHARACTERS, Options, Place, QueueId, QueueRecord, Stage, TimingRecord,
};
use crate::reader::DumpState;
use crate::text::one_line;

/// Rays of a group whose caches are modelled.
const GROUP_RAYS: u64 = 64;

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let manifest = subject.dump.manifest();
    let known = Known::new(manifest, subject.dump.state());
    let mut check = Check::new("records");
    for &queue in subject.queues.keys() {
        let problem = known.outside(queue.pass, queue.bounce);
        check.require(problem.is_none(), || format!("{queue}: {}", problem.unwrap_or_default()));
    }
    for method in &manifest.header.options.methods {
        let problem = known.unknown_method(method).filter(|_| known.has_all_records);
        check.require(problem.is_none(), || format!("the header's methods: {}", problem.unwrap_or_default()));
    }
    for method in &manifest.methods {
        let is_named = known.options.methods.contains(&method.name);
        check.require(is_named, || {
            format!("method {} is not among the header's", one_line(&method.name, NAME_CHARACTERS))
        });
    }
    for queue in &manifest.queues {
        let problem = known.queue_problem(queue);
        check.require(problem.is_none(), || format!("queue {}: {}", queue.id, problem.unwrap_or_default()));
    }
    for array in &manifest.arrays {
        let Place::Method(queue, method, _) = &array.place else { continue };
        let problem = known.unmeasured(*queue, method);
        check.require(problem.is_none(), || format!("{}: {}", array.place, problem.unwrap_or_default()));
    }
    for timing in &manifest.timings {
        let problem = known.timing_problem(timing);
        check.require(problem.is_none(), || {
            let (TimingRecord { pass, bounce, .. }, stage) = (timing, timing.stage.name());
            let method = one_line(&timing.method, NAME_CHARACTERS);
            format!(
                "time of {stage} by {method} in pass {pass}, bounce {bounce}: {}",
                problem.unwrap_or_default()
            )
        });
    }
    for cache in &manifest.caches {
        let problem = known.cache_problem(cache);
        check.require(problem.is_none(), || {
            let queue = QueueId { pass: cache.pass, bounce: cache.bounce, kind: cache.kind };
            let method = one_line(&cache.method, NAME_CHARACTERS);
            format!("caches of {method} in {queue}: {}", problem.unwrap_or_default())
        });
    }
    check
}

/// What records can be about.
struct Known<'a> {
    options: &'a Options,
    queues: BTreeMap<QueueId, &'a QueueRecord>,
    methods: BTreeSet<&'a str>,
    /// Whether every method, and every queue that was measured, has its record.
    has_all_records: bool,
}

impl<'a> Known<'a> {
    fn new(manifest: &'a Manifest, state: DumpState) -> Self {
        let methods = manifest.methods.iter().map(|method| method.name.as_str());
        Self {
            options: &manifest.header.options,
            queues: manifest.queues.iter().map(|queue| (queue.id, queue)).collect(),
            methods: methods.chain(WITHOUT_KEY).collect(),
            has_all_records: state == DumpState::Complete,
        }
    }

    /// That there are no such passes or bounces, if so.
    fn outside(&self, pass: u32, bounce: u32) -> Option<String> {
        let Options { passes, bounces, .. } = *self.options;
        (pass >= passes || bounce >= bounces).then(|| {
            format!("pass {pass}, bounce {bounce} of a recording of {passes} passes and {bounces} bounces")
        })
    }

    fn unknown_method(&self, method: &str) -> Option<String> {
        let is_unknown = !self.methods.contains(method);
        is_unknown.then(|| format!("there is no record of method {}", one_line(method, NAME_CHARACTERS)))
    }

    fn unknown_queue(&self, queue: QueueId) -> Option<String> {
        let is_unknown = self.has_all_records && !self.queues.contains_key(&queue);
        is_unknown.then(|| format!("there is no record of queue {queue}"))
    }

    /// That a queue's record does not name the method, if so.
    fn unmeasured(&self, queue: QueueId, method: &str) -> Option<String> {
        let is_measured = |record: &&QueueRecord| record.methods.iter().any(|name| name == method);
        let record = self.queues.get(&queue).filter(|record| !is_measured(record));
        record.map(|_| format!("the record of {queue} does not name {}", one_line(method, NAME_CHARACTERS)))
    }

    fn queue_problem(&self, queue: &QueueRecord) -> Option<String> {
        let Options { width, height, .. } = *self.options;
        let pixels = u64::from(width) * u64::from(height);
        if queue.rays > pixels {
            return Some(format!("{} rays, expected at most {width} × {height}", queue.rays));
        }
        let unknown = queue.methods.iter().find_map(|method| self.unknown_method(method));
        let wrong = queue.mismatches.iter().find_map(|mismatches| {
            let method = one_line(&mismatches.method, NAME_CHARACTERS);
            if !queue.methods.contains(&mismatches.method) {
                return Some(format!("results of {method} are said to differ, but it was not measured"));
            }
            if mismatches.rays > queue.rays {
                return Some(format!(
                    "{} results of {method} differ, of {} rays",
                    mismatches.rays, queue.rays
                ));
            }
            (mismatches.method == UNSORTED && mismatches.rays > 0)
                .then(|| format!("{} results of {UNSORTED} differ from themselves", mismatches.rays))
        });
        let unmeasured = !queue.methods.is_empty() && !queue.methods.iter().any(|method| method == UNSORTED);
        let no_baseline =
            unmeasured.then(|| format!("its methods lack {UNSORTED}, which is always measured"));
        unknown.or(no_baseline).or(wrong)
    }

    fn timing_problem(&self, timing: &TimingRecord) -> Option<String> {
        let &TimingRecord { pass, bounce, kind, stage, ref method, ref samples_ns } = timing;
        let is_of_a_queue = !matches!(stage, Stage::Generate | Stage::Shade);
        let expected = if is_of_a_queue { self.options.repeats } else { 1 };
        let wrong = if is_of_a_queue != kind.is_some() {
            let (found, expected) = if is_of_a_queue { ("no", "one") } else { ("a", "none") };
            Some(format!("it has {found} kind of queue, expected {expected}"))
        } else if WITHOUT_KEY.contains(&method.as_str()) && matches!(stage, Stage::Key | Stage::Sort) {
            Some("it has no key".to_owned())
        } else if method == UNSORTED && is_of_a_queue && stage != Stage::Trace {
            Some("unsorted rays are traced, and nothing else".to_owned())
        } else if samples_ns.len() != expected as usize {
            Some(format!("it has {} samples, expected {expected}", samples_ns.len()))
        } else {
            None
        };
        self.outside(pass, bounce)
            .or_else(|| self.unknown_method(method))
            .or_else(|| self.unknown_queue(QueueId { pass, bounce, kind: kind? }))
            .or_else(|| self.unmeasured(QueueId { pass, bounce, kind: kind? }, method))
            .or(wrong)
    }

    fn cache_problem(&self, cache: &CacheRecord) -> Option<String> {
        let &CacheRecord { pass, bounce, kind, rays, accesses, l1_hits, l2_hits, ref method, .. } = cache;
        let queue = QueueId { pass, bounce, kind };
        let hits = l1_hits.checked_add(l2_hits);
        let wrong = if [u64::from(cache.line_bytes), cache.l1_bytes, cache.l2_bytes].contains(&0) {
            Some("a cache or its lines have no bytes".to_owned())
        } else if cache.groups != rays.div_ceil(GROUP_RAYS) {
            Some(format!("{} groups of {rays} rays, {GROUP_RAYS} each", cache.groups))
        } else if hits.is_none_or(|hits| hits > accesses) {
            Some(format!("{l1_hits} and {l2_hits} hits of {accesses} accesses"))
        } else {
            let most = self.queues.get(&queue).map_or(u64::MAX, |queue| queue.rays);
            (rays > most).then(|| format!("{rays} rays were sampled, of {most}"))
        };
        self.outside(pass, bounce)
            .or_else(|| self.unknown_method(method))
            .or_else(|| self.unknown_queue(queue))
            .or_else(|| self.unmeasured(queue, method))
            .or(wrong)
    }
}
