//! What a sort may cost: what it saves in tracing against what it takes.

use formats::manifest::Stage;

use super::building::{
    self, figure, is_method, leading, left_out, methods, reason, recordings, settings, stage_style,
};
use super::{Findings, Made};
use crate::analysis::RecordingAnalysis;
use crate::analysis::break_even::BreakEven;
use crate::analysis::summary::RayClass;
use crate::figures::model::{Axis, Content, Panel, Point, Series};

/// Black circles: the style of `unsorted`, which has no row here.
const SAVED_STYLE: usize = 0;

/// A number, and what its interval reaches from and to.
type Number = (f64, Option<(f64, f64)>);

/// What tracing saves and what sorting takes, nanoseconds a ray, per method.
pub fn break_even(findings: &Findings<'_>) -> Made {
    let (mut panels, mut limits) = (Vec::new(), Vec::new());
    let recordings = recordings(findings);
    for recording in &recordings {
        let mut of_recording = Vec::new();
        for rays in RayClass::ALL {
            let found = methods(findings)
                .into_iter()
                .filter_map(|method| Some((method, BreakEven::of(recording, rays, method)?)));
            let mut found: Vec<(&str, BreakEven)> = found.collect();
            of_recording.extend(limit(rays, &found));
            let leading = leading(findings, recording, rays);
            found.retain(|(method, _)| leading.contains(method));
            // An axis of its own: what scenes save is far apart.
            let name = if recordings.len() > 1 { format!("{}, ", recording.label) } else { String::new() };
            panels.push(panel(recording, &name, rays, &found));
        }
        if !of_recording.is_empty() {
            limits.push(format!("{}: {}", recording.label, of_recording.join(", ")));
        }
    }
    let caption = format!(
        "Sorting pays if all of it takes less than it saves in tracing, at best: {}. Saves: the trace of unsorted rays less that of sorted ones, over all bounces, with its 95 % interval from six rounds on. Takes: all else that the recording counts (keys, sort, accumulate, and gather and scatter where rays are not traced through indices). A method whose square is left of its circle has a net speedup above 1; of an order of another tracer the key and the sort were not timed: what is between square and circle is what they may take.{}",
        limits.join("; "),
        left_out(findings)
    );
    let reason =
        reason(findings, |order| &order.trace_speedup, "no method was measured on secondary or shadow rays");
    figure("What a sort may cost, per ray", caption, settings(recordings), panels, reason)
}

/// What a sort may take at most: by the method that saves most.
fn limit(rays: RayClass, found: &[(&str, BreakEven)]) -> Option<String> {
    let methods = found.iter().filter(|(method, _)| is_method(method));
    let (method, best) = methods.max_by(|(_, a), (_, b)| a.saved_ns.total_cmp(&b.saved_ns))?;
    let rays = rays.name();
    Some(if best.saved_ns > 0.0 {
        format!("{:.1} ns a {rays} ray ({method})", best.saved_ns)
    } else {
        format!("nothing with {rays} rays")
    })
}

fn panel(recording: &RecordingAnalysis, name: &str, rays: RayClass, found: &[(&str, BreakEven)]) -> Panel {
    let series = |label: &str, style: usize, number: fn(&BreakEven) -> Number| {
        let point = |(row, (method, of)): (usize, &(&str, BreakEven))| {
            let (y, spread) = number(of);
            let number_of = building::of(recording, rays.name(), None, method);
            Point { x: row as f64, y, spread, n: of.n, of: number_of }
        };
        Series::new(label, style, found.iter().enumerate().map(point).collect())
    };
    Panel::new(
        "",
        Axis::categories("", found.iter().map(|(method, _)| *method)),
        Axis::from_zero(&format!("{name}ns per {} ray", rays.name())),
        Content::Dots(vec![
            series("sorting takes", stage_style(Stage::Sort), |of| (of.cost_ns, None)),
            series("sorting saves", SAVED_STYLE, |of| (of.saved_ns, of.interval)),
        ]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_sort_may_take_is_what_the_best_method_saves() {
        let saving =
            |saved_ns| BreakEven { saved_ns, interval: None, cost_ns: 1.0, unsorted_ns: 100.0, n: 1 };
        let found = [("a", saving(-1.0)), ("f", saving(9.0)), ("h", saving(2.0)), ("control", saving(99.0))];
        assert_eq!(limit(RayClass::Shadow, &found).unwrap(), "9.0 ns a shadow ray (f)");
        assert_eq!(limit(RayClass::Shadow, &[("a", saving(-1.0))]).unwrap(), "nothing with shadow rays");
    }
}
