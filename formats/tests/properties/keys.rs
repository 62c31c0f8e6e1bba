//! Keys by any layout: what is decoded is what was encoded, and what docs/keys.md says of every ray.

use formats::key::decode::{DecodedField, decode};
use formats::key::extent::index_bits;
use formats::key::method::BUILTIN;
use formats::key::{Coordinate, Encoder, Extent, Facts, LAYOUT_BITS, Layout, LayoutText, LightSite, Method};
use formats::ray::Ray;
use formats::unit_space::UnitSpace;
use proptest::prelude::*;

use crate::cases;
use crate::oracle::{Bounds, coordinate, error_bits};

/// Bits of the finest coordinate.
const FINEST: u32 = 22;
const LENGTH: f32 = 0.25;
/// A picture of 15 × 8 tiles of 7 × 5 pixels.
const PICTURE: [u32; 2] = [100, 40];
const TILE: &str = "tile(7x5)";

/// What texts of layouts are made of.
const SIGNS: [&str; 17] = [
    "(",
    ")",
    ")*3",
    ")*",
    "*2",
    " ^ ",
    "^",
    " @real",
    "@",
    " ox",
    " oy ",
    " ex",
    " ey ",
    " u",
    " light ",
    " hilbert(",
    " tile(7x5)",
];

fn lights() -> Vec<LightSite> {
    vec![
        LightSite::Placed { centre: [0.25, 0.4, 0.125] },
        LightSite::directional([0.48, -0.64, 0.6]),
        LightSite::Environment,
    ]
}

/// Groups of words, each repeated: the text of a layout, and its bits spelled out.
fn words() -> impl Strategy<Value = (String, Vec<&'static str>)> {
    let word = prop::sample::select(Coordinate::ALL).prop_map(Coordinate::name);
    let group = (prop::collection::vec(word, 1..5), 1usize..9);
    prop::collection::vec(group, 1..6).prop_map(|groups| {
        let text = groups
            .iter()
            .map(|(words, times)| format!("({})*{times}", words.join(" ").replace("tile", TILE)));
        let bits = groups.iter().flat_map(|(words, times)| words.repeat(*times));
        (text.collect::<Vec<_>>().join(" "), bits.collect())
    })
}

fn extent(lights: usize) -> Extent {
    Extent { lights, picture: PICTURE }
}

/// Whether a word stands for a whole number.
fn is_number(word: &str) -> bool {
    word == "light" || word == "tile"
}

/// The bits of a layout for so many lights, if it is one.
fn spelled_out(words: &[&'static str], lights: usize) -> Option<Vec<&'static str>> {
    let count = |word: &str| words.iter().filter(|other| **other == word).count();
    let without_numbers = words.iter().filter(|word| !is_number(word)).count();
    let is_short = without_numbers <= LAYOUT_BITS as usize;
    let is_fine = words.iter().all(|word| count(word) <= if is_number(word) { 1 } else { FINEST as usize });
    let repeat = |word: &&'static str| {
        let times = if is_number(word) { width(word, lights) as usize } else { 1 };
        std::iter::repeat_n(*word, times)
    };
    (is_short && is_fine && without_numbers > 0)
        .then(|| words.iter().flat_map(repeat).take(LAYOUT_BITS as usize).collect())
}

/// Bits of a coordinate.
fn width(name: &str, lights: usize) -> u32 {
    match name {
        "light" => index_bits(lights as u64),
        "tile" => 7,
        _ => FINEST,
    }
}

/// Layouts that are valid, for as many lights as there are, and those of methods: most of these fill a key.
fn layouts() -> impl Strategy<Value = Layout> {
    let of_words = words().prop_filter_map("not a layout", |(text, words)| {
        spelled_out(&words, lights().len())?;
        LayoutText::parse(&text).unwrap().expand(extent(lights().len())).ok()
    });
    // Not those of other tiles, nor those that an exclusive or hides.
    let is_read = |layout: &Layout| {
        layout.tiles().is_none() && layout.bits().iter().all(|bit| bit.sources().len() == 1)
    };
    let extent = extent(lights().len());
    let builtin =
        BUILTIN.iter().map(|(name, ..)| Method::builtin(name).unwrap().layout.expand(extent).unwrap());
    let of_methods: Vec<Layout> = builtin.filter(is_read).collect();
    prop_oneof![3 => of_words, 1 => prop::sample::select(of_methods)]
}

/// Any width, and often the largest.
fn key_bits() -> impl Strategy<Value = u32> {
    prop_oneof![3 => 8..=LAYOUT_BITS, 1 => Just(LAYOUT_BITS)]
}

/// Boxes with extents, flat ones, and those of no extent at all.
fn bounds() -> impl Strategy<Value = Bounds> {
    let side = || prop_oneof![3 => 1e-3..1e3f32, 1 => Just(0.0f32), 1 => Just(1.0f32)];
    let low = || prop_oneof![3 => -1e3..1e3f32, 1 => Just(0.0f32)];
    ([low(), low(), low()], [side(), side(), side()])
        .prop_map(|(min, sides)| Bounds { min, max: [0, 1, 2].map(|axis| min[axis] + sides[axis]) })
}

fn unit_vector() -> impl Strategy<Value = [f32; 3]> {
    let axis =
        prop::sample::select(vec![[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]);
    let any = (-1.0..1.0f32, 0.0..std::f32::consts::TAU).prop_map(|(z, angle)| {
        let radius = (1.0 - z * z).sqrt();
        [radius * angle.cos(), radius * angle.sin(), z]
    });
    prop_oneof![9 => any, 1 => axis]
}

/// A ray as tracers make them, from a place in the box.
fn ray_in(bounds: Bounds) -> impl Strategy<Value = Ray> {
    let far = prop_oneof![Just(f32::INFINITY), 0f32..2.0];
    ([0f32..1.0, 0f32..1.0, 0f32..1.0], unit_vector(), far).prop_map(move |(at, direction, t_max)| {
        let along = |axis: usize| bounds.min[axis] + at[axis] * (bounds.max[axis] - bounds.min[axis]);
        Ray { origin: [along(0), along(1), along(2)], t_min: 0.0, direction, t_max }
    })
}

/// A number that a file may hold, and the box's own bounds.
fn odd(bounds: Bounds, axis: usize) -> impl Strategy<Value = f32> {
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    prop_oneof![
        prop::sample::select(vec![
            min,
            max,
            min.next_down(),
            min.next_up(),
            max.next_down(),
            max.next_up(),
            min - 1.0,
            max + 1.0,
            0.0,
            -0.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            1e-45,
        ]),
        any::<u32>().prop_map(f32::from_bits),
    ]
}

fn odd_ray(bounds: Bounds) -> impl Strategy<Value = Ray> {
    let three = || [odd(bounds, 0), odd(bounds, 1), odd(bounds, 2)];
    (three(), three(), odd(bounds, 0)).prop_map(|(origin, direction, t_max)| Ray {
        origin,
        t_min: 0.0,
        direction,
        t_max,
    })
}

/// The coordinates that every device must get right to the last bit, of 22 bits.
fn exact(name: &str, bounds: &Bounds, ray: &Ray, light: u32) -> Option<u32> {
    let quantised = |value: f32| {
        let scaled = f64::from(value) * f64::from(1u32 << FINEST);
        if value > 0.0 { scaled.min(f64::from((1u32 << FINEST) - 1)) as u32 } else { 0 }
    };
    let largest = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f32::max);
    let scale = if largest == 0.0 { 1.0 } else { 1.0 / largest };
    let origin = |axis: usize| quantised((ray.origin[axis] - bounds.min[axis]) * scale);
    let direction = |axis: usize| quantised((ray.direction[axis] + 1.0) / 2.0);
    Some(match name {
        "ox" => origin(0),
        "oy" => origin(1),
        "oz" => origin(2),
        "dx" => direction(0),
        "dy" => direction(1),
        "dz" => direction(2),
        "light" => light,
        "tile" => path_of(light) / 100 / 5 * 15 + path_of(light) % 100 / 7,
        _ => return None,
    })
}

/// Checks the value of such a coordinate.
fn assert_exact(field: &DecodedField, bounds: &Bounds, ray: &Ray, light: u32) {
    let name = field.bit.coordinate().unwrap().name();
    if let Some(expected) = exact(name, bounds, ray, light) {
        let expected = expected >> (width(name, lights().len()) - field.bits);
        assert_eq!(field.value, u64::from(expected), "{name} of {ray:?}");
    }
}

/// The path of a ray that goes to a light.
fn path_of(light: u32) -> u32 {
    light * 1789 + 333
}

/// The keys of rays, one by one and many at once, whole and as prefixes.
fn key(layout: &Layout, key_bits: u32, bounds: &Bounds, ray: &Ray, light: u32) -> u64 {
    let unit = UnitSpace::from_bounds(bounds.min, bounds.max);
    let encoder = Encoder::new(layout, key_bits, unit, &lights());
    let facts = Facts { length: LENGTH, light, path: path_of(light) };
    let key = encoder.encode(ray, facts);
    let of_many = Facts { length: |_| LENGTH, light: |_| light, path: |_| path_of(light) };
    let mut of_block = [0u64];
    encoder.encode_all(&[*ray], &of_many, &mut of_block);
    assert_eq!(of_block, [key], "as a block");
    let whole = Encoder::new(layout, LAYOUT_BITS, unit, &lights()).encode(ray, facts);
    assert_eq!(key, whole >> (LAYOUT_BITS - key_bits), "as a prefix");
    key
}

proptest! {
    #![proptest_config(cases(4000))]

    #[test]
    fn a_text_is_a_layout_exactly_if_its_bits_fit((text, words) in words(), lights in 1usize..40) {
        // What fits one light fits any number, or parsing says at once that it does not.
        prop_assert_eq!(LayoutText::parse(&text).is_ok(), spelled_out(&words, 1).is_some(), "{}", text);
        if let Ok(parsed) = LayoutText::parse(&text) {
            let layout = parsed.expand(extent(lights)).unwrap();
            let expected = spelled_out(&words, lights).unwrap();
            prop_assert_eq!(layout.names(), expected, "{}", text);
        }
    }

    #[test]
    fn decoding_gives_the_cell_of_every_coordinate(
        layout in layouts(),
        key_bits in key_bits(),
        (bounds, ray) in bounds().prop_flat_map(|bounds| (Just(bounds), ray_in(bounds))),
        light in 0u32..3,
    ) {
        for field in decode(&layout, key_bits, key(&layout, key_bits, &bounds, &ray, light)) {
            let name = field.bit.coordinate().unwrap().name();
            assert_exact(&field, &bounds, &ray, light);
            if !is_number(name) {
                let site = &lights()[light as usize];
                let truth = coordinate(name, &bounds, &ray, LENGTH.into(), site).clamp(0.0, 1.0);
                let (low, high) = field.range().unwrap();
                let error = error_of(name, &bounds, &ray, light);
                let is_there = low - error <= truth && truth <= high + error;
                prop_assert!(is_there, "{} is {}, found in {:?} by {:?}", name, truth, field, ray);
            }
        }
    }

    #[test]
    fn odd_rays_have_the_keys_that_the_definition_gives(
        layout in layouts(),
        key_bits in key_bits(),
        (bounds, ray) in bounds().prop_flat_map(|bounds| (Just(bounds), odd_ray(bounds))),
        light in 0u32..3,
    ) {
        for field in decode(&layout, key_bits, key(&layout, key_bits, &bounds, &ray, light)) {
            assert_exact(&field, &bounds, &ray, light);
        }
    }

    #[test]
    fn keys_along_a_curve_have_the_coordinates_of_keys_in_turn(
        axes in prop::sample::subsequence(Coordinate::ALL.to_vec(), 2..=6),
        key_bits in 8..=LAYOUT_BITS,
        (bounds, ray) in bounds().prop_flat_map(|bounds| (Just(bounds), odd_ray(bounds))),
    ) {
        let names: Vec<&str> = axes.iter().map(|axis| axis.name()).filter(|name| !is_number(name)).collect();
        prop_assume!(names.len() > 1);
        let layout = |text: String| LayoutText::parse(&text).unwrap().expand(Extent::NOTHING).unwrap();
        let decoded = |layout: Layout| decode(&layout, key_bits, key(&layout, key_bits, &bounds, &ray, 1));
        let (names, times) = (names.join(" "), FINEST.min(LAYOUT_BITS / names.len() as u32));
        let curve = decoded(layout(format!("hilbert({names})*{times}")));
        let in_turn = decoded(layout(format!("({names})*{times}")));
        let known = |fields: &[DecodedField]| fields.iter().map(|field| field.bits).sum::<u32>();
        prop_assert_eq!(known(&curve), known(&in_turn));
        for field in curve {
            let same = in_turn.iter().find(|other| other.bit == field.bit).unwrap();
            let bits = same.bits.min(field.bits);
            prop_assert_eq!(field.value >> (field.bits - bits), same.value >> (same.bits - bits), "{}", field.bit);
        }
    }

    #[test]
    fn every_text_is_a_layout_or_says_where_it_is_none(
        signs in prop::collection::vec(prop::sample::select(&SIGNS[..]), 0..20),
    ) {
        let text = signs.concat();
        let parsed = match LayoutText::parse(&text) {
            Ok(parsed) => parsed,
            Err(error) => {
                let characters = text.chars().count().max(1);
                prop_assert!(error.length > 0 && error.start + error.length <= characters, "{error:?}");
                return Ok(());
            }
        };
        for lights in [1, 3, 300] {
            // With more lights than one, a coordinate may get more bits than it has.
            let Ok(layout) = parsed.expand(extent(lights)) else { continue };
            let read: u32 = decode(&layout, LAYOUT_BITS, u64::MAX).iter().map(|field| field.bits).sum();
            prop_assert_eq!(read as usize, layout.bits().len(), "{}", text);
        }
    }

    #[test]
    fn both_sides_of_an_exclusive_or_are_in_the_key(
        key_bits in 8..=44u32,
        (bounds, ray) in bounds().prop_flat_map(|bounds| (Just(bounds), odd_ray(bounds))),
    ) {
        let key = |text: &str| {
            let layout = LayoutText::parse(text).unwrap().expand(Extent::NOTHING).unwrap();
            key(&layout, key_bits, &bounds, &ray, 1)
        };
        let [left, right] = ["(ox oy)*22", "hilbert(u ex)*22"];
        prop_assert_eq!(key(&format!("{left} ^ {right}")), key(left) ^ key(right));
    }

    #[test]
    fn equal_rays_have_equal_keys_and_the_sign_of_zero_does_not_count(
        layout in layouts(),
        (bounds, ray) in bounds().prop_flat_map(|bounds| (Just(bounds), ray_in(bounds))),
        axis in 0usize..3,
    ) {
        let [mut positive, mut negative] = [ray; 2];
        (positive.origin[axis], negative.origin[axis]) = (0.0, -0.0);
        let keys = [positive, negative, negative].map(|ray| key(&layout, LAYOUT_BITS, &bounds, &ray, 1));
        prop_assert_eq!(keys, [keys[0]; 3]);
    }
}

/// How far from the truth rounding may put a coordinate; infinite where it may choose between two ends
/// of the range: where a circle closes, and along the cuts of the octahedron.
fn error_of(name: &str, bounds: &Bounds, ray: &Ray, light: u32) -> f64 {
    const NEAR: f64 = 1e-5;
    let seen = || match &lights()[light as usize] {
        LightSite::Placed { centre } => {
            let origin = UnitSpace::from_bounds(bounds.min, bounds.max).point(ray.origin);
            [0, 1, 2].map(|axis| f64::from(origin[axis]) - f64::from(centre[axis]))
        }
        _ => ray.direction.map(f64::from),
    };
    let is_cut = |[x, y, z]: [f64; 3]| z < NEAR && (x.abs() < NEAR || y.abs() < NEAR);
    let direction = ray.direction.map(f64::from);
    let rounding = 2f64.powi(-error_bits(name));
    match name {
        "theta" if direction[1].abs() < NEAR => f64::INFINITY,
        "u" | "v" if is_cut(direction) => f64::INFINITY,
        "lu" | "lv" if light != 1 && is_cut(seen()) => f64::INFINITY,
        // The nearer the light, the more an origin's rounding turns the direction to it.
        "lu" | "lv" => rounding / seen().iter().map(|along| along * along).sum::<f64>().sqrt().min(1.0),
        _ => rounding,
    }
}
