//! The object that `info --json` and `record --json` print keeps its promised fields.

use std::path::Path;

use formats::key::LightSite;
use formats::manifest::{
    Adapter, ArrayRecord, Backend, End, Features, Header, ImageDigest, Manifest, Mismatches, Outcome, Place,
    QueueId, QueueRecord, Stage, TimingRecord,
};
use formats::npy::Dtype;
use formats::ray::Kind;
use formats::summary::Summary;
use serde_json::{Value, json};

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

fn header() -> Header {
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let mut header = sample::header();
    (header.options.width, header.options.height) = (4, 2);
    (header.scene.name, header.scene.triangles) = ("cornell".into(), 38);
    header.lights = vec![LightSite::Environment];
    header.backend = Backend::Gpu;
    header.adapter = Adapter {
        name: "card".into(),
        driver: "driver 1".into(),
        device_type: "discrete".into(),
        backend: "vulkan".into(),
    };
    header.features = Features { used: words(&["environment"]), skipped: words(&["textures"]) };
    header
}

fn manifest() -> Manifest {
    let id = QueueId { pass: 0, bounce: 0, kind: Kind::Closest };
    let timing = |kind, method: &str, stage, samples_ns: &[u64]| TimingRecord {
        pass: 0,
        bounce: 0,
        kind,
        method: method.to_owned(),
        stage,
        samples_ns: samples_ns.to_vec(),
    };
    Manifest {
        version: 3,
        header: header(),
        methods: Vec::new(),
        arrays: vec![ArrayRecord {
            place: Place::Image,
            dtype: Dtype::F4,
            shape: vec![2, 4, 3],
            crc32c: 0,
            bytes: 96,
        }],
        queues: vec![QueueRecord {
            id,
            rays: 8,
            methods: vec!["unsorted".into(), "reis".into()],
            mismatches: vec![Mismatches { method: "reis".into(), rays: 0 }],
        }],
        timings: vec![
            timing(None, "unsorted", Stage::Generate, &[7]),
            timing(Some(Kind::Closest), "reis", Stage::TraceIndirect, &[40, 10, 30, 20]),
        ],
        caches: Vec::new(),
        disturbed: Vec::new(),
        ways: Vec::new(),
        calibration: Vec::new(),
        decisions: Vec::new(),
        end: Some(End {
            outcome: Outcome::Complete,
            image: Some(ImageDigest { width: 4, height: 2, sha256: [0xab; 32] }),
            wall_ns: 5,
        }),
    }
}

fn summary(manifest: &Manifest) -> Value {
    serde_json::to_value(Summary::new(Path::new("x.raydump"), manifest)).expect("a summary is JSON")
}

#[test]
fn the_promised_fields_are_there() {
    let found = summary(&manifest());
    for (field, expected) in [
        ("dump", json!("x.raydump")),
        ("format_version", json!(3)),
        ("complete", json!(true)),
        ("backend", json!("gpu")),
        ("image", json!({"width": 4, "height": 2, "sha256": "ab".repeat(32)})),
        ("features", json!({"used": ["environment"], "skipped": ["textures"]})),
    ] {
        assert_eq!(found[field], expected, "{field}");
    }
    for (object, field, expected) in [
        ("adapter", "name", json!("card")),
        ("adapter", "driver", json!("driver 1")),
        ("adapter", "device_type", json!("discrete")),
        ("scene", "name", json!("cornell")),
        ("scene", "triangles", json!(38)),
        ("scene", "light_sites", json!(["environment"])),
    ] {
        assert_eq!(found[object][field], expected, "{object}.{field}");
    }
    let queue = &found["queues"][0];
    let expected = json!([0, 0, "closest", 8, ["unsorted", "reis"]]);
    assert_eq!(
        json!([queue["pass"], queue["bounce"], queue["kind"], queue["rays"], queue["methods"]]),
        expected
    );
}

/// Quartiles of 10, 20, 30, 40 by linear interpolation: 17.5, 25, 32.5.
#[test]
fn timings_are_medians_and_interquartile_ranges() {
    let found = summary(&manifest());
    let timings = json!([
        {"pass": 0, "bounce": 0, "kind": null, "method": "unsorted", "stage": "generate",
            "median_ns": 7.0, "iqr_ns": 0.0, "samples": 1},
        {"pass": 0, "bounce": 0, "kind": "closest", "method": "reis", "stage": "trace_indirect",
            "median_ns": 25.0, "iqr_ns": 15.0, "samples": 4},
    ]);
    assert_eq!(found["timings"], timings);
}

#[test]
fn a_recovered_recording_says_so() {
    let mut manifest = manifest();
    manifest.end = Some(End { outcome: Outcome::Recovered, image: None, wall_ns: 0 });
    let found = summary(&manifest);
    assert_eq!((&found["complete"], &found["recovered"]), (&json!(false), &json!(true)));
    assert_eq!(found["image"], json!({"width": 4, "height": 2, "sha256": null}));
    assert_eq!(found["wall_ns"], Value::Null);
}
