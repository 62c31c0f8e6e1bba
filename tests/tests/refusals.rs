//! What cannot be done is refused with one clear sentence and the right exit code.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::Path;

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};
use tests::programs::{FAILED, Program, USAGE, finish};
use tests::recordings::SMALL;
use tests::scene_files::{glb, triangle_bytes, triangle_json};

fn refuses_options(scene: &str, options: &str, code: i32, words: &[&str]) {
    let folder = tempdir().unwrap();
    let outcome = Program::Recorder.run(folder.path(), &format!("record {scene} --out x.raydump {options}"));
    outcome.failed_with(code, words);
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.is_empty(), "{scene} {options} left {left:?} behind");
}

/// Puts `bytes` into a file and expects that recording it fails with a sentence that has `words`.
fn refuses_file(name: &str, bytes: &[u8], words: &[&str]) {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join(name), bytes).unwrap();
    let line = format!("record {name} --out x.raydump --backend cpu {SMALL}");
    let mut expected = vec![name];
    expected.extend(words);
    Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &expected);
}

/// The same for the triangle scene after `edit`.
fn refuses_scene(edit: impl Fn(&mut Value, &mut Vec<u8>), words: &[&str]) {
    let mut json = triangle_json();
    let mut bytes = triangle_bytes();
    edit(&mut json, &mut bytes);
    refuses_file("broken.glb", &glb(&json, &bytes), words);
}

/// A sentence is said once, whatever error wraps it.
#[test]
fn what_is_wrong_is_said_once() {
    let folder = tempdir().unwrap();
    for (line, sentence) in [
        ("record builtin:cornell --out x --methods nope", "nope"),
        ("record builtin:cornell --out x --method mine=(ox~oq)*2", "found"),
        ("record builtin:nothing --out x", "nothing"),
        ("record builtin:cornell --out x --table-method nope", "nope"),
        ("record none.glb --out x", "none.glb"),
        ("replay none.raydump --out x", "none.raydump"),
    ] {
        let outcome = Program::Recorder.run(folder.path(), line);
        let said = outcome.stderr.matches(sentence).count();
        assert_eq!(said, 1, "{line}: {}", outcome.stderr);
    }
}

#[test]
fn the_triangle_itself_is_fine() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("triangle.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    let line = format!("record triangle.glb --out x.raydump --backend cpu --repeats 1 --json {SMALL}");
    let json = Program::Recorder.run(folder.path(), &line).succeeded().json();
    assert_eq!(json["scene"]["triangles"], 1);
}

#[test]
fn scenes_that_are_no_scene_files() {
    refuses_options("absent.glb", "", FAILED, &["absent.glb"]);
    refuses_options("builtin:nowhere", "", FAILED, &["nowhere", "cornell"]);
    refuses_options("builtin:cornell?triangles=0", "", FAILED, &["0 triangles"]);
    refuses_options("builtin:cornell?size=3", "", FAILED, &["size"]);
    refuses_file("empty.glb", b"", &["empty"]);
    refuses_file("noise.glb", b"this is not a scene at all", &["glTF"]);
    let folder = tempdir().unwrap();
    fs::create_dir(folder.path().join("folder.glb")).unwrap();
    let outcome = Program::Recorder.run(folder.path(), "record folder.glb --out x.raydump");
    outcome.failed_with(FAILED, &["folder.glb", "found a folder"]);
}

#[test]
fn files_that_were_cut_or_lie() {
    let whole = glb(&triangle_json(), &triangle_bytes());
    for length in [11, 19, whole.len() / 2, whole.len() - 1] {
        refuses_file("cut.glb", &whole[..length], &[]);
    }
    refuses_file("cut.glb", &whole[..whole.len() / 2], &["truncated"]);
    let mut lying = whole;
    lying[12..16].copy_from_slice(&0x7fff_fff0u32.to_le_bytes());
    refuses_file("lying.glb", &lying, &["chunk", "2147483632"]);
}

#[test]
fn geometry_that_cannot_be_traced() {
    refuses_scene(|_, bytes| bytes[40] = 77, &["index", "77", "3 vertices"]);
    refuses_scene(|_, bytes| bytes[16..20].copy_from_slice(&f32::NAN.to_le_bytes()), &["vertex 1", "NaN"]);
    refuses_scene(
        |_, bytes| bytes[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes()),
        &["vertex 1", "inf"],
    );
    refuses_scene(|json, _| json["scenes"][0]["nodes"] = json!([1]), &["no triangles"]);
    refuses_scene(|json, _| json["accessors"][0]["count"] = json!(4_000_000_000u32), &["accessor 0"]);
}

#[test]
fn parts_that_are_missing() {
    refuses_scene(|json, _| json["buffers"][0]["uri"] = json!("absent.bin"), &["absent.bin"]);
    let with_image = |json: &mut Value, _: &mut Vec<u8>| {
        json["images"] = json!([{ "uri": "absent.png" }]);
        json["textures"] = json!([{ "source": 0 }]);
        json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
    };
    refuses_scene(with_image, &["absent.png"]);
    refuses_scene(
        |json, _| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        &["KHR_draco_mesh_compression"],
    );
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("a.glb"), glb(&triangle_json(), &triangle_bytes())).unwrap();
    let far = "[[camera]]\nname = \"x\"\neye = [1e25, 0.0, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nyfov_degrees = 60.0\n";
    for (sidecar, words) in [
        ("[[camera]]\nname = \"x\"\nfocus = 3\n", ["a.rayscope.toml", "focus"]),
        (far, ["the camera stands at [1e25, 0.0, 0.0]", "at most 1.15"]),
    ] {
        fs::write(folder.path().join("a.rayscope.toml"), sidecar).unwrap();
        Program::Recorder
            .run(folder.path(), "record a.glb --out x.raydump --backend cpu --camera x")
            .failed_with(FAILED, &words);
    }
}

#[test]
fn names_that_nobody_knows() {
    refuses_options("builtin:cornell", "--camera nobody", FAILED, &["nobody"]);
    refuses_options("builtin:cornell", "--methods aila,nobody", USAGE, &["nobody", "two-point"]);
    refuses_options("builtin:cornell", "--methods aila,aila", USAGE, &["aila", "twice"]);
    refuses_options("builtin:cornell", "--trace nobody", USAGE, &["nobody", "bvh2"]);
    refuses_options("builtin:cornell", "--keep rays,nobody", USAGE, &["nobody", "hits"]);
    refuses_options("builtin:cornell", "--camera auto-17", FAILED, &["auto-2 to auto-16"]);
    refuses_options("builtin:cornell", "--table-method two-point", USAGE, &["two-point"]);
    refuses_options("builtin:cornell", "--adapter nobody", FAILED, &["nobody"]);
    refuses_options("builtin:cornell", "--backend nobody", USAGE, &["nobody", "cpu"]);
    refuses_options("builtin:cornell", "--method mine=(ox", USAGE, &["mine"]);
    refuses_options("builtin:cornell", "--nobody", USAGE, &["nobody"]);
    refuses_options("builtin:cornell", "--backend cpu --trace ray-query", USAGE, &["ray-query"]);
}

#[test]
fn numbers_that_make_no_sense() {
    for option in ["width", "height", "bounces", "passes", "repeats", "threads"] {
        refuses_options("builtin:cornell", &format!("--{option} 0"), USAGE, &[option, "0"]);
    }
    refuses_options("builtin:cornell", "--key-bits 7", USAGE, &["key-bits", "8"]);
    refuses_options("builtin:cornell", "--key-bits 65", USAGE, &["key-bits", "64"]);
    refuses_options("builtin:cornell", "--key-bits 8,16", USAGE, &["key-bits", "one number", "replay"]);
    refuses_options("builtin:cornell", "--table-bits 25", USAGE, &["table-bits", "24"]);
    refuses_options("builtin:cornell", "--width -3", USAGE, &["-3"]);
    #[cfg(target_os = "linux")]
    refuses_options("builtin:cornell", "--backend cpu --pin --threads 1025", USAGE, &["1025", "--pin"]);
    refuses_options("builtin:cornell", "--width 60000 --height 60000 --bounces 9", USAGE, &["2^32"]);
}

#[test]
fn pictures_that_do_not_fit() {
    let huge = "--width 65535 --height 65535 --bounces 1 --passes 1";
    refuses_options("builtin:cornell", &format!("{huge} --backend cpu"), FAILED, &["65535", "memory", "MiB"]);
    refuses_options("builtin:cornell", &format!("{huge} --backend gpu"), FAILED, &["65535", "MiB"]);
}

fn folder_with_recording() -> TempDir {
    let folder = tempdir().unwrap();
    let line = format!(
        "record builtin:cornell --out x.raydump --backend cpu --repeats 1 --methods unsorted {SMALL}"
    );
    Program::Recorder.run(folder.path(), &line).succeeded();
    folder
}

#[test]
fn an_output_that_exists_is_only_replaced_by_force() {
    let folder = folder_with_recording();
    let line = format!(
        "record builtin:cornell --out x.raydump --backend cpu --repeats 1 --methods unsorted {SMALL}"
    );
    let before = fs::read(folder.path().join("x.raydump/manifest.bin")).unwrap();
    Program::Recorder.run(folder.path(), &line).failed_with(FAILED, &["x.raydump", "exists", "--force"]);
    assert_eq!(
        before,
        fs::read(folder.path().join("x.raydump/manifest.bin")).unwrap(),
        "the refused run changed the recording"
    );
    Program::Recorder.run(folder.path(), &format!("{line} --force")).succeeded();
    fs::write(folder.path().join("precious.raydump"), "not a recording").unwrap();
    let line = line.replace("x.raydump", "precious.raydump");
    Program::Recorder
        .run(folder.path(), &format!("{line} --force"))
        .failed_with(FAILED, &["precious.raydump"]);
    assert_eq!(fs::read_to_string(folder.path().join("precious.raydump")).unwrap(), "not a recording");
}

/// Copies the recorder to where every user may run it.
fn recorder_for_everyone(folder: &Path) -> std::path::PathBuf {
    let copy = folder.join("recorder");
    fs::copy(Program::Recorder.path(), &copy).unwrap();
    fs::set_permissions(&copy, fs::Permissions::from_mode(0o755)).unwrap();
    copy
}

#[test]
fn a_folder_that_may_not_be_written_is_named() {
    let folder = tempdir().unwrap();
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    let mut command = Program::Recorder.command([
        "record",
        "builtin:cornell",
        "--backend",
        "cpu",
        "--out",
        "locked/x.raydump",
    ]);
    if fs::metadata(folder.path()).unwrap().uid() == 0 {
        // Root may write everywhere, so somebody else tries.
        const NOBODY: u32 = 65_534;
        let program = recorder_for_everyone(folder.path());
        let arguments: Vec<_> = command.get_args().map(ToOwned::to_owned).collect();
        command = std::process::Command::new(program);
        command.args(arguments).env("XDG_CACHE_HOME", folder.path()).uid(NOBODY).gid(NOBODY);
    }
    finish(command.current_dir(folder.path())).failed_with(FAILED, &["locked", "permission"]);
}

#[test]
fn a_hierarchy_that_cannot_be_kept_is_said() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("cache"), "not a folder").unwrap();
    let line = "record builtin:cornell --out x --backend cpu --width 16 --height 16 --bounces 1 --repeats 1";
    let run = |cache: &str| {
        let mut command = Program::Recorder.command(line.split(' ').chain(["--force"]));
        finish(command.current_dir(folder.path()).env("XDG_CACHE_HOME", folder.path().join(cache)))
            .succeeded()
    };
    let said = run("cache").stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("builds the hierarchy anew") && said.contains("cache/rayscope/bvh"), "{said}");
    assert!(!run("other").stdout.contains("anew"));
}

#[test]
fn recordings_that_cannot_be_read() {
    let folder = folder_with_recording();
    for command in ["info", "verify", "recover"] {
        Program::Inspector
            .run(folder.path(), &format!("{command} absent.raydump"))
            .failed_with(FAILED, &["absent.raydump"]);
        Program::Inspector.run(folder.path(), command).failed_with(USAGE, &[]);
    }
    Program::Inspector.run(folder.path(), "info .").failed_with(FAILED, &["manifest.bin"]);
    Program::Inspector.run(folder.path(), "nobody x.raydump").failed_with(USAGE, &["nobody"]);
    let rays = folder.path().join("x.raydump/pass-001/bounce-01/closest/rays.npy");
    let mut bytes = fs::read(&rays).unwrap();
    bytes[1000] ^= 4;
    fs::write(&rays, &bytes).unwrap();
    let outcome = Program::Inspector.run(folder.path(), "verify x.raydump");
    assert_eq!(outcome.code, Some(FAILED), "verify did not see a flipped bit: {}", outcome.stdout);
    let said = outcome.stdout + &outcome.stderr;
    assert!(said.contains("pass-001/bounce-01/closest/rays.npy"), "verify does not name the file: {said}");
}

/// A result that cannot be written is a sentence, not a panic.
#[cfg(target_os = "linux")]
#[test]
fn results_that_a_full_disk_does_not_take() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["scenes", "scenes --json", "bench sort --log2-n 10 --repeats 1 --backend cpu --json"] {
        let mut command = Program::Recorder.command(line.split(' '));
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        finish(command.current_dir(folder.path()).stdout(full))
            .failed_with(FAILED, &["cannot write to standard output", "No space left"]);
    }
}

/// What is said on the way to a result is no reason to lose it.
#[cfg(target_os = "linux")]
#[test]
fn benchmarks_that_nobody_hears_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let small = "builtin:cornell --width 16 --height 16 --bounces 1 --methods aila";
    for line in [
        format!("bench error {small} --only precision"),
        format!("bench capture {small}"),
        format!("bench render {small} --passes 1"),
        "bench growth --only triangles --triangles 38,100".to_owned(),
    ] {
        let line = format!("{line} --repeats 1 --backend cpu --json");
        let mut command = Program::Recorder.command(line.split(' '));
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        finish(command.current_dir(folder.path()).stderr(full)).succeeded();
    }
}
