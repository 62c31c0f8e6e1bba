//! What disturbed the times of a recording is counted.
#![allow(clippy::unwrap_used, reason = "this is test code, also outside test functions")]

mod sample;

use formats::manifest::{Record, Stage, TimingRecord};
use formats::metrics::noise::Noise;
use formats::reader::Dump;

/// The sample has 7 samples a timing, of which one of each queue's unsorted trace is disturbed.
#[test]
fn disturbed_samples_and_wide_traces_are_counted() {
    let folder = sample::folder_in_memory();
    let path = sample::write(folder.path());
    let counted = || Noise::of(Dump::open(&path).unwrap().manifest());
    let timings = Dump::open(&path).unwrap().manifest().timings.clone();
    let of_queues = |timing: &&TimingRecord| timing.kind.is_some();
    let traces = timings.iter().filter(|timing| timing.stage == Stage::Trace).count();
    let queues = timings.iter().filter(|timing| timing.method == "unsorted").filter(of_queues).count();
    let samples = 7 * timings.iter().filter(of_queues).count();
    assert!(queues > 1 && traces > queues, "{traces} traces of {queues} queues");
    assert_eq!(counted(), Noise { samples, disturbed: queues, traces, wide: 0 });

    sample::edit_manifest(&path, |records| {
        let is_trace = |timing: &&mut TimingRecord| timing.stage == Stage::Trace && timing.method == "aila";
        let trace = records.iter_mut().filter_map(sample::part::timing).find(is_trace).unwrap();
        // Quartiles a tenth of the median apart are not wide yet.
        trace.samples_ns = vec![950, 950, 950, 1_000, 1_050, 1_050, 1_050];
        let Some(Record::Disturbed(first)) =
            records.iter_mut().find(|record| matches!(record, Record::Disturbed(_)))
        else {
            panic!("the sample has disturbed samples")
        };
        first.samples = vec![1, 2, 6];
    });
    assert_eq!(counted(), Noise { samples, disturbed: queues + 2, traces, wide: 0 });

    sample::edit_parts(&path, sample::part::timing, |timing| {
        if timing.samples_ns.contains(&950) {
            timing.samples_ns = vec![940, 940, 940, 1_000, 1_060, 1_060, 1_060];
        }
    });
    assert_eq!(counted(), Noise { samples, disturbed: queues + 2, traces, wide: 1 });
}
