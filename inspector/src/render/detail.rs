//! Stratified level of detail: so many of an order's places, spread evenly along it.

use std::ops::Range;

/// At most `wanted` places of a range, one from the middle of each of as many equal parts, ascending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    first: usize,
    all: usize,
    shown: usize,
}

impl Detail {
    /// Of a range of places.
    pub fn of(places: &Range<usize>, wanted: usize) -> Self {
        let all = places.len();
        Self { first: places.start, all, shown: all.min(wanted) }
    }

    /// The place in the middle of a part.
    fn place(self, part: usize) -> usize {
        // In 128 bits, so that no number of rays overflows.
        let middle = (2 * part as u128 + 1) * self.all as u128 / (2 * self.shown.max(1) as u128);
        self.first + middle as usize
    }

    /// Of how many places one is shown, about, and how many places there are.
    pub fn step(self) -> (usize, usize) {
        ((self.all as f64 / self.shown.max(1) as f64).round() as usize, self.all)
    }

    /// The places shown.
    pub fn places(self) -> impl ExactSizeIterator<Item = usize> {
        (0..self.shown).map(move |part| self.place(part))
    }

    /// Which of the places shown lie in a range, counted from the first one shown.
    pub fn between(self, places: &Range<usize>) -> Range<usize> {
        self.parts_before(places.start)..self.parts_before(places.end)
    }

    /// The parts whose places are smaller than this.
    fn parts_before(self, place: usize) -> usize {
        let place = place.saturating_sub(self.first) as u128;
        let (all, shown) = (self.all as u128, self.shown as u128);
        (2 * shown * place).saturating_sub(all).div_ceil(2 * all.max(1)).min(shown) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_shown_where_they_fit() {
        let detail = Detail::of(&(3..8), 100);
        assert_eq!(detail.places().collect::<Vec<_>>(), [3, 4, 5, 6, 7]);
        assert_eq!((detail.shown, detail.all), (5, 5));
        assert_eq!(Detail::of(&(4..4), 10).places().len(), 0);
        assert_eq!(Detail::of(&(0..9), 0).places().len(), 0);
    }

    #[test]
    fn scrubbing_leaves_the_places_between() {
        let detail = Detail::of(&(0..1000), 10);
        assert_eq!(detail.between(&(0..1000)), 0..10);
        assert_eq!(detail.between(&(100..300)), 1..3);
        assert_eq!(detail.between(&(51..60)), 1..1);
    }

    #[test]
    fn every_part_gives_one_place() {
        for (all, wanted) in [(10, 3), (1000, 7), (2_073_600, 65_536), (100_000_000, 4096)] {
            let places: Vec<usize> = Detail::of(&(5..5 + all), wanted).places().collect();
            assert_eq!(places.len(), wanted);
            for (part, place) in places.iter().enumerate() {
                let (low, high) = (part * all / wanted, ((part + 1) * all).div_ceil(wanted));
                assert!((5 + low..5 + high).contains(place), "part {part} of {wanted} gives {place}");
            }
            assert!(places.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
