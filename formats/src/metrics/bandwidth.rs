//! The bytes that each stage must read and write for a ray.
//!
//! What the data itself asks for, once: caches, write amplification and skipped radix passes are not in
//! it. So bytes over time is the bandwidth that a stage achieves at least (for sort: would need, if no
//! pass had a constant digit).

use crate::key::Termination;
use crate::manifest::Stage;
use crate::ray::{Hit, Kind, Ray};

/// Bytes of a canonical index.
const INDEX: u64 = 4;
/// Bytes of a cell of the length table: two words of its sum, one of its count.
const CELL: u64 = 12;
/// Bytes of a ray.
const RAY: u64 = size_of::<Ray>() as u64;
/// Bits that one radix pass sorts by.
const DIGIT_BITS: u32 = 8;

/// What the bytes of a stage depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Kind of the rays.
    pub kind: Kind,
    /// Its keys; `None` of an order without keys, or with such as differ from queue to queue.
    pub order: Option<KeyTraffic>,
}

/// What the bytes of a method's stages depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyTraffic {
    /// Bits of a key, 8 to 64; keys of up to 32 bits take 4 bytes, wider ones 8.
    pub key_bits: u32,
    /// Where the estimate of a ray's length is read from.
    pub termination: Termination,
}

impl Traffic {
    /// Bytes per ray that a stage must read and write; `None` for keys that are not known, and for stages whose bytes
    /// depend on the scene.
    ///
    /// | stage | reads | writes |
    /// |---|---|---|
    /// | key | ray (32); the cell (12) if adaptive; the result if real | key (4 or 8) |
    /// | sort, per 8 bits | key for the histogram; key and index | key and index |
    /// | gather | index, ray | ray |
    /// | trace | ray; the hierarchy is not counted | result |
    /// | scatter | index, result | result |
    /// | trace through indices | index, ray; the hierarchy is not counted | result |
    /// | accumulate | ray, result | cell (12) |
    ///
    /// A result is a hit (16) or, of shadow rays, a distance (4). At 32 bits a sort takes 80 bytes.
    pub fn bytes_per_ray(&self, stage: Stage) -> Option<u64> {
        let result = match self.kind {
            Kind::Closest => size_of::<Hit>() as u64,
            Kind::Shadow => size_of::<f32>() as u64,
        };
        match (stage, self.order) {
            (Stage::Key, Some(order)) => {
                let length = match order.termination {
                    Termination::Unused | Termination::Fixed => 0,
                    Termination::Adaptive => CELL,
                    Termination::Real => result,
                };
                Some(RAY + length + order.key_bytes())
            }
            (Stage::Sort, Some(order)) => {
                let passes = u64::from(order.key_bits.div_ceil(DIGIT_BITS));
                Some(passes * (order.key_bytes() + 2 * (order.key_bytes() + INDEX)))
            }
            (Stage::Gather, _) => Some(INDEX + 2 * RAY),
            (Stage::Trace, _) => Some(RAY + result),
            (Stage::Scatter, _) => Some(INDEX + 2 * result),
            (Stage::TraceIndirect, _) => Some(INDEX + RAY + result),
            (Stage::Accumulate, _) => Some(RAY + result + CELL),
            (Stage::Key | Stage::Sort, None) | (Stage::Generate | Stage::Shade | Stage::Decide, _) => None,
        }
    }
}

impl KeyTraffic {
    fn key_bytes(&self) -> u64 {
        if self.key_bits > 32 { 8 } else { 4 }
    }
}

/// Bytes a second, from bytes and nanoseconds; `None` for no time.
pub fn bytes_per_second(bytes: u64, elapsed_ns: f64) -> Option<f64> {
    (elapsed_ns > 0.0).then(|| bytes as f64 / elapsed_ns * 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(stage: Stage, kind: Kind, key_bits: u32, termination: Termination) -> Option<u64> {
        Traffic { kind, order: Some(KeyTraffic { key_bits, termination }) }.bytes_per_ray(stage)
    }

    #[test]
    fn bytes_by_hand() {
        use Termination::{Adaptive, Fixed, Real, Unused};
        for (stage, kind, key_bits, termination, expected) in [
            (Stage::Key, Kind::Closest, 32, Fixed, 36),
            (Stage::Key, Kind::Closest, 33, Unused, 40),
            (Stage::Key, Kind::Shadow, 16, Adaptive, 48),
            (Stage::Key, Kind::Shadow, 32, Real, 40),
            (Stage::Sort, Kind::Closest, 32, Fixed, 80),
            (Stage::Sort, Kind::Closest, 16, Fixed, 40),
            (Stage::Sort, Kind::Closest, 17, Fixed, 60),
            (Stage::Sort, Kind::Closest, 64, Fixed, 256),
            (Stage::Gather, Kind::Shadow, 32, Fixed, 68),
            (Stage::Trace, Kind::Closest, 32, Fixed, 48),
            (Stage::Scatter, Kind::Closest, 32, Fixed, 36),
            (Stage::TraceIndirect, Kind::Shadow, 32, Fixed, 40),
            (Stage::Accumulate, Kind::Closest, 32, Adaptive, 60),
        ] {
            assert_eq!(bytes(stage, kind, key_bits, termination), Some(expected), "{stage:?} {key_bits}");
        }
    }

    #[test]
    fn an_order_without_keys_is_moved_as_others_are() {
        let unsorted = Traffic { kind: Kind::Closest, order: None };
        assert_eq!(unsorted.bytes_per_ray(Stage::Trace), Some(48));
        assert_eq!(unsorted.bytes_per_ray(Stage::Gather), Some(68));
        assert_eq!(unsorted.bytes_per_ray(Stage::Sort), None);
        assert_eq!(unsorted.bytes_per_ray(Stage::Shade), None);
        assert_eq!(bytes_per_second(80, 2.0), Some(4e10));
        assert_eq!(bytes_per_second(80, 0.0), None);
    }
}
