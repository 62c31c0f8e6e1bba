//! Two orders and two recordings beside each other, and what views in space draw: vertices, not pixels alone.
//! Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use formats::manifest::scan::scan;
use formats::manifest::{Header, MethodArray, Place, QueueArray, QueueId, Record};
use formats::ray::{Hit, Kind};
use formats::reader::Dump;
use formats::writer::DumpWriter;
use glam::Vec3;
use inspector::analysis::GroupWidth;
use inspector::analysis::comparison::{Comparison, Difference};
use inspector::analysis::differences;
use inspector::model::numbers::Numbers;
use inspector::model::{Context, Order};
use inspector::panels::space::layers::{Layers, RayValues};
use inspector::panels::space::options::{Axis, Side, SpaceOptions};
use inspector::panels::space::{cut, room};
use inspector::render::camera::Camera;
use inspector::render::geometry::{Geometry, Mark, Shape};
use inspector::render::picture::{Cut, Layer, LayerUniform, Paint, SpacePicture, Stage};
use inspector::render::surfaces::Surfaces;
use serde_json::json;
use tempfile::TempDir;

mod headless;

use headless::sample::{self, QUEUE};
use headless::{State, panel_made, reads, shown_by, written};

const SHADOW: QueueId = QueueId { kind: Kind::Shadow, ..QUEUE };

/// The ray that hits something else in the altered recording, and the one whose key is another.
const OTHER_HIT: usize = 4;
const OTHER_KEY: usize = 9;

/// Beside the dump `whole` another one of the same scene: another seed, adapter and kernel, one hit moved to
/// another triangle, one key of `aila` changed.
fn altered(whole: &Path) -> PathBuf {
    let source = Dump::open(whole).unwrap();
    let mut header: Header = sample::header();
    header.options.seed += 1;
    header.options.trace_kernel = "cwbvh".to_owned();
    header.adapter.name = "another processor".to_owned();
    let mut writer = DumpWriter::create(&whole.with_file_name("altered"), header, false).unwrap();
    for frame in scan(&whole.join("manifest.bin")).unwrap().frames {
        match frame.record {
            Record::Header(_) => {}
            Record::Array(array) => {
                let mut bytes = source.bytes(&array).unwrap().to_vec();
                if array.place == Place::Queue(QUEUE, QueueArray::Hits) {
                    let hit = &mut bytes[OTHER_HIT * size_of::<Hit>()..];
                    let near: f32 = 0.5 * f32::from_le_bytes(hit[..4].try_into().unwrap());
                    hit[..4].copy_from_slice(&near.to_le_bytes());
                    hit[4] ^= 1;
                }
                if array.place == Place::Method(QUEUE, "aila".to_owned(), MethodArray::Keys) {
                    bytes[OTHER_KEY * 4] ^= 1;
                }
                let mut file = writer.array(&array.place, array.dtype, &array.shape).unwrap();
                file.write(&bytes).unwrap();
                file.finish().unwrap();
            }
            Record::End(end) => return writer.finish(end).unwrap(),
            record => writer.record(&record).unwrap(),
        }
    }
    panic!("the sample has an end")
}

fn recorded() -> (TempDir, Context) {
    let (folder, dump) = written();
    (folder, Context::open(&[dump]))
}

fn order(context: &mut Context, recording: usize, method: &str) -> Arc<Order> {
    context.select_recording(recording);
    context.go_to(QUEUE);
    context.selection.order_by(method);
    context.awaited_order().unwrap()
}

fn compared(orders: [&Arc<Order>; 2], width: GroupWidth, difference: Difference) -> Comparison {
    let [left, right] = orders.map(|order| Numbers::of(order.clone(), &sample::header(), width));
    Comparison::of(&[left.side(), right.side()], Some(difference))
}

/// A number for each ray on the left.
fn values(orders: [&Arc<Order>; 2], width: GroupWidth, difference: Difference) -> Arc<Vec<f32>> {
    let [left, _] = compared(orders, width, difference).values.unwrap();
    left
}

#[test]
fn two_orders_differ_in_places_and_areas_alone() {
    let (_folder, mut context) = recorded();
    let [left, right] = ["unsorted", "two-point"].map(|method| order(&mut context, 0, method));
    let comparison = compared([&left, &right], GroupWidth::Rays32, Difference::Displacement);
    let counts = &comparison.counts;
    assert_eq!((counts.matched, counts.hits, counts.distances), (left.len(), 0, 0));
    assert!(counts.keys.clone().unwrap_err().contains("no key"), "{:?}", counts.keys);
    let moved = (0..right.len()).filter(|&place| right.places.ray(place) != place).count();
    assert!(moved > 0);
    assert_eq!(counts.places, moved);
    let [moves, again] = comparison.values.as_ref().unwrap();
    assert_eq!(moves, again);
    for (ray, value) in moves.iter().enumerate() {
        let expected = (f64::from(right.place_of_ray()[ray]) - ray as f64).abs() / right.len() as f64;
        assert_eq!(*value, expected as f32);
    }
    let areas = values([&left, &right], GroupWidth::Rays32, Difference::CapsuleArea);
    let area = |order: &Order, ray: usize| {
        let groups = order.groups(GroupWidth::Rays32);
        groups.groups[order.place_of_ray()[ray] as usize / 32].area
    };
    for (ray, value) in areas.iter().enumerate() {
        assert!((value - (area(&right, ray) / area(&left, ray)).log2() as f32).abs() < 1e-6);
    }
}

#[test]
fn two_recordings_differ_where_they_were_made_to() {
    let (_folder, whole) = written();
    let mut context = Context::open(&[whole.clone(), altered(&whole)]);
    assert!(context.problems.is_empty(), "{:?}", context.problems);
    let [left, right] = [0, 1].map(|recording| order(&mut context, recording, "aila"));
    let values = |difference| values([&left, &right], GroupWidth::Rays64, difference);
    let comparison = compared([&left, &right], GroupWidth::Rays64, Difference::Hit);
    let counts = &comparison.counts;
    assert_eq!((counts.hits, counts.distances, &counts.keys, counts.places), (1, 1, &Ok(1), 0));
    let one = |difference, ray: usize| {
        values(difference).iter().enumerate().all(|(at, value)| (*value > 0.0) == (at == ray))
    };
    assert!(one(Difference::Hit, OTHER_HIT) && one(Difference::Key, OTHER_KEY));
    let distances = values(Difference::Distance);
    assert!((distances[OTHER_HIT] - 0.5f32.log10()).abs() < 1e-6, "{}", distances[OTHER_HIT]);
    assert_eq!(comparison.left_of(3), Some(3));
    let settings = differences::settings([0, 1].map(|at| &context.recordings[at].shown));
    let differing: BTreeSet<&str> = settings.iter().filter(|row| row.differs).map(|row| row.what).collect();
    assert_eq!(differing, BTreeSet::from(["seed", "trace kernel", "adapter"]));
    let numbers = differences::counts(&comparison);
    let differing: BTreeSet<&str> = numbers.iter().filter(|row| row.differs).map(|row| row.what).collect();
    let expected = ["distances", "hits", "keys"];
    assert_eq!(differing, BTreeSet::from(expected));
}

#[test]
fn rays_of_queues_of_other_paths_are_matched_by_path() {
    let (_folder, mut context) = recorded();
    let right = order(&mut context, 0, "unsorted");
    context.go_to(QueueId { bounce: 0, ..QUEUE });
    let left = context.awaited_order().unwrap();
    assert!(left.len() > right.len(), "some paths ended");
    let comparison = compared([&left, &right], GroupWidth::Rays64, Difference::Hit);
    assert_eq!(comparison.counts.matched, right.len());
    for ray in 0..right.len() {
        let of_left = comparison.left_of(ray).unwrap();
        assert_eq!(left.queue.path_ids[of_left], right.queue.path_ids[ray]);
        assert_eq!(comparison.right_of(of_left), Some(ray));
    }
    let [values, _] = comparison.values.unwrap();
    let alone = values.iter().filter(|value| value.is_nan()).count();
    assert_eq!(alone, left.len() - right.len());
}

#[test]
fn the_panel_shows_a_line_for_each_difference_and_the_same_picture_each_time() {
    let (_folder, whole) = written();
    let other = altered(&whole);
    let picture = || {
        let mut context = Context::open(&[whole.clone(), other.clone()]);
        order(&mut context, 1, "aila");
        context.hold_against(Some(0), "aila");
        let wanted = json!({ "side_by_side": true, "difference": "hit", "table": true });
        let mut harness = panel_made("scene", [900.0, 900.0], context, wanted);
        for text in ["seed", "trace kernel", "adapter", "hits", "keys", "another processor", "1 differ"] {
            assert!(reads(&harness, text), "{text} is not shown");
        }
        assert!(!reads(&harness, "scene hash"), "what is the same is left out");
        let State { panel, context } = harness.state_mut();
        let csv = panel.data(context).ok().unwrap().text();
        assert!(csv.contains("seed\t7\t8\ttrue\n") && csv.contains("bounces\t2\t2\tfalse\n"), "{csv}");
        harness.render().unwrap()
    };
    assert!(picture() == picture(), "the picture differs from one time to the next");
}

fn layers(context: &mut Context, options: &SpaceOptions, values: Option<RayValues>) -> Vec<Layer> {
    let mut layers = Layers::default();
    layers.ray_values = values;
    shown_by(&mut layers, context, options)
}

#[test]
fn ends_are_marked_by_what_rays_found() {
    let (_folder, mut context) = recorded();
    for (queue, kinds) in [(QUEUE, [Mark::Hit, Mark::Miss]), (SHADOW, [Mark::Occluded, Mark::Miss])] {
        context.go_to(queue);
        context.order_by("unsorted");
        let order = context.awaited_order().unwrap();
        let options =
            SpaceOptions { curve: false, rays: true, ends: true, arrows: true, ..SpaceOptions::default() };
        let drawn = layers(&mut context, &options, None);
        let of = |stage: Stage| drawn.iter().find(|layer| layer.stage == stage).unwrap();
        let Shape::Segments(marks) = of(Stage::Marks).geometry.shape() else { panic!("no marks") };
        let Shape::Segments(heads) = of(Stage::Arrows).geometry.shape() else { panic!("no heads") };
        let mut seen = BTreeSet::new();
        for (ray, [at, mark]) in marks.iter().enumerate() {
            let expected = kinds[usize::from(!order.queue.is_at_surface(ray))];
            assert_eq!(mark.value, expected as u8 as f32);
            seen.insert(mark.value as u8);
            // Marks and heads are where the ray ends, not where it starts.
            assert_eq!((at.position, mark.position), (heads[ray][1].position, heads[ray][1].position));
            let origin = order.queue.segment(ray).origin.map(|along| along as f32);
            assert_eq!(heads[ray][0].position, origin);
        }
        assert_eq!(seen, kinds.iter().map(|kind| *kind as u8).collect());
    }
}

#[test]
fn the_edges_of_surfaces_are_drawn_once() {
    let unit = formats::unit_space::UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let square = Surfaces::new(&unit, &corners, &[[0, 1, 2], [2, 1, 3]], &[]);
    let Shape::Segments(edges) = Shape::edges(&square) else { panic!("edges are lines") };
    let found: BTreeSet<String> =
        edges.iter().map(|[a, b]| format!("{:?} {:?}", a.position, b.position)).collect();
    assert_eq!((edges.len(), found.len()), (5, 5), "the diagonal is shared: {found:?}");
}

#[test]
fn the_clipping_plane_cuts_surfaces_alone() {
    let sides = [1.0, 0.5, 0.25];
    let options = |clip_axis, clip_at, clip_keeps| SpaceOptions {
        clip_axis,
        clip_at,
        clip_keeps,
        ..SpaceOptions::default()
    };
    assert_eq!(cut(&SpaceOptions::default(), sides), Cut::NONE);
    assert_eq!(cut(&options(Axis::Z, 0.0, Side::Above), sides), Cut::NONE);
    for (axis, number) in [(Axis::X, 0), (Axis::Y, 1), (Axis::Z, 2)] {
        for side in [Side::Below, Side::Above] {
            let cut = cut(&options(axis, 0.5, side), sides);
            let is_cut = |part: f32| {
                let mut point = [0.1; 3];
                point[number] = part * sides[number];
                (0..3).map(|axis| cut.normal[axis] * point[axis]).sum::<f32>() > cut.offset
            };
            assert_eq!(
                (is_cut(0.4), is_cut(0.6)),
                (side == Side::Above, side == Side::Below),
                "{axis:?} {side:?}"
            );
        }
    }
    let nothing = Geometry::from(Shape::Segments(Vec::new()));
    let layer = |stage| Layer::of(&nothing, stage, Paint::Plain([1.0; 4]), 1.0);
    let picture = SpacePicture {
        camera: Camera::overview(sides),
        pixels: [64, 64],
        background: [0.0; 4],
        cut: cut(&options(Axis::X, 0.5, Side::Below), sides),
        room: room(sides, Vec3::splat(0.1), Vec3::splat(2.0)),
        layers: Vec::new(),
    };
    let plane = |stage| LayerUniform::of(&picture, &layer(stage), 1.0).cut;
    for stage in [Stage::Solid, Stage::Ghost, Stage::Wire] {
        assert_eq!(plane(stage), [1.0, 0.0, 0.0, 0.5]);
    }
    for stage in [Stage::Lines, Stage::Marks, Stage::Arrows, Stage::Capsules, Stage::Boxes, Stage::OnTop] {
        assert_eq!(plane(stage), [0.0, 0.0, 0.0, 1.0]);
    }
    assert_eq!(
        LayerUniform::of(&picture, &layer(Stage::Solid), 1.0).room,
        [sides[0], sides[1], sides[2], 1.0]
    );
    // From inside, and of what was recorded from outside, all is drawn.
    assert_eq!(room(sides, Vec3::splat(0.1), Vec3::splat(0.2)), None);
    assert_eq!(room(sides, Vec3::splat(2.0), Vec3::splat(2.0)), None);
}

#[test]
fn cells_are_boxes_in_which_rays_of_earlier_queues_started() {
    let (_folder, mut context) = recorded();
    let order = order(&mut context, 0, "unsorted");
    let touched = order.queue.cells.as_ref().unwrap();
    let options = SpaceOptions { cells: true, cell_count: usize::MAX, ..SpaceOptions::default() };
    let drawn = layers(&mut context, &options, None);
    let cells = drawn.iter().find(|layer| layer.stage == Stage::Boxes).unwrap();
    let Shape::Boxes(boxes) = cells.geometry.shape() else { panic!("no boxes") };
    assert!(!boxes.is_empty() && boxes.len() <= touched.len());
    for [low, high] in boxes {
        assert!((0..3).all(|axis| low.position[axis] < high.position[axis]), "{low:?} {high:?}");
    }
    // Rays of bounce 0 have been added: the box of the camera holds them all.
    let eye = context.recording().unwrap().unit().point(sample::header().camera.eye);
    let holds = |[low, high]: &[inspector::render::geometry::Vertex; 2]| {
        (0..3).all(|axis| (low.position[axis]..=high.position[axis]).contains(&eye[axis]))
    };
    assert!(holds(&boxes[0]), "the box of most rays is not the camera's: {:?}", boxes[0]);
    let few = SpaceOptions { cell_count: 2, ..options };
    let drawn = layers(&mut context, &few, None);
    let cells = drawn.iter().find(|layer| layer.stage == Stage::Boxes).unwrap();
    assert_eq!(cells.geometry.shape(), &Shape::Boxes(boxes[..2].to_vec()));
}

#[test]
fn numbers_of_rays_colour_the_curve_in_any_order() {
    let (_folder, mut context) = recorded();
    let order = order(&mut context, 0, "two-point");
    let of_ray: Vec<f32> = (0..order.len()).map(|ray| ray as f32 + 0.5).collect();
    let values =
        RayValues { id: 1, title: "numbers", of_ray: Arc::new(of_ray), range: None, logarithm: None };
    let drawn = layers(&mut context, &SpaceOptions::default(), Some(values));
    let Shape::Strip(curve) = drawn[0].geometry.shape() else { panic!("no curve") };
    let found: Vec<f32> = curve.iter().map(|vertex| vertex.value).collect();
    assert_eq!(found, (0..order.len()).map(|place| order.places.ray(place) as f32 + 0.5).collect::<Vec<_>>());
}
