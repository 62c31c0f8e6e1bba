//! The same command gives the same bytes, and what is measured changes nothing else.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use formats::npy::{self, Dtype};
use tempfile::tempdir;
use tests::programs::{Program, finish};
use tests::recordings::{arrays, assert_same, differing, record, without_methods};

const SCENE: &str = "builtin:atrium?triangles=4000";

/// Records once for every one of `variants` (options) and gives the image hash and arrays of each.
fn recordings(variants: &[&str]) -> Vec<(String, BTreeMap<String, Vec<u8>>)> {
    let folder = tempdir().unwrap();
    let one = |(number, options): (usize, &&str)| {
        let name = format!("variant-{number}");
        let json = record(folder.path(), &name, SCENE, options);
        let hash = json["image"]["sha256"].as_str().expect("--json has the image's hash").to_owned();
        (hash, arrays(&folder.path().join(name + ".raydump")))
    };
    variants.iter().enumerate().map(one).collect()
}

fn the_same_command_twice(backend: &str) {
    let mut found = recordings(&[backend, backend]);
    // Its choice follows from a calibration, which is a measurement: a replay that takes it over repeats it.
    found.iter_mut().for_each(|(_, arrays)| arrays.retain(|path, _| !path.contains("/auto/")));
    assert!(found[0].1.len() > 40, "the recording has only {:?}", found[0].1.keys());
    assert_same(&found[0].1, &found[1].1, backend);
}

#[test]
fn the_same_command_on_threads_gives_the_same_bytes() {
    the_same_command_twice("--backend cpu --repeats 1");
}

#[test]
fn the_same_command_on_the_gpu_gives_the_same_bytes() {
    the_same_command_twice("--backend gpu --repeats 1");
}

/// Whatever `variants` measure, picture and method-independent arrays are those of the first.
fn nothing_else_changes(variants: &[&str]) {
    let mut found = recordings(variants).into_iter();
    let (hash, first) = found.next().unwrap();
    let first = without_methods(first);
    for ((other_hash, other), options) in found.zip(&variants[1..]) {
        assert_eq!(hash, other_hash, "image hash with {options}");
        assert_same(&first, &without_methods(other), options);
    }
}

#[test]
fn methods_repeats_and_threads_change_nothing_else() {
    nothing_else_changes(&[
        "--backend cpu --repeats 1 --threads 2",
        "--backend cpu --repeats 1 --threads 1 --methods unsorted",
        "--backend cpu --repeats 3 --threads 3 --methods two-point-adaptive,costa --key-bits 64",
    ]);
}

#[test]
fn methods_and_repeats_change_nothing_else_on_the_gpu() {
    nothing_else_changes(&[
        "--backend gpu --repeats 1",
        "--backend gpu --repeats 1 --methods unsorted",
        "--backend gpu --repeats 2 --methods two-point-adaptive,costa --key-bits 64",
    ]);
}

#[test]
fn hierarchies_on_threads_find_the_same_hits() {
    let cwbvh = "--backend cpu --repeats 1 --methods unsorted --trace cwbvh";
    let bvh2 = "--backend cpu --repeats 1 --methods unsorted --trace bvh2";
    let mut found = recordings(&[cwbvh, bvh2]);
    // What a hierarchy costs, and which occluder a shadow ray meets first, is its own.
    for (_, arrays) in &mut found {
        arrays.retain(|path, _| !path.ends_with("/work.npy") && !path.contains("/shadow/"));
    }
    assert_eq!(found[0].0, found[1].0, "image hash");
    assert_same(&found[0].1, &found[1].1, "cwbvh and bvh2");
}

#[test]
fn another_seed_gives_another_picture() {
    let found = recordings(&["--backend cpu --repeats 1 --seed 0", "--backend cpu --repeats 1 --seed 1"]);
    assert_ne!(found[0].0, found[1].0, "image hash of two seeds");
    let different = differing(&found[0].1, &found[1].1);
    assert!(different.contains(&"pass-001/bounce-00/closest/rays.npy"), "only {different:?} differ");
    assert!(!different.contains(&"scene/positions.npy"), "the seed changed the scene");
}

/// The commands that a report gives, run somewhere else: the same options and, but for `auto`, the same arrays.
#[test]
fn a_report_says_how_its_recordings_are_repeated() {
    let [folder, other] = [tempdir().unwrap(), tempdir().unwrap()];
    let (here, there) = (folder.path(), other.path());
    let rays: Vec<[f32; 6]> = (0..50).map(|ray| [0.1, 0.2, 0.1, 0.3, 1.0, ray as f32 * 0.1 - 2.0]).collect();
    let npy = [&npy::header(Dtype::F4, &[50, 6]), bytemuck::cast_slice::<_, u8>(&rays)].concat();
    [here, there].iter().for_each(|folder| fs::write(folder.join("rays.npy"), &npy).unwrap());
    const DEVICE: &str = "--backend cpu --threads 1 --repeats 1";
    for line in [
        "record builtin:cornell --out paths --width 24 --height 16 --bounces 3 --passes 2 --russian-roulette \
         --methods aila,auto,shuffled,control --method mine=(ox+oy+oz)*4 --keep rays,hits,keys,lengths,scene,caches \
         --l2-kib 64",
        "replay paths.raydump --out again --methods two-point,origin --key-bits 16,24 --keep keys",
        "replay paths.raydump --out split --methods two-point --method learnt=(ox+oy+oz+ex+ey+ez)*4+@adaptive \
         --split 4,10 --keep keys",
        "import --scene builtin:cornell --rays rays.npy --kind shadow --bounce 2 --size 10x5 --out theirs --methods aila,auto \
         --key-bits 16 --keep rays,scene",
    ] {
        let words = line.split_whitespace().chain(DEVICE.split_whitespace());
        let words = words.map(|word| word.replace('+', " "));
        finish(Program::Recorder.command(words).current_dir(here)).succeeded();
    }
    let names = ["paths", "again", "split", "theirs"].map(|name| format!("{name}.raydump"));
    Program::Inspector.run(here, &format!("report {} --out page", names.join(" "))).succeeded();
    let page = fs::read_to_string(here.join("page/report.html")).unwrap();
    let (_, commands) = page.split_once("How to repeat it</h2>\n<pre><code>").unwrap();
    let commands = commands.split_once("</code>").unwrap().0.replace("&#39;", "'").replace("&amp;", "&");
    for (command, name) in commands.lines().zip(&names) {
        let command = command.replace("SCENE", "builtin:cornell");
        let again = command.replacen("recorder", Program::Recorder.path().to_str().unwrap(), 1);
        finish(Command::new("sh").args(["-c", &again]).current_dir(there)).succeeded();
        let said = |folder| Program::Inspector.run(folder, &format!("info {name} --json")).succeeded().json();
        // What follows `auto` is left out: the first model of a recording is that of unsorted rays.
        for what in ["/options", "/caches/0"] {
            assert_eq!(said(here).pointer(what), said(there).pointer(what), "{command}");
        }
        let kept = |folder: &std::path::Path| {
            let mut arrays = arrays(&folder.join(name));
            arrays.retain(|path, _| !path.contains("/auto/"));
            arrays
        };
        assert_same(&kept(here), &kept(there), &command);
    }
    let last = commands.lines().nth(names.len()).unwrap();
    assert!(
        last.starts_with("inspector report") && commands.lines().count() == names.len() + 1,
        "{commands}"
    );
}
