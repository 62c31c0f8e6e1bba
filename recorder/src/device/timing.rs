//! Time that overlapping intervals cover.

/// Ticks that at least one of the intervals covers.
///
/// Submissions of one stage may overlap on the device; what they share is counted once, and what
/// lies between them not at all.
pub(super) fn covered_ticks(intervals: &mut [(u64, u64)]) -> u64 {
    intervals.sort_unstable();
    let mut covered = 0;
    let mut counted_up_to = 0;
    for &(begin, end) in intervals.iter() {
        let begin = begin.max(counted_up_to);
        covered += end.saturating_sub(begin);
        counted_up_to = counted_up_to.max(end);
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::covered_ticks;

    #[test]
    fn overlaps_count_once_and_gaps_not_at_all() {
        assert_eq!(covered_ticks(&mut []), 0);
        assert_eq!(covered_ticks(&mut [(5, 9)]), 4);
        assert_eq!(covered_ticks(&mut [(20, 30), (0, 10)]), 20, "a gap");
        assert_eq!(covered_ticks(&mut [(0, 10), (5, 15)]), 15, "an overlap");
        assert_eq!(covered_ticks(&mut [(0, 100), (10, 20), (50, 110)]), 110, "one inside another");
        assert_eq!(covered_ticks(&mut [(7, 3)]), 0, "a clock that runs backwards");
    }
}
