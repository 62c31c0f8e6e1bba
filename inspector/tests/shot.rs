//! `inspector shot`, and that the other commands need no GPU.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use formats::key::method::AUTO;
use formats::manifest::Record;
use serde_json::Value;

mod on_disk;

use on_disk::{sample, written};

fn inspector(arguments: &[&str], dump: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
    command.arg(arguments[0]).arg(dump).args(&arguments[1..]);
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A shot of a recording into a file beside it.
fn shot(dump: &Path, arguments: &[&str]) -> Output {
    inspector(&["shot"], dump)
        .arg("--out")
        .arg(dump.with_file_name("x.png"))
        .args(arguments)
        .output()
        .unwrap()
}

/// The picture that it is, and what is printed.
fn drawn_and_said(dump: &Path, arguments: &[&str]) -> (Vec<u8>, Vec<u8>) {
    let output = shot(dump, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    let out = dump.with_file_name("x.png");
    let picture = std::fs::read(&out).unwrap();
    std::fs::remove_file(out).unwrap();
    (picture, output.stdout)
}

fn drawn(dump: &Path, arguments: &[&str]) -> Vec<u8> {
    drawn_and_said(dump, arguments).0
}

/// The picture, and what was drawn for it.
fn counted(dump: &Path, arguments: &[&str]) -> (Vec<u8>, Value) {
    let (picture, said) = drawn_and_said(dump, &[arguments, &["--json"]].concat());
    (picture, serde_json::from_slice(&said).unwrap())
}

fn assert_refused(dump: &Path, arguments: &[&str], code: i32, expected: &str) {
    let output = shot(dump, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    assert!(text(&output).contains(expected), "{arguments:?}: {}", text(&output));
}

/// A session of the sample beside it, as programs before wrote them.
fn session(dump: &Path, [method, ray, theme, panels]: [&str; 4]) -> PathBuf {
    let selection = format!(
        r#""recording": 0, "pass": 1, "bounce": 1, "kind": "closest", "method": "{method}",
            "group_width": "64", "ray": {ray}, "group": null, "cell": null"#
    );
    let text = format!(
        r#"{{ "version": 1, "recordings": ["sample.raydump"], "selection": {{ {selection} }},
            "theme": "{theme}", "layout": null, "panels": {{ {panels} }} }}"#
    );
    let file = dump.with_file_name("view.json");
    std::fs::write(&file, text).unwrap();
    file
}

/// What two pictures may differ by: words that stand upright are smoothed from where their letters lie among all that
/// were drawn, and those that are shown while something is read depend on how long that takes.
const UNSEEN: u8 = 1;

/// The bytes of a picture of 640 by 400.
fn pixels(picture: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(picture).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (640, 400));
    let mut bytes = vec![0; reader.output_buffer_size()];
    reader.next_frame(&mut bytes).unwrap();
    bytes
}

#[test]
fn every_view_is_a_picture_and_the_same_each_time() {
    let (_folder, dump) = written();
    for view in [
        "window",
        "order",
        "capsules",
        "cost",
        "table",
        "paths",
        "rays",
        "length-table",
        "pixels",
        "methods",
        "coherence",
        "what-if",
        "timings",
        "rays-table",
        "ray",
    ] {
        let arguments = ["--view", view, "--method", "aila", "--ray", "3", "--size", "640x400"];
        let [picture, again] = [(); 2].map(|()| pixels(&drawn(&dump, &arguments)));
        let differ = picture.iter().zip(&again).filter(|(a, b)| a.abs_diff(**b) > UNSEEN).count();
        assert_eq!(differ, 0, "{view} differs from one run to the next");
    }
}

/// A layout that was recorded gives the rays in the order that was recorded.
#[test]
fn an_order_that_is_made_is_drawn_like_a_recorded_one() {
    let (_folder, dump) = written();
    let by = |option: &str, value: &str| {
        drawn(&dump, &["--view", "rays", option, value, "--ray", "3", "--size", "640x400"])
    };
    let recorded = by("--method", "mine");
    assert!(by("--what-if", "(u v)*3 (ox oy oz ex ey ez)*5") == recorded);
    assert!(by("--what-if", "origin") != recorded);
}

#[test]
fn what_a_recording_does_not_have_is_said() {
    let (_folder, dump) = written();
    for (option, value, expected) in [
        ("--bounce", "9", "bounce-09"),
        ("--method", "nope", "nope"),
        ("--ray", "100000", "100000"),
        ("--set", "group=999", "999"),
        ("--what-if", "(ox oq)*4", "unknown coordinate 'oq'"),
        ("--what-if", "light-octahedron", "only shadow rays have"),
        ("--filter", "bounse == 1", "did you mean 'bounce'?"),
    ] {
        assert_refused(&dump, &[option, value], 1, expected);
    }
    assert_refused(&dump, &["--size", "5x5"], 2, "");
}

/// A camera as numbers and settings by name change the picture; draws are counted.
#[test]
fn what_is_drawn_is_set_and_counted() {
    let (_folder, dump) = written();
    let draw = |more: &[&str]| counted(&dump, &[&["--view", "rays", "--size", "320x240"], more].concat());
    let (usual, report) = draw(&[]);
    // Surfaces; rays and their marks, hidden and seen.
    let (draws, shown) = (&report["draws"], report["rays_shown"][0].as_u64().unwrap());
    assert_eq!((&draws["draw_calls"], shown > 0), (&5.into(), true));
    assert_eq!(draws["vertices"], 3 * sample::TRIANGLES.len() as u64 + 4 * 6 * shown);
    let uploaded = (12 * (sample::positions().len() + sample::TRIANGLES.len())) as u64 + 2 * 32 * shown;
    assert!(draws["uploaded_bytes"].as_u64().unwrap() >= uploaded, "{draws}");
    let memory = &report["memory"];
    assert!(memory["resident_bytes"].as_u64() >= memory["anonymous_bytes"].as_u64(), "{memory}");
    for more in [
        &["--camera", "0.5 0.25 0.375 1 -0.2 0.9"][..],
        &["--camera", "-0.5,0.25,0.375,1,-0.2,0.9,1.1"],
        &["--set", "mesh=wire"],
        &["--set", "clip_axis=x", "--set", "clip_at=0.5"],
        &["--set", "arrows=true"],
        &["--set", "scene.options.colour_by=key:ox", "--method", "aila"],
        &["--set", "group=2", "--set", "group_width=32"],
        &["--theme", "light"],
    ] {
        assert!(draw(more).0 != usual, "{more:?} changes nothing");
    }
    for (more, code, expected) in [
        (["--camera", "1 2 3"], 2, "target x, y, z, yaw, pitch, distance"),
        (["--set", "meshes=wire"], 1, "did you mean 'mesh'?"),
        (["--set", "mesh=wood"], 1, "wood"),
        (["--set", "colour_by=key:no"], 1, "ox, oy"),
        (["--recording", "7"], 1, "no recording 7"),
    ] {
        assert_refused(&dump, &[&["--view", "order"][..], &more].concat(), code, expected);
    }
}

/// Two views have their lines each, and the surfaces once: 11 corners, each with a colour, and 11 triangles.
#[test]
fn views_share_the_surfaces() {
    let (_folder, dump) = written();
    let uploaded = |both: &str| {
        let arguments = ["--view", "order", "--set", "mesh=ghost", "--size", "640x400", "--set", both];
        let (_, report) = counted(&dump, &arguments);
        report["draws"]["uploaded_bytes"].as_u64().unwrap()
    };
    let mesh = (16 * sample::positions().len() + 12 * sample::TRIANGLES.len()) as u64;
    assert_eq!(2 * uploaded("side_by_side=false") - uploaded("side_by_side=true"), mesh);
}

/// What panels show besides the selection is set by name.
#[test]
fn settings_of_panels_change_their_pictures() {
    let (_folder, dump) = written();
    let draw = |view: &str, settings: &[&str]| {
        let usual = ["--view", view, "--method", "two-point", "--size", "640x480"];
        let settings: Vec<&str> = settings.iter().flat_map(|setting| ["--set", *setting]).collect();
        drawn(&dump, &[&usual[..], &settings].concat())
    };
    for (view, settings) in [
        ("length-table", &["view=count"][..]),
        ("length-table", &["view=estimates"]),
        ("rays-table", &["sorted_by=length"]),
        ("rays-table", &["sorted_by=length", "descending=true"]),
        ("rays-table", &[r#"columns=["ray","area"]"#]),
        ("pixels", &["colouring=key"]),
    ] {
        let (last, before) = settings.split_last().unwrap();
        assert!(draw(view, settings) != draw(view, before), "{last} changes nothing of {view}");
    }
    for (view, setting, expected) in [
        ("length-table", "view=counts", "`count`, "),
        ("rays-table", "columns=[]", "at least one column"),
        ("rays-table", "sorted_by=lenght", "`length`"),
    ] {
        assert_refused(&dump, &["--view", view, "--set", setting], 1, expected);
    }
}

/// A session without the version's newest settings, with relative paths, as programs before wrote them; and the
/// same of another recording.
#[test]
fn a_session_is_drawn_with_changes_and_of_another_recording() {
    let (folder, dump) = written();
    let other = folder.path().join("other.raydump");
    std::fs::rename(&dump, &other).unwrap();
    let dump = sample::write(folder.path());
    let scene = r#""scene": { "options": { "rays": true, "colour_by": "estimate" }, "camera": null }"#;
    let file = session(&dump, ["aila", "3", "light", scene]);
    let out = folder.path().join("x.png");
    let draw = |dump: Option<&Path>, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_inspector"));
        command.arg("shot").args(dump).args(["--view", "order", "--size", "320x240", "--out"]).arg(&out);
        let output = command.args(more).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output));
        std::fs::read(&out).unwrap()
    };
    let session = ["--session", file.to_str().unwrap()];
    let drawn = draw(None, &session);
    let by_options =
        ["--bounce", "1", "--method", "aila", "--ray", "3", "--theme", "light", "--set", "rays=true"];
    // What is estimated over what was traced has another name since.
    let by_options = [&by_options[..], &["--set", "side_by_side=false", "--set", "colour_by=ratio"]].concat();
    assert!(draw(Some(&dump), &by_options) == drawn, "the session shows something else");
    assert!(draw(Some(&other), &session) == drawn, "the other recording has the same rays");
    assert!(draw(None, &[&session[..], &["--method", "mine"]].concat()) != drawn);
    std::fs::remove_dir_all(&dump).unwrap();
    assert!(draw(Some(&other), &session) == drawn, "it takes the place of the session's");
}

/// Order B is the best of the queue that is asked for, but for what a session chose.
#[test]
fn b_follows_the_queue_unless_it_was_chosen() {
    let (_folder, dump) = written();
    sample::edit_records(&dump, |record| {
        if let Record::Queue(queue) = record {
            queue.methods.retain(|method| method != "mine" && method != AUTO);
        }
    });
    let file = session(&dump, ["two-point-adaptive", "null", "dark", ""]);
    let shadow = |more: &[&str]| {
        let usual = ["--view", "order", "--kind", "shadow", "--theme", "dark", "--size", "320x240"];
        drawn(&dump, &[&usual[..], more].concat())
    };
    let [best, chosen] =
        ["light-octahedron", "two-point-adaptive"].map(|method| shadow(&["--method", method]));
    assert!(best != chosen, "two orders look the same");
    assert!(shadow(&[]) == best, "B is that of the closest rays");
    assert!(shadow(&["--session", file.to_str().unwrap()]) == chosen, "the session's B is lost");
}

#[test]
fn a_film_is_a_picture_for_each_step() {
    let (folder, dump) = written();
    let usual = ["--view", "rays", "--size", "320x240"];
    for (film, still, still_at) in [("scrub", &["--set", "until=0.5"][..], 1), ("orbit", &[], 0)] {
        let output = shot(&dump, &[&usual[..], &["--film", film, "--frames", "4"]].concat());
        assert!(output.status.success(), "{film}: {}", text(&output));
        let read = |frame| std::fs::read(folder.path().join(format!("x-{frame:04}.png"))).unwrap();
        let frames: Vec<_> = (0..4).map(read).collect();
        assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "{film} stands still");
        assert!(!folder.path().join("x-0004.png").exists());
        assert!(
            frames[still_at] == drawn(&dump, &[&usual[..], still].concat()),
            "{film} is of something else"
        );
    }
    assert_refused(&dump, &["--view", "timings", "--film", "orbit"], 1, "a film is of the scene");
}

/// With all Vulkan drivers hidden, only what draws in a window fails, and says why.
#[cfg(target_os = "linux")]
#[test]
fn commands_without_pictures_need_no_gpu() {
    let (folder, dump) = written();
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
