//! Results of benchmarks, made up.

use formats::bench_result::error::{ErrorRows, EstimatorRow, HitErrors, ImageRow, KeyBitsRow, PrecisionRow};
use formats::bench_result::skip::{Cost, SkipRow};
use formats::bench_result::{BENCH_VERSION, BenchResult, RenderRow, Rows, ShadeCoherence, SortRow, TraceRow};
use formats::metrics::estimator::EstimateError;
use formats::metrics::speedup::Speedup;
use formats::ray::Kind;

fn bench(rows: Rows) -> BenchResult {
    BenchResult {
        instrument: None,
        rayscope_bench: BENCH_VERSION,
        program_version: "0".into(),
        command: "recorder bench".into(),
        backend: "cpu".into(),
        adapter: "a processor".into(),
        driver: String::new(),
        threads: 2,
        time_source: "monotonic clock".into(),
        rows,
    }
}

pub(crate) fn of_each_kind() -> [BenchResult; 5] {
    let sort = |n, key_bits, ns| SortRow { n, key_bits, samples_ns: vec![ns, ns + 10, ns + 20] };
    let trace = |kernel: &str, order: &str, ns| TraceRow {
        scene: "box".into(),
        triangles: 11,
        kernel: kernel.into(),
        bounce: 1,
        kind: Kind::Closest,
        order: order.into(),
        rays: 1000,
        samples_ns: vec![ns, ns + 10, ns + 20],
        lanes: None,
    };
    [
        bench(Rows::Sort(vec![sort(2048, 32, 900), sort(1024, 32, 500), sort(1024, 64, 800)])),
        bench(Rows::Trace(vec![
            trace("cwbvh", "unsorted", 900),
            trace("cwbvh", "aila", 700),
            trace("bvh2", "aila", 800),
        ])),
        bench(Rows::Error(Box::new(error_rows()))),
        bench(Rows::Skip(
            [("textures", "shade"), ("textures", "trace"), ("masks", "trace")].map(skip_row).to_vec(),
        )),
        bench(Rows::Render(vec![
            frame("unsorted", [1000, 500, 0], None, 4.5),
            frame("aila", [2000, 1000, 500], Some(0.5), 2.5),
            frame("hits by material", [900, 500, 100], Some(1.0 / 0.9), 1.0),
        ])),
    ]
}

/// Frames of these times: whole, tracing, reordering.
fn frame(
    method: &str,
    [frame_ns, trace_ns, reorder_ns]: [u64; 3],
    ratio: Option<f64>,
    materials: f64,
) -> RenderRow {
    RenderRow {
        scene: "box".into(),
        method: method.into(),
        width: 16,
        height: 9,
        passes: 1,
        bounces: 2,
        frame_ns: vec![frame_ns; 3],
        trace_ns: vec![trace_ns; 3],
        reorder_ns: vec![reorder_ns; 3],
        speedup: ratio.map(|ratio| Speedup { ratio, interval: None }),
        shade_speedup: None,
        coherence: Some(ShadeCoherence { materials, branches: 1.0 }),
    }
}

fn skip_row((what, of): (&str, &str)) -> SkipRow {
    SkipRow {
        scene: "box".into(),
        what: what.into(),
        of: of.into(),
        skipped: Cost { samples_ns: vec![100, 100, 100], bytes: 0 },
        done: Cost { samples_ns: vec![150, 150, 150], bytes: 64 },
        same: "picture".into(),
        is_same: true,
    }
}

/// A picture of the curve over time.
fn image(method: &str, passes: u32, wall_ns: u64, relative_mse: f64) -> ImageRow {
    ImageRow {
        scene: "box".to_owned(),
        method: method.into(),
        width: 16,
        height: 9,
        passes,
        wall_ns,
        speedup: (method != "unsorted").then_some(Speedup { ratio: 1.25, interval: Some((1.125, 1.5)) }),
        relative_mse,
        reference_passes: 64,
    }
}

/// Every curve, two points each.
fn error_rows() -> ErrorRows {
    let scene = || "box".to_owned();
    let precision = |triangle_test: &str, missed, ns| PrecisionRow {
        scene: scene(),
        triangles: 11,
        kernel: "bvh2".into(),
        triangle_test: triangle_test.into(),
        box_test: "padded".into(),
        bounces: "1-2".into(),
        errors: HitErrors { rays: 500_000, missed, wrong_triangles: 1, ..HitErrors::default() },
        rays_timed: 1000,
        samples_ns: vec![ns, ns + 10, ns + 20],
    };
    let error = |mean_absolute| EstimateError {
        mean_absolute,
        median_absolute: mean_absolute,
        root_mean_square: mean_absolute,
        n: 100,
    };
    let estimator = |table_method: &str, table_bits, accumulate_ns: Vec<u64>, key_ns, mean| EstimatorRow {
        scene: scene(),
        kind: Kind::Shadow,
        table_method: table_method.into(),
        table_bits,
        pass: 8,
        cells_touched: 7,
        error: error(mean),
        rays_timed: 100,
        accumulate_ns,
        key_ns: vec![key_ns],
    };
    let key_bits = |method: &str, key_bits, key_ns: Vec<u64>| KeyBitsRow {
        scene: scene(),
        bounce: 2,
        kind: Kind::Closest,
        method: method.into(),
        key_bits,
        rays: 1000,
        capsule_area: 0.5,
        sort_ns: key_ns.clone(),
        key_ns,
        trace_ns: vec![2_000_000, 3_000_000, 4_000_000],
    };
    ErrorRows {
        precision: vec![precision("watertight", 0, 900), precision("moeller-trumbore", 3, 800)],
        estimator: vec![
            estimator("constant", 0, vec![], 1000, 0.2),
            estimator("aila", 10, vec![500], 1400, 0.15),
            estimator("aila", 20, vec![600], 1500, 0.1),
        ],
        key_bits: vec![
            key_bits("unsorted", 0, vec![]),
            key_bits("aila", 8, vec![1_000_000]),
            key_bits("aila", 32, vec![2_000_000]),
        ],
        image: vec![
            image("unsorted", 1, 1_000_000, 0.5),
            image("unsorted", 2, 2_000_000, 0.25),
            image("aila", 2, 1_500_000, 0.25),
        ],
    }
}
