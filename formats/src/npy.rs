//! NPY headers and element types: what lets NumPy open and memory-map a dump's arrays.
//!
//! A header is written in one way only (version 1.0, keys in NumPy's order, padded with blanks so
//! that the data starts at a multiple of 64 bytes), so that a reader can compare it byte by byte.
//! Parsing also takes what NumPy itself would write (versions 2.0 and 3.0, other padding).

use bytemuck::{Pod, Zeroable};

use crate::length_table::LengthCell;
use crate::ray::{Hit, Ray, Work};
use crate::text::shown;

/// Data of every array starts at a multiple of this many bytes.
pub const DATA_ALIGNMENT: usize = 64;
/// No header of a dump comes near this many bytes; a longer one is refused before it is read.
pub const HEADER_BYTES_MAX: usize = 4096;
/// Most dimensions of an array.
pub const DIMENSIONS_MAX: usize = 4;

const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// The element types of a dump, all little-endian and without gaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dtype {
    /// 32-bit float.
    F4,
    /// 32-bit unsigned integer.
    U4,
    /// 64-bit unsigned integer.
    U8,
    /// 8-bit unsigned integer.
    U1,
    /// [`Ray`].
    Ray,
    /// [`Hit`].
    Hit,
    /// [`Work`].
    Work,
    /// [`LengthCell`].
    Cell,
    /// [`MaterialMask`].
    Mask,
}

impl Dtype {
    /// Every element type.
    pub const ALL: [Self; 9] =
        [Self::F4, Self::U4, Self::U8, Self::U1, Self::Ray, Self::Hit, Self::Work, Self::Cell, Self::Mask];

    /// NumPy's description: a type string, or for records the list of fields as Python writes it.
    pub fn descr(self) -> &'static str {
        match self {
            Self::F4 => "<f4",
            Self::U4 => "<u4",
            Self::U8 => "<u8",
            Self::U1 => "|u1",
            Self::Ray => {
                "[('origin', '<f4', (3,)), ('t_min', '<f4'), ('direction', '<f4', (3,)), ('t_max', '<f4')]"
            }
            Self::Hit => "[('t', '<f4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4')]",
            Self::Work => "[('nodes', '<u4'), ('triangles', '<u4')]",
            Self::Cell => "[('cell', '<u4'), ('count', '<u4'), ('sum', '<u8')]",
            Self::Mask => "[('texture', '<u4'), ('cutoff', '<f4')]",
        }
    }

    /// The type with this description, if a dump can hold it.
    pub fn from_descr(descr: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|dtype| dtype.descr() == descr)
    }

    /// The description as it stands in a header.
    fn literal(self) -> String {
        match self.descr() {
            list if list.starts_with('[') => list.to_owned(),
            simple => format!("'{simple}'"),
        }
    }

    /// Size of one element in bytes.
    pub fn bytes(self) -> u64 {
        let bytes = match self {
            Self::F4 | Self::U4 => 4,
            Self::U8 => 8,
            Self::U1 => 1,
            Self::Ray => size_of::<Ray>(),
            Self::Hit => size_of::<Hit>(),
            Self::Work => size_of::<Work>(),
            Self::Cell => size_of::<LengthCell>(),
            Self::Mask => size_of::<MaterialMask>(),
        };
        bytes as u64
    }
}

impl std::fmt::Display for Dtype {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.descr())
    }
}

/// Where a material's alpha comes from and where it makes holes; 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MaterialMask {
    /// Number of the alpha texture (`scene/mask-NNN.npy`); [`MaterialMask::NO_TEXTURE`] for none.
    pub texture: u32,
    /// Texels whose alpha byte is below this times 255, rounded, are holes; without a texture the
    /// byte is 255. 0 for a material without a mask.
    pub cutoff: f32,
}

impl MaterialMask {
    /// The cutoff of a material that is all holes: more than the byte of any texel.
    pub const CUTOFF_MAX: f32 = 256.0 / 255.0;
    /// The texture number of a material without an alpha texture.
    pub const NO_TEXTURE: u32 = u32::MAX;

    /// Whether the cutoff is one that some byte of a texel could be held against.
    pub fn is_valid(&self) -> bool {
        (0.0..=Self::CUTOFF_MAX).contains(&self.cutoff)
    }
}

/// Values that a mapped array can be read as.
pub trait Element: Pod {
    /// The element type on disk.
    const DTYPE: Dtype;
    /// How many of them make one value: the last dimension of the array; 1 for any shape.
    const COLUMNS: u64 = 1;
}

macro_rules! elements {
    ($($type:ty => $dtype:ident),* $(,)?) => { $(impl Element for $type { const DTYPE: Dtype = Dtype::$dtype; })* };
}

elements!(f32 => F4, u32 => U4, u64 => U8, u8 => U1, Ray => Ray, Hit => Hit, Work => Work, LengthCell => Cell, MaterialMask => Mask);

impl<const N: usize> Element for [f32; N] {
    const DTYPE: Dtype = Dtype::F4;
    const COLUMNS: u64 = N as u64;
}

impl<const N: usize> Element for [u32; N] {
    const DTYPE: Dtype = Dtype::U4;
    const COLUMNS: u64 = N as u64;
}

impl<const N: usize> Element for [u8; N] {
    const DTYPE: Dtype = Dtype::U1;
    const COLUMNS: u64 = N as u64;
}

/// What an NPY header says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NpyHeader {
    /// Element type.
    pub dtype: Dtype,
    /// Lengths of the dimensions, slowest first (C order).
    pub shape: Vec<u64>,
    /// Where the data starts, bytes from the start of the file.
    pub data_offset: usize,
}

/// Why bytes are not an NPY header that a dump can hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each message says what it and its fields mean")]
pub enum NpyError {
    #[error("the file does not start with NumPy's magic bytes")]
    Magic,
    #[error("NPY version {major}.{minor} is unknown; expected 1.0, 2.0 or 3.0")]
    Version { major: u8, minor: u8 },
    #[error("the NPY header says it is {expected} bytes long, but only {found} were found")]
    Truncated { found: usize, expected: usize },
    #[error("the NPY header says it is {found} bytes long; expected at most {HEADER_BYTES_MAX}")]
    TooLong { found: usize },
    #[error("the NPY header is not a dictionary of plain characters, as NumPy writes it")]
    Text,
    #[error("the NPY header's '{key}' is missing or wrong; expected {expected}")]
    Entry { key: &'static str, expected: &'static str },
    #[error("the element type {} is none that a recording holds{}", shown(found), remedy(found))]
    Dtype { found: String },
}

/// What to do about an element type that NumPy makes where nothing else is asked for.
fn remedy(found: &str) -> &'static str {
    match found {
        "<f8" => "; numpy's .astype('<f4') makes floats of 32 bits",
        "<i8" | "<i4" | "<u8" => "; numpy's .astype('<u4') makes indices of 32 bits",
        _ => "",
    }
}

/// Bytes of an array's data; `None` if they do not fit an `u64`.
pub fn data_bytes(dtype: Dtype, shape: &[u64]) -> Option<u64> {
    shape.iter().try_fold(dtype.bytes(), |bytes, &length| bytes.checked_mul(length))
}

/// The header that a dump's array of this type and shape starts with, byte for byte.
pub fn header(dtype: Dtype, shape: &[u64]) -> Vec<u8> {
    let shape = match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    };
    let text = format!("{{'descr': {}, 'fortran_order': False, 'shape': {shape}, }}", dtype.literal());
    let prefix = MAGIC.len() + 4;
    let total = (prefix + text.len() + 1).next_multiple_of(DATA_ALIGNMENT);
    let mut bytes = Vec::with_capacity(total);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&[1, 0]);
    bytes.extend_from_slice(&((total - prefix) as u16).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(total - 1, b' ');
    bytes.push(b'\n');
    bytes
}

/// Parses the header at the start of `bytes`, which may go on beyond it.
///
/// # Errors
/// Anything that is not an NPY header of an element type of [`Dtype`] in C order.
pub fn parse_header(bytes: &[u8]) -> Result<NpyHeader, NpyError> {
    let truncated = |expected| NpyError::Truncated { found: bytes.len(), expected };
    if !bytes.starts_with(MAGIC) {
        return Err(NpyError::Magic);
    }
    let &[major, minor] = bytes.get(6..8).ok_or(truncated(8))? else { return Err(truncated(8)) };
    let (start, length) = match (major, minor) {
        (1, 0) => {
            let length = bytes.get(8..10).and_then(|length| length.try_into().ok()).ok_or(truncated(10))?;
            (10, usize::from(u16::from_le_bytes(length)))
        }
        (2 | 3, 0) => {
            let length = bytes.get(8..12).and_then(|length| length.try_into().ok()).ok_or(truncated(12))?;
            (12, u32::from_le_bytes(length) as usize)
        }
        _ => return Err(NpyError::Version { major, minor }),
    };
    let data_offset = start + length;
    if data_offset > HEADER_BYTES_MAX {
        return Err(NpyError::TooLong { found: data_offset });
    }
    let text = bytes.get(start..data_offset).ok_or(truncated(data_offset))?;
    let (dtype, shape) = parse_dictionary(text)?;
    Ok(NpyHeader { dtype, shape, data_offset })
}

/// Element type and shape of a dictionary. No text in one that a dump can hold has blanks, brackets, commas or
/// colons, so that it can be cut at these.
fn parse_dictionary(text: &[u8]) -> Result<(Dtype, Vec<u64>), NpyError> {
    if !text.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace()) {
        return Err(NpyError::Text);
    }
    let text = without_blanks(&String::from_utf8_lossy(text)).replace('"', "'");
    let items = text.strip_prefix('{').and_then(|text| text.strip_suffix('}')).ok_or(NpyError::Text)?;
    let mut depth = 0;
    let items = items.split(|character| {
        depth += i32::from(matches!(character, '(' | '[')) - i32::from(matches!(character, ')' | ']'));
        character == ',' && depth == 0
    });
    let entries: Vec<(&str, &str)> = items.filter_map(|item| item.split_once(':')).collect();
    let entry = |key: &'static str, expected| {
        let mut found = entries.iter().filter(|(name, _)| name.trim_matches('\'') == key);
        match (found.next(), found.next()) {
            (Some((_, value)), None) => Ok(*value),
            _ => Err(NpyError::Entry { key, expected }),
        }
    };
    let descr = entry("descr", "a type string or a list of fields")?;
    let dtype = Dtype::ALL.into_iter().find(|dtype| without_blanks(&dtype.literal()) == descr);
    let dtype = dtype.ok_or_else(|| NpyError::Dtype { found: descr.trim_matches('\'').to_owned() })?;
    let expected = "False (numpy.ascontiguousarray puts an array in that order)";
    if entry("fortran_order", expected)? != "False" {
        return Err(NpyError::Entry { key: "fortran_order", expected });
    }
    let expected = "a tuple of at most 4 lengths";
    let shape = parse_shape(entry("shape", expected)?);
    Ok((dtype, shape.ok_or(NpyError::Entry { key: "shape", expected })?))
}

fn without_blanks(text: &str) -> String {
    text.replace(|character: char| character.is_ascii_whitespace(), "")
}

/// The lengths in a tuple such as `(3,)`.
fn parse_shape(tuple: &str) -> Option<Vec<u64>> {
    let lengths = tuple.strip_prefix('(')?.strip_suffix(')')?;
    let lengths = lengths.strip_suffix(',').unwrap_or(lengths);
    let lengths = lengths.split(',').filter(|_| !lengths.is_empty());
    let shape: Vec<u64> = lengths.map(|length| length.parse().ok()).collect::<Option<_>>()?;
    (shape.len() <= DIMENSIONS_MAX).then_some(shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_those_of_numpy() {
        // Written by numpy.lib.format.write_array_header_1_0 for an array of shape (2, 3), '<f4'.
        let expected =
            b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
        let found = header(Dtype::F4, &[2, 3]);
        assert_eq!(&found[..expected.len()], expected);
        assert_eq!(found.len(), 128);
        assert!(found[expected.len()..127].iter().all(|&byte| byte == b' '));
        assert_eq!(found[127], b'\n');
    }

    #[test]
    fn every_type_and_shape_comes_back() {
        for dtype in Dtype::ALL {
            for shape in [&[][..], &[0], &[5], &[u64::MAX], &[7, 3], &[1, 2, 3], &[1, 2, 3, 4]] {
                let bytes = header(dtype, shape);
                assert_eq!(bytes.len() % DATA_ALIGNMENT, 0);
                assert!(bytes.len() < HEADER_BYTES_MAX);
                let expected = NpyHeader { dtype, shape: shape.to_vec(), data_offset: bytes.len() };
                assert_eq!(parse_header(&bytes), Ok(expected), "{dtype} {shape:?}");
            }
        }
    }

    #[test]
    fn sizes_follow_from_the_descriptions() {
        for dtype in Dtype::ALL {
            let fields = dtype.descr().split("), (").map(|field| {
                let size = field.chars().find(char::is_ascii_digit).and_then(|digit| digit.to_digit(10));
                let columns = if field.contains("(3,)") { 3 } else { 1 };
                u64::from(size.unwrap()) * columns
            });
            let bytes: u64 = fields.sum();
            assert_eq!(dtype.bytes(), bytes, "{dtype}");
        }
    }

    #[test]
    fn data_sizes_that_overflow_are_none() {
        assert_eq!(data_bytes(Dtype::Ray, &[3]), Some(96));
        assert_eq!(data_bytes(Dtype::F4, &[]), Some(4));
        assert_eq!(data_bytes(Dtype::F4, &[u64::MAX, 2]), None);
        assert_eq!(data_bytes(Dtype::Ray, &[1 << 60]), None);
    }

    #[test]
    fn what_numpy_writes_otherwise_is_read_too() {
        let text =
            "{'shape': (3,), 'fortran_order': False, 'descr': [('nodes', '<u4'), ('triangles', '<u4')]}\n";
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
        let header = parse_header(&bytes).unwrap();
        assert_eq!((header.dtype, header.shape), (Dtype::Work, vec![3]));
    }

    #[test]
    fn each_fault_has_its_error() {
        let wrap = |text: &str| {
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend_from_slice(&(text.len() as u16).to_le_bytes());
            bytes.extend_from_slice(text.as_bytes());
            bytes
        };
        let cases: [(Vec<u8>, &str); 15] = [
            (b"NUMPY".to_vec(), "magic"),
            (b"\x93NUMPY\x07\x00".to_vec(), "version 7.0"),
            (b"\x93NUMPY\x01\x00\x76".to_vec(), "only 9"),
            (b"\x93NUMPY\x01\x00\x76\x00{'descr'".to_vec(), "only 18"),
            (b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(), "4294967307 bytes long"),
            (wrap("{'descr': '<f4', 'fortran_order': True, 'shape': (3,)}"), "ascontiguousarray"),
            (wrap("{'descr': '>f4', 'fortran_order': False, 'shape': (3,)}"), "type >f4"),
            (wrap("{'descr': '<f8', 'fortran_order': False, 'shape': (3,)}"), ".astype('<f4')"),
            (wrap("{'descr': '<f4', 'fortran_order': False, 'shape': (-3,)}"), "'shape'"),
            (wrap("{'shape': (3,), 'fortran_order': False, 'shape': (3,)}"), "'descr'"),
            (wrap("{'descr': '<f4', 'fortran_order': False, 'shape': (3,), 'shape': (3,)}"), "'shape'"),
            (wrap("('descr': '<f4', 'fortran_order': False, 'shape': (3,))"), "not a dictionary"),
            (wrap("{'descr': '\u{1b}[2J', 'fortran_order': False, 'shape': (3,)}"), "plain characters"),
            (wrap("{'descr': '<f4', 'fortran_order': False, 'shape': 3}"), "'shape'"),
            (wrap("{'descr': '<f4', 'fortran_order': False, 'shape': (1,1,1,1,1)}"), "'shape'"),
        ];
        for (bytes, part) in cases {
            let message = parse_header(&bytes).unwrap_err().to_string();
            assert!(message.contains(part), "{message}: expected {part}");
        }
    }

    #[test]
    fn no_changed_byte_makes_the_parser_panic() {
        let original = header(Dtype::Ray, &[12345, 3]);
        for at in 0..original.len() {
            for value in [0, b'(', b'\'', b'9', 0xff, original[at] ^ 1] {
                let mut bytes = original.clone();
                bytes[at] = value;
                let _ = parse_header(&bytes);
                let _ = parse_header(&bytes[..at]);
            }
        }
    }
}
