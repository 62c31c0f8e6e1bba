//! The numbers of one recording.

use std::path::PathBuf;

use formats::manifest::{Adapter, Options};
use formats::metrics::noise::Noise;
use formats::metrics::samples::Samples;
use formats::reader::Dump;
use formats::summary::hexadecimal;
use serde::Serialize;

use super::frame::{FrameAnalysis, control, instrument_error};
use super::labels;
use super::queue::QueueAnalysis;
use super::summary::{RayClass, distinct};
use super::timing::SpeedupLine;
use crate::shown;

/// The numbers of one recording.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingAnalysis {
    /// What it is called beside the others: its scene, and what tells it from others of that scene.
    pub label: String,
    /// Its folder.
    pub root: PathBuf,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the scene's content, hexadecimal: only equal scenes can be compared.
    pub content_hash: String,
    /// Triangles of the scene.
    pub triangles: u64,
    /// What its times depend on besides scene and method: backend, adapter, kernel and threads.
    pub configuration: String,
    /// The machine.
    pub adapter: Adapter,
    /// What was asked for.
    #[serde(skip)]
    pub options: Options,
    /// What the times were taken with.
    pub time_source: String,
    /// What disturbed them.
    pub noise: Noise,
    /// Its methods over all bounces, by kind of rays.
    pub frames: Vec<FrameAnalysis>,
    /// Unsorted trace over that of the control, over all bounces: what it misses 1 by is the instrument's error.
    #[serde(skip)]
    pub controls: Vec<(RayClass, SpeedupLine)>,
    /// Its queues, in the order in which they were traced.
    pub queues: Vec<QueueAnalysis>,
}

impl RecordingAnalysis {
    pub(super) fn of(dump: &Dump, label: String, mut queues: Vec<QueueAnalysis>) -> Self {
        let manifest = dump.manifest();
        let header = shown::header(&manifest.header);
        let samples = Samples::of(manifest);
        let configuration = labels::configuration(&header);
        let control_of = |rays| Some((rays, control(&samples, &queues, rays)?));
        let controls: Vec<(RayClass, SpeedupLine)> =
            RayClass::ALL.into_iter().filter_map(control_of).collect();
        for queue in &mut queues {
            let error = RayClass::of(queue).map_or(0.0, |rays| instrument_error(&controls, &[rays]));
            queue.orders =
                std::mem::take(&mut queue.orders).into_iter().map(|order| order.beyond(error)).collect();
        }
        Self {
            label,
            root: dump.root().to_owned(),
            scene: header.scene.name,
            content_hash: hexadecimal(&header.scene.content_hash),
            triangles: header.scene.triangles,
            configuration,
            adapter: header.adapter,
            options: header.options,
            time_source: header.time_source,
            noise: Noise::of(manifest),
            frames: FrameAnalysis::all(&queues, &controls),
            controls,
            queues,
        }
    }

    /// A method over all bounces of some rays, if it was measured.
    pub fn frame(&self, rays: RayClass, method: &str) -> Option<&FrameAnalysis> {
        self.frames.iter().find(|frame| frame.rays == rays && frame.method == method)
    }

    /// Unsorted trace over that of the control, of some rays.
    pub fn control(&self, rays: RayClass) -> Option<&SpeedupLine> {
        self.controls.iter().find(|(of, _)| *of == rays).map(|(_, line)| line)
    }

    /// The most that the controls of some rays miss 1 by; 0 where none was measured.
    pub fn instrument_error(&self, rays: &[RayClass]) -> f64 {
        instrument_error(&self.controls, rays)
    }

    /// The controls that miss 1 by so much that other speedups cannot be trusted.
    pub fn bad_controls(&self) -> impl Iterator<Item = &(RayClass, SpeedupLine)> {
        self.controls.iter().filter(|(_, line)| line.speedup().is_bad_control())
    }

    /// A clause for what stands below its numbers: nothing where the machine was quiet.
    pub fn disturbed(&self) -> String {
        let Noise { samples, disturbed, .. } = self.noise;
        match self.noise.is_disturbed() {
            true => format!(", {disturbed} of {samples} samples while the machine did other work"),
            false => String::new(),
        }
    }

    /// How long keys are: those that were asked for or, in a sweep, those of the variants.
    pub fn key_bits(&self) -> String {
        let orders = self.measured().flat_map(|queue| &queue.orders);
        let variants = orders.filter(|order| order.base != order.method);
        let mut bits = distinct(variants.filter_map(|order| order.key_bits));
        bits.sort_unstable();
        if bits.is_empty() {
            bits.push(self.options.key_bits);
        }
        bits.iter().map(|bits| format!("{bits}-bit")).collect::<Vec<_>>().join(", ")
    }

    /// The queues in which methods were measured.
    pub fn measured(&self) -> impl DoubleEndedIterator<Item = &QueueAnalysis> {
        self.queues.iter().filter(|queue| !queue.orders.is_empty())
    }

    /// Those of them with these rays.
    pub fn measured_of(&self, rays: RayClass) -> impl Iterator<Item = &QueueAnalysis> {
        self.measured().filter(move |queue| RayClass::of(queue) == Some(rays))
    }
}
