//! Structs that the CPU and WGSL share: written once here, injected into WGSL from here.

use bytemuck::{Pod, Zeroable};

use crate::device::{Chunk, Parameters, WgslType};

/// A struct's name, size and field offsets as the CPU lays it out, and its WGSL text.
#[derive(Clone, Debug)]
pub struct SharedStruct {
    /// Name in both languages.
    pub name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Name and byte offset of every field.
    pub fields: Vec<(&'static str, usize)>,
    /// Type of every field in WGSL.
    types: Vec<&'static str>,
    /// The definition in WGSL.
    pub wgsl: String,
}

macro_rules! shared_structs {
    ($($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $ty:ty,)* })*) => {
        $($(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $ty,)* }

        impl WgslType for $name { const NAME: &'static str = stringify!($name); }

        impl $name {
            /// Layout and WGSL text.
            pub fn description() -> SharedStruct {
                let fields = vec![$((stringify!($field), std::mem::offset_of!($name, $field)),)*];
                let mut wgsl = format!("struct {} {{\n", stringify!($name));
                $(wgsl.push_str(&format!("    {}: {},\n", stringify!($field), <$ty as WgslType>::NAME));)*
                wgsl.push_str("}\n");
                let types = vec![$(<$ty as WgslType>::NAME,)*];
                SharedStruct { name: stringify!($name), size: std::mem::size_of::<$name>(), fields, types, wgsl }
            }
        })*

        /// Every shared struct.
        pub fn shared_structs() -> Vec<SharedStruct> {
            vec![$($name::description(),)*]
        }
    };
}

impl SharedStruct {
    /// `fn FUNCTION(at: u32) -> NAME`, which reads the struct from word `at` on of `array`, an
    /// `array<u32>`: for structs that lie in one buffer with something else.
    pub fn wgsl_loader(&self, function: &str, array: &str) -> String {
        let word = |component: &str, word: usize| match component {
            "u32" => format!("{array}[at + {word}u]"),
            component => format!("bitcast<{component}>({array}[at + {word}u])"),
        };
        let value = |(&(_, offset), &name): (&(&str, usize), &&str)| {
            let first = offset / size_of::<u32>();
            let Some((size, component)) = name.strip_prefix("vec").and_then(|rest| rest.split_once('<'))
            else {
                return word(name, first);
            };
            let count = size.parse().unwrap_or(0);
            let words = (first..first + count).map(|at| word(component.trim_end_matches('>'), at));
            format!("{name}({})", words.collect::<Vec<_>>().join(", "))
        };
        let values = self.fields.iter().zip(&self.types).map(value).collect::<Vec<_>>().join(",\n        ");
        format!(
            "fn {function}(at: u32) -> {0} {{\n    return {0}(\n        {values},\n    );\n}}\n",
            self.name
        )
    }
}

impl Parameters for GenerateParams {
    fn of(self, Chunk { first, count }: Chunk) -> Self {
        Self { first, count, ..self }
    }
}

impl Parameters for ShadeParams {
    fn of(self, Chunk { first, count }: Chunk) -> Self {
        Self { first, count, ..self }
    }
}

shared_structs! {
    /// What `generate` needs to know.
    pub struct GenerateParams {
        /// Camera position, world space.
        pub eye: [f32; 3],
        /// Picture width in pixels.
        pub width: u32,
        /// Viewing direction.
        pub forward: [f32; 3],
        /// Picture height in pixels.
        pub height: u32,
        /// Right vector times half the picture plane's width at distance 1.
        pub right: [f32; 3],
        /// Pass number.
        pub pass_index: u32,
        /// Up vector times half the picture plane's height at distance 1.
        pub up: [f32; 3],
        /// First pixel of this dispatch.
        pub first: u32,
        /// Seed, low word first.
        pub seed: [u32; 2],
        /// Pixels of this dispatch.
        pub count: u32,
        /// Nothing.
        pub unused: u32,
    }

    /// What `shade` needs to know.
    pub struct ShadeParams {
        /// First ray of this dispatch.
        pub first: u32,
        /// Rays of this dispatch.
        pub count: u32,
        /// Pass number.
        pub pass_index: u32,
        /// Bounce of the rays.
        pub bounce: u32,
        /// Seed, low word first.
        pub seed: [u32; 2],
        /// 1 in the last bounce, after which no path goes on.
        pub is_last: u32,
        /// 1 with Russian roulette.
        pub roulette: u32,
        /// Sky straight up.
        pub zenith: [f32; 3],
        /// Entries of the emitter table.
        pub emitter_count: u32,
        /// Sky straight down.
        pub nadir: [f32; 3],
        /// Density over area of picking a point on an emissive triangle, per luminance.
        pub emission_density: f32,
        /// Density over solid angle of picking a sky direction.
        pub sky_density: f32,
        /// Word of the scene's tables at which the first material begins.
        pub first_material: u32,
        /// Nothing.
        pub unused_0: u32,
        /// Nothing.
        pub unused_1: u32,
    }

    /// A material as kernels read it.
    pub struct MaterialData {
        /// Linear RGB base colour.
        pub base_color: [f32; 3],
        /// 0 to 1.
        pub metallic: f32,
        /// Emitted radiance.
        pub emission: [f32; 3],
        /// Perceptual roughness, 0 to 1.
        pub roughness: f32,
        /// First texel of the base-colour texture among the texels of all.
        pub texture_first: u32,
        /// Its texels per row; 0 without a texture.
        pub texture_width: u32,
        /// Its rows.
        pub texture_height: u32,
        /// Nothing.
        pub unused: u32,
    }

    /// The surface at a hit, seen from the side that the ray came from: what `shade::surface` leaves
    /// for the kernels after it.
    pub struct SurfaceData {
        /// Where rays leave it.
        pub origin: [f32; 3],
        /// Distance along the ray; +inf says that nothing was hit, and that the rest is undefined.
        pub t: f32,
        /// Unit normal of the triangle.
        pub geometric_normal: [f32; 3],
        /// As in the material.
        pub metallic: f32,
        /// Unit normal to shade with.
        pub shading_normal: [f32; 3],
        /// As in the material.
        pub roughness: f32,
        /// Linear RGB, textures included.
        pub base_color: [f32; 3],
        /// Nothing.
        pub unused_0: u32,
        /// Emitted radiance.
        pub emission: [f32; 3],
        /// Nothing.
        pub unused_1: u32,
    }

    /// One entry of the table that shadow rays pick their light from.
    pub struct Emitter {
        /// One of the `EMITTER_` constants.
        pub shape: u32,
        /// Index of the scene's light.
        pub light: u32,
        /// Probability of keeping this entry when its slot is drawn, else `other` is taken.
        pub keep: f32,
        /// The other entry of the slot (Walker 1977).
        pub other: u32,
        /// Centre; of a triangle the first corner.
        pub position: [f32; 3],
        /// Probability of picking this entry.
        pub probability: f32,
        /// Radiant intensity, irradiance or radiance, by shape.
        pub power: [f32; 3],
        /// Sphere: radius. Spot: offset of the angular fall-off. Triangle: area.
        pub extent: f32,
        /// Unit vector in which a spot or directional light shines; of a triangle the second corner.
        pub direction: [f32; 3],
        /// Spot: scale of the angular fall-off.
        pub cone_scale: f32,
        /// Third corner of a triangle.
        pub third_corner: [f32; 3],
        /// Nothing.
        pub unused: u32,
    }

    /// The alpha mask of one triangle.
    pub struct MaskedTriangle {
        /// Texture coordinates of the first corner.
        pub uv_a: [f32; 2],
        /// Texture coordinates of the second corner.
        pub uv_b: [f32; 2],
        /// Texture coordinates of the third corner.
        pub uv_c: [f32; 2],
        /// Smallest alpha byte that is no hole, 0 to 256.
        pub threshold: u32,
        /// Place of the texture's first alpha byte.
        pub first: u32,
        /// Texels per row, ≥ 1.
        pub width: u32,
        /// Rows, ≥ 1.
        pub height: u32,
    }

    /// A light as keys see it, unit space.
    pub struct LightSiteData {
        /// Centre, or for a directional light the unit vector in which it shines.
        pub place: [f32; 3],
        /// One of the `SITE_` constants.
        pub shape: u32,
        /// Unit vector across a directional light.
        pub tangent: [f32; 3],
        /// Nothing.
        pub unused_0: u32,
        /// Unit vector across both.
        pub bitangent: [f32; 3],
        /// Nothing.
        pub unused_1: u32,
    }

    /// State that a path carries beside its ray.
    pub struct PathState {
        /// Throughput of the path; of a shadow ray the radiance that the film gets if it arrives.
        pub color: [f32; 3],
        /// Density over solid angle of a closest ray's direction; 0 for camera rays and mirrors.
        pub density: f32,
    }
}
