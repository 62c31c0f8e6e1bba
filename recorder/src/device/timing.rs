//! The device's own clock: timestamps around the submissions of a run, and the time that they cover.

use super::readback::{InFlight, make_staging};
use super::{Gpu, GpuError};

/// Most submissions of one run that are timed one by one; wgpu's query sets end at 4096 entries.
pub(super) const MOST_TIMED_SUBMISSIONS: usize = 2048;

/// Timestamps of one run, of which a device has as many as run at a time: a run makes nothing of its own.
#[derive(Debug)]
pub(super) struct Timestamps {
    /// Before and after each submission.
    pub(super) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

/// Bytes of the timestamps of so many submissions.
fn bytes_of(submissions: usize) -> u64 {
    (2 * submissions * size_of::<u64>()) as u64
}

impl Timestamps {
    /// Room for [`MOST_TIMED_SUBMISSIONS`].
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let queries = gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timing::queries"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST_TIMED_SUBMISSIONS as u32,
        });
        let resolved = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("timing::resolved"),
            size: bytes_of(MOST_TIMED_SUBMISSIONS),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        gpu.check("making timestamp queries")?;
        Ok(Self { queries, resolved, staging: make_staging(gpu, bytes_of(MOST_TIMED_SUBMISSIONS))? })
    }

    /// Copies the timestamps of the first submissions to where they are read.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, submissions: usize) {
        encoder.resolve_query_set(&self.queries, 0..2 * submissions as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, bytes_of(submissions));
    }

    /// Waits for the last of the submissions; returns the nanoseconds in which any of them ran.
    pub(super) fn elapsed_ns(
        &self,
        gpu: &Gpu,
        stage: &str,
        submissions: usize,
        last: wgpu::SubmissionIndex,
    ) -> Result<u64, GpuError> {
        let mut ticks: Vec<u64> = Vec::new();
        let piece = InFlight::of(gpu, stage, self.staging.clone(), bytes_of(submissions), last)?;
        piece.receive(gpu, stage, &mut |bytes| {
            ticks = bytemuck::pod_collect_to_vec(bytes);
            Ok::<(), GpuError>(())
        })?;
        let mut intervals: Vec<_> = ticks.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        let period_ns = f64::from(gpu.queue().get_timestamp_period());
        Ok((covered_ticks(&mut intervals) as f64 * period_ns).round() as u64)
    }
}

/// Ticks that at least one of the intervals covers.
///
/// Submissions of one stage may overlap on the device; what they share is counted once, and what
/// lies between them not at all.
fn covered_ticks(intervals: &mut [(u64, u64)]) -> u64 {
    intervals.sort_unstable();
    let mut covered = 0;
    let mut counted_up_to = 0;
    for &(begin, end) in intervals.iter() {
        let begin = begin.max(counted_up_to);
        covered += end.saturating_sub(begin);
        counted_up_to = counted_up_to.max(end);
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::covered_ticks;

    #[test]
    fn overlaps_count_once_and_gaps_not_at_all() {
        assert_eq!(covered_ticks(&mut []), 0);
        assert_eq!(covered_ticks(&mut [(5, 9)]), 4);
        assert_eq!(covered_ticks(&mut [(20, 30), (0, 10)]), 20, "a gap");
        assert_eq!(covered_ticks(&mut [(0, 10), (5, 15)]), 15, "an overlap");
        assert_eq!(covered_ticks(&mut [(0, 100), (10, 20), (50, 110)]), 110, "one inside another");
        assert_eq!(covered_ticks(&mut [(7, 3)]), 0, "a clock that runs backwards");
    }
}
