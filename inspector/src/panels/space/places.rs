//! The places of an order that a picture shows: some of those that pass the filter, spread evenly.

use std::ops::Range;
use std::sync::Arc;

use crate::filter::Passing;
use crate::render::detail::Detail;

pub(super) struct ShownPlaces {
    detail: Detail,
    /// Those that `detail` picks from; all if `None`.
    passing: Option<Arc<Passing>>,
}

impl ShownPlaces {
    /// At most `wanted` of a range of places.
    pub(super) fn of(places: &Range<usize>, wanted: usize, passing: Option<Arc<Passing>>) -> Self {
        let of = passing.as_ref().map_or_else(|| places.clone(), |passing| passing.between(places));
        Self { detail: Detail::of(&of, wanted), passing }
    }

    /// The places, ascending.
    pub(super) fn places(&self) -> impl Iterator<Item = usize> {
        let place = |at: usize| self.passing.as_ref().map_or(at, |passing| passing.places()[at] as usize);
        self.detail.places().map(place)
    }

    /// Of how many that pass one is shown, and how many there are to pick from.
    pub(super) fn step(&self) -> (usize, usize) {
        self.detail.step()
    }

    /// Which of them lie in a range, counted from the first one.
    pub(super) fn between(&self, places: &Range<usize>) -> Range<usize> {
        match &self.passing {
            Some(passing) => self.detail.between(&passing.between(places)),
            None => self.detail.between(places),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_do_not_pass_are_passed_over() {
        let passing = Arc::new(Passing::of(vec![2, 3, 50, 51, 52, 90], 100));
        let shown = |wanted| ShownPlaces::of(&(0..100), wanted, Some(passing.clone()));
        assert_eq!(shown(100).places().collect::<Vec<_>>(), [2, 3, 50, 51, 52, 90]);
        assert_eq!(shown(3).places().collect::<Vec<_>>(), [3, 51, 90]);
        assert_eq!((shown(100).step(), shown(3).step()), ((1, 6), (2, 6)));
        assert_eq!(shown(100).between(&(3..52)), 1..4);
        assert_eq!(ShownPlaces::of(&(3..52), 100, Some(passing.clone())).places().count(), 3);
        assert_eq!(ShownPlaces::of(&(4..9), 100, None).places().collect::<Vec<_>>(), [4, 5, 6, 7, 8]);
    }
}
