//! `inspector shot`, and that the other commands need no GPU.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, Output};

use formats::key::method::AUTO;
use formats::manifest::Record;

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

/// A layout that was recorded gives the rays in the order that was recorded.
#[test]
fn an_order_that_is_made_is_drawn_like_a_recorded_one() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let shot = |option: &str, value: &str| {
        let file = folder.path().join("x.png");
        let out = file.to_str().unwrap();
        let arguments =
            ["shot", "--view", "rays", option, value, "--ray", "3", "--size", "640x400", "--out", out];
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
        ("--set", "group=999", "999"),
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

/// A camera as numbers and settings by name change the picture; draws are counted.
#[test]
fn what_is_drawn_is_set_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let out = folder.path().join("x.png");
    let draw = |more: &[&str]| {
        let usual = ["shot", "--view", "rays", "--size", "320x240", "--json", "--out", out.to_str().unwrap()];
        let output = inspector(&[&usual[..], more].concat(), &dump).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (std::fs::read(&out).unwrap(), report)
    };
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
        let view = ["shot", "--view", "order", "--out", out.to_str().unwrap()];
        let output = inspector(&[&view[..], &more].concat(), &dump).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{more:?}");
        assert!(text(&output).contains(expected), "{more:?}: {}", text(&output));
    }
}

/// Two views have their lines each, and the surfaces once: 11 corners, each with a colour, and 11 triangles.
#[test]
fn views_share_the_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let uploaded = |more: &[&str]| {
        let out = folder.path().join("x.png");
        let arguments =
            ["shot", "--json", "--view", "order", "--set", "mesh=ghost", "--size", "640x400", "--out"];
        let output = inspector(&arguments, &dump).arg(out).args(more).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["draws"]["uploaded_bytes"].as_u64().unwrap()
    };
    let mesh = (16 * sample::positions().len() + 12 * sample::TRIANGLES.len()) as u64;
    let of_a_and_b = |both: &str| uploaded(&["--set", both]);
    assert_eq!(2 * of_a_and_b("side_by_side=false") - of_a_and_b("side_by_side=true"), mesh);
}

/// What panels show besides the selection is set by name.
#[test]
fn settings_of_panels_change_their_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let out = folder.path().join("x.png");
    let draw = |view: &str, settings: &[&str]| {
        let usual = ["shot", "--view", view, "--method", "two-point", "--size", "640x480"];
        let settings: Vec<&str> = settings.iter().flat_map(|setting| ["--set", *setting]).collect();
        let arguments = [&usual[..], &settings, &["--out", out.to_str().unwrap()]].concat();
        let output = inspector(&arguments, &dump).output().unwrap();
        assert!(output.status.success(), "{view} {settings:?}: {}", text(&output));
        std::fs::read(&out).unwrap()
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
        let arguments = ["shot", "--view", view, "--set", setting, "--out", out.to_str().unwrap()];
        let output = inspector(&arguments, &dump).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{setting}");
        assert!(text(&output).contains(expected), "{setting}: {}", text(&output));
    }
}

/// A session without the version's newest settings, with relative paths, as programs before wrote them; and the
/// same of another recording.
#[test]
fn a_session_is_drawn_with_changes_and_of_another_recording() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let other = folder.path().join("other.raydump");
    std::fs::rename(&dump, &other).unwrap();
    let dump = sample::write(folder.path());
    let file = folder.path().join("view.json");
    let selection = r#""recording": 0, "pass": 1, "bounce": 1, "kind": "closest", "method": "aila",
        "group_width": "64", "ray": 3, "group": null, "cell": null"#;
    let session = format!(
        r#"{{ "version": 1, "recordings": ["sample.raydump"], "selection": {{ {selection} }}, "theme": "light",
            "layout": null,
            "panels": {{ "scene": {{ "options": {{ "rays": true, "colour_by": "estimate" }}, "camera": null }} }} }}"#
    );
    std::fs::write(&file, session).unwrap();
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
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    sample::edit_records(&dump, |record| {
        if let Record::Queue(queue) = record {
            queue.methods.retain(|method| method != "mine" && method != AUTO);
        }
    });
    let (out, file) = (folder.path().join("x.png"), folder.path().join("view.json"));
    let selection = r#""recording": 0, "pass": 1, "bounce": 1, "kind": "closest",
        "method": "two-point-adaptive", "group_width": "64", "ray": null, "group": null, "cell": null"#;
    let session = format!(
        r#"{{ "version": 1, "recordings": ["sample.raydump"], "selection": {{ {selection} }}, "theme": "dark",
            "layout": null, "panels": {{}} }}"#
    );
    std::fs::write(&file, session).unwrap();
    let shadow = |more: &[&str]| {
        let usual = ["shot", "--view", "order", "--kind", "shadow", "--theme", "dark", "--size", "320x240"];
        let output = inspector(&usual, &dump).arg("--out").arg(&out).args(more).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output));
        std::fs::read(&out).unwrap()
    };
    let [best, chosen] =
        ["light-octahedron", "two-point-adaptive"].map(|method| shadow(&["--method", method]));
    assert!(best != chosen, "two orders look the same");
    assert!(shadow(&[]) == best, "B is that of the closest rays");
    assert!(shadow(&["--session", file.to_str().unwrap()]) == chosen, "the session's B is lost");
}

#[test]
fn a_film_is_a_picture_for_each_step() {
    let folder = tempfile::tempdir().unwrap();
    let dump = sample::write(folder.path());
    let picture = |name: &str, more: &[&str]| {
        let out = folder.path().join(format!("{name}.png"));
        let usual = ["shot", "--view", "rays", "--size", "320x240", "--out", out.to_str().unwrap()];
        let output = inspector(&[&usual[..], more].concat(), &dump).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output));
    };
    let read = |name: &str| std::fs::read(folder.path().join(format!("{name}.png"))).unwrap();
    for film in ["scrub", "orbit"] {
        picture(film, &["--film", film, "--frames", "4"]);
        let frames: Vec<_> = (0..4).map(|frame| read(&format!("{film}-{frame:04}"))).collect();
        assert!(frames.windows(2).all(|pair| pair[0] != pair[1]), "{film} stands still");
        assert!(!folder.path().join(format!("{film}-0004.png")).exists());
        picture("still", if film == "scrub" { &["--set", "until=0.5"] } else { &[] });
        assert!(frames[if film == "scrub" { 1 } else { 0 }] == read("still"), "{film} is of something else");
    }
    let out = folder.path().join("no.png");
    let arguments = ["shot", "--view", "timings", "--film", "orbit", "--out", out.to_str().unwrap()];
    let output = inspector(&arguments, &dump).output().unwrap();
    assert!(text(&output).contains("a film is of the scene"), "{}", text(&output));
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
