//! Files with random damage: loaded or refused, but never a panic and never a broken scene.

use serde_json::json;

use crate::fixture::{Fixture, check_invariants, load_bytes};

const SEED: u64 = 7;
const ROUNDS: usize = 1000;

/// A file with something of everything.
fn rich() -> Fixture {
    let mut fixture = Fixture::triangle();
    let normals = fixture.vectors(&[[0.0, 0.0, 1.0]; 3]);
    let uvs = fixture.vectors(&[[0.0, 0.0]; 3]);
    let indices = fixture.indices(&[0, 1, 2]);
    let attributes = json!({ "POSITION": 0, "NORMAL": normals, "TEXCOORD_0": uvs });
    let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0, "mode": 4 });
    fixture.json["meshes"][0]["primitives"] = json!([primitive, { "attributes": attributes, "mode": 5 }]);
    fixture.push("materials", json!({ "emissiveFactor": [1, 2, 3], "alphaMode": "MASK" }));
    fixture.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let extensions = json!({ "KHR_lights_punctual": { "light": 0 } });
    fixture.node(json!({ "mesh": 0, "camera": 0, "scale": [1, -2, 3], "extensions": extensions }));
    let sparse_indices = fixture.view(&[1, 0, 0, 0]);
    fixture.json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": sparse_indices, "componentType": 5121 },
        "values": { "bufferView": 0 },
    });
    fixture
}

#[test]
fn damaged_bytes_never_panic() {
    let whole = rich().glb();
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut loaded = 0;
    for round in 0..ROUNDS {
        let mut bytes = whole.clone();
        for _ in 0..=random.usize(..4) {
            let place = random.usize(..bytes.len());
            bytes[place] = match random.usize(..4) {
                // A digit where numbers are, so that the JSON often survives.
                0..=2 if bytes[place].is_ascii_digit() => random.u8(b'0'..=b'9'),
                0 => b'9',
                1 => 0xFF,
                _ => random.u8(..),
            };
        }
        // A panic shows which round it was.
        let round = Round(round);
        if let Ok(scene) = load_bytes("scene.glb", &bytes) {
            check_invariants(&scene);
            loaded += 1;
        }
        drop(round);
    }
    // Both ways must have been gone often for this to mean anything.
    assert!(loaded > ROUNDS / 20 && loaded < ROUNDS * 19 / 20, "{loaded} of {ROUNDS} loaded");
}

/// Says its number if it is dropped by a panic.
struct Round(usize);

impl Drop for Round {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("in round {} of seed {SEED}", self.0);
        }
    }
}
