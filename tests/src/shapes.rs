//! Closed surfaces as lists of triangles.

/// Three corners.
pub type Triangle = [[f32; 3]; 3];

/// Moves and scales every corner; corners that were equal stay equal.
pub fn placed(triangles: &[Triangle], scale: f32, centre: [f32; 3]) -> Vec<Triangle> {
    let place = |corner: [f32; 3]| [0, 1, 2].map(|axis| corner[axis] * scale + centre[axis]);
    triangles.iter().map(|triangle| triangle.map(place)).collect()
}

/// A closed surface around the origin, a grid of longitudes and latitudes. `radius` gives the distance of
/// the corner on a ring and a segment.
pub fn globe(rings: u32, segments: u32, radius: impl Fn(u32, u32) -> f64) -> Vec<Triangle> {
    let point = |ring: u32, segment: u32| {
        let segment = segment % segments;
        let is_pole = ring == 0 || ring == rings;
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        let azimuth = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
        let size = radius(ring, if is_pole { 0 } else { segment });
        let sine = if is_pole { 0.0 } else { polar.sin() };
        [sine * azimuth.cos(), polar.cos(), sine * azimuth.sin()].map(|x| (x * size) as f32)
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b] = [point(ring, segment), point(ring, segment + 1)];
            let [c, d] = [point(ring + 1, segment), point(ring + 1, segment + 1)];
            triangles.extend((ring > 0).then_some([a, b, c]));
            triangles.extend((ring + 1 < rings).then_some([b, d, c]));
        }
    }
    triangles
}

/// A closed sphere of radius 1.
pub fn sphere(rings: u32) -> Vec<Triangle> {
    globe(rings, 2 * rings, |_, _| 1.0)
}

/// A closed box, its faces cut along the given coordinates of each axis, ascending.
pub fn cut_box(cuts: [&[f32]; 3]) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let [along, up] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [cuts[axis][0], cuts[axis][cuts[axis].len() - 1]] {
            let corner = |i: usize, j: usize| {
                let mut corner = [side; 3];
                (corner[along], corner[up]) = (cuts[along][i], cuts[up][j]);
                corner
            };
            for i in 0..cuts[along].len() - 1 {
                for j in 0..cuts[up].len() - 1 {
                    let [a, b] = [corner(i, j), corner(i + 1, j)];
                    let [c, d] = [corner(i, j + 1), corner(i + 1, j + 1)];
                    triangles.extend([[a, b, d], [a, d, c]]);
                }
            }
        }
    }
    triangles
}

/// A closed cube from −1 to 1, each face of 2·n² triangles.
pub fn cube(n: u32) -> Vec<Triangle> {
    let cuts: Vec<f32> = (0..=n).map(|place| 2.0 * place as f32 / n as f32 - 1.0).collect();
    cut_box([&cuts; 3])
}
