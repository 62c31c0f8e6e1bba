//! Figures of several recordings: which of them are in it, and which of their methods.

use formats::ray::Kind;
use inspector::analysis::{Analysis, Depth, Metric};
use inspector::figures::model::Scale;
use inspector::report::tables::tables;

use super::{analysis, of_recordings, series};

/// Of many recordings each panel has rows for the methods that are best there, and no row is empty.
#[test]
fn no_panel_of_many_is_without_its_methods() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    let whole = analysis.recordings[0].clone();
    let mut few = whole.clone();
    // What is best of all there stands last elsewhere; and a control that seems to gain most.
    let is_kept = |method: &str| ["unsorted", "two-point-adaptive", "aila"].contains(&method);
    few.queues.iter_mut().for_each(|queue| queue.orders.retain(|order| is_kept(&order.method)));
    few.frames.retain(|frame| is_kept(&frame.method));
    let orders = few.queues.iter_mut().flat_map(|queue| &mut queue.orders);
    for order in orders.filter(|order| order.method == "aila") {
        (order.method, order.base) = ("control".into(), "control".into());
    }
    for frame in few.frames.iter_mut().filter(|frame| frame.method == "aila") {
        (frame.method, frame.base) = ("control".into(), "control".into());
        let Metric::Known(line) = &mut frame.net_speedup else { panic!("it was timed") };
        line.ratio = 9.0;
    }
    // One of camera rays alone.
    let mut camera = whole.clone();
    camera.label = "camera alone".into();
    camera.queues.retain(|queue| queue.kind == Kind::Closest && queue.bounce == 0);
    camera.frames.clear();
    analysis.recordings = vec![whole.clone(), whole, few, camera];
    let expected = ["two-point-adaptive"];
    for name in ["overhead", "break-even"] {
        let made = of_recordings(&analysis, name);
        for (at, panel) in made.panels.iter().enumerate() {
            let Scale::Categories(rows) = &panel.x.scale else { panic!("methods") };
            let points = || series(panel).iter().flat_map(|series| &series.points);
            let is_empty = |row: &usize| !points().any(|point| point.x == *row as f64);
            assert_eq!((0..rows.len()).find(is_empty), None, "{name}, panel {at}: {rows:?}");
            assert!(rows.len() <= 6 && (at < 4 || *rows == expected), "{name}, panel {at}: {rows:?}");
        }
        assert_eq!(made.panels.len(), 6);
        assert!(!made.caption.contains("camera alone"), "{}", made.caption);
    }
}

/// A figure's settings are those of the recordings that are in it, and of a sweep all its bits.
#[test]
fn settings_are_those_of_what_is_in_a_figure() {
    let (folder, mut analysis) = analysis(Depth::Arrays);
    let mut other = analysis.recordings[0].clone();
    (other.label, other.scene, other.content_hash) = ("other".into(), "other".into(), "other".into());
    other.root = folder.path().join("nowhere.raydump");
    let orders = other.queues.iter_mut().flat_map(|queue| &mut queue.orders);
    orders.for_each(|order| order.lanes = Metric::missing("not kept"));
    analysis.recordings.push(other);
    let swept = &mut analysis.recordings[0];
    for order in swept.queues.iter_mut().flat_map(|queue| &mut queue.orders) {
        if let Some(bits) = order.key_bits.filter(|_| ["aila", "mine"].contains(&order.method.as_str())) {
            let variant = format!("aila-{bits}-bits");
            swept.frames.iter_mut().filter(|frame| frame.method == order.method).for_each(|frame| {
                (frame.method, frame.base) = (variant.clone(), "aila".into());
            });
            (order.method, order.base) = (variant, "aila".into());
            order.two_point_length = None;
        }
    }
    let settings = |name: &str| of_recordings(&analysis, name).settings;
    for name in ["key-bits", "lane-utilisation", "headline", "pixel-cost"] {
        let settings = settings(name);
        assert_eq!(settings.len(), 1, "{name}: {settings:?}");
        assert!(settings[0].contains(" 16-bit, 32-bit keys,"), "{name}: {settings:?}");
    }
    let both = settings("overhead");
    assert!(both.len() == 2 && both[1].contains(" 32-bit keys,"), "{both:?}");
}

/// A recording of variants alone is left out beside others, but shown where there is nothing else; tables
/// and pictures that two recordings share are shown once.
#[test]
fn replays_do_not_repeat_what_their_source_shows() {
    let (_folder, mut analysis) = analysis(Depth::Arrays);
    let panels = |analysis: &Analysis| {
        ["overhead", "lane-utilisation", "table-fill", "pixel-cost"]
            .map(|name| of_recordings(analysis, name).panels.len())
    };
    let alone = panels(&analysis);
    let mut replay = analysis.recordings[0].clone();
    replay.label = "replay".into();
    for order in replay.queues.iter_mut().flat_map(|queue| &mut queue.orders) {
        if order.method != "unsorted" {
            order.method = format!("{}-8-bits", order.base);
        }
    }
    for frame in replay.frames.iter_mut().filter(|frame| frame.method != "unsorted") {
        frame.method = format!("{}-8-bits", frame.base);
    }
    analysis.recordings.push(replay);
    assert_eq!(panels(&analysis), alone);
    analysis.recordings.remove(0);
    assert_eq!(panels(&analysis), alone);
}

/// One that a recording lacks has the dots of the others and no mean, which would be over other scenes.
#[test]
fn means_are_of_what_all_recordings_have() {
    let (_folder, mut analysis) = analysis(Depth::Arrays);
    let whole = analysis.recordings[0].clone();
    let mut few = whole.clone();
    few.queues.iter_mut().for_each(|queue| queue.orders.retain(|order| order.method != "aila"));
    few.frames.retain(|frame| frame.method != "aila");
    analysis.recordings = vec![whole.clone(), whole, few];
    for name in ["trace-speedup", "net-speedup", "lane-utilisation"] {
        let made = of_recordings(&analysis, name);
        let count = |method: &str, is_part: bool| -> usize {
            let own = series(&made.panels[0]).iter();
            let own = own.filter(|series| series.label == method && series.is_part == is_part);
            own.map(|series| series.points.len()).sum()
        };
        assert!(made.panels[0].title.starts_with("All recordings"), "{name}");
        assert_eq!(["aila", "two-point"].map(|method| count(method, false)), [0, 1], "{name}");
        assert_eq!(["aila", "two-point"].map(|method| count(method, true)), [2, 3], "{name}");
    }
    for summary in &mut analysis.summaries {
        for speedup in [&mut summary.trace_speedup, &mut summary.net_speedup] {
            let Metric::Known(mean) = speedup else { continue };
            mean.n = if summary.method == "aila" { 2 } else { 3 };
        }
    }
    let rows = tables(&analysis, &[]).into_iter().flat_map(|table| table.rows);
    let means: Vec<_> = rows.filter(|row| row[0].text.starts_with("mean: ")).flatten().collect();
    let of_two: Vec<_> = means.iter().filter(|cell| cell.text.ends_with(" (2 of 3)")).collect();
    assert!(of_two.len() == 2 && of_two.iter().all(|cell| !cell.is_best), "secondary and shadow: {means:?}");
}
