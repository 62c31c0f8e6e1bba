//! The work of one stage on the GPU: recorded first, then submitted in pieces and timed as one figure.

use std::time::Instant;

use bytemuck::NoUninit;

use super::item::{BoundKernel, ITEMS_PER_SUBMISSION, THREADS};
use super::kernel::grid;
use super::timing::covered_ticks;
use super::{Chunk, DeviceArray, Gpu, GpuError, Kernel, Parameters};

/// Most submissions of one run that are timed one by one; wgpu's query sets end at 4096 entries.
const MOST_TIMED_SUBMISSIONS: usize = 2048;

/// Bytes of one timestamp.
const TIMESTAMP_BYTES: u64 = 8;

/// The dispatches of one stage, in order. Each sees what those before it have written.
#[derive(Debug)]
pub struct StageRun<'gpu> {
    gpu: &'gpu Gpu,
    stage: String,
    submissions: Vec<Vec<Command>>,
}

#[derive(Debug)]
enum Command {
    Dispatch {
        pipeline: wgpu::ComputePipeline,
        groups: Vec<wgpu::BindGroup>,
        immediates: Vec<u8>,
        grid: [u32; 3],
    },
    Clear {
        buffer: wgpu::Buffer,
    },
    Copy {
        from: wgpu::Buffer,
        to: wgpu::Buffer,
        bytes: u64,
    },
}

impl Gpu {
    /// Begins to record the work of a stage; nothing runs before it is finished or submitted.
    pub fn stage(&self, stage: &str) -> StageRun<'_> {
        StageRun { gpu: self, stage: stage.to_owned(), submissions: vec![Vec::new()] }
    }
}

impl StageRun<'_> {
    /// Adds a dispatch of at least `workgroups` workgroups; nothing if that is 0.
    ///
    /// # Panics
    /// If the immediates are not the bytes that the kernel was made for.
    pub fn dispatch<I: NoUninit>(
        &mut self,
        kernel: &Kernel,
        groups: &[&wgpu::BindGroup],
        immediates: &I,
        workgroups: u32,
    ) {
        let immediates = bytemuck::bytes_of(immediates).to_vec();
        assert_eq!(
            immediates.len(),
            kernel.immediate_bytes as usize,
            "{} takes other immediates",
            kernel.label
        );
        if workgroups == 0 {
            return;
        }
        let largest_axis = self.gpu.adapter().limits.workgroups_per_axis;
        self.push(Command::Dispatch {
            pipeline: kernel.pipeline.clone(),
            groups: groups.iter().map(|&group| group.clone()).collect(),
            immediates,
            grid: grid(workgroups, largest_axis),
        });
    }

    /// Adds kernels that run for the same items: one dispatch of each in turn and one submission per chunk of
    /// them, so that none runs long enough to wake a driver's watchdog.
    ///
    /// # Panics
    /// If the kernels take other parameters or were bound for different numbers of items.
    pub fn for_items<P: Parameters>(&mut self, kernels: &[BoundKernel<'_>], parameters: P) {
        self.for_items_by(kernels, parameters, ITEMS_PER_SUBMISSION);
    }

    /// The same with other chunks.
    pub(super) fn for_items_by<P: Parameters>(
        &mut self,
        kernels: &[BoundKernel<'_>],
        parameters: P,
        per_submission: u32,
    ) {
        let items = kernels.first().map_or(0, |kernel| kernel.count);
        for (index, chunk) in Chunk::split(items, per_submission).enumerate() {
            if index > 0 {
                self.submissions.push(Vec::new());
            }
            let workgroups = chunk.count.div_ceil(THREADS);
            for BoundKernel { kernel, group, count } in kernels {
                assert_eq!(*count, items, "items of {}", kernel.label);
                self.dispatch(kernel, &[group], &parameters.of(chunk), workgroups);
            }
        }
    }

    /// Fills an array with zeros.
    pub fn clear<T>(&mut self, array: &DeviceArray<T>) {
        self.push(Command::Clear { buffer: array.buffer().clone() });
    }

    /// Copies the first `len` elements of one array into another.
    ///
    /// # Panics
    /// If one of them has fewer.
    pub fn copy<T>(&mut self, from: &DeviceArray<T>, to: &DeviceArray<T>, len: usize) {
        assert!(len <= from.len() && len <= to.len(), "{len} elements of {}", from.label());
        let bytes = (len * size_of::<T>()) as u64;
        if bytes > 0 {
            self.push(Command::Copy { from: from.buffer().clone(), to: to.buffer().clone(), bytes });
        }
    }

    /// Runs everything and returns without waiting for it or timing it.
    ///
    /// # Errors
    /// As [`Gpu::check`]; what goes wrong on the device itself appears in a later call.
    pub fn submit(self) -> Result<(), GpuError> {
        for commands in &self.submissions {
            let mut encoder = self.encoder();
            encode(&mut encoder, &self.stage, commands, None);
            self.gpu.submit(&self.stage, encoder.finish())?;
        }
        Ok(())
    }

    /// Runs everything, waits for it, and returns how many nanoseconds it took: on the GPU's own clock where
    /// it has one, gaps between the submissions left out, else on the CPU's from submission to completion.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn finish(self) -> Result<u64, GpuError> {
        let timed =
            self.gpu.has(wgpu::Features::TIMESTAMP_QUERY) && self.submissions.len() <= MOST_TIMED_SUBMISSIONS;
        if timed { self.finish_by_timestamps() } else { self.finish_by_wall_clock() }
    }

    fn push(&mut self, command: Command) {
        if let Some(submission) = self.submissions.last_mut() {
            submission.push(command);
        }
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(&self.stage) })
    }

    fn finish_by_wall_clock(self) -> Result<u64, GpuError> {
        let gpu = self.gpu;
        let stage = self.stage.clone();
        // What was submitted before must not be counted.
        gpu.wait(&stage, None)?;
        let start = Instant::now();
        self.submit()?;
        gpu.wait(&stage, None)?;
        Ok(start.elapsed().as_nanos() as u64)
    }

    fn finish_by_timestamps(mut self) -> Result<u64, GpuError> {
        self.submissions.retain(|commands| !commands.is_empty());
        if self.submissions.is_empty() {
            return Ok(0);
        }
        let count = 2 * self.submissions.len() as u32;
        let queries = self.gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some(&self.stage),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let resolved = self.gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("timing::resolved"),
            size: u64::from(count) * TIMESTAMP_BYTES,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        self.gpu.check("making timestamp queries")?;
        let last = self.submissions.len() - 1;
        for (index, commands) in self.submissions.iter().enumerate() {
            let mut encoder = self.encoder();
            encode(&mut encoder, &self.stage, commands, Some((&queries, 2 * index as u32)));
            if index == last {
                encoder.resolve_query_set(&queries, 0..count, &resolved, 0);
            }
            self.gpu.submit(&self.stage, encoder.finish())?;
        }
        let ticks: Vec<u64> =
            super::readback::read_buffer(self.gpu, &self.stage, &resolved, u64::from(count))?;
        let mut intervals: Vec<_> = ticks.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        let period_ns = f64::from(self.gpu.queue().get_timestamp_period());
        Ok((covered_ticks(&mut intervals) as f64 * period_ns).round() as u64)
    }
}

/// Encodes the commands of one submission; with `timestamps`, the time before the first and after
/// the last of them is written to the query set at the given index and the one after it.
fn encode(
    encoder: &mut wgpu::CommandEncoder,
    stage: &str,
    commands: &[Command],
    timestamps: Option<(&wgpu::QuerySet, u32)>,
) {
    let mark = |encoder: &mut wgpu::CommandEncoder, begin: bool| {
        let writes = timestamps.map(|(query_set, index)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: begin.then_some(index),
            end_of_pass_write_index: (!begin).then_some(index + 1),
        });
        if writes.is_some() {
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(stage),
                timestamp_writes: writes,
            });
        }
    };
    let is_dispatch = |command: &Command| matches!(command, Command::Dispatch { .. });
    let pieces: Vec<&[Command]> = commands.chunk_by(|a, b| is_dispatch(a) && is_dispatch(b)).collect();
    if commands.first().is_none_or(|command| !is_dispatch(command)) {
        mark(encoder, true);
    }
    let last = pieces.len().saturating_sub(1);
    for (index, piece) in pieces.into_iter().enumerate() {
        let begin = timestamps.filter(|_| index == 0).map(|(_, query)| query);
        let end = timestamps.filter(|_| index == last).map(|(_, query)| query + 1);
        match &piece[0] {
            Command::Dispatch { .. } => {
                let writes = timestamps.filter(|_| begin.is_some() || end.is_some());
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(stage),
                    timestamp_writes: writes.map(|(query_set, _)| wgpu::ComputePassTimestampWrites {
                        query_set,
                        beginning_of_pass_write_index: begin,
                        end_of_pass_write_index: end,
                    }),
                });
                piece.iter().for_each(|command| encode_dispatch(&mut pass, command));
            }
            Command::Clear { buffer } => encoder.clear_buffer(buffer, 0, None),
            Command::Copy { from, to, bytes } => {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, *bytes);
            }
        }
    }
    if commands.last().is_none_or(|command| !is_dispatch(command)) {
        mark(encoder, false);
    }
}

fn encode_dispatch(pass: &mut wgpu::ComputePass<'_>, command: &Command) {
    if let Command::Dispatch { pipeline, groups, immediates, grid: [x, y, z] } = command {
        pass.set_pipeline(pipeline);
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        if !immediates.is_empty() {
            pass.set_immediates(0, immediates);
        }
        pass.dispatch_workgroups(*x, *y, *z);
    }
}
