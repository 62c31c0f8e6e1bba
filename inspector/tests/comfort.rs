//! What a window remembers and is given: sessions, selections to go back to, recent recordings, the page
//! before one is open, recordings that are still being written. Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};

use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use formats::key::method::AUTO;
use formats::manifest::{Record, Stage};
use inspector::app::App;
use inspector::app::demo::Demo;
use inspector::figures::catalogue::CATALOGUE;
use inspector::model::what_if::{Estimate, Settings, WHAT_IF};
use inspector::panels::PANELS;
use inspector::session::Session;
use tempfile::TempDir;

mod headless;

use headless::sample::{self, QUEUE};
use headless::{reads, reads_in_part, settle, window, written};

fn on(paths: &[PathBuf]) -> Harness<'static, App> {
    window(|format| App::new(paths, format))
}

/// A window on the sample, and the folder that it is in.
fn on_sample() -> (TempDir, Harness<'static, App>) {
    let (folder, dump) = written();
    (folder, on(&[dump]))
}

fn press(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    settle(harness);
}

/// Shows a part of the text of what is wrong.
fn has_problem(harness: &Harness<'_, App>, text: &str) -> bool {
    let mut problems = harness.state().context.problems.iter();
    problems.any(|problem| format!("{}: {}", problem.what, problem.why).contains(text))
}

#[test]
fn a_session_is_shown_as_it_was_saved() {
    let (folder, dump) = written();
    let mut harness = on(std::slice::from_ref(&dump));
    let app = harness.state_mut();
    app.context.go_to(QUEUE);
    app.context.selection.order_by("two-point");
    app.context.select_ray(Some(11));
    app.context.toggle_ray(4);
    app.context.selection.cell = Some(5);
    harness.get_by_label("Capsules").click();
    harness.get_by_label("displacement").click();
    settle(&mut harness);
    harness.get_by_label("Overview").click();
    settle(&mut harness);
    let file = folder.path().join("view.json");
    let window_context = harness.ctx.clone();
    window_context.set_theme(egui::ThemePreference::Light);
    // What the pointer rests on looks different.
    harness.event(egui::Event::PointerGone);
    settle(&mut harness);
    let saved = harness.state().session(&window_context);
    saved.write(&file).unwrap();
    let picture = harness.render().unwrap();

    let mut other = on(&[]);
    let context = other.ctx.clone();
    other.state_mut().open_session(&file, &context);
    settle(&mut other);
    assert!(other.state().context.problems.is_empty(), "{:?}", other.state().context.problems);
    assert_eq!(other.state().context.selection, harness.state().context.selection);
    let text = |session: &Session| serde_json::to_value(session).unwrap();
    let again = other.state().session(&context);
    assert_eq!(text(&again), text(&saved));
    let scene = &again.panels["scene"];
    assert_eq!((&scene["options"]["capsules"], scene["camera"].is_string()), (&true.into(), true));
    assert_eq!(again.panels["pixels"]["colouring"], "displacement");
    assert_eq!(text(&again)["theme"], "light");
    assert!(other.render().unwrap() == picture, "the restored window is another picture");
}

/// Panels have other names since version 4.
#[test]
fn panels_of_a_session_of_before_are_found() {
    let (folder, mut harness) = on_sample();
    harness.get_by_label("displacement").click();
    settle(&mut harness);
    let context = harness.ctx.clone();
    let saved = serde_json::to_value(harness.state().session(&context)).unwrap();
    let before =
        saved.to_string().replace(r#""pixels""#, r#""order""#).replace(r#""length-table""#, r#""table""#);
    let before = before.replace(r#""version":4"#, r#""version":3"#);
    assert!(before.contains(r#""order":{"colouring""#) && before.contains(r#""version":3"#), "{before}");
    let file = folder.path().join("before.json");
    std::fs::write(&file, before).unwrap();
    assert_eq!(serde_json::to_value(Session::read(&file).unwrap()).unwrap(), saved);
}

#[test]
fn sessions_that_are_none_are_said() {
    let (folder, dump) = written();
    let mut harness = on(&[dump]);
    let context = harness.ctx.clone();
    let saved = serde_json::to_value(harness.state().session(&context)).unwrap();
    let altered = |name: &str, value: serde_json::Value| {
        let mut session = saved.clone();
        session[name] = value;
        session.to_string()
    };
    let mut panels = saved["panels"].clone();
    panels["scene"]["options"]["colour_by"] = "colour".into();
    for (text, expected) in [
        ("not JSON".to_owned(), "line 1"),
        (altered("version", 99.into()), "version 99"),
        (altered("recordings", vec!["absent.raydump"].into()), "absent.raydump"),
        (altered("panels", serde_json::json!({ "curtain": {} })), "curtain"),
        (altered("panels", panels), "nothing is coloured by colour"),
        (altered("surprise", 1.into()), "surprise"),
    ] {
        let file = folder.path().join("bad.json");
        std::fs::write(&file, text).unwrap();
        harness.state_mut().context.problems.clear();
        harness.state_mut().open_session(&file, &context);
        settle(&mut harness);
        assert!(has_problem(&harness, expected), "{expected}: {:?}", harness.state().context.problems);
        let what = harness.state().context.problems[0].what.clone();
        assert!(reads(&harness, &what), "{what} is not shown");
    }
    harness.state_mut().open_session(&folder.path().join("none.json"), &context);
    assert!(has_problem(&harness, "none.json cannot be read"));
}

#[test]
fn selections_are_undone_and_redone() {
    let (_folder, mut harness) = on_sample();
    harness.state_mut().context.go_to(QUEUE);
    settle(&mut harness);
    for ray in [3, 5] {
        harness.state_mut().context.select_ray(Some(ray));
        settle(&mut harness);
    }
    let ray = |harness: &Harness<'_, App>| harness.state().context.selection.ray;
    press(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(ray(&harness), Some(3));
    press(&mut harness, Modifiers::ALT, Key::ArrowLeft);
    assert_eq!((ray(&harness), harness.state().context.selection.queue), (None, QUEUE));
    press(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    press(&mut harness, Modifiers::ALT, Key::ArrowRight);
    assert_eq!(ray(&harness), Some(5));
}

#[test]
fn before_a_recording_is_open_there_is_a_way_to_one() {
    let (folder, dump) = written();
    let mut harness = window(|format| {
        let mut app = App::new(&[], format);
        app.recent.note(&dump);
        app.recent.note(Path::new("/nowhere/gone.raydump"));
        app.demo = Demo::with(None);
        app
    });
    assert!(reads(&harness, "Open recording..."));
    assert!(reads_in_part(&harness, "found neither beside this one nor on the PATH"));
    harness.state_mut().open(&folder.path().join("absent.raydump"));
    settle(&mut harness);
    let what = harness.state().context.problems[0].what.clone();
    assert!(reads(&harness, &what), "{what} is not on the page");
    harness.render().unwrap();
    harness.get_by_label("sample.raydump").click();
    settle(&mut harness);
    assert_eq!(harness.state().context.recordings.len(), 1);
    assert!(!reads(&harness, "Open recording..."));
    let first = std::path::absolute(&dump).unwrap();
    assert_eq!(harness.state().recent.paths().first(), Some(&first));
}

/// A program that stands for the recorder: it says something and copies a recording, or fails.
#[cfg(unix)]
fn program(folder: &Path, script: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("recorder");
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[cfg(unix)]
#[test]
fn the_demo_is_recorded_in_the_background() {
    let (folder, dump) = written();
    let out = folder.path().join("out");
    let started = |script: &str| {
        let program = program(folder.path(), script);
        let mut harness = window(|format| {
            let mut app = App::new(&[], format);
            app.demo = Demo::with(Some(program)).into_folder(&out);
            app
        });
        // The page says it twice: as a heading and on the button.
        harness.get_by_role_and_label(egui::accesskit::Role::Button, "Record the demo").click();
        settle(&mut harness);
        harness
    };
    let record = |script: &str| {
        let mut harness = started(script);
        for _ in 0..600 {
            settle(&mut harness);
            if !harness.state().demo.is_running() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        harness
    };
    let harness = record("echo no GPU >&2; exit 3");
    assert!(has_problem(&harness, "no GPU"), "{:?}", harness.state().context.problems);
    let copy =
        format!("echo \"$@\"; test \"$1 $2\" = \"demo --out\"; cp -r {} \"$3\"/demo.raydump", dump.display());
    let harness = record(&copy);
    assert_eq!(harness.state().context.recordings.len(), 1, "{:?}", harness.state().context.problems);
    assert!(harness.state().context.recordings[0].dump.root().ends_with("out/demo.raydump"));
    let mut harness = started("sleep 60");
    assert!(harness.state().demo.is_running());
    harness.get_by_label("Cancel").click();
    settle(&mut harness);
    assert!(!harness.state().demo.is_running());
}

#[test]
fn a_recording_that_grows_is_read_again() {
    let (folder, whole) = written();
    let manifest = std::fs::read(whole.join("manifest.bin")).unwrap();
    let partial = folder.path().join("sample.raydump.partial");
    std::fs::rename(&whole, &partial).unwrap();
    // As its recorder has it after a while: some of the queues, and the last record torn.
    let ends: Vec<usize> = formats::manifest::scan::scan(&partial.join("manifest.bin"))
        .unwrap()
        .frames
        .iter()
        .filter(|frame| matches!(frame.record, formats::manifest::Record::Queue(_)))
        .map(|frame| frame.offset as usize)
        .collect();
    std::fs::write(partial.join("manifest.bin"), &manifest[..ends[2] + 3]).unwrap();
    let mut harness = on(std::slice::from_ref(&partial));
    assert!(harness.state().context.problems.is_empty(), "{:?}", harness.state().context.problems);
    let queues = |harness: &Harness<'_, App>| harness.state().context.recording().unwrap().queues().len();
    assert_eq!(queues(&harness), 2);
    std::fs::write(partial.join("manifest.bin"), &manifest[..ends[4] + 3]).unwrap();
    press(&mut harness, Modifiers::NONE, Key::F5);
    assert_eq!(queues(&harness), 4);
    std::fs::write(partial.join("manifest.bin"), &manifest).unwrap();
    std::fs::rename(&partial, &whole).unwrap();
    press(&mut harness, Modifiers::NONE, Key::F5);
    assert_eq!((queues(&harness), ends.len()), (ends.len(), ends.len()));
    assert!(harness.state().context.recording().unwrap().times.is_some());
    std::fs::remove_dir_all(&whole).unwrap();
    press(&mut harness, Modifiers::NONE, Key::F5);
    assert!(has_problem(&harness, "cannot be read again"));
}

#[test]
fn whether_sorting_pays_is_said_first_and_rays_left_alone_have_no_speedup() {
    let (_folder, dump) = written();
    let alone = "auto left these rays alone: A and B are the same order.";
    for is_alone in [false, true] {
        if is_alone {
            sample::edit_manifest(&dump, |records| {
                records.retain(|record| match record {
                    Record::Timing(timing) => timing.method != AUTO || timing.stage == Stage::Decide,
                    _ => true,
                });
                let decisions = records.iter_mut().filter_map(sample::part::decision);
                decisions.for_each(|decision| decision.choice = None);
            });
        }
        let mut harness = on(std::slice::from_ref(&dump));
        harness.state_mut().context.go_to(QUEUE);
        harness.state_mut().context.selection.order_by(AUTO);
        settle(&mut harness);
        assert_eq!(reads(&harness, alone), is_alone);
        assert!(reads_in_part(&harness, "Sorting pays: with"), "the verdict of info");
    }
}

#[test]
fn the_command_that_is_shown_draws_what_is_seen() {
    let (folder, mut harness) = on_sample();
    let app = harness.state_mut();
    app.context.go_to(QUEUE);
    app.context.selection.order_by("aila");
    app.context.select_ray(Some(7));
    settle(&mut harness);
    harness.get_by_label("Capsules").click();
    harness.get_by_label("Overview").click();
    settle(&mut harness);
    let context = harness.ctx.clone();
    // A panel that was moved to the front is in front of the window that is drawn.
    harness.get_by_label("Timings").click();
    settle(&mut harness);
    let file = folder.path().join("view.json");
    let command =
        |panel: &str, harness: &Harness<'_, App>| harness.state().command(panel, &file, &context).unwrap();
    let draw = |command: &str, panel: &str| drawn(folder.path(), command, panel);
    for (panel, view) in
        [("rays", "rays-table"), ("pixels", "pixels"), ("window", "window"), ("scene", "order")]
    {
        let command = command(panel, &harness);
        let parts = [format!("--view {view} "), format!("--session {} ", file.display())];
        assert!(parts.iter().all(|part| command.contains(part)), "{panel}: {command}");
    }
    let session = Session::read(&file).unwrap();
    assert_eq!(session.panels["scene"]["options"]["capsules"], true);
    let camera = session.panels["scene"]["camera"].as_str().unwrap().to_owned();
    // The same by options, without the session.
    let dump = folder.path().join("sample.raydump");
    let by_options = format!(
        "inspector shot {} --view capsules --bounce 1 --method aila --ray 7 --camera '{camera}' --out scene.png",
        dump.display()
    );
    let seen = command("scene", &harness);
    let size = seen.split(" --size ").nth(1).unwrap().split(" --out").next().unwrap();
    let seen = draw(&seen, "scene");
    assert!(seen == draw(&format!("{by_options} --size {size}"), "scene"), "another picture by {by_options}");
    let window = draw(&command("window", &harness), "window");
    let usual = by_options.replace("--view capsules", "--view window");
    let at_first = draw(&usual.replace("scene.png", "window.png --size 1280x720"), "window");
    assert!(window != at_first, "the panel that was brought forward is not seen");
}

/// An order that was made, with bits, a length and an estimate of its own, is drawn by the command.
#[test]
fn the_command_of_an_order_that_was_made_draws_it() {
    let (folder, mut harness) = on_sample();
    let settings = |text: &str, key_bits, estimate, length| Settings {
        text: text.to_owned(),
        key_bits,
        estimate,
        length,
    };
    for (settings, options) in [
        (
            settings("(u v)*3 (ox oy oz)*5", 18, Estimate::Fixed, 0.5),
            "--what-if '(u v)*3 (ox oy oz)*5' --set what_if.key_bits=18 --set what_if.length=0.5",
        ),
        (
            settings("(ox oy oz ex ey ez)*5", 30, Estimate::Traced, 0.25),
            "--what-if '(ox oy oz ex ey ez)*5' --set estimate=traced --set key_bits=30",
        ),
    ] {
        let context = &mut harness.state_mut().context;
        context.go_to(QUEUE);
        context.what_if = Some(settings);
        context.selection.order_by(WHAT_IF);
        let made = context.awaited_order().unwrap();
        let keys: Vec<u64> = (0..made.len()).map(|ray| made.keys.as_ref().unwrap().0.at(ray)).collect();
        settle(&mut harness);
        let window = harness.ctx.clone();
        let session = folder.path().join("made.json");
        let command = harness.state().command("rays", &session, &window).unwrap();
        let size = command.split_whitespace().skip_while(|word| *word != "--size").nth(1).unwrap();
        // As many rows as there are rays.
        let command = command.replace(size, "600x4000");
        let draw = |command: &str| drawn(folder.path(), command, "rays");
        let drawn = draw(&command);
        let by_session = format!("--session {}", session.display());
        let by_options = |options: &str| command.replace(&by_session, &format!("--bounce 1 {options}"));
        assert!(draw(&by_options(options)) == drawn, "{options} shows another order: {keys:?}");
        let usual = options.split(" --set").next().unwrap();
        assert!(draw(&by_options(usual)) != drawn, "{options} changes nothing");
    }
}

/// Runs a command that the window shows, with `to` in place of `from`.
fn repeat(command: &str, from: &str, to: &str) {
    let again = command.replacen("inspector", env!("CARGO_BIN_EXE_inspector"), 1).replace(from, to);
    let done = std::process::Command::new("sh").args(["-c", &again]).output().unwrap();
    assert!(done.status.success(), "{again}: {}", String::from_utf8_lossy(&done.stderr));
}

/// The picture of a panel that such a command draws.
fn drawn(folder: &Path, command: &str, panel: &str) -> Vec<u8> {
    let out = folder.join("again.png");
    repeat(command, &format!("--out {panel}.png"), &format!("--out {}", out.display()));
    std::fs::read(out).unwrap()
}

/// What a panel offers is in the catalogue; what is exported is what the command that is shown then writes.
#[test]
fn figures_of_a_panel_are_those_of_plot() {
    let known: Vec<&str> = CATALOGUE.iter().map(|figure| figure.name).collect();
    for panel in PANELS {
        assert!(panel.figures.iter().all(|name| known.contains(name)), "{}: {:?}", panel.name, panel.figures);
    }
    let (folder, mut harness) = on_sample();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    harness.state_mut().export_figure("table-fill", first.clone());
    harness.state_mut().export_figure("key-bits", first.clone());
    settle(&mut harness);
    assert!(has_problem(&harness, "there is no figure key-bits of these"));
    let shown = harness.query_all_by_label_contains("inspector plot").next().expect("the command is shown");
    let command = shown.accesskit_node().value().unwrap();
    repeat(&command, first.to_str().unwrap(), second.to_str().unwrap());
    let files = |folder: &Path| -> Vec<(PathBuf, Vec<u8>)> {
        let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut files: Vec<_> = paths
            .map(|path| (path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap()))
            .collect();
        files.sort();
        files
    };
    assert!(files(&first).len() >= 6, "{:?}", std::fs::read_dir(&first).unwrap().count());
    assert!(files(&first) == files(&second), "{command} writes something else");
}
