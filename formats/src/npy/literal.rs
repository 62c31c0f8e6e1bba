//! The few Python literals that NPY headers are made of.

use std::fmt;

use super::NpyError;

/// Brackets of a header nest no deeper: dictionary, list, tuple, tuple.
const DEPTH_MAX: usize = 4;

/// A Python literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Literal {
    Text(String),
    Number(u64),
    Boolean(bool),
    Tuple(Vec<Literal>),
    List(Vec<Literal>),
    Dictionary(Vec<(Literal, Literal)>),
}

impl Literal {
    /// The one literal in `text`, which may be followed by blanks.
    pub(super) fn parse(text: &[u8]) -> Result<Self, NpyError> {
        let mut parser = Parser { text, at: 0 };
        let literal = parser.literal(0)?;
        parser.skip_blanks();
        if parser.at < text.len() {
            return Err(parser.error("expected nothing more"));
        }
        Ok(literal)
    }

    /// The tuple of these lengths.
    pub(super) fn tuple_of(lengths: &[u64]) -> Self {
        Self::Tuple(lengths.iter().map(|&length| Self::Number(length)).collect())
    }

    /// What the dictionary holds under `key`, if this is one and `key` is in it once.
    pub(super) fn entry(&self, key: &str) -> Option<&Self> {
        let Self::Dictionary(entries) = self else { return None };
        let mut found = entries.iter().filter(|(name, _)| matches!(name, Self::Text(name) if name == key));
        let (_, value) = found.next()?;
        found.next().is_none().then_some(value)
    }
}

impl fmt::Display for Literal {
    /// As Python's `repr` writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joined = |items: &[Self]| items.iter().map(Self::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Self::Text(text) => write!(f, "'{text}'"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Boolean(true) => f.write_str("True"),
            Self::Boolean(false) => f.write_str("False"),
            Self::Tuple(items) if items.len() == 1 => write!(f, "({},)", items[0]),
            Self::Tuple(items) => write!(f, "({})", joined(items)),
            Self::List(items) => write!(f, "[{}]", joined(items)),
            Self::Dictionary(entries) => {
                let entries = entries.iter().map(|(key, value)| format!("{key}: {value}"));
                write!(f, "{{{}}}", entries.collect::<Vec<_>>().join(", "))
            }
        }
    }
}

struct Parser<'a> {
    text: &'a [u8],
    at: usize,
}

impl Parser<'_> {
    fn literal(&mut self, depth: usize) -> Result<Literal, NpyError> {
        self.skip_blanks();
        if depth > DEPTH_MAX {
            return Err(self.error("brackets nest too deep"));
        }
        match self.text.get(self.at) {
            Some(b'\'' | b'"') => self.quoted().map(Literal::Text),
            Some(b'0'..=b'9') => self.number().map(Literal::Number),
            Some(b'T') => self.word(b"True", Literal::Boolean(true)),
            Some(b'F') => self.word(b"False", Literal::Boolean(false)),
            Some(b'(') => self.items(b')', depth).map(Literal::Tuple),
            Some(b'[') => self.items(b']', depth).map(Literal::List),
            Some(b'{') => self.dictionary(depth),
            _ => Err(self.error("expected a literal")),
        }
    }

    fn quoted(&mut self) -> Result<String, NpyError> {
        let quote = self.text[self.at];
        let rest = &self.text[self.at + 1..];
        let length =
            rest.iter().position(|&byte| byte == quote).ok_or(self.error("expected a closing quote"))?;
        let plain = |byte: &u8| byte.is_ascii_graphic() && *byte != b'\\' || *byte == b' ';
        if !rest[..length].iter().all(plain) {
            return Err(self.error("expected plain characters"));
        }
        self.at += length + 2;
        Ok(rest[..length].iter().map(|&byte| char::from(byte)).collect())
    }

    fn number(&mut self) -> Result<u64, NpyError> {
        let mut number = 0u64;
        while let Some(digit) = self.text.get(self.at).filter(|byte| byte.is_ascii_digit()) {
            let next = number.checked_mul(10).and_then(|tens| tens.checked_add(u64::from(digit - b'0')));
            number = next.ok_or(self.error("expected a number below 2^64"))?;
            self.at += 1;
        }
        Ok(number)
    }

    fn word(&mut self, word: &[u8], value: Literal) -> Result<Literal, NpyError> {
        if !self.text[self.at..].starts_with(word) {
            return Err(self.error("expected True or False"));
        }
        self.at += word.len();
        Ok(value)
    }

    fn items(&mut self, close: u8, depth: usize) -> Result<Vec<Literal>, NpyError> {
        self.at += 1;
        let mut items = Vec::new();
        while !self.closes(close) {
            items.push(self.literal(depth + 1)?);
            self.separator(close)?;
        }
        Ok(items)
    }

    fn dictionary(&mut self, depth: usize) -> Result<Literal, NpyError> {
        self.at += 1;
        let mut entries = Vec::new();
        while !self.closes(b'}') {
            let key = self.literal(depth + 1)?;
            self.skip_blanks();
            if self.text.get(self.at) != Some(&b':') {
                return Err(self.error("expected ':'"));
            }
            self.at += 1;
            entries.push((key, self.literal(depth + 1)?));
            self.separator(b'}')?;
        }
        Ok(Literal::Dictionary(entries))
    }

    /// Steps over the closing bracket if it is next.
    fn closes(&mut self, close: u8) -> bool {
        self.skip_blanks();
        let closes = self.text.get(self.at) == Some(&close);
        self.at += usize::from(closes);
        closes
    }

    /// Steps over a comma; without one the bracket must close.
    fn separator(&mut self, close: u8) -> Result<(), NpyError> {
        self.skip_blanks();
        match self.text.get(self.at) {
            Some(b',') => self.at += 1,
            Some(&byte) if byte == close => {}
            _ => return Err(self.error("expected ',' or a closing bracket")),
        }
        Ok(())
    }

    fn skip_blanks(&mut self) {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    fn error(&self, problem: &'static str) -> NpyError {
        NpyError::Literal { problem, at: self.at }
    }
}
