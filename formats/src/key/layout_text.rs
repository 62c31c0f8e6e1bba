//! The words of layouts, as in FORMAT.md and on the command line.
//!
//! Names separated by blanks; `(…)*n` repeats a group n times, `name*n` a name, and `*` without a number repeats to
//! the end. Each mention of a name takes that coordinate's next lower bit; `light` stands for as many bits as the
//! number of lights needs, and `tile(64x128)` for those that number the tiles of the picture, each of 64 × 128 pixels,
//! row by row from the top left. `hilbert(ox oy oz)*n` takes n bits of each coordinate along the Hilbert curve through
//! them. `A ^ B` is the bitwise exclusive or of two names or groups of as many bits. `@fixed`, `@adaptive` or
//! `@real` at the end says where the length of the end point comes from.

use std::collections::BTreeMap;
use std::fmt;

use super::extent::index_bits;
use super::layout::{Bit, NumberBits, Source};
use super::layout_parser::{self, Item, Parsed, Span};
use super::{COORDINATE_BITS, Coordinate, Extent, LAYOUT_BITS, Layout, Termination, Tiles};

/// Most characters of a text that a message shows.
pub(super) const SHOWN: usize = 200;

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

/// A source where it is mentioned.
type Mention = (Source, Span);

/// A parsed layout text; becomes a [`Layout`] once it is known how much there is to number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayoutText {
    text: String,
    items: Vec<Item>,
    length: Option<Termination>,
    /// Width and height of a tile.
    tile: Option<([u32; 2], Span)>,
}

impl LayoutText {
    /// Parses a text such as `(ox oy oz)*4 (u v ex ey ez)*10`.
    ///
    /// # Errors
    /// Unknown words, unbalanced brackets, bad counts, no bit at all, a coordinate with more than
    /// 22 bits, more than 64 bits (without `light` and `tile`, where the tail is cut), one of these more than once; curves of
    /// other than 2 to 6 coordinates, sides of `^` with different numbers of bits, a coordinate of either that is
    /// mentioned elsewhere, a length that no end point needs; each with its place.
    pub fn parse(text: &str) -> Result<Self, LayoutError> {
        let Parsed { items, length, tile } = layout_parser::parse(text)?;
        let parsed = Self { text: text.to_owned(), items, length: length.map(|(source, _)| source), tile };
        // Without a bit for what is numbered every other fault shows; with one, a number that is mentioned twice.
        parsed.layout(NumberBits::default(), None)?;
        parsed.layout(NumberBits { light: 1, tile: 1 }, None)?;
        match length {
            Some((_, span)) if !parsed.uses(Coordinate::needs_length) => {
                Err(parsed.error("only ex, ey and ez need a length, and they are not mentioned", span))
            }
            _ => Ok(parsed),
        }
    }

    /// The text as it was typed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Where the length of the end point comes from, if the text says so.
    pub fn length(&self) -> Option<Termination> {
        self.length
    }

    /// Whether any bit comes from a coordinate for which `predicate` holds, if there is more than one of all that
    /// is numbered.
    pub fn uses(&self, predicate: impl Fn(Coordinate) -> bool) -> bool {
        self.layout(NumberBits { light: 1, tile: 1 }, None).is_ok_and(|layout| layout.uses(predicate))
    }

    /// The layout for as much as there is to number.
    ///
    /// # Errors
    /// Beyond those that [`LayoutText::parse`] already reported, `tile` where there is no picture, or one with more
    /// tiles than path indices.
    pub fn expand(&self, extent: Extent) -> Result<Layout, LayoutError> {
        let mut numbers = NumberBits { light: index_bits(extent.lights as u64), tile: 0 };
        let mut tiles = None;
        if let Some((tile, span)) = self.tile {
            let [width, height] = extent.picture;
            if !extent.has_picture() {
                let message = "'tile' needs a picture, and these rays have none: imported rays lie in one row without --size";
                return Err(self.error(message, span));
            }
            let found = Tiles { tile, width };
            numbers.tile = found.bits(height);
            if numbers.tile > u32::BITS {
                let message =
                    format!("a picture of {width} × {height} pixels has more tiles than path indices");
                return Err(self.error(&message, span));
            }
            tiles = Some(found);
        }
        self.layout(numbers, tiles)
    }

    fn layout(&self, numbers: NumberBits, tiles: Option<Tiles>) -> Result<Layout, LayoutError> {
        let mut bits = Vec::new();
        self.append(&self.items, numbers, LAYOUT_BITS as usize, &mut bits)?;
        if bits.is_empty() {
            let whole = (0, self.text.chars().count().max(1));
            let message = match self.items.is_empty() {
                true => "a layout needs at least one coordinate",
                false => {
                    "a layout needs a coordinate beside 'light' and 'tile', which have no bits where there is one of them"
                }
            };
            return Err(self.error(message, whole));
        }
        let cuts_tail = bits.iter().flatten().any(|&(source, _)| numbered(source).is_some());
        if let Some(&(_, span)) = bits.get(LAYOUT_BITS as usize).and_then(|bit| bit.first())
            && !cuts_tail
        {
            return Err(self.error("this word makes the layout longer than 64 bits", span));
        }
        bits.truncate(LAYOUT_BITS as usize);
        self.check(&bits, numbers)?;
        let bit = |mentions: &Vec<Mention>| Bit(mentions.iter().map(|&(source, _)| source).collect());
        Ok(Layout { bits: bits.iter().map(bit).collect(), numbers, tiles })
    }

    /// That no source has more bits than there are, and none of a curve or of `^` is mentioned elsewhere.
    fn check(&self, bits: &[Vec<Mention>], numbers: NumberBits) -> Result<(), LayoutError> {
        let (mut counts, mut places) = (BTreeMap::new(), BTreeMap::new());
        for bit in bits {
            for (side, &(source, span)) in bit.iter().enumerate() {
                let axes = source.axes();
                let count = counts.entry(axes.to_vec()).or_insert(0);
                *count += 1;
                if let Some(number) = numbered(source) {
                    if *count > numbers.of(number) {
                        let message = format!(
                            "'{source}' is the whole number already, so it can be mentioned only once"
                        );
                        return Err(self.error(&message, span));
                    }
                } else if *count > COORDINATE_BITS * axes.len() as u32 {
                    let is_endless = self.items.iter().any(|item| matches!(item, Item::Group(_, None)));
                    let hint = if is_endless { "; '*' without a number goes on to 64 bits" } else { "" };
                    let message = format!(
                        "'{source}' is mentioned more than {COORDINATE_BITS} times, and a coordinate has no more bits than that{hint}"
                    );
                    return Err(self.error(&message, span));
                }
                let place = (source, (bit.len() > 1).then_some(side));
                for &axis in axes {
                    let (first, first_span) = *places.entry(axis).or_insert((place, span));
                    if first != place {
                        let message = format!(
                            "'{}' is mentioned elsewhere, and a coordinate of a curve or of one side of '^' cannot be",
                            axis.name()
                        );
                        return Err(self.error(&message, span.max(first_span)));
                    }
                }
            }
        }
        Ok(())
    }

    /// Appends the bits of items; what comes after `room` bits is cut.
    fn append(
        &self,
        items: &[Item],
        numbers: NumberBits,
        room: usize,
        bits: &mut Vec<Vec<Mention>>,
    ) -> Result<(), LayoutError> {
        for item in items {
            match item {
                Item::Bits(source, span) => {
                    let bits_of = |number| numbers.of(number) as usize;
                    let count = numbered(*source).map_or(source.axes().len(), bits_of);
                    bits.extend((0..count).map(|_| vec![(*source, *span)]));
                }
                Item::Group(group, times) => {
                    let most = times.unwrap_or(usize::MAX);
                    for _ in 0..most {
                        let before = bits.len();
                        // One bit past the limit is enough to see that it was passed.
                        if before > room || (times.is_none() && before == room) {
                            break;
                        }
                        self.append(group, numbers, room, bits)?;
                        if bits.len() == before {
                            break;
                        }
                    }
                    if times.is_none() {
                        bits.truncate(room);
                    }
                }
                Item::Mixed(sides) => {
                    bits.extend(self.mixed(sides, numbers, room.saturating_sub(bits.len()))?);
                }
            }
        }
        Ok(())
    }

    /// The bits that `^` makes of its sides.
    fn mixed(
        &self,
        sides: &[(Item, Span)],
        numbers: NumberBits,
        room: usize,
    ) -> Result<Vec<Vec<Mention>>, LayoutError> {
        let mut mixed: Vec<Vec<Mention>> = Vec::new();
        for (number, (side, span)) in sides.iter().enumerate() {
            let mut bits = Vec::new();
            self.append(std::slice::from_ref(side), numbers, room, &mut bits)?;
            bits.truncate(room + 1);
            let is_number = |&&(source, _): &&Mention| numbered(source).is_some();
            if let Some(&(source, span)) = bits.iter().flatten().find(is_number) {
                let message =
                    format!("'{source}' has as many bits as its numbers need, so it cannot be a side of '^'");
                return Err(self.error(&message, span));
            }
            if number == 0 {
                mixed = bits;
                continue;
            }
            if bits.len() != mixed.len() {
                let message = format!(
                    "this side of '^' has {} bits and the one before {}; both need as many",
                    bits.len(),
                    mixed.len()
                );
                return Err(self.error(&message, *span));
            }
            mixed.iter_mut().zip(bits).for_each(|(mixed, bit)| mixed.extend(bit));
        }
        Ok(mixed)
    }

    fn error(&self, message: &str, (start, length): Span) -> LayoutError {
        LayoutError { message: message.to_owned(), text: self.text.clone(), start, length }
    }
}

/// The coordinate, if it is a whole number.
fn numbered(source: Source) -> Option<Coordinate> {
    match source.axes() {
        [axis] if axis.is_number() => Some(*axis),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(text: &str, lights: usize) -> Vec<String> {
        let layout = LayoutText::parse(text).unwrap().expand(Extent { lights, ..Extent::NOTHING }).unwrap();
        layout.names()
    }

    #[test]
    fn groups_repeat_and_fill() {
        assert_eq!(bits("(ox oy)*2 u", 1), ["ox", "oy", "ox", "oy", "u"]);
        assert_eq!(bits("(ox (oy u)*2)", 1), ["ox", "oy", "u", "oy", "u"]);
        assert_eq!(bits("(θ φ)×2 (ox oy oz)*", 1).len(), 64);
        assert_eq!(bits("(ox oy oz)*4 (u v ex ey ez)*10", 1).len(), 62);
    }

    #[test]
    fn curves_sides_and_sources_of_lengths() {
        assert_eq!(bits("ox*2 oy", 1), ["ox", "ox", "oy"]);
        assert_eq!(bits("hilbert(ox oy)*2", 1), ["hilbert(ox oy)"; 4]);
        assert_eq!(bits("u hilbert(ox oy oz)*", 1).len(), 64);
        assert_eq!(bits("(ox oy)*2 ^ (u v)*2 oz", 1), ["ox ^ u", "oy ^ v", "ox ^ u", "oy ^ v", "oz"]);
        assert_eq!(bits("ox ^ u ^ ex", 1), ["ox ^ u ^ ex"]);
        assert_eq!(bits("u (ox oy oz)* ^ hilbert(ex ey ez)*", 1)[63], "oz ^ hilbert(ex ey ez)");
        let length = |text: &str| LayoutText::parse(text).unwrap().length();
        assert_eq!(length("(ex ey)*2"), None);
        assert_eq!(length("(ex ey)*2@adaptive "), Some(Termination::Adaptive));
        assert_eq!(length("u hilbert(ex ey)*2 @real"), Some(Termination::Real));
    }

    #[test]
    fn light_takes_as_many_bits_as_the_lights_need() {
        assert_eq!(bits("light (lu lv)*2", 3), ["light", "light", "lu", "lv", "lu", "lv"]);
    }

    #[test]
    fn tiles_take_as_many_bits_as_the_picture_needs() {
        let layout = LayoutText::parse("tile( 64x128 ) u (ox oy oz)*21").unwrap();
        assert!(layout.uses(Coordinate::needs_path));
        for (picture, tile_bits) in [([64, 128], 0), ([65, 128], 1), ([1920, 1080], 9), ([7680, 4320], 12)] {
            let found = layout.expand(Extent { lights: 1, picture }).unwrap();
            let expected = ["tile"].repeat(tile_bits).into_iter().chain(["u", "ox"]);
            assert_eq!(found.names()[..tile_bits + 2], expected.collect::<Vec<_>>(), "{picture:?}");
            assert_eq!(found.bits().len(), LAYOUT_BITS as usize);
        }
        let large = LayoutText::parse("tile(1x1) u").unwrap();
        assert_eq!(large.expand(Extent { lights: 1, picture: [7680, 4320] }).unwrap().bits().len(), 26);
        for (picture, part) in
            [([5000, 1], "have none"), ([0, 0], "have none"), ([u32::MAX; 2], "more tiles than path indices")]
        {
            let error = large.expand(Extent { lights: 1, picture }).unwrap_err();
            assert!(error.message.contains(part), "{picture:?}: {error}");
            assert_eq!((error.start, error.length), (0, 4), "{error}");
        }
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
            ("tile ox", 0, 4, "such as tile(64x128)"),
            ("u tile(64)", 7, 2, "such as tile(64x128)"),
            ("u tile(0x8)", 7, 3, "such as tile(64x128)"),
            ("u tile()", 7, 1, "such as tile(64x128)"),
            ("u tile(64x8", 2, 4, "no ')'"),
            ("tile(8x8) ox tile(8x4)", 13, 4, "only once"),
            ("ox (tile(8x8) oy)*2", 4, 4, "only once"),
            ("tile(8x8)", 0, 9, "beside 'light' and 'tile'"),
            ("hilbert(ox tile)", 11, 4, "no coordinate"),
            ("ox ^ tile(8x8)", 5, 9, "0 bits and the one before 1"),
            ("ox \u{1b}", 3, 1, "found '\\u{1b}'"),
            ("ox*23", 0, 2, "more than 22"),
            ("hilbert(ox oq)", 11, 2, "unknown coordinate 'oq'"),
            ("hilbert(ox ox)", 11, 2, "twice"),
            ("hilbert(ox light)", 11, 5, "no coordinate"),
            ("u hilbert(ox)*4", 2, 11, "2 to 6 coordinates, found 1"),
            ("hilbert()", 0, 9, "found 0"),
            ("hilbert ox", 0, 7, "needs its coordinates"),
            ("hilbert(ox oy", 0, 7, "no ')'"),
            ("hilbert(ox (oy))", 11, 1, "found '('"),
            ("hilbert(ox oy)*23", 0, 7, "more than 22"),
            ("hilbert(ox oy)*4 oy", 17, 2, "mentioned elsewhere"),
            ("hilbert(ox oy) hilbert(oy oz)", 15, 7, "mentioned elsewhere"),
            ("ox ^", 3, 1, "nothing after"),
            ("(ox ^) ex", 4, 1, "nothing after"),
            ("^ ox", 0, 1, "nothing before"),
            ("(ox oy)*4 ^ (ex ey)*5", 12, 9, "10 bits and the one before 8"),
            ("(ox oy)*4 ^ (oy ex)*4", 13, 2, "mentioned elsewhere"),
            ("(ox ^ ex) ox", 10, 2, "mentioned elsewhere"),
            ("light ^ ox", 8, 2, "the one before 0"),
            ("ox @adaptive", 3, 9, "only ex, ey and ez"),
            ("ex @some", 3, 5, "'some' after '@'; there are fixed adaptive real"),
            ("ex @adaptve", 3, 8, "did you mean 'adaptive'?"),
            ("u tetha", 2, 5, "unknown coordinate 'tetha'; did you mean 'theta'?"),
            ("u qqq", 2, 3, "there are ox oy"),
            ("hilbrt(ox oy)", 0, 6, "did you mean 'hilbert'?"),
            ("u ligth", 2, 5, "did you mean 'light'?"),
            ("ex @real ey", 9, 1, "more follows"),
            ("(ex @real)", 4, 1, "found '@'"),
        ] {
            let error = LayoutText::parse(text).unwrap_err();
            assert!(error.message.contains(part), "{text}: {error}");
            assert_eq!((error.start, error.length), (start, length), "{text}: {error}");
        }
    }

    #[test]
    fn nested_repeats_cannot_blow_up() {
        assert!(LayoutText::parse("(((((ox oy oz)*64)*64)*64)*64)*64").is_err());
        assert!(LayoutText::parse("((((((ox ^ ex)*64)*64)*64)*64)*64").is_err());
        // No bit at all with one light.
        assert!(LayoutText::parse("((((((((light)*64)*64)*64)*64)*64)*64)*64)").is_err());
        let sides = vec!["ox"; 50_000].join("^");
        assert!(LayoutText::parse(&sides).is_err());
    }
}
