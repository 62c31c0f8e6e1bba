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
/// memory stays at three pieces of at most 16 MiB, for any size of the array. It is kept for the next array, since
/// drivers take milliseconds to make what a processor reads.
#[derive(Debug)]
pub struct Readback {
    staging_bytes: u64,
    free: Vec<wgpu::Buffer>,
}

/// A stretch of memory on the GPU.
struct Part<'a> {
    buffer: &'a wgpu::Buffer,
    offset: u64,
    bytes: u64,
}

/// A piece on its way.
pub(super) struct InFlight {
    staging: wgpu::Buffer,
    bytes: u64,
    submission: wgpu::SubmissionIndex,
    mapped: mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Default for Readback {
    /// A ring whose buffers are made when they are first needed.
    fn default() -> Self {
        Self::with_staging_bytes(STAGING_BYTES)
    }
}

impl Readback {
    /// A ring with smaller pieces; a positive multiple of 256 bytes.
    fn with_staging_bytes(staging_bytes: u64) -> Self {
        Self { staging_bytes, free: Vec::new() }
    }

    /// Hands the bytes of the elements in `range` to `take`, in order and in pieces; all but the
    /// last piece have the same length, a multiple of the element size if that is a power of two.
    ///
    /// # Errors
    /// Those of the device, and the first that `take` returns; nothing is handed over after it.
    ///
    /// # Panics
    /// If the range is not inside the array.
    pub fn read_chunks<T: Pod, E: From<GpuError>>(
        &mut self,
        gpu: &Gpu,
        array: &DeviceArray<T>,
        range: Range<usize>,
        mut take: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let Part { buffer, offset, bytes } = part(array, range);
        let starts = (0..bytes).step_by(self.staging_bytes as usize);
        let most = self.staging_bytes;
        let pieces =
            starts.map(|start| [Part { buffer, offset: offset + start, bytes: (bytes - start).min(most) }]);
        self.stream(gpu, &format!("reading {}", array.label()), pieces, &mut take)
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
        gpu: &Gpu,
        array: &DeviceArray<T>,
        range: Range<usize>,
    ) -> Result<Vec<T>, GpuError> {
        let mut elements = vec![T::zeroed(); range.len()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut elements);
        let mut offset = 0;
        self.read_chunks(gpu, array, range, |piece| {
            bytes[offset..offset + piece.len()].copy_from_slice(piece);
            offset += piece.len();
            Ok::<(), GpuError>(())
        })?;
        Ok(elements)
    }

    /// Hands over elements of two arrays side by side: in each piece those of several ranges, in order.
    ///
    /// # Errors
    /// As [`Readback::read_chunks`].
    ///
    /// # Panics
    /// As [`Readback::read_chunks`].
    pub fn read_pairs<T: Pod, E: From<GpuError>>(
        &mut self,
        gpu: &Gpu,
        arrays: [&DeviceArray<T>; 2],
        pieces: impl Iterator<Item: IntoIterator<Item = Range<usize>> + Clone>,
        mut take: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let pieces = pieces.map(|ranges| {
            let of_one = |array| ranges.clone().into_iter().map(move |range| part(array, range));
            arrays.into_iter().flat_map(of_one).collect::<Vec<_>>()
        });
        let mut pairs = Vec::new();
        self.stream(gpu, &format!("reading {}", arrays[0].label()), pieces, &mut |bytes| {
            let (first, second) = bytes.split_at(bytes.len() / 2);
            let halves = first.chunks_exact(size_of::<T>()).zip(second.chunks_exact(size_of::<T>()));
            pairs.resize(bytes.len(), 0);
            for (pair, (first, second)) in pairs.chunks_exact_mut(2 * size_of::<T>()).zip(halves) {
                pair[..size_of::<T>()].copy_from_slice(first);
                pair[size_of::<T>()..].copy_from_slice(second);
            }
            take(&pairs)
        })
    }

    /// Hands over pieces in order, each the bytes of its parts after each other.
    fn stream<'a, P: AsRef<[Part<'a>]>, E: From<GpuError>>(
        &mut self,
        gpu: &Gpu,
        running: &str,
        pieces: impl Iterator<Item = P>,
        take: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        // Nothing can be mapped of no bytes.
        let mut pieces = pieces.filter(|piece| piece.as_ref().iter().any(|part| part.bytes > 0));
        let mut in_flight = VecDeque::with_capacity(RING);
        loop {
            while in_flight.len() < RING
                && let Some(piece) = pieces.next()
            {
                in_flight.push_back(self.send(gpu, running, piece.as_ref())?);
            }
            let Some(next) = in_flight.pop_front() else {
                return Ok(());
            };
            self.free.push(next.receive(gpu, running, take)?);
        }
    }

    /// Starts the copy of one piece.
    fn send(&mut self, gpu: &Gpu, running: &str, parts: &[Part<'_>]) -> Result<InFlight, GpuError> {
        let bytes = parts.iter().map(|part| part.bytes).sum();
        let staging = match self.free.iter().position(|staging| staging.size() >= bytes) {
            Some(index) => self.free.swap_remove(index),
            None => {
                // In the place of a smaller one, so that there are never more than the ring has.
                self.free.pop();
                make_staging(gpu, bytes.next_power_of_two().min(self.staging_bytes).max(bytes))?
            }
        };
        let label = wgpu::CommandEncoderDescriptor { label: Some("readback::copy") };
        let mut encoder = gpu.device().create_command_encoder(&label);
        let mut at = 0;
        for part in parts {
            encoder.copy_buffer_to_buffer(part.buffer, part.offset, &staging, at, part.bytes);
            at += part.bytes;
        }
        let submission = gpu.submit(running, encoder.finish())?;
        InFlight::of(gpu, running, staging, bytes, submission)
    }
}

/// Where elements of an array lie.
fn part<T: Pod>(array: &DeviceArray<T>, range: Range<usize>) -> Part<'_> {
    assert!(
        range.start <= range.end && range.end <= array.len(),
        "{range:?} of {} elements of {}",
        array.len(),
        array.label()
    );
    let size = size_of::<T>() as u64;
    Part { buffer: array.buffer(), offset: range.start as u64 * size, bytes: range.len() as u64 * size }
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
        Readback::default().read_vec(self, array, 0..array.len())
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
            let mut readback = Readback::with_staging_bytes(staging_bytes);
            for range in [0..10_007, 0..0, 5..6, 63..65, 100..9_999] {
                let read = readback.read_vec(gpu, &array, range.clone()).unwrap();
                assert_eq!(read, data[range.clone()], "{range:?} by {staging_bytes}");
            }
            assert!(readback.free.len() <= RING);
        }
    }

    #[test]
    fn elements_of_two_arrays_come_back_side_by_side() {
        let gpu = test_gpu();
        let halves = [0_u64, 1 << 40].map(|side| (0..10_007).map(|i| side + i).collect::<Vec<u64>>());
        let arrays = halves.each_ref().map(|half| gpu.array_of("test::half", half).unwrap());
        let mut readback = Readback::with_staging_bytes(1024);
        let pieces = [vec![0..3, 9_000..10_007], vec![], vec![5..5, 9..9], vec![7..8, 2..3, 2..3]];
        for repeats in [1, RING + 1] {
            let (mut read, mut expected) = (Vec::new(), Vec::new());
            let wanted = pieces.iter().cycle().take(pieces.len() * repeats).cloned();
            for at in wanted.clone().flatten().flatten() {
                expected.extend(halves.each_ref().map(|half| half[at]));
            }
            let take = |bytes: &[u8]| {
                read.extend(bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned::<u64>));
                Ok::<(), GpuError>(())
            };
            readback.read_pairs(gpu, arrays.each_ref(), wanted, take).unwrap();
            assert_eq!(read, expected);
            assert!(readback.free.len() <= RING, "{}", readback.free.len());
        }
    }

    #[test]
    fn an_error_of_the_taker_ends_the_read_and_the_ring_still_works() {
        let gpu = test_gpu();
        let data: Vec<u32> = (0..1000).collect();
        let array = gpu.array_of("test::data", &data).unwrap();
        let mut readback = Readback::with_staging_bytes(256);
        let mut pieces = 0;
        let result = readback.read_chunks(gpu, &array, 0..1000, |_| {
            pieces += 1;
            if pieces == 2 { Err(GpuError::NoAdapter) } else { Ok(()) }
        });
        assert!(matches!(result, Err(GpuError::NoAdapter)));
        assert_eq!(pieces, 2);
        assert_eq!(readback.read_vec(gpu, &array, 0..1000).unwrap(), data);
    }

    #[test]
    fn uploads_beyond_one_piece_arrive() {
        let gpu = test_gpu();
        let data: Vec<u32> = (0..5_000_011).collect();
        let array = gpu.array_of("test::data", &data).unwrap();
        assert!(gpu.read_vec(&array).unwrap() == data);
    }
}
