//! A stored length table and how rays find their cell in it.

use crate::key::termination::bounded_length;
use crate::key::{Encoder, Facts};
use crate::length_table::{LengthCell, LengthTable, LengthTableError, TABLE_BITS_MAX, TABLE_BITS_MIN};
use crate::manifest::{Header, Place, QueueArray, QueueId};
use crate::ray::Ray;
use crate::reader::{Dump, Loaded, ReadError};
use crate::text::shown;
use crate::unit_space::UnitSpace;

/// Why a queue has no usable length table.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum StoredTableError {
    /// It was not kept or cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("{bits} address bits, expected {TABLE_BITS_MIN} to {TABLE_BITS_MAX}")]
    Bits { bits: u32 },
    #[error("'{}' is no layout by which a ray finds its cell in the length table", shown(layout))]
    Layout { layout: String },
    #[error(transparent)]
    Table(#[from] LengthTableError),
}

/// The length table of stored cells.
///
/// # Errors
/// If they are none.
pub fn from_cells(header: &Header, cells: &[LengthCell]) -> Result<LengthTable, StoredTableError> {
    let bits = header.options.table_bits;
    if !(TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&bits) {
        return Err(StoredTableError::Bits { bits });
    }
    Ok(LengthTable::from_touched(bits, cells)?)
}

/// The length table that the methods of a queue read.
#[derive(Debug)]
pub struct StoredTable {
    encoder: Encoder,
    table: LengthTable,
    touched: usize,
}

impl StoredTable {
    /// Reads the table of a queue. Memory: 16 bytes a cell, touched or not.
    ///
    /// # Errors
    /// If it was not kept, cannot be read, or is damaged.
    pub fn open(dump: &Dump, queue: QueueId) -> Result<Self, StoredTableError> {
        let header = &dump.manifest().header;
        let cells: Loaded<LengthCell> = dump.array(&Place::Queue(queue, QueueArray::Lengths))?;
        let table = from_cells(header, &cells)?;
        let layout = || StoredTableError::Layout { layout: header.options.table_layout.clone() };
        Ok(Self { encoder: header.cell_encoder().ok_or_else(layout)?, table, touched: cells.len() })
    }

    /// What two-point-adaptive takes a ray's length for, unit lengths: the mean of its cell, cut by the ray's own end
    /// and by the scene's box.
    pub fn estimate(&self, unit: &UnitSpace, ray: &Ray) -> f32 {
        bounded_length(unit, ray, unit.point(ray.origin), self.mean(ray))
    }

    /// Mean length of a ray's cell, unit lengths.
    pub fn mean(&self, ray: &Ray) -> f32 {
        self.table.mean(self.encoder.encode(ray, Facts::default()) as u32)
    }

    /// Cells that a ray was added to.
    pub fn touched(&self) -> u64 {
        self.touched as u64
    }

    /// All cells.
    pub fn cells(&self) -> u64 {
        1 << self.table.bits()
    }
}
