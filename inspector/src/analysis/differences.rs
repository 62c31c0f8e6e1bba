//! What differs between two orders, as a table: settings of their recordings, counts of rays, numbers.

use formats::manifest::{Header, Source};
use formats::summary::hexadecimal;

use super::comparison::Comparison;
use crate::output::count;

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What may differ.
    pub what: &'static str,
    /// What that is, in a sentence.
    pub about: &'static str,
    /// On the left and on the right.
    pub sides: [String; 2],
    /// Whether it does differ.
    pub differs: bool,
}

impl Row {
    fn of(what: &'static str, about: &'static str, sides: [String; 2]) -> Self {
        let differs = sides[0] != sides[1];
        Self { what, about, sides, differs }
    }
}

type Setting = (&'static str, &'static str, fn(&Header) -> String);

/// What was recorded, and how.
const SETTINGS: [Setting; 24] = [
    ("scene", "Its file or built-in name", |header| header.scene.name.clone()),
    ("scene hash", "SHA-256 of all of the scene that a recording depends on", |header| {
        hexadecimal(&header.scene.content_hash)
    }),
    ("triangles", "Triangles of the scene", |header| count(header.scene.triangles)),
    ("camera", "Its name in the scene", |header| header.options.camera.clone()),
    ("camera at", "Where it stands, world units", |header| format!("{:?}", header.camera.eye)),
    ("size", "Pixels across and down", |header| {
        format!("{} x {}", header.options.width, header.options.height)
    }),
    ("bounces", "Bounces traced at most", |header| header.options.bounces.to_string()),
    ("passes", "Samples per pixel", |header| header.options.passes.to_string()),
    ("repeats", "How often each method was measured", |header| header.options.repeats.to_string()),
    ("seed", "Seed of all random numbers", |header| header.options.seed.to_string()),
    ("russian roulette", "Whether paths were ended at random by their throughput", |header| {
        yes_or_no(header.options.russian_roulette)
    }),
    ("methods", "How rays were sorted", |header| header.options.methods.join(", ")),
    ("key bits", "Bits of a key", |header| header.options.key_bits.to_string()),
    ("two-point length", "Length that two-point assumes, unit lengths", |header| {
        header.options.two_point_length.to_string()
    }),
    ("table bits", "Address bits of the length tables", |header| header.options.table_bits.to_string()),
    ("table layout", "How cells of the length tables are addressed", |header| {
        header.options.table_layout.clone()
    }),
    ("trace kernel", "What traced the rays", |header| header.options.trace_kernel.clone()),
    ("backend", "GPU or native threads", |header| header.backend.name().to_owned()),
    ("adapter", "The machine that was measured", |header| header.adapter.name.clone()),
    ("driver", "Its driver with version", |header| header.adapter.driver.clone()),
    ("threads", "Of the cpu backend", |header| header.options.threads.to_string()),
    ("IEEE arithmetic", "Whether the adapter rounds as IEEE 754 says", |header| {
        yes_or_no(header.ieee_arithmetic)
    }),
    ("recorder", "Version of the program", |header| header.program_version.clone()),
    ("source", "Where the rays are from", |header| match &header.source {
        Source::Traced => "traced".to_owned(),
        Source::Replayed { .. } => "replayed".to_owned(),
        Source::Imported { .. } => "imported".to_owned(),
    }),
];

fn yes_or_no(is_so: bool) -> String {
    if is_so { "yes" } else { "no" }.to_owned()
}

/// The settings of two recordings.
pub fn settings(headers: [&Header; 2]) -> Vec<Row> {
    let row = |(what, about, text): Setting| Row::of(what, about, headers.map(text));
    SETTINGS.into_iter().map(row).collect()
}

/// How many rays differ, and how far their groups do.
pub fn counts(comparison: &Comparison) -> Vec<Row> {
    let found = &comparison.counts;
    let number = |number: usize| count(number as u64);
    let of_all = |what, about, differing: usize| {
        let sides = [
            format!("{} the same", number(found.matched - differing)),
            format!("{} differ", number(differing)),
        ];
        Row { differs: differing > 0, ..Row::of(what, about, sides) }
    };
    let alone = found.rays.map(|rays| rays - found.matched);
    let keys = "Rays with another key";
    vec![
        Row::of("rays", "Rays of the queue", found.rays.map(number)),
        Row {
            differs: alone != [0, 0],
            ..Row::of("rays on one side", "Rays whose path has none in the other queue", alone.map(number))
        },
        of_all("hits", "Rays that hit another triangle; shadow rays, whether they are occluded", found.hits),
        of_all("distances", "Rays whose hit is at another distance, be it by one bit", found.distances),
        of_all("places", "Rays at another place in the order", found.places),
        match &found.keys {
            Ok(differing) => of_all("keys", keys, *differing),
            Err(why) => Row::of("keys", keys, ["not comparable".to_owned(), why.clone()]),
        },
        Row::of(
            "mean capsule area",
            "Of the groups, weighted by rays, in unit space",
            comparison.mean_areas.map(|area| format!("{area:.5}")),
        ),
    ]
}
