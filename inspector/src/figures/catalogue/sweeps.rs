//! Sweeps: methods that are variants of one base, by key bits, by the origin's share of them and by the length that
//! they assume.

use std::collections::{BTreeMap, BTreeSet};

use super::building::{figure, mean_speedup, method_style, settings};
use super::{Findings, Made};
use crate::analysis::order::Varied;
use crate::analysis::summary::{RayClass, distinct};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{FrameAnalysis, Metric, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Of, Panel, Series};

/// Speedups by bits of the key.
pub fn key_bits(findings: &Findings<'_>) -> Made {
    let sweep = Sweep { axis: "bits of the key", varied: Varied::KEY_BITS };
    let caption = "Speedup of one method with keys of different length: the first bits of the same layout. Short keys sort in fewer passes.";
    sweep.figure(findings, "Speedup by bits of the key", caption)
}

/// Speedups by how many bits of the key are the origin's.
pub fn split(findings: &Findings<'_>) -> Made {
    let sweep = Sweep { axis: "bits of the origin", varied: Varied::ORIGIN_BITS };
    let caption = "Speedup of one method that gives the origin more or fewer bits of a key, and the rest to the direction or end point, bits of both in turn.";
    sweep.figure(findings, "Speedup by bits of the origin", caption)
}

/// Speedups by the length that two-point assumes.
pub fn length(findings: &Findings<'_>) -> Made {
    let sweep = Sweep { axis: "assumed length (unit lengths)", varied: Varied::LENGTH };
    let caption = "Speedup of one method that assumes different lengths for all rays, in units of the scene's largest extent.";
    sweep.figure(findings, "Speedup by assumed ray length", caption)
}

struct Sweep {
    axis: &'static str,
    varied: Varied,
}

/// Whose line a point is on: scene, its content's hash, machine, method, and what is not varied.
type Line<'a> = (&'a str, &'a str, &'a str, &'a str, Option<u64>);

/// A speedup: its line, the bits of the varied number, and what it is.
type Found<'a> = (Line<'a>, u64, &'a SpeedupLine);

/// The lines of which a recording has more than one value.
fn swept<'a>(found: &[Found<'a>]) -> BTreeSet<Line<'a>> {
    let mut values: BTreeMap<Line<'_>, BTreeSet<u64>> = BTreeMap::new();
    for (line, varied, _) in found {
        values.entry(*line).or_default().insert(*varied);
    }
    values.into_iter().filter(|(_, values)| values.len() > 1).map(|(line, _)| line).collect()
}

impl Sweep {
    fn figure(&self, findings: &Findings<'_>, title: &str, caption: &str) -> Made {
        let panels = RayClass::ALL.into_iter().flat_map(|rays| {
            [
                self.panel(findings, rays, "trace speedup", |frame| &frame.trace_speedup),
                self.panel(findings, rays, "net speedup", |frame| &frame.net_speedup),
            ]
        });
        let (panels, shown): (Vec<Panel>, Vec<Vec<&RecordingAnalysis>>) = panels.unzip();
        let all = findings.analysis.recordings.iter();
        let shown = all.filter(|one| shown.iter().flatten().any(|shown| std::ptr::eq(*shown, *one)));
        let caption = format!(
            "{caption} The whole frame, times of all bounces summed round by round; whiskers are 95 % intervals, from six rounds on, or of several recordings of a scene, whose geometric mean is shown, reach from the lowest to the highest."
        );
        let reason = format!(
            "no method was measured with two or more values of {}; `recorder replay` can do that",
            self.axis
        );
        figure(title, caption, settings(shown), panels, reason)
    }

    /// What a recording has. Bits of numbers that are not negative are in their order.
    fn found<'a>(
        &self,
        recording: &'a RecordingAnalysis,
        rays: RayClass,
        speedup: fn(&FrameAnalysis) -> &Metric<SpeedupLine>,
    ) -> Vec<Found<'a>> {
        let of = |frame: &'a FrameAnalysis| {
            let order = recording.measured_of(rays).find_map(|queue| queue.order(&frame.method))?;
            let (scene, hash) = (recording.scene.as_str(), recording.content_hash.as_str());
            let other = (self.varied.other)(order).map(f64::to_bits);
            let line = (scene, hash, recording.configuration.as_str(), order.base.as_str(), other);
            Some((line, (self.varied.of)(order)?.to_bits(), speedup(frame).known()?))
        };
        recording.frames.iter().filter(|frame| frame.rays == rays).filter_map(of).collect()
    }

    /// A panel, and the recordings whose numbers are in it.
    fn panel<'a>(
        &self,
        findings: &Findings<'a>,
        rays: RayClass,
        axis: &str,
        speedup: fn(&FrameAnalysis) -> &Metric<SpeedupLine>,
    ) -> (Panel, Vec<&'a RecordingAnalysis>) {
        let mut lines: BTreeMap<Line<'_>, BTreeMap<u64, Vec<&SpeedupLine>>> = BTreeMap::new();
        let mut recordings: Vec<(Line<'_>, &RecordingAnalysis)> = Vec::new();
        let found: Vec<_> =
            findings.analysis.recordings.iter().map(|one| (one, self.found(one, rays, speedup))).collect();
        let swept: Vec<BTreeSet<Line<'_>>> = found.iter().map(|(_, own)| swept(own)).collect();
        let all_swept: BTreeSet<&Line<'_>> = swept.iter().flatten().collect();
        for ((recording, own), swept) in found.iter().zip(&swept) {
            for (line, varied, speedup) in own {
                // One with a single value beside a sweep has rounds, and often rays, of its own.
                if swept.contains(line) || !all_swept.contains(line) {
                    recordings.push((*line, recording));
                    lines.entry(*line).or_default().entry(*varied).or_default().push(speedup);
                }
            }
        }
        lines.retain(|_, points| points.len() > 1);
        recordings.retain(|(line, _)| lines.contains_key(line));
        let measured = lines.values().flat_map(BTreeMap::keys).map(|&varied| f64::from_bits(varied));
        let several_scenes = distinct(lines.keys().map(|line| line.1)).len() > 1;
        let several_machines = distinct(lines.keys().map(|line| line.2)).len() > 1;
        let series = lines.iter().map(|(&(scene, _, configuration, base, _), points)| {
            let mut label = vec![base];
            label.extend(several_scenes.then_some(scene));
            label.extend(several_machines.then_some(configuration));
            let points = points.iter().filter_map(|(&varied, lines)| {
                let of = Of {
                    scene: scene.to_owned(),
                    machine: configuration.to_owned(),
                    kind: rays.name().to_owned(),
                    method: base.to_owned(),
                    ..Of::default()
                };
                mean_speedup(f64::from_bits(varied), lines.iter().copied(), of)
            });
            let points = points.collect();
            Series::new(label.join(", "), method_style(findings, base), points)
        });
        let panel = Panel::new(
            format!("{} rays: {axis}", rays.name()),
            Axis::marked(self.axis, measured),
            Axis::linear(&format!("{axis} (×)")),
            Content::Lines(series.collect()),
        )
        .with_reference("unsorted", 1.0);
        (panel, recordings.into_iter().map(|(_, recording)| recording).collect())
    }
}
