//! Perceptual colour maps: polynomials, looked up in tables.

use std::sync::LazyLock;

/// A map from 0..1 to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColourMap {
    /// Dark blue over green to yellow; for any colour vision.
    #[default]
    Viridis,
    /// Blue to yellow; made for colour-blind eyes.
    Cividis,
    /// All hues: tells neighbours apart, at the price of an even lightness. Without its nearly black ends.
    Turbo,
    /// Black over purple to white.
    Magma,
    /// Blue over grey to red, for ratios: grey is no change. After ColorBrewer's RdBu, grey in its middle to be seen
    /// on white.
    BlueRed,
}

/// Colours of a map, on the CPU and in shaders.
pub const STEPS: usize = 256;

/// The colours of each map from 0 to 1.
static TABLES: LazyLock<[[[u8; 3]; STEPS]; ColourMap::ALL.len()]> = LazyLock::new(|| {
    ColourMap::ALL.map(|map| std::array::from_fn(|at| map.of_polynomials(at as f64 / (STEPS - 1) as f64)))
});

impl ColourMap {
    /// All maps.
    pub const ALL: [Self; 5] = [Self::Viridis, Self::Cividis, Self::Turbo, Self::Magma, Self::BlueRed];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Turbo => "turbo",
            Self::Magma => "magma",
            Self::BlueRed => "blue-red",
        }
    }

    /// Place in [`ColourMap::ALL`].
    pub fn row(self) -> usize {
        self as usize
    }

    /// The colours from 0 to 1; sRGB.
    pub fn colours(self) -> &'static [[u8; 3]; STEPS] {
        &TABLES[self.row()]
    }

    /// The colour at `at`, which is cut to 0..1; sRGB. Below 0 and NaN are the first colour.
    pub fn colour(self, at: f32) -> [u8; 3] {
        // The conversion makes 0 of what is below it and of NaN.
        self.colours()[((at * (STEPS - 1) as f32).round() as usize).min(STEPS - 1)]
    }

    fn of_polynomials(self, at: f64) -> [u8; 3] {
        let polynomials = match self {
            Self::Viridis => &VIRIDIS,
            Self::Cividis => &CIVIDIS,
            Self::Turbo => &TURBO,
            Self::Magma => &MAGMA,
            Self::BlueRed => return between(&BLUE_RED, at),
        };
        let at = if self == Self::Turbo { 0.08 + 0.86 * at } else { at };
        polynomials.map(|polynomial| {
            let value = polynomial.iter().rev().fold(0.0, |sum, factor| sum * at + factor);
            (value.clamp(0.0, 1.0) * 255.0).round() as u8
        })
    }
}

/// Colours at equal distances from 0 to 1.
const BLUE_RED: [[u8; 3]; 5] =
    [[0x21, 0x66, 0xac], [0x67, 0xa9, 0xcf], [0xc0, 0xc0, 0xc0], [0xef, 0x8a, 0x62], [0xb2, 0x18, 0x2b]];

fn between(stops: &[[u8; 3]; 5], at: f64) -> [u8; 3] {
    let place = at.clamp(0.0, 1.0) * 4.0;
    let first = (place as usize).min(3);
    std::array::from_fn(|part| {
        let [low, high] = [stops[first][part], stops[first + 1][part]].map(f64::from);
        (low + (place - first as f64) * (high - low)).round() as u8
    })
}

/// Factors of at⁰ to at⁶ for red, green and blue.
type Polynomials = [[f64; 7]; 3];

/// Fitted to matplotlib's maps by Zucker (2019, shadertoy WlfXRN, public domain).
const VIRIDIS: Polynomials = [
    [0.277_727_33, 0.105_093_04, -0.330_861_83, -4.634_230_5, 6.228_269_94, 4.776_385_0, -5.435_455_86],
    [0.005_407_34, 1.404_613_53, 0.214_847_56, -5.799_100_97, 14.179_933_4, -13.745_145_4, 4.645_852_61],
    [0.334_099_81, 1.384_590_16, 0.095_095_16, -19.332_440_96, 56.690_552_6, -65.353_032_63, 26.312_435_25],
];

/// Fitted by Zucker, as above.
const MAGMA: Polynomials = [
    [-0.002_136_49, 0.251_660_54, 8.353_717_28, -27.668_733_1, 52.176_139_8, -50.768_525_4, 18.655_705_07],
    [-0.000_749_66, 0.677_523_24, -3.577_719_51, 14.264_730_8, -27.943_606_1, 29.046_582_8, -11.489_773_5],
    [-0.005_386_13, 2.494_026_6, 0.314_467_9, -13.649_213_2, 12.944_169_4, 4.234_153_0, -5.601_961_51],
];

/// Fitted by Mikhailov and others at Google (2019, Apache-2.0); lighter than the table at its dark end.
const TURBO: Polynomials = [
    [0.135_721_38, 4.615_392_6, -42.660_322_58, 132.131_082_34, -152.942_393_96, 59.286_379_43, 0.0],
    [0.091_402_61, 2.194_188_39, 4.842_966_58, -14.185_033_33, 4.277_298_57, 2.829_566_04, 0.0],
    [0.106_673_3, 12.641_946_08, -60.582_048_36, 110.362_767_71, -89.903_109_12, 27.348_249_73, 0.0],
];

/// Fitted to the map of Nuñez, Anderton and Renslow (2018) by Bostock (d3-scale-chromatic), of 255.
const CIVIDIS: Polynomials = [
    of_255([-4.54, -35.34, 2381.73, -6402.7, 7024.72, -2710.57]),
    of_255([32.49, 170.73, 52.82, -131.46, 176.58, -67.37]),
    of_255([81.24, 442.36, -2482.43, 6167.24, -6614.94, 2475.67]),
];

const fn of_255(factors: [f64; 6]) -> [f64; 7] {
    let mut scaled = [0.0; 7];
    let mut at = 0;
    while at < factors.len() {
        scaled[at] = factors[at] / 255.0;
        at += 1;
    }
    scaled
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First, middle and last colour of the published tables; of Turbo those at 0.08, 0.51 and 0.94.
    #[test]
    fn maps_are_the_published_ones() {
        let published = [
            (ColourMap::Viridis, [[68, 1, 84], [33, 145, 140], [253, 231, 37]]),
            (ColourMap::Cividis, [[0, 34, 78], [125, 124, 120], [253, 234, 69]]),
            (ColourMap::Turbo, [[66, 75, 181], [169, 251, 57], [169, 22, 1]]),
            (ColourMap::Magma, [[0, 0, 4], [183, 55, 121], [252, 253, 191]]),
        ];
        for (map, colours) in published {
            // Turbo's polynomials are fitted less closely.
            let tolerance = if map == ColourMap::Turbo { 20 } else { 8 };
            for (at, expected) in [0.0, 0.5, 1.0].into_iter().zip(colours) {
                for (found, expected) in map.colour(at).into_iter().zip(expected) {
                    assert!(found.abs_diff(expected) <= tolerance, "{map:?} at {at}: {:?}", map.colour(at));
                }
            }
        }
    }

    #[test]
    fn no_change_is_grey_and_sides_are_blue_and_red() {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|at| ColourMap::BlueRed.colour(at));
        assert!(middle.iter().all(|part| part.abs_diff(0xc0) <= 1), "{middle:?}");
        assert!(low[2] > low[0] && high[0] > high[2], "{low:?} {high:?}");
    }

    #[test]
    fn what_is_no_number_has_a_colour_too() {
        for map in ColourMap::ALL {
            assert_eq!(map.colour(f32::NAN), map.colour(0.0));
            assert_eq!(map.colour(7.0), map.colour(1.0));
            assert_eq!(ColourMap::ALL[map.row()], map);
        }
    }
}
