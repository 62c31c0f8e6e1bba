//! The coordinates that keys are made of, in f64, spelled out from docs/keys.md; shares no code with the encoder.

use formats::key::LightSite;
use formats::ray::Ray;

/// A scene's bounding box, world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
}

impl Bounds {
    fn extent(&self, axis: usize) -> f64 {
        f64::from(self.max[axis]) - f64::from(self.min[axis])
    }

    fn scale(&self) -> f64 {
        match (0..3).map(|axis| self.extent(axis)).fold(0.0, f64::max) {
            0.0 => 1.0,
            largest => 1.0 / largest,
        }
    }

    fn point(&self, world: [f32; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| (f64::from(world[axis]) - f64::from(self.min[axis])) * self.scale())
    }

    /// Where a ray leaves the box, unit lengths.
    fn exit(&self, ray: &Ray) -> f64 {
        let o = self.point(ray.origin);
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for (axis, &o) in o.iter().enumerate() {
            let (d, side) = (f64::from(ray.direction[axis]), self.extent(axis) * self.scale());
            if d == 0.0 {
                if o < 0.0 || o > side {
                    return 0.0;
                }
                continue;
            }
            near = near.max((-o / d).min((side - o) / d));
            far = far.min((-o / d).max((side - o) / d));
        }
        if far < near { 0.0 } else { far }
    }
}

fn octahedral(d: [f64; 3]) -> [f64; 2] {
    let sum = d[0].abs() + d[1].abs() + d[2].abs();
    if sum == 0.0 {
        return [0.5; 2];
    }
    let (x, y) = (d[0] / sum, d[1] / sum);
    let sign = |v: f64| if v > 0.0 { 1.0 } else { -1.0 };
    let (u, v) = if d[2] < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [(u + 1.0) / 2.0, (v + 1.0) / 2.0]
}

/// What a shadow ray looks like from its light.
fn seen(o: [f64; 3], d: [f64; 3], light: &LightSite) -> [f64; 3] {
    match *light {
        LightSite::Placed { centre } => {
            let v: [f64; 3] = std::array::from_fn(|axis| o[axis] - f64::from(centre[axis]));
            let [a, b] = octahedral(v);
            [a, b, v.iter().map(|x| x * x).sum::<f64>().sqrt() / 3f64.sqrt()]
        }
        LightSite::Directional { direction, tangent, bitangent } => [tangent, bitangent, direction]
            .map(|axis| ((0..3).map(|i| o[i] * f64::from(axis[i])).sum::<f64>() / 3f64.sqrt() + 1.0) / 2.0),
        LightSite::Environment => {
            let [a, b] = octahedral(d);
            [a, b, 0.0]
        }
    }
}

/// The value of a coordinate, in [0, 1] where it is in range. `length` is the estimate, unit lengths.
pub(crate) fn coordinate(name: &str, bounds: &Bounds, ray: &Ray, length: f64, light: &LightSite) -> f64 {
    let o = bounds.point(ray.origin);
    let d: [f64; 3] = std::array::from_fn(|axis| f64::from(ray.direction[axis]));
    let length = length.min(bounds.exit(ray)).min(f64::from(ray.t_max) * bounds.scale()).clamp(0.0, 1.75);
    match name {
        "ox" => o[0],
        "oy" => o[1],
        "oz" => o[2],
        // The point is stepped from a cell of the box.
        "ex" => o[0].clamp(0.0, 1.0) + length * d[0],
        "ey" => o[1].clamp(0.0, 1.0) + length * d[1],
        "ez" => o[2].clamp(0.0, 1.0) + length * d[2],
        "dx" => (d[0] + 1.0) / 2.0,
        "dy" => (d[1] + 1.0) / 2.0,
        "dz" => (d[2] + 1.0) / 2.0,
        "u" => octahedral(d)[0],
        "v" => octahedral(d)[1],
        "pu" => d[0] / (d[2].abs() + 1.0) / 4.0 + if d[2] < 0.0 { 0.25 } else { 0.75 },
        "pv" => d[1] / (d[2].abs() + 1.0) / 2.0 + 0.5,
        "theta" if d[0] == 0.0 && d[1] == 0.0 => 0.5,
        "theta" => d[1].atan2(d[0]) / (2.0 * std::f64::consts::PI) + 0.5,
        "phi" => d[2].clamp(-1.0, 1.0).acos() / std::f64::consts::PI,
        "lu" => seen(o, d, light)[0],
        "lv" => seen(o, d, light)[1],
        "lr" => seen(o, d, light)[2],
        other => panic!("no coordinate {other}"),
    }
}

/// How many bits of a coordinate mean something after rounding: the termination point is stepped in
/// factors rounded to 2^-15; all else is f32.
pub(crate) fn error_bits(name: &str) -> i32 {
    if name.starts_with('e') { 13 } else { 19 }
}
