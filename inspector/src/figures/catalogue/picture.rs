//! The picture beside the work behind each pixel.

use formats::reader::Dump;

use super::building::{figure, panel_title, settings};
use super::{Findings, Made};
use crate::analysis::picture::PixelCost;
use crate::analysis::{Metric, RecordingAnalysis};
use crate::colour_map::{ColourMap, STEPS};
use crate::figures::model::{ColourBar, Panel, Picture};

/// Share of the pixels whose work is within the colour bar; the others have its last colour.
const SHOWN_SHARE: f64 = 0.99;

/// The image, and the nodes and triangles behind each of its pixels.
pub fn pixel_cost(findings: &Findings<'_>) -> Made {
    let (mut panels, mut reasons) = (Vec::new(), Vec::new());
    let (mut shown, mut shown_of) = (Vec::<PixelCost>::new(), Vec::new());
    for recording in &findings.analysis.recordings {
        let cost = Dump::open(&recording.root).map_or_else(Metric::missing, |dump| PixelCost::of(&dump));
        match cost {
            // A replay has the picture of its source, and often the work.
            Metric::Known(cost) if shown.contains(&cost) => {}
            Metric::Known(cost) => {
                panels.extend(beside(findings, recording, &cost));
                shown.push(cost);
                shown_of.push(recording);
            }
            Metric::Missing { missing } => reasons.push(missing),
        }
    }
    figure(
        "The picture, and the work behind each pixel",
        "Left the picture (Reinhard's tone map of its luminance), right the hierarchy nodes visited and triangles tested for each pixel, over all bounces and both kinds of rays of one pass. The last colour stands for all that is above it.",
        settings(shown_of),
        panels,
        reasons.into_iter().next().unwrap_or_else(|| "there is no recording".to_owned()),
    )
}

fn beside(findings: &Findings<'_>, recording: &RecordingAnalysis, cost: &PixelCost) -> [Panel; 2] {
    let panel = |title: &str, picture: Picture| {
        let title = panel_title(findings, recording, title);
        Panel::picture(title, picture)
    };
    let PixelCost { width, height, image, work, .. } = cost;
    let (width, height) = (*width, *height);
    let photograph =
        Picture { width, height, rgb: image.iter().map(tone_mapped).collect(), colour_bar: None };
    let most = shown_most(work);
    let colours = ColourMap::Viridis.colours();
    let colour =
        |&work: &u32| colours[((f64::from(work) / most * (STEPS - 1) as f64) as usize).min(STEPS - 1)];
    let map = Picture {
        width,
        height,
        rgb: work.iter().map(colour).collect(),
        colour_bar: Some(ColourBar { label: String::new(), range: (0.0, most), colours: colours.to_vec() }),
    };
    [panel("picture", photograph), panel("nodes + triangles per pixel", map)]
}

/// The work that most pixels do not exceed; at least 1.
fn shown_most(work: &[u32]) -> f64 {
    let mut sorted = work.to_vec();
    let place = (sorted.len().saturating_sub(1) as f64 * SHOWN_SHARE) as usize;
    if sorted.is_empty() {
        return 1.0;
    }
    f64::from(*sorted.select_nth_unstable(place).1).max(1.0)
}

/// Linear RGB as sRGB: luminance by Reinhard et al. 2002, equation 3, then the sRGB curve.
fn tone_mapped(linear: &[f32; 3]) -> [u8; 3] {
    let rgb = linear.map(|value| if value.is_finite() { f64::from(value.max(0.0)) } else { 0.0 });
    let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    rgb.map(|value| {
        let value = (value / (1.0 + luminance)).min(1.0);
        let curved = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (curved * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_mapping_keeps_black_and_never_overflows() {
        assert_eq!(tone_mapped(&[0.0, -1.0, f32::NAN]), [0, 0, 0]);
        assert_eq!(tone_mapped(&[1e30, 1e30, 1e30]), [255, 255, 255]);
        // A luminance of 1 becomes a half, which sRGB writes as 188.
        assert_eq!(tone_mapped(&[1.0, 1.0, 1.0]), [188, 188, 188]);
    }

    #[test]
    fn a_few_bright_pixels_do_not_darken_the_others() {
        let work: Vec<u32> = (0..1000).map(|i| if i < 5 { 1_000_000 } else { i % 100 }).collect();
        assert!(shown_most(&work) < 100.0);
        assert_eq!(shown_most(&[]), 1.0);
        assert_eq!(shown_most(&[0, 0]), 1.0);
    }
}
