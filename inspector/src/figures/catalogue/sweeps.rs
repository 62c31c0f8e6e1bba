//! Sweeps: methods that are variants of one base, by key bits and by the length that they assume.

use std::collections::BTreeMap;

use super::building::{figure, linear, marked, method_style, rays_title, settings};
use super::{Material, Skipped};
use crate::analysis::summary::{MeanSpeedup, Rays};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{Metric, OrderAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Reference, Series};

/// What is varied, as a number that can be put in order.
type Varied = fn(&OrderAnalysis) -> Option<f64>;

/// Speedups by bits of the key.
pub fn key_bits(material: &Material<'_>) -> Result<Figure, Skipped> {
    let sweep = Sweep {
        axis: "bits of the key",
        of: |order| order.key_bits.map(f64::from),
        other: |order| order.two_point_length.map(f64::from),
    };
    let caption = "Speedup of one method with keys of different length: the first bits of the same layout. Short keys sort in fewer passes.";
    sweep.figure(material, "key-bits", "Speedup by bits of the key", caption)
}

/// Speedups by the length that two-point assumes.
pub fn length(material: &Material<'_>) -> Result<Figure, Skipped> {
    let sweep = Sweep {
        axis: "assumed length (unit lengths)",
        of: |order| order.two_point_length.map(f64::from),
        other: |order| order.key_bits.map(f64::from),
    };
    let caption = "Speedup of one method that assumes different lengths for all rays, in units of the scene's largest extent.";
    sweep.figure(material, "two-point-length", "Speedup by assumed ray length", caption)
}

struct Sweep {
    axis: &'static str,
    of: Varied,
    /// What must be the same along a line.
    other: Varied,
}

/// Whose line a point is on: scene, its content's hash, machine, method, and what is not varied.
type Line<'a> = (&'a str, &'a str, &'a str, &'a str, Option<u64>);

impl Sweep {
    fn figure(
        &self,
        material: &Material<'_>,
        name: &str,
        title: &str,
        caption: &str,
    ) -> Result<Figure, Skipped> {
        let mut panels = Vec::new();
        for rays in Rays::ALL {
            panels.push(self.panel(material, rays, "trace speedup", |order| &order.trace_speedup));
            panels.push(self.panel(material, rays, "net speedup", |order| &order.net_speedup));
        }
        let parts = Figure {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: format!(
                "{caption} Geometric means over bounces; whiskers reach from the lowest to the highest bounce."
            ),
            settings: settings(material),
            panels,
        };
        let reason = format!(
            "no method was measured with two or more values of {}; `recorder replay` can do that",
            self.axis
        );
        figure(parts, reason)
    }

    fn panel(
        &self,
        material: &Material<'_>,
        rays: Rays,
        axis: &str,
        speedup: fn(&OrderAnalysis) -> &Metric<SpeedupLine>,
    ) -> Panel {
        let mut lines: BTreeMap<Line<'_>, BTreeMap<u64, Vec<&SpeedupLine>>> = BTreeMap::new();
        for recording in &material.analysis.recordings {
            for queue in super::building::queues(recording, rays) {
                for order in &queue.orders {
                    let (Some(varied), Some(found)) = ((self.of)(order), speedup(order).known()) else {
                        continue;
                    };
                    let other = (self.other)(order).map(f64::to_bits);
                    let (scene, hash) = (recording.scene.as_str(), recording.content_hash.as_str());
                    let line = (scene, hash, recording.configuration.as_str(), order.base.as_str(), other);
                    // Bits of numbers that are not negative are in their order.
                    lines.entry(line).or_default().entry(varied.to_bits()).or_default().push(found);
                }
            }
        }
        lines.retain(|_, points| points.len() > 1);
        let measured: Vec<f64> =
            lines.values().flat_map(BTreeMap::keys).map(|&varied| f64::from_bits(varied)).collect();
        let several_scenes =
            lines.keys().any(|line| Some(line.1) != lines.keys().next().map(|first| first.1));
        let several_machines =
            lines.keys().any(|line| Some(line.2) != lines.keys().next().map(|first| first.2));
        let series = lines.iter().map(|(line, points)| {
            let (scene, _, configuration, base, _) = *line;
            let mut label = base.to_owned();
            if several_scenes {
                label = format!("{label}, {scene}");
            }
            if several_machines {
                label = format!("{label}, {configuration}");
            }
            let points = points.iter().filter_map(|(&varied, lines)| {
                let mean = MeanSpeedup::of(lines.iter().copied())?;
                let x = f64::from_bits(varied);
                let spread = (mean.n > 1).then_some((mean.lowest, mean.highest));
                Some(Point {
                    x,
                    y: mean.mean,
                    spread,
                    n: mean.n,
                    name: format!("{scene}, {}, {base}", rays.name()),
                })
            });
            Series { style: method_style(material, base), points: points.collect(), label }
        });
        Panel {
            title: format!("{}: {axis}", rays_title(rays)),
            x: marked(self.axis, measured),
            y: linear(&format!("{axis} (×)"), false),
            content: Content::Lines(series.collect()),
            references: vec![Reference { label: "unsorted".to_owned(), y: 1.0, span: None }],
        }
    }
}
