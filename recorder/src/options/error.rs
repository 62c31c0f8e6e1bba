//! Options that make no sense, in words that say what would.

use formats::key::MethodError;
use formats::manifest::check::KEEP_WORDS;

/// An option that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionError {
    /// An unknown word in `--keep`.
    #[error("--keep: there is no array '{word}'; there are {}, and 'none'", KEEP_WORDS.join(", "))]
    Keep {
        /// What was typed.
        word: String,
    },
    /// A number out of its range.
    #[error("--{option} is {found}, expected {expected}")]
    Range {
        /// Option without its dashes.
        option: &'static str,
        /// What was typed.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// A method that cannot be had.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The same method twice.
    #[error("method '{name}' is asked for twice")]
    MethodTwice {
        /// Its name.
        name: String,
    },
    /// A table method that needs a length, a light or a picture.
    #[error(
        "--table-method: '{name}' cannot address the length table, since its key needs a length, a light or a picture; use origin, reis, costa, aila or octahedron"
    )]
    TableMethod {
        /// Its name.
        name: String,
    },
    /// A combination of options that excludes itself.
    #[error("{message}")]
    Conflict {
        /// What is wrong and what to do.
        message: String,
    },
}

impl OptionError {
    /// Options that exclude each other: what is wrong and what to do.
    pub fn conflict(message: impl Into<String>) -> Self {
        Self::Conflict { message: message.into() }
    }
}

/// Checks that a number lies in a range.
///
/// # Errors
/// If it does not.
pub fn in_range<T: PartialOrd + std::fmt::Display>(
    option: &'static str,
    value: T,
    min: T,
    max: T,
) -> Result<T, OptionError> {
    if value >= min && value <= max {
        return Ok(value);
    }
    Err(OptionError::Range { option, found: value.to_string(), expected: format!("{min} to {max}") })
}
