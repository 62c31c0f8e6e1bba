//! How recordings are analysed.

use clap::ValueEnum;

/// Rays of a group: as many as a GPU traces together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum GroupWidth {
    /// A warp.
    #[value(name = "32")]
    Rays32,
    /// The default.
    #[default]
    #[value(name = "64")]
    Rays64,
    /// Two of them.
    #[value(name = "128")]
    Rays128,
}

impl GroupWidth {
    /// How many rays.
    pub fn rays(self) -> usize {
        match self {
            Self::Rays32 => 32,
            Self::Rays64 => 64,
            Self::Rays128 => 128,
        }
    }
}

/// How deep to look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// At what the manifests say: times and the cache model. Takes no time.
    #[default]
    Manifest,
    /// At the arrays as well: capsules, direction spread, lanes, length tables. Reads all of them.
    Arrays,
}

/// How recordings are analysed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AnalysisOptions {
    /// Rays of a group.
    pub group_width: GroupWidth,
    /// Threads; as many as there are processors if `None`.
    pub threads: Option<usize>,
    /// How deep to look.
    pub depth: Depth,
}
