//! The one selection that all panels share, with the two orders that are held against each other.

use std::collections::BTreeSet;
use std::ops::Range;

use formats::key::method::UNSORTED;
use formats::manifest::QueueId;
use formats::ray::Kind;

use super::order::Order;
use crate::analysis::GroupWidth;
use crate::filter::Filter;

/// Order A: what order B is held against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Baseline {
    /// Which of the open recordings it is of; that of B if `None`.
    pub recording: Option<usize>,
    /// A method, or `unsorted`.
    pub method: String,
}

/// How far along the order all panels are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playhead {
    /// Where in the order the rays shown end, 0 to 1.
    pub until: f32,
    /// How much of the order before that is shown, 0 to 1.
    pub window: f32,
}

impl Default for Playhead {
    fn default() -> Self {
        Self { until: 1.0, window: 1.0 }
    }
}

impl Playhead {
    /// The places of an order of so many rays that it leaves, whatever a session says.
    pub fn places(self, rays: usize) -> Range<usize> {
        let [until, window] = [self.until, self.window].map(|part| f64::from(part.clamp(0.0, 1.0)));
        let until = (until * rays as f64).round();
        let from = (until - window * rays as f64).max(0.0).round();
        from as usize..until as usize
    }

    /// The place that it is at; `None` where it leaves the whole order.
    pub fn place(self, rays: usize) -> Option<usize> {
        let is_within = self.until < 1.0 || self.window < 1.0;
        self.places(rays).end.checked_sub(1).filter(|_| is_within)
    }
}

/// What is selected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Which of the open recordings.
    pub recording: usize,
    /// Pass, bounce and kind.
    pub queue: QueueId,
    /// Order B, which panels show: a method, or `unsorted`.
    pub method: String,
    /// What B was where the queue was measured by it: it is B again where one is.
    pub wanted: Option<String>,
    /// Order A.
    pub baseline: Baseline,
    /// Rays of a group.
    pub group_width: GroupWidth,
    /// A ray of the queue, by its canonical index: the last one if there are several.
    pub ray: Option<usize>,
    /// Rays that are selected, too, the latest first.
    pub others: Vec<usize>,
    /// A group of the order, from 0.
    pub group: Option<usize>,
    /// A cell of the length table.
    pub cell: Option<u32>,
    /// Which rays are shown.
    pub filter: Filter,
}

impl Default for Selection {
    fn default() -> Self {
        Self {
            recording: 0,
            queue: QueueId { pass: 0, bounce: 0, kind: Kind::Closest },
            method: UNSORTED.to_owned(),
            wanted: None,
            baseline: Baseline { recording: None, method: UNSORTED.to_owned() },
            group_width: GroupWidth::default(),
            ray: None,
            others: Vec::new(),
            group: None,
            cell: None,
            filter: Filter::default(),
        }
    }
}

impl Selection {
    /// Another queue; rays of the old one mean nothing there.
    pub fn go_to(&mut self, queue: QueueId) {
        if self.queue != queue {
            self.queue = queue;
            self.select(Vec::new());
        }
    }

    /// All rays, the latest first.
    pub fn rays(&self) -> Vec<usize> {
        self.ray.into_iter().chain(self.others.iter().copied()).collect()
    }

    /// The groups of all rays in an order, and the one that is selected itself.
    pub fn groups(&self, order: &Order) -> BTreeSet<usize> {
        let place_of_ray = order.place_of_ray();
        let places = self.others.iter().filter_map(|&ray| place_of_ray.get(ray));
        places.map(|&place| place as usize / self.group_width.rays()).chain(self.group).collect()
    }

    /// These rays, the latest first.
    pub fn select(&mut self, rays: Vec<usize>) {
        let mut rays = rays.into_iter();
        (self.ray, self.group) = (rays.next(), None);
        self.others = rays.collect();
    }

    /// Another order of the same rays: the ray stays, the group is another.
    pub fn order_by(&mut self, method: &str) {
        self.wanted = None;
        if self.method != method {
            method.clone_into(&mut self.method);
            self.group = None;
        }
    }

    /// Nothing within the queue.
    pub fn clear(&mut self) {
        self.select(Vec::new());
        self.cell = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_playhead_beyond_the_order_is_within_it() {
        for (until, window) in [(5.0, 0.5), (1.0, -1.0), (-3.0, 2.0), (f32::NAN, f32::NAN)] {
            let places = Playhead { until, window }.places(100);
            assert!(places.start <= places.end && places.end <= 100, "{until}, {window}: {places:?}");
        }
        assert_eq!(Playhead { until: 0.5, window: 0.25 }.places(100), 25..50);
    }

    #[test]
    fn rays_outlive_their_order_but_not_their_queue() {
        let mut selection = Selection { ray: Some(7), group: Some(2), cell: Some(5), ..Selection::default() };
        selection.order_by("aila");
        assert_eq!((selection.ray, selection.group), (Some(7), None));
        selection.go_to(QueueId { bounce: 1, ..selection.queue });
        assert_eq!((selection.ray, selection.cell), (None, Some(5)));
    }
}
