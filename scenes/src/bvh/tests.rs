//! Hierarchies over many shapes of scenes, held against what traversal relies on.

use super::*;

/// A scene of triangles that share no corners.
pub(super) fn scene_of(triangles: &[[[f32; 3]; 3]]) -> Scene {
    let corners = (0..triangles.len() as u32).map(|index| [0, 1, 2].map(|corner| 3 * index + corner));
    Scene::of_geometry("test".into(), triangles.as_flattened().to_vec(), corners.collect())
}

/// Small triangles anywhere in the unit cube.
pub(super) fn soup(count: usize, seed: u64) -> Scene {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut triangle = || {
        let centre = std::array::from_fn(|_| random.f32());
        std::array::from_fn(|_| centre.map(|x| x + 0.1 * (random.f32() - 0.5)))
    };
    scene_of(&(0..count).map(|_| triangle()).collect::<Vec<_>>())
}

/// Every corner of a soup's triangles moved by `map`.
fn mapped(count: usize, map: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Scene {
    let mut scene = soup(count, 3);
    for (index, position) in scene.positions.iter_mut().enumerate() {
        *position = map(index / 3, *position);
    }
    scene
}

/// Scenes that have broken hierarchies elsewhere.
fn shapes() -> Vec<(&'static str, Scene)> {
    vec![
        ("one triangle", soup(1, 1)),
        ("two triangles", soup(2, 1)),
        ("three triangles", soup(3, 1)),
        ("nine triangles", soup(9, 1)),
        ("a soup", soup(3000, 1)),
        ("flat in y", mapped(500, |_, [x, _, z]| [x, 0.0, z])),
        ("flat in y, away from 0", mapped(500, |_, [x, _, z]| [x, 1234.567, z])),
        ("a line", mapped(500, |_, [x, _, _]| [x, 1.0, 2.0])),
        ("a point", mapped(5000, |_, _| [3.0, 4.0, 5.0])),
        ("the origin", mapped(5000, |_, _| [0.0; 3])),
        (
            "equal boxes in a row",
            mapped(5000, |index, p| [(index as f32) + (p[0] > 0.5) as u8 as f32, 0.0, 0.0]),
        ),
        ("far away", mapped(3000, |_, [x, y, z]| [x + 148_376.0, y + 1234.0, z - 223_423.0])),
        ("tiny", mapped(500, |_, p| p.map(|x| x * 1e-20))),
        ("tiny and far away", mapped(500, |_, p| p.map(|x| x * 1e-20 + 1.0))),
        ("huge", mapped(500, |_, p| p.map(|x| x * 1e12))),
        ("of all sizes", mapped(500, |index, p| p.map(|x| (x - 0.5) * 1.1f32.powi(index as i32 - 250)))),
        (
            "one huge among tiny",
            mapped(500, |index, p| if index == 7 { p.map(|x| x * 1e9) } else { p.map(|x| x * 1e-6) }),
        ),
    ]
}

#[test]
fn every_scene_gets_a_valid_hierarchy() {
    for (name, scene) in shapes() {
        for kind in BvhKind::ALL {
            // `build` validates; doing it again here keeps the test honest if it ever stops to.
            let bvh = build(&scene, kind).unwrap_or_else(|error| panic!("{name}, {kind}: {error}"));
            assert_eq!(validate(&bvh, &scene), Ok(()), "{name}, {kind}");
            assert_eq!(bvh.kind(), kind);
        }
    }
}

/// Boxes of which none is apart from the others: what a builder compares pair by pair takes for ever.
#[test]
fn heaps_of_triangles_take_seconds() {
    const COUNT: usize = 100_000;
    let heap = |place: &dyn Fn(usize, [f32; 3]) -> [f32; 3]| {
        let quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let corners = |index: usize| match index % 2 {
            0 => [quad[0], quad[1], quad[2]],
            _ => [quad[0], quad[2], quad[3]],
        };
        let triangle = |index: usize| corners(index).map(|corner| place(index / 2, corner));
        scene_of(&(0..COUNT).map(triangle).collect::<Vec<_>>())
    };
    let scenes = [
        ("coincident", heap(&|_, corner| corner)),
        ("coincident but one", heap(&|index, corner| corner.map(|x| if index == 0 { x + 1e3 } else { x }))),
        ("nested", heap(&|index, corner| corner.map(|x| x * (1.0 + 1e-5 * index as f32)))),
        ("concentric", heap(&|index, corner| corner.map(|x| (x - 0.5) * (1.0 + 1e-5 * index as f32)))),
    ];
    for (name, scene) in scenes {
        for kind in BvhKind::ALL {
            let start = std::time::Instant::now();
            build(&scene, kind).unwrap_or_else(|error| panic!("{name}, {kind}: {error}"));
            eprintln!("{name}, {kind}: {:?}", start.elapsed());
            assert!(start.elapsed().as_secs() < 20, "{name}, {kind}: {:?}", start.elapsed());
        }
    }
}

#[test]
fn threads_do_not_change_a_hierarchy() {
    let scene =
        mapped(120_000, |index, p| if index % 3 == 0 { p.map(|x| (x * 16.0).floor() / 16.0) } else { p });
    for kind in BvhKind::ALL {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&scene, kind).unwrap())
        };
        let one = with(1);
        for threads in [2, 3, 7] {
            assert!(one == with(threads), "{kind} with {threads} threads differs from one thread's");
        }
    }
}

#[test]
fn scenes_out_of_range_are_refused() {
    let mut empty = soup(1, 1);
    empty.triangles.clear();
    assert!(matches!(build(&empty, BvhKind::Bvh2), Err(BvhError::NoTriangles { .. })));
    for value in [f32::NAN, f32::INFINITY, -2e12] {
        let mut scene = soup(10, 1);
        scene.positions[17][2] = value;
        match build(&scene, BvhKind::Cwbvh) {
            Err(BvhError::Coordinate { triangle: 5, value: found }) => {
                assert_eq!(found.to_bits(), value.to_bits());
            }
            other => panic!("{value}: {other:?}"),
        }
    }
}

/// What `change` makes of a valid hierarchy.
fn verdict(kind: BvhKind, change: impl Fn(&mut Bvh)) -> Result<(), Defect> {
    let scene = soup(200, 4);
    let mut bvh = build(&scene, kind).unwrap();
    change(&mut bvh);
    validate(&bvh, &scene)
}

#[test]
fn defects_of_bvh2_are_found() {
    let nodes_of = |change: fn(&mut Vec<Bvh2Node>)| {
        verdict(BvhKind::Bvh2, |bvh| {
            let Bvh::Bvh2 { nodes, .. } = bvh else { unreachable!() };
            change(nodes);
        })
    };
    assert_eq!(nodes_of(|_| {}), Ok(()));
    assert!(matches!(nodes_of(|nodes| nodes[0].first = 4000), Err(Defect::Reference { node: 0 })));
    assert!(matches!(nodes_of(|nodes| nodes[0].first = 0), Err(Defect::Reference { node: 0 })));
    assert!(matches!(nodes_of(|nodes| nodes[0].first = 4), Err(Defect::Shared { .. })));
    assert!(matches!(nodes_of(|nodes| nodes[5].min[1] = 9.0), Err(Defect::Box { .. })));
    assert!(matches!(nodes_of(|nodes| nodes.clear()), Err(Defect::Reference { .. })));
    assert!(matches!(
        nodes_of(|nodes| nodes.last_mut().unwrap().count += 1),
        Err(Defect::Reference { .. } | Defect::Shared { .. })
    ));
    assert!(matches!(
        verdict(BvhKind::Bvh2, |bvh| {
            let Bvh::Bvh2 { order, .. } = bvh else { unreachable!() };
            order[3] = order[4];
        }),
        Err(Defect::Order { slot: 4, .. })
    ));
}

#[test]
fn defects_of_cwbvh_are_found() {
    let nodes_of = |change: fn(&mut Vec<CwbvhNode>)| {
        verdict(BvhKind::Cwbvh, |bvh| {
            let Bvh::Cwbvh { nodes, .. } = bvh else { unreachable!() };
            change(nodes);
        })
    };
    assert_eq!(nodes_of(|_| {}), Ok(()));
    assert!(matches!(nodes_of(|nodes| nodes[0].child_base = 4000), Err(Defect::Reference { node: 0 })));
    assert!(matches!(nodes_of(|nodes| nodes[0].child_base = 0), Err(Defect::Reference { node: 0 })));
    assert!(matches!(
        nodes_of(|nodes| nodes[0].child_base += 1),
        Err(Defect::Shared { .. } | Defect::Reference { .. })
    ));
    assert!(matches!(nodes_of(|nodes| nodes[0].imask = 0), Err(Defect::Reference { .. })));
    assert!(matches!(nodes_of(|nodes| nodes[1].p[0] += 0.5), Err(Defect::Box { node: 1 })));
    assert!(matches!(nodes_of(|nodes| nodes[1].e[2] -= 1), Err(Defect::Box { node: 1 })));
}

#[test]
fn defects_of_wide_are_found() {
    let nodes_of = |change: fn(&mut Vec<WideNode>)| {
        verdict(BvhKind::Wide, |bvh| {
            let Bvh::Wide { nodes, .. } = bvh else { unreachable!() };
            change(nodes);
        })
    };
    assert_eq!(nodes_of(|_| {}), Ok(()));
    assert!(matches!(nodes_of(|nodes| nodes[0].children[0] = 4000), Err(Defect::Reference { node: 0 })));
    assert!(matches!(nodes_of(|nodes| nodes[0].children[0] = 0), Err(Defect::Reference { node: 0 })));
    assert!(matches!(
        nodes_of(|nodes| nodes[0].children[0] = nodes[0].children[1]),
        Err(Defect::Shared { .. })
    ));
    let too_many = |nodes: &mut Vec<WideNode>| {
        nodes[0].children[0] = (WIDE_LEAF + 1) << WideNode::FIRST_BITS;
    };
    assert!(matches!(nodes_of(too_many), Err(Defect::Reference { node: 0 })));
    assert!(matches!(
        nodes_of(|nodes| nodes[1].planes[2][1][0] = nodes[1].planes[2][0][0]),
        Err(Defect::Box { node: 1 })
    ));
    assert!(matches!(nodes_of(|nodes| nodes[1].planes[0][0][0] = f32::NAN), Err(Defect::Box { node: 1 })));
    assert!(matches!(nodes_of(|nodes| nodes[0].planes[0][0][1] = f32::INFINITY), Err(Defect::Shared { .. })));
}
