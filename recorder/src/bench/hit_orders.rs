//! Orders of hits: what a renderer may sort between tracing and shading, as shader execution reordering does.

use anyhow::{Context, Result};
use formats::bench_result::ShadeCoherence;
use formats::key::{LayoutText, Method, Termination};
use formats::ray::{Hit, Kind};

use crate::backends::{Array, Backend, Queue, collected};
use crate::stages::setup::{MethodPlan, Setup};
use crate::stages::shade::tables::ShadeTables;

/// Neighbours that a GPU shades together.
const WARP: usize = 32;

/// What hits are sorted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HitOrder {
    Material,
    Triangle,
    /// Where the ray hits, along a Morton curve; where it leaves the scene if it hits nothing.
    Place,
}

impl HitOrder {
    pub(super) const ALL: [Self; 3] = [Self::Material, Self::Triangle, Self::Place];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Material => "hits by material",
            Self::Triangle => "hits by triangle",
            Self::Place => "hits by place",
        }
    }

    /// The method that has the keys of places.
    ///
    /// # Errors
    /// None; its layout is a layout.
    pub(super) fn place_method() -> Result<Method> {
        let layout = LayoutText::parse("(ex ey ez)*21 ex")?;
        Ok(Method { name: Self::Place.name().to_owned(), layout, termination: Termination::Real })
    }

    /// Keys of hits, and the time that making them took, nanoseconds: 0 where a key is a number that tracing could
    /// have written, too.
    ///
    /// # Errors
    /// Any of the backend.
    pub(super) fn keys<B: Backend>(
        self,
        backend: &mut B,
        setup: &Setup,
        rays: &B::Rays,
        hits: &B::Hits,
    ) -> Result<(B::Keys, u64)> {
        let tables = &setup.tables;
        let number = |hit: &Hit| match self {
            Self::Material => material(tables, hit),
            Self::Triangle | Self::Place => hit.is_hit().then_some(hit.triangle),
        };
        let count = match self {
            Self::Place => {
                let is_it = |plan: &MethodPlan| plan.name == self.name();
                let number =
                    setup.methods.iter().position(is_it).context("a run that sorts hits keys places")?;
                let keys = backend.key(rays, Some(hits), number)?;
                return Ok((keys, backend.elapsed_ns()));
            }
            Self::Material => tables.materials.len(),
            Self::Triangle => tables.triangles.len(),
        };
        let found: Vec<Hit> = collected(backend, Array::Hits(hits))?;
        // What hits nothing comes last.
        let keys: Vec<u64> = found.iter().map(|hit| number(hit).map_or(count as u64, u64::from)).collect();
        Ok((backend.upload_keys(&keys, usize::BITS - count.leading_zeros())?, 0))
    }
}

fn material(tables: &ShadeTables, hit: &Hit) -> Option<u32> {
    hit.is_hit().then(|| tables.triangles[hit.triangle as usize][3])
}

/// Ways that shading takes: nothing hit, or a material with or without a texture, gloss and light of its own.
fn branch(tables: &ShadeTables, hit: &Hit) -> u32 {
    let Some(material) = material(tables, hit) else { return 0 };
    let material = &tables.materials[material as usize];
    let is_glossy = material.metallic > 0.0 || material.roughness < 1.0;
    let shines = material.emission.iter().any(|&light| light > 0.0);
    1 + u32::from(material.texture_width > 0) + 2 * u32::from(is_glossy) + 4 * u32::from(shines)
}

/// Counts what neighbours have in common when they are shaded.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    warps: u64,
    materials: u64,
    branches: u64,
}

impl Tally {
    /// Counts a queue, whose hits lie in the order of shading.
    ///
    /// # Errors
    /// Any of the backend.
    pub(super) fn add<B: Backend>(
        &mut self,
        backend: &mut B,
        setup: &Setup,
        rays: &B::Rays,
        hits: &B::Hits,
    ) -> Result<()> {
        if rays.id().kind == Kind::Shadow {
            return Ok(());
        }
        let found: Vec<Hit> = collected(backend, Array::Hits(hits))?;
        for warp in found.chunks(WARP) {
            self.warps += 1;
            self.materials +=
                distinct(warp.iter().map(|hit| material(&setup.tables, hit).unwrap_or(u32::MAX)));
            self.branches += distinct(warp.iter().map(|hit| branch(&setup.tables, hit)));
        }
        Ok(())
    }

    pub(super) fn coherence(&self) -> Option<ShadeCoherence> {
        let mean = |sum: u64| sum as f64 / self.warps as f64;
        let found = ShadeCoherence { materials: mean(self.materials), branches: mean(self.branches) };
        (self.warps > 0).then_some(found)
    }
}

fn distinct(values: impl Iterator<Item = u32>) -> u64 {
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values.len() as u64
}
