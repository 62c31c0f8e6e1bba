//! Skinned meshes: placed by their joints, in the pose that the file's nodes have.

use serde_json::json;

use crate::fixture::{F32, Fixture, TRIANGLE, U8, U16, corners, le_bytes};

/// All of a joint's influence on a vertex.
const WHOLE: [f32; 4] = [1.0, 0.0, 0.0, 0.0];

/// A column-major matrix that scales by `scale` and moves by `translation`.
fn matrix(scale: f32, translation: [f32; 3]) -> [f32; 16] {
    let [x, y, z] = translation;
    [scale, 0.0, 0.0, 0.0, 0.0, scale, 0.0, 0.0, 0.0, 0.0, scale, 0.0, x, y, z, 1.0]
}

/// A triangle in node 0, which is far away, skinned with node 1, moved by (10, 0, 0), and its child node 2,
/// moved by (0, 5, 0); the vertices belong to joints 0, 1 and 0, which have no inverse bind matrices.
fn skinned() -> Fixture {
    let mut fixture = Fixture::triangle();
    let normals = fixture.vectors(&[[0.0, 0.0, 1.0]; 3]);
    let joints = fixture.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0], U8, "VEC4", 3);
    let weights = fixture.vectors(&[WHOLE; 3]);
    let attributes = json!({ "POSITION": 0, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    fixture.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    fixture.json["nodes"][0] = json!({ "mesh": 0, "skin": 0, "translation": [1000, 0, 0] });
    fixture.node(json!({ "translation": [10, 0, 0], "children": [2] }));
    fixture.push("nodes", json!({ "translation": [0, 5, 0], "name": "tip" }));
    fixture.push("skins", json!({ "joints": [1, 2] }));
    fixture
}

fn set_attribute(fixture: &mut Fixture, name: &str, accessor: usize) {
    fixture.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
}

#[test]
fn joints_place_vertices_and_the_node_of_the_mesh_does_not() {
    let mut fixture = skinned();
    assert_eq!(corners(&fixture.scene()), [[[10.0, 0.0, 0.0], [11.0, 5.0, 0.0], [10.0, 1.0, 0.0]]]);
    assert!(!fixture.scene().notices.iter().any(|notice| notice.contains("skin")));
    // The inverse bind matrices come first; there may be more of them than joints.
    let matrices = [matrix(2.0, [0.0; 3]), matrix(1.0, [-1.0, 0.0, 7.0]), matrix(f32::NAN, [0.0; 3])];
    let matrices = fixture.accessor(&le_bytes(matrices.as_flattened()), F32, "MAT4", 3);
    fixture.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    assert_eq!(corners(&fixture.scene()), [[[10.0, 0.0, 0.0], [10.0, 5.0, 7.0], [10.0, 2.0, 0.0]]]);
}

#[test]
fn joints_and_weights_of_every_type() {
    let mut fixture = skinned();
    let joints: Vec<u8> = [[0_u16, 1, 0, 0]; 3].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let joints = fixture.accessor(&joints, U16, "VEC4", 3);
    set_attribute(&mut fixture, "JOINTS_0", joints);
    // Weights of 1 : 4, which need not sum up to 1.
    let words: Vec<u8> =
        [[100_u16, 400, 0, 0]; 3].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let all = [
        fixture.vectors(&[[0.5, 2.0, 0.0, 0.0]; 3]),
        fixture.accessor([[51_u8, 204, 0, 0]; 3].as_flattened(), U8, "VEC4", 3),
        fixture.accessor(&words, U16, "VEC4", 3),
    ];
    for weights in all {
        fixture.json["accessors"][weights]["normalized"] = json!(weights != all[0]);
        set_attribute(&mut fixture, "WEIGHTS_0", weights);
        for (found, before) in fixture.scene().positions.iter().zip(TRIANGLE) {
            let expected = [before[0] + 10.0, before[1] + 4.0, before[2]];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}, {expected:?}");
        }
    }
    // Without any weight, the first joint has all.
    let zeros = fixture.vectors(&[[0.0; 4]; 3]);
    set_attribute(&mut fixture, "WEIGHTS_0", zeros);
    assert_eq!(fixture.scene().positions, TRIANGLE.map(|[x, y, z]| [x + 10.0, y, z]));
}

#[test]
fn joints_turn_normals_and_mirror_triangles() {
    let mut fixture = skinned();
    fixture.json["skins"][0]["joints"] = json!([1, 1]);
    fixture.json["nodes"][1] = json!({ "scale": [-1, 1, 1], "children": [2] });
    let scene = fixture.scene();
    assert_eq!(corners(&scene), [[[0.0; 3], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]]);
    assert_eq!(scene.normals, [[0.0, 0.0, 1.0]; 3]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    fixture.json["nodes"][1] = json!({ "rotation": [0, half, 0, half], "children": [2] });
    for [x, y, z] in fixture.scene().normals {
        assert!((x - 1.0).abs() < 1e-6 && y.abs() < 1e-6 && z.abs() < 1e-6, "{x} {y} {z}");
    }
}

#[test]
fn one_mesh_may_have_several_skins_and_none() {
    let mut fixture = skinned();
    fixture.push("skins", json!({ "joints": [2, 1] }));
    fixture.node(json!({ "mesh": 0, "skin": 1 }));
    fixture.node(json!({ "mesh": 0 }));
    let found = corners(&fixture.scene());
    assert_eq!(found[1], [[10.0, 5.0, 0.0], [11.0, 0.0, 0.0], [10.0, 6.0, 0.0]]);
    assert_eq!(found[2], TRIANGLE);
}

#[test]
fn more_than_four_joints_a_vertex_are_said() {
    let mut fixture = skinned();
    set_attribute(&mut fixture, "JOINTS_1", 2);
    set_attribute(&mut fixture, "WEIGHTS_1", 3);
    let expected = "skinned primitives have more than four joints a vertex, of which four count (1)";
    assert_eq!(fixture.scene().notices[0], expected);
}

#[test]
fn skins_that_cannot_be_are_refused() {
    let refusal = |change: &dyn Fn(&mut Fixture)| {
        let mut fixture = skinned();
        change(&mut fixture);
        fixture.load().unwrap_err().replace("cannot load scene.glb: ", "")
    };
    const PRIMITIVE: &str = "node 0, primitive 0 of mesh 0: ";
    for (skin, expected) in [
        (json!({ "joints": [1] }), "accessor 2 gives vertex 1 the joint 1, but its skin has 1"),
        (json!({ "joints": [1, 9] }), "skin 0 refers to node 9, which does not exist"),
        (json!({ "joints": [1, 3] }), "skin 0 has the joint node 3, expected a node of the scene"),
        (json!({ "joints": "all" }), "its JSON is not valid glTF: skins[0]: invalid type: string"),
        (
            json!({ "joints": [1, 2], "inverseBindMatrices": 4 }),
            "accessor 4 has 1 inverse bind matrices, expected one for each of 2 joints",
        ),
        (
            json!({ "joints": [1, 2], "inverseBindMatrices": 0 }),
            "accessor 0 has elements of type Vec3, expected Mat4",
        ),
    ] {
        let message = refusal(&|fixture| {
            let one = fixture.accessor(&le_bytes(&matrix(1.0, [0.0; 3])), F32, "MAT4", 1);
            assert_eq!(one, 4);
            fixture.push("nodes", json!({}));
            fixture.json["skins"][0] = skin.clone();
        });
        assert!(message.starts_with(&format!("{PRIMITIVE}{expected}")), "{message}");
    }
    let message = refusal(&|fixture| fixture.json["nodes"][0]["skin"] = json!(3));
    assert_eq!(message, format!("{PRIMITIVE}node 0 refers to skin 3, which does not exist"));
    let message = refusal(&|fixture| set_attribute(fixture, "JOINTS_0", 3));
    assert_eq!(message, format!("{PRIMITIVE}accessor 3 has F32 joints, expected U8 or U16"));
    let message = refusal(&|fixture| {
        let attributes = &mut fixture.json["meshes"][0]["primitives"][0]["attributes"];
        attributes.as_object_mut().unwrap().remove("WEIGHTS_0");
    });
    assert_eq!(message, format!("{PRIMITIVE}its WEIGHTS_0 has 0 values for 3 positions"));
    let message = refusal(&|fixture| {
        let short = fixture.vectors(&[WHOLE; 2]);
        set_attribute(fixture, "WEIGHTS_0", short);
    });
    assert_eq!(message, format!("{PRIMITIVE}its WEIGHTS_0 has 2 values for 3 positions"));
}
