//! What a study is to record: `study.toml`.
//!
//! ```toml
//! scenes = ["builtin:cornell", { file = "sponza.glb", cameras = ["nave", "aisle"] }]
//! cameras = "first"                      # of scenes without their own: "first", "all", names, or n automatic views
//! seeds = [0, 1]
//!
//! [record]                               # options of `recorder record` by their long names
//! width = 640
//! methods = ["aila", "two-point"]
//! russian-roulette = true
//!
//! [replay.bits]                          # of `recorder replay`: bits.raydump, from the rays of each recording
//! key-bits = [16, 32]
//! ```

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use formats::files::read_plain;
use formats::text::{did_you_mean, one_line};
use toml::{Table, Value};

use super::PlanError;
use super::words::{Commands, Parser, sentence, words};
use crate::options::RecordOptions;
use crate::replay::ReplayOptions;

/// Bytes of the longest plan that is read.
const BYTES_MAX: u64 = 1 << 20;
/// Most characters of a name that a problem shows.
const SHOWN: usize = 100;
/// What the recording is called that replays are made from.
pub const RECORDING: &str = "recording";
/// Keys of a plan.
const KEYS: [&str; 5] = ["scenes", "cameras", "seeds", "record", "replay"];
/// Keys of a scene that is a table.
const SCENE_KEYS: [&str; 2] = ["file", "cameras"];

/// What a study is to record.
#[derive(Debug)]
pub struct Plan {
    /// The file, as it was read.
    pub text: String,
    /// In the order of the plan.
    pub scenes: Vec<PlannedScene>,
    /// Seeds of all random numbers; each makes jobs of its own.
    pub seeds: Vec<u64>,
    /// What is done with each scene, camera and seed: the recording first, then its replays.
    pub record: Planned<RecordOptions>,
    /// Replays, in the order of their names.
    pub replays: Vec<Planned<ReplayOptions>>,
}

/// A command of every job.
#[derive(Debug)]
pub struct Planned<T> {
    /// Name of what it makes, without the extension.
    pub name: String,
    /// Its options as words.
    pub words: Vec<String>,
    /// What they stand for, but for what differs from job to job.
    pub options: T,
}

/// A scene of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedScene {
    /// As the plan names it.
    pub name: String,
    /// What `recorder record` is given: a built-in name, or a file's absolute path.
    pub source: String,
    /// From where it is seen.
    pub cameras: Cameras,
}

/// Which cameras of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Cameras {
    /// The one that `recorder record` takes by itself.
    First,
    /// All that it has.
    All,
    /// These.
    Named(Vec<String>),
    /// So many views chosen automatically.
    Automatic(u32),
}

/// Reads a plan. With `folder`, the scene files of that folder take the place of the plan's scenes.
///
/// # Errors
/// All that is wrong with it.
pub fn read(file: &Path, folder: Option<&Path>, commands: &Commands) -> Result<Plan, PlanError> {
    let refuse = |problem: String| PlanError { problems: vec![problem] };
    let shown = one_line(&file.to_string_lossy(), SHOWN);
    let bytes = read_plain(file, BYTES_MAX)
        .map_err(|error| refuse(format!("cannot read the plan {shown}: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|_| refuse(format!("{shown} is no text in UTF-8")))?;
    let mut reader = Reader { base: file.parent().unwrap_or(Path::new("")), commands, problems: Vec::new() };
    let plan = match text.parse::<Table>() {
        Ok(table) => reader.plan(&table, folder, text),
        Err(error) => {
            let line = 1 + error.span().map_or(0, |span| text[..span.start].matches('\n').count());
            reader.problems.push(format!("line {line}: {}", error.message().replace('\n', " ")));
            None
        }
    };
    match plan {
        Some(plan) if reader.problems.is_empty() => Ok(plan),
        _ => Err(PlanError {
            problems: reader.problems.iter().map(|problem| format!("{shown}: {problem}")).collect(),
        }),
    }
}

/// Reads a plan, and keeps what is wrong with it.
struct Reader<'a> {
    /// What files are relative to.
    base: &'a Path,
    commands: &'a Commands,
    problems: Vec<String>,
}

impl Reader<'_> {
    /// A problem, and nothing.
    fn refuse<T>(&mut self, problem: String) -> Option<T> {
        self.problems.push(problem);
        None
    }

    fn plan(&mut self, table: &Table, folder: Option<&Path>, text: String) -> Option<Plan> {
        self.know(table, &KEYS, "");
        let cameras = match table.get("cameras") {
            Some(value) => self.cameras(value, "cameras"),
            None => Some(Cameras::First),
        };
        let scenes = match folder {
            Some(folder) => self.scenes_of(folder, cameras.as_ref()),
            None => self.scenes(table.get("scenes"), cameras.as_ref()),
        };
        let seeds = self.seeds(table.get("seeds"));
        let record = self.table(table.get("record"), "[record]");
        let scene = "builtin:cornell".to_owned();
        let record = self.planned(RECORDING, "[record]", &record, scene, &self.commands.record);
        let replays = self.table(table.get("replay"), "[replay.NAME]");
        let replays: Vec<_> = replays.iter().map(|(name, value)| self.replay(name, value)).collect();
        Some(Plan {
            text,
            scenes: scenes?,
            seeds: seeds?,
            record: record?,
            replays: replays.into_iter().collect::<Option<_>>()?,
        })
    }

    /// Refuses keys that there are not.
    fn know(&mut self, table: &Table, known: &[&str], place: &str) {
        for key in table.keys().filter(|key| !known.contains(&key.as_str())) {
            let hint = did_you_mean(key, known);
            self.problems.push(format!("{place}{}: there is no such key; {hint}", one_line(key, SHOWN)));
        }
    }

    /// A table, or an empty one.
    fn table(&mut self, value: Option<&Value>, place: &str) -> Table {
        match value {
            None => Table::new(),
            Some(Value::Table(table)) => table.clone(),
            Some(value) => {
                let found = one_line(&value.to_string(), SHOWN);
                self.refuse(format!("{place}: found {found}, expected a table of options"))
                    .unwrap_or_default()
            }
        }
    }

    fn cameras(&mut self, value: &Value, place: &str) -> Option<Cameras> {
        let named = |values: &Vec<Value>| {
            let names = values.iter().map(|value| value.as_str().map(str::to_owned));
            names.collect::<Option<Vec<String>>>().filter(|names| !names.is_empty())
        };
        let cameras = match value {
            Value::String(text) if text == "first" => Some(Cameras::First),
            Value::String(text) if text == "all" => Some(Cameras::All),
            Value::Integer(count) => u32::try_from(*count)
                .ok()
                .filter(|count| (1..=scenes::views::VIEWS_MAX).contains(count))
                .map(Cameras::Automatic),
            Value::Array(values) => named(values).map(Cameras::Named),
            _ => None,
        };
        if let Some(Cameras::Named(names)) = &cameras
            && let Some(name) = repeated(names)
        {
            return self.refuse(format!("{place}: '{}' is listed twice", one_line(name, SHOWN)));
        }
        let found = one_line(&value.to_string(), SHOWN);
        cameras.or_else(|| {
            self.refuse(format!(
                "{place}: found {found}, expected \"first\", \"all\", a list of names, or how many automatic views, 1 to {}",
                scenes::views::VIEWS_MAX
            ))
        })
    }

    fn seeds(&mut self, value: Option<&Value>) -> Option<Vec<u64>> {
        let Some(value) = value else { return Some(vec![0]) };
        let seed = |value: &Value| value.as_integer().and_then(|seed| u64::try_from(seed).ok());
        let seeds: Option<Vec<u64>> = value.as_array().and_then(|list| list.iter().map(seed).collect());
        match seeds {
            Some(seeds) if !seeds.is_empty() => match repeated(&seeds) {
                Some(seed) => self.refuse(format!("seeds: {seed} is listed twice")),
                None => Some(seeds),
            },
            _ => {
                let found = one_line(&value.to_string(), SHOWN);
                self.refuse(format!("seeds: found {found}, expected a list of whole numbers from 0 on"))
            }
        }
    }

    fn scenes(&mut self, value: Option<&Value>, cameras: Option<&Cameras>) -> Option<Vec<PlannedScene>> {
        let Some(list) = value.and_then(Value::as_array).filter(|list| !list.is_empty()) else {
            return self.refuse(
                "scenes: expected a list of files and built-in scenes, such as [\"builtin:cornell\", \"sponza.glb\"]"
                    .to_owned(),
            );
        };
        let scenes: Vec<_> = list.iter().map(|value| self.scene(value, cameras)).collect();
        let scenes = scenes.into_iter().collect::<Option<Vec<_>>>()?;
        let names: Vec<&String> = scenes.iter().map(|scene| &scene.name).collect();
        match repeated(&names) {
            Some(name) => {
                let name = one_line(name, SHOWN);
                self.refuse(format!("scenes: '{name}' is listed twice; list its cameras in one place"))
            }
            None => Some(scenes),
        }
    }

    fn scene(&mut self, value: &Value, cameras: Option<&Cameras>) -> Option<PlannedScene> {
        let (name, cameras) = match value {
            Value::String(name) => (Some(name.as_str()), cameras.cloned()),
            Value::Table(table) => {
                self.know(table, &SCENE_KEYS, "scenes: ");
                let name = table.get("file").and_then(Value::as_str);
                let own = table.get("cameras");
                (name, own.map_or(cameras.cloned(), |own| self.cameras(own, "scenes: cameras")))
            }
            _ => (None, None),
        };
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            let found = one_line(&value.to_string(), SHOWN);
            return self.refuse(format!(
                "scenes: found {found}, expected a name, or {{ file = \"NAME\", cameras = … }}"
            ));
        };
        let source = match name.starts_with("builtin:") {
            true => name.to_owned(),
            false => self.source(&self.base.join(name))?,
        };
        Some(PlannedScene { name: name.to_owned(), source, cameras: cameras? })
    }

    /// The scene files of a folder, by name.
    fn scenes_of(&mut self, folder: &Path, cameras: Option<&Cameras>) -> Option<Vec<PlannedScene>> {
        let shown = folder.display();
        let listed = std::fs::read_dir(folder).and_then(|entries| {
            entries.map(|entry| entry.map(|entry| entry.path())).collect::<std::io::Result<Vec<PathBuf>>>()
        });
        let mut files = match listed {
            Ok(files) => files,
            Err(error) => return self.refuse(format!("--scenes: cannot read {shown}: {error}")),
        };
        let is_scene = |file: &PathBuf| file.extension().is_some_and(|end| end == "glb" || end == "gltf");
        files.retain(is_scene);
        files.sort();
        if files.is_empty() {
            return self.refuse(format!("--scenes: {shown} has no file that ends in .glb or .gltf"));
        }
        let cameras = cameras?;
        let scene = |file: &PathBuf| {
            let source = self.source(file)?;
            let name = file.file_name()?.to_str()?.to_owned();
            Some(PlannedScene { name, source, cameras: cameras.clone() })
        };
        files.iter().map(scene).collect()
    }

    /// A file's absolute path, since commands run in folders of their own.
    fn source(&mut self, file: &Path) -> Option<String> {
        let absolute = match std::path::absolute(file) {
            Ok(absolute) => absolute,
            Err(error) => return self.refuse(format!("scenes: {}: {error}", file.display())),
        };
        match absolute.to_str() {
            Some(path) => Some(path.to_owned()),
            None => self.refuse(format!("scenes: the name of {} is not UTF-8; rename it", file.display())),
        }
    }

    /// A command by a table of options, `first` being what it is for.
    fn planned<T>(
        &mut self,
        name: &str,
        place: &str,
        table: &Table,
        first: String,
        parser: &Parser<T>,
    ) -> Option<Planned<T>> {
        let words = words(table, place, &parser.command, &mut self.problems);
        let line = [[first, format!("--out={name}")].as_slice(), &words].concat();
        match (parser.options)(&line) {
            Ok(options) => Some(Planned { name: name.to_owned(), words, options }),
            Err(error) => self.refuse(format!("{place}: {}", sentence(&error))),
        }
    }

    fn replay(&mut self, name: &str, value: &Value) -> Option<Planned<ReplayOptions>> {
        let place = format!("[replay.{}]", one_line(name, SHOWN));
        let is_plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
        if name == RECORDING || name.is_empty() || name.len() > SHOWN || !name.chars().all(is_plain) {
            return self.refuse(format!(
                "{place}: expected a name of small letters, digits and '-', other than {RECORDING}"
            ));
        }
        let table = self.table(Some(value), &place);
        self.planned(name, &place, &table, format!("{RECORDING}.raydump"), &self.commands.replay)
    }
}

/// What stands in a list twice.
fn repeated<T: Ord>(list: &[T]) -> Option<&T> {
    let mut seen = BTreeSet::new();
    list.iter().find(|item| !seen.insert(*item))
}
