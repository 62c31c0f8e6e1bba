//! What pictures of the scene show: the longest jumps of an order, capsules, and what is selected among the rest.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use inspector::model::Context;
use inspector::model::colour_by::ColourBy;
use inspector::panels::space::options::{CapsuleChoice, SpaceOptions};
use inspector::render::geometry::Shape;
use inspector::render::picture::{Layer, Stage};

mod headless;
#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

use headless::layers;

fn opened(folder: &std::path::Path) -> Context {
    let mut context = Context::open(&[sample::write(folder)]);
    context.order_by("aila");
    context
}

fn strip(layers: &[Layer]) -> &Layer {
    layers.iter().find(|layer| matches!(layer.geometry.shape(), Shape::Strip(_))).unwrap()
}

fn nothing() -> SpaceOptions {
    SpaceOptions { curve: false, ..SpaceOptions::default() }
}

/// Against a sort of all distances from one ray's origin to the next one's.
#[test]
fn the_longest_jumps_are_drawn_in_colours_of_their_own_length() {
    const JUMPS: usize = 5;
    let folder = tempfile::tempdir().unwrap();
    let mut context = opened(folder.path());
    let order = context.awaited_order().unwrap();
    let origin = |place: usize| order.queue.segment(order.places.ray(place)).origin;
    let length = |place: usize| {
        let [here, next] = [origin(place), origin(place + 1)];
        (0..3).map(|axis| (next[axis] - here[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let mut all: Vec<(f64, usize)> = (0..order.len() - 1).map(|place| (length(place), place)).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut expected: Vec<usize> = all[..JUMPS].iter().map(|(_, place)| *place).collect();
    expected.sort_unstable();
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
    let folder = tempfile::tempdir().unwrap();
    let mut context = opened(folder.path());
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

#[test]
fn what_is_not_selected_fades_to_a_tenth() {
    let folder = tempfile::tempdir().unwrap();
    let mut context = opened(folder.path());
    let options = SpaceOptions { jumps: 0, ..SpaceOptions::default() };
    let opacity = |context: &mut Context| strip(&layers(context, &options)).opacity;
    let alone = opacity(&mut context);
    context.select_ray(Some(3));
    assert!((opacity(&mut context) - 0.1 * alone).abs() < 1e-6);
}
