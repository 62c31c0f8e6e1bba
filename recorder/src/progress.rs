//! A progress bar on stderr: how much of the run is done, rays per second, time left; a line a minute where stderr is
//! no terminal.

use std::cell::Cell;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use formats::manifest::QueueId;
use formats::ray::Kind;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::output::say;

/// What a bar counts to.
const LENGTH: f64 = 1e6;
/// The share of rays that are expected to go on from bounce to bounce. The total does not depend on how many do.
const GO_ON: f64 = 0.8;

/// Between two lines, where there is no bar.
const SILENCE: Duration = Duration::from_secs(60);

/// Progress of a run over passes, in traces that are expected.
pub struct Progress {
    bar: ProgressBar,
    bounces: u32,
    /// For each pass, in the order in which they run: traces of each ray beyond the first.
    traces: Vec<u64>,
    /// Rays that were traced, once for each trace.
    rays: Arc<AtomicU64>,
    /// The number of the pass that runs, and its last queue.
    last: Cell<Option<(usize, QueueId)>>,
    /// How long it ran when a line was written last.
    said: Cell<Duration>,
}

impl Progress {
    /// For passes of so many bounces that trace every ray so many times beyond the first.
    pub fn new(bounces: u32, traces: Vec<u64>) -> Self {
        let rays = Arc::new(AtomicU64::new(0));
        let traced = rays.clone();
        let rate = move |state: &ProgressState, text: &mut dyn Write| {
            let seconds = state.elapsed().as_secs_f64().max(1e-9);
            // A bar has nothing to say of what cannot be written.
            let _ = write!(text, "{:.1} Mrays/s", traced.load(Ordering::Relaxed) as f64 / seconds / 1e6);
        };
        let bar = ProgressBar::new(LENGTH as u64);
        let style = ProgressStyle::with_template("{msg:22} {wide_bar} {percent:>3} %  {rate}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style.with_key("rate", rate));
        }
        Self { bar, bounces, traces, rays, last: Cell::default(), said: Cell::default() }
    }

    /// A queue of `rays` was traced once.
    pub fn traced(&self, id: QueueId, rays: usize) {
        let pass = match self.last.get() {
            None => 0,
            // Queues ascend within a pass.
            Some((pass, last)) => pass + usize::from(last.pass != id.pass || id <= last),
        };
        self.last.set(Some((pass, id)));
        let queue = format!("pass {} bounce {} {}", id.pass, id.bounce, id.kind);
        self.rays.fetch_add(rays as u64, Ordering::Relaxed);
        let position = self.position(pass, id, 1.0);
        let elapsed = self.bar.elapsed();
        if self.bar.is_hidden() && elapsed >= self.said.get() + SILENCE {
            self.said.set(elapsed);
            say(format!("{} s: {:.0} % done, {queue}", elapsed.as_secs(), 100.0 * position as f64 / LENGTH));
        }
        self.bar.set_message(queue);
        self.bar.set_position(position);
    }

    /// That queue was measured with all methods.
    pub fn measured(&self, id: QueueId, rays: usize) {
        let pass = self.last.get().map_or(0, |(pass, _)| pass);
        let traces = self.traces.get(pass).copied().unwrap_or(0);
        self.rays.fetch_add(rays as u64 * traces, Ordering::Relaxed);
        self.bar.set_position(self.position(pass, id, 1.0 + traces as f64));
    }

    /// The bar is done.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Where the bar is when of a queue so many traces are done.
    fn position(&self, pass: usize, id: QueueId, traces: f64) -> u64 {
        let whole = |traces: &u64| 1.0 + *traces as f64;
        let rays = |bounce: u32| GO_ON.powi(bounce as i32);
        let of_pass = 2.0 * (0..self.bounces).map(rays).sum::<f64>();
        let earlier = of_pass * self.traces.iter().take(pass).map(whole).sum::<f64>();
        let before = 2.0 * (0..id.bounce).map(rays).sum::<f64>()
            + if id.kind == Kind::Shadow { rays(id.bounce) } else { 0.0 };
        let own = self.traces.get(pass).map_or(1.0, whole) * before + traces * rays(id.bounce);
        let all = of_pass * self.traces.iter().map(whole).sum::<f64>();
        ((earlier + own) / all * LENGTH).min(LENGTH) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A calibration on the pass after the last, a pass, a pass that is measured: never backwards, to the end.
    #[test]
    fn the_bar_goes_forward_to_its_end() {
        let progress = Progress::new(3, vec![4, 0, 9]);
        let mut last = 0;
        for (number, pass) in [2, 0, 1].into_iter().enumerate() {
            for bounce in 0..3 {
                for kind in Kind::ALL {
                    let id = QueueId { pass, bounce, kind };
                    progress.traced(id, 100);
                    let traced = progress.bar.position();
                    if number != 1 {
                        progress.measured(id, 100);
                    }
                    let measured = progress.bar.position();
                    assert!(last < traced && traced <= measured, "{id}: {last}, {traced}, {measured}");
                    last = measured;
                }
            }
        }
        assert!((LENGTH as u64 - last) <= 1, "{last}");
        assert_eq!(progress.rays.load(Ordering::Relaxed), 6 * 100 * (5 + 1 + 10));
    }

    /// Imported queues come in one pass, which is the calibration's too.
    #[test]
    fn a_queue_that_comes_again_is_of_the_next_pass() {
        let progress = Progress::new(1, vec![3, 3]);
        let id = QueueId { pass: 0, bounce: 0, kind: Kind::Closest };
        let positions = [(); 2].map(|()| {
            progress.traced(id, 1);
            progress.measured(id, 1);
            progress.bar.position()
        });
        assert_eq!(positions, [250_000, 750_000]);
    }
}
