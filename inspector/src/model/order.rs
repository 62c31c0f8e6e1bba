//! One order of a queue: where each ray stands in it, and by which key.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use formats::key::decode::{FieldReader, decode};
use formats::key::method::{AUTO, WITHOUT_LAYOUT};
use formats::key::{Coordinate, Extent, KEY_BITS_MIN, LAYOUT_BITS, Layout, LayoutText};
use formats::manifest::{MethodArray, MethodRecord, Place};
use formats::metrics::group::Group;
use formats::metrics::order::{Keys, Places};
use formats::reader::Dump;
use rayon::prelude::*;

use super::groups::{Groups, group, places_of};
use super::queue::Queue;
use crate::analysis::GroupWidth;

/// How a method's keys are made.
#[derive(Clone, Debug)]
pub struct KeyLayout {
    /// What each bit comes from.
    pub layout: Layout,
    /// Bits of a key.
    pub key_bits: u32,
    /// The layout as it was written.
    pub text: String,
}

impl KeyLayout {
    fn of(record: &MethodRecord, extent: Extent) -> Option<Self> {
        // A key may have more bits than its layout: the rest is 0.
        if !(KEY_BITS_MIN..=LAYOUT_BITS).contains(&record.key_bits) {
            return None;
        }
        let layout = LayoutText::parse(&record.text).and_then(|text| text.expand(extent)).ok()?;
        let is_recorded = layout.names() == record.layout;
        is_recorded.then(|| Self { layout, key_bits: record.key_bits, text: record.text.clone() })
    }
}

/// One order of a queue.
#[derive(Debug)]
pub struct Order {
    /// Of no other order of this run, also of none of the same name.
    pub serial: u64,
    /// The rays.
    pub queue: Arc<Queue>,
    /// The method, or `unsorted`.
    pub method: String,
    /// The ray at each place.
    pub places: Places,
    /// The key of each ray, and how it is made; or why there is none.
    pub keys: Result<(Keys, KeyLayout), String>,
    place_of_ray: OnceLock<Vec<u32>>,
    groups: [OnceLock<Groups>; 3],
}

impl Order {
    /// Maps an order of a queue.
    ///
    /// # Errors
    /// If its permutation was not kept or is none.
    pub fn open(dump: &Dump, queue: Arc<Queue>, method: &str) -> Result<Self, String> {
        let places = Places::open(dump, queue.id, method, queue.len())?;
        let keys = Place::Method(queue.id, method.to_owned(), MethodArray::Keys);
        let keys = self::keys(dump, &queue, method, &keys);
        Ok(Self::new(queue, method, places, keys))
    }

    /// The order by these keys, one for each ray: stable, as recorded ones are.
    ///
    /// # Panics
    /// If there are more or fewer keys than rays.
    pub fn of_keys(queue: Arc<Queue>, name: &str, keys: Vec<u64>, layout: KeyLayout) -> Self {
        assert_eq!(keys.len(), queue.len(), "a key for each ray");
        let mut permutation: Vec<u32> = (0..keys.len() as u32).collect();
        permutation.par_sort_by_key(|&ray| keys[ray as usize]);
        Self::new(queue, name, Places::Made(permutation), Ok((Keys::Made(keys), layout)))
    }

    fn new(queue: Arc<Queue>, method: &str, places: Places, keys: Result<(Keys, KeyLayout), String>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            serial: NEXT.fetch_add(1, Ordering::Relaxed),
            queue,
            method: method.to_owned(),
            places,
            keys,
            place_of_ray: OnceLock::new(),
            groups: Default::default(),
        }
    }

    /// How many rays.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether it has no rays.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The place of each ray: the inverse of the permutation.
    pub fn place_of_ray(&self) -> &[u32] {
        self.place_of_ray.get_or_init(|| {
            let mut inverse = vec![0; self.len()];
            for place in 0..self.len() {
                inverse[self.places.ray(place)] = place as u32;
            }
            inverse
        })
    }

    /// What reads a coordinate out of the keys; `None` if they do not hold it.
    pub fn field_reader(&self, coordinate: Coordinate) -> Option<FieldReader> {
        let (_, layout) = self.keys.as_ref().ok()?;
        FieldReader::new(&layout.layout, layout.key_bits, coordinate)
    }

    /// The coordinates that can be read out of the keys, in the layout's order, with what reads them.
    pub fn readable_fields(&self) -> Vec<(Coordinate, FieldReader)> {
        let Ok((_, layout)) = &self.keys else { return Vec::new() };
        let fields = decode(&layout.layout, layout.key_bits, 0);
        let coordinates = fields.iter().filter_map(|field| field.bit.coordinate());
        coordinates.filter_map(|coordinate| Some((coordinate, self.field_reader(coordinate)?))).collect()
    }

    /// The groups of this width; `None` until they are found.
    pub fn known_groups(&self, width: GroupWidth) -> Option<&Groups> {
        self.groups[width as usize].get()
    }

    /// The places of a group.
    pub fn places_of_group(&self, group: usize, width: GroupWidth) -> Range<usize> {
        places_of(group, width.rays(), self.len())
    }

    /// The group of a ray.
    ///
    /// # Panics
    /// If there is no such ray.
    pub fn group_of(&self, ray: usize, width: GroupWidth) -> usize {
        self.place_of_ray()[ray] as usize / width.rays()
    }

    /// One group by itself; `None` if there is none.
    pub fn group(&self, at: usize, width: GroupWidth) -> Option<Group> {
        group(&self.queue, &self.places, self.places_of_group(at, width))
    }

    /// The groups of this width: found when they are first asked for, which takes all threads a tenth of a
    /// second for millions of rays.
    ///
    /// The first one to ask must be none of rayon's threads: they would wait for each other.
    pub fn groups(&self, width: GroupWidth) -> &Groups {
        self.groups[width as usize].get_or_init(|| {
            debug_assert!(rayon::current_thread_index().is_none(), "groups are found before values are");
            Groups::of(&self.queue, &self.places, width.rays())
        })
    }
}

fn keys(dump: &Dump, queue: &Queue, method: &str, place: &Place) -> Result<(Keys, KeyLayout), String> {
    let mut decisions = dump.manifest().decisions.iter();
    if method == AUTO
        && let Some(decision) = decisions.find(|one| one.queue == queue.id)
    {
        return Err(format!("{AUTO} has no key of its own: it gave these rays {}", decision.chosen()));
    }
    if WITHOUT_LAYOUT.contains(&method) {
        return Err(format!("{method} rays have no key of their own"));
    }
    let record = dump.manifest().methods.iter().find(|record| record.name == method);
    let record = record.ok_or_else(|| format!("the manifest says nothing of {method}"))?;
    if !record.has_layout() {
        return Err(format!("nobody says what the keys of {method} are"));
    }
    let extent = dump.manifest().header.extent();
    let layout =
        KeyLayout::of(record, extent).ok_or_else(|| format!("{method} has no layout of at most {LAYOUT_BITS} bits and keys of {KEY_BITS_MIN} to {LAYOUT_BITS}: {}", record.text))?;
    let keys = if layout.key_bits > 32 {
        dump.array(place).map(Keys::Wide)
    } else {
        dump.array(place).map(Keys::Narrow)
    };
    let keys = keys.map_err(|error| error.to_string())?;
    if keys.len() != queue.len() {
        return Err(format!("{place} has {} keys for {} rays", keys.len(), queue.len()));
    }
    Ok((keys, layout))
}
