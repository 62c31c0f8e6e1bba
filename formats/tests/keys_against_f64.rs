//! Every method's key, bit by bit, against an oracle in f64 that shares no code with the encoder.
//!
//! The oracle spells docs/keys.md out: it lists a layout's bits with plain loops and takes each bit from a
//! coordinate computed in f64. A wrong bit order, a swapped axis or a shifted field shows at once.

mod oracle;

use formats::key::{Encoder, Extent, Facts, LightSite, Method};
use formats::ray::Ray;
use formats::unit_space::UnitSpace;
use oracle::{Bounds, coordinate, error_bits, hilbert_digits};

const MIN: [f32; 3] = [-3.0, 10.0, 0.5];
const MAX: [f32; 3] = [5.0, 14.0, 2.5];
const LENGTH: f64 = 0.25;
const PICTURE: [u32; 2] = [300, 200];

fn lights() -> Vec<LightSite> {
    vec![
        LightSite::Placed { centre: [0.25, 0.4, 0.125] },
        LightSite::directional([0.48, -0.64, 0.6]),
        LightSite::Environment,
        LightSite::Placed { centre: [0.75, 0.1, 0.2] },
        LightSite::Placed { centre: [0.5, 0.2, 0.1] },
    ]
}

/// The layouts, spelled out: names of the bits, most significant first.
fn bits_of(method: &str, lights: usize) -> Vec<&'static str> {
    let mut bits = Vec::new();
    let mut repeat = |group: &[&'static str], times: usize| {
        for _ in 0..times {
            bits.extend_from_slice(group);
        }
    };
    let index_bits = (0..).find(|&bits| 1 << bits >= lights).unwrap_or(0);
    match method {
        "origin" => {
            repeat(&["ox", "oy", "oz"], 21);
            repeat(&["ox"], 1);
        }
        "reis" => {
            repeat(&["ox", "oy", "oz"], 7);
            repeat(&["ox"], 1);
            repeat(&["theta", "phi"], 21);
        }
        "costa" => {
            repeat(&["theta", "phi"], 4);
            repeat(&["ox", "oy", "oz"], 15);
            repeat(&["theta", "phi"], 5);
            repeat(&["theta"], 1);
        }
        "aila" => {
            repeat(&["ox", "oy", "oz"], 3);
            repeat(&["ox", "oy", "oz", "dx", "dy", "dz"], 9);
            repeat(&["ox"], 1);
        }
        "octahedron" => {
            repeat(&["ox", "oy", "oz"], 4);
            repeat(&["ox", "oy", "oz", "u", "v"], 10);
            repeat(&["ox", "oy"], 1);
        }
        "light-octahedron" => {
            repeat(&["light"], index_bits);
            repeat(&["lu", "lv"], 8);
            repeat(&["lu", "lv", "lr"], 14);
            repeat(&["ox", "oy", "oz"], 2);
        }
        "origin-light" => {
            repeat(&["ox", "oy", "oz"], 3);
            repeat(&["light"], index_bits);
            repeat(&["ox", "oy", "oz"], 19);
        }
        "paraboloid" => {
            repeat(&["ox", "oy", "oz"], 4);
            repeat(&["ox", "oy", "oz", "pu", "pv"], 10);
            repeat(&["ox", "oy"], 1);
        }
        "tiled-octahedron" => {
            // 5 × 2 tiles of 64 × 128 pixels in a picture of 300 × 200.
            repeat(&["tile"], 4);
            repeat(&["u", "v"], 4);
        }
        "grid-spherical" => {
            repeat(&["ox", "oy", "oz"], 5);
            repeat(&["theta"], 4);
            repeat(&["phi"], 3);
        }
        _ => {
            repeat(&["ox", "oy", "oz", "ex", "ey", "ez"], 10);
            repeat(&["ox", "oy", "oz", "ex"], 1);
        }
    }
    bits.truncate(64);
    bits
}

/// A bit of a coordinate, the highest being level 1; `None` if the coordinate lies so close to the border of its cell
/// that rounding in f32 may put it on the other side.
fn coordinate_bit(name: &str, level: i32, ray: &Ray, light: u32) -> Option<bool> {
    let value = coordinate(name, &Bounds { min: MIN, max: MAX }, ray, LENGTH, &lights()[light as usize]);
    let scaled = value.clamp(0.0, 1.0) * 2f64.powi(level);
    let is_far = (scaled - scaled.round()).abs() >= 2f64.powi(level - error_bits(name));
    is_far.then_some(scaled.floor() as u64 & 1 == 1)
}

/// The tile of a path, found by walking from tile to tile.
fn tile_of(path: u32) -> u32 {
    let corners = (0..PICTURE[1]).step_by(128).flat_map(|y| (0..PICTURE[0]).step_by(64).map(move |x| (x, y)));
    let is_inside = |(left, top): (u32, u32)| {
        let (x, y) = (path - path / PICTURE[0] * PICTURE[0], path / PICTURE[0]);
        (left..left + 64).contains(&x) && (top..top + 128).contains(&y)
    };
    corners.into_iter().position(is_inside).expect("a path of the picture") as u32
}

/// The key, or `None` as of [`coordinate_bit`].
fn oracle_key(bits: &[&'static str], key_bits: usize, ray: &Ray, light: u32, path: u32) -> Option<u64> {
    let bits_of = |number| bits.iter().filter(|name| **name == number).count() as i32;
    let mut key = 0u64;
    for place in 0..key_bits {
        let Some(name) = bits.get(place) else {
            key <<= 1;
            continue;
        };
        let level = bits[..place].iter().filter(|other| *other == name).count() as i32 + 1;
        let bit = match *name {
            "light" => light >> (bits_of("light") - level) & 1 == 1,
            "tile" => tile_of(path) >> (bits_of("tile") - level) & 1 == 1,
            name => coordinate_bit(name, level, ray, light)?,
        };
        key = key << 1 | u64::from(bit);
    }
    Some(key)
}

/// The key along a Hilbert curve, likewise.
fn hilbert_key(axes: &[&str], key_bits: usize, ray: &Ray) -> Option<u64> {
    let level =
        |level: i32| axes.iter().map(|axis| coordinate_bit(axis, level, ray, 0)).collect::<Option<Vec<_>>>();
    let levels = (1..=key_bits.div_ceil(axes.len()) as i32).map(level).collect::<Option<Vec<_>>>()?;
    Some(hilbert_digits(&levels)[..key_bits].iter().fold(0, |key, &bit| key << 1 | u64::from(bit)))
}

fn rays() -> impl Iterator<Item = Ray> {
    let mut random = fastrand::Rng::with_seed(0x1234_5678);
    let mut number = move || random.f32();
    (0..20_000).map(move |index| {
        let origin = [0, 1, 2].map(|axis| MIN[axis] + (MAX[axis] - MIN[axis]) * number());
        let d: [f32; 3] = std::array::from_fn(|_| number() * 2.0 - 1.0);
        let length = d.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
        Ray {
            origin,
            t_min: 0.0,
            direction: d.map(|x| x / length),
            t_max: if index % 4 == 0 { 1.0 } else { f32::INFINITY },
        }
    })
}

#[test]
fn every_method_puts_every_bit_where_keys_says() {
    let unit = UnitSpace::from_bounds(MIN, MAX);
    let lights = lights();
    let extent = Extent { lights: lights.len(), picture: PICTURE };
    let methods = [
        "origin",
        "reis",
        "costa",
        "aila",
        "octahedron",
        "two-point",
        "two-point-adaptive",
        "two-point-real",
        "light-octahedron",
        "origin-light",
        "paraboloid",
        "grid-spherical",
        "tiled-octahedron",
    ];
    for name in methods {
        let layout = Method::builtin(name).unwrap().layout.expand(extent).unwrap();
        let bits = bits_of(name, lights.len());
        for key_bits in [8, 12, 16, 24, 32] {
            let encoder = Encoder::new(&layout, key_bits, unit, &lights);
            let mut compared = 0;
            for (index, ray) in rays().enumerate() {
                let light = index as u32 % lights.len() as u32;
                let path = index as u32 * 3 % (PICTURE[0] * PICTURE[1]);
                if let Some(expected) = oracle_key(&bits, key_bits as usize, &ray, light, path) {
                    let found = encoder.encode(&ray, Facts { length: LENGTH as f32, light, path });
                    assert_eq!(
                        found, expected,
                        "{name} at {key_bits} bits: {found:b} instead of {expected:b} for {ray:?}"
                    );
                    compared += 1;
                }
            }
            assert!(compared > 200, "{name} at {key_bits} bits: only {compared} rays were far from a border");
        }
    }
}

#[test]
fn curves_and_exclusive_ors_are_what_keys_says() {
    let unit = UnitSpace::from_bounds(MIN, MAX);
    let (origin, end) = (["ox", "oy", "oz"], ["ex", "ey", "ez"]);
    let morton =
        |axes: &[&'static str], key_bits, ray: &Ray| oracle_key(&axes.repeat(22), key_bits, ray, 0, 0);
    for (name, expected) in [
        (
            "hilbert-origin",
            &(|key_bits, ray: &Ray| hilbert_key(&origin, key_bits, ray)) as &dyn Fn(usize, &Ray) -> _,
        ),
        ("hilbert-two-point", &|key_bits, ray| hilbert_key(&[origin, end].concat(), key_bits, ray)),
        ("two-point-xor", &|key_bits, ray| {
            Some(morton(&origin, key_bits, ray)? ^ morton(&end, key_bits, ray)?)
        }),
    ] {
        let layout = Method::builtin(name).unwrap().layout.expand(Extent::NOTHING).unwrap();
        for key_bits in [8, 12, 16, 24, 32] {
            let encoder = Encoder::new(&layout, key_bits, unit, &[]);
            let known = rays().filter_map(|ray| Some((ray, expected(key_bits as usize, &ray)?)));
            let compared = known
                .map(|(ray, expected): (Ray, u64)| {
                    let found = encoder.encode(&ray, Facts { length: LENGTH as f32, ..Facts::default() });
                    assert_eq!(found, expected, "{name} at {key_bits} bits: {found:b} for {ray:?}");
                })
                .count();
            assert!(compared > 200, "{name} at {key_bits} bits: only {compared} rays were far from a border");
        }
    }
}

#[test]
fn layouts_name_the_same_bits() {
    let others = ["origin-light", "paraboloid", "grid-spherical", "tiled-octahedron"];
    for name in ["origin", "reis", "costa", "aila", "octahedron", "two-point", "light-octahedron"]
        .into_iter()
        .chain(others)
    {
        for lights in [1, 5, 64] {
            let layout =
                Method::builtin(name).unwrap().layout.expand(Extent { lights, picture: PICTURE }).unwrap();
            let names = layout.names();
            let expected = bits_of(name, lights);
            assert_eq!(names[..expected.len()], expected[..], "{name} with {lights} lights");
        }
    }
}
