//! What `inspector info --metrics` says of each order: a row each, and one for it over all bounces.

use std::sync::Arc;

use formats::key::method::UNSORTED;
use formats::manifest::{Stage, Way};

use super::Recorded;
use super::table::{Column, TableWriter};
use crate::analysis::summary::RayClass;
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{FrameAnalysis, OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::output::sum;

type SummaryColumn = Column<'static, SummaryRow>;

/// One order of a queue, or over all bounces.
#[derive(Default)]
pub(super) struct SummaryRow {
    of: Arc<Recorded>,
    camera: Arc<str>,
    seed: u64,
    kind: &'static str,
    pass: Option<u32>,
    bounce: Option<u32>,
    method: String,
    base: String,
    key_bits: Option<u32>,
    rays: u64,
    way: Option<&'static str>,
    trace_ns: Option<f64>,
    total_ns: Option<f64>,
    trace_speedup: Option<SpeedupLine>,
    net_speedup: Option<SpeedupLine>,
    capsule_area: Option<f64>,
    capsule_area_ratio: Option<f64>,
    direction_spread: Option<f64>,
    lane_utilisation: Option<f64>,
    table_fill: Option<f64>,
    table_error: Option<f64>,
    constant_error: Option<f64>,
}

/// Adds the orders of a recording to the table of all.
///
/// # Errors
/// If they cannot be written.
pub(super) fn add(
    table: &mut TableWriter<'static, SummaryRow>,
    of: &Arc<Recorded>,
    analysis: &RecordingAnalysis,
) -> anyhow::Result<()> {
    let camera: Arc<str> = analysis.options.camera.as_str().into();
    let row = |row: SummaryRow| SummaryRow {
        of: of.clone(),
        camera: camera.clone(),
        seed: analysis.options.seed,
        ..row
    };
    let orders =
        analysis.queues.iter().flat_map(|queue| queue.orders.iter().map(move |order| (queue, order)));
    let orders = orders.map(|(queue, order)| of_queue(queue, order));
    let frames = analysis.frames.iter().map(|frame| of_frame(frame, &analysis.queues));
    table.add(&orders.chain(frames).map(row).collect::<Vec<_>>())
}

fn of_queue(queue: &QueueAnalysis, order: &OrderAnalysis) -> SummaryRow {
    let coherence = order.coherence.known();
    let area = coherence.map(|coherence| coherence.mean_capsule_area);
    let unsorted = queue.order(UNSORTED).and_then(|unsorted| unsorted.coherence.known());
    let ratio = area.zip(unsorted).map(|(area, unsorted)| area / unsorted.mean_capsule_area);
    let errors = queue.estimators.known();
    SummaryRow {
        kind: queue.kind.name(),
        pass: Some(queue.pass),
        bounce: Some(queue.bounce),
        method: order.method.clone(),
        base: order.base.clone(),
        key_bits: order.key_bits,
        rays: queue.rays,
        way: Some(match order.way {
            Way::Gathered => "gathered",
            Way::Indices => "indices",
        }),
        trace_ns: order.stage(Stage::Trace).map(|trace| trace.time.median_ns),
        total_ns: order.total.as_ref().map(|total| total.median_ns),
        trace_speedup: order.trace_speedup.known().copied(),
        net_speedup: order.net_speedup.known().copied(),
        capsule_area: area,
        capsule_area_ratio: ratio.filter(|ratio| ratio.is_finite()),
        direction_spread: coherence.map(|coherence| coherence.mean_direction_spread),
        lane_utilisation: order.warp_utilisation(),
        table_fill: queue.table.known().map(|table| table.fill),
        table_error: errors.map(|errors| errors.table.mean_absolute),
        constant_error: errors.map(|errors| errors.constant.mean_absolute),
        ..SummaryRow::default()
    }
}

fn of_frame(frame: &FrameAnalysis, queues: &[QueueAnalysis]) -> SummaryRow {
    let own = queues.iter().filter(|queue| RayClass::of(queue) == Some(frame.rays));
    let measured = own.filter(|queue| queue.order(&frame.method).is_some());
    let stage = |stage| frame.stages.iter().find(|found| found.stage == stage);
    SummaryRow {
        kind: frame.rays.kind().name(),
        method: frame.method.clone(),
        base: frame.base.clone(),
        rays: sum(measured.map(|queue| queue.rays)),
        trace_ns: stage(Stage::Trace).map(|trace| trace.median_ns),
        trace_speedup: frame.trace_speedup.known().copied(),
        net_speedup: frame.net_speedup.known().copied(),
        capsule_area_ratio: frame.capsule_area_ratio.known().copied(),
        ..SummaryRow::default()
    }
}

pub(super) fn columns() -> Vec<SummaryColumn> {
    [what(), times(), coherence()].into_iter().flatten().collect()
}

/// What a row is of.
fn what() -> Vec<SummaryColumn> {
    vec![
        SummaryColumn::text("scene", "Scene", |row| Some(&row.of.scene)),
        SummaryColumn::text("machine", "Backend, adapter, kernel and threads", |row| Some(&row.of.machine)),
        SummaryColumn::text("recording", "Recording, by its folder", |row| Some(&row.of.recording)),
        SummaryColumn::text("camera", "Camera", |row| Some(&row.camera)),
        SummaryColumn::optional("seed", "Seed of all random numbers", |row| Some(row.seed)),
        SummaryColumn::text("kind", "Kind of the rays", |row| Some(row.kind)),
        SummaryColumn::optional("pass", "Pass, from 0; null for all bounces together", |row| row.pass),
        SummaryColumn::optional(
            "bounce",
            "Bounce; null for all together, of closest rays without bounce 0, the camera rays",
            |row| row.bounce,
        ),
        SummaryColumn::text("method", "Order of the rays", |row| Some(&row.method)),
        SummaryColumn::text("base", "Method that it is a variant of; its own name if it is none", |row| {
            Some(&row.base)
        }),
        SummaryColumn::optional(
            "key_bits",
            "Bits of its keys; null for unsorted and for all bounces",
            |row| row.key_bits,
        ),
        SummaryColumn::optional("rays", "Rays", |row| Some(row.rays)),
    ]
}

fn real(name: &'static str, about: &'static str, of: fn(&SummaryRow) -> Option<f64>) -> SummaryColumn {
    SummaryColumn::optional(name, about, of)
}

/// What its times say.
fn times() -> Vec<SummaryColumn> {
    let ns = "nanoseconds";
    vec![
        SummaryColumn::text("way", "How its rays are traced in the total; null for all bounces", |row| {
            row.way
        }),
        real("trace_ns", "Median time of the trace alone, of rays as they lie", |row| row.trace_ns).unit(ns),
        real("total_ns", "Median time of all stages; null for all bounces", |row| row.total_ns).unit(ns),
        real("trace_speedup", "Unsorted trace over trace in this order", |row| {
            Some(row.trace_speedup?.ratio)
        }),
        real("trace_speedup_low", "Lower end of its 95 % interval; null with fewer than six rounds", |row| {
            Some(row.trace_speedup?.interval?.0)
        }),
        real("trace_speedup_high", "Upper end of it", |row| Some(row.trace_speedup?.interval?.1)),
        real("net_speedup", "Unsorted trace over all stages", |row| Some(row.net_speedup?.ratio)),
        real("net_speedup_low", "Lower end of its 95 % interval; null with fewer than six rounds", |row| {
            Some(row.net_speedup?.interval?.0)
        }),
        real("net_speedup_high", "Upper end of it", |row| Some(row.net_speedup?.interval?.1)),
    ]
}

/// How coherent its rays are, how full the length table is, and how right.
fn coherence() -> Vec<SummaryColumn> {
    let unit_lengths = "unit lengths: the scene's largest side is 1";
    vec![
        real("capsule_area", "Mean capsule area of a ray's group; null for all bounces", |row| {
            row.capsule_area
        })
        .unit("unit lengths squared"),
        real("capsule_area_ratio", "Mean capsule area over that of unsorted rays", |row| {
            row.capsule_area_ratio
        }),
        real("direction_spread", "Mean direction spread of a ray's group: 0 if all are parallel", |row| {
            row.direction_spread
        }),
        real("lane_utilisation", "Share of their time in which 32 lanes work; a model", |row| {
            row.lane_utilisation
        }),
        real("table_fill", "Share of the length table's cells that hold a ray", |row| row.table_fill),
        real("table_error", "Mean error of the lengths that the table estimates", |row| row.table_error)
            .unit(unit_lengths),
        real("constant_error", "Mean error of one length for all rays", |row| row.constant_error)
            .unit(unit_lengths),
    ]
}
