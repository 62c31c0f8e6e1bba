//! What layouts number: the lights of a scene, the tiles of a picture.

/// How much there is to number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Lights of the scene.
    pub lights: usize,
    /// Width and height of the picture in pixels; rays that came without one lie in a single row.
    pub picture: [u32; 2],
}

impl Extent {
    /// For layouts that number nothing.
    pub const NOTHING: Self = Self { lights: 0, picture: [0, 0] };

    /// Whether rays have a picture whose tiles they could be of.
    pub fn has_picture(&self) -> bool {
        self.picture[0] > 0 && self.picture[1] > 1
    }
}

/// ⌈log2 count⌉: the bits that number so many things.
pub fn index_bits(count: u64) -> u32 {
    u64::BITS - count.max(1).saturating_sub(1).leading_zeros()
}

/// A picture cut into tiles, which are numbered row by row from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// Width and height of a tile in pixels, at least 1; those at the right and at the bottom may be cut.
    pub tile: [u32; 2],
    /// Width of the picture in pixels, at least 1.
    pub width: u32,
}

impl Tiles {
    /// Tiles in a row.
    pub fn across(&self) -> u32 {
        self.width.div_ceil(self.tile[0])
    }

    /// Bits of the number of a tile, for a picture of so many rows.
    pub fn bits(&self, height: u32) -> u32 {
        index_bits(u64::from(self.across()) * u64::from(height.div_ceil(self.tile[1])))
    }

    /// Number of the tile in which the pixel of a path lies; at most the path's own.
    #[inline(always)]
    pub fn number(&self, path: u32) -> u32 {
        let (x, y) = (path % self.width, path / self.width);
        y / self.tile[1] * self.across() + x / self.tile[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_bits_as_the_numbers_need() {
        for (count, expected) in [(0, 0), (1, 0), (2, 1), (3, 2), (4, 2), (5, 3), (1024, 10), (1025, 11)] {
            assert_eq!(index_bits(count), expected, "{count}");
        }
        assert_eq!(index_bits(u64::MAX), 64);
    }

    #[test]
    fn tiles_are_numbered_row_by_row() {
        // 3 × 2 tiles, the last column and row cut.
        let tiles = Tiles { tile: [4, 3], width: 10 };
        let number = |x: u32, y: u32| tiles.number(y * 10 + x);
        assert_eq!([number(0, 0), number(3, 2), number(4, 0), number(9, 2)], [0, 0, 1, 2]);
        assert_eq!([number(0, 3), number(7, 4), number(8, 4)], [3, 4, 5]);
        assert_eq!((tiles.bits(5), tiles.bits(3), tiles.bits(1)), (3, 2, 2));
    }

    #[test]
    fn a_tile_has_no_larger_number_than_its_paths() {
        for tile in [[1, 1], [u32::MAX, 1], [1, u32::MAX]] {
            for width in [1, 2, u32::MAX] {
                for path in [0, 5, u32::MAX] {
                    assert!(Tiles { tile, width }.number(path) <= path, "{tile:?} of {width}: {path}");
                }
            }
        }
    }
}
