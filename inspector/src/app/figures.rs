//! Figures for a paper, of all that is open, written by another thread: it reads whole recordings.

use std::collections::VecDeque;
use std::path::PathBuf;

use super::{App, Shown};
use crate::figures::style::Width;
use crate::inputs::{Inputs, quoted};
use crate::model::Absent;
use crate::model::background::Background;
use crate::output::counted;
use crate::plot;

/// A figure that was asked for.
#[derive(Clone, Debug)]
struct Export {
    /// How many were asked for before it.
    number: usize,
    name: &'static str,
    inputs: Vec<PathBuf>,
    folder: PathBuf,
}

/// Figures that are not written yet, one at a time.
#[derive(Debug, Default)]
pub(super) struct Exports {
    waiting: VecDeque<Export>,
    asked: usize,
    written: Background<usize, Result<usize, String>, 1>,
}

impl Exports {
    /// The figure that is being made.
    pub(super) fn now(&self) -> Option<&'static str> {
        self.waiting.front().map(|export| export.name)
    }
}

impl Export {
    /// Writes the files; how many there are.
    fn write(&self) -> Result<usize, String> {
        let made = || {
            let inputs = Inputs::open(&self.inputs)?;
            // All of them are open in the window.
            if let Some(why) = inputs.left_out.first() {
                anyhow::bail!("{why}");
            }
            plot::make(
                &inputs,
                &inputs.analysis()?,
                &[self.name.to_owned()],
                Width::OneColumn,
                &self.folder,
                |_| {},
            )
        };
        made().map(|made| made.files.len()).map_err(|error| error.to_string())
    }

    /// The command that does the same.
    fn command(&self) -> String {
        let inputs: Vec<String> = self.inputs.iter().map(|path| quoted(path)).collect();
        let (inputs, folder) = (inputs.join(" "), quoted(&self.folder));
        format!("inspector plot {inputs} --figure {} --out {folder}", self.name)
    }
}

impl App {
    /// Has a figure of the catalogue written into a folder.
    pub fn export_figure(&mut self, name: &'static str, folder: PathBuf) {
        let inputs = self.context.recordings.iter().map(|open| open.dump.root().to_owned()).collect();
        self.exports.waiting.push_back(Export { number: self.exports.asked, name, inputs, folder });
        self.exports.asked += 1;
    }

    /// Says what became of the figure that is being made.
    pub(super) fn take_exported(&mut self) {
        let Some(export) = self.exports.waiting.front().cloned() else { return };
        let writing = export.clone();
        let written = self.exports.written.of(export.number, self.context.waker(), move || writing.write());
        let result = match written {
            Err(Absent::Awaited) => return,
            Err(absent) => Err(absent.to_string()),
            Ok(result) => result.clone(),
        };
        self.exports.waiting.pop_front();
        match result {
            Ok(files) => {
                let files = counted(files as u64, "file", "files");
                let said = format!("{}: {files} in {}", export.name, export.folder.display());
                self.shown = Some(Shown { said, command: export.command() });
            }
            Err(why) => self.problem(format!("there is no figure {}", export.name), why),
        }
    }
}
