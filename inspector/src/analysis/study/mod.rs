//! Means over studies: medians within a recording, means over a scene's views, over scenes; machines side by side.
//!
//! Recordings are looked at one after the other, and what is kept of each is its [`summary`]: memory does not grow
//! with their rays.

mod kept;
pub mod summary;

use std::convert::Infallible;

use formats::key::method::CONTROL;
use formats::metrics::frame::FrameTimes;
use formats::metrics::speedup::{Speedup, Verdict, geometric_mean};
use formats::metrics::views::{self, mean_of_scene, mean_over_views};
use formats::ray::Kind;
use formats::reader::Dump;
use formats::study::Study;
use rayon::prelude::*;
use serde::Serialize;

use super::labels::{Scene, scene_label, scene_name};
use super::summary::{RayClass, distinct};
use super::{AnalysisOptions, KnownQueues, QueueAnalysis};
use kept::{kept, place};
use summary::{RecordingSummary, summary};

/// Means over the recordings of studies.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StudyAnalysis {
    /// Recordings whose times have a common mean.
    pub groups: Vec<StudyGroup>,
    /// What could not be read or kept, a sentence each.
    pub notices: Vec<String>,
}

/// Recordings of one name on one machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyGroup {
    /// Which of a job's recordings: `recording`, or the name of a replay.
    pub name: String,
    /// Backend, adapter, kernel and threads.
    pub configuration: String,
    /// The scenes by name, and where two share one by the hash of what is in them, too.
    pub scenes: Vec<String>,
    /// Recordings: views of these scenes, by camera and seed.
    pub views: usize,
    /// Its methods, by kind of rays, the best net mean first.
    pub rows: Vec<StudyRow>,
}

/// One method on one kind of rays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyRow {
    /// The rays.
    pub rays: RayClass,
    /// The method.
    pub method: String,
    /// Whether it is a variant of another, as in a sweep.
    pub is_variant: bool,
    /// Unsorted trace over trace in its order.
    pub trace: StudyMean,
    /// Unsorted trace over all stages; `null` where those are not all known.
    pub net: Option<StudyMean>,
    /// Geometric mean of capsule areas over those of unsorted rays, where known.
    pub capsule_area_ratio: Option<f64>,
}

/// A mean over scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyMean {
    /// The mean, and where it lies with 95 % confidence.
    #[serde(flatten)]
    pub mean: Speedup,
    /// Those of the scenes that have any.
    pub scenes: Vec<SceneMean>,
    /// Views.
    pub views: usize,
}

/// The mean over views of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SceneMean {
    /// Place of the scene among the group's.
    pub scene: usize,
    /// The mean.
    pub ratio: f64,
    /// Views.
    pub views: usize,
}

/// The numbers of a recording's queues, kept in the study that it is of. Second, why they could not be kept.
pub(super) fn queues(
    study: &Study,
    dump: &Dump,
    options: &AnalysisOptions,
) -> (Vec<QueueAnalysis>, Option<String>) {
    let make = || QueueAnalysis::all(dump, options, &KnownQueues::new());
    match place(study, dump.root(), "-queues") {
        Ok(path) => kept(&path, || Ok::<_, Infallible>(make())).unwrap_or_else(|never| match never {}),
        Err(error) => (make(), Some(error.to_string())),
    }
}

/// A summary and the name of its recording within its job.
type Named = (String, RecordingSummary);

impl StudyAnalysis {
    /// Of some studies together. Recordings that cannot be read are left out with a notice.
    pub fn of(studies: &[Study]) -> Self {
        let recordings = studies.iter().flat_map(|study| study.recordings().map(move |path| (study, path)));
        let found: Vec<(Option<Named>, Option<String>)> = recordings
            .collect::<Vec<_>>()
            .par_iter()
            .map(|(study, path)| {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                match summary(study, path) {
                    Ok((summary, notice)) => (Some((name, summary)), notice),
                    Err(error) => (None, Some(format!("left out: {error}"))),
                }
            })
            .collect();
        let (summaries, notices): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        let summaries: Vec<Named> = summaries.into_iter().flatten().collect();
        Self::of_summaries(&summaries, distinct(notices.into_iter().flatten()))
    }

    fn of_summaries(summaries: &[Named], notices: Vec<String>) -> Self {
        let mut groups: Vec<(&str, &str)> =
            distinct(summaries.iter().map(|(name, summary)| (summary.configuration.as_str(), name.as_str())));
        // Recordings come before their replays.
        groups.sort_by_key(|(configuration, name)| (*name != "recording", *name, *configuration));
        let group = |(configuration, name): &(&str, &str)| {
            let own = summaries
                .iter()
                .filter(|(of, summary)| of == name && summary.configuration == *configuration);
            StudyGroup::of(name, configuration, &own.map(|(_, summary)| summary).collect::<Vec<_>>())
        };
        Self { groups: groups.par_iter().map(group).collect(), notices }
    }
}

impl StudyGroup {
    fn of(name: &str, configuration: &str, summaries: &[&RecordingSummary]) -> Self {
        let mut scenes = distinct(summaries.iter().map(|summary| summary.scene()));
        scenes.sort_unstable();
        let mut rows = Vec::new();
        for rays in RayClass::ALL {
            let methods = distinct(
                summaries.iter().flat_map(|summary| kinds(rays, summary)).map(|times| times.method.as_str()),
            );
            let mut own: Vec<StudyRow> =
                methods.par_iter().filter_map(|method| row(rays, method, &scenes, summaries)).collect();
            let net = |row: &StudyRow| row.net.as_ref().map_or(f64::NEG_INFINITY, |net| net.mean.ratio);
            own.sort_by(|a, b| net(b).total_cmp(&net(a)));
            rows.extend(own);
        }
        Self {
            name: name.to_owned(),
            configuration: configuration.to_owned(),
            scenes: scenes.iter().map(|scene| scene_label(*scene, &scenes)).collect(),
            views: summaries.len(),
            rows,
        }
    }

    /// Whether there is nothing but variants of methods, as in a replay with a sweep.
    pub fn is_sweep(&self) -> bool {
        self.rows.iter().all(|row| row.is_variant || row.method == CONTROL)
    }

    /// Views that have some of these rays.
    pub fn views_of(&self, rays: RayClass) -> usize {
        self.methods(rays).map(|row| row.trace.views).max().unwrap_or(0)
    }

    /// Whether a method's net speedup lies beyond 1 and what the control of these rays misses it by, on all views that
    /// have such rays: a mean over others is not to be compared.
    pub fn is_shown_to_pay(&self, row: &StudyRow) -> bool {
        let Some(net) = row.net.as_ref().filter(|net| net.views >= self.views_of(row.rays)) else {
            return false;
        };
        let control = self.rows.iter().find(|other| other.rays == row.rays && other.method == CONTROL);
        let error = control.map_or(0.0, |control| (control.trace.mean.ratio - 1.0).abs());
        net.mean.verdict(error) == Verdict::Faster
    }

    /// The rows of a kind of rays: methods, or in a sweep their variants.
    pub fn methods(&self, rays: RayClass) -> impl Iterator<Item = &StudyRow> {
        let is_sweep = self.is_sweep();
        self.rows.iter().filter(move |row| row.rays == rays && (is_sweep || !row.is_variant))
    }
}

impl RecordingSummary {
    fn scene(&self) -> Scene<'_> {
        Scene { name: scene_name(&self.scene), content_hash: &self.content_hash }
    }
}

/// The times of a recording on rays of a kind.
fn kinds(rays: RayClass, summary: &RecordingSummary) -> impl Iterator<Item = &FrameTimes> {
    summary.times.iter().filter(move |times| times.kind == rays.kind())
}

fn row(
    rays: RayClass,
    method: &str,
    scenes: &[Scene<'_>],
    summaries: &[&RecordingSummary],
) -> Option<StudyRow> {
    let own: Vec<(&RecordingSummary, &FrameTimes)> = summaries
        .iter()
        .filter_map(|summary| Some((*summary, kinds(rays, summary).find(|times| times.method == method)?)))
        .collect();
    let of_kind = |summary: &RecordingSummary, kind: Kind| {
        summary.areas.iter().find(|(of, name, _)| *of == kind && name == method).map(|(.., ratio)| *ratio)
    };
    let areas = own.iter().filter_map(|(summary, times)| of_kind(summary, times.kind));
    Some(StudyRow {
        rays,
        method: method.to_owned(),
        is_variant: own.iter().all(|(summary, _)| summary.variants.iter().any(|variant| variant == method)),
        trace: mean(&own, scenes, |times| &times.traced_ns)?,
        net: mean(&own, scenes, |times| &times.total_ns),
        capsule_area_ratio: geometric_mean(areas),
    })
}

fn mean(
    own: &[(&RecordingSummary, &FrameTimes)],
    scenes: &[Scene<'_>],
    time: impl Fn(&FrameTimes) -> &[u64],
) -> Option<StudyMean> {
    let ratios = |times: &FrameTimes| -> Vec<f64> {
        let rounds = times.unsorted_ns.iter().zip(time(times));
        rounds.map(|(&unsorted, &own)| unsorted as f64 / own.max(1) as f64).collect()
    };
    let views = |scene: &Scene<'_>| -> views::Scene {
        let of_scene = own.iter().filter(|(summary, _)| summary.scene() == *scene);
        of_scene.map(|(_, times)| ratios(times)).filter(|rounds| !rounds.is_empty()).collect()
    };
    let all: Vec<(usize, views::Scene)> =
        scenes.iter().map(views).enumerate().filter(|(_, views)| !views.is_empty()).collect();
    let by_scene = |(scene, views): &(usize, views::Scene)| {
        Some(SceneMean { scene: *scene, ratio: mean_of_scene(views)?, views: views.len() })
    };
    Some(StudyMean {
        scenes: all.iter().filter_map(by_scene).collect(),
        views: all.iter().map(|(_, views)| views.len()).sum(),
        mean: mean_over_views(&all.into_iter().map(|(_, views)| views).collect::<Vec<_>>())?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(scene: &str, camera: &str, configuration: &str, traced_ns: [u64; 3]) -> RecordingSummary {
        let times = FrameTimes {
            kind: Kind::Shadow,
            method: "aila".into(),
            unsorted_ns: vec![1200, 1200, 1200],
            traced_ns: traced_ns.into(),
            total_ns: traced_ns.iter().map(|ns| 2 * ns).collect(),
        };
        let control = FrameTimes { method: "control".into(), total_ns: vec![], ..times.clone() };
        RecordingSummary {
            scene: scene.into(),
            content_hash: "0123456789".into(),
            camera: camera.into(),
            seed: 0,
            configuration: configuration.into(),
            times: vec![times, control],
            variants: vec![],
            areas: vec![(Kind::Shadow, "aila".into(), 0.5)],
        }
    }

    /// Two scenes, two cameras, three rounds, by hand; another machine has means of its own.
    #[test]
    fn views_are_averaged_within_their_scene_and_machines_are_not_mixed() {
        let named = |summary| ("recording".to_owned(), summary);
        let summaries = [
            named(recording("a.glb", "one", "m", [600, 300, 600])),
            named(recording("a.glb", "two", "m", [150, 150, 1200])),
            named(recording("b.glb", "one", "m", [1200, 1200, 1200])),
            named(recording("b.glb", "two", "m", [1200, 1200, 600])),
            named(recording("b.glb", "two", "n", [300, 300, 300])),
        ];
        let study = StudyAnalysis::of_summaries(&summaries, vec![]);
        let [first, second] = &study.groups[..] else { panic!("two machines: {study:?}") };
        assert_eq!((first.views, second.views), (4, 1));
        assert_eq!(first.scenes, ["a", "b"]);
        let [aila, control] = &first.rows[..] else { panic!("two methods: {first:?}") };
        // Scene a: medians 2 and 8, mean 4; scene b: 1 and 1; of both 2. All stages take twice as long.
        assert!((aila.trace.mean.ratio - 2.0).abs() < 1e-12, "{aila:?}");
        assert!((aila.net.as_ref().unwrap().mean.ratio - 1.0).abs() < 1e-12, "{aila:?}");
        assert!(aila.trace.scenes.iter().all(|scene| scene.views == 2), "{aila:?}");
        let scenes: Vec<f64> = aila.trace.scenes.iter().map(|scene| scene.ratio).collect();
        assert!((scenes[0] - 4.0).abs() < 1e-12 && (scenes[1] - 1.0).abs() < 1e-12, "{scenes:?}");
        assert_eq!((aila.trace.views, aila.capsule_area_ratio), (4, Some(0.5)));
        assert_eq!((control.method.as_str(), &control.net), ("control", &None));
        assert_eq!(second.rows[0].trace.mean.ratio, 4.0);
        // The control has twice the speed, too: a gain is beyond that.
        let pays = |low| {
            let mut row = aila.clone();
            row.net.as_mut().unwrap().mean.interval = Some((low, 3.0));
            first.is_shown_to_pay(&row)
        };
        assert!(pays(2.1) && !pays(1.9) && !first.is_shown_to_pay(aila));
    }

    /// Scenes are told apart by what is in them, whatever they are called.
    #[test]
    fn scenes_of_one_name_are_two() {
        let named = |summary| ("recording".to_owned(), summary);
        let mut summaries = [
            named(recording("one/room.glb", "front", "m", [300, 300, 300])),
            named(recording("other/room.glb", "front", "m", [1200, 1200, 1200])),
            named(recording("other/room.glb", "back", "m", [1200, 1200, 1200])),
        ];
        let ratio = |summaries: &[Named]| {
            let study = StudyAnalysis::of_summaries(summaries, vec![]);
            let [group] = &study.groups[..] else { panic!("one group: {study:?}") };
            (group.scenes.clone(), group.rows[0].trace.mean.ratio)
        };
        let (scenes, mean) = ratio(&summaries);
        assert!(scenes == ["room"] && (mean - 4f64.cbrt()).abs() < 1e-12, "{scenes:?} {mean}");
        summaries[0].1.content_hash = "9876543210".into();
        let (scenes, mean) = ratio(&summaries);
        assert!(scenes == ["room (01234567)", "room (98765432)"], "{scenes:?}");
        assert!((mean - 2.0).abs() < 1e-12, "the mean of 4 and 1 is {mean}");
    }
}
