//! Nodes: transforms, instances, cameras and lights in them.

use scenes::{Light, Scene};
use serde_json::{Value, json};

use crate::fixture::{Fixture, TRIANGLE, corners};

#[test]
fn a_hierarchy_of_matrices_and_trs() {
    let mut fixture = Fixture::triangle();
    // Down the tree: move by (0, 0, 5), a quarter turn about z, stretch by (2, 3, 1).
    let half = std::f32::consts::FRAC_1_SQRT_2;
    fixture.json["nodes"] = json!([
        { "children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1] },
        { "children": [2], "rotation": [0, 0, half, half] },
        { "mesh": 0, "scale": [2, 3, 1], "translation": [1, 0, 0] },
    ]);
    let found = corners(&fixture.scene());
    let expected = [[0.0, 1.0, 5.0], [0.0, 3.0, 5.0], [-3.0, 1.0, 5.0]];
    for (found, expected) in found[0].as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
    }
}

#[test]
fn mirrors_turn_the_winding_and_keep_normals_outside() {
    let mut fixture = Fixture::triangle();
    let normals = fixture.vectors(&[[0.0, 0.0, 1.0]; 3]);
    fixture.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    fixture.json["nodes"][0]["scale"] = json!([-2, 1, 1]);
    let mirrored = fixture.scene();
    assert_eq!(corners(&mirrored), [[[0.0; 3], [0.0, 1.0, 0.0], [-2.0, 0.0, 0.0]]]);
    assert_eq!(mirrored.normals, [[0.0, 0.0, 1.0]; 3]);
    fixture.json["nodes"][0]["scale"] = json!([-2, 1, -1]);
    let turned = fixture.scene();
    assert_eq!(turned.triangles, [[0, 1, 2]]);
    assert_eq!(turned.normals, [[0.0, 0.0, -1.0]; 3]);
}

#[test]
fn a_mesh_scaled_flat_keeps_its_normals() {
    let mut fixture = Fixture::triangle();
    let normals = fixture.vectors(&[[0.0, 0.5, 1.0]; 3]);
    fixture.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    fixture.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    assert_eq!(fixture.scene().normals, [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn instances_follow_the_order_of_nodes() {
    let mut fixture = Fixture::triangle();
    fixture.node(json!({ "mesh": 0, "translation": [10, 0, 0], "children": [2] }));
    fixture.push("nodes", json!({ "mesh": 0, "translation": [0, 10, 0] }));
    let scene = fixture.scene();
    let at = |x: f32, y: f32| TRIANGLE.map(|[a, b, c]| [a + x, b + y, c]);
    assert_eq!(corners(&scene), [at(0.0, 0.0), at(10.0, 0.0), at(10.0, 10.0)]);
}

#[test]
fn the_default_scene_counts_else_the_first_else_all_roots() {
    let mut fixture = Fixture::triangle();
    fixture.push("nodes", json!({ "mesh": 0, "translation": [10, 0, 0], "children": [2] }));
    fixture.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 5] }));
    fixture.push("scenes", json!({ "nodes": [1] }));
    let first_corners = |fixture: &Fixture| -> Vec<[f32; 3]> {
        corners(&fixture.scene()).iter().map(|corners| corners[0]).collect()
    };
    fixture.json["scene"] = json!(1);
    assert_eq!(first_corners(&fixture), [[10.0, 0.0, 0.0], [10.0, 0.0, 5.0]]);
    fixture.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(first_corners(&fixture), [[0.0; 3]]);
    fixture.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(first_corners(&fixture), [[0.0; 3], [10.0, 0.0, 0.0], [10.0, 0.0, 5.0]]);
}

#[test]
fn nesting_has_no_bottom() {
    const DEPTH: usize = 20_000;
    let mut fixture = Fixture::triangle();
    let nodes = (1..=DEPTH).map(|child| json!({ "children": [child], "translation": [0, 0, 1] }));
    let nodes: Vec<Value> = nodes.chain([json!({ "mesh": 0 })]).collect();
    fixture.json["nodes"] = json!(nodes);
    assert_eq!(fixture.scene().positions[1], [1.0, 0.0, DEPTH as f32]);
}

fn camera(yfov: f32) -> Value {
    json!({ "type": "perspective", "name": "inner", "perspective": { "yfov": yfov, "znear": 0.1 } })
}

#[test]
fn cameras_of_nodes() {
    let mut fixture = Fixture::triangle();
    fixture.push("cameras", camera(0.5));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotation = json!([0, half, 0, half]);
    fixture.node(json!({ "camera": 0, "rotation": rotation, "translation": [1, 2, 3], "scale": [-3, 3, 3] }));
    for _ in 0..3 {
        fixture.node(json!({ "camera": 0, "name": "outer" }));
    }
    let orthographic = json!({ "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9 });
    fixture.push("cameras", json!({ "type": "orthographic", "orthographic": orthographic }));
    fixture.node(json!({ "camera": 1 }));
    let scene = fixture.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
    assert_eq!(names, ["inner", "outer", "outer-2", "outer-3"]);
    let turned = &scene.cameras[0];
    assert_eq!((turned.eye, turned.yfov_radians), ([1.0, 2.0, 3.0], 0.5));
    // A quarter turn to the left looks along −x, and a mirror does not make a left-handed camera.
    for (found, expected) in
        [(turned.forward, [-1.0, 0.0, 0.0]), (turned.up, [0.0, 1.0, 0.0]), (turned.right, [0.0, 0.0, -1.0])]
    {
        assert!(found.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6), "{found:?}");
    }
    assert_eq!(scene.notices[0], "cameras without perspective are skipped (1)");
}

#[test]
fn a_camera_without_a_name_is_called_by_its_number() {
    let mut fixture = Fixture::triangle();
    fixture.push("cameras", camera(0.5));
    fixture.push("cameras", camera(0.5));
    fixture.json["cameras"][1]["name"] = json!("");
    fixture.node(json!({ "camera": 0, "name": "" }));
    fixture.node(json!({ "camera": 1, "name": "" }));
    let scene = fixture.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| &*camera.name).collect();
    assert_eq!(names, ["inner", "camera 1"]);
}

/// A triangle and these lights, each in a node one to the right of the last one.
fn lit(lights: Value) -> Result<Scene, String> {
    let mut fixture = Fixture::triangle();
    for light in 0..lights.as_array().map_or(0, Vec::len) {
        let extensions = json!({ "KHR_lights_punctual": { "light": light } });
        fixture.node(json!({ "translation": [light, 0, 0], "scale": [2, 2, 2], "extensions": extensions }));
    }
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    fixture.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    fixture.load()
}

#[test]
fn punctual_lights() {
    let scene = lit(json!([
        { "type": "point", "color": [1, 0.5, 0], "intensity": 8 },
        { "type": "point", "intensity": 0 },
        { "type": "directional", "intensity": 3 },
        { "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
        { "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.5 } },
    ]))
    .unwrap();
    let direction = [0.0, 0.0, -1.0];
    let spot = |x: f32, inner_cone_cos: f32, outer_cone_cos: f32| Light::Spot {
        position: [x, 0.0, 0.0],
        direction,
        intensity: [1.0; 3],
        inner_cone_cos,
        outer_cone_cos,
    };
    let hard_edge = 0.5_f32.cos();
    assert_eq!(
        scene.lights,
        [
            Light::Point { position: [0.0; 3], intensity: [8.0, 4.0, 0.0] },
            Light::Directional { direction, irradiance: [3.0; 3] },
            spot(3.0, 0.25_f32.cos(), 0.5_f32.cos()),
            spot(4.0, hard_edge, hard_edge - 0.001),
        ]
    );
    assert_eq!(scene.notices[0], "lights without intensity are left out (1)");
    let (mut round, sharp) = (scene.clone(), scene);
    round.give_points_a_radius(0.05);
    let sphere = Light::Sphere { position: [0.0; 3], radius: 0.05, intensity: [8.0, 4.0, 0.0] };
    assert_eq!((&round.lights[0], &round.lights[1..]), (&sphere, &sharp.lights[1..]));
    assert!(round.notices.contains(&"point lights were given a radius of 0.05 (1 of 4)".to_owned()));
}

#[test]
fn a_light_that_makes_no_sense_is_left_out_and_said() {
    let good = json!({ "type": "point", "intensity": 8 });
    for (light, expected) in [
        (json!({ "type": "point", "intensity": -1 }), "a colour and intensity of [1.0, 1.0, 1.0] times -1"),
        (
            json!({ "type": "point", "color": [1, -1, 0] }),
            "a colour and intensity of [1.0, -1.0, 0.0] times 1",
        ),
        (json!({ "type": "lamp" }), "a type that is unknown, expected point, spot or directional"),
        (json!({ "type": "spot" }), "the type spot, expected its cone beside it"),
    ] {
        let scene = lit(json!([light, good])).unwrap();
        assert_eq!(scene.lights, [Light::Point { position: [1.0, 0.0, 0.0], intensity: [8.0; 3] }]);
        let notice = &scene.notices[0];
        assert!(notice.starts_with(&format!("light 0 of node 1 has {expected}")), "{notice}");
        assert!(notice.ends_with("; it is left out"), "{notice}");
    }
    let mut fixture = Fixture::triangle();
    let lights = json!({ "lights": [{ "type": "directional" }] });
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": lights });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    fixture.node(json!({ "scale": [0, 0, 0], "extensions": extensions }));
    let expected =
        "light 0 of node 1 has the scale 0, expected one that leaves it a direction; it is left out";
    assert_eq!(fixture.scene().notices[0], expected);
    fixture.json["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(5);
    let message = fixture.load().unwrap_err();
    assert!(message.contains("node 1 refers to light 5, which does not exist"), "{message}");
}

#[test]
fn a_range_of_a_light_is_said_to_have_no_effect() {
    let scene = lit(json!([
        { "type": "point", "intensity": 8, "range": 3 },
        { "type": "spot", "spot": {}, "range": 3 },
        // Only point and spot lights have one.
        { "type": "directional", "range": 3 },
    ]));
    let scene = scene.unwrap();
    assert_eq!(scene.lights[0], Light::Point { position: [0.0; 3], intensity: [8.0; 3] });
    assert_eq!(scene.notices[0], "lights have a range, which is ignored (2)");
}
