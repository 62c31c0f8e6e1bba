//! A queue that somebody made up, through the check that stands between it and the kernels.
//!
//! Bytes become width and height (u16 each), the numbers of lights, expected rays, rays, path ids and light
//! ids, what kind of queue it is and where it is from (u8 each), the entries of these arrays as they lie
//! in files, and edits of the header's record: offset (u16), value. Bytes that are missing are 0.

use std::path::Path;

use formats::key::LightSite;
use formats::manifest::scan::scan_bytes;
use formats::manifest::{
    FRAME_BYTES, Header, PREAMBLE_BYTES, QueueId, Record, Source, encode_frame, preamble,
};
use formats::queue_check::{QueueRays, QueueRules};
use formats::ray::{Kind, Ray};

use super::dump::sample;
use super::{assert_sentence, with_right_checksums};

/// Offset and value.
const EDIT_BYTES: usize = 3;
/// How far the length of a unit vector may be from 1, and what two ways to compute it may differ by.
const UNIT_TOLERANCE: f64 = 1e-4;
const ROUNDING: f64 = 1e-9;

/// The header's own check, and that of a queue by the header.
pub(crate) fn queue(mut bytes: &[u8]) {
    let mut header = sample::header();
    let [width, height] = [next(&mut bytes), next(&mut bytes)].map(u16::from_le_bytes);
    (header.options.width, header.options.height) = (width.into(), height.into());
    let [lights, expected, rays, path_ids, light_ids, choice] = next(&mut bytes);
    header.lights.resize(lights.into(), LightSite::Environment);
    header.source = match choice / 2 % 3 {
        0 => Source::Traced,
        1 => Source::Imported { name: "rays.npy".into(), sha256: [7; 32] },
        _ => Source::Replayed { name: "sample.raydump".into(), manifest_sha256: [7; 32] },
    };
    let kind = Kind::ALL[usize::from(choice) % 2];
    let rays: Vec<Ray> = (0..rays).map(|_| bytemuck::pod_read_unaligned(&next::<32>(&mut bytes))).collect();
    let [path_ids, light_ids] = [path_ids, light_ids]
        .map(|count| (0..count).map(|_| u32::from_le_bytes(next(&mut bytes))).collect::<Vec<_>>());
    let Some(header) = edited(header, bytes) else { return };
    header.problems().iter().for_each(|problem| assert_sentence(problem));
    let queue = QueueRays { rays: &rays, path_ids: &path_ids, lights: &light_ids };
    let rules = QueueRules::new(QueueId { pass: 0, bounce: 1, kind }, &header);
    match rules.check(queue, expected.into()) {
        Ok(()) => assert!(is_right(&header, kind, queue, expected, UNIT_TOLERANCE + ROUNDING), "{queue:?}"),
        Err(fault) => {
            assert_sentence(&fault.to_string());
            assert!(
                !is_right(&header, kind, queue, expected, UNIT_TOLERANCE - ROUNDING),
                "{fault}: {queue:?}"
            );
        }
    }
}

fn next<const N: usize>(bytes: &mut &[u8]) -> [u8; N] {
    let (taken, rest) = bytes.split_at(bytes.len().min(N));
    *bytes = rest;
    let mut word = [0; N];
    word[..taken.len()].copy_from_slice(taken);
    word
}

/// The header that its record is after some edits, if it still is one.
fn edited(header: Header, edits: &[u8]) -> Option<Header> {
    if edits.is_empty() {
        return Some(header);
    }
    let mut bytes = preamble().to_vec();
    bytes.extend(encode_frame(&Record::Header(Box::new(header))).unwrap());
    let start = PREAMBLE_BYTES + FRAME_BYTES;
    for edit in edits.chunks_exact(EDIT_BYTES) {
        let at = start + usize::from(u16::from_le_bytes([edit[0], edit[1]])) % (bytes.len() - start);
        bytes[at] = edit[2];
    }
    let bytes = with_right_checksums(&bytes);
    let scan = scan_bytes(&bytes[..], bytes.len() as u64, Path::new("manifest.bin")).ok()?;
    match scan.frames.into_iter().next()?.record {
        Record::Header(header) => Some(*header),
        _ => None,
    }
}

/// The rules again, one after the other and without a word on what is wrong.
fn is_right(header: &Header, kind: Kind, queue: QueueRays<'_>, expected: u8, tolerance: f64) -> bool {
    let QueueRays { rays, path_ids, lights } = queue;
    let expected = usize::from(expected);
    let pixels = u128::from(header.options.width) * u128::from(header.options.height);
    let is_endless = kind == Kind::Closest && header.source == Source::Traced;
    let is_right_ray = |ray: &Ray| {
        let [x, y, z] = ray.direction.map(f64::from);
        ray.origin.iter().all(|along| along.is_finite())
            && (x.hypot(y).hypot(z) - 1.0).abs() <= tolerance
            && (0.0..f32::INFINITY).contains(&ray.t_min)
            && (ray.t_min..=f32::INFINITY).contains(&ray.t_max)
            && (!is_endless || ray.t_max.is_infinite())
    };
    rays.len() == expected
        && path_ids.len() == expected
        && (kind == Kind::Closest || lights.len() == expected)
        && rays.iter().all(is_right_ray)
        && path_ids.is_sorted_by(|before, after| before < after)
        && path_ids.iter().all(|&path| u128::from(path) < pixels)
        && lights.iter().all(|&light| (light as usize) < header.lights.len())
}
