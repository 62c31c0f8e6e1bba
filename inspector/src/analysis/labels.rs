//! What recordings are called beside each other.

use std::collections::BTreeMap;

use formats::manifest::{Header, Source};
use formats::reader::Dump;
use formats::summary::hexadecimal;

use crate::shown;

/// Hexadecimal digits of a scene's hash that tell two scenes of one name apart.
const HASH_DIGITS: usize = 8;

/// A label for each recording, all different, whose names are short enough to be shown: its scene's name, then as much of what differs among the
/// recordings of that name (content, camera, replay, machine, kernel, threads, size, …) as it takes to tell
/// them apart; if nothing does, its folder's name, which may stand for the scene's.
pub fn labels(dumps: &[Dump]) -> Vec<String> {
    let folder = |dump: &Dump| {
        let name = dump.root().file_name();
        name.map_or_else(|| dump.root().display().to_string(), |name| name.to_string_lossy().into_owned())
    };
    let facts = |dump: &Dump| {
        let header = shown::header(&dump.manifest().header);
        let folder = shown::name(&folder(dump));
        Facts { scene: scene_name(&header.scene.name).to_owned(), details: details(&header, &folder), folder }
    };
    distinct(&dumps.iter().map(facts).collect::<Vec<_>>())
}

/// What a recording's times depend on besides scene and method.
pub fn configuration(header: &Header) -> String {
    let options = &header.options;
    let mut parts = vec![header.backend.name().to_owned(), header.adapter.name.clone()];
    parts.push(options.trace_kernel.clone());
    if options.threads > 0 {
        parts.push(threads(options.threads));
    }
    parts.join(", ")
}

fn threads(threads: u32) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

/// A scene: its name as [`scene_name`] has it, and the hash of what is in it. Two scenes may share a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Scene<'a> {
    pub(super) name: &'a str,
    pub(super) content_hash: &'a str,
}

/// A file is known by its name without folder and extension, a built-in scene by its name.
pub fn scene_name(scene: &str) -> &str {
    let name = scene.rsplit(['/', '\\']).next().unwrap_or(scene).trim_start_matches("builtin:");
    let stem = [".gltf", ".glb"].iter().find_map(|extension| name.strip_suffix(extension));
    stem.unwrap_or(name)
}

/// The name of a scene beside others: with some of its hash where they share it.
pub(super) fn scene_label(scene: Scene<'_>, others: &[Scene<'_>]) -> String {
    let Scene { name, content_hash } = scene;
    match others.iter().filter(|other| other.name == name).count() {
        0 | 1 => name.to_owned(),
        _ => format!("{name} ({})", content_hash.get(..HASH_DIGITS).unwrap_or(content_hash)),
    }
}

/// What may tell recordings of one scene apart, the most telling first.
fn details(header: &Header, folder: &str) -> Vec<String> {
    let options = &header.options;
    let replay = match header.source {
        Source::Replayed { .. } => format!("replay {}", folder.trim_end_matches(".raydump")),
        Source::Traced | Source::Imported { .. } => String::new(),
    };
    vec![
        hexadecimal(&header.scene.content_hash)[..HASH_DIGITS].to_owned(),
        format!("camera {}", options.camera),
        replay,
        header.backend.name().to_owned(),
        header.adapter.name.clone(),
        options.trace_kernel.clone(),
        if options.threads > 0 { threads(options.threads) } else { String::new() },
        format!("{}×{}", options.width, options.height),
        format!("{}-bit keys", options.key_bits),
        format!("seed {}", options.seed),
    ]
}

/// What a label is made of.
struct Facts {
    scene: String,
    details: Vec<String>,
    folder: String,
}

fn distinct(facts: &[Facts]) -> Vec<String> {
    let mut scenes: BTreeMap<&str, Vec<&Facts>> = BTreeMap::new();
    for fact in facts {
        scenes.entry(&fact.scene).or_default().push(fact);
    }
    let mut labels: Vec<String> =
        facts.iter().map(|fact| label(fact, &scenes[fact.scene.as_str()])).collect();
    let by_folder = |label: &str, fact: &Facts, _: usize| {
        let folder = fact.folder.trim_end_matches(".raydump");
        if folder.contains(&fact.scene) { folder.to_owned() } else { format!("{label}, {folder}") }
    };
    let by_number = |label: &str, _: &Facts, at: usize| format!("{label}, #{}", at + 1);
    for unlike in [&by_folder as &dyn Fn(&str, &Facts, usize) -> String, &by_number] {
        let taken = labels.clone();
        for (at, label) in labels.iter_mut().enumerate() {
            if taken.iter().filter(|other| *other == label).count() > 1 {
                *label = unlike(label, &facts[at], at);
            }
        }
    }
    labels
}

/// A recording's label among those of its scene.
fn label(fact: &Facts, same_scene: &[&Facts]) -> String {
    let telling = |fact: &Facts, details: usize| -> Vec<String> {
        let differs = |at: &usize| same_scene.iter().any(|other| other.details[*at] != fact.details[*at]);
        let telling = (0..details).filter(differs).map(|at| fact.details[at].clone());
        telling.filter(|detail| !detail.is_empty()).collect()
    };
    let all = fact.details.len();
    let are_told_apart = |details: &usize| {
        let mut labels: Vec<Vec<String>> = same_scene.iter().map(|fact| telling(fact, *details)).collect();
        labels.sort_unstable();
        labels.windows(2).all(|pair| pair[0] != pair[1])
    };
    let enough = (0..all).find(are_told_apart).unwrap_or(all);
    let telling = telling(fact, enough);
    if telling.is_empty() { fact.scene.clone() } else { format!("{} ({})", fact.scene, telling.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fact(scene: &str, details: &[&str], folder: &str) -> Facts {
        Facts {
            scene: scene.into(),
            details: details.iter().map(|&detail| detail.into()).collect(),
            folder: folder.into(),
        }
    }

    #[test]
    fn labels_say_what_differs_and_no_more() {
        let labels = distinct(&[
            fact("sponza", &["cpu", "bvh2", "1 thread"], "a"),
            fact("sponza", &["cpu", "cwbvh", "2 threads"], "b"),
            fact("kitchen", &["gpu", "cwbvh", ""], "c"),
        ]);
        assert_eq!(labels, ["sponza (bvh2)", "sponza (cwbvh)", "kitchen"]);
    }

    #[test]
    fn equal_recordings_go_by_folder_and_then_by_number() {
        let labels =
            distinct(&[fact("a", &["x"], "one"), fact("a", &["x"], "two"), fact("a", &["x"], "two")]);
        assert_eq!(labels, ["a, one", "a, two, #2", "a, two, #3"]);
        let named = ["kitchen-1.raydump", "kitchen-2.raydump"].map(|folder| fact("kitchen", &["x"], folder));
        assert_eq!(distinct(&named), ["kitchen-1", "kitchen-2"]);
    }
}
