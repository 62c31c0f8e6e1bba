//! What a header says against what any recorder writes: numbers in range, vectors that are some.

use std::collections::BTreeSet;

use super::{Backend, CameraPose, Header, NAME_CHARACTERS, SceneSummary};
use crate::key::method::UNSORTED;
use crate::key::{Encoder, KEY_BITS_MIN, LAYOUT_BITS, LayoutText, LightSite, Method};
use crate::length_table::{LONGEST_SUMMED, TABLE_BITS_MAX, TABLE_BITS_MIN};
use crate::text::one_line;
use crate::unit_space::UnitSpace;

/// Most bounces of a recording.
pub const BOUNCES_MAX: u32 = 99;
/// Most passes of a recording.
pub const PASSES_MAX: u32 = 999;
/// Most repeats of a measurement.
pub const REPEATS_MAX: u32 = 10_000;

/// The trace kernels of this version.
const TRACE_KERNELS: &[&str] = &["cwbvh", "bvh2", "ray-query"];
/// Which passes may be kept.
const KEPT_PASSES: &[&str] = &["measured", "all"];
/// The words of `--keep`, in the order in which they are listed.
pub const KEEP_WORDS: [&str; 9] =
    ["rays", "hits", "keys", "permutations", "lengths", "scene", "image", "caches", "work"];

/// How far the length of a camera's vector may be from 1.
const UNIT_TOLERANCE: f64 = 1e-4;

impl Header {
    /// What is wrong with the header by itself, a sentence each; empty for whatever a recorder wrote.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        self.check_options(&mut problems);
        check_scene(&self.scene, &mut problems);
        check_camera(&self.camera, &mut problems);
        for (index, light) in self.lights.iter().enumerate() {
            if !is_finite(light) {
                problems.push(format!("light {index} is {light:?}, expected finite numbers"));
            }
        }
        problems
    }

    /// What gives a ray's cell in the length tables, if the header says so.
    pub fn cell_encoder(&self) -> Option<Encoder> {
        let (options, scene) = (&self.options, &self.scene);
        if !(TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&options.table_bits) {
            return None;
        }
        let layout = LayoutText::parse(&options.table_layout).ok()?.expand(1).ok()?;
        let fits = !layout.uses(|coordinate| coordinate.needs_light() || coordinate.needs_length());
        let unit = UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max);
        fits.then(|| Encoder::new(&layout, options.table_bits, unit, &[]))
    }

    fn check_options(&self, problems: &mut Vec<String>) {
        let options = &self.options;
        if options.width == 0 || options.height == 0 {
            let (width, height) = (options.width, options.height);
            problems.push(format!("the picture has {width} × {height} pixels, expected at least 1 × 1"));
        }
        for (what, found, least, most) in [
            ("bounces", options.bounces, 1, BOUNCES_MAX),
            ("passes", options.passes, 1, PASSES_MAX),
            ("repeats", options.repeats, 1, REPEATS_MAX),
            ("key bits", options.key_bits, KEY_BITS_MIN, LAYOUT_BITS),
            ("table bits", options.table_bits, TABLE_BITS_MIN, TABLE_BITS_MAX),
        ] {
            if !(least..=most).contains(&found) {
                problems.push(format!("it has {found} {what}, expected {least} to {most}"));
            }
        }
        let words = [
            ("trace kernel", &options.trace_kernel, TRACE_KERNELS),
            ("kept passes", &options.keep_passes, KEPT_PASSES),
        ];
        for (what, found, known) in words {
            if !known.contains(&found.as_str()) {
                let found = one_line(found, NAME_CHARACTERS);
                problems.push(format!("its {what} are '{found}', expected one of {}", known.join(", ")));
            }
        }
        if let Some(word) = options.keep.iter().find(|word| !KEEP_WORDS.contains(&word.as_str())) {
            let (found, known) = (one_line(word, NAME_CHARACTERS), KEEP_WORDS.join(", "));
            problems.push(format!("it kept '{found}', expected some of {known}"));
        }
        let table_method = Method::builtin(&options.table_method).map(|method| method.can_address_table());
        if table_method != Ok(true) {
            let found = one_line(&options.table_method, NAME_CHARACTERS);
            problems.push(format!(
                "its tables are addressed by '{found}', expected a built-in method that needs no length and no light"
            ));
        }
        for (what, words) in [("kept arrays", &options.keep), ("methods", &options.methods)] {
            let mut seen = BTreeSet::new();
            if let Some(twice) = words.iter().find(|word| !seen.insert(*word)) {
                let word = one_line(twice, NAME_CHARACTERS);
                problems.push(format!("its {what} name '{word}' twice"));
            }
        }
        if !options.methods.iter().any(|method| method == UNSORTED) {
            problems.push(format!("its methods lack {UNSORTED}, which is always measured"));
        }
        if self.backend == Backend::Gpu && options.threads != 0 {
            problems.push(format!("it has {} threads of the cpu backend, but ran on a gpu", options.threads));
        }
        if self.backend == Backend::Cpu && (options.threads == 0 || options.trace_kernel == "ray-query") {
            problems.push(format!(
                "it ran on {} threads by {}, expected some threads and a kernel of the cpu backend",
                options.threads,
                one_line(&options.trace_kernel, NAME_CHARACTERS)
            ));
        }
        let length = options.two_point_length;
        if !(0.0..=LONGEST_SUMMED).contains(&length) {
            problems.push(format!("the length of two-point is {length}, expected 0 to {LONGEST_SUMMED}"));
        }
        let has_bits = (TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&options.table_bits);
        if has_bits && self.cell_encoder().is_none() {
            problems.push(format!(
                "the table's layout '{}' is none that gives every ray a cell",
                one_line(&options.table_layout, NAME_CHARACTERS)
            ));
        }
    }
}

fn check_scene(scene: &SceneSummary, problems: &mut Vec<String>) {
    let mut corners = scene.bounds_min.into_iter().zip(scene.bounds_max);
    if !corners.all(|(low, high)| low <= high && (high - low).is_finite()) {
        problems.push(format!(
            "the scene's box goes from {:?} to {:?}, expected finite corners, the lowest first",
            scene.bounds_min, scene.bounds_max
        ));
    }
}

fn check_camera(camera: &CameraPose, problems: &mut Vec<String>) {
    if !camera.eye.iter().all(|along| along.is_finite()) {
        problems.push(format!("the camera's eye is {:?}, expected finite numbers", camera.eye));
    }
    for (name, vector) in [("forward", camera.forward), ("right", camera.right), ("up", camera.up)] {
        let squared: f64 = vector.iter().map(|&along| f64::from(along) * f64::from(along)).sum();
        // NaN is in no range.
        if !(-UNIT_TOLERANCE..=UNIT_TOLERANCE).contains(&(squared.sqrt() - 1.0)) {
            problems.push(format!("the camera's {name} is {vector:?}, expected a unit vector"));
        }
    }
    let yfov = camera.yfov_radians;
    if !(yfov > 0.0 && yfov < std::f32::consts::PI) {
        problems
            .push(format!("the camera's field of view is {yfov} radians, expected more than 0, less than π"));
    }
}

fn is_finite(light: &LightSite) -> bool {
    let are_finite = |vector: &[f32; 3]| vector.iter().all(|along| along.is_finite());
    match light {
        LightSite::Placed { centre } => are_finite(centre),
        LightSite::Directional { direction, tangent, bitangent } => {
            [direction, tangent, bitangent].into_iter().all(are_finite)
        }
        LightSite::Environment => true,
    }
}
