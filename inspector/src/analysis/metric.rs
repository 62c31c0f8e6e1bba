//! A number, or why there is none.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::shown;

/// A number that some recordings cannot give. In JSON: the number, or `{"missing": "why"}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Metric<T> {
    /// The number.
    Known(T),
    /// There is none.
    Missing {
        /// Why, in a sentence without its full stop.
        missing: String,
    },
}

impl<T> Metric<T> {
    /// No number, for this reason.
    pub fn missing(reason: impl Display) -> Self {
        Self::Missing { missing: shown::sentence(reason.to_string()) }
    }

    /// The same of what is known.
    pub fn map<U>(self, of: impl FnOnce(T) -> U) -> Metric<U> {
        match self {
            Self::Known(value) => Metric::Known(of(value)),
            Self::Missing { missing } => Metric::Missing { missing },
        }
    }

    /// The number, if there is one.
    pub fn known(&self) -> Option<&T> {
        match self {
            Self::Known(value) => Some(value),
            Self::Missing { .. } => None,
        }
    }

    /// Why there is none, if so.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Known(_) => None,
            Self::Missing { missing } => Some(missing),
        }
    }
}

impl<T, E: Display> From<Result<T, E>> for Metric<T> {
    fn from(result: Result<T, E>) -> Self {
        result.map_or_else(Self::missing, Self::Known)
    }
}
