//! What a recording was asked for, with presets and defaults filled in.

mod device;
mod error;
mod keep;

pub use device::{BackendChoice, DeviceOptions};
pub use error::{OptionError, in_range};
pub use keep::{Keep, KeepPasses};

use std::path::PathBuf;

use formats::key::method::{AUTO, BUILTIN, CONTROL, IN_ALL, SHUFFLED, UNSORTED, WITHOUT_LAYOUT};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS, Method};
use formats::length_table::{TABLE_BITS_DEFAULT, TABLE_BITS_MAX, TABLE_BITS_MIN};
use formats::manifest::check::{BOUNCES_MAX, PASSES_MAX, REPEATS_MAX};

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
    /// Radius that point lights are given, world units; none if not given.
    pub light_radius: Option<f32>,
    /// Orders to measure beside the baseline.
    pub orders: AskedOrders,
    /// Width of keys.
    pub key_bits: u32,
    /// Length of the plain two-point method, unit lengths.
    pub two_point_length: f32,
    /// Address bits of the length tables.
    pub table_bits: u32,
    /// Method that addresses them.
    pub table_method: Method,
    /// Where and how to trace.
    pub device: DeviceOptions,
    /// Arrays to keep.
    pub keep: Keep,
    /// Passes to keep them of.
    pub keep_passes: KeepPasses,
    /// Whether dark paths end by chance.
    pub russian_roulette: bool,
    /// Whether an existing recording may be replaced.
    pub force: bool,
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
            "all" => BUILTIN[..IN_ALL].iter().try_for_each(|(name, ..)| add(Method::builtin(name)?))?,
            UNSORTED => {}
            _ => add(Method::builtin(name)?)?,
        }
    }
    own.iter().try_for_each(|definition| add(Method::from_user(definition)?))?;
    Ok(methods)
}

/// The orders of `--methods` and of every `--method`.
#[derive(Clone, Debug, Default)]
pub struct AskedOrders {
    /// Those with a layout.
    pub methods: Vec<Method>,
    /// Whether the control is among them; where anything is, it is measured, and if it is asked for, listed like a
    /// method.
    pub control: bool,
    /// Whether a random order is.
    pub shuffled: bool,
    /// Whether the order that `auto` chooses is; `all` has it.
    pub auto: bool,
}

impl From<Vec<Method>> for AskedOrders {
    fn from(methods: Vec<Method>) -> Self {
        Self { methods, ..Self::default() }
    }
}

/// As [`parse_methods`], with the orders that have no layout of their own.
///
/// # Errors
/// As [`parse_methods`].
pub fn parse_orders(list: &str, own: &[String]) -> Result<AskedOrders, OptionError> {
    let names = || list.split(',').map(str::trim);
    let named: Vec<&str> = names().filter(|name| !WITHOUT_LAYOUT.contains(name)).collect();
    // Orders without a layout may be all that is asked for, a list of nothing is none.
    let named = if named.is_empty() { UNSORTED.to_owned() } else { named.join(",") };
    Ok(AskedOrders {
        methods: parse_methods(&named, own)?,
        control: names().any(|name| name == CONTROL),
        shuffled: names().any(|name| name == SHUFFLED),
        auto: names().any(|name| name == AUTO || name == "all"),
    })
}

impl RecordOptions {
    /// One pass over no scene yet, with no methods and nothing kept.
    ///
    /// # Errors
    /// None: the table's method is built in.
    pub fn base() -> Result<Self, OptionError> {
        Ok(Self {
            scene: String::new(),
            out: PathBuf::new(),
            width: 640,
            height: 360,
            bounces: 4,
            passes: 1,
            repeats: 1,
            seed: 0,
            camera: None,
            light_radius: None,
            orders: AskedOrders::default(),
            key_bits: 32,
            two_point_length: 0.25,
            table_bits: TABLE_BITS_DEFAULT,
            table_method: Method::builtin("aila")?,
            device: DeviceOptions::default(),
            keep: Keep::default(),
            keep_passes: KeepPasses::Measured,
            russian_roulette: false,
            force: false,
        })
    }

    /// Checks everything that can be judged without opening a file or a device.
    ///
    /// # Errors
    /// The first option that makes no sense.
    pub fn check(&self) -> Result<(), OptionError> {
        in_range("width", self.width, 1, 1 << 16)?;
        in_range("height", self.height, 1, 1 << 16)?;
        self.check_run()?;
        self.device.check()
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
        self.light_radius.map(|radius| in_range("light-radius", radius, 1e-9, 1e9)).transpose()?;
        check_table(self.table_bits, &self.table_method)?;
        let additions =
            u64::from(self.width) * u64::from(self.height) * u64::from(self.bounces) * u64::from(self.passes);
        if additions >= 1 << 32 {
            return Err(OptionError::conflict(format!(
                "{} × {} rays over {} bounces and {} passes could add {additions} lengths to one cell of the length table, whose count ends at 2^32; ask for less",
                self.width, self.height, self.bounces, self.passes
            )));
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
    use formats::key::MethodError;

    use super::*;

    #[test]
    fn method_lists() {
        let names = |list: &str, own: &[&str]| -> Vec<String> {
            let own: Vec<String> = own.iter().map(|&text| text.to_owned()).collect();
            parse_methods(list, &own).unwrap().into_iter().map(|method| method.name).collect()
        };
        assert_eq!(names("all", &[]).len(), IN_ALL);
        assert_eq!(names("all", &[]).last().unwrap(), "origin-light");
        assert_eq!(names("paraboloid,hilbert-origin", &[]).len(), 2);
        assert_eq!(names("unsorted", &[]), Vec::<String>::new());
        assert_eq!(names("aila, costa", &["mine=(ox oy oz)*4"]), ["aila", "costa", "mine"]);
        let asked = |list| {
            let AskedOrders { methods, control, shuffled, auto } = parse_orders(list, &[]).unwrap();
            (methods.len(), control, shuffled, auto)
        };
        assert_eq!(asked("aila, shuffled"), (1, false, true, false));
        assert_eq!(asked("all"), (IN_ALL, false, false, true));
        assert_eq!(asked("auto,aila"), (1, false, false, true));
        assert_eq!(asked("control"), (0, true, false, false));
        assert!(matches!(parse_methods("aila,aila", &[]), Err(OptionError::MethodTwice { .. })));
        assert!(matches!(parse_methods("nope", &[]), Err(OptionError::Method(MethodError::Unknown { .. }))));
    }
}
