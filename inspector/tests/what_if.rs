//! Orders that are made here against recorded ones, and lists whose entries are clicked.
//! Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use formats::key::Facts;
use inspector::analysis::{GroupWidth, Metric};
use inspector::model::coherences::OrderCoherence;
use inspector::model::key::{ReadKey, field_text};
use inspector::model::what_if::{Estimate, Settings, WHAT_IF};
use inspector::model::{Context, Order};
use inspector::panels::space::options::SpaceOptions;
use inspector::render::geometry::Shape;
use inspector::render::picture::Stage;

mod headless;

use headless::{awaited, builtin, click, layers, panel, passing, sampled, sampled_panel, settle};

/// Of every method on every queue: keys and places, bit for bit, as they were recorded.
#[test]
fn recorded_settings_give_recorded_keys_and_places() {
    let (_folder, mut context) = sampled("two-point");
    let dump = context.recording().unwrap().dump.clone();
    let mut compared = 0;
    for record in &dump.manifest().queues {
        context.go_to(record.id);
        let has_layout = |method: &&String| *method != "unsorted" && *method != "auto";
        for method in record.methods.iter().filter(has_layout) {
            context.selection.order_by(method);
            let recorded = context.awaited_order().unwrap();
            context.what_if = Some(Settings::of(context.recording().unwrap().method(method).unwrap()));
            context.selection.order_by(WHAT_IF);
            let made = context.awaited_order().unwrap();
            let ((recorded_keys, _), (made_keys, _)) =
                (recorded.keys.as_ref().unwrap(), made.keys.as_ref().unwrap());
            for at in 0..recorded.len() {
                assert_eq!(made_keys.at(at), recorded_keys.at(at), "{} by {method}: key {at}", record.id);
                assert_eq!(
                    made.places.ray(at),
                    recorded.places.ray(at),
                    "{} by {method}: place {at}",
                    record.id
                );
            }
            compared += recorded.len();
        }
    }
    assert!(compared > 1000, "{compared} keys are too few");
}

/// Keys of the words for curves, exclusive or and lengths, read back field by field.
#[test]
fn curves_and_lengths_are_typed_and_explained() {
    let (_folder, mut context) = sampled("two-point");
    let header = context.recording().unwrap().dump.manifest().header.clone();
    let mut made = |text: &str| {
        let mut settings = Settings::named(text, &header);
        settings.key_bits = 32;
        context.what_if = Some(settings);
        context.selection.order_by(WHAT_IF);
        context.awaited_order().unwrap()
    };
    let keys = |order: &Order| {
        let (keys, _) = order.keys.as_ref().unwrap();
        (0..order.len()).map(|ray| keys.at(ray)).collect::<Vec<_>>()
    };
    let learnt = made("two-point-adaptive");
    assert_eq!(keys(&learnt), keys(&made("(ox oy oz ex ey ez)*10 ox oy oz ex @adaptive")));
    let origin = made("origin");
    let curve = made("hilbert(ox oy oz)*");
    let words = |order: &Order, ray: usize| {
        let key = ReadKey::of(order, ray).unwrap();
        (key.fields.iter().map(field_text).collect::<Vec<_>>(), key)
    };
    for ray in 0..origin.len() {
        let ((_, morton), (_, hilbert)) = (words(&origin, ray), words(&curve, ray));
        for (morton, hilbert) in morton.fields.iter().zip(&hilbert.fields) {
            assert_eq!(morton.value >> (morton.bits - 10), hilbert.value >> (hilbert.bits - 10));
        }
        assert!(hilbert.bits.iter().all(|bit| hilbert.field_of(bit) == Some(0)));
    }
    let mixed = made("two-point-xor");
    let (text, key) = words(&mixed, 3);
    assert_eq!(text[0].split_at(8).0, "ox ^ ex ");
    assert_eq!(key.fields.len(), 3);
    assert!(mixed.readable_fields().is_empty());
    assert_eq!(curve.readable_fields().len(), 3);
}

#[test]
fn what_the_recording_lacks_is_said() {
    let (_folder, mut context) = sampled("two-point");
    context.what_if = Some(builtin(&context, "light-octahedron"));
    context.selection.order_by(WHAT_IF);
    let error = context.awaited_order().unwrap_err();
    assert!(error.contains("only shadow rays have"), "{error}");
}

/// The order that is made has the numbers of the recorded one beside it, and other panels can show it.
#[test]
fn the_order_that_is_made_stands_beside_recorded_ones() {
    let (_folder, mut made) = sampled_panel("what-if", "two-point");
    let context = std::mem::take(&mut made.state_mut().context);
    let mut harness = panel("methods", context);
    let context = &mut harness.state_mut().context;
    let order = context.awaited_order().unwrap();
    let ranking = context.ranking(u64::MAX);
    let of = |name: &str| ranking.iter().find(|order| order.method == name).unwrap();
    assert!(of(WHAT_IF).area.as_ref().is_some_and(|area| area.known().is_some()));
    assert_eq!((&of(WHAT_IF).area, &of(WHAT_IF).lanes), (&of("two-point").area, &of("two-point").lanes));
    harness.get_by_label(WHAT_IF).click();
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    assert_eq!(context.selection.method, WHAT_IF);
    let made = context.awaited_order().unwrap();
    assert_eq!((made.method.as_str(), made.places.ray(9)), (WHAT_IF, order.places.ray(9)));
    assert!(context.methods().iter().any(|method| method == WHAT_IF));
    context.what_if.as_mut().unwrap().estimate = Estimate::Traced;
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    let other = context.awaited_order().unwrap();
    assert_ne!(made.serial, other.serial);
    assert!((0..made.len()).any(|place| made.places.ray(place) != other.places.ray(place)));
}

/// Of each bit the area is that of the order by keys that end there, which the encoder makes by itself.
#[test]
fn a_bit_is_worth_what_keys_that_end_there_are() {
    let (_folder, mut context) = sampled("two-point");
    let header = context.recording().unwrap().dump.manifest().header.clone();
    let area = |context: &mut Context| {
        let area = |found: &OrderCoherence| found.coherence.known().unwrap().mean_capsule_area;
        awaited(context, |context| context.what_if_coherence().map(area)).unwrap()
    };
    for (text, filled) in [("(ox oy oz ex ey ez)*4", 24), ("hilbert(dx dy dz)*4", 12)] {
        let settings = Settings { key_bits: 24, ..Settings::named(text, &header) };
        context.what_if = Some(settings.clone());
        let found = awaited(&mut context, Context::what_if_bits).unwrap();
        assert_eq!(found.bits.len(), filled, "{text}: bits of the layout alone");
        for key_bits in 8..=filled as u32 {
            context.what_if = Some(Settings { key_bits, ..settings.clone() });
            let bit = &found.bits[key_bits as usize - 1];
            assert_eq!(bit.mean_capsule_area, area(&mut context), "{text}, {key_bits} bits");
        }
        assert!(found.bits[filled - 1].mean_capsule_area < found.unsorted_area, "{text}");
    }
}

/// Nothing is awaited of an order that cannot be made.
#[test]
fn a_layout_that_is_wrong_has_no_numbers_and_says_why() {
    let (_folder, mut context) = sampled("two-point");
    let settings = builtin(&context, "origin");
    context.what_if = Some(Settings { key_bits: 200, ..settings.clone() });
    context.selection.order_by(WHAT_IF);
    assert_eq!(context.awaited_order().err().unwrap(), "200 key bits, expected 8 to 64");
    context.what_if = Some(Settings { text: "foo*3 (".to_owned(), ..settings });
    let mut harness = panel("methods", context);
    let ranking = harness.state_mut().context.ranking(u64::MAX);
    let order = ranking.iter().find(|order| order.method == WHAT_IF).unwrap();
    for why in [order.area.as_ref().and_then(Metric::reason), order.lanes.as_ref().and_then(Metric::reason)] {
        assert!(why.is_some_and(|why| why.contains("foo")), "{why:?}");
    }
}

#[test]
fn a_layout_that_is_wrong_is_said_where_it_is_typed() {
    let (_folder, mut context) = sampled("two-point");
    let settings = builtin(&context, "origin");
    context.what_if = Some(Settings { text: "ox oy ".to_owned(), ..settings });
    let mut harness = panel("what-if", context);
    harness.get_by_role(Role::TextInput).focus();
    harness.step();
    harness.key_press(egui::Key::End);
    harness.get_by_role(Role::TextInput).type_text("oq");
    settle(&mut harness);
    assert!(harness.query_by_label_contains("character 7: unknown coordinate 'oq'").is_some());
    assert!(
        harness.query_by_label_contains("a row of the table").is_none(),
        "a row of a layout that is none"
    );
}

#[test]
fn a_group_of_the_worst_is_a_capsule_in_space() {
    let (_folder, mut context) = sampled("two-point");
    context.selection.group_width = GroupWidth::Rays32;
    let mut harness = panel("coherence", context);
    let context = &mut harness.state_mut().context;
    let order = context.awaited_order().unwrap();
    let groups = order.groups(context.selection.group_width);
    let mut areas: Vec<(f64, usize)> =
        groups.groups.iter().enumerate().map(|(at, group)| (group.area, at)).collect();
    areas.sort_by(|a, b| b.0.total_cmp(&a.0));
    assert!(areas.len() > 3 && areas.iter().map(|(_, at)| *at).ne(0..areas.len()), "no order to be told");
    let heights: Vec<f32> =
        areas.iter().map(|(area, _)| harness.get_by_label(&format!("{area:.4}")).rect().top()).collect();
    assert!(heights.is_sorted(), "the worst group is not the first");
    let (_, second) = areas[1];
    harness.get_by_label(&second.to_string()).click();
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    assert_eq!(context.selection.group, Some(second));
    let drawn = layers(context, &SpaceOptions::default());
    let capsule = drawn.iter().find(|layer| layer.stage == Stage::Capsules).unwrap();
    let Shape::Capsules(capsules) = capsule.geometry.shape() else { panic!("no capsule") };
    assert_eq!(capsules[0].ends[3], groups.groups[second].capsule.end_radius as f32);
}

#[test]
fn a_cell_that_is_clicked_is_its_rays() {
    let (_folder, mut harness) = sampled_panel("length-table", "two-point");
    let at = egui::pos2(200.0, 300.0);
    click(&mut harness, at);
    let context = &mut harness.state_mut().context;
    let cell = context.selection.cell.expect("a cell is under the pointer");
    let rays = context.rays_of_cell(cell).unwrap();
    assert_eq!(context.selection.ray, rays.first().map(|&ray| ray as usize));
    // A cell that is known to have rays, as the first one under the pointer may have none.
    let order = context.awaited_order().unwrap();
    let queue = order.queue.clone();
    let header = &context.recording().unwrap().dump.manifest().header;
    let cell_of = header.cell_encoder().unwrap();
    let cell_of = |ray: usize| cell_of.encode(&queue.traced.rays()[ray], Facts::default()) as u32;
    let cell = cell_of(7);
    let expected: Vec<u32> =
        (0..queue.len()).filter(|&ray| cell_of(ray) == cell).map(|ray| ray as u32).collect();
    context.selection.cell = Some(cell);
    settle(&mut harness);
    let found = harness.state_mut().context.rays_of_cell(cell).expect("they are known");
    assert_eq!(*found, expected);
    harness.get_by_label("filter these").click();
    settle(&mut harness);
    let context = &mut harness.state_mut().context;
    let passing = passing(context, &order);
    let rays = passing.places().iter().map(|&place| order.places.ray(place as usize) as u32);
    assert_eq!(rays.collect::<BTreeSet<_>>(), expected.iter().copied().collect());
    assert_eq!(passing.len(), expected.len());
    harness.get_by_label(&expected[0].to_string()).click();
    settle(&mut harness);
    assert_eq!(harness.state().context.selection.ray, Some(expected[0] as usize));
}

/// Every ray is counted once, in the bin of the estimate that two-point-adaptive took.
#[test]
fn estimates_are_those_of_the_table() {
    let (_folder, mut context) = sampled("two-point");
    let estimates = awaited(&mut context, Context::estimates).unwrap();
    let queue = context.queue().unwrap();
    let table = queue.table.as_ref().unwrap();
    assert_eq!(estimates.counts.iter().sum::<u32>() as usize, queue.len());
    let (rays, unit) = (queue.traced.rays(), queue.traced.unit());
    let exit = |ray: usize| unit.exit(unit.point(rays[ray].origin), rays[ray].direction);
    let estimate =
        |ray: usize| table.mean(&rays[ray]).min(rays[ray].t_max * unit.scale).min(exit(ray)).max(0.0);
    let ratio = |ray: usize| estimate(ray) / queue.lengths[ray];
    let within = (0..queue.len()).filter(|&ray| (0.5..=2.0).contains(&ratio(ray))).count();
    assert_eq!(estimates.within_factor_two, within as f64 / queue.len() as f64);
    assert!(within > 0 && within < queue.len());
}
