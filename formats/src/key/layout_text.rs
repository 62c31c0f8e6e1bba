//! The words of layouts, as in KEYS and on the command line.
//!
//! Names separated by blanks; `(…)*n` repeats a group n times, `name*n` a name, and `*` without a number repeats to
//! the end. Each mention of a name takes that coordinate's next lower bit; `light` stands for as many bits as the
//! number of lights needs. `hilbert(ox oy oz)*n` takes n bits of each coordinate along the Hilbert curve through
//! them. `A ^ B` is the bitwise exclusive or of two names or groups of as many bits. `@fixed`, `@adaptive` or
//! `@real` at the end says where the length of the end point comes from.

use std::collections::BTreeMap;
use std::fmt;

use super::layout::{Bit, CURVE_AXES, Source};
use super::{COORDINATE_BITS, Coordinate, LAYOUT_BITS, Layout, Termination};
use crate::text::one_line;

/// Most characters of a text that a message shows.
const SHOWN: usize = 200;

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

/// Some characters of a text: the first one, and how many.
type Span = (usize, usize);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Item {
    /// A coordinate, or a level of a curve.
    Bits(Source, Span),
    /// A group, and how often it is repeated; to the end if nothing is said.
    Group(Vec<Item>, Option<usize>),
    /// What `^` combines.
    Mixed(Vec<(Item, Span)>),
}

/// A source where it is mentioned.
type Mention = (Source, Span);

/// A parsed layout text; becomes a [`Layout`] once the number of lights is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayoutText {
    text: String,
    items: Vec<Item>,
    length: Option<Termination>,
}

impl LayoutText {
    /// Parses a text such as `(ox oy oz)*4 (u v ex ey ez)*10`.
    ///
    /// # Errors
    /// Unknown words, unbalanced brackets, bad counts, no bit at all, a coordinate with more than
    /// 22 bits, more than 64 bits (without `light`, where the tail is cut), `light` more than once; curves of
    /// other than 2 to 6 coordinates, sides of `^` with different numbers of bits, a coordinate of either that is
    /// mentioned elsewhere, a length that no end point needs; each with its place.
    pub fn parse(text: &str) -> Result<Self, LayoutError> {
        let characters: Vec<char> = text.chars().collect();
        let mut parser = Parser { text, characters: &characters, at: 0 };
        let items = parser.items(0)?;
        let length = parser.length()?;
        let parsed = Self { text: text.to_owned(), items, length: length.map(|(source, _)| source) };
        // One light is the case with the fewest index bits, so it shows every other fault; two show
        // an index that is mentioned twice.
        parsed.expand(1)?;
        let layout = parsed.expand(2)?;
        match length {
            Some((_, span)) if !layout.uses(Coordinate::needs_length) => {
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

    /// The layout for a scene with this many lights (at least 1).
    ///
    /// # Errors
    /// None beyond those that [`LayoutText::parse`] already reported, up to 2^22 lights.
    pub fn expand(&self, lights: usize) -> Result<Layout, LayoutError> {
        let mut bits = Vec::new();
        let light_bits = light_index_bits(lights);
        self.append(&self.items, light_bits, LAYOUT_BITS as usize, &mut bits)?;
        if bits.is_empty() {
            let whole = (0, self.text.chars().count().max(1));
            return Err(self.error("a layout needs at least one coordinate", whole));
        }
        let cuts_tail = bits.iter().flatten().any(|&(source, _)| is_light(source));
        if let Some(&(_, span)) = bits.get(LAYOUT_BITS as usize).and_then(|bit| bit.first())
            && !cuts_tail
        {
            return Err(self.error("this word makes the layout longer than 64 bits", span));
        }
        bits.truncate(LAYOUT_BITS as usize);
        self.check(&bits, light_bits)?;
        let bit = |mentions: &Vec<Mention>| Bit(mentions.iter().map(|&(source, _)| source).collect());
        Ok(Layout { bits: bits.iter().map(bit).collect(), light_bits })
    }

    /// That no source has more bits than there are, and none of a curve or of `^` is mentioned elsewhere.
    fn check(&self, bits: &[Vec<Mention>], light_bits: u32) -> Result<(), LayoutError> {
        let (mut counts, mut places) = (BTreeMap::new(), BTreeMap::new());
        for bit in bits {
            for (side, &(source, span)) in bit.iter().enumerate() {
                let axes = source.axes();
                let count = counts.entry(axes.to_vec()).or_insert(0);
                *count += 1;
                if is_light(source) && *count > light_bits {
                    let message = "'light' is the whole index already, so it can be mentioned only once";
                    return Err(self.error(message, span));
                }
                if *count > COORDINATE_BITS * axes.len() as u32 {
                    let message = format!(
                        "'{source}' is mentioned more than {COORDINATE_BITS} times, and a coordinate has no more bits than that"
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
        light_bits: u32,
        room: usize,
        bits: &mut Vec<Vec<Mention>>,
    ) -> Result<(), LayoutError> {
        for item in items {
            match item {
                Item::Bits(source, span) => {
                    let count = if is_light(*source) { light_bits as usize } else { source.axes().len() };
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
                        self.append(group, light_bits, room, bits)?;
                        if bits.len() == before {
                            break;
                        }
                    }
                    if times.is_none() {
                        bits.truncate(room);
                    }
                }
                Item::Mixed(sides) => {
                    bits.extend(self.mixed(sides, light_bits, room.saturating_sub(bits.len()))?);
                }
            }
        }
        Ok(())
    }

    /// The bits that `^` makes of its sides.
    fn mixed(
        &self,
        sides: &[(Item, Span)],
        light_bits: u32,
        room: usize,
    ) -> Result<Vec<Vec<Mention>>, LayoutError> {
        let mut mixed: Vec<Vec<Mention>> = Vec::new();
        for (number, (side, span)) in sides.iter().enumerate() {
            let mut bits = Vec::new();
            self.append(std::slice::from_ref(side), light_bits, room, &mut bits)?;
            bits.truncate(room + 1);
            if let Some(&(_, span)) = bits.iter().flatten().find(|&&(source, _)| is_light(source)) {
                let message = "'light' has as many bits as there are lights, so it cannot be a side of '^'";
                return Err(self.error(message, span));
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

/// ⌈log2 lights⌉, the bits that a light's index takes.
pub fn light_index_bits(lights: usize) -> u32 {
    usize::BITS - lights.max(1).saturating_sub(1).leading_zeros()
}

fn is_light(source: Source) -> bool {
    source.axes() == [Coordinate::Light]
}

struct Parser<'a> {
    text: &'a str,
    characters: &'a [char],
    at: usize,
}

impl Parser<'_> {
    fn items(&mut self, depth: usize) -> Result<Vec<Item>, LayoutError> {
        let mut items = Vec::new();
        while let Some(character) = self.next() {
            match character {
                ')' if depth > 0 => break,
                ')' => return Err(self.error("')' has no '(' before it", self.at, 1)),
                '@' if depth == 0 => break,
                '^' => {
                    let sign = self.at;
                    let Some(left) = items.pop() else {
                        return Err(self.error("'^' has nothing before it", sign, 1));
                    };
                    self.at += 1;
                    if matches!(self.next(), None | Some(')')) {
                        return Err(self.error("'^' has nothing after it", sign, 1));
                    }
                    let start = self.at;
                    let right = (self.item(depth)?, (start, self.at - start));
                    items.push(match left {
                        Item::Mixed(sides) => Item::Mixed([sides, vec![right]].concat()),
                        left => Item::Mixed(vec![(left, (sign, 1)), right]),
                    });
                }
                _ => items.push(self.item(depth)?),
            }
        }
        Ok(items)
    }

    /// The next character that is not blank.
    fn next(&mut self) -> Option<char> {
        while self.characters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.characters.get(self.at).copied()
    }

    /// A name, a curve or a group, and how often.
    fn item(&mut self, depth: usize) -> Result<Item, LayoutError> {
        let item = match self.characters.get(self.at) {
            Some('(') if depth >= 8 => {
                return Err(self.error("brackets are nested more than 8 deep", self.at, 1));
            }
            Some('(') => Item::Group(self.group(depth)?, Some(1)),
            Some(c) if c.is_alphabetic() => match self.word() {
                (name, span) if name == "hilbert" => Item::Bits(self.curve(span)?, span),
                (name, span) => Item::Bits(Source::coordinate(self.coordinate(&name, span)?), span),
            },
            found => {
                let found = found.map_or(String::new(), |c| c.escape_debug().to_string());
                let problem = format!("found '{found}', expected a coordinate's name or '('");
                return Err(self.error(&problem, self.at, 1));
            }
        };
        let Some(times) = self.times()? else { return Ok(item) };
        Ok(match item {
            Item::Group(items, _) => Item::Group(items, times),
            item => Item::Group(vec![item], times),
        })
    }

    fn group(&mut self, depth: usize) -> Result<Vec<Item>, LayoutError> {
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
        Ok(items)
    }

    /// What follows `*`, if there is one: a number, or nothing for the whole rest.
    fn times(&mut self) -> Result<Option<Option<usize>>, LayoutError> {
        if !matches!(self.characters.get(self.at), Some('*' | '×')) {
            return Ok(None);
        }
        self.at += 1;
        let start = self.at;
        while self.characters.get(self.at).is_some_and(char::is_ascii_digit) {
            self.at += 1;
        }
        if start == self.at {
            return Ok(Some(None));
        }
        let digits: String = self.characters[start..self.at].iter().collect();
        match digits.parse() {
            Ok(times @ 1..=64) => Ok(Some(Some(times))),
            _ => Err(self.error("a group or a name can be repeated 1 to 64 times", start, self.at - start)),
        }
    }

    /// The coordinates of a curve, whose name was read.
    fn curve(&mut self, (start, length): Span) -> Result<Source, LayoutError> {
        if self.characters.get(self.at) != Some(&'(') {
            let message = "'hilbert' needs its coordinates after it, such as hilbert(ox oy oz)*10";
            return Err(self.error(message, start, length));
        }
        self.at += 1;
        let mut axes: Vec<Coordinate> = Vec::new();
        while let Some(character) = self.next().filter(|&character| character != ')') {
            if !character.is_alphabetic() {
                let found = character.escape_debug();
                let message = format!("found '{found}', expected a coordinate's name or ')' of hilbert");
                return Err(self.error(&message, self.at, 1));
            }
            let (name, span) = self.word();
            let axis = self.coordinate(&name, span)?;
            if axis == Coordinate::Light || axes.contains(&axis) {
                let reason =
                    if axis == Coordinate::Light { "is a number, no coordinate" } else { "is there twice" };
                let message = format!("'{name}' {reason}: a curve goes through different coordinates");
                return Err(self.error(&message, span.0, span.1));
            }
            axes.push(axis);
        }
        if self.next().is_none() {
            return Err(self.error("'hilbert(' has no ')' after it", start, length));
        }
        self.at += 1;
        Source::curve(&axes).ok_or_else(|| {
            let message = format!("a curve goes through 2 to {CURVE_AXES} coordinates, found {}", axes.len());
            self.error(&message, start, self.at - start)
        })
    }

    /// `@` and the source of lengths at the end, if there is one.
    fn length(&mut self) -> Result<Option<(Termination, Span)>, LayoutError> {
        if self.next() != Some('@') {
            return Ok(None);
        }
        let start = self.at;
        self.at += 1;
        let (name, _) = self.word();
        let span = (start, self.at - start);
        let source = Termination::ALL.into_iter().find(|source| source.word() == Some(name.as_str()));
        let Some(source) = source else {
            let name = one_line(&name, SHOWN);
            let message = format!("unknown source of lengths '@{name}'; there are @fixed @adaptive @real");
            return Err(self.error(&message, span.0, span.1));
        };
        if self.next().is_some() {
            return Err(self.error(&format!("'@{name}' ends a layout, and more follows"), self.at, 1));
        }
        Ok(Some((source, span)))
    }

    /// Letters and digits, and where they are.
    fn word(&mut self) -> (String, Span) {
        let start = self.at;
        while self.characters.get(self.at).is_some_and(|c| c.is_alphanumeric()) {
            self.at += 1;
        }
        (self.characters[start..self.at].iter().collect(), (start, self.at - start))
    }

    fn coordinate(&self, name: &str, (start, length): Span) -> Result<Coordinate, LayoutError> {
        Coordinate::from_name(name).ok_or_else(|| {
            let known: Vec<_> = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).collect();
            let (name, known) = (one_line(name, SHOWN), known.join(" "));
            self.error(&format!("unknown coordinate '{name}'; there are {known}"), start, length)
        })
    }

    fn error(&self, message: &str, start: usize, length: usize) -> LayoutError {
        LayoutError { message: message.to_owned(), text: self.text.to_owned(), start, length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(text: &str, lights: usize) -> Vec<String> {
        let layout = LayoutText::parse(text).unwrap().expand(lights).unwrap();
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
            ("ex @some", 3, 5, "@fixed @adaptive @real"),
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
