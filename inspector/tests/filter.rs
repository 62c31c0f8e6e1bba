//! Filters and sorted rows against one-line oracles, and in the panels that share the filter.
//! Without an adapter the tests of panels fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::sync::Arc;

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use formats::key::decode::decode;
use formats::length_table::mean_length;
use formats::manifest::{Place, QueueId, SceneArray};
use formats::metrics::quantity::Quantity;
use formats::ray::{Kind, Ray};
use formats::traced::Results;
use inspector::analysis::GroupWidth;
use inspector::filter::Expression;
use inspector::model::colour_by::ColourBy;
use inspector::model::numbers::Numbers;
use inspector::model::rows::{Direction, Rows, Sorting};
use inspector::model::{Context, Order};
use inspector::panels::space::layers::Layers;
use inspector::panels::space::options::SpaceOptions;
use inspector::render::geometry::Shape;
use inspector::theme::Theme;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

mod headless;

use headless::sample::{self, QUEUE};
use headless::{State, ordered, reads, reads_in_part, sampled, sampled_panel, settle, shown_by, written};

fn numbers(context: &mut Context) -> Numbers {
    let order = context.awaited_order().unwrap();
    context.numbers(order).unwrap()
}

/// The places that pass by a closure.
fn kept(order: &Order, keep: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    (0..order.len()).filter(|&place| keep(place, order.places.ray(place))).map(|place| place as u32).collect()
}

fn value(numbers: &Numbers, quantity: Quantity, place: usize) -> f64 {
    numbers.prepare(quantity);
    (quantity.value())(numbers.rays().at(place))
}

fn places(text: &str, numbers: &Numbers) -> Vec<u32> {
    let expression = Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    numbers.passing(&expression).unwrap_or_else(|error| panic!("{text}: {error}")).places().to_vec()
}

/// Each name against the recording, read in another way.
#[test]
fn names_mean_what_the_recording_holds() {
    let (_folder, mut context) = sampled("two-point");
    let numbers = numbers(&mut context);
    let order = &*numbers.order;
    let queue = &order.queue;
    let rays = queue.traced.rays();
    let Results::Hits(hits) = queue.traced.results() else { panic!("closest rays have hits") };
    let (work, table) = (queue.work.as_ref().unwrap(), queue.table.as_ref().unwrap());
    let (keys, layout) = order.keys.as_ref().unwrap();
    let ex = |ray: usize| {
        let fields = decode(&layout.layout, layout.key_bits, keys.at(ray));
        fields.iter().find(|field| field.bit.to_string() == "ex").unwrap().value
    };
    let groups = order.groups(GroupWidth::default());
    let group = |place: usize| &groups.groups[place / 64];
    let width = sample::WIDTH;
    let paths = &queue.path_ids;
    let check = |text: &str, keep: &dyn Fn(usize, usize) -> bool| {
        let expected = kept(order, keep);
        assert!(!expected.is_empty() && expected.len() < order.len(), "{text} tells nothing apart");
        assert_eq!(places(text, &numbers), expected, "{text}");
    };
    check("place < 17", &|place, _| place < 17);
    check("ray >= 40", &|_, ray| ray >= 40);
    check("pixel == 100 || pixel == 77", &|_, ray| [100, 77].contains(&paths[ray]));
    check("x == 3 && y > 5", &|_, ray| paths[ray] % width == 3 && paths[ray] / width > 5);
    check("t < 1.5", &|_, ray| hits[ray].t < 1.5);
    check("length < 0.25", &|_, ray| queue.lengths[ray] < 0.25);
    check("origin.y > 0.5", &|_, ray| rays[ray].origin[1] > 0.5);
    check("dir.z + direction.x > 0", &|_, ray| {
        f64::from(rays[ray].direction[2]) + f64::from(rays[ray].direction[0]) > 0.0
    });
    check("abs(direction.y) < 0.3", &|_, ray| rays[ray].direction[1].abs() < 0.3);
    check("field(ex) > 300", &|_, ray| ex(ray) > 300);
    check("key > 0x4000000000000000", &|_, ray| keys.at(ray) > 1 << 62);
    check("displacement > 50", &|place, ray| place.abs_diff(ray) > 50);
    check("group == 1", &|place, _| place / 64 == 1);
    let mean = groups.mean_area;
    check(&format!("area > {mean}"), &|place, _| group(place).area > mean);
    check("spread < 0.8", &|place, _| group(place).spread < 0.8);
    let lanes = groups.groups[0].lanes.unwrap();
    check(&format!("lanes > {lanes}"), &|place, _| group(place).lanes.unwrap() > lanes);
    check("nodes == 2", &|_, ray| work[ray].nodes == 2);
    check("work > 13 && triangles == 11", &|_, ray| work[ray].nodes > 2);
    let unit = queue.traced.unit();
    let cut = |ray: &Ray, length: f32| {
        length.min(ray.t_max * unit.scale).min(unit.exit(unit.point(ray.origin), ray.direction)).max(0.0)
    };
    let estimate = |ray: usize| cut(&rays[ray], table.mean(&rays[ray]));
    assert!((0..rays.len()).any(|ray| estimate(ray) < table.mean(&rays[ray])), "no estimate is cut");
    check("estimate > 0.3", &|_, ray| f64::from(estimate(ray)) > 0.3);
    check("log2(ratio) > 0", &|_, ray| estimate(ray) > queue.lengths[ray]);
    check("hit", &|_, ray| hits[ray].is_hit());
    check("triangle == 3", &|_, ray| hits[ray].triangle == 3);
    check("!hit || triangle != 3", &|_, ray| hits[ray].triangle != 3);
    assert_eq!(places("pass == 1 && bounce == 1 && !shadow", &numbers).len(), order.len());
    assert!(places("pass == 0 || bounce == 2 || shadow", &numbers).is_empty());
}

/// Groups are found by the thread that asks for them, before many threads look at them: in a debug build, any
/// other way panics.
#[test]
fn what_takes_groups_finds_them_first() {
    let (_folder, dump) = written();
    let fresh = || ordered(dump.clone(), QUEUE, "two-point");
    // The sample is too small for many threads, but groups are found before light is missed.
    let numbers_of_filter = numbers(&mut fresh());
    let expression = Expression::parse("spread < 0.8 && light > 0").unwrap();
    assert!(numbers_of_filter.passing(&expression).is_err());
    assert!(numbers_of_filter.order.known_groups(GroupWidth::default()).is_some());
    for by in [Quantity::Area, Quantity::Spread, Quantity::Lanes] {
        let mut context = fresh();
        let sorted = Rows::of(&numbers(&mut context), None, Sorting { by, direction: Direction::Ascending });
        assert!(sorted.len() > 1);
    }
    for colour_by in [Quantity::Area, Quantity::Spread, Quantity::Lanes].map(ColourBy::Quantity) {
        let options = SpaceOptions { curve: false, colour_by, ..SpaceOptions::default() };
        let mut layers = Layers::default();
        shown_by(&mut layers, &mut fresh(), &options);
        assert!(layers.counts().is_some(), "{colour_by:?}");
    }
}

#[test]
fn lights_belong_to_shadow_rays() {
    let (_folder, dump) = written();
    let mut context = ordered(dump, QueueId { kind: Kind::Shadow, ..QUEUE }, "light-octahedron");
    let numbers = numbers(&mut context);
    let order = &*numbers.order;
    let lights = order.queue.lights.as_ref().unwrap();
    assert_eq!(places("light == 2", &numbers), kept(order, |_, ray| lights[ray] == 2));
    assert_eq!(places("field(light) == 2", &numbers), kept(order, |_, ray| lights[ray] == 2));
    let expression = Expression::parse("hit && triangle == 1").unwrap();
    let error = numbers.passing(&expression).unwrap_err();
    assert_eq!((error.start, error.length), (7, 8));
    assert!(error.message.contains("shadow rays have no triangle"), "{error}");
}

#[test]
fn materials_are_those_of_the_triangles_hit() {
    let (_folder, mut context) = sampled("aila");
    let place = Place::Scene(SceneArray::Materials);
    let materials = context.recording().unwrap().dump.array::<u32>(&place).unwrap();
    let numbers = numbers(&mut context);
    let Results::Hits(hits) = numbers.order.queue.traced.results() else { panic!("closest rays") };
    let mut found = 0;
    for material in 0..materials.iter().max().unwrap() + 1 {
        let is_it = |ray: usize| hits[ray].is_hit() && materials[hits[ray].triangle as usize] == material;
        let expected = kept(&numbers.order, |_, ray| is_it(ray));
        assert_eq!(places(&format!("material == {material}"), &numbers), expected);
        found += usize::from(!expected.is_empty());
    }
    assert!(found > 1, "{found} materials were hit");
}

/// The rays of a cell: the mean that the stored cell has is the estimate of those rays, but for those that end before.
#[test]
fn the_rays_of_a_cell_have_its_mean() {
    let (_folder, mut context) = sampled("aila");
    let numbers = numbers(&mut context);
    let cells = numbers.order.queue.cells.as_ref().unwrap();
    let (mut found, mut uncut) = (0, 0);
    for cell in cells.iter() {
        let places = places(&format!("cell == {}", cell.cell), &numbers);
        let mean = f64::from(mean_length(cell.sum, cell.count));
        let estimates = places.iter().map(|&place| value(&numbers, Quantity::Estimate, place as usize));
        assert!(estimates.clone().all(|estimate| estimate <= mean));
        uncut += estimates.filter(|estimate| *estimate == mean).count();
        found += places.len();
    }
    assert!(uncut > 10, "{uncut} estimates are a cell's mean");
    assert!(found > 50, "only {found} rays have a cell that was touched");
}

#[test]
fn what_keys_do_not_hold_is_said() {
    let (_folder, mut context) = sampled("aila");
    let aila = numbers(&mut context);
    let expression = Expression::parse("t > 1 && field(ex) > 3").unwrap();
    let error = aila.passing(&expression).unwrap_err();
    assert_eq!((error.start, error.length), (15, 2));
    assert!(error.message.contains("keys of aila have no field ex; they have ox oy oz dx"), "{error}");
    context.selection.order_by("unsorted");
    let error = numbers(&mut context).passing(&expression).unwrap_err();
    assert!(error.message.contains("unsorted rays have no key"), "{error}");
}

/// A number of the ray at a place.
type OfRay = dyn Fn(&Numbers, usize) -> f64;

/// A condition as text and as a closure over the numbers of a ray.
#[derive(Clone)]
struct Sample {
    text: String,
    of: Arc<OfRay>,
}

impl std::fmt::Debug for Sample {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

fn sample(text: String, of: impl Fn(&Numbers, usize) -> f64 + 'static) -> Sample {
    Sample { text, of: Arc::new(of) }
}

fn any_number() -> impl Strategy<Value = Sample> {
    let literal = (0u32..4000).prop_map(|n| {
        let value = f64::from(n) / 256.0;
        sample(value.to_string(), move |_, _| value)
    });
    let quantity = prop::sample::select(Quantity::ALL)
        .prop_filter("known of closest rays", |quantity| !matches!(quantity, Quantity::Light));
    let quantity = quantity.prop_map(|quantity| {
        sample(quantity.name().to_owned(), move |numbers, place| value(numbers, quantity, place))
    });
    prop_oneof![literal, quantity].prop_recursive(3, 12, 2, |inner| {
        let two = (inner.clone(), inner.clone(), 0..4usize).prop_map(|(a, b, sign)| {
            let text = format!("({} {} {})", a.text, ["+", "-", "*", "/"][sign], b.text);
            sample(text, move |n, p| {
                let (a, b) = ((a.of)(n, p), (b.of)(n, p));
                [a + b, a - b, a * b, a / b][sign]
            })
        });
        let one = (inner, 0..3usize).prop_map(|(a, which)| {
            let text = format!("{}({})", ["abs", "log2", "-"][which], a.text);
            sample(text, move |n, p| {
                let a = (a.of)(n, p);
                [a.abs(), a.log2(), -a][which]
            })
        });
        prop_oneof![two, one]
    })
}

fn any_condition() -> impl Strategy<Value = Sample> {
    let compared = (any_number(), any_number(), 0..6usize).prop_map(|(a, b, sign)| {
        let text = format!("{} {} {}", a.text, ["<", "<=", ">", ">=", "==", "!="][sign], b.text);
        sample(text, move |n, p| {
            let (a, b) = ((a.of)(n, p), (b.of)(n, p));
            f64::from(u8::from([a < b, a <= b, a > b, a >= b, a == b, a != b][sign]))
        })
    });
    let hit = Just(sample("hit".to_owned(), |n, p| {
        f64::from(u8::from(n.order.queue.is_at_surface(n.order.places.ray(p))))
    }));
    prop_oneof![4 => compared, 1 => hit].prop_recursive(3, 12, 2, |inner| {
        let two = (inner.clone(), inner.clone(), any::<bool>()).prop_map(|(a, b, is_and)| {
            let text = format!("({}) {} ({})", a.text, if is_and { "&&" } else { "||" }, b.text);
            sample(text, move |n, p| {
                let (a, b) = ((a.of)(n, p), (b.of)(n, p));
                if is_and { a.min(b) } else { a.max(b) }
            })
        });
        let not = inner.prop_map(|a| sample(format!("!({})", a.text), move |n, p| 1.0 - (a.of)(n, p)));
        prop_oneof![two, not]
    })
}

/// A fixed seed: the same cases each time.
fn runner(cases: u32) -> TestRunner {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    TestRunner::new_with_rng(Config { cases, failure_persistence: None, ..Config::default() }, rng)
}

#[test]
fn filters_are_their_oracle() {
    let (_folder, mut context) = sampled("mine");
    let numbers = numbers(&mut context);
    let check = |condition: Sample| {
        let expected = kept(&numbers.order, |place, _| (condition.of)(&numbers, place) == 1.0);
        prop_assert_eq!(places(&condition.text, &numbers), expected);
        Ok(())
    };
    runner(1500).run(&any_condition(), check).unwrap();
}

/// Whatever is typed: a filter, or an error whose place is in the text or just behind it.
#[test]
fn no_text_is_a_panic() {
    let words =
        ["t", "length", "<", "&&", "(", ")", "!", "-", "0x", "1e", ".5", "field", "ex", "=", "§", "hit"];
    let text =
        prop::collection::vec(prop::sample::select(words.to_vec()), 0..12).prop_map(|words| words.concat());
    let check = |text: String| {
        if let Err(error) = Expression::parse(&text) {
            prop_assert!(error.length >= 1 && error.start <= text.chars().count(), "{}: {}", text, error);
        }
        Ok(())
    };
    runner(3000).run(&text, check).unwrap();
}

/// Against a stable sort by comparison.
#[test]
fn rows_are_sorted_stably_and_filtered() {
    let (_folder, mut context) = sampled("two-point");
    let numbers = numbers(&mut context);
    let filter = numbers.passing(&Expression::parse("x > 4").unwrap()).unwrap();
    for &by in Quantity::ALL {
        for direction in [Direction::Ascending, Direction::Descending] {
            for filter in [None, Some(&filter)] {
                let kept = |place: &usize| filter.is_none_or(|filter| filter.contains(*place));
                let mut expected: Vec<usize> = (0..numbers.order.len()).filter(kept).collect();
                expected.sort_by(|&a, &b| {
                    let (x, y) = (value(&numbers, by, a), value(&numbers, by, b));
                    let compared = if by == Quantity::Key {
                        let rays = numbers.rays();
                        rays.at(a).key().cmp(&rays.at(b).key())
                    } else {
                        x.partial_cmp(&y).unwrap_or_else(|| x.is_nan().cmp(&y.is_nan()))
                    };
                    let is_turned = direction == Direction::Descending && !(x.is_nan() || y.is_nan());
                    if is_turned { compared.reverse() } else { compared }
                });
                let rows = Rows::of(&numbers, filter, Sorting { by, direction });
                let found: Vec<usize> = (0..rows.len()).map(|row| rows.place(row)).collect();
                assert_eq!(found, expected, "{} {direction:?}", by.name());
            }
        }
    }
}

fn type_filter(harness: &mut Harness<'_, State>, text: &str) {
    let input = harness.get_by_role(Role::TextInput);
    input.focus();
    harness.step();
    harness.get_by_role(Role::TextInput).type_text(text);
    settle(harness);
}

#[test]
fn a_filter_that_is_wrong_is_said_where_it_is_typed() {
    let (_folder, mut harness) = sampled_panel("rays", "aila");
    type_filter(&mut harness, "bounse == 1");
    let said = "character 1: found 'bounse', which no ray has; did you mean 'bounce'?";
    assert!(reads(&harness, said), "{said} is not shown");
    let context = &mut harness.state_mut().context;
    context.selection.filter.set("field(ex) > 1");
    settle(&mut harness);
    assert!(reads_in_part(&harness, "keys of aila have no field ex"));
}

/// What is typed above the table is what space shows.
#[test]
fn a_filter_links_table_and_space() {
    let (_folder, mut harness) = sampled_panel("rays", "two-point");
    type_filter(&mut harness, "length < 0.25 && hit");
    let context = &mut harness.state_mut().context;
    let numbers = numbers(context);
    let queue = &numbers.order.queue;
    let expected = kept(&numbers.order, |_, ray| queue.lengths[ray] < 0.25 && queue.is_at_surface(ray));
    assert!(!expected.is_empty() && expected.len() < numbers.order.len());
    let label = format!("{} of {} rays by two-point", expected.len(), numbers.order.len());
    assert!(harness.query_by_label(&label).is_some(), "{label} is not shown");
    let context = &mut harness.state_mut().context;
    let options = SpaceOptions { rays: true, jumps: 0, ends: true, ..SpaceOptions::default() };
    let mut layers = Layers::default();
    let drawn = shown_by(&mut layers, context, &options);
    let origins: Vec<[f32; 3]> = expected
        .iter()
        .map(|&place| {
            queue.segment(numbers.order.places.ray(place as usize)).origin.map(|along| along as f32)
        })
        .collect();
    let Shape::Strip(curve) = drawn[0].geometry.shape() else { panic!("no curve") };
    assert_eq!(curve.iter().map(|vertex| vertex.position).collect::<Vec<_>>(), origins);
    let Shape::Segments(lines) = drawn[1].geometry.shape() else { panic!("no rays") };
    assert_eq!(lines.iter().map(|line| line[0].position).collect::<Vec<_>>(), origins);
    assert_eq!(
        (layers.counts(), layers.passing),
        (Some((origins.len(), numbers.order.len())), Some(origins.len()))
    );
}

/// The picture of the order: rays that do not pass are grey, and only those.
#[test]
fn a_filter_greys_the_other_pixels() {
    let (_folder, mut harness) = sampled_panel("pixels", "two-point");
    let mut grey = |text: &str| -> Vec<u32> {
        harness.state_mut().context.selection.filter.set(text);
        settle(&mut harness);
        let [red, green, blue, _] = Theme::of(&harness.ctx).left_out().to_array();
        let image = harness.render().unwrap();
        let found = image.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[..3] == [red, green, blue]);
        found.map(|(column, ..)| column).collect()
    };
    assert!(grey("").is_empty());
    let right = grey("x < 8");
    let left = grey("x >= 8");
    assert!(right.len() > 1000 && left.len() > 1000, "{} and {} pixels", right.len(), left.len());
    assert!(left.iter().max() < right.iter().min(), "the wrong half is grey");
    let order = harness.state_mut().context.order().unwrap();
    let passing = harness.state_mut().context.filtered(&order).passing().unwrap().len();
    assert!(passing < order.len());
    harness.get_by_label_contains(&format!("{passing} of {} rays", order.len()));
}

#[test]
fn a_header_sorts_and_again_the_other_way() {
    let (_folder, mut harness) = sampled_panel("rays", "two-point");
    let numbers = numbers(&mut harness.state_mut().context);
    let lengths = (0..numbers.order.len()).map(|place| value(&numbers, Quantity::Length, place));
    let lengths: BTreeSet<u32> = lengths.map(|length| (length as f32).to_bits()).collect();
    let text = |bits: Option<&u32>| format!("{:.4}", f32::from_bits(*bits.unwrap()));
    let (shortest, longest) = (text(lengths.first()), text(lengths.last()));
    for first in [shortest, longest] {
        harness.get_by_label("length").click();
        settle(&mut harness);
        let top = |node: &egui_kittest::Node<'_>| node.rect().top() as i32;
        let cells = harness.query_all_by_label(&first);
        let highest = cells.map(|node| top(&node)).min().expect("the first row is in sight");
        let below = highest - top(&harness.get_by_label("length"));
        assert!((1..40).contains(&below), "{first} is not in the first row");
    }
}

#[test]
fn rows_in_sight_are_copied_as_text() {
    let (_folder, mut harness) = sampled_panel("rays", "two-point");
    let ray = numbers(&mut harness.state_mut().context).order.places.ray(2);
    harness.get_by_label("copy").click();
    harness.step();
    let copied = harness.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let copied = copied.expect("something was copied");
    let lines: Vec<Vec<&str>> = copied.lines().map(|line| line.split('\t').collect()).collect();
    assert_eq!((lines[0][0], lines[0][1]), ("place", "ray"));
    assert_eq!((lines[3][0], lines[3][1]), ("2", ray.to_string().as_str()));
}
