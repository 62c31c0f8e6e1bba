//! A key's bits as data: what each of the 64 bits comes from.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{COORDINATE_BITS, Tiles};

macro_rules! coordinates {
    ($($(#[doc = $doc:literal])* $variant:ident = $name:literal $(| $alias:literal)?,)*) => {
        /// A number in [0, 1] that key bits are taken from.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Coordinate { $($(#[doc = $doc])* $variant,)* }

        impl Coordinate {
            /// All coordinates, in the order in which docs list them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The word for it in layouts.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            pub(super) fn from_name(name: &str) -> Option<Self> {
                match name { $($name $(| $alias)? => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

coordinates! {
    /// Origin in unit space, x.
    OriginX = "ox",
    /// Origin, y.
    OriginY = "oy",
    /// Origin, z.
    OriginZ = "oz",
    /// Estimated termination point in unit space, x.
    EndX = "ex",
    /// Estimated termination point, y.
    EndY = "ey",
    /// Estimated termination point, z.
    EndZ = "ez",
    /// Direction, cartesian: (x + 1)/2.
    DirectionX = "dx",
    /// Direction, cartesian, y.
    DirectionY = "dy",
    /// Direction, cartesian, z.
    DirectionZ = "dz",
    /// Direction, octahedral, first coordinate.
    OctahedralU = "u",
    /// Direction, octahedral, second coordinate.
    OctahedralV = "v",
    /// Direction, paraboloid, first coordinate.
    ParaboloidU = "pu",
    /// Direction, paraboloid, second coordinate.
    ParaboloidV = "pv",
    /// Direction, spherical: azimuth.
    Azimuth = "theta" | "θ",
    /// Direction, spherical: polar angle.
    Polar = "phi" | "φ",
    /// Index of the light, ⌈log2 lights⌉ bits (shadow rays only).
    Light = "light",
    /// Octahedral direction from the light's centre to the origin, first coordinate (shadow rays only).
    LightU = "lu",
    /// Octahedral direction from the light's centre, second coordinate (shadow rays only).
    LightV = "lv",
    /// Distance from the light's centre over √3, in unit space (shadow rays only).
    LightR = "lr",
    /// Number of the tile of the picture in which the ray's path lies, ⌈log2 tiles⌉ bits.
    Tile = "tile",
}

impl Coordinate {
    /// Whether it needs a light, which only shadow rays have.
    pub fn needs_light(self) -> bool {
        matches!(self, Self::Light | Self::LightU | Self::LightV | Self::LightR)
    }

    /// Whether it needs the path that the ray is of, and a picture that the path belongs to.
    pub fn needs_path(self) -> bool {
        self == Self::Tile
    }

    /// Whether it needs more than the ray itself.
    pub fn needs_facts(self) -> bool {
        self.needs_length() || self.needs_light() || self.needs_path()
    }

    /// Whether it is a whole number, of as many bits as there are things to number.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Light | Self::Tile)
    }

    /// Whether it needs the ray's direction.
    pub fn needs_direction(self) -> bool {
        use Coordinate as C;
        !matches!(self, C::OriginX | C::OriginY | C::OriginZ | C::Light | C::Tile)
    }

    /// Whether it needs an estimate of the ray's length.
    pub fn needs_length(self) -> bool {
        matches!(self, Self::EndX | Self::EndY | Self::EndZ)
    }
}

/// Most coordinates that a Hilbert curve can go through.
pub const CURVE_AXES: usize = 6;

/// What bits are taken from, highest first: a coordinate, or the place along the Hilbert curve through several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Source {
    axes: [Coordinate; CURVE_AXES],
    count: usize,
}

impl Source {
    /// A coordinate itself.
    pub fn coordinate(coordinate: Coordinate) -> Self {
        Self { axes: [coordinate; CURVE_AXES], count: 1 }
    }

    /// The Hilbert curve through 2 to [`CURVE_AXES`] coordinates; `None` for fewer or more.
    pub fn curve(coordinates: &[Coordinate]) -> Option<Self> {
        let count = coordinates.len();
        let axes = || std::array::from_fn(|axis| coordinates[axis % count]);
        (2..=CURVE_AXES).contains(&count).then(|| Self { axes: axes(), count })
    }

    /// The coordinates, of which the curve's lowest bits change the last one first.
    pub fn axes(&self) -> &[Coordinate] {
        &self.axes[..self.count]
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [axis] = self.axes() {
            return f.write_str(axis.name());
        }
        for (at, axis) in self.axes().iter().enumerate() {
            write!(f, "{}{}", if at == 0 { "hilbert(" } else { " " }, axis.name())?;
        }
        f.write_str(")")
    }
}

/// A bit of a key: the next lower bit of its source, or the exclusive or of several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bit(pub(super) Vec<Source>);

impl Bit {
    /// What it comes from; several where a layout says `^`.
    pub fn sources(&self) -> &[Source] {
        &self.0
    }

    /// The coordinate that it is of, if it can be read back from the key.
    pub fn coordinate(&self) -> Option<Coordinate> {
        match self.sources() {
            [source] if source.count == 1 => Some(source.axes[0]),
            _ => None,
        }
    }
}

impl From<Coordinate> for Bit {
    fn from(coordinate: Coordinate) -> Self {
        Self(vec![Source::coordinate(coordinate)])
    }
}

impl fmt::Display for Bit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, source) in self.0.iter().enumerate() {
            write!(f, "{}{source}", if at == 0 { "" } else { " ^ " })?;
        }
        Ok(())
    }
}

/// What each bit of a key comes from, most significant bit first; 1 to 64 bits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pub(super) bits: Vec<Bit>,
    pub(super) numbers: NumberBits,
    pub(super) tiles: Option<Tiles>,
}

/// Bits of the coordinates that are whole numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct NumberBits {
    pub(super) light: u32,
    pub(super) tile: u32,
}

impl NumberBits {
    /// Bits of a coordinate.
    pub(super) fn of(self, coordinate: Coordinate) -> u32 {
        match coordinate {
            Coordinate::Light => self.light,
            Coordinate::Tile => self.tile,
            _ => COORDINATE_BITS,
        }
    }
}

/// The bits of a key that come from the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// What each of them is.
    pub bit: Bit,
    /// Their positions in the k-bit key (0 = least significant), highest bit first.
    pub positions: Vec<u32>,
}

/// One source's share of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Share {
    /// The source.
    pub source: Source,
    /// Bits of each coordinate that positions are counted in: 22, of a number its own, or of a curve as many
    /// as the key has levels of it.
    pub width: u32,
    /// For each axis of the source, positions in the k-bit key (0 = least significant) of its bits, highest bit
    /// first. Shares of one position are combined by exclusive or.
    pub positions: Vec<Vec<u32>>,
}

impl Layout {
    /// What each bit comes from, most significant bit first.
    pub fn bits(&self) -> &[Bit] {
        &self.bits
    }

    /// The same as manifests have it.
    pub fn names(&self) -> Vec<String> {
        self.bits.iter().map(Bit::to_string).collect()
    }

    /// How the picture is cut, where the layout numbers tiles.
    pub fn tiles(&self) -> Option<Tiles> {
        self.tiles
    }

    /// Whether any bit comes from a coordinate for which `predicate` holds.
    pub fn uses(&self, predicate: impl Fn(Coordinate) -> bool) -> bool {
        let sources = self.bits.iter().flat_map(Bit::sources);
        sources.flat_map(Source::axes).any(|&coordinate| predicate(coordinate))
    }

    /// The fields of the layout's k-bit prefix, in order of first mention. Bits past the end of a
    /// layout shorter than `key_bits` are 0.
    pub fn fields(&self, key_bits: u32) -> Vec<Field> {
        let mut fields: Vec<Field> = Vec::new();
        for (bit, position) in self.bits.iter().zip((0..key_bits).rev()) {
            match fields.iter_mut().find(|field| field.bit == *bit) {
                Some(field) => field.positions.push(position),
                None => fields.push(Field { bit: bit.clone(), positions: vec![position] }),
            }
        }
        fields
    }

    /// The shares of the sources in the layout's k-bit prefix, in order of first mention.
    pub fn shares(&self, key_bits: u32) -> Vec<Share> {
        let mut shares: Vec<(Source, Vec<u32>)> = Vec::new();
        for (bit, position) in self.bits.iter().zip((0..key_bits).rev()) {
            for &source in bit.sources() {
                match shares.iter_mut().find(|(known, _)| *known == source) {
                    Some((_, positions)) => positions.push(position),
                    None => shares.push((source, vec![position])),
                }
            }
        }
        let share = |(source, positions): (Source, Vec<u32>)| {
            let width = match source.axes() {
                [axis] => self.numbers.of(*axis),
                axes => positions.len().div_ceil(axes.len()) as u32,
            };
            Share { source, width, positions: by_axis(&positions, source.count) }
        };
        shares.into_iter().map(share).collect()
    }
}

/// The positions of a source's bits, for each of its axes.
pub(super) fn by_axis(positions: &[u32], axes: usize) -> Vec<Vec<u32>> {
    (0..axes).map(|axis| positions.iter().copied().skip(axis).step_by(axes).collect()).collect()
}

#[cfg(test)]
mod tests {
    use crate::key::{Extent, LayoutText};

    #[test]
    fn fields_place_the_first_mention_highest() {
        let layout = LayoutText::parse("(ox oy)*4").unwrap().expand(Extent::NOTHING).unwrap();
        let fields = layout.fields(8);
        assert_eq!(fields[0].positions, [7, 5, 3, 1]);
        assert_eq!(fields[1].positions, [6, 4, 2, 0]);
        // A key wider than its layout keeps the layout at the top.
        assert_eq!(layout.fields(16)[0].positions, [15, 13, 11, 9]);
    }

    #[test]
    fn shares_of_a_curve_and_of_both_sides_of_an_exclusive_or() {
        let layout = LayoutText::parse("hilbert(ox oy)*2 (u ^ ex)").unwrap().expand(Extent::NOTHING).unwrap();
        let fields: Vec<_> =
            layout.fields(5).iter().map(|field| (field.bit.to_string(), field.positions.clone())).collect();
        assert_eq!(fields, [("hilbert(ox oy)".to_owned(), vec![4, 3, 2, 1]), ("u ^ ex".to_owned(), vec![0])]);
        let shares = layout.shares(5);
        assert_eq!((shares[0].width, &shares[0].positions), (2, &vec![vec![4, 2], vec![3, 1]]));
        assert_eq!((&shares[1].positions, &shares[2].positions), (&vec![vec![0]], &vec![vec![0]]));
        // A level that the key ends in.
        assert_eq!((layout.shares(3)[0].width, &layout.shares(3)[0].positions[1]), (2, &vec![1]));
    }
}
