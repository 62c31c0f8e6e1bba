//! What is said of a loaded scene: its features and its content hash.

use std::collections::HashSet;

use scenes::features::Features;
use scenes::hash::content_hash;
use scenes::{Environment, Light, Material, Scene, Texture};

use crate::fixture::Fixture;

/// A scene that uses nothing but diffuse triangles.
fn plain() -> Scene {
    let mut scene = Fixture::triangle().scene();
    scene.lights.clear();
    scene
}

const LIGHTS: [Light; 6] = [
    Light::Sphere { position: [1.0; 3], radius: 1.0, intensity: [1.0; 3] },
    Light::Point { position: [1.0; 3], intensity: [1.0; 3] },
    Light::Spot {
        position: [1.0; 3],
        direction: [0.0, 0.0, 1.0],
        intensity: [1.0; 3],
        inner_cone_cos: 0.9,
        outer_cone_cos: 0.8,
    },
    Light::Directional { direction: [0.0, 0.0, 1.0], irradiance: [1.0; 3] },
    Light::Emissive { first_triangle: 0, triangle_count: 1 },
    Light::Environment(Environment { zenith: [1.0; 3], nadir: [1.0; 3] }),
];

#[test]
fn each_feature_is_found_alone() {
    assert_eq!(Features::of(&plain()), Features::default());
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 11] = [
        ("alpha-masks", |scene| scene.materials[0].alpha_cutoff = Some(0.5)),
        ("textures", |scene| scene.materials[0].base_color_texture = Some(0)),
        ("emissive-triangles", |scene| scene.materials[0].emission[2] = 1.0),
        ("sphere-lights", |scene| scene.lights.push(LIGHTS[0].clone())),
        ("punctual-lights", |scene| scene.lights.push(LIGHTS[1].clone())),
        ("punctual-lights", |scene| scene.lights.push(LIGHTS[2].clone())),
        ("punctual-lights", |scene| scene.lights.push(LIGHTS[3].clone())),
        ("environment", |scene| scene.lights.push(LIGHTS[5].clone())),
        ("specular", |scene| scene.materials[0].metallic = 0.1),
        ("specular", |scene| scene.materials[0].roughness = 0.9),
        ("vertex-normals", |scene| scene.normals = vec![[0.0, 0.0, 1.0]; 3]),
    ];
    let mut names = HashSet::new();
    for (name, change) in changes {
        let mut scene = plain();
        change(&mut scene);
        let features = Features::of(&scene);
        assert_eq!(features.used(), [name]);
        assert_eq!(features.skipped().len(), 7);
        assert!(!features.skipped().contains(&name));
        names.insert(name);
    }
    assert_eq!(names.len(), 8);
}

#[test]
fn a_material_that_no_triangle_has_is_no_feature() {
    let mut scene = plain();
    scene.materials.push(Material { metallic: 1.0, emission: [1.0; 3], ..Material::default() });
    assert_eq!(Features::of(&scene), Features::default());
    scene.triangle_materials[0] = 1;
    assert_eq!(Features::of(&scene).used(), ["emissive-triangles", "specular"]);
}

#[test]
fn every_part_of_a_scene_changes_its_hash() {
    let mut base = plain();
    base.normals = vec![[0.0; 3]; 3];
    base.uvs = vec![[0.0; 2]; 3];
    base.lights = LIGHTS.to_vec();
    base.textures.push(Texture { width: 2, height: 1, rgba: vec![[0; 4]; 2] });
    let mut hashes = HashSet::from([content_hash(&base)]);
    let mut changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = base.clone();
        change(&mut scene);
        assert!(hashes.insert(content_hash(&scene)), "change {} goes unnoticed", hashes.len());
    };
    changed(&|scene| scene.positions[2][2] = 1.0);
    changed(&|scene| scene.normals[0][0] = 1.0);
    changed(&|scene| scene.normals.clear());
    changed(&|scene| scene.uvs[0][0] = 1.0);
    changed(&|scene| scene.uvs.clear());
    changed(&|scene| scene.triangles[0] = [1, 2, 0]);
    changed(&|scene| scene.triangle_materials[0] = 1);
    changed(&|scene| scene.materials.push(Material::default()));
    changed(&|scene| scene.materials[0].base_color[1] = 0.1);
    changed(&|scene| scene.materials[0].base_color_texture = Some(0));
    changed(&|scene| scene.materials[0].metallic = 0.1);
    changed(&|scene| scene.materials[0].roughness = 0.1);
    changed(&|scene| scene.materials[0].emission[0] = 0.1);
    changed(&|scene| scene.materials[0].alpha_cutoff = Some(0.0));
    changed(&|scene| scene.materials[0].alpha = 0.1);
    changed(&|scene| scene.textures[0].rgba[1][3] = 1);
    changed(&|scene| (scene.textures[0].width, scene.textures[0].height) = (1, 2));
    changed(&|scene| scene.lights.swap(0, 1));
    for light in 0..LIGHTS.len() {
        changed(&move |scene| {
            scene.lights.remove(light);
        });
    }
    changed(&|scene| {
        scene.lights[0] = Light::Sphere { position: [1.0; 3], radius: 2.0, intensity: [1.0; 3] }
    });
    changed(&|scene| scene.lights[4] = Light::Emissive { first_triangle: 0, triangle_count: 2 });
}

#[test]
fn names_cameras_and_notices_do_not_change_the_hash() {
    let base = plain();
    let mut scene = base.clone();
    scene.name.push('x');
    scene.materials[0].name.push('x');
    scene.cameras[0].eye[0] += 1.0;
    scene.notices.push("x".into());
    assert_eq!(content_hash(&scene), content_hash(&base));
}

#[test]
fn the_hash_is_the_same_on_every_machine() {
    let hash: String = content_hash(&plain()).iter().map(|byte| format!("{byte:02x}")).collect();
    // Made by another program from the description of `content_hash`.
    assert_eq!(hash, "b41da56ea5787dc68c44f5f31c337261f001a66450750d3c0785cb776f1b3044");
}
