//! A progress bar on stderr: rays traced, rays per second, time left.

use formats::manifest::QueueId;
use indicatif::{ProgressBar, ProgressStyle};

/// Progress of a recording, in traced rays. Hidden where stderr is not a terminal.
pub struct Progress {
    bar: ProgressBar,
    passes: u32,
    bounces: u32,
    /// Traces of each ray of the measured pass beyond the first.
    measured_traces: u64,
}

impl Progress {
    /// For a run of `passes` × `bounces` whose measured pass traces every ray `measured_traces`
    /// times more.
    pub fn new(passes: u32, bounces: u32, pixels: u64, measured_traces: u64) -> Self {
        let bar = ProgressBar::new(0);
        let style = ProgressStyle::with_template(
            "{msg:22} {wide_bar} {human_pos}/{human_len} rays  {per_sec}  {eta} left",
        );
        if let Ok(style) = style {
            bar.set_style(style);
        }
        let progress = Self { bar, passes, bounces, measured_traces };
        progress.expect(0, 0, pixels);
        progress
    }

    /// A queue of `rays` was traced once.
    pub fn traced(&self, id: QueueId, rays: usize) {
        self.bar.set_message(format!("pass {} bounce {} {}", id.pass, id.bounce, id.kind));
        self.bar.inc(rays as u64);
        self.expect(id.pass, id.bounce, rays as u64);
    }

    /// A queue of `rays` was measured with all methods.
    pub fn measured(&self, id: QueueId, rays: usize) {
        self.bar.inc(rays as u64 * self.measured_traces);
        self.expect(id.pass, id.bounce, rays as u64);
    }

    /// The bar is done.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Every later queue of the pass can have no more rays than this one had; later passes will be
    /// like it.
    fn expect(&self, pass: u32, bounce: u32, rays: u64) {
        let queues_left = 2 * u64::from(self.bounces.saturating_sub(bounce + 1));
        let passes_left = u64::from(self.passes.saturating_sub(pass + 1));
        let per_queue = |measured: bool| if measured { 1 + self.measured_traces } else { 1 };
        let this_pass = queues_left * rays * per_queue(passes_left == 0);
        let whole_pass = 2 * u64::from(self.bounces) * rays;
        let later = whole_pass * passes_left.saturating_sub(1)
            + if passes_left > 0 { whole_pass * per_queue(true) } else { 0 };
        self.bar.set_length(self.bar.position() + this_pass + later);
    }
}
