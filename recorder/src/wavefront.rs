//! The loop: a path tracer in verbs, written once for any backend.
//!
//! It sorts nothing. Meister et al. (2020, "On Ray Reordering Techniques for Faster GPU Ray Tracing") put keys and a sort
//! before each trace; here [`crate::measure::Queued`] does so with every queue that the loop shows its observer, in all
//! orders on the same rays, and the queue stays as it is. The loop that keeps its rays sorted, as a renderer would, is
//! that of `bench::render`.

use std::ops::Range;

use anyhow::Result;
use formats::manifest::Stage;

use crate::backends::{Backend, Queue, RecordedRays, Table};
use crate::stages::trace::Order;

/// What measures and captures the queues of the loop.
pub trait Observer<B: Backend> {
    /// A queue was just traced in canonical order; its length table still is as before.
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()>;
    /// A stage beside tracing has just run: `Generate` made these rays, or `Shade` shaded them.
    fn ran(&mut self, _backend: &B, _stage: Stage, _rays: &B::Rays) -> Result<()> {
        Ok(())
    }
}

/// What only looks at queues.
impl<B: Backend, F: FnMut(&mut B, &B::Rays, &B::Hits) -> Result<()>> Observer<B> for F {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        self(backend, rays, hits)
    }
}

/// Traces paths from the camera: a sample per pixel for each of `passes`, of up to `bounces` bounces.
///
/// # Errors
/// Any of the backend or the observer.
pub fn run<B: Backend>(
    backend: &mut B,
    passes: Range<u32>,
    bounces: u32,
    observer: &mut impl Observer<B>,
) -> Result<()> {
    for pass in passes {
        let mut rays = backend.generate(pass)?;
        observer.ran(backend, Stage::Generate, &rays)?;
        for _ in 0..bounces {
            if rays.is_empty() {
                break;
            }
            let hits = trace(backend, &rays, observer)?;
            let shaded = backend.shade(&rays, &hits)?;
            observer.ran(backend, Stage::Shade, &rays)?;
            if !shaded.shadow.is_empty() {
                let occlusion = trace(backend, &shaded.shadow, observer)?;
                backend.add_light(&shaded.shadow, &occlusion)?;
            }
            rays = shaded.next;
        }
    }
    Ok(())
}

/// Traces queues that were recorded, in the order of their recording.
///
/// # Errors
/// Any of the backend or the observer.
pub fn run_recorded<B: Backend>(
    backend: &mut B,
    queues: &[RecordedRays<'_>],
    observer: &mut impl Observer<B>,
) -> Result<()> {
    for &queue in queues {
        let rays = backend.upload(queue)?;
        trace(backend, &rays, observer)?;
    }
    Ok(())
}

/// Traces a queue in canonical order, measures it, and only then lets the length table learn from it.
fn trace<B: Backend>(backend: &mut B, rays: &B::Rays, observer: &mut impl Observer<B>) -> Result<B::Hits> {
    let hits = backend.trace(rays, Order::Stored)?;
    observer.measure(backend, rays, &hits)?;
    backend.accumulate(rays, &hits, Table::Learnt)?;
    Ok(hits)
}

/// Queues that nobody measures.
impl<B: Backend> Observer<B> for () {
    fn measure(&mut self, _: &mut B, _: &B::Rays, _: &B::Hits) -> Result<()> {
        Ok(())
    }
}
