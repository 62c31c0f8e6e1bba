//! Methods: a layout of key bits and, where it needs one, an estimate of the ray's length. Those of Meister et al. (2020)
//! are built in, docs/keys.md says where each layout is from.
//!
//! Adding a method is adding a row to [`BUILTIN`]; users add theirs with [`Method::from_user`].

use serde::{Deserialize, Serialize};

use super::{Coordinate, Layout, LayoutError, LayoutText};
use crate::ray::Kind;
use crate::text::{did_you_mean, one_line};

/// Most characters of what was asked for that a message shows.
const SHOWN: usize = 200;

/// Where a method's estimate of a ray's length comes from; in manifests the number of the variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Termination {
    /// The layout has no termination point.
    Unused,
    /// One length for all rays (`--two-point-length`, a quarter of the largest extent by default).
    Fixed,
    /// The mean of the ray's cell in the length table.
    Adaptive,
    /// The traced length: an upper bound, since the ray must be traced first.
    Real,
}

impl Termination {
    pub(crate) const ALL: [Self; 4] = [Self::Unused, Self::Fixed, Self::Adaptive, Self::Real];

    /// The word for it at the end of a layout, after `@`; none for what no layout says.
    pub fn word(self) -> Option<&'static str> {
        match self {
            Self::Unused => None,
            Self::Fixed => Some("fixed"),
            Self::Adaptive => Some("adaptive"),
            Self::Real => Some("real"),
        }
    }

    /// Whether this is a source of lengths exactly where the layout has a termination point.
    pub fn fits(self, layout: &Layout) -> bool {
        (self != Self::Unused) == layout.uses(Coordinate::needs_length)
    }
}

/// A way to make a key from a ray.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Method {
    /// Name on the command line, in paths and in figures.
    pub name: String,
    /// The key's bits.
    pub layout: LayoutText,
    /// Source of the length estimate.
    pub termination: Termination,
}

/// Whether a name can be a method's: small letters, digits and dashes, as the command line takes them.
pub fn is_method_name(name: &str) -> bool {
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    !name.is_empty() && name.len() <= 100 && !name.starts_with('-') && name.bytes().all(plain)
}

/// The baseline: canonical order, no key, no permutation.
pub const UNSORTED: &str = "unsorted";

/// Canonical order again, but gathered, traced and scattered as any method is: what it misses 1 by is the
/// instrument's error. It is measured wherever a method is, and has times alone; if it is asked for by name, it is
/// listed like a method and has a permutation, which leaves every ray in its place.
pub const CONTROL: &str = "control";

/// A random order, drawn from the seed: what canonical order already has over none at all. It has a permutation
/// and no key.
pub const SHUFFLED: &str = "shuffled";

/// The order that [`crate::auto`] chooses, queue by queue. It has a permutation; its keys are those of the method
/// that was chosen.
pub const AUTO: &str = "auto";

/// The orders that have no layout of their own, and so no record of a method.
pub const WITHOUT_LAYOUT: [&str; 4] = [UNSORTED, CONTROL, SHUFFLED, AUTO];

/// Orders that say what others are worth, and that nobody would choose: canonical order, itself once more, a random one.
pub const REFERENCES: [&str; 3] = [UNSORTED, CONTROL, SHUFFLED];

const TWO_POINT: &str = "(ox oy oz ex ey ez)*10 ox oy oz ex";

/// How many methods of [`BUILTIN`], the first ones, `all` stands for: the paper's and our own. The rows of others
/// are asked for by name.
pub const IN_ALL: usize = 10;

/// Name, layout and length estimate of every built-in method.
pub const BUILTIN: &[(&str, &str, Termination)] = &[
    ("origin", "(ox oy oz)*21 ox", Termination::Unused),
    ("reis", "(ox oy oz)*7 ox (theta phi)*21", Termination::Unused),
    ("costa", "(theta phi)*4 (ox oy oz)*15 (theta phi)*5 theta", Termination::Unused),
    ("aila", "(ox oy oz)*3 (ox oy oz dx dy dz)*9 ox", Termination::Unused),
    ("octahedron", "(ox oy oz)*4 (ox oy oz u v)*10 ox oy", Termination::Unused),
    ("two-point", TWO_POINT, Termination::Fixed),
    ("two-point-adaptive", TWO_POINT, Termination::Adaptive),
    ("two-point-real", TWO_POINT, Termination::Real),
    ("light-octahedron", "light (lu lv)*8 (lu lv lr)*14 (ox oy oz)*", Termination::Unused),
    ("origin-light", "(ox oy oz)*3 light (ox oy oz)*", Termination::Unused),
    // Of the paper's first author, whose code has them beside those above.
    ("paraboloid", "(ox oy oz)*4 (ox oy oz pu pv)*10 ox oy", Termination::Unused),
    ("hilbert-origin", "hilbert(ox oy oz)*", Termination::Unused),
    ("hilbert-two-point", "hilbert(ox oy oz ex ey ez)*", Termination::Fixed),
    // Of a ray coherence engine.
    ("two-point-xor", "(ox oy oz)* ^ (ex ey ez)*", Termination::Fixed),
    // Of a simulator's ray generator: 22 bits.
    ("grid-spherical", "(ox oy oz)*5 theta*4 phi*3", Termination::Unused),
    // Of a ray-traced ambient occlusion sample: canonical order is kept beyond the tile.
    ("tiled-octahedron", "tile(64x128) (u v)*4", Termination::Unused),
];

/// Why a method cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum MethodError {
    #[error("there is no method '{}' (your own are written 'name=layout'); {}", one_line(name, SHOWN), did_you_mean(name, &names()))]
    Unknown { name: String },
    #[error("'{name}' is an order that no layout makes; only methods with a layout can be asked for here")]
    WithoutLayout { name: String },
    #[error(
        "'{}' is not a method: write 'name=layout' with a name of small letters, digits and dashes that no built-in method has",
        one_line(definition, SHOWN)
    )]
    BadName { definition: String },
    #[error("method '{name}': {cause}")]
    Layout { name: String, cause: LayoutError },
}

/// Names of all orders that are ours.
fn names() -> Vec<&'static str> {
    WITHOUT_LAYOUT.into_iter().chain(BUILTIN.iter().map(|(name, ..)| *name)).collect()
}

impl Method {
    /// A built-in method by name (none of [`WITHOUT_LAYOUT`], which have no key).
    ///
    /// # Errors
    /// If there is no such method.
    pub fn builtin(name: &str) -> Result<Self, MethodError> {
        if WITHOUT_LAYOUT.contains(&name) {
            return Err(MethodError::WithoutLayout { name: name.to_owned() });
        }
        let unknown = || MethodError::Unknown { name: name.to_owned() };
        let &(name, layout, termination) =
            BUILTIN.iter().find(|(known, ..)| *known == name).ok_or_else(unknown)?;
        Self::new(name, layout, termination)
    }

    /// A user's method from `name=layout`. A layout with `ex ey ez` uses the fixed length unless it says another.
    ///
    /// # Errors
    /// If the name is missing, taken, longer than a file's may be or has other characters than `a-z 0-9 -`, or
    /// the layout is wrong.
    pub fn from_user(definition: &str) -> Result<Self, MethodError> {
        let bad_name = || MethodError::BadName { definition: definition.to_owned() };
        let (name, layout) = definition.split_once('=').ok_or_else(bad_name)?;
        let name = name.trim();
        let taken = WITHOUT_LAYOUT.contains(&name) || BUILTIN.iter().any(|(known, ..)| *known == name);
        if !is_method_name(name) || taken {
            return Err(bad_name());
        }
        let mut method = Self::new(name, layout, Termination::Unused)?;
        if method.layout.uses(Coordinate::needs_length) {
            method.termination = method.layout.length().unwrap_or(Termination::Fixed);
        }
        Ok(method)
    }

    fn new(name: &str, layout: &str, termination: Termination) -> Result<Self, MethodError> {
        let layout = LayoutText::parse(layout)
            .map_err(|cause| MethodError::Layout { name: name.to_owned(), cause })?;
        Ok(Self { name: name.to_owned(), layout, termination })
    }

    /// Whether the method makes sense for this kind of ray: what needs a light is for shadow rays.
    pub fn applies_to(&self, kind: Kind) -> bool {
        kind == Kind::Shadow || !self.layout.uses(Coordinate::needs_light)
    }

    /// Whether a length table can be addressed by this method: it must not need a length itself,
    /// nor a light, so that both kinds of ray have a cell, nor a path, since rays of one cell are alike.
    pub fn can_address_table(&self) -> bool {
        !self.layout.uses(Coordinate::needs_facts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{Extent, LAYOUT_BITS};

    #[test]
    fn every_builtin_layout_fills_its_bits() {
        for (name, ..) in BUILTIN {
            for lights in [1, 3, 1000, 100_000] {
                let extent = Extent { lights, picture: [1920, 1080] };
                let layout = Method::builtin(name).unwrap().layout.expand(extent).unwrap();
                let bits = match *name {
                    "grid-spherical" => 22,
                    "tiled-octahedron" => 9 + 8,
                    _ => LAYOUT_BITS as usize,
                };
                assert_eq!(layout.bits().len(), bits, "{name} with {lights} lights");
            }
        }
    }

    /// Bits of the origin in a key of 32.
    #[test]
    fn the_split_at_32_bits_is_the_documented_one() {
        for (name, origin_bits) in
            [("origin", 32), ("reis", 22), ("costa", 24), ("aila", 21), ("octahedron", 24), ("two-point", 17)]
        {
            let layout = Method::builtin(name).unwrap().layout.expand(Extent::NOTHING).unwrap();
            let is_origin = |name: &String| matches!(name.as_str(), "ox" | "oy" | "oz");
            let found = layout.names()[..32].iter().filter(|name| is_origin(name)).count();
            assert_eq!(found, origin_bits, "{name}");
        }
    }

    #[test]
    fn users_methods_are_named_and_checked() {
        let mine = Method::from_user("mine=(ox oy oz)*4 (u v ex ey ez)*10").unwrap();
        assert_eq!((mine.name.as_str(), mine.termination), ("mine", Termination::Fixed));
        let learnt = Method::from_user("mine=(ox oy oz)*6 (ex ey ez)*4 @adaptive").unwrap();
        assert_eq!(learnt.termination, Termination::Adaptive);
        for bad in ["mine", "=ox", "costa=ox", "unsorted=ox", "My=ox", "a b=ox", "../x=ox"] {
            assert!(matches!(Method::from_user(bad), Err(MethodError::BadName { .. })), "{bad}");
        }
        let error = Method::from_user("mine=(ox oq)*2").unwrap_err();
        assert!(error.to_string().contains("^^"), "{error}");
    }

    #[test]
    fn a_method_that_is_nearly_named_is_offered() {
        for (name, meant) in
            [("octahedrn", "octahedron"), ("unsortd", "unsorted"), ("hilbert-orgin", "hilbert-origin")]
        {
            let error = Method::builtin(name).unwrap_err().to_string();
            assert!(
                error.contains(&format!(
                    "'{name}' (your own are written 'name=layout'); did you mean '{meant}'?"
                )),
                "{error}"
            );
        }
        for name in WITHOUT_LAYOUT {
            let error = Method::builtin(name).unwrap_err().to_string();
            assert!(
                error.contains("only methods with a layout") && !error.contains("did you mean"),
                "{error}"
            );
        }
        let error = Method::builtin("zzz").unwrap_err().to_string();
        assert!(error.contains("; there are unsorted control"), "{error}");
    }

    #[test]
    fn lights_are_for_shadow_rays() {
        let method = Method::builtin("light-octahedron").unwrap();
        assert!(method.applies_to(Kind::Shadow) && !method.applies_to(Kind::Closest));
        assert!(!method.can_address_table());
        assert!(!Method::builtin("two-point").unwrap().can_address_table());
        assert!(!Method::builtin("tiled-octahedron").unwrap().can_address_table());
        assert!(Method::builtin("aila").unwrap().can_address_table());
    }
}
