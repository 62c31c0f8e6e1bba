//! What must hold for each built-in scene.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

#[allow(dead_code, reason = "what makes files is not used here")]
#[path = "import/fixture.rs"]
mod fixture;

use std::sync::LazyLock;

use glam::DVec3;
use sha2::{Digest, Sha256};

use scenes::builtin::{BuiltinError, BuiltinInfo, build, list};
use scenes::{Light, Scene};

/// Every scene at its default and at its coarsest, built once.
fn samples() -> &'static [Scene] {
    static SAMPLES: LazyLock<Vec<Scene>> = LazyLock::new(|| {
        let sizes = |info: &BuiltinInfo| {
            [None, Some(info.least_triangles)].map(|count| build(info.name, count).unwrap())
        };
        list().iter().flat_map(sizes).collect()
    });
    &SAMPLES
}

fn corners(scene: &Scene, triangle: usize) -> [DVec3; 3] {
    scene.corners(triangle).map(|corner| DVec3::from(corner.map(f64::from)))
}

/// A digest of everything in a scene that a tracer sees.
fn digest(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    hash.update(bytemuck::cast_slice(&scene.positions));
    hash.update(bytemuck::cast_slice(&scene.normals));
    hash.update(bytemuck::cast_slice(&scene.uvs));
    hash.update(bytemuck::cast_slice(&scene.triangles));
    hash.update(bytemuck::cast_slice(&scene.triangle_materials));
    hash.update(format!("{:?}{:?}", scene.materials, scene.textures));
    hash.update(format!("{:?}{:?}", scene.lights, scene.cameras));
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn scenes_keep_the_invariants_of_a_scene() {
    for scene in samples() {
        // The name stands above the message if the check panics.
        eprintln!("{}", scene.name);
        fixture::check_invariants(scene);
    }
}

#[test]
fn every_material_is_used_and_names_differ() {
    for info in list() {
        let scene = build(info.name, None).unwrap();
        for (index, material) in scene.materials.iter().enumerate() {
            let used = scene.triangle_materials.contains(&(index as u32));
            assert!(used, "{}: nothing is made of {}", info.name, material.name);
            let named = scene.materials.iter().filter(|other| other.name == material.name).count();
            assert_eq!(named, 1, "{}: two materials {}", info.name, material.name);
        }
    }
}

#[test]
fn the_wanted_count_is_met_within_five_percent() {
    for info in list() {
        let mut wanted = info.least_triangles;
        let mut counts = vec![info.default_triangles];
        while wanted < 1_200_000.min(20 * info.default_triangles) {
            counts.push(wanted);
            wanted = wanted * 8 / 5 + 3;
        }
        for wanted in counts {
            let found = build(info.name, Some(wanted)).unwrap().triangles.len() as f64;
            let error = (found / wanted as f64 - 1.0).abs();
            assert!(error <= 0.05, "{}: {found} triangles instead of {wanted}", info.name);
        }
    }
}

#[test]
fn too_few_triangles_give_the_coarsest_scene_and_a_notice() {
    for info in list() {
        let coarsest = build(info.name, Some(info.least_triangles)).unwrap();
        let scene = build(info.name, Some(1)).unwrap();
        assert_eq!(digest(&scene), digest(&coarsest), "{}", info.name);
        assert!(coarsest.notices.is_empty(), "{}", info.name);
        assert_eq!(scene.notices.len(), 1, "{}", info.name);
    }
}

#[test]
fn what_cannot_be_built_is_refused() {
    let unknown = build("citty", None).unwrap_err();
    let known = "cornell, atrium, apartment, city, hairball, terrain".to_string();
    assert_eq!(unknown, BuiltinError::UnknownName { name: "citty".into(), known });
    for info in list() {
        let (least, most, name) = (info.least_triangles, info.most_triangles, info.name);
        for asked in [0, most + 1, u64::from(u32::MAX) + 1, u64::MAX] {
            let refused = build(name, Some(asked)).unwrap_err();
            assert_eq!(refused, BuiltinError::TriangleCount { name, asked, least, most });
        }
        assert!(info.least_triangles <= info.default_triangles);
        assert!(info.default_triangles <= info.most_triangles);
        // Even with a vertex of its own for every corner, indices fit into 32 bits.
        assert!(3 * info.most_triangles < u64::from(u32::MAX));
    }
}

#[test]
fn the_same_scene_is_the_same_bits() {
    for scene in samples().iter().step_by(2) {
        let again = build(&scene.name, None).unwrap();
        assert_eq!(digest(scene), digest(&again), "{}", scene.name);
    }
}

/// Goldens: a change here changes every recording of a built-in scene, so it must be meant.
#[test]
fn coarse_scenes_have_the_known_bits() {
    let found: Vec<_> = list()
        .iter()
        .map(|info| (info.name, digest(&build(info.name, Some(info.least_triangles)).unwrap())))
        .collect();
    let known = [
        ("cornell", "8f34313cdbfe5fdc"),
        ("atrium", "ad12220f1903ffc0"),
        ("apartment", "ada86f302da42c6b"),
        ("city", "61a8af9cb32b1265"),
        ("hairball", "4d759ec21b662c4e"),
        ("terrain", "d188d5ea99102e42"),
    ];
    assert_eq!(found, known.map(|(name, digest)| (name, digest.to_string())));
}

#[test]
fn hardly_any_triangle_is_degenerate() {
    for scene in samples() {
        let degenerate = (0..scene.triangles.len())
            .filter(|&triangle| {
                let [a, b, c] = corners(scene, triangle);
                (b - a).cross(c - a).length() == 0.0
            })
            .count();
        let share = degenerate as f64 / scene.triangles.len() as f64;
        assert!(share < 0.001, "{}: {degenerate} degenerate triangles", scene.name);
    }
}

#[test]
fn vertex_normals_are_on_the_side_of_their_face() {
    for scene in samples().iter().filter(|scene| !scene.normals.is_empty()) {
        let (mut smooth, mut wrong) = (0, 0);
        for (triangle, indices) in scene.triangles.iter().enumerate() {
            let [a, b, c] = corners(scene, triangle);
            let face = (b - a).cross(c - a);
            for &index in indices {
                let normal = DVec3::from(scene.normals[index as usize].map(f64::from));
                smooth += usize::from(normal != DVec3::ZERO);
                wrong += usize::from(normal.dot(face) < 0.0);
            }
        }
        assert!(smooth > 0);
        let share = wrong as f64 / smooth as f64;
        assert!(share < 0.005, "{}: {wrong} of {smooth} normals point inwards", scene.name);
    }
}

#[test]
fn cameras_are_orthonormal_and_stand_clear_of_everything() {
    const CLEARANCE: f64 = 0.04;
    for scene in samples() {
        for camera in &scene.cameras {
            let [forward, right, up] =
                [camera.forward, camera.right, camera.up].map(|axis| DVec3::from(axis.map(f64::from)));
            assert!((right.cross(forward) - up).length() < 1e-6, "{} {}", scene.name, camera.name);
            assert!((forward.length() - 1.0).abs() < 1e-6, "{} {}", scene.name, camera.name);
            assert!(up.y > 0.0 && (0.3..2.0).contains(&camera.yfov_radians));
            let eye = DVec3::from(camera.eye.map(f64::from));
            let nearest = (0..scene.triangles.len())
                .map(|triangle| distance(eye, corners(scene, triangle)))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest > CLEARANCE, "{} {}: {nearest} m clear", scene.name, camera.name);
        }
    }
}

/// Distance from a point to a triangle: to its plane if the foot of the perpendicular is inside,
/// else to the nearest edge.
fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_edge = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let t = (point - from).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        point.distance(from + edge * t.clamp(0.0, 1.0))
    };
    let normal = (b - a).cross(c - a);
    let is_inside = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) >= 0.0;
    if normal.length() > 0.0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return (point - a).dot(normal.normalize()).abs();
    }
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[test]
fn lights_are_in_order_and_cover_the_emissive_triangles() {
    for scene in samples() {
        let name = &scene.name;
        let rank = |light: &Light| match light {
            Light::Emissive { .. } => 1,
            Light::Environment(_) => 2,
            _ => 0,
        };
        assert!(scene.lights.is_sorted_by_key(rank), "{name}: {:?}", scene.lights);
        assert!(!scene.lights.is_empty(), "{name} is dark");
        let environments = scene.lights.iter().filter(|light| rank(light) == 2).count();
        assert!(environments <= 1, "{name}");
        let mut lit = vec![false; scene.triangles.len()];
        for light in &scene.lights {
            if let Light::Emissive { first_triangle, triangle_count } = *light {
                let range = first_triangle as usize..(first_triangle + triangle_count) as usize;
                let material = scene.triangle_materials[range.start];
                assert!(scene.triangle_materials[range.clone()].iter().all(|&m| m == material));
                lit[range].fill(true);
            }
            if let Light::Sphere { radius, .. } = light {
                assert_eq!(*radius, 0.05, "{name}");
            }
        }
        for (lit, &material) in lit.iter().zip(&scene.triangle_materials) {
            assert_eq!(*lit, scene.materials[material as usize].is_emissive(), "{name}");
        }
    }
}

#[test]
fn the_features_that_only_files_would_bring_are_there() {
    let scenes = samples();
    assert!(scenes.iter().any(|scene| !scene.normals.is_empty()));
    assert!(scenes.iter().any(|scene| scene.normals.is_empty()));
    let has_mask = |scene: &Scene| scene.materials.iter().any(|m| m.alpha_cutoff.is_some());
    assert!(scenes.iter().any(has_mask));
    assert!(!scenes.iter().all(has_mask));
    for scene in scenes.iter().filter(|scene| has_mask(scene)) {
        // A mask that hides nothing, or all, would test nothing.
        let alphas: Vec<u8> = scene.textures[0].rgba.iter().map(|texel| texel[3]).collect();
        let shown = alphas.iter().filter(|&&alpha| alpha > 127).count() as f64 / alphas.len() as f64;
        assert!((0.2..0.8).contains(&shown), "{}: {shown} of the mask is opaque", scene.name);
    }
}
