//! Everything about a run that kernels depend on.

use std::sync::Arc;

use formats::key::method::BUILTIN;
use formats::key::{Extent, Layout, LayoutError, LayoutText, LightSite, Method, Termination};
use formats::ray::Kind;
use formats::unit_space::UnitSpace;
use scenes::features::Features;
use scenes::{Camera, Scene};

use super::shade::tables::ShadeTables;
use super::trace::Precision;

/// A method as a backend runs it: layout expanded for the scene's lights and the picture.
#[derive(Clone, Debug)]
pub struct MethodPlan {
    /// Name in paths and tables.
    pub name: String,
    /// Method that this is a variant of; its own name if it is none.
    pub base: String,
    /// What the user typed or the methods say.
    pub text: String,
    /// The key's bits.
    pub layout: Layout,
    /// Source of the length estimate.
    pub termination: Termination,
    /// Width of the key, 8 to 64.
    pub key_bits: u32,
    /// Length that a fixed estimate assumes, unit lengths.
    pub two_point_length: f32,
    /// Whether closest rays have such keys, and whether shadow rays do.
    pub for_kinds: [bool; 2],
}

impl MethodPlan {
    /// A method as it is, for as much as there is to number.
    ///
    /// # Errors
    /// If the layout needs a picture, and there is none.
    pub fn new(
        method: &Method,
        extent: Extent,
        key_bits: u32,
        two_point_length: f32,
    ) -> Result<Self, LayoutError> {
        Ok(Self {
            name: method.name.clone(),
            base: method.name.clone(),
            text: method.layout.text().to_owned(),
            layout: method.layout.expand(extent)?,
            termination: method.termination,
            key_bits,
            two_point_length,
            for_kinds: Kind::ALL.map(|kind| method.applies_to(kind)),
        })
    }

    /// Whether the method makes sense for this kind of ray.
    pub fn applies_to(&self, kind: Kind) -> bool {
        self.for_kinds[kind as usize]
    }
}

/// Everything about a run that kernels depend on.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Scene arrays for shading.
    pub tables: Arc<ShadeTables>,
    /// What the scene uses.
    pub features: Features,
    /// World to unit space.
    pub unit: UnitSpace,
    /// Where the lights are, by index.
    pub light_sites: Vec<LightSite>,
    /// The view.
    pub camera: Camera,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Bounces traced; the last has number `bounces − 1`.
    pub bounces: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Whether dark paths end by chance.
    pub roulette: bool,
    /// Methods to measure, in order, and after them those that only `auto` may choose.
    pub methods: Vec<MethodPlan>,
    /// How many those are at the end.
    pub candidates: usize,
    /// Address bits of the length tables.
    pub table_bits: u32,
    /// Layout whose top bits address them.
    pub table_layout: Layout,
    /// How triangles and boxes are tested for closest rays.
    pub precision: Precision,
}

impl Setup {
    /// Unit space and light sites of a scene.
    pub fn light_sites(scene: &Scene, unit: &UnitSpace) -> Vec<LightSite> {
        let site = |light: &scenes::Light| match (light, light.centre(scene)) {
            (_, Some(centre)) => LightSite::Placed { centre: unit.point(centre) },
            (scenes::Light::Directional { direction, .. }, None) => LightSite::directional(*direction),
            (_, None) => LightSite::Environment,
        };
        scene.lights.iter().map(site).collect()
    }

    /// A run over nothing, with all features of scenes or with none, and all built-in methods: for tests that
    /// need every line of WGSL.
    pub(crate) fn made_up(all_features: bool, key_bits: u32) -> Self {
        let features = Features::each().into_iter().filter(|_| all_features);
        let light_sites = vec![
            LightSite::Placed { centre: [0.5; 3] },
            LightSite::directional([0.0, -1.0, 0.0]),
            LightSite::Environment,
        ];
        let extent = Extent { lights: light_sites.len(), picture: [64, 64] };
        let methods = BUILTIN.iter().filter_map(|(name, ..)| {
            let method = Method::builtin(name).ok()?;
            MethodPlan::new(&method, extent, key_bits, 0.25).ok()
        });
        let table_layout = LayoutText::parse("ox dx").and_then(|text| text.expand(Extent::NOTHING));
        Self {
            tables: Arc::default(),
            features: features.fold(Features::default(), |all, (_, feature)| all.union(feature)),
            unit: UnitSpace::from_bounds([-1.0; 3], [1.0; 3]),
            camera: Camera {
                name: String::new(),
                eye: [0.0; 3],
                forward: [0.0, 0.0, 1.0],
                right: [1.0, 0.0, 0.0],
                up: [0.0, 1.0, 0.0],
                yfov_radians: 1.0,
            },
            width: 64,
            height: 64,
            bounces: 2,
            seed: 0,
            roulette: all_features,
            methods: methods.collect(),
            candidates: 0,
            table_bits: 20,
            table_layout: table_layout.unwrap_or_default(),
            precision: Precision::default(),
            light_sites,
        }
    }

    /// How much layouts have to number.
    pub fn extent(&self) -> Extent {
        Extent { lights: self.light_sites.len(), picture: [self.width, self.height] }
    }

    /// The methods that were asked for.
    pub fn named(&self) -> &[MethodPlan] {
        &self.methods[..self.methods.len() - self.candidates]
    }

    /// Those that only `auto` may choose.
    pub fn candidates(&self) -> &[MethodPlan] {
        &self.methods[self.named().len()..]
    }

    /// The same with such methods.
    #[must_use]
    pub fn with_candidates(mut self, candidates: Vec<MethodPlan>) -> Self {
        self.candidates = candidates.len();
        self.methods.extend(candidates);
        self
    }

    /// The seed as kernels take it, low word first.
    pub fn seed_words(&self) -> [u32; 2] {
        [self.seed as u32, (self.seed >> 32) as u32]
    }
}
