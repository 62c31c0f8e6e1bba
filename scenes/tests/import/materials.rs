//! Materials and textures.

use std::fs;
use std::io::Cursor;

use base64::Engine;
use image::{DynamicImage, ImageFormat, Rgb, RgbImage, Rgba, RgbaImage};
use scenes::features::Features;
use scenes::{Light, Material, Scene};
use serde_json::{Value, json};

use crate::fixture::{Fixture, load_in};

/// Two texels side by side.
const TEXELS: [[u8; 4]; 2] = [[255, 0, 10, 128], [0, 200, 30, 7]];

fn png() -> Vec<u8> {
    encoded(RgbaImage::from_fn(2, 1, |x, _| Rgba(TEXELS[x as usize])), ImageFormat::Png)
}

/// The file of an image.
pub(crate) fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).expect("images can be written");
    bytes.into_inner()
}

/// A triangle with texture coordinates and this material.
fn with_material(material: Value) -> Fixture {
    let mut fixture = Fixture::triangle();
    let uvs = fixture.vectors(&[[0.0, 0.0], [1.0, 0.0], [0.5, f32::NAN]]);
    let other_uvs = fixture.vectors(&[[0.25, 0.75]; 3]);
    fixture.push("materials", material);
    let primitive = &mut fixture.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["attributes"]["TEXCOORD_1"] = json!(other_uvs);
    fixture
}

/// The same with a base-colour texture of this image.
fn with_image(image: Value) -> Fixture {
    let base_color = json!({ "baseColorTexture": { "index": 0 } });
    let mut fixture = with_material(json!({ "pbrMetallicRoughness": base_color }));
    fixture.push("textures", json!({ "source": 0 }));
    fixture.push("images", image);
    fixture
}

/// The same with the bytes of an image in the file.
fn with_bytes(image: &[u8]) -> Fixture {
    let mut fixture = with_image(json!({}));
    let view = fixture.view(image);
    fixture.json["images"][0]["bufferView"] = json!(view);
    fixture
}

#[test]
fn factors() {
    let emissive = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 8 } });
    let scene = with_material(json!({
        "name": "lamp",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.25, 0.5, 7, 0.75], "metallicFactor": 0.125, "roughnessFactor": 0.5,
        },
        "emissiveFactor": [1, 0.5, 0],
        "extensions": emissive,
    }))
    .scene();
    let expected = Material {
        name: "lamp".into(),
        base_color: [0.25, 0.5, 1.0],
        base_color_texture: None,
        metallic: 0.125,
        roughness: 0.5,
        emission: [8.0, 4.0, 0.0],
        alpha_cutoff: None,
        alpha: 0.75,
    };
    assert_eq!(scene.materials, [expected]);
    assert_eq!(scene.lights, [Light::Emissive { first_triangle: 0, triangle_count: 1 }]);
}

#[test]
fn factors_that_the_file_leaves_out_are_those_of_gltf() {
    let scene = with_material(json!({})).scene();
    let expected = Material { base_color: [1.0; 3], metallic: 1.0, ..Material::default() };
    assert_eq!(scene.materials, [expected]);
}

#[test]
fn primitives_without_a_material_are_grey() {
    let mut fixture = with_material(json!({ "name": "first" }));
    fixture.primitive(json!({ "attributes": { "POSITION": 0 } }));
    let scene = fixture.scene();
    assert_eq!(scene.triangle_materials, [0, 1]);
    assert_eq!(scene.materials[1], Material::default());
}

#[test]
fn alpha_modes() {
    let mode = |mode: &str| with_material(json!({ "alphaMode": mode, "alphaCutoff": 0.25 })).scene();
    let cutoff = |scene: &Scene| scene.materials[0].alpha_cutoff;
    assert_eq!(cutoff(&mode("OPAQUE")), None);
    assert_eq!(cutoff(&mode("MASK")), Some(0.25));
    assert!(Features::of(&mode("MASK")).alpha_masks);
    let blended = mode("BLEND");
    assert_eq!(cutoff(&blended), None);
    assert_eq!(blended.notices[0], "materials with alpha blending are treated as opaque (1)");
    assert_eq!(cutoff(&with_material(json!({ "alphaMode": "MASK" })).scene()), Some(0.5));
    let message = with_material(json!({ "alphaMode": "GLASS" })).load().unwrap_err();
    assert!(message.contains("material 0 has an alpha mode"), "{message}");
}

#[test]
fn emissive_primitives_are_lights_in_order_one_per_instance() {
    let mut fixture = with_material(json!({ "emissiveFactor": [1, 1, 1] }));
    let dark = fixture.push("materials", json!({}));
    // One mesh with a lit, a dark and a lit primitive, twice.
    let lit = json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    let dark = json!({ "attributes": { "POSITION": 0 }, "material": dark });
    let mesh = fixture.push("meshes", json!({ "primitives": [lit, dark, lit] }));
    fixture.node(json!({ "mesh": mesh }));
    fixture.node(json!({ "mesh": mesh }));
    let light = |first_triangle| Light::Emissive { first_triangle, triangle_count: 1 };
    assert_eq!(fixture.scene().lights, [0, 1, 3, 4, 6].map(light));
}

#[test]
fn textures_from_views_uris_and_files() {
    let check = |scene: &Scene| {
        assert_eq!(scene.textures.len(), 1);
        let texture = &scene.textures[0];
        assert_eq!((texture.width, texture.height), (2, 1));
        assert_eq!(texture.rgba, TEXELS);
        assert_eq!(scene.materials[0].base_color_texture, Some(0));
        // Texels cannot be looked up at NaN.
        assert_eq!(scene.uvs, [[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]);
        assert!(Features::of(scene).textures);
    };

    let mut fixture = with_bytes(&png());
    fixture.json["images"][0]["mimeType"] = json!("image/jpeg");
    check(&fixture.scene());

    let encoded = base64::engine::general_purpose::STANDARD.encode(png());
    check(&with_image(json!({ "uri": format!("data:image/png;base64,{encoded}") })).scene());

    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("two words")).unwrap();
    fs::write(folder.path().join("two words/ü.png"), png()).unwrap();
    let fixture = with_image(json!({ "uri": "two%20words/ü.png" }));
    fs::write(folder.path().join("scene.glb"), fixture.glb()).unwrap();
    check(&load_in(folder.path(), "scene.glb").unwrap());
}

#[test]
fn jpeg_textures() {
    let jpeg = encoded(RgbImage::from_pixel(8, 8, Rgb([200, 100, 50])), ImageFormat::Jpeg);
    for [red, green, blue, alpha] in &with_bytes(&jpeg).scene().textures[0].rgba {
        assert!(red.abs_diff(200) < 4 && green.abs_diff(100) < 4 && blue.abs_diff(50) < 4);
        assert_eq!(*alpha, 255);
    }
}

#[test]
fn a_texture_says_which_coordinates_it_wants() {
    let mut fixture = with_bytes(&png());
    fixture.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(1);
    assert_eq!(fixture.scene().uvs, [[0.25, 0.75]; 3]);
    fixture.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(2);
    let scene = fixture.scene();
    assert_eq!(scene.uvs, [[0.0, 0.0]; 3]);
    assert_eq!(scene.notices[0], "textured primitives without texture coordinates show one texel (1)");
}

#[test]
fn an_image_is_kept_once_and_only_if_a_triangle_shows_it() {
    let mut fixture = with_bytes(&png());
    fixture.push("textures", json!({ "source": 0 }));
    let same_image = json!({ "baseColorTexture": { "index": 1 } });
    fixture.push("materials", json!({ "pbrMetallicRoughness": same_image }));
    fixture.primitive(json!({ "attributes": { "POSITION": 0 }, "material": 1 }));
    // No triangle has this one, so nobody misses its image.
    fixture.push("images", json!({ "uri": "missing.png" }));
    fixture.push("textures", json!({ "source": 1 }));
    for texture in [2, 99] {
        let unused = json!({ "baseColorTexture": { "index": texture } });
        fixture.push("materials", json!({ "pbrMetallicRoughness": unused }));
    }
    let scene = fixture.scene();
    assert_eq!(scene.textures.len(), 1);
    let textures: Vec<Option<u32>> = scene.materials.iter().map(|m| m.base_color_texture).collect();
    assert_eq!(textures, [Some(0), Some(0), None, None]);
    // A primitive without coordinates beside one that has them.
    assert_eq!(scene.uvs[3..], [[0.0, 0.0]; 3]);
}

#[test]
fn other_textures_count_by_their_mean() {
    let mut fixture = with_bytes(&png());
    let texture = json!({ "index": 0 });
    fixture.json["materials"][0] = json!({
        "pbrMetallicRoughness": { "metallicRoughnessTexture": texture, "roughnessFactor": 0.5 },
        "emissiveTexture": texture,
        "emissiveFactor": [2, 2, 2],
        "normalTexture": texture,
    });
    let scene = fixture.scene();
    assert!(scene.textures.is_empty() && scene.uvs.is_empty());
    let material = &scene.materials[0];
    let is_close = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    is_close(material.roughness, 0.5 * 100.0 / 255.0);
    is_close(material.metallic, 20.0 / 255.0);
    // sRGB 255 stands for 1; 200 for 0.57758; 10 and 30 for 0.00304 and 0.01298.
    for (found, expected) in material.emission.into_iter().zip([1.0, 0.577_58, 0.016_02]) {
        is_close(found, expected);
    }
    let expected = [
        "normal maps are ignored (1)",
        "metallic-roughness textures are replaced by their means (1)",
        "emissive textures are replaced by their means (1)",
    ];
    assert_eq!(scene.notices[..3], expected);
}

#[test]
fn specular_glossiness_gives_diffuse_colour_and_roughness() {
    let of = |extension: Value, both: Value| {
        let mut material = json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": extension } });
        if !both.is_null() {
            material["pbrMetallicRoughness"] = both;
        }
        let mut fixture = with_material(material);
        let view = fixture.view(&png());
        fixture.push("images", json!({ "bufferView": view }));
        fixture.push("textures", json!({ "source": 0 }));
        fixture.json["extensionsRequired"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
        fixture.scene()
    };
    let scene = of(json!({ "diffuseFactor": [0.1, 0.2, 0.8, 0.5], "glossinessFactor": 0.25 }), json!(null));
    let expected =
        Material { base_color: [0.1, 0.2, 0.8], roughness: 0.75, alpha: 0.5, ..Material::default() };
    assert_eq!(scene.materials, [expected]);
    let expected =
        "specular-glossiness materials have their diffuse colour and gloss, but no specular colour (1)";
    assert_eq!(scene.notices[0], expected);

    let texture = json!({ "index": 0 });
    let textured = json!({ "diffuseTexture": texture, "specularGlossinessTexture": texture });
    let scene = of(textured, json!(null));
    let material = &scene.materials[0];
    assert_eq!((material.base_color, material.base_color_texture), ([1.0; 3], Some(0)));
    assert_eq!((scene.textures[0].rgba.as_slice(), scene.uvs[1]), (TEXELS.as_slice(), [1.0, 0.0]));
    // The mean alpha is that of 128 and 7.
    assert!((material.roughness - (1.0 - 67.5 / 255.0)).abs() < 1e-6, "{material:?}");
    assert_eq!(scene.notices[1], "specular-glossiness textures are replaced by their mean gloss (1)");

    // Factors that are there for those who know no other ones are nearer to what is shaded here.
    let scene = of(json!({ "diffuseFactor": [1, 0, 0, 1] }), json!({ "metallicFactor": 0.5 }));
    let expected = Material { base_color: [1.0; 3], metallic: 0.5, ..Material::default() };
    assert_eq!(scene.materials, [expected]);
    let expected =
        "materials have specular-glossiness factors beside the metallic-roughness ones that count (1)";
    assert_eq!(scene.notices[0], expected);
}

#[test]
fn images_that_cannot_be_had_are_refused() {
    let message = with_image(json!({ "uri": "missing.png" })).load().unwrap_err();
    assert!(message.contains("image 0 cannot be read: cannot read missing.png: No such file"), "{message}");
    let message = with_image(json!({ "uri": "https://example.org/a.png" })).load().unwrap_err();
    assert!(message.contains("the scheme \"https\""), "{message}");
    let message = with_image(json!({})).load().unwrap_err();
    assert!(message.contains("image 0 has neither a URI nor a buffer view"), "{message}");
    let message = with_image(json!({ "uri": "data:image/png;base64,AAAA" })).load().unwrap_err();
    assert!(message.contains("image 0 cannot be decoded as PNG or JPEG"), "{message}");
    let message = with_image(json!({ "uri": "data:image/png;base64,A?" })).load().unwrap_err();
    assert!(message.contains("invalid base64"), "{message}");
    let mut fixture = with_image(json!({}));
    fixture.json["textures"][0]["source"] = json!(7);
    let message = fixture.load().unwrap_err();
    assert!(message.contains("refers to image 7, which does not exist"), "{message}");
}
