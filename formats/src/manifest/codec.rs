//! A record as bytes, and back: bincode 2, fixed-width integers, little-endian.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use bincode::de::{BorrowDecoder, Decoder};
use bincode::enc::Encoder;
use bincode::error::{DecodeError, EncodeError};
use bincode::{BorrowDecode, Decode, Encode};

use super::{FORMAT_VERSION, FRAME_BYTES, Place, RECORD_BYTES_MAX, Record};
use crate::key::{LightSite, Termination};
use crate::npy::Dtype;
use crate::ray::Kind;
use crate::text::shown;

/// Kinds of records that a version of the format knows: the first variants of [`Record`].
pub(super) fn record_kinds(version: u32) -> u32 {
    match version {
        ..3 => 7,
        3 => 9,
        _ => 11,
    }
}

/// Most records are shorter than this. What the decoded values may take, lists with false lengths
/// included, is bounded by the length of the record: a short one cannot ask for much memory.
const SHORT_BYTES_MAX: usize = 64 << 10;
/// Records of this many bytes have a bound between that of short ones and that of the longest.
const MIDDLING_BYTES_MAX: usize = 4 << 20;
/// How many times its bytes a value may take: lists of texts need three, all others fewer.
const EXPANSION: usize = 4;

const fn configuration<const BYTES: usize>() -> Configuration<LittleEndian, Fixint, Limit<BYTES>> {
    bincode::config::standard().with_fixed_int_encoding().with_limit::<BYTES>()
}

/// A record with its length and checksum before it, as it is appended to a manifest.
///
/// # Errors
/// If the record is longer than [`RECORD_BYTES_MAX`]; the length found is given.
pub fn encode_frame(record: &Record) -> Result<Vec<u8>, usize> {
    let mut frame = vec![0; FRAME_BYTES];
    let written = bincode::encode_into_std_write(
        record,
        &mut frame,
        configuration::<{ EXPANSION * RECORD_BYTES_MAX }>(),
    );
    let length = frame.len() - FRAME_BYTES;
    if written.is_err() || length > RECORD_BYTES_MAX {
        return Err(length);
    }
    let checksum = crc32c::crc32c(&frame[FRAME_BYTES..]);
    frame[..4].copy_from_slice(&(length as u32).to_le_bytes());
    frame[4..8].copy_from_slice(&checksum.to_le_bytes());
    Ok(frame)
}

/// The record that these bytes are, all of them.
///
/// # Errors
/// What is wrong with them, as a phrase.
pub(super) fn decode(payload: &[u8]) -> Result<Record, String> {
    const SHORT: usize = EXPANSION * SHORT_BYTES_MAX;
    const MIDDLING: usize = EXPANSION * MIDDLING_BYTES_MAX;
    const LONG: usize = EXPANSION * RECORD_BYTES_MAX;
    let decoded = if payload.len() <= SHORT_BYTES_MAX {
        bincode::decode_from_slice(payload, configuration::<SHORT>())
    } else if payload.len() <= MIDDLING_BYTES_MAX {
        bincode::decode_from_slice(payload, configuration::<MIDDLING>())
    } else {
        bincode::decode_from_slice(payload, configuration::<LONG>())
    };
    match decoded {
        Ok((record, used)) if used == payload.len() => Ok(record),
        Ok((_, used)) => Err(format!("it is {} bytes long, but its fields take {used}", payload.len())),
        Err(DecodeError::LimitExceeded) => Err("a length in it is larger than the record can hold".into()),
        Err(DecodeError::UnexpectedEnd { .. }) => Err("its fields go on after its end".into()),
        Err(DecodeError::Utf8 { .. }) => Err("a text in it is not UTF-8".into()),
        Err(DecodeError::UnexpectedVariant { found, .. }) => {
            Err(format!("format version {FORMAT_VERSION} has no choice {found} where it has one"))
        }
        Err(DecodeError::OtherString(problem)) => Err(problem),
        Err(error) => Err(error.to_string()),
    }
}

/// Encodes values that another module owns as text or as a number, so that bincode stays in here.
macro_rules! encode_as {
    ($type:ty as $wire:ty, $to:expr, $from:expr) => {
        impl Encode for $type {
            fn encode<E: Encoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
                let to: fn(&$type) -> $wire = $to;
                to(self).encode(encoder)
            }
        }

        impl<Context> Decode<Context> for $type {
            fn decode<D: Decoder<Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
                let from: fn($wire) -> Result<$type, String> = $from;
                from(<$wire>::decode(decoder)?).map_err(DecodeError::OtherString)
            }
        }

        impl<'de, Context> BorrowDecode<'de, Context> for $type {
            fn borrow_decode<D: BorrowDecoder<'de, Context = Context>>(
                decoder: &mut D,
            ) -> Result<Self, DecodeError> {
                Self::decode(decoder)
            }
        }
    };
}

encode_as!(Place as String, Place::to_string, |path| {
    Place::parse(&path).ok_or_else(|| format!("'{}' is not the path of an array", shown(&path)))
});

encode_as!(Dtype as String, |dtype| dtype.descr().to_owned(), |descr| {
    Dtype::from_descr(&descr).ok_or_else(|| format!("unknown element type '{}'", shown(&descr)))
});

encode_as!(Kind as u32, |kind| *kind as u32, |number| {
    let known = Kind::ALL.into_iter().find(|&kind| kind as u32 == number);
    known.ok_or_else(|| format!("unknown kind of queue {number}"))
});

encode_as!(Termination as u32, |termination| *termination as u32, |number| {
    let known = Termination::ALL.into_iter().find(|&termination| termination as u32 == number);
    known.ok_or_else(|| format!("unknown length estimate {number}"))
});

/// [`LightSite`] on the wire.
#[derive(Encode, Decode)]
enum WireLight {
    Placed { centre: [f32; 3] },
    Directional { direction: [f32; 3], tangent: [f32; 3], bitangent: [f32; 3] },
    Environment,
}

encode_as!(
    LightSite as WireLight,
    |light| match *light {
        LightSite::Placed { centre } => WireLight::Placed { centre },
        LightSite::Directional { direction, tangent, bitangent } => {
            WireLight::Directional { direction, tangent, bitangent }
        }
        LightSite::Environment => WireLight::Environment,
    },
    |wire| Ok(match wire {
        WireLight::Placed { centre } => LightSite::Placed { centre },
        WireLight::Directional { direction, tangent, bitangent } => {
            LightSite::Directional { direction, tangent, bitangent }
        }
        WireLight::Environment => LightSite::Environment,
    })
);
