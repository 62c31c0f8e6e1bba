//! The loop: a path tracer in verbs, written once for any backend (DESIGN §2).

use anyhow::Result;
use formats::manifest::Stage;
use formats::ray::Kind;

use crate::backend::{Backend, Queue};

/// Where in the run a queue stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Pass, from 0.
    pub pass: u32,
    /// Surfaces away from the camera.
    pub bounce: u32,
    /// What the rays ask for.
    pub kind: Kind,
}

/// What wants to look at the loop: measuring and capturing stand outside it.
pub trait Observer<B: Backend> {
    /// A queue was traced in canonical order; its table still is as before.
    fn traced(
        &mut self,
        backend: &mut B,
        place: Place,
        rays: &B::Rays,
        hits: &B::Hits,
        elapsed_ns: u64,
    ) -> Result<()>;
    /// A stage that has no queue of its own to show took this long.
    fn stage(&mut self, _place: Place, _stage: Stage, _elapsed_ns: u64) -> Result<()> {
        Ok(())
    }
}

/// Runs `passes` passes of up to `bounces` bounces.
///
/// # Errors
/// Whatever the backend or the observer reports.
pub fn run<B: Backend>(
    backend: &mut B,
    passes: u32,
    bounces: u32,
    observer: &mut impl Observer<B>,
) -> Result<()> {
    for pass in 0..passes {
        let at = |bounce, kind| Place { pass, bounce, kind };
        let generated = backend.generate(pass)?;
        let mut rays = generated.value;
        observer.stage(at(0, Kind::Closest), Stage::Generate, generated.elapsed_ns)?;
        for bounce in 0..bounces {
            if rays.is_empty() {
                break;
            }
            let hits = backend.trace(&rays)?;
            observer.traced(backend, at(bounce, Kind::Closest), &rays, &hits.value, hits.elapsed_ns)?;
            backend.accumulate(&rays, &hits.value)?;
            let shaded = backend.shade(pass, &rays, &hits.value)?;
            observer.stage(at(bounce, Kind::Closest), Stage::Shade, shaded.elapsed_ns)?;
            let shadow_rays = shaded.value.shadow;
            if !shadow_rays.is_empty() {
                let occlusion = backend.trace(&shadow_rays)?;
                observer.traced(
                    backend,
                    at(bounce, Kind::Shadow),
                    &shadow_rays,
                    &occlusion.value,
                    occlusion.elapsed_ns,
                )?;
                backend.accumulate(&shadow_rays, &occlusion.value)?;
                backend.add_light(&shadow_rays, &occlusion.value)?;
            }
            rays = shaded.value.next;
        }
    }
    Ok(())
}
