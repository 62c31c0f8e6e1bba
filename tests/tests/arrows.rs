//! Holds the arrows between the packages: who may depend on whom, and on what.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::{BTreeMap, BTreeSet};

use tests::sources::{files, root};

/// `package → packages of ours that it may depend on`.
const ARROWS: [(&str, &[&str]); 5] = [
    ("formats", &[]),
    ("scenes", &[]),
    ("recorder", &["formats", "scenes"]),
    ("inspector", &["formats"]),
    ("tests", &["formats", "inspector", "recorder", "scenes"]),
];

/// `crate → its rooms, lowest first`: a room is a file or folder right below `src`, and names those before it
/// alone. The crate's root, which names them all, and its `main.rs` are no rooms.
const ROOMS: [(&str, &str); 4] = [
    (
        "formats",
        "length_table pages prefetch permutation ray intersect text npy unit_space key manifest folder queue_check read_error \
         array_file files writer reader recover holes hierarchy stored_table traced metrics auto bench_result summary \
         study verify",
    ),
    (
        "scenes",
        "bounds camera features hash material memory shown light scene base_colour automatic files brightness bvh \
         sidecar builtin gltf load views",
    ),
    (
        "recorder",
        "clock device stages oracle cache_model options machine backends output progress interrupt auto wavefront \
         foreign measure calibrate capture comparison observer recording replay bench report study cli",
    ),
    (
        "inspector",
        "shown png_file recent arguments output colour_map filter analysis figures method_table inputs report \
         info verify recover plot theme model export session render panels app shot cli",
    ),
];

/// What `formats` never reaches, through any crate: a GPU, a window, a scene file.
const NOT_IN_FORMATS: [&str; 7] = ["wgpu", "naga", "ash", "winit", "egui", "gltf", "obvhs"];

/// What `scenes` never reaches: it is CPU only and knows no dump.
const NOT_IN_SCENES: [&str; 6] = ["wgpu", "naga", "ash", "winit", "egui", "bincode"];

fn parse(path: &str) -> toml::Table {
    let text = std::fs::read_to_string(root().join(path))
        .unwrap_or_else(|error| panic!("cannot read {path}: {error}"));
    text.parse().unwrap_or_else(|error| panic!("cannot parse {path}: {error}"))
}

fn members() -> Vec<String> {
    let manifest = parse("Cargo.toml");
    let members = manifest["workspace"]["members"].as_array().unwrap();
    members.iter().map(|member| member.as_str().unwrap().to_owned()).collect()
}

/// Names of all dependencies in a manifest: normal, development and build ones, of every target.
fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (key, value) in manifest {
        let Some(table) = value.as_table() else { continue };
        match key.as_str() {
            "dependencies" | "dev-dependencies" | "build-dependencies" => {
                for (name, wanted) in table {
                    // A renamed dependency says its real name in `package`.
                    let package = wanted.get("package").and_then(toml::Value::as_str);
                    names.insert(package.unwrap_or(name).to_owned());
                }
            }
            "target" => {
                for target in table.values().filter_map(toml::Value::as_table) {
                    names.extend(dependencies(target));
                }
            }
            _ => {}
        }
    }
    names
}

/// `package → all packages it reaches`, from the lock file; two versions of a crate count as one name.
fn reached_from(package: &str) -> BTreeSet<String> {
    let lock = parse("Cargo.lock");
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for entry in lock["package"].as_array().unwrap() {
        let next = entry.get("dependencies").and_then(toml::Value::as_array).into_iter().flatten();
        // An entry is `name`, or `name version` where there are several versions.
        let next = next.map(|text| text.as_str().unwrap().split(' ').next().unwrap().to_owned());
        edges.entry(entry["name"].as_str().unwrap().to_owned()).or_default().extend(next);
    }
    assert!(edges.contains_key(package), "Cargo.lock has no package {package}");
    let mut reached = BTreeSet::new();
    let mut waiting = vec![package.to_owned()];
    while let Some(name) = waiting.pop() {
        for next in edges.get(&name).into_iter().flatten() {
            if reached.insert(next.clone()) {
                waiting.push(next.clone());
            }
        }
    }
    reached
}

#[test]
fn packages_depend_on_each_other_as_the_arrows_say() {
    let members = members();
    let known: BTreeSet<&str> = ARROWS.iter().map(|(package, _)| *package).collect();
    assert_eq!(
        members.iter().map(String::as_str).collect::<BTreeSet<_>>(),
        known,
        "a package without a row in ARROWS"
    );
    for (package, allowed) in ARROWS {
        let found = dependencies(&parse(&format!("{package}/Cargo.toml")));
        for other in found.iter().filter(|name| members.contains(name)) {
            assert!(
                allowed.contains(&other.as_str()),
                "{package} depends on {other}; it may depend on {allowed:?} alone"
            );
        }
    }
    let recorder = dependencies(&parse("recorder/Cargo.toml"));
    assert!(
        recorder.contains("formats") && recorder.contains("scenes"),
        "reading dependencies found only {recorder:?}"
    );
}

#[test]
fn formats_and_scenes_reach_nothing_beyond_their_part() {
    for (package, forbidden) in [("formats", &NOT_IN_FORMATS[..]), ("scenes", &NOT_IN_SCENES[..])] {
        let reached = reached_from(package);
        assert!(reached.len() > 5, "{package} reaches only {reached:?}: the lock file was not read right");
        for name in forbidden {
            assert!(!reached.contains(*name), "{package} reaches {name}");
        }
    }
    let recorder = reached_from("recorder");
    assert!(
        recorder.contains("wgpu") && recorder.contains("gltf"),
        "the recorder's reach was not read right: {recorder:?}"
    );
}

#[test]
fn bincode_stays_inside_the_manifest() {
    for (package, _) in ARROWS {
        let has_bincode = dependencies(&parse(&format!("{package}/Cargo.toml"))).contains("bincode");
        assert_eq!(has_bincode, package == "formats", "whether {package} depends on bincode");
    }
    let users: Vec<String> = files("formats/src", "rs")
        .into_iter()
        .filter(|source| source.text.lines().any(|line| line.split("//").next().unwrap().contains("bincode")))
        .map(|source| source.path)
        .collect();
    assert!(!users.is_empty(), "nothing in formats uses bincode: drop it, and this test");
    for path in users {
        assert!(
            path.starts_with("formats/src/manifest"),
            "{path} uses bincode; it belongs to formats::manifest alone"
        );
    }
}

#[test]
fn the_loop_names_no_backend() {
    let source =
        files("recorder/src", "rs").into_iter().find(|source| source.path == "recorder/src/wavefront.rs");
    let text = source.expect("recorder/src/wavefront.rs is the loop").text;
    for (index, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap();
        for backend in ["wgpu", "gpu::", "cpu::", "rayon"] {
            assert!(
                !code.contains(backend),
                "wavefront.rs:{} names a backend ({backend}): {line}",
                index + 1
            );
        }
    }
}

/// The code of a file without its comments and what only tests see.
fn code(text: &str) -> String {
    let mut kept = Vec::new();
    let mut lines = text.lines().map(|line| line.split("//").next().unwrap());
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push(line);
            continue;
        }
        // The item that follows is a line, or ends with a brace as far indented as the attribute.
        if !lines.next().unwrap().trim_end().ends_with(';') {
            let end = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            let _ = lines.find(|line| line.trim_end() == end);
        }
    }
    kept.join("\n")
}

/// The module of a file below `src`: `["stages", "trace", "gpu"]`. The root has none.
fn module<'a>(path: &'a str, package: &str) -> Vec<&'a str> {
    let inside = path.strip_prefix(&format!("{package}/src/")).unwrap().strip_suffix(".rs").unwrap();
    let mut names: Vec<&str> = inside.split('/').collect();
    if matches!(names.last(), Some(&("mod" | "lib" | "main"))) {
        names.pop();
    }
    names
}

fn first_name(path: &str) -> &str {
    path.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next().unwrap_or_default()
}

/// The first name of a path, or of each path of a list in braces.
fn first_names(path: &str) -> Vec<&str> {
    let Some(list) = path.strip_prefix('{') else { return vec![first_name(path)] };
    let (mut names, mut depth) = (Vec::new(), 0);
    for part in list.split_inclusive([',', '{', '}']) {
        if depth == 0 {
            names.push(first_name(part.trim_start()));
        }
        depth += i32::from(part.ends_with('{')) - i32::from(part.ends_with('}'));
        if depth < 0 {
            break;
        }
    }
    names
}

#[test]
fn lists_of_paths_name_each_room() {
    assert_eq!(first_names("a::b;"), ["a"]);
    assert_eq!(first_names("{a, b::{c, d}, e::f};\nuse g"), ["a", "b", "", "e"]);
}

#[test]
fn rooms_name_only_those_below_them() {
    for (package, rooms) in ROOMS {
        let rooms: Vec<&str> = rooms.split_whitespace().collect();
        let sources = files(&format!("{package}/src"), "rs");
        let mut seen = BTreeSet::new();
        for source in &sources {
            let module = module(&source.path, package);
            // Files of tests, which a `#[cfg(test)]` declares.
            let is_test = module.last().is_some_and(|name| *name == "tests" || name.starts_with("test_"));
            let Some(&room) = module.first().filter(|_| !is_test) else { continue };
            let level = rooms.iter().position(|known| *known == room);
            let level = level.unwrap_or_else(|| panic!("{}: {room} has no place in ROOMS", source.path));
            seen.insert(room);
            let code = code(&source.text).replace(&"super::".repeat(module.len()), "crate::");
            for (at, _) in code.match_indices("crate::") {
                for named in first_names(&code[at + "crate::".len()..]) {
                    let is_above = rooms.iter().skip(level + 1).any(|above| *above == named);
                    assert!(!is_above, "{}: {room} names {named}, a room above it", source.path);
                }
            }
        }
        assert_eq!(seen, rooms.iter().copied().collect(), "the rooms of {package}");
    }
}

#[test]
fn panels_do_not_reach_into_each_other() {
    let sources = files("inspector/src/panels", "rs");
    let module = |path: &str| {
        let inside = path.strip_prefix("inspector/src/panels/").unwrap();
        inside.split(['/', '.']).next().unwrap().to_owned()
    };
    let is_panel = |text: &str| code(text).contains("impl Panel for");
    let panels: BTreeSet<String> =
        sources.iter().filter(|source| is_panel(&source.text)).map(|source| module(&source.path)).collect();
    assert!(panels.len() >= 10 && panels.contains("scene"), "panels were not found: {panels:?}");
    for source in &sources {
        let own = module(&source.path);
        if own == "mod" {
            continue;
        }
        for other in panels.iter().filter(|other| **other != own) {
            for reach in [format!("super::{other}::"), format!("panels::{other}::")] {
                assert!(
                    !code(&source.text).contains(&reach),
                    "{} reaches into the panel {other}",
                    source.path
                );
            }
        }
    }
}

#[test]
fn colours_stand_in_the_theme_alone() {
    let mut seen = 0;
    for source in files("inspector/src", "rs") {
        let is_window = ["app", "panels", "render", "model"]
            .iter()
            .any(|folder| source.path.starts_with(&format!("inspector/src/{folder}/")));
        if !is_window {
            continue;
        }
        seen += 1;
        let code = code(&source.text);
        for (at, _) in code.match_indices("Color32::") {
            let what = &code[at + "Color32::".len()..];
            let named = what.starts_with(|first: char| first.is_ascii_uppercase());
            let digits = what.split_once('(').is_some_and(|(name, values)| {
                name.starts_with("from_")
                    && values.trim_start().starts_with(|first: char| first.is_ascii_digit())
            });
            assert!(!named && !digits, "{} has a colour of its own: Color32::{:.40}", source.path, what);
        }
    }
    assert!(seen > 40, "only {seen} files of the window were read");
}
