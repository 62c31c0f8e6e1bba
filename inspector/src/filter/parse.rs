//! From the words of a filter to its tree, by recursive descent; what binds more tightly lies deeper.

use std::ops::Range;

use formats::key::Coordinate;
use formats::metrics::quantity::Quantity;
use formats::text::nearest;

use super::error::FilterError;
use super::token::{Token, tokens};
use super::tree::{
    COMPARISONS, FACTS, FUNCTIONS, Function, LEVELS, Node, OPERATORS, Operator, PREFIXES, ValueKind,
};

/// How deep operations may lie inside each other, so that no text can exhaust a stack.
const DEEPEST: usize = 64;

/// A condition that rays meet or not.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    pub(super) condition: Node,
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Eq for Expression {}

impl Expression {
    /// From text.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn parse(text: &str) -> Result<Self, FilterError> {
        Ok(Self { text: text.to_owned(), condition: parse(text)? })
    }

    /// As it was typed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it asks for a number that the groups of an order have.
    pub fn takes_groups(&self) -> bool {
        fn takes(node: &Node) -> bool {
            match node {
                Node::Quantity(quantity, _) => quantity.is_of_group(),
                Node::Unary(_, inner) => takes(inner),
                Node::Binary(_, both) => both.iter().any(takes),
                Node::Literal(_) | Node::Field(..) | Node::Fact(_) => false,
            }
        }
        takes(&self.condition)
    }
}

/// The condition of a text.
fn parse(text: &str) -> Result<Node, FilterError> {
    let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0 };
    let whole = parser.level(0)?;
    let (found, span) = parser.next();
    if found != Token::End {
        let expected = "an operator such as && or <, or the end";
        return Err(FilterError::expected(&span, &found.described(), expected));
    }
    whole.of_kind(ValueKind::Condition, "as a filter")
}

/// A part of the text, with its characters and its depth.
struct Parsed {
    node: Node,
    kind: ValueKind,
    span: Range<usize>,
    depth: usize,
}

impl Parsed {
    /// The part, where a value of this kind has its place.
    fn of_kind(self, wanted: ValueKind, place: &str) -> Result<Node, FilterError> {
        let (found, expected) = match wanted {
            _ if wanted == self.kind => return Ok(self.node),
            ValueKind::Number => ("a condition", format!("a number {place}")),
            ValueKind::Condition => ("a number", format!("a condition {place}, such as length < 0.1")),
        };
        Err(FilterError::expected(&self.span, found, &expected))
    }

    /// What this and another one become.
    fn with(self, operator: &'static Operator, other: Self) -> Result<Self, FilterError> {
        let span = self.span.start..other.span.end;
        let depth = checked(self.depth.max(other.depth) + 1, &span)?;
        let place = format!("beside '{}'", operator.sign);
        let both = [self.of_kind(operator.takes, &place)?, other.of_kind(operator.takes, &place)?];
        Ok(Self { node: Node::Binary(operator, Box::new(both)), kind: operator.gives, span, depth })
    }

    /// What a function makes of this one; it starts at `start`.
    fn under(self, function: &'static Function, start: usize, place: &str) -> Result<Self, FilterError> {
        let (span, depth) = (start..self.span.end, self.depth + 1);
        let inner = Box::new(self.of_kind(function.kind, place)?);
        Ok(Self { node: Node::Unary(function, inner), kind: function.kind, span, depth })
    }
}

fn checked(depth: usize, span: &Range<usize>) -> Result<usize, FilterError> {
    if depth > DEEPEST {
        let message = format!("operations lie more than {DEEPEST} deep inside each other");
        return Err(FilterError::new(span, message));
    }
    Ok(depth)
}

struct Parser {
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    depth: usize,
}

impl Parser {
    fn peek(&self) -> &(Token, Range<usize>) {
        &self.tokens[self.at.min(self.tokens.len() - 1)]
    }

    fn next(&mut self) -> (Token, Range<usize>) {
        let token = self.peek().clone();
        self.at += 1;
        token
    }

    /// The next word if it is a sign that this knows.
    fn take<T>(&mut self, known: impl FnOnce(&str) -> Option<T>) -> Option<T> {
        let Token::Sign(sign) = self.peek().0 else { return None };
        let found = known(sign)?;
        self.at += 1;
        Some(found)
    }

    /// Operators of a level and those that bind more tightly, from left to right.
    fn level(&mut self, level: usize) -> Result<Parsed, FilterError> {
        if level == LEVELS {
            return self.unary();
        }
        let of_level = |sign: &str| OPERATORS.iter().find(|known| (known.sign, known.level) == (sign, level));
        let mut left = self.level(level + 1)?;
        while let Some(operator) = self.take(of_level) {
            let right = self.level(level + 1)?;
            let (next, span) = self.peek();
            if level == COMPARISONS && matches!(next, Token::Sign(sign) if of_level(sign).is_some()) {
                let expected = "&& or ||: write 0 < t && t < 1 for 0 < t < 1";
                return Err(FilterError::expected(span, &next.described(), expected));
            }
            left = left.with(operator, right)?;
        }
        Ok(left)
    }

    /// `-x`, `!c`, or what neither stands before.
    fn unary(&mut self) -> Result<Parsed, FilterError> {
        let start = self.peek().1.start;
        self.depth = checked(self.depth + 1, &(start..start + 1))?;
        let parsed = match self.take(|sign| PREFIXES.iter().find(|prefix| prefix.name == sign)) {
            None => self.primary()?,
            Some(prefix) => {
                let place = if prefix.name == "!" { "after '!': write !(…)" } else { "after '-'" };
                self.unary()?.under(prefix, start, place)?
            }
        };
        self.depth -= 1;
        Ok(parsed)
    }

    fn primary(&mut self) -> Result<Parsed, FilterError> {
        let (token, span) = self.next();
        let (node, kind) = match token {
            Token::Number(value) => (Node::Literal(value), ValueKind::Number),
            Token::Sign("(") => {
                let inner = self.level(0)?;
                let end = self.close(&span)?;
                return Ok(Parsed { span: span.start..end, ..inner });
            }
            Token::Name(name) if self.take(|sign| (sign == "(").then_some(())).is_some() => {
                return self.call(&name, &span);
            }
            Token::Name(name) => named(&name, &span)?,
            found => {
                let expected = "a number, a name, '(', '-' or '!'";
                return Err(FilterError::expected(&span, &found.described(), expected));
            }
        };
        Ok(Parsed { node, kind, span, depth: 1 })
    }

    /// What follows `name(`.
    fn call(&mut self, name: &str, span: &Range<usize>) -> Result<Parsed, FilterError> {
        if name == "field" {
            let (found, inner) = self.next();
            let node = Node::Field(coordinate(&found, &inner)?, inner);
            let end = self.close(span)?;
            return Ok(Parsed { node, kind: ValueKind::Number, span: span.start..end, depth: 1 });
        }
        let Some(function) = FUNCTIONS.iter().find(|function| function.name == name) else {
            let known = ["abs", "log2", "field"];
            let hint = nearest(name, &known).map_or_else(
                || format!("there are {}", known.join(", ")),
                |meant| format!("did you mean '{meant}'?"),
            );
            let message = format!("found '{}(', which is no function; {hint}", name.escape_debug());
            return Err(FilterError::new(span, message));
        };
        let inner = self.level(0)?;
        let end = self.close(span)?;
        checked(inner.depth + 1, span)?;
        let called = inner.under(function, span.start, &format!("in {name}(…)"))?;
        Ok(Parsed { span: span.start..end, ..called })
    }

    /// The closing bracket of what was opened; where it ends.
    fn close(&mut self, open: &Range<usize>) -> Result<usize, FilterError> {
        match self.next() {
            (Token::Sign(")"), span) => Ok(span.end),
            (found, span) => {
                let expected = format!("')' for what was opened at character {}", open.start + 1);
                Err(FilterError::expected(&span, &found.described(), &expected))
            }
        }
    }
}

fn named(name: &str, span: &Range<usize>) -> Result<(Node, ValueKind), FilterError> {
    if let Some((_, fact)) = FACTS.iter().find(|(known, _)| *known == name) {
        return Ok((Node::Fact(*fact), ValueKind::Condition));
    }
    for (foreign, sign) in [("and", "&&"), ("or", "||"), ("not", "!")] {
        if name == foreign {
            return Err(FilterError::expected(span, &format!("'{name}'"), &format!("'{sign}'")));
        }
    }
    let quantity = Quantity::of_name(name).ok_or_else(|| FilterError::unknown(span, name))?;
    Ok((Node::Quantity(quantity, span.clone()), ValueKind::Number))
}

fn coordinate(found: &Token, span: &Range<usize>) -> Result<Coordinate, FilterError> {
    let is_meant = |known: &&Coordinate| matches!(found, Token::Name(name) if name == known.name());
    Coordinate::ALL.iter().find(is_meant).copied().ok_or_else(|| {
        let names: Vec<&str> = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).collect();
        let expected = format!("a coordinate of keys: {}", names.join(" "));
        FilterError::expected(span, &found.described(), &expected)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_say_where_what_and_what_else() {
        for (text, start, length, part) in [
            ("bounse == 2", 0, 6, "did you mean 'bounce'?"),
            ("t < ", 4, 1, "found the end, expected a number, a name"),
            ("t < 0.1 &&", 10, 1, "found the end"),
            ("t = 0.1", 2, 1, "found '=', expected '=='"),
            ("t < 0.1 & hit", 8, 1, "expected '&&'"),
            ("0 < t < 1", 6, 1, "write 0 < t && t < 1"),
            ("t", 0, 1, "found a number, expected a condition"),
            ("hit == 1", 0, 3, "found a condition, expected a number"),
            ("!t < 1", 1, 1, "write !(…)"),
            ("(t < 1", 6, 1, "expected ')' for what was opened at character 1"),
            ("t < 1)", 5, 1, "found ')', expected an operator"),
            ("field(oq) > 1", 6, 2, "expected a coordinate of keys: ox"),
            ("lag2(t) > 1", 0, 4, "did you mean 'log2'?"),
            ("t < 1.2.3", 4, 5, "expected a number such as"),
            ("t < 0xg", 4, 3, "expected a number such as"),
            ("t < 1 and hit", 6, 3, "expected an operator"),
            ("not hit", 0, 3, "expected '!'"),
            ("t < #", 4, 1, "found '#'"),
            ("abs(hit) > 1", 4, 3, "expected a number in abs"),
            ("", 0, 1, "found the end"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.message.contains(part), "{text}: {error}");
            assert_eq!((error.start, error.length), (start, length), "{text}: {error}");
        }
    }

    #[test]
    fn no_text_is_too_deep_for_the_stack() {
        for text in [
            format!("{}t < 1{}", "(".repeat(100_000), ")".repeat(100_000)),
            format!("{}hit", "!".repeat(100_000)),
            format!("t < 1{}", " + 1".repeat(100_000)),
        ] {
            assert!(parse(&text).unwrap_err().message.contains("64 deep"));
        }
        assert!(parse(&format!("{}t < 1{}", "(".repeat(50), ")".repeat(50))).is_ok());
    }

    #[test]
    fn operators_bind_as_in_c() {
        for (text, same) in [
            ("hit || shadow && !hit", "hit || (shadow && (!hit))"),
            ("1 + 2 * t < 3 - 4 - 5", "(1 + (2 * t)) < ((3 - 4) - 5)"),
            ("-t * 2 > 1e-3 / .5", "((-t) * 2) > (0.001 / 0.5)"),
            ("dir.x < 0x1F && hit", "((direction.x) < 31) && hit"),
        ] {
            let shape = |text: &str| {
                let tree = format!("{:?}", parse(text).unwrap());
                // Spans differ, as the texts do.
                tree.split_whitespace().filter(|word| !word.contains("..")).collect::<String>()
            };
            assert_eq!(shape(text), shape(same), "{text}");
        }
    }
}
