//! Sessions: all that a window shows, as a file to come back to or to draw from without a screen.

pub mod setting;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::ValueEnum;
use formats::files::{read_plain, replace};
use formats::key::method::UNSORTED;
use formats::manifest::QueueId;
use formats::ray::Kind;
use serde::{Deserialize, Serialize};

use crate::analysis::GroupWidth;
use crate::model::what_if::{self, WHAT_IF};
use crate::model::{Context, Selection};

/// Versions of the files that this program reads; it writes the last.
const OLDEST: u64 = 1;
const VERSION: u64 = 4;

/// What colours stood for in version 1, and what it is called since.
const RENAMED_COLOURS: [(&str, &str); 2] = [("estimate", "ratio"), ("capsule-area", "area")];

/// Bytes of the largest file that is read as a session; usual ones have some thousands.
const LARGEST: u64 = 16 << 20;

/// What panels were called before version 4, and are called since.
const RENAMED_PANELS: [(&str, &str); 2] = [("order", "pixels"), ("table", "length-table")];

/// All that a window shows.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// 4.
    version: u64,
    /// The recordings; relative paths start at the session's folder.
    pub recordings: Vec<PathBuf>,
    /// What of them is selected.
    pub selection: SavedSelection,
    /// What the what-if order is made by, if there is one.
    #[serde(default)]
    pub what_if: Option<what_if::Settings>,
    /// Light, dark, or as the system.
    pub theme: ThemeChoice,
    /// Where panels are.
    pub layout: Option<egui_tiles::Tree<String>>,
    /// What panels show besides the selection, by their names.
    pub panels: BTreeMap<String, serde_json::Value>,
}

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum ThemeChoice {
    /// Dark on light.
    Light,
    /// Light on dark.
    Dark,
    /// As the system.
    #[default]
    #[value(skip)]
    System,
}

impl From<egui::ThemePreference> for ThemeChoice {
    fn from(theme: egui::ThemePreference) -> Self {
        match theme {
            egui::ThemePreference::Light => Self::Light,
            egui::ThemePreference::Dark => Self::Dark,
            egui::ThemePreference::System => Self::System,
        }
    }
}

impl From<ThemeChoice> for egui::ThemePreference {
    fn from(theme: ThemeChoice) -> Self {
        match theme {
            ThemeChoice::Light => Self::Light,
            ThemeChoice::Dark => Self::Dark,
            ThemeChoice::System => Self::System,
        }
    }
}

/// A [`Selection`] as it is written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedSelection {
    pub(crate) recording: usize,
    pub(crate) pass: u32,
    pub(crate) bounce: u32,
    pub(crate) kind: Kind,
    /// Order B.
    pub(crate) method: String,
    /// Order A.
    #[serde(default = "unsorted")]
    pub(crate) baseline: String,
    /// The recording of order A; that of B if `None`.
    #[serde(default)]
    pub(crate) baseline_recording: Option<usize>,
    pub(crate) group_width: String,
    pub(crate) ray: Option<usize>,
    /// Rays that are selected, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) others: Vec<usize>,
    pub(crate) group: Option<usize>,
    pub(crate) cell: Option<u32>,
    /// Which rays are shown; all if empty.
    #[serde(default)]
    pub(crate) filter: String,
}

fn unsorted() -> String {
    UNSORTED.to_owned()
}

impl From<&Selection> for SavedSelection {
    fn from(selection: &Selection) -> Self {
        let Selection {
            recording,
            queue,
            method,
            wanted: _,
            baseline,
            group_width,
            ray,
            others,
            group,
            cell,
            filter,
        } = selection.clone();
        Self {
            recording,
            pass: queue.pass,
            bounce: queue.bounce,
            kind: queue.kind,
            method,
            baseline: baseline.method,
            baseline_recording: baseline.recording,
            group_width: group_width.rays().to_string(),
            ray,
            others,
            group,
            cell,
            filter: filter.text().to_owned(),
        }
    }
}

impl Session {
    /// What a window shows; panels and layout are given by it.
    pub fn of(
        context: &Context,
        theme: ThemeChoice,
        layout: Option<egui_tiles::Tree<String>>,
        panels: BTreeMap<String, serde_json::Value>,
    ) -> Self {
        let path = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Self {
            version: VERSION,
            recordings: context.recordings.iter().map(|open| path(open.dump.root())).collect(),
            selection: SavedSelection::from(&context.selection),
            what_if: context.what_if.clone(),
            theme,
            layout,
            panels,
        }
    }

    /// Reads a session.
    ///
    /// # Errors
    /// If there is none in that file, or one of another version.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let name = path.display();
        let bytes = read_plain(path, LARGEST).map_err(|cause| anyhow!("{name} cannot be read: {cause}"))?;
        let syntax = |cause: serde_json::Error| {
            anyhow!("{name} is not a session of the inspector: {cause}; File > Save session writes one")
        };
        let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(syntax)?;
        // Another version may differ in anything else, so it is read first.
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(found) if !(OLDEST..=VERSION).contains(&found) => {
                bail!("{name} is a session of version {found}; this program reads {OLDEST} to {VERSION}");
            }
            _ => {}
        }
        let mut session: Self = serde_json::from_slice(&bytes).map_err(syntax)?;
        session.upgrade();
        let folder = path.parent().unwrap_or(Path::new(""));
        for recording in &mut session.recordings {
            *recording = folder.join(&*recording);
        }
        Ok(session)
    }

    /// From what an earlier version wrote.
    fn upgrade(&mut self) {
        if self.version == OLDEST {
            for colour in self.panels.values_mut().filter_map(|panel| panel.pointer_mut("/options/colour_by"))
            {
                let renamed = RENAMED_COLOURS.into_iter().find(|(before, _)| *colour == *before);
                if let Some((_, now)) = renamed {
                    *colour = now.into();
                }
            }
        }
        // Versions 1 and 2 held two orders against each other in a panel of its own.
        if let Some(compare) = self.panels.remove("compare") {
            self.selection.baseline = compare["before"].as_str().map_or_else(unsorted, str::to_owned);
            let at = compare["before_recording"].as_u64();
            self.selection.baseline_recording = at.and_then(|at| usize::try_from(at).ok());
        }
        if self.version < 4 {
            for (before, now) in RENAMED_PANELS {
                if let Some(state) = self.panels.remove(before) {
                    self.panels.insert(now.to_owned(), state);
                }
                let tiles = self.layout.iter_mut().flat_map(|tree| tree.tiles.tiles_mut());
                for tile in tiles {
                    if let egui_tiles::Tile::Pane(name) = tile
                        && name == before
                    {
                        now.clone_into(name);
                    }
                }
            }
        }
        self.version = VERSION;
    }

    /// Writes it.
    ///
    /// # Errors
    /// If that file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        replace(path, |file| writeln!(file, "{text}"))
            .map_err(|cause| anyhow!("{} cannot be written: {cause}", path.display()))
    }

    /// With these recordings in place of its own; its own if there are none.
    pub(crate) fn of_recordings(mut self, recordings: &[PathBuf]) -> Self {
        if let Some(last) = recordings.len().checked_sub(1) {
            self.recordings = recordings.to_vec();
            self.selection.recording = self.selection.recording.min(last);
        }
        self
    }

    /// Opens its recordings and selects what was selected. What is not there any more is a problem.
    pub fn open(&self) -> Context {
        let mut context = Context::default();
        let mut opened = Vec::new();
        for path in &self.recordings {
            opened.push(context.add(path).then(|| context.recordings.len() - 1));
        }
        context.what_if.clone_from(&self.what_if);
        let place = |number: usize| opened.get(number).copied().flatten();
        let Some(at) = place(self.selection.recording) else { return context };
        context.select_recording(at);
        let baseline_recording = self.selection.baseline_recording.and_then(place);
        let selection = SavedSelection { baseline_recording, ..self.selection.clone() };
        if let Err(why) = selection.select(&mut context) {
            let what = "not all that the session had selected can be selected".to_owned();
            context.problems.push(crate::model::context::Problem { what, why });
        }
        context
    }
}

impl SavedSelection {
    /// The selected queue.
    pub(crate) fn queue(&self) -> QueueId {
        QueueId { pass: self.pass, bounce: self.bounce, kind: self.kind }
    }

    /// Selects it in the selected recording.
    ///
    /// # Errors
    /// What that recording does not have.
    pub(crate) fn select(&self, context: &mut Context) -> Result<(), String> {
        let queue = self.queue();
        let recording = context.recording().ok_or("its recording is not open")?;
        let Some(record) = recording.queue(queue) else {
            let known: Vec<String> = recording.queues().iter().map(|record| record.id.to_string()).collect();
            return Err(format!("{} has no {queue}; it has: {}", recording.label, known.join(", ")));
        };
        let is_made = self.method == WHAT_IF || self.method == UNSORTED;
        if !is_made && !record.methods.contains(&self.method) {
            let known = record.methods.join(", ");
            return Err(format!("{queue} was not ordered by {}; there are: {known}", self.method));
        }
        let width = GroupWidth::from_str(&self.group_width, false)?;
        let rays = record.rays;
        let groups = rays.div_ceil(width.rays() as u64);
        let selected = self.ray.iter().chain(&self.others).map(|&ray| ("ray", ray, rays));
        for (what, chosen, all) in selected.chain(self.group.map(|group| ("group", group, groups))) {
            if chosen as u64 >= all {
                return Err(format!("{queue} has no {what} {chosen}; there are {all}, counted from 0"));
            }
        }
        context.go_to(queue);
        context.selection.group_width = width;
        context.is_b_chosen = true;
        context.selection.order_by(&self.method);
        context.hold_against(self.baseline_recording, &self.baseline);
        if context.selection.baseline.method != self.baseline {
            return Err(format!("{queue} was not ordered by {}, which was to be order A", self.baseline));
        }
        let selection = &mut context.selection;
        selection.others.clone_from(&self.others);
        (selection.ray, selection.group, selection.cell) = (self.ray, self.group, self.cell);
        selection.filter.set(&self.filter);
        match selection.filter.error() {
            Some(error) => Err(format!("the filter is none: {}", error.shown(&self.filter))),
            None => Ok(()),
        }
    }
}
