//! From the characters of a layout to its words, groups and curves.

use super::layout::{CURVE_AXES, Source};
use super::layout_text::{LayoutError, SHOWN};
use super::{Coordinate, Termination};
use crate::text::{did_you_mean, one_line};

/// The word for a Hilbert curve.
const CURVE: &str = "hilbert";

/// Some characters of a text: the first one, and how many.
pub(super) type Span = (usize, usize);

/// What a layout is made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Item {
    /// A coordinate, or a level of a curve.
    Bits(Source, Span),
    /// A group, and how often it is repeated; to the end if nothing is said.
    Group(Vec<Item>, Option<usize>),
    /// What `^` combines.
    Mixed(Vec<(Item, Span)>),
}

/// What was read of a layout's text.
pub(super) struct Parsed {
    pub items: Vec<Item>,
    /// Where the length of the end point comes from, if it says so.
    pub length: Option<(Termination, Span)>,
    /// Width and height of a tile, as the last `tile` said.
    pub tile: Option<([u32; 2], Span)>,
}

/// Reads a text; what its bits come to is not looked at.
///
/// # Errors
/// Unknown words, unbalanced brackets, bad counts; each with its place.
pub(super) fn parse(text: &str) -> Result<Parsed, LayoutError> {
    let characters: Vec<char> = text.chars().collect();
    let mut parser = Parser { text, characters: &characters, at: 0, tile: None };
    let items = parser.items(0)?;
    let length = parser.length()?;
    Ok(Parsed { items, length, tile: parser.tile })
}

struct Parser<'a> {
    text: &'a str,
    characters: &'a [char],
    at: usize,
    tile: Option<([u32; 2], Span)>,
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
                (name, span) if name == CURVE => Item::Bits(self.curve(span)?, span),
                (name, span) if name == Coordinate::Tile.name() => {
                    self.tile = Some((self.tile_size(span)?, span));
                    Item::Bits(Source::coordinate(Coordinate::Tile), span)
                }
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
            if axis.is_number() || axes.contains(&axis) {
                let reason = if axis.is_number() { "is a number, no coordinate" } else { "is there twice" };
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

    /// Width and height in pixels after `tile`, in brackets.
    fn tile_size(&mut self, (start, length): Span) -> Result<[u32; 2], LayoutError> {
        let missing = "'tile' needs its size in pixels after it, such as tile(64x128)";
        if self.characters.get(self.at) != Some(&'(') {
            return Err(self.error(missing, start, length));
        }
        self.at += 1;
        self.next();
        let (size, (start_of_size, length_of_size)) = self.word();
        let side = |text: &str| text.parse().ok().filter(|&side: &u32| side > 0);
        let sides = size.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
        let Some(sides) = sides else {
            return Err(self.error(missing, start_of_size, length_of_size.max(1)));
        };
        if self.next() != Some(')') {
            return Err(self.error("'tile(' has no ')' after it", start, length));
        }
        self.at += 1;
        Ok(sides)
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
            let known: Vec<&str> = Termination::ALL.into_iter().filter_map(Termination::word).collect();
            let (found, hint) = (one_line(&name, SHOWN), did_you_mean(&name, &known));
            let message = format!("unknown source of lengths '{found}' after '@'; {hint}");
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
            let known = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).chain([CURVE]);
            let hint = did_you_mean(name, &known.collect::<Vec<_>>());
            self.error(&format!("unknown coordinate '{}'; {hint}", one_line(name, SHOWN)), start, length)
        })
    }

    fn error(&self, message: &str, start: usize, length: usize) -> LayoutError {
        LayoutError { message: message.to_owned(), text: self.text.to_owned(), start, length }
    }
}
