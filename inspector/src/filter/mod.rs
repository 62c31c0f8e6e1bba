//! Filters: which rays are shown, as an expression that is typed, `bounce == 2 && length < 0.1`.
//!
//! - `token`, `parse`: from text to a checked tree; [`error`]: what is wrong, where, and what was meant
//! - `tree`: what a filter is made of, and its operators
//! - [`evaluate`]: the rays of an order that pass

pub mod error;
pub mod evaluate;
mod parse;
mod token;
mod tree;

use std::sync::Arc;

pub use self::error::FilterError;
pub use self::evaluate::{FilteredRays, Passing, passing};
pub use self::parse::Expression;

/// What a filter may contain besides the names of quantities: word, and what it is.
pub const WORDS: [(&str, &str); 6] = [
    ("hit", "whether a surface was hit"),
    ("shadow", "whether it is a shadow ray"),
    ("field(NAME)", "whole number of a coordinate's bits in the key: field(ex)"),
    ("abs(…), log2(…)", "absolute value, logarithm"),
    ("< <= > >= == !=", "compare numbers; what a ray does not have is equal to nothing"),
    ("&& || ! ( ) + - * /", "and, or, not, brackets, arithmetic; 0x1f is a number too"),
];

/// The filter as it is being typed. While the text is wrong, what was right before stays in force.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    text: String,
    in_force: Option<Arc<Expression>>,
    error: Option<FilterError>,
}

impl Filter {
    /// The text as it was typed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What rays must meet; all pass if `None`.
    pub fn in_force(&self) -> Option<&Arc<Expression>> {
        self.in_force.as_ref()
    }

    /// What is wrong with the text, if anything is.
    pub fn error(&self) -> Option<&FilterError> {
        self.error.as_ref()
    }

    /// Another text; an empty one lets all rays pass.
    pub fn set(&mut self, text: &str) {
        if self.text == text {
            return;
        }
        text.clone_into(&mut self.text);
        self.error = None;
        if text.trim().is_empty() {
            self.in_force = None;
            return;
        }
        match Expression::parse(text) {
            Ok(expression) => self.in_force = Some(Arc::new(expression)),
            Err(error) => self.error = Some(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_right_stays_in_force() {
        let mut filter = Filter::default();
        filter.set("length < 0.5");
        filter.set("length < ");
        assert!(filter.error().is_some());
        assert_eq!(filter.in_force().unwrap().text(), "length < 0.5");
        filter.set(" ");
        assert_eq!((filter.error(), filter.in_force()), (None, None));
    }
}
