//! From the words of a filter to its tree, by recursive descent; what binds more tightly lies deeper.

use std::ops::Range;

use formats::key::Coordinate;
use formats::metrics::quantity::Quantity;

use super::error::{FilterError, nearest};
use super::token::{Token, tokens};
use super::tree::{Arithmetic, Comparison, Condition, Connective, Fact, Function, Number};

/// How deep operations may lie inside each other, so that no text can exhaust a stack.
const DEEPEST: usize = 64;

/// A condition that rays meet or not.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    pub(super) condition: Condition,
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
}

/// The condition of a text.
fn parse(text: &str) -> Result<Condition, FilterError> {
    let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0 };
    let whole = parser.either()?;
    let (found, span) = parser.next();
    if found != Token::End {
        return Err(FilterError::expected(
            &span,
            &found.described(),
            "an operator such as && or <, or the end",
        ));
    }
    whole.condition("as a filter")
}

/// A number or a condition, with its characters and its depth.
struct Parsed {
    value: Value,
    span: Range<usize>,
    depth: usize,
}

enum Value {
    Number(Number),
    Condition(Condition),
}

impl Parsed {
    fn number(self, place: &str) -> Result<Number, FilterError> {
        match self.value {
            Value::Number(number) => Ok(number),
            Value::Condition(_) => {
                Err(FilterError::expected(&self.span, "a condition", &format!("a number {place}")))
            }
        }
    }

    fn condition(self, place: &str) -> Result<Condition, FilterError> {
        match self.value {
            Value::Condition(condition) => Ok(condition),
            Value::Number(_) => Err(FilterError::expected(
                &self.span,
                "a number",
                &format!("a condition {place}, such as length < 0.1"),
            )),
        }
    }

    /// What this and another one become.
    fn with(
        self,
        other: Self,
        of: impl FnOnce(Self, Self) -> Result<Value, FilterError>,
    ) -> Result<Self, FilterError> {
        let span = self.span.start..other.span.end;
        let depth = checked(self.depth.max(other.depth) + 1, &span)?;
        Ok(Self { value: of(self, other)?, span, depth })
    }
}

fn checked(depth: usize, span: &Range<usize>) -> Result<usize, FilterError> {
    if depth > DEEPEST {
        return Err(FilterError::new(
            span,
            format!("operations lie more than {DEEPEST} deep inside each other"),
        ));
    }
    Ok(depth)
}

struct Parser {
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    depth: usize,
}

impl Parser {
    fn peek(&self) -> &Token {
        self.tokens.get(self.at).map_or(&Token::End, |(token, _)| token)
    }

    fn next(&mut self) -> (Token, Range<usize>) {
        let last = self.tokens.len() - 1;
        let token = self.tokens[self.at.min(last)].clone();
        self.at += 1;
        token
    }

    /// The next word if it is one of these signs.
    fn take(&mut self, signs: &[&'static str]) -> Option<&'static str> {
        let Token::Sign(sign) = *self.peek() else { return None };
        signs.contains(&sign).then(|| {
            self.at += 1;
            sign
        })
    }

    /// One level of operators that are taken from left to right.
    fn chain(
        &mut self,
        signs: &[&'static str],
        inner: fn(&mut Self) -> Result<Parsed, FilterError>,
        of: impl Fn(&'static str, Parsed, Parsed) -> Result<Value, FilterError>,
    ) -> Result<Parsed, FilterError> {
        let mut left = inner(self)?;
        while let Some(sign) = self.take(signs) {
            let right = inner(self)?;
            left = left.with(right, |left, right| of(sign, left, right))?;
        }
        Ok(left)
    }

    fn either(&mut self) -> Result<Parsed, FilterError> {
        self.chain(&["||"], Self::both, connected)
    }

    fn both(&mut self) -> Result<Parsed, FilterError> {
        self.chain(&["&&"], Self::comparison, connected)
    }

    fn comparison(&mut self) -> Result<Parsed, FilterError> {
        let signs: Vec<&'static str> = Comparison::ALL.iter().map(|sign| sign.name()).collect();
        let left = self.sum()?;
        let Some(sign) = self.take(&signs) else { return Ok(left) };
        let right = self.sum()?;
        if let Some(second) = self.take(&signs) {
            let (_, span) = &self.tokens[self.at - 1];
            let expected = "&& or ||: write 0 < t && t < 1 for 0 < t < 1";
            return Err(FilterError::expected(span, &format!("'{second}'"), expected));
        }
        left.with(right, |left, right| {
            let place = format!("beside '{sign}'");
            let comparison = Comparison::of_name(sign).unwrap_or(Comparison::Equal);
            let numbers = [left.number(&place)?, right.number(&place)?];
            Ok(Value::Condition(Condition::Compare(comparison, Box::new(numbers))))
        })
    }

    fn sum(&mut self) -> Result<Parsed, FilterError> {
        self.chain(&["+", "-"], Self::product, calculated)
    }

    fn product(&mut self) -> Result<Parsed, FilterError> {
        self.chain(&["*", "/"], Self::unary, calculated)
    }

    /// `-x`, `!c`, or what neither stands before.
    fn unary(&mut self) -> Result<Parsed, FilterError> {
        let (_, Range { start, .. }) = self.tokens[self.at.min(self.tokens.len() - 1)].clone();
        self.depth = checked(self.depth + 1, &(start..start + 1))?;
        let parsed = match self.take(&["-", "!"]) {
            None => self.primary()?,
            Some(sign) => {
                let inner = self.unary()?;
                let (span, depth) = (start..inner.span.end, inner.depth + 1);
                let value = if sign == "-" {
                    Value::Number(Number::Call(Function::Minus, Box::new(inner.number("after '-'")?)))
                } else {
                    let inner = inner.condition("after '!': write !(…)")?;
                    Value::Condition(Condition::Not(Box::new(inner)))
                };
                Parsed { value, span, depth }
            }
        };
        self.depth -= 1;
        Ok(parsed)
    }

    fn primary(&mut self) -> Result<Parsed, FilterError> {
        let (token, span) = self.next();
        let value = match token {
            Token::Number(value) => Value::Number(Number::Literal(value)),
            Token::Sign("(") => {
                let inner = self.either()?;
                let end = self.close(&span)?;
                return Ok(Parsed { span: span.start..end, ..inner });
            }
            Token::Name(name) if self.take(&["("]).is_some() => return self.call(&name, &span),
            Token::Name(name) => named(&name, &span)?,
            found => {
                let expected = "a number, a name, '(', '-' or '!'";
                return Err(FilterError::expected(&span, &found.described(), expected));
            }
        };
        Ok(Parsed { value, span, depth: 1 })
    }

    /// What follows `name(`.
    fn call(&mut self, name: &str, span: &Range<usize>) -> Result<Parsed, FilterError> {
        if name == "field" {
            let (found, inner) = self.next();
            let coordinate = coordinate(&found, &inner)?;
            let end = self.close(span)?;
            let value = Value::Number(Number::Field(coordinate, inner));
            return Ok(Parsed { value, span: span.start..end, depth: 1 });
        }
        let Some(function) = Function::of_name(name) else {
            let known = ["abs", "log2", "field"];
            let hint = nearest(name, &known).map_or_else(
                || format!("there are {}", known.join(", ")),
                |meant| format!("did you mean '{meant}'?"),
            );
            return Err(FilterError::new(
                span,
                format!("found '{}(', which is no function; {hint}", name.escape_debug()),
            ));
        };
        let inner = self.either()?;
        let end = self.close(span)?;
        let depth = checked(inner.depth + 1, span)?;
        let number = inner.number(&format!("in {name}(…)"))?;
        Ok(Parsed {
            value: Value::Number(Number::Call(function, Box::new(number))),
            span: span.start..end,
            depth,
        })
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

fn connected(sign: &'static str, left: Parsed, right: Parsed) -> Result<Value, FilterError> {
    let place = format!("beside '{sign}'");
    let connective = if sign == "&&" { Connective::And } else { Connective::Or };
    let conditions = [left.condition(&place)?, right.condition(&place)?];
    Ok(Value::Condition(Condition::Both(connective, Box::new(conditions))))
}

fn calculated(sign: &'static str, left: Parsed, right: Parsed) -> Result<Value, FilterError> {
    let place = format!("beside '{sign}'");
    let arithmetic = Arithmetic::of_name(sign).unwrap_or(Arithmetic::Plus);
    let numbers = [left.number(&place)?, right.number(&place)?];
    Ok(Value::Number(Number::Binary(arithmetic, Box::new(numbers))))
}

fn named(name: &str, span: &Range<usize>) -> Result<Value, FilterError> {
    if let Some(fact) = Fact::of_name(name) {
        return Ok(Value::Condition(Condition::Fact(fact)));
    }
    for (foreign, sign) in [("and", "&&"), ("or", "||"), ("not", "!")] {
        if name == foreign {
            return Err(FilterError::expected(span, &format!("'{name}'"), &format!("'{sign}'")));
        }
    }
    let quantity = Quantity::of_name(name).ok_or_else(|| FilterError::unknown(span, name))?;
    Ok(Value::Number(Number::Quantity(quantity, span.clone())))
}

fn coordinate(found: &Token, span: &Range<usize>) -> Result<Coordinate, FilterError> {
    let names: Vec<&str> = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).collect();
    let is_meant = |coordinate: &&Coordinate| *found == Token::Name(coordinate.name().to_owned());
    let known = || format!("a coordinate of keys: {}", names.join(" "));
    Coordinate::ALL
        .iter()
        .find(is_meant)
        .copied()
        .ok_or_else(|| FilterError::expected(span, &found.described(), &known()))
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
