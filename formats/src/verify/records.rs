//! Records of queues, timings and caches: of what was recorded, and with numbers that can be.

use std::collections::{BTreeMap, BTreeSet};

use super::{Check, Subject};
use crate::key::method::{AUTO, CONTROL, SHUFFLED, UNSORTED, WITHOUT_LAYOUT};
use crate::manifest::{
    CacheRecord, DisturbedRecord, Options, Place, QueueId, QueueRecord, Stage, TimingRecord,
};
use crate::ray::Kind;
use crate::reader::DumpState;
use crate::text::{counted, shown};

/// Rays of a group whose caches are modelled.
const GROUP_RAYS: u64 = 64;

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let manifest = subject.dump.manifest();
    let options = &manifest.header.options;
    let mut check = Check::new("records");
    for queue in subject.queues.keys() {
        check.find(subject.outside(queue.pass, queue.bounce), || queue.to_string());
    }
    for method in &options.methods {
        let problem = subject.unknown_method(method).filter(|_| subject.has_all_records());
        check.find(problem, || "the header's methods".to_owned());
    }
    let named: BTreeSet<&str> = options.methods.iter().map(String::as_str).collect();
    for method in &manifest.methods {
        check.require(named.contains(method.name.as_str()), || {
            format!("method {} is not among the header's", shown(&method.name))
        });
    }
    for queue in &manifest.queues {
        check.find(subject.queue_problem(queue), || format!("queue {}", queue.id));
    }
    for array in &manifest.arrays {
        let Place::Method(queue, method, _) = &array.place else { continue };
        check.find(subject.unmeasured(*queue, method), || array.place.to_string());
    }
    for timing in &manifest.timings {
        let TimingRecord { pass, bounce, stage, method, .. } = timing;
        check.find(subject.timing_problem(timing), || {
            format!("time of {} by {} in pass {pass}, bounce {bounce}", stage.name(), shown(method))
        });
    }
    let timed: BTreeMap<_, _> =
        manifest.timings.iter().map(|timing| (about(timing), timing.samples_ns.len())).collect();
    for disturbed in &manifest.disturbed {
        let &DisturbedRecord { queue, stage, ref method, ref samples } = disturbed;
        let QueueId { pass, bounce, kind } = queue;
        let count = timed.get(&(pass, bounce, Some(kind), stage, method.as_str()));
        let last = samples.last().map_or(0, |&last| last as usize);
        check.require(count.is_some_and(|&count| last < count), || {
            let found = count.map_or("no such time".to_owned(), |count| format!("a time of {count} samples"));
            format!("disturbed samples of {} by {} in {queue}: there is {found}", stage.name(), shown(method))
        });
    }
    for way in &manifest.ways {
        check.find(subject.unknown_method(&way.method), || "the ways of methods".to_owned());
    }
    for cache in &manifest.caches {
        check.find(subject.cache_problem(cache), || {
            format!("caches of {} in {}", shown(&cache.method), cache.queue)
        });
    }
    check
}

/// What a timing is about.
fn about(timing: &TimingRecord) -> (u32, u32, Option<Kind>, Stage, &str) {
    (timing.pass, timing.bounce, timing.kind, timing.stage, &timing.method)
}

impl Subject<'_> {
    fn options(&self) -> &Options {
        &self.dump.manifest().header.options
    }

    /// Whether every method, and every queue that was measured, has its record.
    fn has_all_records(&self) -> bool {
        self.dump.state() == DumpState::Complete
    }

    /// That there are no such passes or bounces, if so.
    fn outside(&self, pass: u32, bounce: u32) -> Option<String> {
        let &Options { passes, bounces, .. } = self.options();
        (pass >= passes || bounce >= bounces).then(|| {
            let passes = counted(passes.into(), "pass", "passes");
            let bounces = counted(bounces.into(), "bounce", "bounces");
            format!("pass {pass}, bounce {bounce} of a recording of {passes} and {bounces}")
        })
    }

    fn unknown_method(&self, method: &str) -> Option<String> {
        let is_unknown = !WITHOUT_LAYOUT.contains(&method) && !self.methods.contains_key(method);
        is_unknown.then(|| format!("there is no record of method {}", shown(method)))
    }

    pub(super) fn record_of(&self, queue: QueueId) -> Option<&QueueRecord> {
        self.queues.get(&queue)?.record
    }

    pub(super) fn unknown_queue(&self, queue: QueueId) -> Option<String> {
        let is_unknown = self.has_all_records() && self.record_of(queue).is_none();
        is_unknown.then(|| format!("there is no record of queue {queue}"))
    }

    /// That a queue's record does not name the method, if so.
    fn unmeasured(&self, queue: QueueId, method: &str) -> Option<String> {
        let found = self.queues.get(&queue).filter(|found| found.record.is_some());
        // The control is measured wherever a method is, and leaves nothing but times.
        let name = if method == CONTROL { UNSORTED } else { method };
        let is_missing = found.is_some_and(|found| !found.measured.contains(name));
        is_missing.then(|| format!("the record of {queue} does not name {}", shown(method)))
    }

    fn queue_problem(&self, queue: &QueueRecord) -> Option<String> {
        let &Options { width, height, .. } = self.options();
        let measured = &self.queues[&queue.id].measured;
        let pixels = u64::from(width) * u64::from(height);
        if queue.rays > pixels {
            return Some(format!("{} rays, expected at most {width} × {height}", queue.rays));
        }
        let unknown = queue.methods.iter().find_map(|method| self.unknown_method(method));
        let wrong = queue.mismatches.iter().find_map(|mismatches| {
            let method = shown(&mismatches.method);
            if !measured.contains(mismatches.method.as_str()) {
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
        let unmeasured = !measured.is_empty() && !measured.contains(UNSORTED);
        let no_baseline =
            unmeasured.then(|| format!("its methods lack {UNSORTED}, which is always measured"));
        unknown.or(no_baseline).or(wrong)
    }

    fn timing_problem(&self, timing: &TimingRecord) -> Option<String> {
        let &TimingRecord { pass, bounce, kind, stage, ref method, ref samples_ns } = timing;
        let is_of_a_queue = !matches!(stage, Stage::Generate | Stage::Shade);
        let expected = if is_of_a_queue { self.options().repeats } else { 1 };
        let wrong = if is_of_a_queue != kind.is_some() {
            let (found, expected) = if is_of_a_queue { ("no", "one") } else { ("a", "none") };
            Some(format!("it has {found} kind of queue, expected {expected}"))
        } else if method == UNSORTED && is_of_a_queue && stage != Stage::Trace {
            Some("unsorted rays are traced, and nothing else".to_owned())
        } else if method == CONTROL && !matches!(stage, Stage::Gather | Stage::Trace | Stage::Scatter) {
            Some("the control is gathered, traced and scattered, and nothing else".to_owned())
        } else if method == SHUFFLED && matches!(stage, Stage::Key | Stage::Sort | Stage::Accumulate) {
            Some("a random order has no key, and nothing to sort".to_owned())
        } else if (stage == Stage::Decide) && method != AUTO {
            Some("only auto decides anything".to_owned())
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
        let &CacheRecord { queue, rays, accesses, l1_hits, l2_hits, ref method, .. } = cache;
        let hits = l1_hits.checked_add(l2_hits);
        let wrong = if [u64::from(cache.line_bytes), cache.l1_bytes, cache.l2_bytes].contains(&0) {
            Some("a cache or its lines have no bytes".to_owned())
        } else if cache.groups != rays.div_ceil(GROUP_RAYS) {
            Some(format!("{} groups of {rays} rays, {GROUP_RAYS} each", cache.groups))
        } else if hits.is_none_or(|hits| hits > accesses) {
            Some(format!("{l1_hits} and {l2_hits} hits of {accesses} accesses"))
        } else {
            let most = self.record_of(queue).map_or(u64::MAX, |queue| queue.rays);
            (rays > most).then(|| format!("{rays} rays were sampled, of {most}"))
        };
        self.outside(queue.pass, queue.bounce)
            .or_else(|| self.unknown_method(method))
            .or_else(|| self.unknown_queue(queue))
            .or_else(|| self.unmeasured(queue, method))
            .or(wrong)
    }
}
