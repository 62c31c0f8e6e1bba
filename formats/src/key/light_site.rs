//! Where a light is, as far as keys need to know.

use serde::Serialize;

/// How a light lies in unit space. Shadow rays carry the index of their light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightSite {
    /// A light with a place.
    Placed {
        /// Its centre in unit space.
        centre: [f32; 3],
    },
    /// Parallel light.
    Directional {
        /// Unit vector in which it shines.
        direction: [f32; 3],
        /// Unit vector across it.
        tangent: [f32; 3],
        /// Unit vector across both.
        bitangent: [f32; 3],
    },
    /// Light from everywhere.
    Environment,
}

impl LightSite {
    /// A directional light with the basis of Duff et al., "Building an Orthonormal Basis,
    /// Revisited" (JCGT 2017).
    pub fn directional(direction: [f32; 3]) -> Self {
        let [x, y, z] = direction;
        let sign = 1.0f32.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        Self::Directional {
            direction,
            tangent: [1.0 + sign * x * x * a, sign * b, -sign * x],
            bitangent: [b, sign + y * y * a, -y],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_orthonormal() {
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for d in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [0.48, 0.64, 0.6]] {
            let LightSite::Directional { direction, tangent, bitangent } = LightSite::directional(d) else {
                panic!("not directional");
            };
            for (a, b, expected) in [
                (direction, tangent, 0.0),
                (direction, bitangent, 0.0),
                (tangent, bitangent, 0.0),
                (tangent, tangent, 1.0),
                (bitangent, bitangent, 1.0),
            ] {
                assert!((dot(a, b) - expected).abs() < 1e-6, "{d:?}");
            }
        }
    }
}
