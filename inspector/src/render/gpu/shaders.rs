//! The modules of all pipelines, composed of the WGSL files.

use super::super::surfaces::FINEST_BITS;

const LAYER: &str = include_str!("layer.wgsl");

const POINTS: &str = include_str!("points.wgsl");

const LINE_ENDS: &str = include_str!("line_ends.wgsl");

/// Lines.
pub fn lines() -> String {
    [LAYER, POINTS, LINE_ENDS, include_str!("lines.wgsl")].concat()
}

/// Heads at the ends of lines.
pub fn arrows() -> String {
    [LAYER, POINTS, LINE_ENDS, include_str!("arrows.wgsl")].concat()
}

/// Marks at the ends of lines.
pub fn marks() -> String {
    [LAYER, POINTS, include_str!("marks.wgsl")].concat()
}

/// Boxes.
pub fn boxes() -> String {
    [LAYER, POINTS, include_str!("boxes.wgsl")].concat()
}

/// Surfaces.
pub fn mesh() -> String {
    let finest = format!("const FINEST_BITS = {FINEST_BITS}u;\n");
    [LAYER, &finest, include_str!("mesh.wgsl")].concat()
}

/// Capsules.
pub fn capsules() -> String {
    [LAYER, include_str!("capsules.wgsl")].concat()
}

/// From a picture to the window.
pub fn copy() -> String {
    include_str!("copy.wgsl").to_owned()
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use naga::TypeInner;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;
    use crate::render::frame::LayerUniform;

    #[test]
    fn every_module_is_valid() {
        for text in [lines(), arrows(), marks(), boxes(), mesh(), capsules(), copy()] {
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
            if let Err(error) = validator.validate(&module) {
                panic!("{}", error.emit_to_string(&text));
            }
            let entries = match &text {
                text if *text == copy() => 3,
                text if *text == lines() => 4,
                _ => 2,
            };
            assert_eq!(module.entry_points.len(), entries);
        }
    }

    #[test]
    fn the_uniform_lies_as_shaders_read_it() {
        let module = naga::front::wgsl::parse_str(&lines()).unwrap();
        let (_, layer) = module.types.iter().find(|(_, kind)| kind.name.as_deref() == Some("Layer")).unwrap();
        let TypeInner::Struct { members, span } = &layer.inner else { panic!("Layer is a struct") };
        let found: Vec<(&str, usize)> =
            members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset as usize)).collect();
        macro_rules! offsets { ($($field:ident),*) => { [$((stringify!($field), offset_of!(LayerUniform, $field))),*] } }
        let expected =
            offsets!(clip_from_unit, eye, plain, cut, viewport, width, opacity, low, high, map, points_each);
        assert_eq!(found, expected);
        assert_eq!(*span as usize, size_of::<LayerUniform>());
    }
}
