//! The picture in which a queue's rays have their places: the image plane, or rows of rays that have none.

/// Largest side of a picture: what every GPU can show, in 64 MiB.
const LARGEST_SIDE: u32 = 4096;

/// Farthest that a path may be from what is pointed at, pixels, however many of them a point stands for.
const FARTHEST: i64 = 64;

/// Which pixel of an image plane, or which path of a recording without one, is shown where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImagePlane {
    width: u32,
    height: u32,
    /// Pixels along each side of a point of the picture: 1 unless it would be too large.
    step: u32,
}

impl ImagePlane {
    /// Of a recording of so many columns and rows of pixels. Imported rays have no image plane
    /// (`recorder import` gives them a single row): they fill the rows of a square, in the order of their file.
    pub fn of(columns: u32, rows: u32) -> Self {
        let [width, height] = match [columns.max(1), rows.max(1)] {
            [rays, 1] => {
                let width = f64::from(rays).sqrt().ceil() as u32;
                [width, rays.div_ceil(width)]
            }
            size => size,
        };
        Self { width, height, step: width.max(height).div_ceil(LARGEST_SIDE) }
    }

    /// Columns and rows of the picture.
    pub fn size(self) -> [usize; 2] {
        [self.width, self.height].map(|side| side.div_ceil(self.step) as usize)
    }

    /// Column and row at which a path is shown; `None` if it starts outside the picture.
    pub fn point(self, path: u32) -> Option<[u32; 2]> {
        let [column, row] = [path % self.width, path / self.width];
        (row < self.height).then_some([column / self.step, row / self.step])
    }

    /// The paths that start near a point of the picture, the nearest first: within so many points, and no more
    /// than [`FARTHEST`] pixels.
    pub fn near(self, [column, row]: [u32; 2], reach: u32) -> impl Iterator<Item = u32> {
        let step = i64::from(self.step);
        let reach = (i64::from(reach) * step).min(FARTHEST);
        let middle = [column, row].map(|at| i64::from(at) * step + step / 2);
        let mut near: Vec<(i64, i64)> =
            (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))).collect();
        near.sort_by_key(|(x, y)| x * x + y * y);
        let (width, height) = (i64::from(self.width), i64::from(self.height));
        let pixels = near.into_iter().map(move |(x, y)| (middle[0] + x, middle[1] + y));
        let inside = pixels.filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y));
        inside.filter_map(move |(x, y)| u32::try_from(y * width + x).ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_shown_where_they_are() {
        let plane = ImagePlane::of(640, 360);
        assert_eq!(plane.size(), [640, 360]);
        assert_eq!(plane.point(641), Some([1, 1]));
        assert_eq!(plane.point(640 * 360), None);
        assert_eq!(plane.near([1, 1], 0).collect::<Vec<_>>(), [641]);
        assert_eq!(plane.near([0, 0], 1).collect::<Vec<_>>(), [0, 1, 640, 641]);
    }

    #[test]
    fn rays_without_an_image_plane_fill_a_square() {
        let plane = ImagePlane::of(100_000, 1);
        assert_eq!(plane.size(), [317, 316]);
        assert_eq!(plane.point(99_999), Some([99_999 % 317, 99_999 / 317]));
        assert_eq!(ImagePlane::of(1, 1).size(), [1, 1]);
        assert_eq!(ImagePlane::of(0, 0).size(), [1, 1]);
        assert_eq!(ImagePlane::of(u32::MAX, 1).size(), [4096, 4096]);
    }

    #[test]
    fn no_picture_is_too_large() {
        let plane = ImagePlane::of(16_384, 1000);
        assert_eq!(plane.size(), [4096, 250]);
        for path in [0, 5, 16_383, 16_384 * 999 + 16_383] {
            let point = plane.point(path).unwrap();
            assert!(plane.near(point, 1).any(|near| near == path), "{path} is not near {point:?}");
        }
        let [columns, rows] = ImagePlane::of(u32::MAX, u32::MAX).size();
        assert!(columns <= 4096 && rows <= 4096, "{columns} x {rows}");
    }
}
