//! Features that a scene does not have: pipelines as they are, and specialised as if it had them.

use std::sync::Arc;

use anyhow::Result;
use formats::bench_result::skip::SkipRow;
use formats::manifest::Stage;
use scenes::features::Features;

use super::super::backends::{Configuration, OnBackends, measure_all};
use super::Bench;
use crate::backends::{Backend, picture};
use crate::machine::Device;
use crate::measure::sampled;
use crate::stages::setup::Setup;
use crate::stages::shade::cpu::SPECIALISED;
use crate::stages::shade::tables::ShadeTables;
use crate::stages::trace::mask::Masks;
use crate::wavefront::{self, Observer};

/// What is skipped of the scene's features, one by one and all together.
pub(super) fn rows(bench: Bench<'_>) -> Result<Vec<SkipRow>> {
    let needed = bench.setup.features;
    let on_threads = matches!(bench.device, Device::Cpu(_));
    let is_specialised = |feature: Features| !on_threads || SPECIALISED.union(feature) == SPECIALISED;
    let is_absent =
        |&(_, feature): &(_, Features)| needed.union(feature) != needed && is_specialised(feature);
    let absent: Vec<_> = Features::each().into_iter().filter(is_absent).collect();
    let mut rows = Vec::new();
    for &(name, feature) in &absent {
        let stage = if feature.alpha_masks { "trace" } else { "shade" };
        rows.extend(compare(bench, name, needed.union(feature), &[stage])?);
    }
    if absent.len() > 1 {
        let all = absent.iter().fold(needed, |all, &(_, feature)| all.union(feature));
        rows.extend(compare(bench, "all these features", all, &["trace", "shade"])?);
    }
    Ok(rows)
}

fn compare(bench: Bench<'_>, what: &str, features: Features, stages: &[&str]) -> Result<Vec<SkipRow>> {
    let tables = ShadeTables::clone(&bench.setup.tables).for_features(&features);
    let with = Setup { features, tables: Arc::new(tables), ..Setup::clone(bench.setup) };
    let kernel = bench.device.kernel(&bench.run.device);
    let configurations =
        [Arc::clone(bench.setup), Arc::new(with)].map(|setup| Configuration { setup, kernel });
    let sides = measure_all(bench.device, bench.scene, &configurations, Sides { bench })?;
    let bytes = |configuration: &Configuration, stage: &str| {
        let setup = &configuration.setup;
        match stage {
            "trace" => mask_bytes(&Masks::for_features(bench.scene, &setup.features)),
            _ => feature_bytes(&setup.tables),
        }
    };
    let row = |&stage: &&str| {
        let mut row = bench.row(what, stage, "picture");
        row.is_same = sides[0].image == sides[1].image;
        let costs = [&mut row.skipped, &mut row.done];
        for ((cost, side), configuration) in costs.into_iter().zip(&sides).zip(&configurations) {
            cost.samples_ns = if stage == "trace" { side.trace_ns.clone() } else { side.shade_ns.clone() };
            cost.bytes = bytes(configuration, stage);
        }
        row
    };
    Ok(stages.iter().map(row).collect())
}

/// Bytes of what only textures and vertex normals need.
fn feature_bytes(tables: &ShadeTables) -> u64 {
    (size_of_val(&*tables.normals) + size_of_val(&*tables.uvs) + size_of_val(&*tables.texels)) as u64
}

fn mask_bytes(masks: &Masks) -> u64 {
    (size_of_val(&*masks.numbers) + size_of_val(&*masks.triangles) + masks.alphas.len()) as u64
}

/// What one backend took, a sample per repeat, and what it painted.
struct Side {
    trace_ns: Vec<u64>,
    shade_ns: Vec<u64>,
    image: Vec<[f32; 3]>,
}

struct Sides<'a> {
    bench: Bench<'a>,
}

impl OnBackends for Sides<'_> {
    type Output = Vec<Side>;

    /// Passes on each backend, in rounds.
    fn run<B: Backend>(self, mut backends: Vec<B>) -> Result<Vec<Side>> {
        let run = self.bench.run;
        let passes = sampled(backends.len(), run.repeats, run.seed, |at| {
            let mut pass = Pass::default();
            wavefront::run(&mut backends[at], 0..1, run.bounces, &mut pass)?;
            Ok(pass)
        })?;
        let side = |(passes, backend): (Vec<Pass>, &mut B)| {
            let (trace_ns, shade_ns) = passes.iter().map(|pass| (pass.trace_ns, pass.shade_ns)).unzip();
            // One pass more: that of the round which does not count.
            Ok(Side { trace_ns, shade_ns, image: picture(backend, run.repeats + 1)? })
        };
        passes.into_iter().zip(&mut backends).map(side).collect()
    }
}

/// Adds up the stages of one pass.
#[derive(Default)]
struct Pass {
    trace_ns: u64,
    shade_ns: u64,
}

impl<B: Backend> Observer<B> for Pass {
    fn measure(&mut self, backend: &mut B, _: &B::Rays, _: &B::Hits) -> Result<()> {
        self.trace_ns += backend.elapsed_ns();
        Ok(())
    }

    fn ran(&mut self, backend: &B, stage: Stage, _: &B::Rays) -> Result<()> {
        if stage == Stage::Shade {
            self.shade_ns += backend.elapsed_ns();
        }
        Ok(())
    }
}
