//! A length table on the GPU: three arrays of words.

use formats::length_table::{DUMMY_SUM, LengthCell, LengthTable};

use super::{DeviceArray, Gpu, GpuError};

/// Sums as low and high words, and counts.
pub(super) struct GpuTable {
    pub(super) sums_low: DeviceArray<u32>,
    pub(super) sums_high: DeviceArray<u32>,
    pub(super) counts: DeviceArray<u32>,
}

impl GpuTable {
    /// 2^`bits` cells, each with its dummy ray.
    pub(super) fn new(gpu: &Gpu, bits: u32) -> Result<Self, GpuError> {
        let cells = 1usize << bits;
        Ok(Self {
            sums_low: gpu.array_of("length_table::sums_low", &vec![DUMMY_SUM as u32; cells])?,
            sums_high: gpu.array("length_table::sums_high", cells)?,
            counts: gpu.array_of("length_table::counts", &vec![1u32; cells])?,
        })
    }

    /// A copy of a table.
    pub(super) fn filled(gpu: &Gpu, table: &LengthTable) -> Result<Self, GpuError> {
        let (sums, counts): (Vec<u64>, Vec<u32>) = table.cells().unzip();
        let low: Vec<u32> = sums.iter().map(|&sum| sum as u32).collect();
        let high: Vec<u32> = sums.iter().map(|&sum| (sum >> 32) as u32).collect();
        Ok(Self {
            sums_low: gpu.array_of("length_table::sums_low", &low)?,
            sums_high: gpu.array_of("length_table::sums_high", &high)?,
            counts: gpu.array_of("length_table::counts", &counts)?,
        })
    }

    /// The cells with a count of 2 or more, ascending.
    pub(super) fn touched(&self, gpu: &Gpu) -> Result<Vec<LengthCell>, GpuError> {
        let (low, high, counts) =
            (gpu.read_vec(&self.sums_low)?, gpu.read_vec(&self.sums_high)?, gpu.read_vec(&self.counts)?);
        let cells = (0u32..).zip(&counts).zip(low.iter().zip(&high));
        Ok(cells
            .filter(|((_, count), _)| **count >= 2)
            .map(|((cell, &count), (&low, &high))| LengthCell {
                cell,
                count,
                sum: u64::from(high) << 32 | u64::from(low),
            })
            .collect())
    }
}
