//! The modules of all pipelines, composed of the WGSL files.

use super::super::surfaces::FINEST_BITS;

const LAYER: &str = include_str!("layer.wgsl");
const POINTS: &str = include_str!("points.wgsl");
const LINE_ENDS: &str = include_str!("line_ends.wgsl");

/// A module, which pipelines may share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Module {
    /// Lines, and edges of surfaces.
    Lines,
    /// Heads at the ends of lines.
    Arrows,
    /// Marks at the ends of lines.
    Marks,
    /// Boxes.
    Boxes,
    /// Surfaces.
    Mesh,
    /// Capsules.
    Capsules,
    /// From a picture to the window.
    Copy,
}

impl Module {
    /// All of it as WGSL.
    pub fn text(self) -> String {
        match self {
            Self::Lines => [LAYER, POINTS, LINE_ENDS, include_str!("lines.wgsl")].concat(),
            Self::Arrows => [LAYER, POINTS, LINE_ENDS, include_str!("arrows.wgsl")].concat(),
            Self::Marks => [LAYER, POINTS, include_str!("marks.wgsl")].concat(),
            Self::Boxes => [LAYER, POINTS, include_str!("boxes.wgsl")].concat(),
            Self::Mesh => {
                let finest = format!("const FINEST_BITS = {FINEST_BITS}u;\n");
                [LAYER, &finest, include_str!("mesh.wgsl")].concat()
            }
            Self::Capsules => [LAYER, include_str!("capsules.wgsl")].concat(),
            Self::Copy => include_str!("copy.wgsl").to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use naga::TypeInner;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;
    use crate::render::picture::LayerUniform;

    #[test]
    fn every_module_is_valid() {
        use Module::{Arrows, Boxes, Capsules, Copy, Lines, Marks, Mesh};
        for (module, entries) in
            [(Lines, 4), (Arrows, 2), (Marks, 2), (Boxes, 2), (Mesh, 2), (Capsules, 2), (Copy, 3)]
        {
            let text = module.text();
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
            if let Err(error) = validator.validate(&module) {
                panic!("{}", error.emit_to_string(&text));
            }
            assert_eq!(module.entry_points.len(), entries);
        }
    }

    #[test]
    fn the_uniform_lies_as_shaders_read_it() {
        let module = naga::front::wgsl::parse_str(&Module::Lines.text()).unwrap();
        let (_, layer) = module.types.iter().find(|(_, kind)| kind.name.as_deref() == Some("Layer")).unwrap();
        let TypeInner::Struct { members, span } = &layer.inner else { panic!("Layer is a struct") };
        let found: Vec<(&str, usize)> =
            members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset as usize)).collect();
        macro_rules! offsets { ($($field:ident),*) => { [$((stringify!($field), offset_of!(LayerUniform, $field))),*] } }
        let expected = offsets!(
            clip_from_unit,
            eye,
            plain,
            cut,
            room,
            faded,
            viewport,
            width,
            opacity,
            low,
            high,
            map,
            points_each
        );
        assert_eq!(found, expected);
        assert_eq!(*span as usize, size_of::<LayerUniform>());
    }
}
