//! The window without a screen: every panel, one selection for all of them, and what cannot be opened.
//! Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use formats::manifest::{MethodArray, Place, QueueArray, QueueId};
use formats::metrics::capsule::{Capsule, Segment};
use formats::metrics::order::Places;
use formats::metrics::quantity::Quantity;
use formats::metrics::speedup::Verdict;
use formats::ray::Kind;
use formats::reader::{Dump, Loaded};
use formats::traced::Traced;
use formats::writer::DumpWriter;
use inspector::analysis::coherence::coherence;
use inspector::analysis::summary::RayClass;
use inspector::analysis::timing::SpeedupLine;
use inspector::analysis::{GroupWidth, Metric};
use inspector::app::App;
use inspector::model::Context;
use inspector::panels::PANELS;
use inspector::panels::space::options::{CapsuleChoice, SpaceOptions};
use inspector::render::geometry::{RayEnd, Shape};
use inspector::render::picture::Stage;
use serde_json::json;

mod headless;

use headless::sample::{self, QUEUE};
use headless::{
    State, click, layers, opened, ordered, panel, panel_made, passing, reads, reads_in_part, sampled,
    sampled_panel, settle, window, written,
};

/// What must be read in each panel, with a recording and without.
const READ: [(&str, &str, &str); 10] = [
    ("scene", "Properties", "no recording is open"),
    ("methods", "two-point-adaptive", "no recording is open"),
    ("pixels", "displacement", "no recording is open"),
    ("length-table", "mean length", "no recording is open"),
    ("coherence", "of the mean", "no recording is open"),
    ("what-if", "Keys of", "no recording is open"),
    ("timings", "trace", "no recording is open"),
    ("rays", "direction.x", "no recording is open"),
    ("ray", "worst group", "no recording is open"),
    ("problems", "No problems.", "No problems."),
];

#[test]
fn every_panel_has_a_test() {
    let tested: BTreeSet<&str> = READ.iter().map(|(name, ..)| *name).collect();
    let registered: BTreeSet<&str> = PANELS.iter().map(|entry| entry.name).collect();
    assert_eq!(tested, registered);
}

#[test]
fn every_panel_shows_a_recording() {
    for (name, text, _) in READ {
        let (_folder, mut harness) = sampled_panel(name, "two-point");
        assert!(reads(&harness, text), "{name} does not show {text:?}");
        let image = harness.render().unwrap();
        let colours: BTreeSet<[u8; 4]> = image.pixels().map(|pixel| pixel.0).collect();
        assert!(colours.len() > 2, "{name} is empty");
    }
}

#[test]
fn a_control_that_is_off_is_a_problem() {
    let (_folder, mut context) = sampled("two-point");
    let verdict = Verdict::NoSignificantDifference;
    let line = |ratio| SpeedupLine { ratio, interval: Some((0.9, 1.4)), verdict, n: 7 };
    context.recordings[0].times.as_mut().unwrap().controls =
        vec![(RayClass::Secondary, line(1.2)), (RayClass::Shadow, line(1.01))];
    let harness = panel("problems", context);
    assert!(reads_in_part(&harness, "the control is off by +20.0 %"));
    assert!(reads_in_part(&harness, "of secondary rays it is 1.20"));
    assert!(!reads_in_part(&harness, "shadow rays"), "1.01 is right");
    assert!(!reads(&harness, "No problems."));
}

#[test]
fn every_panel_says_what_it_lacks() {
    for (name, _, text) in READ {
        let harness = panel(name, Context::default());
        assert!(reads(&harness, text), "{name} does not show {text:?}");
    }
}

#[test]
fn a_row_that_is_clicked_is_the_ray_in_space() {
    let (_folder, mut harness) = sampled_panel("rays", "two-point");
    let order = harness.state_mut().context.awaited_order().unwrap();
    let ray = order.places.ray(5);
    let pixel = order.queue.path_ids[ray];
    harness.get_by_label(&format!("{},{}", pixel % sample::WIDTH, pixel / sample::WIDTH)).click();
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    assert_eq!((context.selection.ray, context.selection.group), (Some(ray), Some(0)));
    let layers = layers(context, &SpaceOptions::default());
    let Shape::Segments(lines) = layers.last().unwrap().geometry.shape() else { panic!("no line on top") };
    let segment = order.queue.segment(ray);
    let expected = [segment.origin, segment.end].map(|point| point.map(|along| along as f32));
    assert_eq!(lines[0].map(|vertex| vertex.position), expected);
}

#[test]
fn a_group_that_is_chosen_is_a_capsule_in_space() {
    let (_folder, mut harness) = sampled_panel("ray", "two-point");
    harness.get_by_label("worst group").click();
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    let order = context.awaited_order().unwrap();
    let groups = order.groups(context.selection.group_width);
    let worst = groups.groups.iter().map(|group| group.area).fold(0.0, f64::max);
    let group = context.selection.group.unwrap();
    assert_eq!(groups.groups[group].area, worst);
    let layers = layers(context, &SpaceOptions::default());
    let capsule = layers.iter().find(|layer| layer.stage == Stage::Capsules).unwrap();
    let Shape::Capsules(capsules) = capsule.geometry.shape() else { panic!("no capsule") };
    assert_eq!(capsules[0].origins[3], groups.groups[group].capsule.origin_radius as f32);
}

#[test]
fn the_ray_panel_says_what_a_path_carries() {
    let (_folder, mut context) = sampled("two-point");
    context.select_ray(Some(0));
    let mut harness = panel("ray", context);
    settle(&mut harness);
    // As the sample has it at bounces 0 and 1.
    harness.get_by_label("1.000 1.000 1.000");
    harness.get_by_label("1.000 0.500 1.000");
    // The places of the ray in A and B, with its key.
    harness.get_by_label("0 by unsorted");
    let place = harness.state_mut().context.awaited_order().unwrap().place_of_ray()[0];
    harness.get_by_label_contains(&format!("{place} by two-point, key "));

    // Whose order it is that `auto` gave.
    let (_folder, mut context) = sampled("auto");
    context.select_ray(Some(0));
    let mut harness = panel("ray", context);
    settle(&mut harness);
    harness.get_by_label_contains("auto has no key of its own: it gave these rays aila, 16 bits");

    // What cannot be read is said, not taken for what was not kept.
    let (_folder, mut context) = sampled("two-point");
    context.select_ray(Some(0));
    let dump = context.recording().unwrap().dump.clone();
    let queue = QueueId { kind: Kind::Closest, ..context.selection.queue };
    let place = Place::Queue(queue, QueueArray::Throughput);
    let file = std::fs::OpenOptions::new().write(true).open(dump.root().join(place.to_string())).unwrap();
    file.set_len(7).unwrap();
    let mut harness = panel("ray", context);
    settle(&mut harness);
    harness.get_by_label_contains("throughput.npy is 7 bytes long");
}

#[test]
fn a_pixel_that_is_clicked_is_a_ray() {
    let (_folder, mut harness) = sampled_panel("pixels", "two-point");
    let at = egui::pos2(300.0, 300.0);
    click(&mut harness, at);
    let context = &mut harness.state_mut().context;
    let order = context.awaited_order().unwrap();
    let ray = context.selection.ray.expect("the pixel under the pointer has a ray");
    let place = order.place_of_ray()[ray] as usize;
    assert_eq!(context.selection.group, Some(place / context.selection.group_width.rays()));
}

/// Dragging along a chart leaves the rays in that range, in all panels; a click has all of them again.
#[test]
fn rays_are_brushed_in_charts() {
    for (name, state, quantity, y) in [
        ("coherence", json!({}), Quantity::Area, 150.0),
        ("pixels", json!({ "colouring": "length" }), Quantity::Length, 556.0),
        ("length-table", json!({ "view": "estimates" }), Quantity::Length, 300.0),
    ] {
        let (_folder, context) = sampled("two-point");
        let mut harness = panel_made(name, [900.0, 640.0], context, state);
        let all = harness.state_mut().context.awaited_order().unwrap();
        let filter =
            |harness: &Harness<'_, State>| harness.state().context.selection.filter.text().to_owned();
        harness.drag_at(egui::pos2(250.0, y));
        harness.step();
        for x in [300.0, 400.0, 500.0] {
            harness.hover_at(egui::pos2(x, y));
            harness.step();
        }
        harness.drop_at(egui::pos2(500.0, y));
        settle(&mut harness);
        let text = filter(&harness);
        let parts: Vec<f64> = text.split(' ').filter_map(|word| word.parse().ok()).collect();
        let [low, high] = parts[..] else { panic!("{name}: {text:?}") };
        let of = quantity.name();
        assert_eq!(text, format!("{of} >= {low} && {of} <= {high}"));
        let context = &mut harness.state_mut().context;
        let numbers = context.numbers(all.clone()).unwrap();
        numbers.prepare(quantity);
        let values: Vec<f64> =
            (0..all.len()).map(|place| (quantity.value())(numbers.rays().at(place))).collect();
        let passing = passing(context, &all);
        let expected = |value: &f64| (low..=high).contains(value);
        assert_eq!(passing.len(), values.iter().filter(|value| expected(value)).count(), "{name}: {text}");
        click(&mut harness, egui::pos2(250.0, y));
        assert_eq!(filter(&harness), "", "{name}");
    }
}

/// The wheel enlarges what is under the pointer, which stays there; a double click shows all again.
#[test]
fn pictures_are_enlarged_where_the_pointer_is() {
    let (_folder, mut harness) = sampled_panel("pixels", "two-point");
    let pixel_at = |harness: &mut Harness<'_, State>, at: egui::Pos2| {
        click(harness, at);
        let context = &mut harness.state_mut().context;
        let order = context.awaited_order().unwrap();
        order.queue.path_ids[context.selection.ray.unwrap()] % sample::WIDTH
    };
    let [here, beside] = [egui::pos2(300.0, 250.0), egui::pos2(500.0, 250.0)];
    let before = [pixel_at(&mut harness, here), pixel_at(&mut harness, beside)];
    assert!(before[1] > before[0] + 2, "{before:?}");
    harness.hover_at(here);
    let (unit, delta) = (egui::MouseWheelUnit::Point, egui::vec2(0.0, 700.0));
    let (phase, modifiers, source) =
        (egui::TouchPhase::Move, egui::Modifiers::NONE, egui::MouseWheelSource::Unknown);
    harness.event(egui::Event::MouseWheel { unit, delta, phase, modifiers, source });
    settle(&mut harness);
    let enlarged = [pixel_at(&mut harness, here), pixel_at(&mut harness, beside)];
    assert!(enlarged[0] == before[0] && enlarged[1] <= before[0] + 1, "{before:?}, then {enlarged:?}");
    // Frames are far apart in a test.
    harness.ctx.options_mut(|options| options.input_options.max_double_click_delay = 0.6);
    harness.hover_at(beside);
    for pressed in [true, false, true, false] {
        let (pos, button) = (beside, egui::PointerButton::Primary);
        harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
    }
    settle(&mut harness);
    assert_eq!([pixel_at(&mut harness, here), pixel_at(&mut harness, beside)], before);
}

/// The table's fill goes on from bounce to bounce, and stops after the last one.
#[test]
fn the_fill_of_the_table_is_played_to_its_end() {
    let (_folder, mut harness) = sampled_panel("length-table", "two-point");
    let queues: Vec<QueueId> = {
        let open = harness.state().context.recording().unwrap();
        let mut queues: Vec<_> = open.queues().iter().map(|record| record.id).collect();
        queues.retain(|queue| queue.kind == Kind::Closest);
        queues.sort_by_key(|queue| (queue.pass, queue.bounce));
        queues
    };
    assert!(queues.len() > 2, "{queues:?}");
    harness.state_mut().context.go_to(queues[0]);
    settle(&mut harness);
    harness.get_by_label("Play").click();
    let mut seen = vec![queues[0]];
    for _ in 0..400 {
        harness.step();
        harness.state_mut().context.finish();
        let now = harness.state().context.selection.queue;
        if seen.last() != Some(&now) {
            seen.push(now);
        }
    }
    assert_eq!(seen, queues);
    assert!(harness.query_by_label("Play").is_some(), "it has not stopped");
}

/// Rays of another tracer have no image plane: `recorder import` gives them a row, too long for a picture.
#[test]
fn imported_rays_are_shown_in_rows() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = sample::header();
    (header.options.width, header.options.height) = (20_000, 1);
    let mut writer = DumpWriter::create(&folder.path().join("imported"), header, false).unwrap();
    let end = sample::write_all(&mut writer).unwrap();
    let mut harness = panel("pixels", opened(writer.finish(end).unwrap(), QUEUE));
    harness.render().unwrap();
    // The sample's rays are in the first two of 142 rows.
    let corner = harness.get_by_label("displacement").rect().min;
    let at = corner + egui::vec2(0.0, 48.0);
    click(&mut harness, at);
    assert!(harness.state().context.selection.ray.is_some(), "no ray at {at}");
}

/// Camera rays start in one place: their curve is that of what they hit.
#[test]
fn the_curve_of_camera_rays_goes_through_what_they_hit() {
    let (_folder, dump) = written();
    let mut context = ordered(dump, QueueId { bounce: 0, ..QUEUE }, "two-point");
    let [by_default, through_hits] = [RayEnd::Origin, RayEnd::Termination].map(|curve_end| {
        let drawn = layers(&mut context, &SpaceOptions { curve_end, jumps: 0, ..SpaceOptions::default() });
        let Shape::Strip(curve) = drawn[0].geometry.shape() else { panic!("no curve") };
        curve.iter().map(|vertex| vertex.position).collect::<Vec<_>>()
    });
    assert!(by_default.len() > 1 && by_default == through_hits);
}

/// Curve, rays and capsules against the recording read without the window.
#[test]
fn vertices_are_those_of_the_analysis() {
    let (_folder, mut context) = sampled("two-point");
    let dump = Dump::open(context.recording().unwrap().dump.root()).unwrap();
    let traced = Traced::open(&dump, QUEUE).unwrap();
    let place = Place::Method(QUEUE, "two-point".to_owned(), MethodArray::Permutation);
    let permutation: Loaded<u32> = dump.array(&place).unwrap();
    let of = |&ray: &u32| {
        let ray = ray as usize;
        Segment::of(traced.unit(), &traced.rays()[ray], traced.length(ray))
    };
    let segments: Vec<Segment> = permutation.iter().map(of).collect();
    let narrow = |point: [f64; 3]| point.map(|along| along as f32);
    for end in [RayEnd::Origin, RayEnd::Termination] {
        let options = SpaceOptions { curve_end: end, ..SpaceOptions::default() };
        let drawn = layers(&mut context, &options);
        let Shape::Strip(curve) = drawn[0].geometry.shape() else { panic!("no curve") };
        let points: Vec<[f32; 3]> = curve.iter().map(|vertex| vertex.position).collect();
        let point = |segment: &Segment| if end == RayEnd::Origin { segment.origin } else { segment.end };
        assert_eq!(points, segments.iter().map(|segment| narrow(point(segment))).collect::<Vec<_>>());
        let places: Vec<f32> = curve.iter().map(|vertex| vertex.value).collect();
        assert_eq!(places, (0..segments.len()).map(|place| place as f32).collect::<Vec<_>>());
    }
    let options = SpaceOptions {
        curve: false,
        capsules: true,
        capsule_choice: CapsuleChoice::Spread,
        capsule_count: usize::MAX,
        ..SpaceOptions::default()
    };
    let drawn = layers(&mut context, &options);
    let Shape::Capsules(capsules) = drawn[0].geometry.shape() else { panic!("no capsules") };
    let width = context.selection.group_width;
    let expected: Vec<Capsule> = segments.chunks(width.rays()).filter_map(Capsule::around).collect();
    assert_eq!(capsules.len(), expected.len());
    for (found, expected) in capsules.iter().zip(&expected) {
        let [x, y, z] = narrow(expected.origin_centre);
        assert_eq!(found.origins, [x, y, z, expected.origin_radius as f32]);
        let [x, y, z] = narrow(expected.end_centre);
        assert_eq!(found.ends, [x, y, z, expected.end_radius as f32]);
    }
    let order = context.awaited_order().unwrap();
    let places = Places::sorted(permutation, segments.len()).unwrap();
    let analysed = coherence(&traced, &order.queue.lengths, &places, width.rays()).unwrap();
    let mean = order.groups(width).mean_area;
    assert!((mean / analysed.mean_capsule_area - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_no_recording_is_said_and_survived() {
    let (folder, good) = written();
    let bad = folder.path().join("bad.raydump");
    std::fs::create_dir(&bad).unwrap();
    std::fs::write(bad.join("manifest.bin"), b"not a manifest").unwrap();
    let paths: Vec<PathBuf> = vec![bad, folder.path().join("absent.raydump"), good];
    let mut harness = window(|format| App::new(&paths, format));
    harness.render().unwrap();
    let app = harness.state();
    assert_eq!((app.context.recordings.len(), app.context.problems.len()), (1, 2));
    let text = &app.context.problems[1].what;
    assert!(reads(&harness, text), "{text} is not shown");
}

#[test]
fn arrays_that_are_missing_are_said_in_their_place() {
    let (_folder, context) = sampled("two-point");
    let root = context.recording().unwrap().dump.root().to_owned();
    let hits = root.join(QUEUE.to_string()).join("hits.npy");
    std::fs::remove_file(&hits).unwrap();
    for name in ["scene", "pixels", "coherence", "rays", "ray", "length-table"] {
        let mut context = opened(root.clone(), QUEUE);
        let reason = context.awaited_order().unwrap_err();
        assert!(reason.contains("hits.npy"), "{reason}");
        let mut harness = panel(name, context);
        harness.render().unwrap();
        if name != "scene" {
            assert!(reads(&harness, &reason), "{name} does not say why");
        }
    }
    // What is not awaited is not waited for.
    let mut harness = panel("methods", opened(root, QUEUE));
    let ranking = harness.state_mut().context.ranking(1);
    for order in ranking.into_iter().filter(|order| order.elsewhere.is_none()) {
        let why = order.area.as_ref().and_then(Metric::reason);
        assert!(why.is_some_and(|why| why.contains("hits.npy")), "{}: {why:?}", order.method);
    }
}

/// What is read before there is a window is what panels show then, read once.
#[test]
fn what_is_read_ahead_is_there_when_it_is_asked_for() {
    let (_folder, mut context) = sampled("two-point");
    context.read_ahead();
    context.finish();
    let (queue, order) = (context.queue().unwrap(), context.order().unwrap());
    assert!(Arc::ptr_eq(&queue, &order.queue), "the queue was read twice");
    assert!(order.known_groups(GroupWidth::default()).is_none(), "no one asked for groups");
    context.read_ahead();
    context.finish();
    assert!(Arc::ptr_eq(&context.queue().unwrap(), &queue), "the queue was read again");
    assert!(Arc::ptr_eq(&context.order().unwrap(), &order), "the order was read again");
}

/// Areas wait until everything else was drawn, however often they are asked for in a frame.
#[test]
fn areas_are_found_after_a_picture_without_them() {
    let (_folder, mut context) = sampled("two-point");
    context.read_ahead();
    context.finish();
    let waker = context.waker().clone();
    let drawings = Arc::new(AtomicUsize::new(0));
    let counted = drawings.clone();
    waker.set(move || {
        counted.fetch_add(1, Relaxed);
    });
    let mut ask = |frame| {
        let before = drawings.load(Relaxed);
        let found = context.coherences(frame).unwrap().0.len();
        (found, waker.is_busy() || found > 0, drawings.load(Relaxed) > before)
    };
    assert_eq!(ask(5), (0, false, true), "another picture is asked for");
    assert!(!ask(5).1, "the same picture");
    ask(6);
    waker.wait();
    let (all, ..) = ask(6);
    assert_eq!(all, context.coherences(6).unwrap().1);
}
