//! Layouts that give the origin another share of a key.

use formats::key::{Bit, Coordinate, Extent, LayoutError, LayoutText, Method, Termination};

use Coordinate::{OriginX, OriginY, OriginZ};

/// The coordinates of a method's origin, and those of its direction or end point, in the order of their first
/// mention; `None` if it has not both, or a curve, a number or `^`.
fn parts(method: &Method) -> Option<[Vec<Coordinate>; 2]> {
    let layout =
        method.layout.expand(Extent::NOTHING).ok().filter(|layout| !layout.uses(Coordinate::needs_light))?;
    let mut parts = [Vec::new(), Vec::new()];
    for coordinate in layout.bits().iter().map(Bit::coordinate) {
        let coordinate = coordinate?;
        let part = &mut parts[usize::from(!matches!(coordinate, OriginX | OriginY | OriginZ))];
        if !part.contains(&coordinate) {
            part.push(coordinate);
        }
    }
    let has_both = parts.iter().all(|part| !part.is_empty());
    has_both.then_some(parts)
}

/// Whether a method has an origin and something else whose shares can be changed.
pub fn can_split(method: &Method) -> bool {
    parts(method).is_some()
}

/// The method with keys of `key_bits` bits, `origin_bits` of which are the origin's: bits of the two parts in turn,
/// as evenly as the numbers allow, the larger part first. `None` if it cannot be split, or the key has fewer
/// bits.
///
/// # Errors
/// If a coordinate would have more bits than there are.
pub fn split(method: &Method, origin_bits: u32, key_bits: u32) -> Option<Result<Method, LayoutError>> {
    let [origin, other] = parts(method)?;
    let rest = key_bits.checked_sub(origin_bits)?;
    let (larger, smaller, of_larger) =
        if origin_bits >= rest { (origin, other, origin_bits) } else { (other, origin, rest) };
    let (mut larger, mut smaller) = (larger.iter().cycle(), smaller.iter().cycle());
    let before = |place: u32| (place * of_larger).div_ceil(key_bits);
    let word = |place: u32| {
        let part = if before(place + 1) > before(place) { &mut larger } else { &mut smaller };
        part.next().map_or("", |coordinate| coordinate.name())
    };
    let words: Vec<&str> = (0..key_bits).map(word).collect();
    let name = format!("{}-split-{origin_bits}-{rest}", method.name);
    let of_origin_alone = rest == 0;
    let termination = if of_origin_alone { Termination::Unused } else { method.termination };
    Some(LayoutText::parse(&words.join(" ")).map(|layout| Method { name, layout, termination }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(method: &str, origin_bits: u32, key_bits: u32) -> String {
        let method = Method::builtin(method).unwrap();
        split(&method, origin_bits, key_bits).unwrap().unwrap().layout.text().to_owned()
    }

    #[test]
    fn bits_of_both_parts_come_in_turn_and_the_larger_part_first() {
        assert_eq!(text("octahedron", 4, 8), "ox u oy v oz u ox v");
        assert_eq!(text("octahedron", 6, 8), "ox oy oz u ox oy oz v");
        assert_eq!(text("octahedron", 2, 8), "u v u ox v u v oy");
        assert_eq!(text("reis", 0, 8), "theta phi theta phi theta phi theta phi");
        assert_eq!(text("two-point", 8, 8), "ox oy oz ox oy oz ox oy");
        assert_eq!(text("two-point", 5, 8), "ox oy ex oz ox ey oy ez");
    }

    #[test]
    fn every_split_has_as_many_bits_as_it_says() {
        for method in ["reis", "costa", "aila", "octahedron", "two-point", "paraboloid"] {
            for origin_bits in 0..=32 {
                let text = text(method, origin_bits, 32);
                let words: Vec<&str> = text.split(' ').collect();
                let of_origin = words.iter().filter(|word| word.starts_with('o')).count();
                assert_eq!((words.len(), of_origin), (32, origin_bits as usize), "{method}: {text}");
            }
        }
    }

    #[test]
    fn what_has_one_part_alone_cannot_be_split() {
        for method in ["origin", "light-octahedron", "hilbert-origin", "hilbert-two-point", "two-point-xor"] {
            let method = Method::builtin(method).unwrap();
            assert!(!can_split(&method) && split(&method, 4, 32).is_none(), "{}", method.name);
        }
        let octahedron = Method::builtin("octahedron").unwrap();
        assert!(split(&octahedron, 33, 32).is_none());
        assert!(split(&octahedron, 4, 64).unwrap().is_err(), "60 bits of two coordinates");
    }
}
