//! The camera and the lights that are made for scenes that have none.

use scenes::{Camera, Light, Scene};
use serde_json::json;

use crate::fixture::Fixture;

/// A box of 4 × 2.5 × 6 around (10, 1.25, 0), whose fronts are inside or outside.
fn house(fronts_inside: bool, has_ceiling: bool) -> Fixture {
    let mut fixture = Fixture::new();
    let corner = |index: usize| [index & 1, index >> 1 & 1, index >> 2 & 1].map(|bit| bit as f32 - 0.5);
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let positions = fixture.vectors(&corners);
    // Seen from outside, anticlockwise: left, right, floor, front, back, ceiling.
    let sides: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [4, 5, 7, 6], [0, 2, 3, 1], [2, 6, 7, 3]];
    let sides = &sides[..if has_ceiling { 6 } else { 5 }];
    let mut indices: Vec<u32> = sides.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    if fronts_inside {
        indices.reverse();
    }
    let indices = fixture.indices(&indices);
    fixture.primitive(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    fixture.json["nodes"][0]["scale"] = json!([4, 2.5, 6]);
    fixture.json["nodes"][0]["translation"] = json!([10, 1.25, 0]);
    fixture
}

/// The only camera, which must be the automatic one.
fn automatic(scene: &Scene) -> &Camera {
    let [camera] = &*scene.cameras else { panic!("{:?}", scene.cameras) };
    assert_eq!(camera.name, "auto");
    assert!(scene.notices.contains(&"no camera was found: \"auto\" was made to see the scene".to_owned()));
    camera
}

fn is_inside(scene: &Scene, point: [f32; 3]) -> bool {
    let bounds = scene.bounds();
    (0..3).all(|axis| bounds.min[axis] < point[axis] && point[axis] < bounds.max[axis])
}

/// How far each corner of the box is from the view axis, as tangents of angles; all must be in a
/// picture at least as wide as high.
fn sees_all(scene: &Scene, camera: &Camera) -> bool {
    let bounds = scene.bounds();
    (0..8).all(|index| {
        let corner =
            [0, 1, 2].map(|axis| if index >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] });
        let to_corner = [0, 1, 2].map(|axis| corner[axis] - camera.eye[axis]);
        let along = |axis: [f32; 3]| axis.iter().zip(to_corner).map(|(a, b)| a * b).sum::<f32>();
        let limit = (camera.yfov_radians / 2.0).tan() * along(camera.forward);
        along(camera.forward) > 0.0 && along(camera.up).abs() < limit && along(camera.right).abs() < limit
    })
}

#[test]
fn rooms_are_seen_from_inside_and_lit_from_inside() {
    let scene = house(true, true).scene();
    let camera = automatic(&scene);
    assert!(is_inside(&scene, camera.eye), "{camera:?}");
    // Along the room, not into the nearest wall.
    assert!(camera.forward[2].abs() > 0.7, "{camera:?}");
    let [Light::Sphere { position, radius, intensity }, Light::Environment(_)] = &*scene.lights else {
        panic!("{:?}", scene.lights)
    };
    assert!(is_inside(&scene, *position) && position[1] > camera.eye[1]);
    assert!(*radius > 0.0 && position[1] + radius < 2.5 && intensity[0] > 0.0);
    let expected = "no light was found: a sky and a lamp in the room of the first camera were made";
    assert!(scene.notices.contains(&expected.to_owned()));
}

#[test]
fn solid_things_are_seen_from_outside() {
    let scene = house(false, true).scene();
    let camera = automatic(&scene);
    assert!(!is_inside(&scene, camera.eye) && sees_all(&scene, camera), "{camera:?}");
    assert!(matches!(&*scene.lights, [Light::Environment(_)]));
    assert!(scene.notices.contains(&"no light was found: a sky was made".to_owned()));
}

#[test]
fn yards_are_seen_from_inside_and_lit_by_the_sky() {
    let scene = house(true, false).scene();
    let camera = automatic(&scene);
    assert!(is_inside(&scene, camera.eye), "{camera:?}");
    assert!(matches!(&*scene.lights, [Light::Environment(_)]));
}

#[test]
fn a_roof_without_walls_lets_the_sky_in() {
    let mut fixture = house(true, true);
    // Ceiling and floor: the sides of such a house are listed backwards.
    let sides = [0..6, 18..24].map(|range| {
        let scene = house(true, true).scene();
        scene.triangles.as_flattened()[range].to_vec()
    });
    let indices = fixture.indices(&sides.concat());
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    fixture.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    fixture.node(json!({ "camera": 0, "translation": [10, 1.25, 0] }));
    let scene = fixture.scene();
    assert_eq!(scene.bounds().extent(), [4.0, 2.5, 6.0]);
    assert!(matches!(&*scene.lights, [Light::Environment(_)]), "{:?}", scene.lights);
}

#[test]
fn scenes_of_any_size_can_be_seen() {
    for scale in [1e-20, 1e-3, 1.0, 1e6, 1e30] {
        let mut fixture = Fixture::triangle();
        fixture.json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        let scene = fixture.scene();
        assert!(sees_all(&scene, automatic(&scene)), "scale {scale}");
    }
    // Rooms too small or too large for a lamp.
    for scale in [2e-23, 1e30] {
        let mut fixture = house(true, true);
        fixture.json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        fixture.json["nodes"][0]["translation"] = json!([0, 0, 0]);
        let scene = fixture.scene();
        assert!(is_inside(&scene, automatic(&scene).eye));
        assert!(matches!(&*scene.lights, [Light::Environment(_)]), "{:?}", scene.lights);
    }
    // Too large for any camera outside.
    let mut fixture = Fixture::triangle();
    fixture.json["nodes"][0]["scale"] = json!([3.4e38, 3.4e38, 3.4e38]);
    let message = fixture.load().unwrap_err();
    assert!(message.starts_with("scene.glb has no camera and none can be made"), "{message}");
}

#[test]
fn the_same_scene_gets_the_same_camera() {
    let first = house(true, true).scene();
    for _ in 0..5 {
        let again = house(true, true).scene();
        assert_eq!((again.cameras, again.lights), (first.cameras.clone(), first.lights.clone()));
    }
}

/// The room with one square of this emission on its floor.
fn with_emission(emission: f32, has_ceiling: bool) -> Fixture {
    let mut fixture = house(true, has_ceiling);
    fixture.push("materials", json!({ "emissiveFactor": [emission, emission, emission] }));
    let positions = fixture.vectors(&[[10.0, 0.1, 0.0], [10.0, 0.1, 1.0], [11.0, 0.1, 0.0]]);
    fixture.primitive(json!({ "attributes": { "POSITION": positions }, "material": 0 }));
    fixture
}

#[test]
fn what_glows_a_little_does_not_keep_the_sky_out() {
    let scene = with_emission(1.0, true).scene();
    assert!(matches!(&*scene.lights, [Light::Emissive { .. }]), "{:?}", scene.lights);
    let scene = with_emission(1e-3, true).scene();
    let expected =
        "what glows is too dim to see by: a sky and a lamp in the room of the first camera were made";
    assert!(scene.notices.contains(&expected.to_owned()), "{:?}", scene.notices);
    let [Light::Sphere { .. }, Light::Emissive { .. }, Light::Environment(_)] = &*scene.lights else {
        panic!("{:?}", scene.lights)
    };
    let scene = with_emission(1e-3, false).scene();
    assert!(matches!(&*scene.lights, [Light::Emissive { .. }, Light::Environment(_)]), "{:?}", scene.lights);
}

/// A room and what a sidecar would have to say, taken from its notice.
fn dark_room(light: serde_json::Value, has_ceiling: bool) -> (Scene, Option<String>) {
    let mut fixture = house(true, has_ceiling);
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    let down = [-std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];
    fixture.node(json!({ "extensions": light, "translation": [10, 1, 0], "rotation": down }));
    let scene = fixture.scene();
    let notice = scene.notices.iter().find(|notice| notice.contains("nearly black")).cloned();
    (scene, notice)
}

#[test]
fn a_picture_that_will_be_black_is_said_with_what_would_help() {
    assert_eq!(dark_room(json!({ "type": "point", "intensity": 10 }), true).1, None);
    assert_eq!(dark_room(json!({ "type": "directional", "intensity": 3 }), false).1, None);
    for (light, has_ceiling) in [
        (json!({ "type": "point", "intensity": 1e-3 }), true),
        (json!({ "type": "point", "intensity": 1e-3 }), false),
        // The sun does not get into a closed room.
        (json!({ "type": "directional", "intensity": 3 }), true),
    ] {
        let (scene, notice) = dark_room(light.clone(), has_ceiling);
        assert_eq!(scene.lights.len(), 1, "what was asked for stays");
        let notice = notice.unwrap_or_else(|| panic!("{light}: {:?}", scene.notices));
        let help = notice.split("; a").nth(1).unwrap().trim_start_matches('n').trim_start();
        let (table, rest) = help.split_once(" with ").unwrap();
        let lines =
            rest.split(" in ").next().unwrap().replace("], ", "]\n").replace(", intensity", "\nintensity");
        let sidecar = scenes::sidecar::parse(&format!("{table}\n{lines}\n")).unwrap();
        assert_eq!(sidecar.lights.len() + usize::from(sidecar.environment.is_some()), 1, "{notice}");
        assert_eq!(sidecar.environment.is_some(), !has_ceiling, "{notice}");
        assert!(notice.contains("scene.rayscope.toml"), "{notice}");
    }
}

#[test]
fn further_views_are_unlike_the_first_and_inside_a_room_or_outside_of_a_thing() {
    for is_room in [true, false] {
        let scene = house(is_room, true).scene();
        let names = scenes::views::names(4);
        assert_eq!(names, ["auto", "auto-2", "auto-3", "auto-4"]);
        let view = |name: &String| scenes::views::view(&scene, name).unwrap().unwrap();
        let views: Vec<Camera> = names.iter().map(view).collect();
        assert_eq!(&views[0], automatic(&scene));
        for (number, view) in views.iter().enumerate() {
            assert_eq!(view.name, names[number]);
            assert_eq!(is_inside(&scene, view.eye), is_room, "{view:?}");
            let pose = |camera: &Camera| (camera.eye, camera.forward);
            assert!(views[..number].iter().all(|before| pose(before) != pose(view)), "{views:?}");
        }
        assert!(scenes::views::view(&scene, "auto-1").is_none());
        assert!(scenes::views::view(&scene, "auto-17").is_none());
        assert!(scenes::views::view(&scene, "front").is_none());
    }
}

#[test]
fn a_thing_in_the_middle_of_a_plain_is_seen_from_near_by_all_views_but_the_first() {
    let scene = scenes::load("builtin:city?triangles=14000").unwrap();
    let view = |name: &str| scenes::views::view(&scene, name).unwrap().unwrap();
    let height = |camera: Camera| camera.eye[1];
    assert!(height(view("auto-2")) < 0.5 * height(view("auto")), "{:?} {:?}", view("auto"), view("auto-2"));
}
