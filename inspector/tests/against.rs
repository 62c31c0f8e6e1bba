//! Order A against order B: the strip, the table of methods, and what follows when one of them is another.
//! Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use formats::key::method::{AUTO, UNSORTED};
use formats::manifest::{QueueId, Record};
use formats::metrics::frame::{Frame, summed};
use formats::metrics::samples::Samples;
use formats::ray::Kind;
use formats::reader::Dump;
use inspector::analysis::Metric;
use inspector::app::App;
use inspector::model::Context;
use inspector::model::what_if::WHAT_IF;
use inspector::panels::space::options::SpaceOptions;
use inspector::session::Session;
use serde_json::json;
use tempfile::TempDir;

mod headless;

use headless::sample::{self, QUEUE};
use headless::{State, builtin, click, opened, panel, panel_made, reads, sampled, settle, window, written};

/// The sample as it is first seen: by its best order.
fn at_first() -> (TempDir, Context) {
    let (folder, dump) = written();
    (folder, opened(dump, QUEUE))
}

/// The ratios on the screen that have the sign of a ratio.
fn ratios(harness: &Harness<'_, App>) -> Vec<String> {
    let height = harness.get_by_label("Bounce").rect().bottom() + 60.0;
    let seen = harness.query_all_by_label_contains("\u{d7}");
    let place =
        |node: &egui_kittest::Node<'_>| node.accesskit_node().raw_bounds().map(|bounds| bounds.y1 as f32);
    let in_strip = seen.filter(|node| place(node).is_some_and(|bottom| bottom < height));
    in_strip.filter_map(|node| node.accesskit_node().label().or(node.accesskit_node().value())).collect()
}

/// What the strip should read: net and trace on the frame, then of the selected rays.
fn expected(context: &Context) -> Vec<String> {
    let [frame, selected] = context.versus().unwrap();
    let lines = [&frame.net, &frame.trace, &selected.net, &selected.trace];
    lines.map(|line| format!("{:.2}\u{d7}", line.known().unwrap().ratio)).to_vec()
}

fn row<'a>(harness: &'a Harness<'_, App>, method: &'a str) -> egui_kittest::Node<'a> {
    let mut nodes: Vec<_> = harness.query_all_by_label(method).collect();
    // The lists of the strip have the names of A and B, too.
    nodes.retain(|node| node.rect().left() > 700.0);
    nodes.into_iter().next().unwrap()
}

#[test]
fn a_row_that_is_clicked_is_b_and_with_shift_a_and_the_strip_follows() {
    let (_folder, context) = at_first();
    let mut harness = window(|format| App::showing(context, format.into()));
    // Room for all rows.
    harness.set_size(egui::vec2(1280.0, 1000.0));
    settle(&mut harness);
    let names = |harness: &Harness<'_, App>| {
        let selection = &harness.state().context.selection;
        (selection.baseline.method.clone(), selection.method.clone())
    };
    let best = harness.state().context.recording().unwrap().best_method(QUEUE).to_owned();
    assert_eq!(names(&harness), (UNSORTED.to_owned(), best), "the best method is B at first");
    assert_eq!(ratios(&harness), expected(&harness.state().context));
    row(&harness, "aila").click();
    settle(&mut harness);
    assert_eq!(names(&harness), (UNSORTED.to_owned(), "aila".to_owned()));
    let over_unsorted = ratios(&harness);
    assert_eq!(over_unsorted, expected(&harness.state().context));
    row(&harness, "mine").click_modifiers(Modifiers::SHIFT);
    settle(&mut harness);
    assert_eq!(names(&harness), ("mine".to_owned(), "aila".to_owned()));
    assert_eq!(ratios(&harness), expected(&harness.state().context));
    assert_ne!(ratios(&harness), over_unsorted);
}

/// Over unsorted rays the frame is that of the table in which recordings end; over another method it is the median
/// of the rounds' ratios.
#[test]
fn the_frame_is_that_of_the_closing_table_and_of_any_two_methods() {
    let (_folder, mut context) = at_first();
    let dump = Dump::open(context.recording().unwrap().dump.root()).unwrap();
    let mut compared = 0;
    for row in Frame::of(dump.manifest()).rows {
        context.selection.order_by(&row.method);
        let [frame, _] = context.versus().unwrap();
        match (&frame.net, row.net) {
            (Metric::Known(found), Some(expected)) => {
                assert_eq!(
                    (found.ratio, found.interval),
                    (expected.ratio, expected.interval),
                    "{}",
                    row.method
                );
                compared += 1;
            }
            (Metric::Missing { .. }, _) => {}
            (found, expected) => panic!("{}: {found:?}, {expected:?}", row.method),
        }
    }
    assert!(compared > 3, "{compared} methods");
    context.selection.order_by("aila");
    context.hold_against(None, "mine");
    let samples = Samples::of(dump.manifest());
    let total = |method| {
        let of = |queue| samples.get(queue, method).map(|own| own.totals(samples.way(queue, method)));
        let queues = dump.manifest().queues.iter().map(|record| record.id);
        let queues = queues.filter(|queue| queue.kind == Kind::Shadow || queue.bounce > 0);
        let totals: Vec<Vec<u64>> = queues.filter_map(of).collect();
        summed(totals.iter().map(Vec::as_slice))
    };
    let mut ratios: Vec<f64> =
        total("mine").iter().zip(total("aila")).map(|(a, b)| *a as f64 / b as f64).collect();
    ratios.sort_by(f64::total_cmp);
    let [frame, _] = context.versus().unwrap();
    assert_eq!(frame.net.known().unwrap().ratio, ratios[ratios.len() / 2]);
}

/// B, the table's numbers and its order are those of the strip, and B is the method that `info` names.
#[test]
fn b_and_the_table_go_by_the_number_in_the_strip() {
    let (_folder, mut context) = at_first();
    let dump = Dump::open(context.recording().unwrap().dump.root()).unwrap();
    let said = Frame::of(dump.manifest()).text();
    assert!(said.contains(&format!("with {}, one of ", context.selection.method)), "{said}");
    let ranking = context.ranking(1);
    let nets: Vec<f64> = ranking.iter().filter_map(|order| order.gain(&order.net)).collect();
    assert!(nets.len() > 3 && nets.is_sorted_by(|a, b| a >= b), "{nets:?}");
    for order in ranking.iter().filter(|order| order.method != UNSORTED) {
        context.selection.order_by(&order.method);
        let [frame, _] = context.versus().unwrap();
        assert_eq!((&order.net, &order.trace), (&frame.net, &frame.trace), "{}", order.method);
    }
}

/// B is the best order of the recording that is looked at, until another one is chosen.
#[test]
fn of_several_recordings_b_is_the_best_of_each() {
    let (_folder, whole) = written();
    let queues: Vec<QueueId> =
        Dump::open(&whole).unwrap().manifest().queues.iter().map(|record| record.id).collect();
    let other = sample::thinned(&whole, "other", &queues, &["two-point"]);
    let mut context = Context::open(&[other, whole]);
    assert!(context.problems.is_empty(), "{:?}", context.problems);
    let best = context.recording().unwrap().best_method(context.selection.queue).to_owned();
    assert_ne!(best, "two-point", "the sample has a better one");
    assert_eq!(context.selection.method, best);
    context.select_recording(0);
    assert_eq!(context.selection.method, "two-point");
    context.order_by(UNSORTED);
    context.select_recording(1);
    assert_eq!(context.selection.method, UNSORTED, "what was chosen stays");
}

/// Whatever its times are, they say nothing of an order.
#[test]
fn auto_that_left_all_alone_is_not_b() {
    let (_folder, dump) = written();
    // Without the record of what it chose.
    let alone = sample::thinned(&dump, "alone", &[QUEUE], &["two-point", AUTO]);
    let mut context = Context::open(&[alone]);
    assert_eq!(context.selection.method, "two-point");
    let ranking = context.ranking(1);
    let auto = ranking.iter().find(|order| order.method == AUTO).unwrap();
    assert_eq!((auto.net.known(), auto.trace.known()), (None, None), "{ranking:?}");
}

#[test]
fn a_frame_has_rays_that_a_method_does_not_order_as_they_lie() {
    const SHADOW_RAYS_ALONE: &str = "light-octahedron";
    let (_folder, dump) = written();
    let dump = Dump::open(&dump).unwrap();
    let samples = Samples::of(dump.manifest());
    let queues = dump.manifest().queues.iter().map(|record| record.id);
    let is_timed = |queue: &QueueId| queue.pass == QUEUE.pass;
    let queues = queues.filter(|queue| queue.kind == Kind::Shadow || queue.bounce > 0);
    let queues: Vec<QueueId> = queues.filter(is_timed).collect();
    let unsorted = |queue| samples.get(queue, UNSORTED).unwrap().traced().to_vec();
    let own = |queue: QueueId| match queue.kind {
        Kind::Closest => unsorted(queue),
        Kind::Shadow => {
            let own = samples.get(queue, SHADOW_RAYS_ALONE).unwrap();
            own.totals(samples.way(queue, SHADOW_RAYS_ALONE))
        }
    };
    let sum = |of: &dyn Fn(QueueId) -> Vec<u64>, round: usize| -> u64 {
        queues.iter().map(|queue| of(*queue)[round]).sum()
    };
    let mut ratios =
        [0, 1, 2, 3, 4, 5, 6].map(|round| sum(&unsorted, round) as f64 / sum(&own, round) as f64);
    ratios.sort_by(f64::total_cmp);
    let rows = Frame::of(dump.manifest()).rows;
    let row = rows.iter().find(|row| row.method == SHADOW_RAYS_ALONE).unwrap();
    assert_eq!((row.secondary, row.net.unwrap().ratio), (None, ratios[3]));
}

#[test]
fn an_order_that_is_made_can_be_a_beside_b() {
    let (_folder, mut context) = sampled("aila");
    context.what_if = Some(builtin(&context, "origin"));
    context.hold_against(None, WHAT_IF);
    let mut harness = panel_made("scene", [900.0, 640.0], context, json!({ "side_by_side": true }));
    for side in [WHAT_IF, "aila"] {
        assert!(reads(&harness, side), "{side} has no picture");
    }
    let context = &mut harness.state_mut().context;
    let a = context.of_baseline(|_| None, |context| context.order().unwrap());
    assert_eq!((a.method.as_str(), context.order().unwrap().method.as_str()), (WHAT_IF, "aila"));
    harness.render().unwrap();
}

#[test]
fn an_order_that_is_made_is_among_the_capsules_too() {
    let (_folder, mut context) = at_first();
    context.what_if = Some(builtin(&context, "origin"));
    context.selection.order_by(WHAT_IF);
    let mut harness = panel("coherence", context);
    settle(&mut harness);
    harness.get_by_label_contains(&format!("{WHAT_IF}: median "));
}

#[test]
fn the_table_has_all_orders_the_best_first() {
    let (_folder, mut context) = at_first();
    context.what_if = Some(builtin(&context, "origin"));
    let harness = panel("methods", context);
    let top = |name: &str| harness.get_by_label(name).rect().top();
    let context = &harness.state().context;
    let best = context.recording().unwrap().best_method(QUEUE);
    for name in context.methods() {
        assert!(top(&name) >= top(best), "{name} is above {best}");
    }
    assert!(top(WHAT_IF) > top(UNSORTED), "what was not measured is below what was");
}

/// The net speedups by kind of rays are those of the table that `info` ends in.
#[test]
fn the_table_has_what_each_kind_of_rays_gains() {
    let (_folder, mut context) = at_first();
    let frame = Frame::of(context.recording().unwrap().dump.manifest());
    let ranking = context.ranking(0);
    let mut compared = 0;
    for row in &frame.rows {
        let Some(order) = ranking.iter().find(|order| order.method == row.method) else { continue };
        for (on, expected) in order.by_rays.iter().zip([row.net_secondary, row.net_shadow]) {
            let Some(expected) = expected else { continue };
            let found = on.all.known().unwrap();
            assert_eq!((found.ratio, found.interval), (expected.ratio, expected.interval), "{}", row.method);
            assert!(!on.by_bounce.is_empty());
            compared += 1;
        }
    }
    assert!(compared > 2, "{compared} compared");
}

/// Below the table stands what B gains on each bounce; a click on a number goes to those rays, in the same order.
#[test]
fn what_an_order_gains_is_said_by_bounce() {
    let (_folder, mut context) = at_first();
    context.order_by("aila");
    let times = context.recording().unwrap().times.clone().unwrap();
    let mut harness = panel("methods", context);
    let queues = times.measured().filter(|queue| queue.bounce > 0 || queue.kind == Kind::Shadow);
    let mut clicked = 0;
    for queue in queues.filter(|queue| queue.id() != QUEUE) {
        let Some(net) = queue.order("aila").and_then(|order| order.net_speedup.known()) else { continue };
        let number = format!("{:.2}\u{d7}", net.ratio);
        let cells: Vec<_> = harness.get_all_by_role(Role::Button).collect();
        // Shadow rays, which may gain as much as secondary ones, come last.
        let cell = cells.iter().rfind(|cell| cell.accesskit_node().label().unwrap().ends_with(&number));
        let place = cell.unwrap_or_else(|| panic!("no {number}")).rect().center();
        click(&mut harness, place);
        let selection = &harness.state().context.selection;
        assert_eq!((selection.queue, &*selection.method), (queue.id(), "aila"));
        clicked += 1;
    }
    assert!(clicked > 0);
    harness.state_mut().context.order_by(UNSORTED);
    settle(&mut harness);
    assert!(harness.query_by_role(Role::Button).is_none(), "it gains nothing over itself");
}

/// What orders shadow rays alone is in the table of closest rays, too, and a click goes to those; B comes back with the
/// rays that it was chosen for.
#[test]
fn an_order_of_other_rays_is_found_and_comes_back() {
    const THEIRS: &str = "light-octahedron";
    let (_folder, context) = at_first();
    let mut harness = panel("methods", context);
    assert!(!harness.state().context.methods().contains(&THEIRS.to_owned()));
    let row = harness.get_by_label(THEIRS).rect().center();
    click(&mut harness, row);
    let context = &mut harness.state_mut().context;
    let shadow = QueueId { kind: Kind::Shadow, ..QUEUE };
    assert_eq!((context.selection.queue, &*context.selection.method), (shadow, THEIRS));
    context.go_to(QUEUE);
    assert!(context.methods().contains(&context.selection.method));
    context.go_to(shadow);
    assert_eq!(context.selection.method, THEIRS);
    context.go_to(QUEUE);
    context.order_by("aila");
    context.go_to(shadow);
    assert_eq!(context.selection.method, "aila", "what was chosen meanwhile stays");
}

/// An order of other bounces and of the other kind, too: a click stays with the kind that is looked at.
#[test]
fn an_order_is_looked_for_in_rays_of_the_same_kind_first() {
    let (_folder, dump) = written();
    sample::edit_records(&dump, |record| {
        if let Record::Queue(queue) = record
            && queue.id == QUEUE
        {
            queue.methods.retain(|method| method != "mine");
        }
    });
    let mut context = opened(dump, QUEUE);
    let mine = "mine".to_owned();
    let shadow = QueueId { kind: Kind::Shadow, ..QUEUE };
    assert!(!context.methods().contains(&mine));
    assert!(context.recording().unwrap().methods(shadow).contains(&mine), "nearer, but of the other kind");
    context.go_where_measured("mine");
    assert!(context.methods().contains(&mine));
    let QueueId { bounce, kind, .. } = context.selection.queue;
    assert_eq!((bounce, kind), (QUEUE.bounce - 1, Kind::Closest));
}

/// Unsorted rays beside themselves would answer nothing.
#[test]
fn auto_is_not_compared_where_it_left_rays_alone() {
    let (_folder, dump) = written();
    let best =
        |dump: &Path| opened(dump.to_owned(), QUEUE).recording().unwrap().best_method(QUEUE).to_owned();
    sample::edit_records(&dump, |record| {
        if let Record::Queue(queue) = record {
            queue.methods.retain(|method| method != "mine");
        }
    });
    assert_eq!(best(&dump), AUTO);
    sample::edit_records(&dump, |record| {
        if let Record::Decision(decision) = record {
            decision.choice = None;
        }
    });
    assert_ne!(best(&dump), AUTO);
}

/// Colours stand for the same numbers in all orders of a queue.
#[test]
fn the_range_of_colours_stays_while_orders_change() {
    let (_folder, context) = sampled("two-point");
    let mut options = serde_json::to_value(SpaceOptions::default()).unwrap();
    options["colour_by"] = "area".into();
    let mut harness = panel_made("scene", [900.0, 640.0], context, json!({ "options": options }));
    let range =
        |harness: &mut Harness<'_, State>| harness.state_mut().panel.space().unwrap().range().unwrap();
    let first = range(&mut harness);
    harness.state_mut().context.order_by(UNSORTED);
    settle(&mut harness);
    assert_eq!(range(&mut harness), first, "another order, another range");
    harness.state_mut().context.go_to(QueueId { bounce: 0, ..QUEUE });
    settle(&mut harness);
    assert_ne!(range(&mut harness), first, "other rays have a range of their own");
}

/// Escape closes what is on top, and nothing else.
#[test]
fn escape_closes_one_thing_after_the_other() {
    let (_folder, context) = at_first();
    let mut harness = window(|format| App::showing(context, format.into()));
    harness.state_mut().context.select_rays(vec![3, 5]);
    harness.get_by_label("File").click();
    settle(&mut harness);
    harness.event(egui::Event::Text("?".to_owned()));
    settle(&mut harness);
    let state = |harness: &Harness<'_, App>| {
        let rays = harness.state().context.selection.rays();
        (reads(harness, "Quit"), reads(harness, "Keys and words"), rays.len())
    };
    for expected in [(true, true, 2), (false, true, 2), (false, false, 2), (false, false, 0)] {
        assert_eq!(state(&harness), expected);
        harness.key_press_modifiers(Modifiers::NONE, Key::Escape);
        settle(&mut harness);
    }
}

/// A session of a version before, with panels that are gone: what it compared is A against B now.
#[test]
fn a_session_of_before_has_its_two_orders() {
    let (folder, context) = sampled("aila");
    let mut harness = window(|format| App::showing(context, format.into()));
    let drawn_on = harness.ctx.clone();
    let mut session = serde_json::to_value(harness.state().session(&drawn_on)).unwrap();
    session["version"] = 2.into();
    let selection = session["selection"].as_object_mut().unwrap();
    selection.remove("baseline").unwrap();
    selection.remove("baseline_recording").unwrap();
    let compare = json!({
        "before": "mine", "before_recording": null, "difference": "hit", "table": true, "all_rows": false,
        "options": session["panels"]["scene"]["options"].clone(), "camera": null
    });
    session["panels"]["compare"] = compare;
    // It kept nothing then.
    session["panels"]["coherence"] = serde_json::Value::Null;
    let scene = session["panels"]["scene"].as_object_mut().unwrap();
    for added in ["side_by_side", "difference", "table", "properties"] {
        scene.remove(added).unwrap();
    }
    let layout = session["layout"].to_string();
    let layout = layout.replace(r#""methods""#, r#""navigator""#).replace(r#""pixels""#, r#""order""#);
    session["layout"] = serde_json::from_str(&layout).unwrap();
    let file = folder.path().join("before.json");
    std::fs::write(&file, session.to_string()).unwrap();
    assert!(Session::read(&file).is_ok());
    harness.state_mut().open_session(&file, &drawn_on);
    settle(&mut harness);
    let context = &harness.state().context;
    assert!(context.problems.is_empty(), "{:?}", context.problems);
    let selection = &context.selection;
    assert_eq!((selection.baseline.method.as_str(), selection.method.as_str()), ("mine", "aila"));
    assert!(reads(&harness, "secondary"), "the table of methods is not there");
}
