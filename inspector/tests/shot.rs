//! `inspector shot`, and that the other commands need no GPU.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, Output};

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

fn inspector(arguments: &[&str], dump: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
    command.arg(arguments[0]).arg(dump).args(&arguments[1..]);
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn every_view_is_a_picture_and_the_same_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    for view in [
        "window",
        "curve",
        "rays",
        "capsules",
        "compare",
        "cell",
        "table",
        "order",
        "coherence",
        "what-if",
        "timings",
        "rays-table",
        "ray",
    ] {
        let shot = |name: &str| {
            let file = folder.path().join(name);
            let out = file.to_str().unwrap();
            let arguments =
                ["shot", "--view", view, "--method", "aila", "--ray", "3", "--size", "640x400", "--out", out];
            let output = inspector(&arguments, &dump).output().unwrap();
            assert!(output.status.success(), "{view}: {}", text(&output));
            std::fs::read(file).unwrap()
        };
        let picture = shot("a.png");
        let info = png::Decoder::new(picture.as_slice()).read_info().unwrap();
        assert_eq!((info.info().width, info.info().height), (640, 400));
        assert!(picture == shot("b.png"), "{view} differs from one run to the next");
    }
}

/// A layout that was recorded gives the curve that was recorded.
#[test]
fn an_order_that_is_made_is_drawn_like_a_recorded_one() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let shot = |option: &str, value: &str| {
        let file = folder.path().join("x.png");
        let out = file.to_str().unwrap();
        let arguments =
            ["shot", "--view", "curve", option, value, "--ray", "3", "--size", "640x400", "--out", out];
        let output = inspector(&arguments, &dump).output().unwrap();
        assert!(output.status.success(), "{option} {value}: {}", text(&output));
        std::fs::read(file).unwrap()
    };
    let recorded = shot("--method", "mine");
    assert!(shot("--what-if", "(u v)*3 (ox oy oz ex ey ez)*5") == recorded);
    assert!(shot("--what-if", "origin") != recorded);
}

#[test]
fn what_a_recording_does_not_have_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let out = folder.path().join("x.png");
    for (option, value, expected) in [
        ("--bounce", "9", "bounce-09"),
        ("--method", "nope", "nope"),
        ("--ray", "100000", "100000"),
        ("--group", "999", "999"),
        ("--what-if", "(ox oq)*4", "unknown coordinate 'oq'"),
        ("--what-if", "light-octahedron", "only shadow rays have"),
        ("--filter", "bounse == 1", "did you mean 'bounce'?"),
    ] {
        let output =
            inspector(&["shot", option, value, "--out", out.to_str().unwrap()], &dump).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{option} {value}");
        assert!(text(&output).contains(expected), "{option} {value}: {}", text(&output));
    }
    let output = inspector(&["shot", "--size", "5x5", "--out", "x.png"], &dump).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

/// With all Vulkan drivers hidden, only what draws in a window fails, and says why.
#[cfg(target_os = "linux")]
#[test]
fn commands_without_pictures_need_no_gpu() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let hidden = |arguments: &[&str]| {
        let mut command = inspector(arguments, &dump);
        command.env("VK_DRIVER_FILES", "/dev/null").env("VK_ICD_FILENAMES", "/dev/null");
        command.output().unwrap()
    };
    for arguments in [
        &["info", "--metrics"][..],
        &["verify"],
        &["export", "--format", "ply", "--out", out],
        &["plot", "--out", out],
        &["report", "--out", out],
    ] {
        let output = hidden(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    }
    let output = hidden(&["shot", "--out", "x.png"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("GPU"), "{}", text(&output));
}
