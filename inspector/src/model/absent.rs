//! Why something is not shown.

use std::fmt;

use crate::shown;

/// Why something is not shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Absent {
    /// Another thread is reading or making it.
    Awaited,
    /// It cannot be had, for this reason.
    Impossible(String),
}

impl fmt::Display for Absent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Awaited => f.write_str("it is being read"),
            Self::Impossible(reason) => f.write_str(reason),
        }
    }
}

impl From<Absent> for String {
    fn from(absent: Absent) -> Self {
        absent.to_string()
    }
}

impl From<&str> for Absent {
    fn from(reason: &str) -> Self {
        Self::from(reason.to_owned())
    }
}

impl From<String> for Absent {
    fn from(reason: String) -> Self {
        Self::Impossible(shown::sentence(reason))
    }
}

impl From<&String> for Absent {
    fn from(reason: &String) -> Self {
        Self::from(reason.clone())
    }
}
