//! The oracle against whole numbers, against itself without a hierarchy, and against answers known beforehand.

use formats::ray::{Hit, Ray};
use scenes::Scene;

use super::line::Line;
use super::{ExactHit, Oracle, Verdict};
use crate::stages::random::Random;

fn random(seed: u32) -> Random {
    Random::new([seed, 0], 0, 0, 0)
}

/// A whole number from −`size` to `size`.
fn whole(random: &mut Random, size: i32) -> i32 {
    (random.draw() * (2 * size + 1) as f32) as i32 - size
}

fn scene_of(triangles: &[[[f32; 3]; 3]]) -> Scene {
    let indices = (0..triangles.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]);
    Scene::of_geometry("test".into(), triangles.as_flattened().to_vec(), indices.collect())
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

fn determinant([a, b, c]: [[i64; 3]; 3]) -> i64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// Cramer's rule for origin + t·direction = p + u·(q − p) + v·(r − p): the four determinants.
fn solve(origin: [i64; 3], direction: [i64; 3], [p, q, r]: [[i64; 3]; 3]) -> Option<[i64; 4]> {
    let minus = |a: [i64; 3], b: [i64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let (e, f, s) = (minus(q, p), minus(r, p), minus(origin, p));
    let back = direction.map(|x| -x);
    let whole = determinant([back, e, f]);
    let [t, u, v] = [determinant([s, e, f]), determinant([back, s, f]), determinant([back, e, s])];
    let sign = whole.signum();
    let is_inside = whole != 0 && u * sign >= 0 && v * sign >= 0 && (u + v) * sign <= whole * sign;
    is_inside.then_some([whole, t, u, v])
}

#[test]
fn lines_cross_triangles_where_whole_numbers_say() {
    let mut random = random(1);
    let (mut hits, mut on_borders) = (0, 0);
    for round in 0..200_000 {
        let size = [2, 5, 40][round % 3];
        let mut point = || [0; 3].map(|_: i32| whole(&mut random, size));
        let (origin, direction, corners) = (point(), point(), [point(), point(), point()]);
        let wide = |v: [i32; 3]| v.map(i64::from);
        let expected = solve(wide(origin), wide(direction), corners.map(wide));
        // Scales that are powers of two change nothing but the exponents.
        let tiny = |exponent: i32| f32::from_bits(1 << (exponent + 149));
        for (scale, speed) in [(1.0, 1.0), (tiny(-140), tiny(-145)), (2f32.powi(100), tiny(-130))] {
            let float = |v: [i32; 3]| v.map(|x| x as f32 * scale);
            let ray = ray(float(origin), direction.map(|x| x as f32 * speed));
            let found = Line::new(&ray).cross(&corners.map(float));
            let Some([whole, t, u, v]) = expected else {
                assert_eq!(found, None, "{ray:?} {corners:?}");
                continue;
            };
            let found = found.unwrap_or_else(|| panic!("{ray:?} does not cross {corners:?}"));
            let whole = whole as f64;
            let t = t as f64 / whole * f64::from(scale) / f64::from(speed);
            assert!((found.t - t).abs() <= found.error + 1e-15 * t.abs(), "{found:?}, not {t}");
            for (weight, expected) in found.weights[1..].iter().zip([u, v]) {
                assert!((weight - expected as f64 / whole).abs() < 1e-12, "{found:?}");
            }
            hits += 1;
            on_borders += usize::from(found.weights.contains(&0.0));
        }
    }
    assert!(hits > 30_000 && on_borders > 3000, "{hits} hits, {on_borders} of them on an edge or a corner");
}

#[test]
fn a_line_that_misses_an_edge_by_less_than_double_precision_misses_it() {
    // The edge from (0, −1, 1) to (0, 1, 1), passed at 2^-100 of its distance on either side.
    let left = [[0.0, -1.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 1.0]];
    let right = [[0.0, -1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    for (side, expected) in [(-1.0, [true, false]), (0.0, [true, true]), (1.0, [false, true])] {
        let line = Line::new(&ray([0.0; 3], [side * 2f32.powi(-100), 0.0, 1.0]));
        assert_eq!([left, right].map(|corners| line.cross(&corners).is_some()), expected, "side {side}");
        let line = Line::new(&ray([side * 2f32.powi(-100), 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert_eq!([left, right].map(|corners| line.cross(&corners).is_some()), expected, "side {side}");
    }
}

/// Triangles and rays on a coarse grid, so that ties, edges and flat boxes are common, or off it.
fn soup(random: &mut Random, count: usize, grid: Option<f32>) -> Vec<[[f32; 3]; 3]> {
    let snap = |x: f32| grid.map_or(x, |steps| (x * steps).round() / steps);
    (0..count)
        .map(|_| {
            let centre = [0; 3].map(|_| random.draw());
            [0; 3].map(|_| [0, 1, 2].map(|axis: usize| snap(centre[axis] + 0.3 * random.draw())))
        })
        .collect()
}

#[test]
fn the_hierarchy_loses_no_hit() {
    let mut random = random(2);
    for (count, grid) in
        [(0, None), (1, None), (3, Some(4.0)), (700, None), (700, Some(8.0)), (300, Some(0.5))]
    {
        let scene = scene_of(&soup(&mut random, count, grid));
        let oracle = Oracle::new(&scene);
        let mut hit = 0;
        for number in 0..4000 {
            let snap = |x: f32| if number % 2 == 0 { (x * 8.0).round() / 8.0 } else { x };
            let direction = [0; 3].map(|_| snap(2.0 * random.draw() - 1.0));
            let mut ray = ray([0; 3].map(|_| snap(1.4 * random.draw())), direction);
            ray.t_max = if number % 3 == 0 { random.draw() } else { f32::INFINITY };
            let all: Vec<ExactHit> = (0..count as u32)
                .filter_map(|triangle| oracle.hit(&Line::new(&ray), triangle))
                .filter(|hit| 0.0 <= hit.t && hit.t <= f64::from(ray.t_max))
                .collect();
            let (line, mut found) = (Line::new(&ray), Vec::new());
            oracle.tree.walk(&line, |triangle| {
                found.extend(oracle.hit(&line, triangle).filter(|hit| line.includes(hit.t)));
                line.t_max
            });
            found.sort_by_key(|hit| hit.triangle);
            assert_eq!(found, all, "{ray:?}");
            let nearest = all.iter().copied().reduce(|a, b| if b.is_before(&a) { b } else { a });
            assert_eq!(oracle.closest(&ray).map(|hit| hit.t), nearest.map(|hit| hit.t), "{ray:?}");
            hit += usize::from(!all.is_empty());
        }
        assert!(count < 300 || hit > 500, "only {hit} rays hit anything");
    }
}

#[test]
fn broken_rays_hit_nothing() {
    let oracle = Oracle::new(&scene_of(&[[[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, 1.0]]]));
    assert!(oracle.closest(&ray([0.0; 3], [0.0, 0.0, 1.0])).is_some());
    for direction in [[0.0; 3], [0.0, 0.0, f32::INFINITY], [f32::NAN, 0.0, 1.0]] {
        assert!(oracle.closest(&ray([0.0; 3], direction)).is_none(), "{direction:?}");
    }
}

/// A square from −1 to 1 at z = 1 of two triangles, and behind it one at z = 2 of the same.
fn squares() -> Oracle {
    let square = |z: f32| {
        let [a, b, c, d] = [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
        [[a, b, c], [a, c, d]]
    };
    Oracle::new(&scene_of(&[square(1.0), square(2.0)].concat()))
}

fn hit(t: f32, triangle: u32) -> Hit {
    Hit { t, triangle, u: 0.0, v: 0.0 }
}

#[test]
fn answers_are_judged() {
    let oracle = squares();
    let judge = |ray: &Ray, hit: Hit| oracle.judge(ray, &hit).verdict;
    // Well inside triangle 0.
    let plain = ray([0.5, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(judge(&plain, hit(1.0, 0)), Verdict::Right);
    assert_eq!(judge(&plain, hit(1.0, 1)), Verdict::WrongTriangle);
    assert_eq!(judge(&plain, hit(2.0, 2)), Verdict::WrongTriangle);
    assert_eq!(judge(&plain, Hit::MISS), Verdict::Missed);
    assert_eq!(judge(&ray([1.5, 0.0, 0.0], [0.0, 0.0, 1.0]), hit(1.0, 0)), Verdict::FalseHit);
    assert_eq!(judge(&ray([1.5, 0.0, 0.0], [0.0, 0.0, 1.0]), Hit::MISS), Verdict::Right);
    // On the diagonal, and so near to it that single precision cannot tell.
    for x in [0.0, 1e-7, -1e-7] {
        let diagonal = ray([x, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert!(judge(&diagonal, hit(1.0, 0)).is_right() && judge(&diagonal, hit(1.0, 1)).is_right());
        assert_eq!(judge(&diagonal, hit(2.0, 2)), Verdict::WrongTriangle, "a leak");
        assert_eq!(judge(&diagonal, Hit::MISS), Verdict::Missed, "a leak");
    }
    assert_eq!(judge(&ray([1e-4, 0.0, 0.0], [0.0, 0.0, 1.0]), hit(1.0, 1)), Verdict::WrongTriangle);
    // At the outline both are right: to hit the front, or to pass it and find nothing.
    for x in [0.999_999_94, 1.0, 1.000_000_1] {
        let outline = ray([x, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert!(judge(&outline, hit(1.0, 0)).is_right() && judge(&outline, Hit::MISS).is_right(), "{x}");
    }
    // Within rounding of the ends.
    for t_max in [1f32.next_down(), 1.0, 1f32.next_up()] {
        let ends = Ray { t_max, ..plain };
        assert!(judge(&ends, hit(1.0, 0)).is_right() && judge(&ends, Hit::MISS).is_right(), "{t_max}");
    }
    assert_eq!(judge(&Ray { t_max: 1.01, ..plain }, Hit::MISS), Verdict::Missed);
    assert_eq!(judge(&Ray { t_max: 0.99, ..plain }, hit(1.0, 0)), Verdict::FalseHit);
    assert_eq!(judge(&Ray { t_min: 1.01, ..plain }, hit(2.0, 2)), Verdict::Right);
}

#[test]
fn occlusion_is_judged() {
    let oracle = squares();
    let judge = |ray: &Ray, distance: f32| oracle.judge_occlusion(ray, distance).verdict;
    let plain = ray([0.5, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(judge(&plain, 1.0), Verdict::Right);
    assert_eq!(judge(&plain, 2.0), Verdict::Right);
    assert_eq!(judge(&plain, 1.5), Verdict::FalseHit);
    assert_eq!(judge(&plain, f32::INFINITY), Verdict::Missed);
    let short = Ray { t_max: 0.5, ..plain };
    assert_eq!(judge(&short, f32::INFINITY), Verdict::Right);
    assert_eq!(judge(&short, 1.0), Verdict::FalseHit);
}

#[test]
fn distances_are_compared_in_ulps_of_the_coordinates() {
    let oracle = squares();
    // The largest coordinate is 4, whose ulp is 2^-21, for any length of the direction.
    for speed in [1.0, 0.25] {
        let from_afar = ray([0.5, 0.0, -4.0], [0.0, 0.0, speed]);
        let off = hit((5.0 + 3.0 * 2f32.powi(-21)) / speed, 0);
        let deviation = oracle.judge(&from_afar, &off).t.unwrap();
        assert_eq!(deviation.ulps, 3.0);
        assert!((2.0..50.0).contains(&deviation.tolerance_ulps), "{deviation:?}");
    }
    // Of two parallel squares nearer than rounding, both are right.
    let [front, behind] = [1.0, 1f32.next_up()].map(|z| [[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]]);
    let oracle = Oracle::new(&scene_of(&[behind, front]));
    let straight = ray([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(oracle.judge(&straight, &hit(1.0, 1)).verdict, Verdict::Right);
    assert_eq!(oracle.judge(&straight, &hit(1.0, 0)).verdict, Verdict::Tied);
}
