//! What `plot` and `report` are given: recordings, studies and benchmark results.

use std::path::{Path, PathBuf};

use formats::bench_result::BenchResult;
use formats::reader::Dump;
use formats::study::Study;
use formats::text::shell_word;

use crate::analysis::summary::distinct;
use crate::analysis::{Analysis, analyse_studies, lacking, open_finished};
use crate::figures::catalogue::{CATALOGUE, FigureMaker, Findings, Skipped};
use crate::figures::model::Figure;
use crate::output::{say, sentence};

/// Scenes of a study whose first views have figures and tables of their own.
const MOST_SCENES: usize = 8;

/// Recordings and benchmark results, in the order in which they were named; of a study each scene's first view.
pub(crate) struct Inputs {
    pub(crate) recordings: Vec<Dump>,
    pub(crate) studies: Vec<Study>,
    pub(crate) benches: Vec<BenchResult>,
    /// Why others cannot be used, a sentence each.
    pub(crate) left_out: Vec<String>,
}

impl Inputs {
    /// Opens each path: a file is a benchmark result, a folder a study or a recording. What cannot be used is left
    /// out, and said at once.
    ///
    /// # Errors
    /// If nothing of it can be used.
    pub(crate) fn open(paths: &[PathBuf]) -> anyhow::Result<Self> {
        let mut inputs =
            Self { recordings: Vec::new(), studies: Vec::new(), benches: Vec::new(), left_out: Vec::new() };
        for path in paths {
            if let Err(error) = inputs.add(path) {
                inputs.left_out.push(sentence(&error));
            }
        }
        let Self { recordings, studies, benches, left_out } = &inputs;
        let is_empty = recordings.is_empty() && studies.is_empty() && benches.is_empty();
        anyhow::ensure!(!is_empty, "{}", left_out.join("; "));
        left_out.iter().for_each(|why| say(&format!("left out: {why}")));
        Ok(inputs)
    }

    fn add(&mut self, path: &Path) -> anyhow::Result<()> {
        if path.is_file() {
            self.benches.push(BenchResult::read(path)?);
        } else if Study::is_at(path) {
            let study = Study::open(path)?;
            for recording in first_views(&study) {
                if let Err(error) = self.add_recording(&recording) {
                    self.left_out.push(sentence(&error));
                }
            }
            self.studies.push(study);
        } else {
            self.add_recording(path)?;
        }
        Ok(())
    }

    fn add_recording(&mut self, path: &Path) -> anyhow::Result<()> {
        self.recordings.push(open_finished(path)?);
        Ok(())
    }

    /// The numbers of all recordings, arrays included. What some queues lack is said.
    pub(crate) fn analysis(&self) -> anyhow::Result<Analysis> {
        let analysis = analyse_studies(&self.studies, &self.recordings)?;
        for notice in analysis.study.iter().flat_map(|study| &study.notices) {
            say(notice);
        }
        for lacking in analysis.recordings.iter().flat_map(lacking::all) {
            say(&format!("missing: {lacking}"));
        }
        Ok(analysis)
    }

    /// Every figure that they have the numbers for, those of `names` alone if there are any; and those that
    /// need what is not there.
    pub(crate) fn figures(
        &self,
        analysis: &Analysis,
        names: &[String],
    ) -> anyhow::Result<(Vec<Figure>, Vec<Skipped>)> {
        let findings = Findings { analysis, benches: &self.benches };
        let (mut made, mut left_out) = (Vec::new(), Vec::new());
        let is_wanted =
            |maker: &&FigureMaker| names.is_empty() || names.iter().any(|name| name == maker.name);
        for maker in CATALOGUE.iter().filter(is_wanted) {
            match maker.make(&findings) {
                Ok(figure) => made.push(figure),
                Err(skipped) if names.is_empty() => left_out.push(skipped),
                Err(Skipped { figure, reason }) => {
                    anyhow::bail!("there is no figure {figure} of these: {reason}")
                }
            }
        }
        Ok((made, left_out))
    }
}

/// The recordings of the first job of each scene, of the first scenes.
fn first_views(study: &Study) -> Vec<PathBuf> {
    let finished = || study.jobs.iter().filter(|job| job.record.failure.is_none());
    let scenes = distinct(finished().map(|job| job.record.scene.as_str()));
    if scenes.len() > MOST_SCENES {
        say(&format!(
            "{}: {} scenes; means are over all, details are of the first {MOST_SCENES}",
            study.root.display(),
            scenes.len()
        ));
    }
    let first = |scene: &str| finished().find(|job| job.record.scene == scene);
    let jobs = scenes.into_iter().take(MOST_SCENES).filter_map(first);
    jobs.flat_map(|job| job.record.recordings.iter().map(|name| job.folder.join(name))).collect()
}

/// Whether all of these are names of figures.
///
/// # Errors
/// If one is not, with those that there are.
pub(crate) fn check_names(names: &[String]) -> anyhow::Result<()> {
    match names.iter().find(|name| CATALOGUE.iter().all(|maker| maker.name != **name)) {
        None => Ok(()),
        Some(name) => {
            let known: Vec<&str> = CATALOGUE.iter().map(|maker| maker.name).collect();
            anyhow::bail!("there is no figure {name}; there are: {}", known.join(", "))
        }
    }
}

/// A path as a shell takes it.
pub(crate) fn quoted(path: &Path) -> String {
    shell_word(&path.display().to_string()).into_owned()
}
