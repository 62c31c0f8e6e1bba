//! Capsules: they hold what they are around, in any order and at any place of the group.

use std::f64::consts::PI;

use formats::metrics::capsule::{Capsule, Point, Segment};
use proptest::prelude::*;

use crate::cases;

/// Roundings of a few operations on coordinates near 1.
const TOLERANCE: f64 = 1e-12;

fn point() -> impl Strategy<Value = Point> {
    // Some coordinates coincide, so that groups are flat, straight or one point.
    let along = || prop_oneof![4 => 0.0..1.0f64, 1 => Just(0.25), 1 => Just(-0.0)];
    [along(), along(), along()]
}

fn group() -> impl Strategy<Value = Vec<Segment>> {
    prop::collection::vec((point(), point()).prop_map(|(origin, end)| Segment { origin, end }), 1..65)
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn moved(point: Point, by: Point) -> Point {
    [0, 1, 2].map(|axis| point[axis] + by[axis])
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn every_point_lies_in_its_sphere_and_every_segment_in_the_hull(group in group(), along in 0.0..1.0f64) {
        let capsule = Capsule::around(&group).unwrap();
        let Capsule { origin_centre, origin_radius, end_centre, end_radius } = capsule;
        for Segment { origin, end } in &group {
            prop_assert!(distance(*origin, origin_centre) <= origin_radius);
            prop_assert!(distance(*end, end_centre) <= end_radius);
            // The hull of two spheres is all the spheres between them.
            let mix = |a: Point, b: Point| [0, 1, 2].map(|axis| a[axis] + along * (b[axis] - a[axis]));
            let radius = origin_radius + along * (end_radius - origin_radius);
            prop_assert!(distance(mix(*origin, *end), mix(origin_centre, end_centre)) <= radius + TOLERANCE);
        }
        // No larger than the box around it makes necessary.
        prop_assert!(origin_radius <= 3f64.sqrt() / 2.0 + TOLERANCE && end_radius <= 3f64.sqrt() / 2.0 + TOLERANCE);
        // A convex thing has at least the area of what it holds, and at most that of what holds it.
        let apart = distance(origin_centre, end_centre);
        let larger = origin_radius.max(end_radius);
        let around = larger + 0.5 * apart;
        prop_assert!(capsule.area() >= 4.0 * PI * larger * larger - TOLERANCE);
        prop_assert!(capsule.area() <= 4.0 * PI * around * around + TOLERANCE);
    }

    #[test]
    fn order_and_direction_do_not_count(group in group(), turn in any::<prop::sample::Index>()) {
        let capsule = Capsule::around(&group).unwrap();
        let mut turned = group.clone();
        turned.rotate_left(turn.index(group.len()));
        prop_assert_eq!(Capsule::around(&turned), Some(capsule));
        turned.reverse();
        prop_assert_eq!(Capsule::around(&turned), Some(capsule));
        let swapped: Vec<Segment> =
            group.iter().map(|&Segment { origin, end }| Segment { origin: end, end: origin }).collect();
        let swapped = Capsule::around(&swapped).unwrap();
        prop_assert!((swapped.area() - capsule.area()).abs() <= TOLERANCE);
    }

    #[test]
    fn moving_a_group_moves_its_capsule(group in group(), by in [-8.0..8.0f64, -8.0..8.0f64, -8.0..8.0f64]) {
        let capsule = Capsule::around(&group).unwrap();
        let elsewhere: Vec<Segment> = group
            .iter()
            .map(|segment| Segment { origin: moved(segment.origin, by), end: moved(segment.end, by) })
            .collect();
        let elsewhere = Capsule::around(&elsewhere).unwrap();
        prop_assert!(distance(elsewhere.origin_centre, moved(capsule.origin_centre, by)) <= TOLERANCE);
        prop_assert!((elsewhere.origin_radius - capsule.origin_radius).abs() <= TOLERANCE);
        prop_assert!((elsewhere.end_radius - capsule.end_radius).abs() <= TOLERANCE);
        // The area's slope in the distance of the centres is bounded by that of a sphere that grows.
        prop_assert!((elsewhere.area() - capsule.area()).abs() <= 1e-6);
    }
}
