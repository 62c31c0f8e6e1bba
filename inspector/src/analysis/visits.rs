//! The boxes of the hierarchy that a ray and its group enter.

use std::collections::HashMap;

use formats::hierarchy::{Hierarchy, Visit};
use formats::ray::Kind;
use formats::traced::Traced;
use rayon::prelude::*;

/// A box that rays enter.
#[derive(Clone, Debug, PartialEq)]
pub struct EnteredBox {
    /// Its lowest and highest corner, unit space.
    pub corners: ([f32; 3], [f32; 3]),
    /// How far below the root, which has 0.
    pub level: u32,
    /// How many rays of the group enter it.
    pub rays: u32,
    /// Whether the ray itself does.
    pub is_of_ray: bool,
}

/// The boxes that a group enters.
#[derive(Clone, Debug, PartialEq)]
pub struct Visits {
    /// By level, then as the first ray of the group that enters them comes to them.
    pub boxes: Vec<EnteredBox>,
}

impl Visits {
    /// Of the rays of a group, canonical indices, of which one is looked at.
    pub fn of(hierarchy: &Hierarchy, traced: &Traced, kind: Kind, group: &[usize], ray: usize) -> Self {
        let traversal = |&of: &usize| (of == ray, hierarchy.traversal(&traced.rays()[of], kind));
        let traversals: Vec<_> = group.par_iter().map(traversal).collect();
        let mut boxes: Vec<EnteredBox> = Vec::new();
        let mut known = HashMap::new();
        for (is_of_ray, traversal) in &traversals {
            for &Visit { place, level, .. } in &traversal.visits {
                let at = *known.entry(place).or_insert_with(|| {
                    let corners = hierarchy.bounds(place).map(|corner| traced.unit().point(corner)).into();
                    boxes.push(EnteredBox { corners, level, rays: 0, is_of_ray: false });
                    boxes.len() - 1
                });
                boxes[at].rays += 1;
                boxes[at].is_of_ray |= is_of_ray;
            }
        }
        boxes.sort_by_key(|entered| entered.level);
        Self { boxes }
    }

    /// How many boxes one ray of the group alone enters; and how many the group enters.
    pub fn private(&self) -> (usize, usize) {
        (self.boxes.iter().filter(|entered| entered.rays == 1).count(), self.boxes.len())
    }

    /// Of the boxes that the ray enters, how many others of its group enter, too; and how many there are.
    pub fn shared(&self) -> (usize, usize) {
        let of_ray = || self.boxes.iter().filter(|entered| entered.is_of_ray);
        (of_ray().filter(|entered| entered.rays > 1).count(), of_ray().count())
    }
}
