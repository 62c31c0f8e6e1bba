//! A length table on the GPU: sums and counts.

use formats::length_table::{LengthCell, LengthTable};

use crate::device::{DeviceArray, Gpu, GpuError, StageRun};

/// Sums, low word first, and counts.
pub(super) struct GpuTable {
    sums: DeviceArray<[u32; 2]>,
    counts: DeviceArray<u32>,
}

impl GpuTable {
    /// 2^`bits` cells, each with its dummy ray.
    pub(super) fn new(gpu: &Gpu, bits: u32) -> Result<Self, GpuError> {
        Self::filled(gpu, &LengthTable::new(bits))
    }

    /// Takes the cells of another table of as many.
    pub(super) fn copy(&self, run: &mut StageRun<'_>, from: &Self) {
        run.copy(&from.sums, &self.sums, from.sums.len());
        run.copy(&from.counts, &self.counts, from.counts.len());
    }

    /// Sums and counts, to be bound.
    pub(super) fn bindings(&self) -> [wgpu::BindingResource<'_>; 2] {
        [self.sums.binding(), self.counts.binding()]
    }

    /// A copy of a table.
    pub(super) fn filled(gpu: &Gpu, table: &LengthTable) -> Result<Self, GpuError> {
        let (sums, counts): (Vec<u64>, Vec<u32>) = table.cells().unzip();
        let sums: Vec<[u32; 2]> = sums.into_iter().map(|sum| [sum as u32, (sum >> 32) as u32]).collect();
        Ok(Self {
            sums: gpu.array_of("length_table::sums", &sums)?,
            counts: gpu.array_of("length_table::counts", &counts)?,
        })
    }

    /// The cells with a count of 2 or more, ascending.
    pub(super) fn touched(&self, gpu: &Gpu) -> Result<Vec<LengthCell>, GpuError> {
        let (sums, counts) = (gpu.read_vec(&self.sums)?, gpu.read_vec(&self.counts)?);
        let cells = (0u32..).zip(&counts).zip(&sums);
        Ok(cells
            .filter(|((_, count), _)| **count >= 2)
            .map(|((cell, &count), &[low, high])| LengthCell {
                cell,
                count,
                sum: u64::from(high) << 32 | u64::from(low),
            })
            .collect())
    }
}
