//! Primitives: how their vertices and indices may be stored.

use serde_json::json;

use crate::fixture::{F32, Fixture, I8, I16, TRIANGLE, U8, U16, U32, corners, le_bytes};

const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// Four vertices of a triangle list (4), strip (5) or fan (6).
fn quad(mode: u32) -> Fixture {
    let mut fixture = Fixture::new();
    let positions = fixture.vectors(&QUAD);
    fixture.primitive(json!({ "attributes": { "POSITION": positions }, "mode": mode }));
    fixture
}

#[test]
fn indices_of_every_width_and_none() {
    for (component, width) in [(U8, 1), (U16, 2), (U32, 4)] {
        let mut fixture = quad(4);
        let bytes: Vec<u8> = [2_u32, 3, 1].iter().flat_map(|i| i.to_le_bytes()[..width].to_vec()).collect();
        let indices = fixture.accessor(&bytes, component, "SCALAR", 3);
        fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert_eq!(corners(&fixture.scene()), [[QUAD[2], QUAD[3], QUAD[1]]]);
    }
    let without = Fixture::triangle().scene();
    assert_eq!(without.triangles, [[0, 1, 2]]);
    assert_eq!(without.positions, TRIANGLE);
}

#[test]
fn wide_indices_keep_all_their_bytes() {
    let mut fixture = Fixture::new();
    let mut vertices = vec![[0.0; 3]; 70_000];
    vertices[69_999] = [5.0, 0.0, 0.0];
    vertices[300] = [0.0, 7.0, 0.0];
    let positions = fixture.vectors(&vertices);
    let indices = fixture.indices(&[69_999, 300, 0]);
    fixture.primitive(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    assert_eq!(corners(&fixture.scene()), [[[5.0, 0.0, 0.0], [0.0, 7.0, 0.0], [0.0; 3]]]);
}

#[test]
fn strips_keep_one_winding() {
    let scene = quad(5).scene();
    // The quad's corners in the order of a strip make a bow tie; what counts is the order.
    assert_eq!(scene.triangles, [[0, 1, 2], [1, 3, 2]]);
}

#[test]
fn fans_turn_around_their_first_vertex() {
    let scene = quad(6).scene();
    assert_eq!(scene.triangles, [[1, 2, 0], [2, 3, 0]]);
}

#[test]
fn short_strips_and_fans_are_empty() {
    for mode in [5, 6] {
        let mut fixture = Fixture::triangle();
        let positions = fixture.vectors(&QUAD[..2]);
        fixture.primitive(json!({ "attributes": { "POSITION": positions }, "mode": mode }));
        assert_eq!(fixture.scene().triangles.len(), 1);
    }
}

#[test]
fn points_and_lines_are_skipped_and_said_so() {
    let mut fixture = Fixture::triangle();
    for mode in 0..4 {
        fixture.primitive(json!({ "attributes": { "POSITION": 0 }, "mode": mode }));
    }
    let scene = fixture.scene();
    assert_eq!(scene.triangles.len(), 1);
    assert_eq!(scene.notices[0], "primitives of points or lines are skipped (4)");
}

#[test]
fn interleaved_attributes() {
    let mut fixture = Fixture::new();
    let mut bytes = Vec::new();
    for (place, position) in QUAD.iter().enumerate() {
        bytes.extend(le_bytes(position));
        bytes.extend(le_bytes(&[0.0, place as f32, 1.0]));
        bytes.extend([0xFF; 4]);
    }
    let view = fixture.view(&bytes);
    fixture.json["bufferViews"][view]["byteStride"] = json!(28);
    let mut attribute = |offset: usize| {
        let accessor = json!({ "bufferView": view, "byteOffset": offset, "componentType": F32,
                               "type": "VEC3", "count": 4 });
        fixture.push("accessors", accessor)
    };
    let (positions, normals) = (attribute(0), attribute(12));
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    fixture.primitive(json!({ "attributes": attributes, "mode": 6 }));
    let scene = fixture.scene();
    assert_eq!(scene.positions, QUAD);
    for (place, normal) in scene.normals.iter().enumerate() {
        assert!((normal[1] / normal[2] - place as f32).abs() < 1e-6);
    }
}

#[test]
fn the_last_interleaved_element_may_end_where_its_view_does() {
    let mut fixture = Fixture::new();
    let mut bytes = Vec::new();
    for position in TRIANGLE {
        bytes.extend(le_bytes(&[9.0]));
        bytes.extend(le_bytes(&position));
    }
    let view = fixture.view(&bytes);
    fixture.json["bufferViews"][view]["byteStride"] = json!(16);
    let accessor = json!({ "bufferView": view, "byteOffset": 4, "componentType": F32, "type": "VEC3",
                           "count": 3 });
    let positions = fixture.push("accessors", accessor);
    fixture.primitive(json!({ "attributes": { "POSITION": positions } }));
    assert_eq!(fixture.scene().positions, TRIANGLE);
}

/// Moves vertices 1 and 3 of the quad, or of zeros, by sparse values.
fn sparse(index_component: u32, index_width: usize, has_base: bool) -> Fixture {
    let mut fixture = quad(6);
    let indices: Vec<u8> = [1_u32, 3].iter().flat_map(|i| i.to_le_bytes()[..index_width].to_vec()).collect();
    let indices = fixture.view(&indices);
    let values = fixture.view(&le_bytes(&[4.0, 0.0, 0.0, 0.0, 4.0, 1.0]));
    fixture.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": index_component },
        "values": { "bufferView": values },
    });
    if !has_base {
        fixture.json["accessors"][0]["bufferView"] = json!(null);
    }
    fixture
}

#[test]
fn sparse_accessors() {
    for (component, width) in [(U8, 1), (U16, 2), (U32, 4)] {
        let scene = sparse(component, width, true).scene();
        assert_eq!(scene.positions, [QUAD[0], [4.0, 0.0, 0.0], QUAD[2], [0.0, 4.0, 1.0]]);
        let scene = sparse(component, width, false).scene();
        assert_eq!(scene.positions, [[0.0; 3], [4.0, 0.0, 0.0], [0.0; 3], [0.0, 4.0, 1.0]]);
    }
}

#[test]
fn quantised_positions_and_normals() {
    let mut fixture = Fixture::new();
    let words: [i16; 9] = [0, 0, 0, 32767, 0, 0, 0, -32768, 16384];
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let positions = fixture.accessor(&bytes, I16, "VEC3", 3);
    let normals: Vec<u8> = [[0_i8, 0, 127]; 3].as_flattened().iter().map(|&x| x as u8).collect();
    let normals = fixture.accessor(&normals, I8, "VEC3", 3);
    fixture.json["accessors"][normals]["normalized"] = json!(true);
    fixture.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    fixture.primitive(json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    let plain = fixture.scene();
    assert_eq!(plain.positions, [[0.0; 3], [32767.0, 0.0, 0.0], [0.0, -32768.0, 16384.0]]);
    assert_eq!(plain.normals, [[0.0, 0.0, 1.0]; 3]);
    fixture.json["accessors"][positions]["normalized"] = json!(true);
    assert_eq!(fixture.scene().positions[..2], [[0.0; 3], [1.0, 0.0, 0.0]]);
    assert_eq!(fixture.scene().positions[2], [0.0, -1.0, 16384.0 / 32767.0]);
}

#[test]
fn primitives_that_share_vertices_take_only_their_own() {
    let mut fixture = Fixture::new();
    let positions = fixture.vectors(&[QUAD, QUAD.map(|[x, y, _]| [x, y, 9.0])].concat());
    for indices in [[5, 7, 6], [2, 0, 1]] {
        let indices = fixture.indices(&indices);
        fixture.primitive(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    }
    let scene = fixture.scene();
    assert_eq!(scene.positions.len(), 6);
    let far = |vertex: usize| [QUAD[vertex][0], QUAD[vertex][1], 9.0];
    assert_eq!(corners(&scene), [[far(1), far(3), far(2)], [QUAD[2], QUAD[0], QUAD[1]]]);
}

#[test]
fn a_vertex_that_no_triangle_uses_may_be_anything() {
    let mut fixture = quad(4);
    fixture.binary[36..48].fill(0xFF);
    let indices = fixture.indices(&[0, 1, 2]);
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(fixture.scene().positions, QUAD[..3]);
}

#[test]
fn normals_of_some_primitives_leave_zeros_for_the_others() {
    let mut fixture = Fixture::triangle();
    assert!(fixture.scene().normals.is_empty());
    let normals = fixture.vectors(&[[0.0, 0.0, 2.0], [0.0; 3], [f32::NAN, 0.0, 1.0]]);
    fixture.primitive(json!({ "attributes": { "POSITION": 0, "NORMAL": normals } }));
    fixture.primitive(json!({ "attributes": { "POSITION": 0 } }));
    let scene = fixture.scene();
    let mut expected = [[0.0; 3]; 9];
    expected[3] = [0.0, 0.0, 1.0];
    assert_eq!(scene.normals, expected);
}

#[test]
fn degenerate_triangles_stay_and_are_counted() {
    let mut fixture = quad(4);
    let indices = fixture.indices(&[0, 0, 1, 0, 1, 2, 3, 3, 3]);
    fixture.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let scene = fixture.scene();
    assert_eq!(scene.triangles.len(), 3);
    assert_eq!(scene.notices[0], "degenerate triangles stay in the scene and are never hit (2)");
}
