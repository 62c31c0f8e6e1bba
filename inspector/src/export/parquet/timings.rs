//! Every sample of every time: a row each.

use std::collections::BTreeMap;
use std::sync::Arc;

use formats::manifest::{DisturbedRecord, Manifest, TimingRecord};
use formats::ray::Kind;

use super::Recorded;
use super::table::{Column, TableWriter};
use crate::shown;

type TimingColumn = Column<'static, TimingRow>;

/// One sample.
pub(super) struct TimingRow {
    of: Arc<Recorded>,
    pass: u32,
    bounce: u32,
    kind: Option<&'static str>,
    method: Arc<str>,
    stage: &'static str,
    round: u32,
    ns: u64,
    is_disturbed: bool,
}

/// Adds the samples of a recording to the table of all.
///
/// # Errors
/// If they cannot be written.
pub(super) fn add<'m>(
    table: &mut TableWriter<'static, TimingRow>,
    of_recording: &Arc<Recorded>,
    manifest: &'m Manifest,
) -> anyhow::Result<()> {
    let of = |record: &'m DisturbedRecord| {
        let DisturbedRecord { queue, method, stage, samples } = record;
        ((queue.pass, queue.bounce, Some(queue.kind), method.as_str(), *stage), samples.as_slice())
    };
    let disturbed: BTreeMap<_, &[u32]> = manifest.disturbed.iter().map(of).collect();
    for record in &manifest.timings {
        let TimingRecord { pass, bounce, kind, method, stage, samples_ns } = record;
        let shown: Arc<str> = shown::name(method).into();
        let rounds = disturbed.get(&(*pass, *bounce, *kind, method.as_str(), *stage));
        let row = |(round, &ns): (u32, &u64)| TimingRow {
            of: of_recording.clone(),
            pass: *pass,
            bounce: *bounce,
            kind: kind.map(Kind::name),
            method: shown.clone(),
            stage: stage.name(),
            round,
            ns,
            is_disturbed: rounds.is_some_and(|rounds| rounds.contains(&round)),
        };
        table.add(&(0..).zip(samples_ns).map(row).collect::<Vec<_>>())?;
    }
    Ok(())
}

pub(super) fn columns() -> Vec<TimingColumn> {
    vec![
        TimingColumn::text("scene", "Scene", |row| Some(&row.of.scene)),
        TimingColumn::text("machine", "Backend, adapter, kernel and threads", |row| Some(&row.of.machine)),
        TimingColumn::text("recording", "Recording, by its folder", |row| Some(&row.of.recording)),
        TimingColumn::optional("pass", "Pass, from 0", |row| Some(row.pass)),
        TimingColumn::optional("bounce", "Bounce; 0 is the camera rays", |row| Some(row.bounce)),
        TimingColumn::text("kind", "Kind of the rays; null for stages that serve both", |row| row.kind),
        TimingColumn::text("method", "Order of the rays", |row| Some(&row.method)),
        TimingColumn::text("stage", "What was timed", |row| Some(row.stage)),
        TimingColumn::optional("round", "Round of measuring, from 0: its samples belong together", |row| {
            Some(row.round)
        }),
        TimingColumn::optional("ns", "How long it took", |row| Some(row.ns)).unit("nanoseconds"),
        TimingColumn::optional(
            "disturbed",
            "Whether the machine is known to have done other work meanwhile",
            |row| Some(row.is_disturbed),
        ),
    ]
}
