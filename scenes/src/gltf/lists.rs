//! From the text of the JSON to the lists that are read: what glTF allows and the parser does not is
//! levelled first, and what has no effect here is not checked (animations, morph targets).

use ::gltf::json::deserialize::{from_slice, from_value};
use ::gltf::json::{Root, Value};
use serde::de::DeserializeOwned;

use super::error::GltfError;
use super::notices::Notices;

/// The extension whose factors count where a material has no others.
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// Below this magnitude every whole f64 is the number that was written.
const MAX_EXACT: f64 = (1_u64 << 53) as f64;

/// The lists of the file.
pub(super) struct Lists {
    /// What the parser makes of them; animations, skins and cameras are left empty.
    pub(super) root: Root,
    /// Not yet parsed, since a camera that cannot be used is no reason to refuse the file.
    pub(super) cameras: Vec<Value>,
    /// Not yet parsed, since only those that a mesh of the scene has count.
    pub(super) skins: Vec<Value>,
}

/// Parses the JSON. An error says which item of which list is at fault.
pub(super) fn parse(json: &[u8], notices: &mut Notices) -> Result<Lists, GltfError> {
    let mut file: Value = from_slice(json).map_err(|error| GltfError::Json { problem: error.to_string() })?;
    level(&mut file);
    let animations = items(&mut file, "animations").count();
    notices.count("animations are ignored: nodes stay where the file puts them", animations);
    for scene in items(&mut file, "scenes") {
        set_default(scene, "nodes", Value::Array(Vec::new()));
    }
    for mesh in items(&mut file, "meshes") {
        forget(mesh, "weights");
        for primitive in items(mesh, "primitives") {
            // That there are targets counts, not what they are.
            for target in items(primitive, "targets") {
                *target = Value::Object(Default::default());
            }
        }
    }
    for node in items(&mut file, "nodes") {
        forget(node, "weights");
    }
    for material in items(&mut file, "materials") {
        if forget_specular_glossiness(material) {
            let sentence =
                "materials have specular-glossiness factors beside the metallic-roughness ones that count";
            notices.count(sentence, 1);
        }
    }
    let file = &mut file;
    let root = Root {
        accessors: list(file, "accessors")?,
        buffers: list(file, "buffers")?,
        buffer_views: list(file, "bufferViews")?,
        extensions: property(file, "extensions")?,
        extensions_used: list(file, "extensionsUsed")?,
        images: list(file, "images")?,
        materials: list(file, "materials")?,
        meshes: list(file, "meshes")?,
        nodes: list(file, "nodes")?,
        samplers: list(file, "samplers")?,
        scene: property(file, "scene")?,
        scenes: list(file, "scenes")?,
        textures: list(file, "textures")?,
        ..Root::default()
    };
    Ok(Lists { root, cameras: list(file, "cameras")?, skins: list(file, "skins")? })
}

/// Writes whole numbers as integers, as which JSON Schema takes `4.0` too, and removes `extras`, which may
/// be anything.
fn level(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => match number.as_f64() {
            Some(real) if real.fract() == 0.0 && real.abs() < MAX_EXACT && !is_minus_zero(real) => {
                *value = Value::from(real as i64);
            }
            _ => {}
        },
        Value::Array(items) => items.iter_mut().for_each(level),
        Value::Object(members) => {
            members.remove("extras");
            members.values_mut().for_each(level);
        }
        _ => {}
    }
}

/// Integers have no −0, and what is computed from it may differ.
fn is_minus_zero(real: f64) -> bool {
    real == 0.0 && real.is_sign_negative()
}

/// The items of a list inside an object; none if it is not there or no list.
fn items<'a>(object: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    object.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Removes the factors of specular and gloss where a material has metallic-roughness ones, which are written
/// for programs that shade as this one does. Returns whether there were any.
fn forget_specular_glossiness(material: &mut Value) -> bool {
    let own = material.get("pbrMetallicRoughness").and_then(Value::as_object);
    let has_own = own.is_some_and(|factors| !factors.is_empty());
    let extensions = material.get_mut("extensions").and_then(Value::as_object_mut);
    has_own && extensions.is_some_and(|extensions| extensions.remove(SPECULAR_GLOSSINESS).is_some())
}

fn set_default(object: &mut Value, key: &str, default: Value) {
    if let Some(members) = object.as_object_mut() {
        members.entry(key).or_insert(default);
    }
}

fn forget(object: &mut Value, key: &str) {
    if let Some(members) = object.as_object_mut() {
        members.remove(key);
    }
}

/// Takes a property out of the file; `None` if it is not there.
fn property<T: DeserializeOwned>(file: &mut Value, key: &str) -> Result<Option<T>, GltfError> {
    let Some(value) = file.get_mut(key).map(Value::take) else {
        return Ok(None);
    };
    from_value(value).map_err(|error| GltfError::Json { problem: format!("{key}: {error}") })
}

/// Takes a list out of the file; an empty one if it is not there.
fn list<T: DeserializeOwned>(file: &mut Value, key: &str) -> Result<Vec<T>, GltfError> {
    let items: Vec<Value> = property(file, key)?.unwrap_or_default();
    let parsed = items.into_iter().enumerate().map(|(index, item)| {
        from_value(item).map_err(|error| GltfError::Json { problem: format!("{key}[{index}]: {error}") })
    });
    parsed.collect()
}
