//! Lane utilisation: a model of control-flow divergence that holds on any GPU.

use crate::ray::Work;

/// The widths that are modelled: lavapipe and CPUs, most GPUs, some of AMD's.
pub const WIDTHS: [usize; 3] = [8, 32, 64];

/// Work done and lane time taken by groups of `width` lanes that wait for their slowest. A model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneUse {
    /// Lanes of a group.
    pub width: usize,
    /// Work of all rays: nodes visited and triangles tested.
    pub work: u64,
    /// The same if every lane of a group took as long as its slowest one.
    pub capacity: u64,
}

impl LaneUse {
    /// Of no group yet.
    pub fn new(width: usize) -> Self {
        Self { width, work: 0, capacity: 0 }
    }

    /// Adds consecutive rays of an order, in groups from the first on; the last group may be shorter,
    /// and its missing lanes are idle.
    pub fn add(&mut self, works: &[u64]) {
        for group in works.chunks(self.width) {
            self.work += group.iter().sum::<u64>();
            self.capacity += self.width as u64 * group.iter().max().copied().unwrap_or(0);
        }
    }

    /// Adds what was counted elsewhere with the same width.
    pub fn merge(&mut self, other: &Self) {
        self.work += other.work;
        self.capacity += other.capacity;
    }

    /// `Σ work / (W · Σ_groups max work)`, in (0, 1]; `None` if no work was done.
    pub fn utilisation(&self) -> Option<f64> {
        (self.capacity > 0).then(|| self.work as f64 / self.capacity as f64)
    }
}

/// A ray's work: nodes visited + triangles tested.
pub fn work_of(work: &Work) -> u64 {
    u64::from(work.nodes) + u64::from(work.triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utilisation(width: usize, works: &[u64]) -> Option<f64> {
        let mut lanes = LaneUse::new(width);
        lanes.add(works);
        lanes.utilisation()
    }

    #[test]
    fn closed_forms() {
        assert_eq!(utilisation(8, &[]), None);
        assert_eq!(utilisation(8, &[0; 8]), None);
        assert_eq!(utilisation(8, &[7; 32]), Some(1.0));
        assert_eq!(utilisation(8, &[8, 0, 0, 0, 0, 0, 0, 0]), Some(0.125));
        assert_eq!(utilisation(8, &[3; 12]), Some(12.0 / 16.0));
        assert_eq!(work_of(&Work { nodes: 3, triangles: 4 }), 7);
    }

    #[test]
    fn parts_that_are_whole_groups_add_up() {
        let works: Vec<u64> = (0..1000).map(|i| i * i % 101).collect();
        for width in WIDTHS {
            let mut parts = LaneUse::new(width);
            for chunk in works.chunks(width * 3) {
                let mut part = LaneUse::new(width);
                part.add(chunk);
                parts.merge(&part);
            }
            assert_eq!(parts.utilisation(), utilisation(width, &works));
        }
    }
}
