//! The folder of an export: made beside its place, and there only when it is complete.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use formats::files::outside_recordings;
use tempfile::TempDir;

/// Folder of the rays.
const RAYS: &str = "rays";
/// File of the times.
pub(super) const TIMINGS: &str = "timings.parquet";
/// File of the numbers of each order.
pub(super) const SUMMARIES: &str = "summaries.parquet";

/// Where an export goes. What is in the making is taken away with this.
#[derive(Debug)]
pub(super) struct Destination {
    place: PathBuf,
    /// Holds what is in the making, on the same file system as its place.
    beside: TempDir,
}

impl Destination {
    /// Makes a folder beside `out`.
    ///
    /// # Errors
    /// If `out` lies in a recording, holds something already and is not to be replaced, holds what no export
    /// wrote, or nothing can be written beside it.
    pub(super) fn new(out: &Path, may_replace: bool) -> anyhow::Result<Self> {
        let place = std::path::absolute(out).with_context(|| format!("cannot find {}", out.display()))?;
        let cannot = || format!("cannot write {}", place.display());
        let parent = place.parent().with_context(|| format!("{}: it is no folder to write", cannot()))?;
        if let Some(there) = place.ancestors().find(|folder| folder.exists()) {
            outside_recordings(&there.join(RAYS)).with_context(cannot)?;
        }
        if let Ok(kind) = fs::symlink_metadata(&place).map(|metadata| metadata.file_type()) {
            if !kind.is_dir() {
                bail!("{} is no folder; name another with --out", place.display());
            }
            check_replaceable(&place, may_replace)?;
        }
        fs::create_dir_all(parent).with_context(cannot)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".").suffix(".partial");
        // Like any new folder, and not for the owner alone; the system takes away what the user's mask says.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let beside = builder.tempdir_in(parent).with_context(cannot)?;
        fs::create_dir_all(beside.path().join("new").join(RAYS)).with_context(cannot)?;
        Ok(Self { place, beside })
    }

    fn new_folder(&self) -> PathBuf {
        self.beside.path().join("new")
    }

    /// The place of a file next to the folder of the rays.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.new_folder().join(name)
    }

    /// The place of a file of rays, whose folder is made.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(super) fn rays_file(&self, folder: &Path, name: &str) -> anyhow::Result<PathBuf> {
        let folder = self.new_folder().join(RAYS).join(folder);
        fs::create_dir_all(&folder).with_context(|| format!("cannot write {}", folder.display()))?;
        Ok(folder.join(name))
    }

    /// Puts everything in its place; gives the place.
    ///
    /// # Errors
    /// If it cannot be put there. What was there before then still is.
    pub(super) fn complete(self) -> anyhow::Result<PathBuf> {
        let cannot = || format!("cannot write {}", self.place.display());
        let old = self.beside.path().join("old");
        let is_replaced = self.place.exists();
        if is_replaced {
            fs::rename(&self.place, &old).with_context(cannot)?;
        }
        if let Err(error) = fs::rename(self.new_folder(), &self.place) {
            if is_replaced {
                fs::rename(&old, &self.place).with_context(|| {
                    format!(
                        "cannot put back what was in {}: it is in {}",
                        self.place.display(),
                        old.display()
                    )
                })?;
            }
            return Err(error).with_context(cannot);
        }
        Ok(self.place)
    }
}

/// Whether a folder is empty or, where it may be replaced, holds an export and nothing else.
fn check_replaceable(folder: &Path, may_replace: bool) -> anyhow::Result<()> {
    let cannot = || format!("cannot look into {}", folder.display());
    let entries = fs::read_dir(folder).with_context(cannot)?.collect::<Result<Vec<_>, _>>();
    let entries = entries.with_context(cannot)?;
    if entries.is_empty() {
        return Ok(());
    }
    for entry in entries {
        let (name, kind) = (entry.file_name(), entry.file_type().with_context(cannot)?);
        let is_own = match name.to_str() {
            Some(RAYS) => kind.is_dir(),
            Some(TIMINGS | SUMMARIES) => kind.is_file(),
            _ => false,
        };
        if !is_own {
            bail!("{} was written by no export; name another folder with --out", entry.path().display());
        }
    }
    let rays = folder.join(RAYS);
    if rays.exists() {
        check_rays(&rays)?;
    }
    if !may_replace {
        bail!("{} holds an export; replace it with --force", folder.display());
    }
    Ok(())
}

/// Whether everything below is a folder `NAME=VALUE` or a Parquet file.
fn check_rays(folder: &Path) -> anyhow::Result<()> {
    let cannot = || format!("cannot look into {}", folder.display());
    for entry in fs::read_dir(folder).with_context(cannot)? {
        let entry = entry.with_context(cannot)?;
        let (name, kind) = (entry.file_name(), entry.file_type().with_context(cannot)?);
        let name = name.to_string_lossy();
        match (kind.is_dir(), kind.is_file()) {
            (true, _) if name.contains('=') => check_rays(&entry.path())?,
            (_, true) if name.ends_with(".parquet") => {}
            _ => bail!("{} was written by no export; name another folder with --out", entry.path().display()),
        }
    }
    Ok(())
}
