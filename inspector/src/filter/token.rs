//! From the text of a filter to its words.

use std::ops::Range;

use super::error::FilterError;

/// A word of a filter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Name(String),
    /// An operator or a bracket.
    Sign(&'static str),
    End,
}

impl Token {
    /// As errors name it.
    pub(super) fn described(&self) -> String {
        match self {
            Self::Number(value) => format!("the number {value}"),
            Self::Name(name) => format!("'{}'", name.escape_debug()),
            Self::Sign(sign) => format!("'{sign}'"),
            Self::End => "the end".to_owned(),
        }
    }
}

/// Longer ones before those that they start with.
const SIGNS: [&str; 15] = ["<=", ">=", "==", "!=", "&&", "||", "<", ">", "!", "(", ")", "+", "-", "*", "/"];

/// What other languages write, and what is written here.
const FOREIGN: [(char, &str); 5] = [('=', "=="), ('&', "&&"), ('|', "||"), ('≤', "<="), ('≥', ">=")];

/// The words of a text, each with its characters, and the end.
pub(super) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, FilterError> {
    let characters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&character) = characters.get(at) {
        if character.is_whitespace() {
            at += 1;
            continue;
        }
        let (token, length) = token(&characters[at..])
            .map_err(|(message, length)| FilterError::new(&(at..at + length), message))?;
        tokens.push((token, at..at + length));
        at += length;
    }
    tokens.push((Token::End, characters.len()..characters.len() + 1));
    Ok(tokens)
}

/// The first word and its length; else what is wrong, and how many characters are.
fn token(rest: &[char]) -> Result<(Token, usize), (String, usize)> {
    let first = rest[0];
    let while_is = |is: fn(char) -> bool| rest.iter().take_while(|&&c| is(c)).count();
    let starts_number =
        first.is_ascii_digit() || first == '.' && rest.get(1).is_some_and(char::is_ascii_digit);
    if starts_number {
        return number(rest);
    }
    if first.is_alphabetic() || first == '_' {
        let length = while_is(|c| c.is_alphanumeric() || c == '_' || c == '.');
        return Ok((Token::Name(rest[..length].iter().collect()), length));
    }
    let is_next = |sign: &&&str| sign.chars().eq(rest.iter().take(sign.len()).copied());
    if let Some(sign) = SIGNS.iter().find(is_next) {
        return Ok((Token::Sign(sign), sign.len()));
    }
    let meant = FOREIGN.iter().find(|(foreign, _)| *foreign == first);
    let expected =
        meant.map_or_else(|| "a number, a name or an operator".to_owned(), |(_, sign)| format!("'{sign}'"));
    Err((format!("found '{}', expected {expected}", first.escape_debug()), 1))
}

/// `12`, `0.5`, `.5`, `1e-3`, `0x1f`.
fn number(rest: &[char]) -> Result<(Token, usize), (String, usize)> {
    let mut length = 0;
    let mut last = ' ';
    for &c in rest {
        let is_sign_of_exponent =
            matches!(c, '+' | '-') && matches!(last, 'e' | 'E') && rest.get(1) != Some(&'x');
        if !(c.is_alphanumeric() || c == '.' || is_sign_of_exponent) {
            break;
        }
        (length, last) = (length + 1, c);
    }
    let text: String = rest[..length].iter().collect();
    let value = match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16).ok().map(|value| value as f64),
        None => text.parse::<f64>().ok(),
    };
    value.map(|value| (Token::Number(value), length)).ok_or_else(|| {
        (format!("found '{}', expected a number such as 2, 0.5, 1e-3 or 0x1f", text.escape_debug()), length)
    })
}
