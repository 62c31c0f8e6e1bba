//! GPU memory to the CPU through a small ring of staging buffers.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::mpsc;

use bytemuck::Pod;

use super::{DeviceArray, Gpu, GpuError};

/// Bytes of a staging buffer.
const STAGING_BYTES: u64 = 16 << 20;

/// Staging buffers of a ring: two are being filled while one is being looked at.
const RING: usize = 3;

/// Reads arrays piece by piece; copies of the next pieces are under way while one is handled, and
/// memory stays at three pieces of at most 16 MiB, for any size of the array.
#[derive(Debug)]
pub struct Readback<'gpu> {
    gpu: &'gpu Gpu,
    staging_bytes: u64,
    free: Vec<wgpu::Buffer>,
}

/// A piece on its way.
pub(super) struct InFlight {
    staging: wgpu::Buffer,
    bytes: u64,
    submission: wgpu::SubmissionIndex,
    mapped: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl<'gpu> Readback<'gpu> {
    /// A ring whose buffers are made when they are first needed.
    pub fn new(gpu: &'gpu Gpu) -> Self {
        Self::with_staging_bytes(gpu, STAGING_BYTES)
    }

    /// A ring with smaller pieces; a positive multiple of 256 bytes.
    fn with_staging_bytes(gpu: &'gpu Gpu, staging_bytes: u64) -> Self {
        Self { gpu, staging_bytes, free: Vec::new() }
    }

    /// Hands the bytes of the elements in `range` to `take`, in order and in pieces; all but the
    /// last piece have the same length, a multiple of the element size if that is a power of two.
    ///
    /// # Errors
    /// Those of the device, and the first that `take` returns; nothing is handed over after it.
    ///
    /// # Panics
    /// If the range is not inside the array or does not begin and end at multiples of four bytes.
    pub fn read_chunks<T: Pod, E: From<GpuError>>(
        &mut self,
        array: &DeviceArray<T>,
        range: Range<usize>,
        mut take: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        assert!(
            range.start <= range.end && range.end <= array.len(),
            "{range:?} of {} elements of {}",
            array.len(),
            array.label()
        );
        let bytes = (range.start * size_of::<T>()) as u64..(range.end * size_of::<T>()) as u64;
        let running = format!("reading {}", array.label());
        self.stream(&running, array.buffer(), bytes, &mut take)
    }

    /// The elements in `range`.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// As [`Readback::read_chunks`].
    pub fn read_vec<T: Pod>(
        &mut self,
        array: &DeviceArray<T>,
        range: Range<usize>,
    ) -> Result<Vec<T>, GpuError> {
        let mut elements = vec![T::zeroed(); range.len()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut elements);
        let mut offset = 0;
        self.read_chunks(array, range, |piece| {
            bytes[offset..offset + piece.len()].copy_from_slice(piece);
            offset += piece.len();
            Ok::<(), GpuError>(())
        })?;
        Ok(elements)
    }

    /// The elements in several ranges of two arrays, side by side: all of it in one copy.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// As [`Readback::read_chunks`].
    pub fn read_pairs<T: Pod>(
        &mut self,
        [first, second]: [&DeviceArray<T>; 2],
        ranges: &[Range<usize>],
    ) -> Result<Vec<[T; 2]>, GpuError> {
        let count: usize = ranges.iter().map(Range::len).sum();
        if count == 0 {
            return Ok(Vec::new());
        }
        let (gpu, size) = (self.gpu, size_of::<T>());
        let running = format!("reading a sample of {}", first.label());
        let staging = make_staging(gpu, (2 * count * size) as u64)?;
        let label = wgpu::CommandEncoderDescriptor { label: Some("readback::sample") };
        let mut encoder = gpu.device().create_command_encoder(&label);
        let mut at = 0;
        for array in [first, second] {
            for range in ranges {
                assert!(
                    range.end <= array.len(),
                    "{range:?} of {} elements of {}",
                    array.len(),
                    array.label()
                );
                let bytes = (range.len() * size) as u64;
                encoder.copy_buffer_to_buffer(
                    array.buffer(),
                    (range.start * size) as u64,
                    &staging,
                    at,
                    bytes,
                );
                at += bytes;
            }
        }
        let submission = gpu.submit(&running, encoder.finish())?;
        let mut pairs = vec![[T::zeroed(); 2]; count];
        InFlight::of(gpu, &running, staging, at, submission)?.receive(gpu, &running, &mut |bytes| {
            let elements = bytes.chunks_exact(size).map(bytemuck::pod_read_unaligned::<T>);
            elements.enumerate().for_each(|(at, element)| pairs[at % count][at / count] = element);
            Ok::<(), GpuError>(())
        })?;
        Ok(pairs)
    }

    fn stream<E: From<GpuError>>(
        &mut self,
        running: &str,
        source: &wgpu::Buffer,
        mut bytes: Range<u64>,
        take: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut in_flight = VecDeque::with_capacity(RING);
        loop {
            while in_flight.len() < RING && !bytes.is_empty() {
                let piece = (bytes.end - bytes.start).min(self.staging_bytes);
                in_flight.push_back(self.send(running, source, bytes.start, piece)?);
                bytes.start += piece;
            }
            let Some(next) = in_flight.pop_front() else {
                return Ok(());
            };
            self.free.push(next.receive(self.gpu, running, take)?);
        }
    }

    /// Starts the copy of one piece.
    fn send(
        &mut self,
        running: &str,
        source: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<InFlight, GpuError> {
        let gpu = self.gpu;
        let staging = match self.free.iter().position(|staging| staging.size() >= bytes) {
            Some(index) => self.free.swap_remove(index),
            None => make_staging(gpu, bytes.next_power_of_two().min(self.staging_bytes).max(bytes))?,
        };
        let label = wgpu::CommandEncoderDescriptor { label: Some("readback::copy") };
        let mut encoder = gpu.device().create_command_encoder(&label);
        encoder.copy_buffer_to_buffer(source, offset, &staging, 0, bytes);
        let submission = gpu.submit(running, encoder.finish())?;
        InFlight::of(gpu, running, staging, bytes, submission)
    }
}

impl InFlight {
    /// The first `bytes` of a staging buffer that a submission fills.
    pub(super) fn of(
        gpu: &Gpu,
        running: &str,
        staging: wgpu::Buffer,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
    ) -> Result<Self, GpuError> {
        let (sender, mapped) = mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            // The receiver is gone only when the read was given up.
            let _ = sender.send(result);
        });
        gpu.check(running)?;
        Ok(Self { staging, bytes, submission, mapped })
    }

    /// Waits for the piece and hands it over; returns its buffer, for the next one.
    pub(super) fn receive<E: From<GpuError>>(
        self,
        gpu: &Gpu,
        running: &str,
        take: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<wgpu::Buffer, E> {
        gpu.wait(running, Some(self.submission))?;
        let mapped = self.mapped.recv().map_err(|error| gpu.refused(running, error))?;
        mapped.map_err(|error| gpu.refused(running, error))?;
        {
            let view = self.staging.get_mapped_range(0..self.bytes);
            take(&view.map_err(|error| gpu.refused(running, error))?)?;
        }
        self.staging.unmap();
        Ok(self.staging)
    }
}

impl Gpu {
    /// All elements of an array; for small ones and for tests. [`Readback`] serves many and large.
    ///
    /// # Errors
    /// Those of the device.
    pub fn read_vec<T: Pod>(&self, array: &DeviceArray<T>) -> Result<Vec<T>, GpuError> {
        Readback::new(self).read_vec(array, 0..array.len())
    }
}

/// A buffer that copies are read from.
pub(super) fn make_staging(gpu: &Gpu, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
    let staging = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback::staging"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.check(&format!("allocating readback::staging ({bytes} bytes)"))?;
    Ok(staging)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::test_gpu;

    #[test]
    fn ranges_come_back_whole_and_in_order_whatever_the_piece() {
        let gpu = test_gpu();
        let data: Vec<u32> = (0..10_007_u32).map(|i| i.wrapping_mul(0x9E37_79B9)).collect();
        let array = gpu.array_of("test::data", &data).unwrap();
        for staging_bytes in [256, 1024, 40_028, 1 << 20] {
            let mut readback = Readback::with_staging_bytes(gpu, staging_bytes);
            for range in [0..10_007, 0..0, 5..6, 63..65, 100..9_999] {
                let read = readback.read_vec(&array, range.clone()).unwrap();
                assert_eq!(read, data[range.clone()], "{range:?} by {staging_bytes}");
            }
            assert!(readback.free.len() <= RING);
        }
    }

    #[test]
    fn an_error_of_the_taker_ends_the_read_and_the_ring_still_works() {
        let gpu = test_gpu();
        let data: Vec<u32> = (0..1000).collect();
        let array = gpu.array_of("test::data", &data).unwrap();
        let mut readback = Readback::with_staging_bytes(gpu, 256);
        let mut pieces = 0;
        let result = readback.read_chunks(&array, 0..1000, |_| {
            pieces += 1;
            if pieces == 2 { Err(GpuError::NoAdapter) } else { Ok(()) }
        });
        assert!(matches!(result, Err(GpuError::NoAdapter)));
        assert_eq!(pieces, 2);
        assert_eq!(readback.read_vec(&array, 0..1000).unwrap(), data);
    }

    #[test]
    fn uploads_beyond_one_piece_arrive() {
        let gpu = test_gpu();
        let data: Vec<u32> = (0..5_000_011).collect();
        let array = gpu.array_of("test::data", &data).unwrap();
        assert!(gpu.read_vec(&array).unwrap() == data);
    }
}
