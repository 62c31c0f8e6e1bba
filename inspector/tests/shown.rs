//! What pictures of the scene show: the longest jumps of an order, capsules, paths, and what is selected among the
//! rest; the pictures that answer a question, and pictures without buttons.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::process::Command;

use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use formats::hierarchy::Hierarchy;
use formats::key::method::AUTO;
use formats::manifest::{MethodArray, Place, QueueArray, QueueId, Record, Stage as StageName, TimingRecord};
use formats::metrics::capsule::Segment;
use formats::ray::Kind;
use formats::reader::{Dump, Loaded};
use formats::traced::{Results, Traced};
use inspector::model::Context;
use inspector::model::colour_by::ColourBy;
use inspector::panels::space::options::{CapsuleChoice, SpaceOptions, VisitChoice};
use inspector::render::geometry::Shape;
use inspector::render::picture::{Layer, Paint, Stage};
use inspector::render::range::ValueRange;
use tempfile::TempDir;

mod headless;

use headless::{State, layers, panel, reads, sample, settle, written};

fn opened() -> (TempDir, Context) {
    let (folder, dump) = written();
    let mut context = Context::open(&[dump]);
    context.order_by("aila");
    (folder, context)
}

fn strip(layers: &[Layer]) -> &Layer {
    layers.iter().find(|layer| matches!(layer.geometry.shape(), Shape::Strip(_))).unwrap()
}

fn nothing() -> SpaceOptions {
    SpaceOptions { curve: false, ..SpaceOptions::default() }
}

/// Prints after which places of an order the longest jumps are, ascending; of equal ones those that come first.
const LONGEST_JUMPS: &str = r#"
import sys
import numpy as np

queue, method, wanted = sys.argv[1], sys.argv[2], int(sys.argv[3])
origins = np.load(f"{queue}/rays.npy")["origin"][np.load(f"{queue}/{method}/permutation.npy")].astype("f8")
lengths = np.linalg.norm(np.diff(origins, axis=0), axis=1)
print(*sorted(np.argsort(-lengths, kind="stable")[:wanted]))
"#;

/// Against a sort of all distances from one ray's origin to the next one's by NumPy.
#[test]
fn the_longest_jumps_are_drawn_in_colours_of_their_own_length() {
    const JUMPS: usize = 5;
    let (_folder, mut context) = opened();
    let order = context.awaited_order().unwrap();
    let origin = |place: usize| order.queue.segment(order.places.ray(place)).origin;
    let length = |place: usize| {
        let [here, next] = [origin(place), origin(place + 1)];
        (0..3).map(|axis| (next[axis] - here[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let queue = context.recording().unwrap().dump.root().join(context.selection.queue.to_string());
    let mut python = Command::new(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    python.args(["-c", LONGEST_JUMPS]).arg(queue).args(["aila", &JUMPS.to_string()]);
    let output = python.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    let expected: Vec<usize> = printed.split_whitespace().map(|place| place.parse().unwrap()).collect();
    assert_eq!(expected.len(), JUMPS);
    let colour_by = ColourBy::try_from("jump".to_owned()).unwrap();
    let options = SpaceOptions { jumps: JUMPS, detail: 7, colour_by, ..SpaceOptions::default() };
    let drawn = layers(&mut context, &options);
    let is_jumps =
        |layer: &&Layer| layer.stage == Stage::Lines && matches!(layer.geometry.shape(), Shape::Segments(_));
    let jumps = drawn.iter().find(is_jumps).unwrap();
    let Shape::Segments(lines) = jumps.geometry.shape() else { panic!("jumps are lines") };
    assert_eq!((lines.len(), jumps.opacity), (JUMPS, 1.0));
    for (line, &place) in lines.iter().zip(&expected) {
        let ends = [origin(place), origin(place + 1)].map(|end| end.map(|along| along as f32));
        assert_eq!(line.map(|end| end.position), ends, "after place {place}");
        assert!((f64::from(line[0].value) - length(place).log10()).abs() < 1e-5);
    }
    // The faint curve between rays that are no neighbours has the lengths of its own lines.
    let Shape::Strip(points) = strip(&drawn).geometry.shape() else { panic!("the curve is a strip") };
    assert!(strip(&drawn).opacity < 0.5);
    for pair in points.windows(2) {
        let [a, b] = [pair[0].position, pair[1].position].map(|at| at.map(f64::from));
        let length = (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt();
        assert!((f64::from(pair[0].value) - length.max(1e-6).log10()).abs() < 1e-3, "{pair:?}");
    }
    // Part of the order has the jumps that start in it.
    let half = SpaceOptions { until: 0.5, ..options };
    let drawn = layers(&mut context, &half);
    let jumps = drawn.iter().find(is_jumps).unwrap();
    let before = expected.iter().filter(|&&place| place < order.len().div_ceil(2)).count() as u32;
    assert_eq!(jumps.part, Some(0..before));
}

#[test]
fn capsules_are_those_of_some_groups_while_none_is_selected() {
    let (_folder, mut context) = opened();
    let options = SpaceOptions { capsules: true, capsule_choice: CapsuleChoice::Selected, ..nothing() };
    let count = |context: &mut Context| {
        let drawn = layers(context, &options);
        drawn.iter().find(|layer| layer.stage == Stage::Capsules).unwrap().geometry.shape().len()
    };
    let groups = context.awaited_order().unwrap().len().div_ceil(64);
    assert_eq!(count(&mut context), groups.min(options.capsule_count));
    context.select_ray(Some(3));
    assert_eq!(count(&mut context), 1);
}

/// Against the way of each ray of the group through the hierarchy.
#[test]
fn boxes_are_drawn_that_a_ray_and_its_group_enter() {
    let (_folder, mut context) = opened();
    let order = context.awaited_order().unwrap();
    context.select_ray(Some(order.places.ray(0)));
    let hierarchy = Hierarchy::open(&context.recording().unwrap().dump).unwrap();
    let mut entered: BTreeMap<Option<usize>, (u32, u32)> = BTreeMap::new();
    for place in 0..context.selection.group_width.rays().min(order.len()) {
        let ray = &order.queue.traced.rays()[order.places.ray(place)];
        for visit in hierarchy.traversal(ray, order.queue.id.kind).visits {
            let (rays, is_of_first) = entered.entry(visit.place).or_default();
            *rays += 1;
            *is_of_first += u32::from(place == 0);
        }
    }
    let mut values = |visits, visit_levels| -> BTreeMap<u32, usize> {
        let drawn = layers(&mut context, &SpaceOptions { visits, visit_levels, ..nothing() });
        let boxes = drawn.iter().rev().find(|layer| layer.stage == Stage::Lines);
        let Some(Shape::Segments(lines)) = boxes.map(|layer| layer.geometry.shape()) else {
            return BTreeMap::new();
        };
        let mut counts = BTreeMap::new();
        lines.iter().for_each(|line| *counts.entry(line[0].value as u32).or_default() += 1);
        counts
    };
    // Twelve edges each, by how many rays enter a box, and by level.
    let mut by_rays: BTreeMap<u32, usize> = BTreeMap::new();
    entered.values().for_each(|(rays, _)| *by_rays.entry(*rays).or_default() += 12);
    assert!(by_rays.len() > 1, "all boxes are entered by as many rays: {by_rays:?}");
    assert_eq!(values(VisitChoice::Group, 32), by_rays);
    let of_first = entered.values().filter(|(_, is_of_first)| *is_of_first > 0).count();
    assert_eq!(values(VisitChoice::Ray, 32), BTreeMap::from([(0, 12), (1, 12 * (of_first - 1))]));
    assert_eq!(values(VisitChoice::Ray, 0), BTreeMap::from([(0, 12)]));
    assert_eq!(values(VisitChoice::Hidden, 32), BTreeMap::new());
}

/// Against all pairs of rays.
#[test]
fn near_rays_have_the_colour_of_their_mean() {
    let (_folder, mut context) = opened();
    let order = context.awaited_order().unwrap();
    let colour_by = ColourBy::try_from("place".to_owned()).unwrap();
    let options = SpaceOptions { ends: true, colour_by, near_mean: true, detail: 1000, ..nothing() };
    let drawn = layers(&mut context, &options);
    let marks = drawn.iter().find(|layer| layer.stage == Stage::Marks).unwrap();
    let Shape::Segments(marks) = marks.geometry.shape() else { panic!("marks are at lines") };
    let cell = |place: usize| {
        order
            .queue
            .segment(order.places.ray(place))
            .end
            .map(|along| (along * (order.len() as f64 / 10.0).sqrt()) as i32)
    };
    let mean = |place: usize| {
        let near: Vec<usize> = (0..order.len()).filter(|&other| cell(other) == cell(place)).collect();
        near.iter().sum::<usize>() as f64 / near.len() as f64
    };
    assert_eq!(marks.len(), order.len());
    let is_other = (0..order.len()).filter(|&place| {
        assert!((f64::from(marks[place][0].value) - mean(place)).abs() < 1e-3, "place {place}");
        mean(place) != place as f64
    });
    assert!(is_other.count() > 0, "no rays end near each other");
}

#[test]
fn what_is_not_selected_fades_to_a_tenth() {
    let (_folder, mut context) = opened();
    let options = SpaceOptions { jumps: 0, ..SpaceOptions::default() };
    let opacity = |context: &mut Context| strip(&layers(context, &options)).opacity;
    let alone = opacity(&mut context);
    context.select_ray(Some(3));
    assert!((opacity(&mut context) - 0.1 * alone).abs() < 1e-6);
}

/// Against the arrays of each queue, read one after the other and sought through.
#[test]
fn a_path_is_its_rays_in_all_bounces() {
    let (_folder, mut context) = opened();
    let dump = Dump::open(context.recording().unwrap().dump.root()).unwrap();
    let order = context.awaited_order().unwrap();
    let pass = context.selection.queue.pass;
    let mut lengths = Vec::new();
    for &pixel in [order.queue.path_ids[0], order.queue.path_ids[order.len() - 1]].iter() {
        let mut expected = Vec::new();
        for bounce in 0.. {
            if !dump.manifest().queues.iter().any(|queue| (queue.id.pass, queue.id.bounce) == (pass, bounce))
            {
                break;
            }
            for kind in [Kind::Closest, Kind::Shadow] {
                let queue = QueueId { pass, bounce, kind };
                let paths: Loaded<u32> = dump.array(&Place::Queue(queue, QueueArray::PathIds)).unwrap();
                let Some(ray) = paths.iter().position(|&path| path == pixel) else { continue };
                let traced = Traced::open(&dump, queue).unwrap();
                let is_at_surface = match traced.results() {
                    Results::Hits(hits) => hits[ray].t.is_finite(),
                    Results::Distances(distances) => distances[ray].is_finite(),
                };
                let permutation = Place::Method(queue, "aila".to_owned(), MethodArray::Permutation);
                let permutation: Loaded<u32> = dump.array(&permutation).unwrap();
                let place = permutation.iter().position(|&index| index as usize == ray);
                let length = traced.length(ray);
                let segment = Segment::of(traced.unit(), &traced.rays()[ray], length);
                // As the sample has it.
                let carried = [1.0, 0.5f32.powi(queue.bounce as i32), 1.0];
                let carried = (queue.kind == Kind::Closest).then_some(Ok(carried));
                expected.push((queue, ray, segment, length, is_at_surface, carried, [Some(ray), place]));
            }
        }
        context.paths(vec![pixel]);
        context.finish();
        let found = context.paths(vec![pixel]).unwrap();
        let found: Vec<_> = found
            .iter()
            .map(|ray| {
                let carried = ray.throughput.clone();
                (ray.queue, ray.ray, ray.segment, ray.length, ray.is_at_surface, carried, ray.places)
            })
            .collect();
        assert_eq!(found, expected, "path {pixel}");
        lengths.push(found.len());
    }
    assert!(lengths.iter().any(|&rays| rays > 2), "no path has several bounces: {lengths:?}");
}

#[test]
fn the_path_of_the_selected_ray_is_drawn_by_bounce() {
    let (_folder, mut context) = opened();
    context.select_ray(Some(3));
    let pixel = context.awaited_order().unwrap().queue.path_ids[3];
    let drawn = layers(&mut context, &SpaceOptions { path: true, ..nothing() });
    let path = context.paths(vec![pixel]).unwrap();
    let last = context.recording().unwrap().dump.manifest().header.options.bounces - 1;
    for kind in [Kind::Closest, Kind::Shadow] {
        let of_kind = || path.iter().filter(|ray| ray.queue.kind == kind);
        let bounces: Vec<f32> = of_kind().map(|ray| ray.queue.bounce as f32).collect();
        let is_drawn = drawn.iter().any(|layer| match layer.geometry.shape() {
            Shape::Segments(lines) if layer.stage == Stage::OnTop => {
                matches!(layer.paint, Paint::Values(_, range) if range == ValueRange { low: 0.0, high: last as f32 })
                    && lines.iter().map(|line| line[1].value).eq(bounces.iter().copied())
                    && lines
                        .iter()
                        .zip(of_kind())
                        .all(|(line, ray)| line[1].position == ray.segment.end.map(|along| along as f32))
            }
            _ => false,
        });
        assert!(is_drawn && !bounces.is_empty(), "{kind} rays of the path are not drawn");
    }
}

/// Against the path indices of all queues of the pass.
#[test]
fn the_paths_of_a_group_are_those_of_all_its_rays() {
    let (_folder, mut context) = opened();
    let order = context.awaited_order().unwrap();
    context.select_ray(Some(order.places.ray(70)));
    let group: Vec<u32> = order
        .places_of_group(1, context.selection.group_width)
        .map(|place| order.queue.path_ids[order.places.ray(place)])
        .collect();
    assert_eq!(group.len(), 64);
    let dump = context.recording().unwrap().dump.clone();
    let pass = order.queue.id.pass;
    let mut expected: BTreeMap<(Kind, u32), Vec<[f32; 3]>> = BTreeMap::new();
    for queue in dump.manifest().queues.iter().map(|queue| queue.id).filter(|queue| queue.pass == pass) {
        let paths: Loaded<u32> = dump.array(&Place::Queue(queue, QueueArray::PathIds)).unwrap();
        let traced = Traced::open(&dump, queue).unwrap();
        for ray in (0..paths.len()).filter(|&ray| group.contains(&paths[ray])) {
            let end = Segment::of(traced.unit(), &traced.rays()[ray], traced.length(ray)).end;
            expected.entry((queue.kind, queue.bounce)).or_default().push(end.map(|along| along as f32));
        }
    }
    assert!(expected.len() > 3, "{expected:?}");
    let drawn = layers(&mut context, &SpaceOptions { path: true, path_group: true, ..nothing() });
    for kind in [Kind::Closest, Kind::Shadow] {
        let mut of_kind: Vec<(f32, [f32; 3])> = expected
            .iter()
            .filter(|((of, _), _)| *of == kind)
            .flat_map(|((_, bounce), ends)| ends.iter().map(|end| (*bounce as f32, *end)))
            .collect();
        of_kind.sort_by(|a, b| a.partial_cmp(b).unwrap());
        // Camera rays, for one, are of all paths; rays to lights are thin.
        let is_drawn = drawn.iter().any(|layer| {
            let Shape::Segments(lines) = layer.geometry.shape() else { return false };
            let mut ends: Vec<_> = lines.iter().map(|line| (line[1].value, line[1].position)).collect();
            ends.sort_by(|a, b| a.partial_cmp(b).unwrap());
            layer.stage == Stage::OnTop && ends == of_kind && (layer.width == 1.0) == (kind == Kind::Shadow)
        });
        assert!(is_drawn, "{kind} rays of the paths are not drawn");
    }
}

/// Ctrl-click in any panel adds a ray, and takes it away again; all of them stand out. Without Ctrl there is one.
#[test]
fn rays_are_added_and_taken_away_with_ctrl() {
    let (_folder, mut context) = opened();
    let order = context.awaited_order().unwrap();
    context.select_ray(Some(order.places.ray(70)));
    let mut harness = panel("rays", context);
    let ray = order.places.ray(63);
    let pixel = order.queue.path_ids[ray];
    let label = format!("{},{}", pixel % sample::WIDTH, pixel / sample::WIDTH);
    let click_row = |harness: &mut Harness<'_, State>, modifiers: egui::Modifiers| {
        harness.get_by_label(&label).click_modifiers(modifiers);
        settle(harness);
        harness.state().context.selection.rays()
    };
    let first = order.places.ray(70);
    assert_eq!(click_row(&mut harness, egui::Modifiers::COMMAND), [ray, first]);
    let context = &mut harness.state_mut().context;
    assert_eq!((context.selection.group, context.selection.others.as_slice()), (Some(0), &[first][..]));
    let drawn = layers(context, &nothing());
    let capsules = drawn.iter().find(|layer| layer.stage == Stage::Capsules).unwrap();
    assert_eq!(capsules.geometry.shape().len(), 2, "a capsule for each group");
    let Shape::Segments(lines) = drawn.last().unwrap().geometry.shape() else { panic!("no line on top") };
    for (line, ray) in lines.iter().zip([ray, first]) {
        assert_eq!(line[1].position, order.queue.segment(ray).end.map(|along| along as f32));
    }
    assert_eq!(lines.len(), 2);
    assert_eq!(click_row(&mut harness, egui::Modifiers::COMMAND), [first]);
    assert_eq!(click_row(&mut harness, egui::Modifiers::COMMAND), [ray, first]);
    assert_eq!(click_row(&mut harness, egui::Modifiers::NONE), [ray]);
    // What belongs to other rays is not selected there.
    harness.state_mut().context.toggle_ray(first);
    harness.state_mut().context.order_by("unsorted");
    assert_eq!(harness.state().context.selection.rays(), [first, ray]);
    harness.state_mut().context.go_to(QueueId { bounce: 0, ..order.queue.id });
    assert!(harness.state().context.selection.rays().is_empty());
}

/// With Ctrl, pixels and points in space are added, too; nothing is taken away where there is no ray.
#[test]
fn pixels_and_points_in_space_are_added_with_ctrl() {
    for (name, at) in [("pixels", [300.0, 300.0]), ("scene", [450.0, 330.0])] {
        let (_folder, mut context) = opened();
        let last = context.awaited_order().unwrap().len() - 1;
        context.select_ray(Some(last));
        let mut harness = panel(name, context);
        harness.event(egui::Event::ModifiersChanged(egui::Modifiers::COMMAND));
        let rays = |harness: &Harness<'_, State>| harness.state().context.selection.rays();
        let mut tried = (0..12).flat_map(|row| (0..12).map(move |column| [column, row]));
        let added = tried.find(|&offset| {
            let offset = egui::Vec2::from(offset.map(|step| 12.0 * step as f32 - 72.0));
            headless::click(&mut harness, egui::Pos2::from(at) + offset);
            rays(&harness) != [last]
        });
        assert!(added.is_some(), "{name}: no ray is added");
        assert_eq!((rays(&harness).len(), rays(&harness)[1]), (2, last), "{name}");
        headless::click(&mut harness, egui::pos2(2.0, 636.0));
        assert_eq!(rays(&harness).len(), 2, "{name}");
    }
}

/// A button shows the whole of its picture, whatever was shown before.
#[test]
fn buttons_show_pictures_that_answer_a_question() {
    let (_folder, context) = opened();
    let mut harness = panel("scene", context);
    let shown = |harness: &mut Harness<'_, State>, button: &str| {
        harness.get_by_label(button).click();
        settle(harness);
        let state = harness.state().panel.state();
        let options = state["options"].as_object().unwrap();
        let mut on: Vec<String> = ["curve", "ends", "capsules", "cells", "path"]
            .into_iter()
            .filter(|name| options[*name] == true)
            .map(str::to_owned)
            .collect();
        on.extend((state["side_by_side"] == true).then(|| "A | B".to_owned()));
        assert!(harness.state().context.problems.is_empty());
        on.join(", ")
    };
    for (button, expected) in [
        ("Capsules", "capsules, A | B"),
        ("Order", "curve, A | B"),
        ("Table", "cells"),
        ("Cost", "ends"),
        ("Paths", "path"),
        ("Order", "curve, A | B"),
    ] {
        assert_eq!(shown(&mut harness, button), expected, "{button}");
    }
}

#[test]
fn properties_stay_open_and_a_picture_has_no_buttons() {
    let (_folder, context) = opened();
    let mut harness = panel("scene", context);
    harness.get_by_label("Properties").click();
    settle(&mut harness);
    for property in ["Rays", "Hit points", "Rays"] {
        harness.get_by_label(property).click();
        settle(&mut harness);
    }
    let options = harness.state().panel.state()["options"].clone();
    assert_eq!((&options["rays"], &options["ends"]), (&false.into(), &true.into()));
    harness.get_by_label("Order").click();
    settle(&mut harness);
    assert!(reads(&harness, "Hit points"), "another picture closes the properties");
    harness.state_mut().context.is_bare = true;
    settle(&mut harness);
    for button in ["Properties", "Hit points", "Order", "Play"] {
        assert!(!reads(&harness, button), "{button} is in the picture");
    }
    assert!(reads(&harness, "aila"), "the picture does not say what it is of");
}

/// What is said of a ray is said of the one that a click selects.
#[test]
fn what_the_pointer_is_on_is_said() {
    let (_folder, context) = opened();
    let mut harness = panel("scene", context);
    harness.get_by_label("Cost").click();
    settle(&mut harness);
    let mut said = 0;
    for at in (0..120).map(|at| egui::pos2(60.0 + 40.0 * (at % 20) as f32, 150.0 + 70.0 * (at / 20) as f32)) {
        harness.event(egui::Event::PointerMoved(at));
        harness.run_steps(8);
        let tip = harness.query_all_by_label_contains(" at place ").last().map(|tip| {
            let node = tip.accesskit_node();
            node.label().or(node.value()).unwrap()
        });
        for pressed in [true, false] {
            let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
            harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
            harness.step();
        }
        let context = &mut harness.state_mut().context;
        let order = context.awaited_order().unwrap();
        let selected = context.selection.ray;
        let expected = selected.map(|ray| format!("ray {ray} at place {}, ", order.place_of_ray()[ray]));
        assert_eq!(tip.is_some(), expected.is_some(), "{tip:?} {expected:?}");
        if let (Some(tip), Some(expected)) = (tip, expected) {
            assert!(tip.starts_with(&expected), "{tip}, expected {expected}");
            said += 1;
        }
    }
    assert!(said > 1, "the pointer was on {said} rays");
}

/// The times of `auto` without those of a sort are its trace of unsorted rays and nothing more.
#[test]
fn what_auto_left_alone_has_no_speedup_among_the_times() {
    let (_folder, path) = written();
    let speedups = || {
        let context = Context::open(std::slice::from_ref(&path));
        let mut harness = panel("timings", context);
        let State { panel, context } = harness.state_mut();
        let table = panel.data(context).ok().unwrap().text();
        table.lines().filter(|line| line.starts_with("auto\t") && line.contains("speedup")).count()
    };
    assert_eq!(speedups(), 2, "of the trace and net");
    sample::edit_manifest(&path, |records| {
        let is_sort = |timing: &TimingRecord| timing.method == AUTO && timing.stage == StageName::Sort;
        records.retain(|record| !matches!(record, Record::Timing(timing) if is_sort(timing)));
    });
    assert_eq!(speedups(), 0);
}
