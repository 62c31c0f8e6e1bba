//! Which rows of a long table are in sight.

/// Which rows are in sight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RowWindow {
    pub(super) first: usize,
    /// What the wheel has left over of a row.
    rest: f32,
}

impl RowWindow {
    /// Goes down by so many rows, no farther than the last row.
    pub(super) fn scroll(&mut self, rows: f32, all: usize, in_sight: usize) {
        let wanted = self.rest + rows;
        let whole = wanted.trunc();
        self.rest = wanted - whole;
        let last = all.saturating_sub(in_sight);
        let first = self.first as i128 + whole as i128;
        self.first = usize::try_from(first.max(0)).unwrap_or(usize::MAX).min(last);
    }

    /// Brings a row into sight.
    pub(super) fn reveal(&mut self, row: usize, all: usize, in_sight: usize) {
        if !(self.first..self.first + in_sight).contains(&row) {
            self.first = row.saturating_sub(in_sight / 2).min(all.saturating_sub(in_sight));
        }
    }

    /// The rows in sight, of so many.
    pub(super) fn rows(self, all: usize, in_sight: usize) -> std::ops::Range<usize> {
        let first = self.first.min(all);
        first..first.saturating_add(in_sight).min(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::rows::{Direction, Rows};

    /// All rays from both ends, and every seventh of them: the last row is the right ray.
    #[test]
    fn a_hundred_million_rows_end_at_the_last_one() {
        let (rays, in_sight) = (100_000_003usize, 37);
        let listed = Rows::Listed((0..rays as u32).step_by(7).collect());
        for (rows, last) in [
            (Rows::All(rays, Direction::Ascending), rays - 1),
            (Rows::All(rays, Direction::Descending), 0),
            (listed, (rays - 1) / 7 * 7),
        ] {
            let all = rows.len();
            let mut window = RowWindow::default();
            window.scroll(f32::MAX, all, in_sight);
            let seen = window.rows(all, in_sight);
            assert_eq!((seen.len(), seen.end, rows.place(all - 1)), (in_sight, all, last));
            window.rest = 0.0;
            window.scroll(-1.0, all, in_sight);
            assert_eq!(window.first + in_sight, all - 1);
            for row in [all - 1, all - 13] {
                window.reveal(row, all, in_sight);
                assert_eq!(window.first + in_sight, all);
            }
            let middle = rows.place(all / 2 + 3);
            window.reveal(rows.row_of(middle).unwrap(), all, in_sight);
            assert!(window.rows(all, in_sight).any(|row| rows.place(row) == middle));
        }
    }

    #[test]
    fn parts_of_rows_add_up() {
        let mut window = RowWindow::default();
        for _ in 0..10 {
            window.scroll(0.25, 100, 10);
        }
        assert_eq!(window.first, 2);
        window.scroll(-1e9, 100, 10);
        assert_eq!(window.first, 0);
        window.scroll(5.0, 3, 10);
        assert_eq!(window.first, 0);
    }
}
