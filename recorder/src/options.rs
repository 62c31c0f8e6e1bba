//! What a recording was asked for, with presets and defaults filled in.

use std::path::PathBuf;

use formats::key::method::{BUILTIN, UNSORTED};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS, Method, MethodError};
use formats::length_table::{TABLE_BITS_MAX, TABLE_BITS_MIN};
use formats::manifest::check::{BOUNCES_MAX, KEEP_WORDS, PASSES_MAX, REPEATS_MAX};

use crate::stages::trace::TraceKernel;

/// Where to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BackendChoice {
    /// A hardware GPU that passes the self-check, else the CPU.
    Auto,
    /// A GPU; a software adapter if there is no other.
    Gpu,
    /// Native threads.
    Cpu,
}

/// Passes whose arrays are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum KeepPasses {
    /// The last one, in which methods are measured.
    Measured,
    /// Every one.
    All,
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
}

impl Keep {
    /// The words of `--keep`, in the order in which they are listed.
    pub const WORDS: [&'static str; 9] = KEEP_WORDS;

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
            _ => return None,
        })
    }

    /// From a comma-separated list; `none` for nothing.
    ///
    /// # Errors
    /// An unknown word.
    pub fn parse(list: &str) -> Result<Self, OptionError> {
        let mut keep = Self::default();
        for word in list.split(',').map(str::trim).filter(|word| *word != "none") {
            *keep.flag(word).ok_or_else(|| OptionError::Keep { word: word.to_owned() })? = true;
        }
        Ok(keep)
    }

    /// The words for what is kept.
    pub fn words(&self) -> Vec<String> {
        let mut copy = *self;
        Self::WORDS
            .iter()
            .filter(|word| copy.flag(word).is_some_and(|flag| *flag))
            .map(|&word| word.to_owned())
            .collect()
    }
}

/// Everything that `recorder record` was asked for.
#[derive(Clone, Debug)]
pub struct RecordOptions {
    /// File or `builtin:NAME`.
    pub scene: String,
    /// Where the dump goes.
    pub out: PathBuf,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Bounces.
    pub bounces: u32,
    /// Passes.
    pub passes: u32,
    /// Timed repeats.
    pub repeats: u32,
    /// Seed.
    pub seed: u64,
    /// Camera by name; the scene's first if not given.
    pub camera: Option<String>,
    /// Methods to measure beside the baseline.
    pub methods: Vec<Method>,
    /// Width of keys.
    pub key_bits: u32,
    /// Length of the plain two-point method, unit lengths.
    pub two_point_length: f32,
    /// Address bits of the length tables.
    pub table_bits: u32,
    /// Method that addresses them.
    pub table_method: Method,
    /// Where to run.
    pub backend: BackendChoice,
    /// Adapter by part of its name.
    pub adapter: Option<String>,
    /// Trace kernel.
    pub trace: TraceKernel,
    /// Threads of the CPU backend; all cores if not given.
    pub threads: Option<usize>,
    /// Arrays to keep.
    pub keep: Keep,
    /// Bytes of the second level of the cache model.
    pub l2_bytes: u64,
    /// Passes to keep them of.
    pub keep_passes: KeepPasses,
    /// Whether dark paths end by chance.
    pub russian_roulette: bool,
    /// Whether an existing recording may be replaced.
    pub force: bool,
}

/// An option that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionError {
    /// An unknown word in `--keep`.
    #[error("--keep: there is no array '{word}'; there are {}, and 'none'", Keep::WORDS.join(", "))]
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
    /// A table method that needs a length or a light.
    #[error(
        "--table-method: '{name}' cannot address the length table, since its key needs a length or a light; use origin, reis, costa, aila or octahedron"
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

/// The methods of `--methods` and of every `--method`.
///
/// # Errors
/// Unknown or repeated names, wrong layouts.
pub fn parse_methods(list: &str, own: &[String]) -> Result<Vec<Method>, OptionError> {
    let mut methods: Vec<Method> = Vec::new();
    let mut add = |method: Method| {
        if methods.iter().any(|known| known.name == method.name) {
            return Err(OptionError::MethodTwice { name: method.name });
        }
        methods.push(method);
        Ok(())
    };
    for name in list.split(',').map(str::trim) {
        match name {
            "all" => BUILTIN.iter().try_for_each(|(name, ..)| add(Method::builtin(name)?))?,
            UNSORTED | "" => {}
            _ => add(Method::builtin(name)?)?,
        }
    }
    own.iter().try_for_each(|definition| add(Method::from_user(definition)?))?;
    Ok(methods)
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

impl RecordOptions {
    /// Checks everything that can be judged without opening a file or a device.
    ///
    /// # Errors
    /// The first option that makes no sense.
    pub fn check(&self) -> Result<(), OptionError> {
        in_range("width", self.width, 1, 1 << 16)?;
        in_range("height", self.height, 1, 1 << 16)?;
        self.check_run()?;
        self.check_device()
    }

    /// Checks what is run, but for the size of the picture.
    ///
    /// # Errors
    /// The first option that makes no sense.
    pub fn check_run(&self) -> Result<(), OptionError> {
        in_range("bounces", self.bounces, 1, BOUNCES_MAX)?;
        in_range("passes", self.passes, 1, PASSES_MAX)?;
        in_range("repeats", self.repeats, 1, REPEATS_MAX)?;
        in_range("key-bits", self.key_bits, KEY_BITS_MIN, LAYOUT_BITS)?;
        in_range("two-point-length", self.two_point_length, 0.0, 2.0)?;
        check_table(self.table_bits, &self.table_method)?;
        let additions =
            u64::from(self.width) * u64::from(self.height) * u64::from(self.bounces) * u64::from(self.passes);
        if additions >= 1 << 32 {
            let message = format!(
                "{} × {} rays over {} bounces and {} passes could add {additions} lengths to one cell of the length table, whose count ends at 2^32; ask for less",
                self.width, self.height, self.bounces, self.passes
            );
            return Err(OptionError::Conflict { message });
        }
        Ok(())
    }

    /// Checks where it runs.
    ///
    /// # Errors
    /// The first option that makes no sense.
    pub fn check_device(&self) -> Result<(), OptionError> {
        in_range("l2-kib", self.l2_bytes >> 10, 64, 1 << 20)?;
        if let Some(threads) = self.threads {
            in_range("threads", threads, 1, 4096)?;
        }
        if self.backend == BackendChoice::Cpu && self.trace == TraceKernel::RayQuery {
            let message = "--trace ray-query needs a GPU that has ray queries; use --backend gpu, or --trace cwbvh or bvh2".to_owned();
            return Err(OptionError::Conflict { message });
        }
        if self.backend == BackendChoice::Cpu && self.adapter.is_some() {
            let message =
                "--adapter names a GPU, but --backend cpu asks for threads; leave one of them out".to_owned();
            return Err(OptionError::Conflict { message });
        }
        Ok(())
    }
}

/// Checks what the length tables are addressed by.
///
/// # Errors
/// Too few or too many bits, or a method whose key needs more than the ray.
pub fn check_table(bits: u32, method: &Method) -> Result<(), OptionError> {
    in_range("table-bits", bits, TABLE_BITS_MIN, TABLE_BITS_MAX)?;
    let can = method.can_address_table();
    can.then_some(()).ok_or_else(|| OptionError::TableMethod { name: method.name.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn method_lists() {
        let names = |list: &str, own: &[&str]| -> Vec<String> {
            let own: Vec<String> = own.iter().map(|&text| text.to_owned()).collect();
            parse_methods(list, &own).unwrap().into_iter().map(|method| method.name).collect()
        };
        assert_eq!(names("all", &[]).len(), BUILTIN.len());
        assert_eq!(names("unsorted", &[]), Vec::<String>::new());
        assert_eq!(names("aila, costa", &["mine=(ox oy oz)*4"]), ["aila", "costa", "mine"]);
        assert!(matches!(parse_methods("aila,aila", &[]), Err(OptionError::MethodTwice { .. })));
        assert!(matches!(parse_methods("nope", &[]), Err(OptionError::Method(MethodError::Unknown { .. }))));
    }

    #[test]
    fn keep_lists() {
        assert_eq!(Keep::parse("rays,work").unwrap().words(), ["rays", "work"]);
        assert_eq!(Keep::parse("none").unwrap(), Keep::default());
        assert!(Keep::parse("rays,picture").unwrap_err().to_string().contains("'picture'"));
    }
}
