//! What is wrong with a filter.

use std::ops::Range;

use formats::metrics::quantity::Quantity;
use formats::text::nearest;

use super::tree::{FACTS, FUNCTIONS};

/// What is wrong with a filter, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("character {}: {message}", start + 1)]
pub struct FilterError {
    /// What was found and what was expected.
    pub message: String,
    /// First character at fault, counted in characters from 0.
    pub start: usize,
    /// How many characters are at fault, ≥ 1.
    pub length: usize,
}

impl FilterError {
    pub(super) fn new(span: &Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), start: span.start, length: span.len().max(1) }
    }

    pub(super) fn expected(span: &Range<usize>, found: &str, expected: &str) -> Self {
        Self::new(span, format!("found {found}, expected {expected}"))
    }

    /// With the text of the filter, and marks under what is at fault.
    pub fn shown(&self, filter: &str) -> String {
        format!("{self}\n  {filter}\n  {}{}", " ".repeat(self.start), "^".repeat(self.length))
    }

    /// No quantity has this name; says which was meant.
    pub(super) fn unknown(span: &Range<usize>, name: &str) -> Self {
        let quantities = Quantity::ALL.iter().map(|quantity| quantity.name());
        let facts = FACTS.iter().map(|(name, _)| *name);
        let functions = FUNCTIONS.iter().map(|function| function.name);
        let known: Vec<&str> = quantities.chain(facts).chain(functions).chain(["field"]).collect();
        let hint = match nearest(name, &known) {
            Some(meant) => format!("did you mean '{meant}'?"),
            None => format!("there are {}", known.join(" ")),
        };
        Self::new(span, format!("found '{}', which no ray has; {hint}", name.escape_debug()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistyped_names_are_guessed() {
        for (typed, meant) in
            [("bounse", "bounce"), ("len", "length"), ("lenght", "length"), ("orign.x", "origin.x")]
        {
            let message = FilterError::unknown(&(0..1), typed).message;
            assert!(message.ends_with(&format!("did you mean '{meant}'?")), "{message}");
        }
        assert!(FilterError::unknown(&(0..1), "q").message.contains("there are place"));
    }
}
