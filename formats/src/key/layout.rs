//! A key's bits as data: which coordinate each of the 64 bits comes from.
//!
//! Text form, as in KEYS and on the command line: names separated by blanks, `(…)*n` repeats a
//! group n times, `(…)*` repeats it to the end. `light` stands for as many bits as the number of
//! lights needs. Each mention of a name takes that coordinate's next lower bit.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{COORDINATE_BITS, LAYOUT_BITS};
use crate::text::one_line;

/// Most characters of a text that a message shows.
const SHOWN: usize = 200;

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

            fn from_name(name: &str) -> Option<Self> {
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
}

impl Coordinate {
    /// Whether it needs a light, which only shadow rays have.
    pub fn needs_light(self) -> bool {
        matches!(self, Self::Light | Self::LightU | Self::LightV | Self::LightR)
    }

    /// Whether it needs an estimate of the ray's length.
    pub fn needs_length(self) -> bool {
        matches!(self, Self::EndX | Self::EndY | Self::EndZ)
    }
}

/// What is wrong with a layout's text, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct LayoutError {
    /// What was found and what was expected.
    pub message: String,
    /// The whole text.
    pub text: String,
    /// First character at fault, counted in characters.
    pub start: usize,
    /// How many characters are at fault, ≥ 1.
    pub length: usize,
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Of a text that fills the screen, the part at fault.
        let skipped = self.start.saturating_sub(SHOWN / 2);
        let blanks = " ".repeat(self.start - skipped);
        let marks = "^".repeat(self.length.min(SHOWN / 2));
        let shown = self.text.chars().skip(skipped).take(SHOWN);
        // As many places as characters, and nothing that a terminal obeys.
        let text: String = shown.map(|c| if c.is_control() { ' ' } else { c }).collect();
        write!(f, "{}\n  {text}\n  {blanks}{marks}", self.message)
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Item {
    Name(Coordinate, usize, usize),
    Group(Vec<Item>, Option<usize>),
}

/// A parsed layout text; becomes a [`Layout`] once the number of lights is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayoutText {
    text: String,
    items: Vec<Item>,
}

impl LayoutText {
    /// Parses a text such as `(ox oy oz)*4 (u v ex ey ez)*10`.
    ///
    /// # Errors
    /// Unknown words, unbalanced brackets, bad counts, no bit at all, a coordinate with more than
    /// 22 bits, more than 64 bits (without `light`, where the tail is cut), `light` more than once;
    /// each with its place.
    pub fn parse(text: &str) -> Result<Self, LayoutError> {
        let characters: Vec<char> = text.chars().collect();
        let mut parser = Parser { text, characters: &characters, at: 0 };
        let items = parser.items(0)?;
        let parsed = Self { text: text.to_owned(), items };
        // One light is the case with the fewest index bits, so it shows every other fault; two show
        // an index that is mentioned twice.
        parsed.expand(1)?;
        parsed.expand(2)?;
        Ok(parsed)
    }

    /// The text as it was typed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The layout for a scene with this many lights (at least 1).
    ///
    /// # Errors
    /// None beyond those that [`LayoutText::parse`] already reported, up to 2^22 lights.
    pub fn expand(&self, lights: usize) -> Result<Layout, LayoutError> {
        let mut bits = Vec::new();
        let light_bits = light_index_bits(lights);
        self.append(&self.items, light_bits, &mut bits)?;
        if bits.is_empty() {
            return Err(self.error(
                "a layout needs at least one coordinate",
                0,
                self.text.chars().count().max(1),
            ));
        }
        let cuts_tail = bits.iter().any(|(coordinate, ..)| *coordinate == Coordinate::Light);
        if bits.len() > LAYOUT_BITS as usize && !cuts_tail {
            let (_, start, length) = bits[LAYOUT_BITS as usize];
            return Err(self.error("this word makes the layout longer than 64 bits", start, length));
        }
        bits.truncate(LAYOUT_BITS as usize);
        let mut counts = std::collections::BTreeMap::new();
        for &(coordinate, start, length) in &bits {
            let count = counts.entry(coordinate).or_insert(0);
            *count += 1;
            if coordinate == Coordinate::Light && *count > light_bits {
                let message = "'light' is the whole index already, so it can be mentioned only once";
                return Err(self.error(message, start, length));
            }
            if *count > COORDINATE_BITS {
                let message = format!(
                    "'{}' is mentioned more than {COORDINATE_BITS} times, and a coordinate has no more bits than that",
                    coordinate.name()
                );
                return Err(self.error(&message, start, length));
            }
        }
        Ok(Layout { bits: bits.into_iter().map(|(coordinate, ..)| coordinate).collect(), light_bits })
    }

    fn append(
        &self,
        items: &[Item],
        light_bits: u32,
        bits: &mut Vec<(Coordinate, usize, usize)>,
    ) -> Result<(), LayoutError> {
        // One bit past the limit is enough to see that it was passed.
        let full = |bits: &Vec<_>| bits.len() > LAYOUT_BITS as usize;
        for item in items {
            match item {
                Item::Name(Coordinate::Light, start, length) => {
                    bits.extend((0..light_bits).map(|_| (Coordinate::Light, *start, *length)));
                }
                Item::Name(coordinate, start, length) => bits.push((*coordinate, *start, *length)),
                Item::Group(group, Some(times)) => {
                    for _ in 0..*times {
                        if full(bits) {
                            break;
                        }
                        self.append(group, light_bits, bits)?;
                    }
                }
                Item::Group(group, None) => {
                    let mut before = usize::MAX;
                    while bits.len() < LAYOUT_BITS as usize && bits.len() != before {
                        before = bits.len();
                        self.append(group, light_bits, bits)?;
                    }
                    bits.truncate(LAYOUT_BITS as usize);
                }
            }
        }
        Ok(())
    }

    fn error(&self, message: &str, start: usize, length: usize) -> LayoutError {
        LayoutError { message: message.to_owned(), text: self.text.clone(), start, length }
    }
}

/// ⌈log2 lights⌉, the bits that a light's index takes.
pub fn light_index_bits(lights: usize) -> u32 {
    usize::BITS - lights.max(1).saturating_sub(1).leading_zeros()
}

struct Parser<'a> {
    text: &'a str,
    characters: &'a [char],
    at: usize,
}

impl Parser<'_> {
    fn items(&mut self, depth: usize) -> Result<Vec<Item>, LayoutError> {
        let mut items = Vec::new();
        while let Some(&character) = self.characters.get(self.at) {
            match character {
                c if c.is_whitespace() => self.at += 1,
                '(' if depth >= 8 => {
                    return Err(self.error("brackets are nested more than 8 deep", self.at, 1));
                }
                '(' => items.push(self.group(depth)?),
                ')' if depth > 0 => return Ok(items),
                ')' => return Err(self.error("')' has no '(' before it", self.at, 1)),
                c if c.is_alphabetic() => items.push(self.name()?),
                c => {
                    let problem =
                        format!("found '{}', expected a coordinate's name or '('", c.escape_debug());
                    return Err(self.error(&problem, self.at, 1));
                }
            }
        }
        Ok(items)
    }

    fn group(&mut self, depth: usize) -> Result<Item, LayoutError> {
        let open = self.at;
        self.at += 1;
        let items = self.items(depth + 1)?;
        if self.characters.get(self.at) != Some(&')') {
            return Err(self.error("'(' has no ')' after it", open, 1));
        }
        self.at += 1;
        if items.is_empty() {
            return Err(self.error("the group is empty", open, self.at - open));
        }
        if !matches!(self.characters.get(self.at), Some('*' | '×')) {
            return Ok(Item::Group(items, Some(1)));
        }
        self.at += 1;
        let start = self.at;
        while self.characters.get(self.at).is_some_and(char::is_ascii_digit) {
            self.at += 1;
        }
        if start == self.at {
            return Ok(Item::Group(items, None));
        }
        let digits: String = self.characters[start..self.at].iter().collect();
        match digits.parse() {
            Ok(times @ 1..=64) => Ok(Item::Group(items, Some(times))),
            _ => Err(self.error("a group can be repeated 1 to 64 times", start, self.at - start)),
        }
    }

    fn name(&mut self) -> Result<Item, LayoutError> {
        let start = self.at;
        while self.characters.get(self.at).is_some_and(|c| c.is_alphanumeric()) {
            self.at += 1;
        }
        let name: String = self.characters[start..self.at].iter().collect();
        let length = self.at - start;
        let coordinate = Coordinate::from_name(&name).ok_or_else(|| {
            let known: Vec<_> = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).collect();
            let (name, known) = (one_line(&name, SHOWN), known.join(" "));
            self.error(&format!("unknown coordinate '{name}'; there are {known}"), start, length)
        })?;
        Ok(Item::Name(coordinate, start, length))
    }

    fn error(&self, message: &str, start: usize, length: usize) -> LayoutError {
        LayoutError { message: message.to_owned(), text: self.text.to_owned(), start, length }
    }
}

/// Which coordinate each bit of a key comes from, most significant bit first; 1 to 64 bits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    bits: Vec<Coordinate>,
    light_bits: u32,
}

/// One coordinate's share of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Which coordinate.
    pub coordinate: Coordinate,
    /// Width to which the coordinate is quantised: 22, or the light index's own width.
    pub width: u32,
    /// Positions in the k-bit key (0 = least significant) of the coordinate's bits, highest bit first.
    pub positions: Vec<u32>,
}

impl Layout {
    /// From coordinates as a manifest lists them; `None` if no layout has so many bits, in all or of one
    /// coordinate.
    pub fn from_bits(bits: Vec<Coordinate>) -> Option<Self> {
        let count = |wanted| bits.iter().filter(|&&coordinate| coordinate == wanted).count() as u32;
        let fits = bits.len() <= LAYOUT_BITS as usize
            && Coordinate::ALL.iter().all(|&coordinate| count(coordinate) <= COORDINATE_BITS);
        let light_bits = count(Coordinate::Light);
        fits.then_some(Self { bits, light_bits })
    }

    /// The coordinates, most significant bit first.
    pub fn bits(&self) -> &[Coordinate] {
        &self.bits
    }

    /// Whether any bit comes from a coordinate for which `predicate` holds.
    pub fn uses(&self, predicate: impl Fn(Coordinate) -> bool) -> bool {
        self.bits.iter().any(|&coordinate| predicate(coordinate))
    }

    /// The fields of the layout's k-bit prefix, in order of first mention. Bits past the end of a
    /// layout shorter than `key_bits` are 0.
    pub fn fields(&self, key_bits: u32) -> Vec<Field> {
        let mut fields: Vec<Field> = Vec::new();
        for (place, &coordinate) in self.bits.iter().take(key_bits as usize).enumerate() {
            let position = key_bits - 1 - place as u32;
            match fields.iter_mut().find(|field| field.coordinate == coordinate) {
                Some(field) => field.positions.push(position),
                None => fields.push(Field {
                    coordinate,
                    width: if coordinate == Coordinate::Light { self.light_bits } else { COORDINATE_BITS },
                    positions: vec![position],
                }),
            }
        }
        fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(text: &str, lights: usize) -> Vec<&'static str> {
        let layout = LayoutText::parse(text).unwrap().expand(lights).unwrap();
        layout.bits().iter().map(|coordinate| coordinate.name()).collect()
    }

    #[test]
    fn groups_repeat_and_fill() {
        assert_eq!(bits("(ox oy)*2 u", 1), ["ox", "oy", "ox", "oy", "u"]);
        assert_eq!(bits("(ox (oy u)*2)", 1), ["ox", "oy", "u", "oy", "u"]);
        assert_eq!(bits("(θ φ)×2 (ox oy oz)*", 1).len(), 64);
        assert_eq!(bits("(ox oy oz)*4 (u v ex ey ez)*10", 1).len(), 62);
    }

    #[test]
    fn light_takes_as_many_bits_as_the_lights_need() {
        for (lights, expected) in [(0, 0), (1, 0), (2, 1), (3, 2), (4, 2), (5, 3), (1024, 10), (1025, 11)] {
            assert_eq!(light_index_bits(lights), expected, "{lights} lights");
        }
        assert_eq!(bits("light (lu lv)*2", 3), ["light", "light", "lu", "lv", "lu", "lv"]);
    }

    #[test]
    fn errors_point_at_the_fault() {
        for (text, start, length, part) in [
            ("(ox oq)*4", 4, 2, "unknown coordinate 'oq'"),
            ("(ox oy", 0, 1, "no ')'"),
            ("ox) oy", 2, 1, "no '('"),
            ("(ox oy)*0", 8, 1, "1 to 64"),
            ("(ox oy)*99", 8, 2, "1 to 64"),
            ("ox + oy", 3, 1, "found '+'"),
            ("() ox", 0, 2, "empty"),
            ("(ox)*23", 1, 2, "more than 22"),
            ("(ox oy oz u)*16 v", 16, 1, "longer than 64"),
            ("", 0, 1, "at least one"),
            ("light ox light", 9, 5, "only once"),
            ("ox \u{1b}", 3, 1, "found '\\u{1b}'"),
        ] {
            let error = LayoutText::parse(text).unwrap_err();
            assert!(error.message.contains(part), "{text}: {error}");
            assert_eq!((error.start, error.length), (start, length), "{text}: {error}");
        }
    }

    #[test]
    fn nested_repeats_cannot_blow_up() {
        let text = "(((((ox oy oz)*64)*64)*64)*64)*64";
        assert!(LayoutText::parse(text).is_err());
    }

    #[test]
    fn fields_place_the_first_mention_highest() {
        let layout = LayoutText::parse("(ox oy)*4").unwrap().expand(1).unwrap();
        let fields = layout.fields(8);
        assert_eq!(fields[0].positions, [7, 5, 3, 1]);
        assert_eq!(fields[1].positions, [6, 4, 2, 0]);
        // A key wider than its layout keeps the layout at the top.
        assert_eq!(layout.fields(16)[0].positions, [15, 13, 11, 9]);
    }
}
