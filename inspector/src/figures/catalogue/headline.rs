//! One view, unsorted and sorted, each with its rate.

use formats::key::method::UNSORTED;

use super::building::{figure, is_method, methods, recordings, settings};
use super::{Findings, Made};
use crate::analysis::Metric;
use crate::analysis::headline::{Headline, View};
use crate::colour_map::ColourMap;
use crate::figures::axis::number;
use crate::figures::model::{Panel, Picture};
use crate::output::times;

/// Pixels without a ray.
const NO_RAY: [u8; 3] = [0; 3];
/// Share of the pixels whose areas are below the first colour, and above the last.
const CUT_SHARE: f64 = 0.01;

/// The same pixels twice, by how large their groups' capsules are.
pub fn headline(findings: &Findings<'_>) -> Made {
    let (mut panels, mut ranges, mut reasons) = (Vec::new(), Vec::new(), Vec::new());
    let (recordings, mut shown) = (recordings(findings), Vec::new());
    let methods: Vec<&str> = methods(findings).into_iter().filter(|method| is_method(method)).collect();
    for recording in &recordings {
        match Headline::of(recording, &methods, findings.analysis.group_width) {
            Metric::Known(found) => {
                shown.push(*recording);
                let of = if recordings.len() > 1 { format!("{}, ", recording.label) } else { String::new() };
                let range = range(&found);
                let (low, high) = range;
                ranges.push(format!("{of}bounce {}: {} to {}", found.bounce, number(low), number(high)));
                panels.extend(found.views.iter().map(|view| panel(&of, &found, view, range)));
            }
            Metric::Missing { missing } => reasons.push(missing),
        }
    }
    let caption = format!(
        "Each pixel has the colour of the capsule around the {} secondary rays that its ray is traced together with, in pixel order and sorted by the method that gains most, net of all that sorting costs (or in tracing, where that is not known): from dark blue (small: rays that stay close to each other) to yellow (large), by the logarithm of the area. Black: no ray. Rates are of the trace alone: of unsorted rays by its median, of sorted ones by that and the trace speedup in parentheses; speedups are those of this queue, medians over rounds. Areas in unit space, {}.",
        findings.analysis.group_width,
        ranges.join("; ")
    );
    let reason = reasons.into_iter().next().unwrap_or_else(|| "there is no recording".to_owned());
    figure("One view, unsorted and sorted", caption, settings(shown), panels, reason)
}

/// The areas of the first colour and of the last, of both views.
fn range(found: &Headline) -> (f64, f64) {
    let areas = found.views.iter().flat_map(|view| view.areas.iter().flatten().copied());
    let mut areas: Vec<f64> = areas.filter(|area| *area > 0.0).collect();
    areas.sort_by(f64::total_cmp);
    let cut = (areas.len() as f64 * CUT_SHARE) as usize;
    match areas.get(cut..areas.len().saturating_sub(cut)) {
        Some([low, .., high]) => (*low, *high),
        _ => (1.0, 1.0),
    }
}

fn panel(of: &str, found: &Headline, view: &View, (low, high): (f64, f64)) -> Panel {
    let colour = |area: &Option<f64>| {
        let place = |area: f64| ((area / low).ln() / (high / low).ln()) as f32;
        area.map_or(NO_RAY, |area| ColourMap::Viridis.colour(place(area)))
    };
    let picture = Picture {
        width: found.width,
        height: found.height,
        rgb: view.areas.iter().map(colour).collect(),
        colour_bar: None,
    };
    let net = view.net.map_or(String::new(), |net| format!(", net {}", times(net)));
    let speedup = match &*view.method {
        UNSORTED => String::new(),
        _ => format!(" (trace {}{net})", times(view.speedup)),
    };
    let title = format!("{of}{}: {} Mrays/s{speedup}", view.method, rate(view.mrays_per_second));
    Panel::picture(title, picture)
}

/// Three digits, as many as a clock is good for.
pub(super) fn rate(mrays_per_second: f64) -> String {
    let whole_digits = mrays_per_second.max(1.0).log10() as usize + 1;
    format!("{mrays_per_second:.*}", 3usize.saturating_sub(whole_digits))
}
