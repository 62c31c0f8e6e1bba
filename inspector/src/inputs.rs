//! What `plot` and `report` are given: recordings and benchmark results.

use std::path::{Path, PathBuf};

use formats::bench_result::BenchResult;
use formats::reader::Dump;

use crate::figures::catalogue::{self, Catalogue};

/// Recordings and benchmark results, in the order in which they were named.
pub(crate) struct Inputs {
    pub(crate) recordings: Vec<Dump>,
    pub(crate) benches: Vec<BenchResult>,
}

impl Inputs {
    /// Opens each path: a file is a benchmark result, anything else a recording.
    pub(crate) fn open(paths: &[PathBuf]) -> anyhow::Result<Self> {
        let mut inputs = Self { recordings: Vec::new(), benches: Vec::new() };
        for path in paths {
            if path.is_file() {
                inputs.benches.push(BenchResult::read(path)?);
            } else {
                inputs.recordings.push(Dump::open(path)?);
            }
        }
        Ok(inputs)
    }

    /// Every figure that they have the numbers for, those of `names` alone if there are any.
    pub(crate) fn catalogue(&self, names: &[String]) -> anyhow::Result<Catalogue> {
        let mut catalogue = catalogue::all(&self.recordings, &self.benches)?;
        if names.is_empty() {
            return Ok(catalogue);
        }
        for name in names {
            if let Some((_, reason)) = catalogue.skipped.iter().find(|(skipped, _)| skipped == name) {
                anyhow::bail!("there is no figure {name} of these: {reason}");
            }
            if !catalogue.figures.iter().any(|figure| figure.name == *name) {
                let known: Vec<&str> = catalogue.figures.iter().map(|figure| figure.name.as_str()).collect();
                anyhow::bail!("there is no figure {name}; there are: {}", known.join(", "));
            }
        }
        catalogue.figures.retain(|figure| names.contains(&figure.name));
        catalogue.skipped.clear();
        Ok(catalogue)
    }
}

/// A path as a shell takes it.
pub(crate) fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |character: char| character.is_alphanumeric() || "-_./:=+,@".contains(character);
    if !text.is_empty() && text.chars().all(is_plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_quoted_where_a_shell_would_split_them() {
        assert_eq!(quoted(Path::new("a/b-1.raydump")), "a/b-1.raydump");
        assert_eq!(quoted(Path::new("it's here")), "'it'\\''s here'");
    }

    #[test]
    fn what_is_no_input_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("other.json");
        std::fs::write(&file, "{}").unwrap();
        let message = |path: PathBuf| Inputs::open(&[path]).err().unwrap().to_string();
        assert!(message(file).contains("is not what `recorder bench --json` prints"));
        assert!(message(folder.path().join("none.raydump")).contains("there is no recording"));
    }
}
