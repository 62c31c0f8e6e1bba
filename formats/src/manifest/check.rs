//! What a header says against what any recorder writes: numbers in range, vectors that are some.

use std::collections::BTreeSet;

use super::{Backend, CameraPose, Header, SceneSummary};
use crate::key::method::UNSORTED;
use crate::key::{Coordinate, Encoder, Extent, KEY_BITS_MIN, LAYOUT_BITS, LayoutText, LightSite, Method};
use crate::length_table::{LONGEST_SUMMED, TABLE_BITS_MAX, TABLE_BITS_MIN};
use crate::text::shown;
use crate::unit_space::UnitSpace;

/// Most bounces of a recording.
pub const BOUNCES_MAX: u32 = 99;
/// Most passes of a recording.
pub const PASSES_MAX: u32 = 999;
/// Most repeats of a measurement.
pub const REPEATS_MAX: u32 = 10_000;

/// The trace kernels of this version.
const TRACE_KERNELS: &[&str] = &["wide", "cwbvh", "bvh2", "lanes", "packet", "ray-query"];
/// Of `--keep-passes`: the last pass, in which methods are measured.
pub const MEASURED_PASS: &str = "measured";
/// Of `--keep-passes`: every one.
pub const ALL_PASSES: &str = "all";
/// Which passes may be kept.
const KEPT_PASSES: &[&str] = &[MEASURED_PASS, ALL_PASSES];
/// The words of `--keep`, in the order in which they are listed.
pub const KEEP_WORDS: [&str; 11] = [
    "rays",
    "hits",
    "keys",
    "permutations",
    "lengths",
    "scene",
    "image",
    "caches",
    "work",
    "hierarchy",
    "throughput",
];

/// How far the length of a camera's vector may be from 1.
const UNIT_TOLERANCE: f64 = 1e-4;

/// What is wrong, a sentence each.
#[derive(Default)]
struct Problems(Vec<String>);

impl Problems {
    fn require(&mut self, is_right: bool, problem: impl FnOnce() -> String) {
        if !is_right {
            self.0.push(problem());
        }
    }
}

impl Header {
    /// What is wrong with the header by itself, a sentence each; empty for whatever a recorder wrote.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Problems::default();
        self.check_options(&mut problems);
        self.check_table(&mut problems);
        self.check_machine(&mut problems);
        check_scene(&self.scene, &mut problems);
        check_camera(&self.camera, &mut problems);
        for (index, light) in self.lights.iter().enumerate() {
            problems
                .require(is_finite(light), || format!("light {index} is {light:?}, expected finite numbers"));
        }
        problems.0
    }

    /// How much layouts of this recording have to number.
    pub fn extent(&self) -> Extent {
        Extent { lights: self.lights.len(), picture: [self.options.width, self.options.height] }
    }

    /// What gives a ray's cell in the length tables, if the header says so.
    pub fn cell_encoder(&self) -> Option<Encoder> {
        let (options, scene) = (&self.options, &self.scene);
        if !(TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&options.table_bits) {
            return None;
        }
        let layout = LayoutText::parse(&options.table_layout).ok()?.expand(Extent::NOTHING).ok()?;
        let fits = !layout.uses(Coordinate::needs_facts);
        let unit = UnitSpace::from_bounds(scene.bounds_min, scene.bounds_max);
        fits.then(|| Encoder::new(&layout, options.table_bits, unit, &[]))
    }

    fn check_options(&self, problems: &mut Problems) {
        let options = &self.options;
        let (width, height, length) = (options.width, options.height, options.two_point_length);
        problems.require(width > 0 && height > 0, || {
            format!("the picture has {width} × {height} pixels, expected at least 1 × 1")
        });
        for (what, found, least, most) in [
            ("bounces", options.bounces, 1, BOUNCES_MAX),
            ("passes", options.passes, 1, PASSES_MAX),
            ("repeats", options.repeats, 1, REPEATS_MAX),
            ("key bits", options.key_bits, KEY_BITS_MIN, LAYOUT_BITS),
            ("table bits", options.table_bits, TABLE_BITS_MIN, TABLE_BITS_MAX),
        ] {
            problems.require((least..=most).contains(&found), || {
                format!("it has {found} {what}, expected {least} to {most}")
            });
        }
        problems.require((0.0..=LONGEST_SUMMED).contains(&length), || {
            format!("the length of two-point is {length}, expected 0 to {LONGEST_SUMMED}")
        });
        for (what, found, known) in [
            ("trace kernel", &options.trace_kernel, TRACE_KERNELS),
            ("kept passes", &options.keep_passes, KEPT_PASSES),
        ] {
            problems.require(known.contains(&found.as_str()), || {
                format!("its {what} are '{}', expected one of {}", shown(found), known.join(", "))
            });
        }
        if let Some(word) = options.keep.iter().find(|word| !KEEP_WORDS.contains(&word.as_str())) {
            let known = KEEP_WORDS.join(", ");
            problems.0.push(format!("it kept '{}', expected some of {known}", shown(word)));
        }
        for (what, words) in [("kept arrays", &options.keep), ("methods", &options.methods)] {
            let mut seen = BTreeSet::new();
            if let Some(twice) = words.iter().find(|word| !seen.insert(*word)) {
                problems.0.push(format!("its {what} name '{}' twice", shown(twice)));
            }
        }
        problems.require(options.methods.iter().any(|method| method == UNSORTED), || {
            format!("its methods lack {UNSORTED}, which is always measured")
        });
    }

    fn check_table(&self, problems: &mut Problems) {
        let options = &self.options;
        let method = Method::builtin(&options.table_method);
        problems.require(method.is_ok_and(|method| method.can_address_table()), || {
            format!(
                "its tables are addressed by '{}', expected a built-in method that needs no length, light or picture",
                shown(&options.table_method)
            )
        });
        let has_bits = (TABLE_BITS_MIN..=TABLE_BITS_MAX).contains(&options.table_bits);
        problems.require(!has_bits || self.cell_encoder().is_some(), || {
            format!(
                "the table's layout '{}' is none that gives every ray a cell",
                shown(&options.table_layout)
            )
        });
    }

    fn check_machine(&self, problems: &mut Problems) {
        let (threads, kernel) = (self.options.threads, &self.options.trace_kernel);
        match self.backend {
            Backend::Gpu => problems.require(threads == 0, || {
                format!("it has {threads} threads of the cpu backend, but ran on a gpu")
            }),
            Backend::Cpu => problems.require(threads > 0 && kernel != "ray-query", || {
                format!(
                    "it ran on {threads} threads by {}, expected some threads and a kernel of the cpu backend",
                    shown(kernel)
                )
            }),
        }
    }
}

fn check_scene(scene: &SceneSummary, problems: &mut Problems) {
    let mut corners = scene.bounds_min.into_iter().zip(scene.bounds_max);
    problems.require(corners.all(|(low, high)| low <= high && (high - low).is_finite()), || {
        format!(
            "the scene's box goes from {:?} to {:?}, expected finite corners, the lowest first",
            scene.bounds_min, scene.bounds_max
        )
    });
}

fn check_camera(camera: &CameraPose, problems: &mut Problems) {
    problems.require(camera.eye.iter().all(|along| along.is_finite()), || {
        format!("the camera's eye is {:?}, expected finite numbers", camera.eye)
    });
    for (name, vector) in [("forward", camera.forward), ("right", camera.right), ("up", camera.up)] {
        let squared: f64 = vector.iter().map(|&along| f64::from(along) * f64::from(along)).sum();
        // NaN is in no range.
        let is_unit = (-UNIT_TOLERANCE..=UNIT_TOLERANCE).contains(&(squared.sqrt() - 1.0));
        problems.require(is_unit, || format!("the camera's {name} is {vector:?}, expected a unit vector"));
    }
    let yfov = camera.yfov_radians;
    problems.require(yfov > 0.0 && yfov < std::f32::consts::PI, || {
        format!("the camera's field of view is {yfov} radians, expected more than 0, less than π")
    });
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
