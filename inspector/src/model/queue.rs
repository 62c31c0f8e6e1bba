//! The rays of a queue with all that the recording keeps of them, in canonical order.

use std::sync::OnceLock;

use formats::length_table::{LengthCell, TABLE_BITS_MAX, TABLE_BITS_MIN};
use formats::manifest::{Place, QueueArray, QueueId, SceneArray};
use formats::metrics::capsule::Segment;
use formats::queue_check::{QueueFault, QueueRays, QueueRules};
use formats::ray::{Kind, Work};
use formats::reader::{Dump, Loaded};
use formats::stored_table::{StoredTable, StoredTableError};
use formats::traced::Traced;
use rayon::prelude::*;

use crate::analysis::work::work;

/// The rays of a queue, mapped.
#[derive(Debug)]
pub struct Queue {
    /// Which queue.
    pub id: QueueId,
    /// The rays and what came of them.
    pub traced: Traced,
    /// Traced length of each ray, unit lengths.
    pub lengths: Vec<f32>,
    /// Pixel of each ray, ascending.
    pub path_ids: Loaded<u32>,
    /// Index of each shadow ray's light.
    pub lights: Option<Loaded<u32>>,
    /// The material of each triangle of the scene, or why it is not known.
    pub materials: Result<Loaded<u32>, String>,
    /// Nodes visited and triangles tested, or why they are not known.
    pub work: Result<Loaded<Work>, String>,
    /// Touched cells of the length table that the methods read, or why they are not known.
    pub cells: Result<Loaded<LengthCell>, String>,
    /// The same as a table that rays find their cell in.
    pub table: Result<StoredTable, String>,
    starts_in_one_place: OnceLock<bool>,
}

impl Queue {
    /// Maps the arrays of a queue.
    ///
    /// # Errors
    /// If its rays, their paths or what came of them were not kept, or do not belong together.
    pub fn open(dump: &Dump, id: QueueId) -> Result<Self, String> {
        let text = |error: formats::reader::ReadError| error.to_string();
        let place = |array| Place::Queue(id, array);
        let traced = Traced::open(dump, id).map_err(|error| error.to_string())?;
        let rays = traced.rays().len();
        let path_ids: Loaded<u32> = dump.array(&place(QueueArray::PathIds)).map_err(text)?;
        let lights = match id.kind {
            Kind::Closest => None,
            Kind::Shadow => Some(dump.array::<u32>(&place(QueueArray::Lights)).map_err(text)?),
        };
        let rules = QueueRules::new(id, &dump.manifest().header);
        let wrong = |fault: QueueFault| format!("{fault}; `inspector verify` says what is wrong");
        let arrays = QueueRays {
            rays: traced.rays(),
            path_ids: &path_ids,
            lights: lights.as_deref().unwrap_or_default(),
        };
        rules.check(arrays, rays as u64).map_err(wrong)?;
        let work = work(dump, id).and_then(|work| {
            let found = rules.check_count(QueueArray::Work, work.len() as u64, rays as u64);
            found.map(|()| work).map_err(wrong)
        });
        Ok(Self {
            id,
            lengths: traced.lengths(),
            path_ids,
            lights,
            materials: dump.array(&Place::Scene(SceneArray::Materials)).map_err(text),
            work,
            cells: cells(dump, &place(QueueArray::Lengths)),
            table: StoredTable::open(dump, id).map_err(|error| error.to_string()),
            starts_in_one_place: OnceLock::new(),
            traced,
        })
    }

    /// How many rays.
    pub fn len(&self) -> usize {
        self.lengths.len()
    }

    /// Whether it has no rays.
    pub fn is_empty(&self) -> bool {
        self.lengths.is_empty()
    }

    /// Whether all rays start in one place, as those of a pinhole camera do.
    pub fn starts_in_one_place(&self) -> bool {
        *self.starts_in_one_place.get_or_init(|| {
            let rays = self.traced.rays();
            rays.iter().all(|ray| ray.origin == rays[0].origin)
        })
    }

    /// A ray from its origin to where it ended, unit space.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn segment(&self, ray: usize) -> Segment {
        Segment::of(self.traced.unit(), &self.traced.rays()[ray], self.lengths[ray])
    }

    /// Whether a ray ended at a surface.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn is_at_surface(&self, ray: usize) -> bool {
        self.traced.is_at_surface(ray)
    }

    /// The ray of a pixel, if its path is still alive.
    pub fn ray_of_pixel(&self, pixel: u32) -> Option<usize> {
        self.path_ids.binary_search(&pixel).ok()
    }
}

/// Touched cells, all of which a table of as many address bits as the header says has.
fn cells(dump: &Dump, place: &Place) -> Result<Loaded<LengthCell>, String> {
    let bits = dump.manifest().header.options.table_bits;
    if !(TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&bits) {
        return Err(StoredTableError::Bits { bits }.to_string());
    }
    let cells: Loaded<LengthCell> = dump.array(place).map_err(|error| error.to_string())?;
    match cells.par_iter().find_first(|cell| cell.cell >> bits != 0) {
        None => Ok(cells),
        Some(LengthCell { cell, .. }) => Err(format!(
            "{place} has cell {cell} of a table of 2^{bits}; `inspector verify` says what is wrong"
        )),
    }
}
