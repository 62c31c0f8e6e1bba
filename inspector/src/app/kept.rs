//! What is kept from one window to the next: where panels are, and which recordings were opened.

use std::io;
use std::path::{Path, PathBuf};

use egui_tiles::Tree;
use formats::files::{read_plain, replace};
use serde::{Deserialize, Serialize};

use super::layout::Pane;
use crate::recent::Recent;

/// Bytes of the largest file that is read; usual ones have some thousands.
const LARGEST: u64 = 1 << 20;

/// What is kept. The library of the window keeps only where the window itself was: it cuts its file before
/// it writes it, so that a full disk takes what was there.
#[derive(Serialize, Deserialize)]
pub(super) struct Kept {
    pub(super) tiles: Tree<Pane>,
    pub(super) recent: Recent,
}

impl Kept {
    /// Where the windows of an application keep it; `None` where the system has no place for that.
    pub(super) fn path(app_id: &str) -> Option<PathBuf> {
        eframe::storage_dir(app_id).map(|folder| folder.join("window.json"))
    }

    /// What an earlier window kept; `None` if there is nothing, or nothing that this version can use.
    pub(super) fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&read_plain(path, LARGEST).ok()?).ok()
    }

    /// Keeps it.
    ///
    /// # Errors
    /// If the file cannot be written; what was kept before is still there.
    pub(super) fn write(&self, path: &Path) -> io::Result<()> {
        let text = serde_json::to_vec(self)?;
        replace(path, |file| file.write_all(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::layout;

    #[test]
    fn what_is_kept_comes_back_and_damage_is_as_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("window.json");
        assert!(Kept::read(&path).is_none());
        let mut kept = Kept { tiles: layout::at_first(), recent: Recent::default() };
        layout::bring_forward(&mut kept.tiles, "timings");
        kept.recent.note(Path::new("/a.raydump"));
        kept.write(&path).unwrap();
        let again = Kept::read(&path).unwrap();
        assert_eq!(again.recent, kept.recent);
        assert_eq!(serde_json::to_value(&again.tiles).unwrap(), serde_json::to_value(&kept.tiles).unwrap());
        std::fs::write(&path, "{").unwrap();
        assert!(Kept::read(&path).is_none());
    }
}
