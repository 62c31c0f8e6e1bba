//! The work of one stage on the GPU: recorded first, then submitted in pieces and timed as one figure.

use std::time::Instant;

use bytemuck::NoUninit;

use super::item::{BoundKernel, ITEMS_PER_SUBMISSION, THREADS};
use super::kernel::grid;
use super::timing::{MOST_TIMED_SUBMISSIONS, Timestamps};
use super::{Chunk, DeviceArray, Gpu, GpuError, Kernel, Parameters};

/// The dispatches of one stage, in order. Each sees what those before it have written.
#[derive(Debug)]
pub struct StageRun<'gpu> {
    gpu: &'gpu Gpu,
    stage: String,
    submissions: Vec<Vec<Command>>,
}

#[derive(Debug)]
enum Command {
    Dispatch { pipeline: wgpu::ComputePipeline, group: wgpu::BindGroup, immediates: Vec<u8>, grid: [u32; 3] },
    Clear { buffer: wgpu::Buffer },
    Copy { from: wgpu::Buffer, to: wgpu::Buffer, bytes: u64 },
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
        group: &wgpu::BindGroup,
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
            group: group.clone(),
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
                self.dispatch(kernel, group, &parameters.of(chunk), workgroups);
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
        self.encoded(None)
            .into_iter()
            .try_for_each(|commands| self.gpu.submit(&self.stage, commands).map(drop))
    }

    /// Runs everything, waits for it, and returns how many nanoseconds it took: on the GPU's own clock where
    /// it has one, gaps between the submissions left out, else on the CPU's from submission to completion.
    /// While the time is taken nothing is made or encoded.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn finish(mut self) -> Result<u64, GpuError> {
        self.submissions.retain(|commands| !commands.is_empty());
        let count = self.submissions.len();
        if count == 0 {
            return Ok(0);
        }
        if count > MOST_TIMED_SUBMISSIONS || !self.gpu.has(wgpu::Features::TIMESTAMP_QUERY) {
            return self.finish_by_wall_clock();
        }
        let (gpu, stage) = (self.gpu, &self.stage);
        let timestamps = gpu.take_timestamps()?;
        let mut last = None;
        for commands in self.encoded(Some(&timestamps)) {
            last = Some(gpu.submit(stage, commands)?);
        }
        let Some(last) = last else { return Ok(0) };
        let elapsed_ns = timestamps.elapsed_ns(gpu, stage, count, last)?;
        gpu.keep_timestamps(timestamps);
        Ok(elapsed_ns)
    }

    fn push(&mut self, command: Command) {
        if let Some(submission) = self.submissions.last_mut() {
            submission.push(command);
        }
    }

    /// Everything, as it is submitted.
    fn encoded(&self, timestamps: Option<&Timestamps>) -> Vec<wgpu::CommandBuffer> {
        let label = wgpu::CommandEncoderDescriptor { label: Some(&self.stage) };
        let count = self.submissions.len();
        let encoded = |(index, commands): (usize, &Vec<Command>)| {
            let mut encoder = self.gpu.device().create_command_encoder(&label);
            let queries = timestamps.map(|timestamps| (&timestamps.queries, 2 * index as u32));
            encode(&mut encoder, &self.stage, commands, queries);
            if let Some(timestamps) = timestamps.filter(|_| index + 1 == count) {
                timestamps.resolve(&mut encoder, count);
            }
            encoder.finish()
        };
        self.submissions.iter().enumerate().map(encoded).collect()
    }

    fn finish_by_wall_clock(self) -> Result<u64, GpuError> {
        let (gpu, stage) = (self.gpu, &self.stage);
        let encoded = self.encoded(None);
        // What was submitted before must not be counted.
        gpu.wait(stage, None)?;
        let start = Instant::now();
        for commands in encoded {
            gpu.submit(stage, commands)?;
        }
        gpu.wait(stage, None)?;
        Ok(start.elapsed().as_nanos() as u64)
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
    if let Command::Dispatch { pipeline, group, immediates, grid: [x, y, z] } = command {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        if !immediates.is_empty() {
            pass.set_immediates(0, immediates);
        }
        pass.dispatch_workgroups(*x, *y, *z);
    }
}
