//! Typed arrays in GPU memory, checked against the adapter's limits before they are made.

use std::marker::PhantomData;

use bytemuck::Pod;

use super::{Gpu, GpuError};

/// Bytes that one upload hands to wgpu before it submits, so that its staging memory stays small.
const UPLOAD_BYTES: usize = 16 << 20;

/// An array of `T` in GPU memory that kernels read and write as a storage buffer.
#[derive(Clone, Debug)]
pub struct DeviceArray<T> {
    buffer: wgpu::Buffer,
    len: usize,
    label: String,
    element: PhantomData<T>,
}

impl<T> DeviceArray<T> {
    /// How many elements there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none. wgpu binds nothing empty, so the buffer itself has room for one.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// `stage::array`.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// wgpu's buffer.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The whole array, to be bound.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        self.buffer.as_entire_binding()
    }
}

impl Gpu {
    /// An array of `len` zeros. The label reads `stage::array`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] before anything is allocated, [`GpuError::OutOfMemory`] after.
    pub fn array<T: Pod>(&self, label: &str, len: usize) -> Result<DeviceArray<T>, GpuError> {
        const { assert!(size_of::<T>().is_multiple_of(4), "wgpu copies and binds in words of four bytes") };
        let bytes = (len.max(1) as u64).saturating_mul(size_of::<T>() as u64);
        let limits = &self.adapter().limits;
        let allowed = [
            ("largest buffer", limits.buffer_bytes),
            ("largest storage binding", limits.storage_binding_bytes),
        ];
        if let Some((limit, limit_bytes)) = allowed.into_iter().find(|&(_, limit)| bytes > limit) {
            return Err(GpuError::TooLarge {
                label: label.to_owned(),
                bytes,
                limit,
                limit_bytes,
                adapter: self.adapter().title(),
            });
        }
        let buffer = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST
                | self.acceleration_structure_input(),
            mapped_at_creation: false,
        });
        self.check(&format!("allocating {label} ({bytes} bytes)"))?;
        Ok(DeviceArray { buffer, len, label: label.to_owned(), element: PhantomData })
    }

    /// An array with these elements.
    ///
    /// # Errors
    /// As [`Gpu::array`].
    pub fn array_of<T: Pod>(&self, label: &str, data: &[T]) -> Result<DeviceArray<T>, GpuError> {
        let array = self.array(label, data.len())?;
        self.write(&array, data)?;
        Ok(array)
    }

    /// Overwrites the beginning of an array.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    ///
    /// # Panics
    /// If there are more data than the array has elements.
    pub fn write<T: Pod>(&self, array: &DeviceArray<T>, data: &[T]) -> Result<(), GpuError> {
        assert!(data.len() <= array.len(), "{} elements into {}", data.len(), array.label());
        let running = format!("uploading {}", array.label());
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mut offset = 0;
        for piece in bytes.chunks(UPLOAD_BYTES) {
            self.queue().write_buffer(array.buffer(), offset, piece);
            offset += piece.len() as u64;
            if offset < bytes.len() as u64 {
                let sent = self.queue().submit([]);
                self.wait(&running, Some(sent))?;
            }
        }
        self.check(&running)
    }

    /// Vertices and indices of the driver's own acceleration structure are plain arrays too.
    fn acceleration_structure_input(&self) -> wgpu::BufferUsages {
        if self.has(wgpu::Features::EXPERIMENTAL_RAY_QUERY) {
            wgpu::BufferUsages::BLAS_INPUT
        } else {
            wgpu::BufferUsages::empty()
        }
    }
}
