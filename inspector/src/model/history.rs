//! Selections to go back to, and forward again.

use super::selection::Selection;

/// Selections that are kept.
const KEPT: usize = 256;

/// What was selected before, and what was undone.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Selection>,
    now: Option<Selection>,
    future: Vec<Selection>,
}

impl History {
    /// Remembers what is selected, if it is something else than before. Nothing can be redone after that.
    pub fn note(&mut self, selection: &Selection) {
        // What B was elsewhere is nothing that anybody sees.
        if let Some(now) = &mut self.now {
            now.wanted.clone_from(&selection.wanted);
        }
        if self.now.as_ref() == Some(selection) {
            return;
        }
        // The group of a ray is known once its order is read: nothing else was selected.
        let found_group =
            |now: &&mut Selection| Selection { group: selection.group, ..(**now).clone() } == *selection;
        if let Some(now) = self.now.as_mut().filter(|now| now.group.is_none()).filter(found_group) {
            now.group = selection.group;
            return;
        }
        if let Some(before) = self.now.replace(selection.clone()) {
            if self.past.len() == KEPT {
                self.past.remove(0);
            }
            self.past.push(before);
            self.future.clear();
        }
    }

    /// What was selected before.
    pub fn undo(&mut self) -> Option<Selection> {
        let before = self.past.pop()?;
        self.future.extend(self.now.replace(before.clone()));
        Some(before)
    }

    /// What was selected before the last [`History::undo`].
    pub fn redo(&mut self) -> Option<Selection> {
        let after = self.future.pop()?;
        self.past.extend(self.now.replace(after.clone()));
        Some(after)
    }

    /// Whether there is something to undo, and something to redo.
    pub fn can(&self) -> (bool, bool) {
        (!self.past.is_empty(), !self.future.is_empty())
    }

    /// Forgets everything, as when another session is opened.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(ray: usize) -> Selection {
        Selection { ray: Some(ray), ..Selection::default() }
    }

    #[test]
    fn a_group_that_is_found_later_is_no_other_selection() {
        let mut history = History::default();
        history.note(&of(1));
        history.note(&of(2));
        history.note(&Selection { group: Some(0), ..of(2) });
        history.note(&Selection { group: Some(7), ..of(2) });
        assert_eq!(history.undo(), Some(Selection { group: Some(0), ..of(2) }));
        assert_eq!((history.undo(), history.undo()), (Some(of(1)), None));
    }

    #[test]
    fn what_was_undone_is_redone_until_something_else_is_selected() {
        let mut history = History::default();
        for ray in [1, 1, 2, 3] {
            history.note(&of(ray));
        }
        assert_eq!((history.undo(), history.undo(), history.undo()), (Some(of(2)), Some(of(1)), None));
        history.note(&of(1));
        assert_eq!(history.redo(), Some(of(2)));
        history.note(&of(9));
        assert_eq!((history.redo(), history.undo()), (None, Some(of(2))));
    }

    #[test]
    fn the_oldest_are_forgotten() {
        let mut history = History::default();
        (0..2 * KEPT).for_each(|ray| history.note(&of(ray)));
        assert_eq!((0..2 * KEPT).filter(|_| history.undo().is_some()).count(), KEPT);
    }
}
