//! What hostile bytes are put through: any bytes at all by the fuzz targets, those worth keeping by
//! the test `corpus`. Each function panics if something is wrong with our code.
#![allow(clippy::unwrap_used, reason = "this is test code, although not in test functions")]
#![allow(
    dead_code,
    unused_imports,
    reason = "every test and fuzz target compiles it anew and uses its own share"
)]

mod dump;
mod queue;
mod tiny;

use std::path::Path;

use formats::key::decode::decode;
use formats::key::{
    Encoder, Extent, Facts, LAYOUT_BITS, LayoutError, LayoutText, LightSite, Method, MethodError,
};
use formats::manifest::scan::scan_bytes;
use formats::manifest::{FRAME_BYTES, Manifest, PREAMBLE_BYTES, encode_frame, preamble};
use formats::npy::{self, HEADER_BYTES_MAX};
use formats::ray::Ray;
use formats::summary::Summary;
use formats::unit_space::UnitSpace;

pub(crate) use dump::{dump, sample, use_everything};
pub(crate) use queue::queue;

/// Longest message that is still one sentence.
const SENTENCE_BYTES_MAX: usize = 3 * HEADER_BYTES_MAX;

/// Asserts that a message can stand in one line of a terminal.
#[track_caller]
pub(crate) fn assert_sentence(message: &str) {
    assert!(!message.is_empty() && !message.chars().any(char::is_control), "{message:?}");
    assert!(message.len() <= SENTENCE_BYTES_MAX, "{} bytes: {message}", message.len());
}

/// The records of a manifest.
pub(crate) fn manifest(bytes: &[u8]) {
    scan_and_compare(bytes);
    scan_and_compare(&with_right_checksums(bytes));
}

/// What can be read is what was written, byte for byte.
fn scan_and_compare(bytes: &[u8]) {
    let path = Path::new("manifest.bin");
    let scan = match scan_bytes(bytes, bytes.len() as u64, path) {
        Ok(scan) => scan,
        Err(error) => return assert_sentence(&error.to_string()),
    };
    let mut offset = PREAMBLE_BYTES as u64;
    for frame in &scan.frames {
        assert_eq!(frame.offset, offset);
        let found = &bytes[frame.offset as usize..frame.end as usize];
        assert!(encode_frame(&frame.record).unwrap() == found, "{:?}", frame.record);
        offset = frame.end;
    }
    match &scan.fault {
        Some(fault) => assert_sentence(&fault.to_string()),
        None => assert_eq!(offset, bytes.len() as u64),
    }
    if let Some(manifest) = Manifest::of(scan) {
        serde_json::to_string(&Summary::new(path, &manifest)).unwrap();
    }
}

/// The bytes after a right preamble, with the checksum that each record should have: no damage is
/// found by its checksum then.
pub(crate) fn with_right_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut mended = preamble().to_vec();
    let mut rest = bytes.get(PREAMBLE_BYTES..).unwrap_or_default();
    while let Some((frame, after)) = rest.split_first_chunk::<FRAME_BYTES>() {
        let [l0, l1, l2, l3, ..] = *frame;
        let length = after.len().min(u32::from_le_bytes([l0, l1, l2, l3]) as usize);
        mended.extend((length as u32).to_le_bytes());
        mended.extend(crc32c::crc32c(&after[..length]).to_le_bytes());
        mended.extend(&after[..length]);
        rest = &after[length..];
    }
    mended.extend(rest);
    mended
}

/// The header of an NPY file.
pub(crate) fn npy_header(bytes: &[u8]) {
    parse_npy_header(bytes);
    let mut wrapped = b"\x93NUMPY\x01\x00".to_vec();
    wrapped.extend((bytes.len() as u16).to_le_bytes());
    wrapped.extend(bytes);
    parse_npy_header(&wrapped);
}

fn parse_npy_header(bytes: &[u8]) {
    match npy::parse_header(bytes) {
        Ok(header) => {
            assert!(header.data_offset <= bytes.len());
            let again = npy::parse_header(&npy::header(header.dtype, &header.shape)).unwrap();
            assert_eq!((again.dtype, again.shape), (header.dtype, header.shape));
        }
        Err(error) => assert_sentence(&error.to_string()),
    }
}

/// The text of a layout, and keys made by it.
pub(crate) fn layout(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match LayoutText::parse(&text) {
        Ok(parsed) => encode_by(&parsed),
        Err(error) => assert_points_at(&error, &text),
    }
    match Method::from_user(&text) {
        Ok(method) => encode_by(&method.layout),
        Err(MethodError::Layout { cause, .. }) => assert_points_at(&cause, cause.text.as_str()),
        Err(_) => {}
    }
}

fn assert_points_at(error: &LayoutError, text: &str) {
    assert_sentence(&error.message);
    assert!(error.length >= 1 && error.start + error.length <= text.chars().count().max(1), "{error:?}");
    assert_eq!(error.text, text);
    assert!(error.to_string().contains('^'));
}

/// Rays that no tracer makes, among others.
fn odd_rays() -> [Ray; 4] {
    let ray = Ray { origin: [0.25; 3], t_min: 0.0, direction: [0.6, 0.0, -0.8], t_max: f32::INFINITY };
    [
        ray,
        Ray { origin: [f32::NAN, f32::INFINITY, -0.0], ..ray },
        Ray { direction: [f32::NEG_INFINITY, f32::NAN, f32::MAX], t_max: f32::NAN, ..ray },
        Ray { direction: [0.0; 3], t_max: -1.0, ..ray },
    ]
}

fn encode_by(text: &LayoutText) {
    let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
    for (lights, picture) in [(1, [8, 8]), (3, [u32::MAX; 2]), (300, [1, 1])] {
        let sites = vec![LightSite::Placed { centre: [0.5; 3] }; lights];
        // With more lights than one, a coordinate may get more bits than it has.
        let Ok(layout) = text.expand(Extent { lights, picture }) else { continue };
        assert!((1..=LAYOUT_BITS as usize).contains(&layout.bits().len()));
        for key_bits in [8, 33, LAYOUT_BITS] {
            let encoder = Encoder::new(&layout, key_bits, unit, &sites);
            for ray in odd_rays() {
                let key =
                    encoder.encode(&ray, Facts { length: 0.25, light: lights as u32 - 1, path: u32::MAX });
                let fields = decode(&layout, key_bits, key);
                let bits: u32 = fields.iter().map(|field| field.bits).sum();
                assert_eq!(bits, key_bits.min(layout.bits().len() as u32));
            }
        }
    }
}
