//! Which arrays a recording keeps, and of which passes.

use formats::manifest::check::{ALL_PASSES, KEEP_WORDS, MEASURED_PASS};

use super::error::OptionError;

/// Passes whose arrays are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum KeepPasses {
    /// The last one, in which methods are measured.
    #[value(name = MEASURED_PASS)]
    Measured,
    /// Every one.
    #[value(name = ALL_PASSES)]
    All,
}

impl KeepPasses {
    /// Its word on the command line and in manifests.
    pub fn word(self) -> &'static str {
        match self {
            Self::Measured => MEASURED_PASS,
            Self::All => ALL_PASSES,
        }
    }
}

/// Arrays that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Rays, path indices, lights of shadow rays.
    pub rays: bool,
    /// Hits and distances.
    pub hits: bool,
    /// Keys.
    pub keys: bool,
    /// Permutations.
    pub permutations: bool,
    /// Length tables.
    pub lengths: bool,
    /// Geometry.
    pub scene: bool,
    /// The picture.
    pub image: bool,
    /// What the cache model says.
    pub caches: bool,
    /// Work counters.
    pub work: bool,
    /// The hierarchy.
    pub hierarchy: bool,
    /// What the paths of closest rays carry.
    pub throughput: bool,
}

impl Keep {
    fn flag(&mut self, word: &str) -> Option<&mut bool> {
        Some(match word {
            "rays" => &mut self.rays,
            "hits" => &mut self.hits,
            "keys" => &mut self.keys,
            "permutations" => &mut self.permutations,
            "lengths" => &mut self.lengths,
            "scene" => &mut self.scene,
            "image" => &mut self.image,
            "caches" => &mut self.caches,
            "work" => &mut self.work,
            "hierarchy" => &mut self.hierarchy,
            "throughput" => &mut self.throughput,
            _ => return None,
        })
    }

    /// From a comma-separated list; `none` for nothing.
    ///
    /// # Errors
    /// An unknown word, or `none` beside others.
    pub fn parse(list: &str) -> Result<Self, OptionError> {
        let mut keep = Self::default();
        if list.trim() == "none" {
            return Ok(keep);
        }
        for word in list.split(',').map(str::trim) {
            if word == "none" {
                return Err(OptionError::conflict("--keep: 'none' stands alone; leave it or the arrays out"));
            }
            *keep.flag(word).ok_or_else(|| OptionError::Keep { word: word.to_owned() })? = true;
        }
        Ok(keep)
    }

    /// The words for what is kept, in the order in which they are listed.
    pub fn words(mut self) -> Vec<String> {
        let kept = KEEP_WORDS.into_iter().filter(|word| self.flag(word).is_some_and(|flag| *flag));
        kept.map(str::to_owned).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keep_lists() {
        assert_eq!(Keep::parse("rays,work").unwrap().words(), ["rays", "work"]);
        assert_eq!(Keep::parse("none").unwrap(), Keep::default());
        assert!(Keep::parse("none,rays").unwrap_err().to_string().contains("'none' stands alone"));
        assert!(Keep::parse("rays,picture").unwrap_err().to_string().contains("'picture'"));
    }
}
