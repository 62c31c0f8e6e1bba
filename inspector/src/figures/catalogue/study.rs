//! Means over a study: trace and net speedup by method, over scenes and their views.

use super::building::{figure, in_rows, of_method, rows_of};
use super::{Findings, Made};
use crate::analysis::study::{SceneMean, StudyGroup, StudyMean, StudyRow};
use crate::analysis::summary::{RayClass, distinct};
use crate::figures::model::{Axis, Of, Point, Series};
use crate::output::counted;

/// Groups that have panels: those of the most views.
const MOST_GROUPS: usize = 2;

/// Trace and net speedup of each method.
pub fn speedups(findings: &Findings<'_>) -> Made {
    let study = findings.analysis.study.as_ref().ok_or("no study was given")?;
    let is_shown = |row: &StudyRow| !row.is_variant && row.net.is_some();
    let mut groups: Vec<&StudyGroup> =
        study.groups.iter().filter(|group| group.rows.iter().any(is_shown)).collect();
    groups.sort_by_key(|group| std::cmp::Reverse(group.views));
    groups.truncate(MOST_GROUPS);
    // As much as tells them apart.
    let are_named = distinct(groups.iter().map(|group| &group.name)).len() == groups.len();
    let title = |group: &StudyGroup, words: String| match groups.len() {
        1 => words,
        _ if are_named => format!("{}: {words}", group.name),
        _ => format!("{}: {words}", label(group)),
    };
    let mut panels = Vec::new();
    for group in &groups {
        let parts: [(&str, Part); 2] = [("trace", |row| Some(&row.trace)), ("net", |row| row.net.as_ref())];
        let of = |rays| parts.map(|(name, part)| (rays, name, series(findings, group, rays, part)));
        let all = RayClass::ALL.map(of).concat();
        // Panels beside each other have the same rows.
        let rows = rows_of(findings, &all.iter().flat_map(|(.., series)| series.clone()).collect::<Vec<_>>());
        panels.extend(all.into_iter().map(|(rays, name, series)| {
            let title = title(group, format!("{} rays, {name}", rays.name()));
            in_rows(&rows, title, Axis::ratios("speedup"), series).with_reference("unsorted", 1.0)
        }));
    }
    let settings = groups.iter().map(|group| {
        let views = counted(group.views as u64, "view", "views");
        format!("{}: {views} of {}", label(group), group.scenes.join(", "))
    });
    figure(
        "Speedups over the scenes and views of a study",
        "Each marker is a geometric mean over scenes: of each recording the median over rounds of unsorted over sorted time, all bounces summed, of each scene the geometric mean over its views (cameras and seeds). The thick line is its 95 % interval, by bootstrap over views and rounds, the scenes as they are. Small dots are the scenes, of methods that were not measured on all views these alone. Net counts all that sorting takes.",
        settings.collect(),
        panels,
        "no method was measured in the study",
    )
}

/// The machine, and which recording of the jobs it is if it is a replay.
pub fn label(group: &StudyGroup) -> String {
    if group.name == "recording" {
        group.configuration.clone()
    } else {
        format!("{}, {}", group.name, group.configuration)
    }
}

/// A mean of a row.
type Part = fn(&StudyRow) -> Option<&StudyMean>;

/// Means and, behind them, those of each scene.
fn series(findings: &Findings<'_>, group: &StudyGroup, rays: RayClass, of: Part) -> Vec<Series> {
    let point = |row: &StudyRow, scene: &str, y, spread, n| {
        let of = Of {
            scene: scene.to_owned(),
            machine: group.configuration.clone(),
            kind: rays.name().to_owned(),
            method: row.method.clone(),
            ..Of::detail(group.name.clone())
        };
        Point { x: 0.0, y, spread, n, of }
    };
    let series =
        |row: &StudyRow, is_part, points| Series { is_part, ..of_method(findings, &row.method, points) };
    let all = group.views_of(rays);
    let rows = || group.methods(rays).filter_map(|row| Some((row, of(row)?)));
    let mean = |(row, mean): (&StudyRow, &StudyMean)| {
        series(row, false, vec![point(row, "all scenes", mean.mean.ratio, mean.mean.interval, mean.views)])
    };
    let scenes = |(row, mean): (&StudyRow, &StudyMean)| {
        let points = mean
            .scenes
            .iter()
            .map(|SceneMean { scene, ratio, views }| point(row, &group.scenes[*scene], *ratio, None, *views));
        series(row, true, points.collect())
    };
    // A mean over other views is not to be compared.
    rows().filter(|(_, mean)| mean.views == all).map(mean).chain(rows().map(scenes)).collect()
}
