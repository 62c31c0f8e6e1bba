//! Recordings that were opened before.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Recordings that are remembered.
const REMEMBERED: usize = 12;

/// Recordings that were opened before, the last one first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recent(Vec<PathBuf>);

impl Recent {
    /// Remembers a recording, by its path from the root of the file system.
    pub fn note(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.0.retain(|known| *known != path);
        self.0.insert(0, path);
        self.0.truncate(REMEMBERED);
    }

    /// Those of `older` too, after its own.
    pub fn add_older(&mut self, older: Self) {
        for path in older.0 {
            if !self.0.contains(&path) {
                self.0.push(path);
            }
        }
        self.0.truncate(REMEMBERED);
    }

    /// The paths, the last one first.
    pub fn paths(&self) -> &[PathBuf] {
        &self.0
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_one_is_first_and_only_once() {
        let mut recent = Recent::default();
        for name in ["/a", "/b", "/a"] {
            recent.note(Path::new(name));
        }
        recent.add_older(Recent(vec!["/c".into(), "/b".into()]));
        assert_eq!(recent.paths(), [Path::new("/a"), Path::new("/b"), Path::new("/c")]);
        (0..40).for_each(|number| recent.note(Path::new(&format!("/{number}"))));
        assert_eq!((recent.paths().len(), recent.paths()[0].as_path()), (REMEMBERED, Path::new("/39")));
    }
}
