//! The picture beside the work behind each pixel.

use formats::reader::Dump;

use super::building::{figure, panel_title, settings};
use super::{Findings, Made};
use crate::analysis::picture::PixelCost;
use crate::analysis::{Metric, RecordingAnalysis};
use crate::figures::model::{Axis, ColourBar, Content, Panel, Picture};

/// Colours of a colour bar.
const COLOURS: usize = 256;
/// Share of the pixels whose work is within the colour bar; the others have its last colour.
const SHOWN_SHARE: f64 = 0.99;

/// The image, and the nodes and triangles behind each of its pixels.
pub fn pixel_cost(findings: &Findings<'_>) -> Made {
    let (mut panels, mut reasons) = (Vec::new(), Vec::new());
    let mut shown: Vec<PixelCost> = Vec::new();
    for recording in &findings.analysis.recordings {
        let cost = Dump::open(&recording.root).map_or_else(Metric::missing, |dump| PixelCost::of(&dump));
        match cost {
            // A replay has the picture of its source, and often the work.
            Metric::Known(cost) if shown.contains(&cost) => {}
            Metric::Known(cost) => {
                panels.extend(beside(findings, recording, &cost));
                shown.push(cost);
            }
            Metric::Missing { missing } => reasons.push(missing),
        }
    }
    figure(
        "The picture, and the work behind each pixel",
        "Left the picture (Reinhard's tone map of its luminance), right the hierarchy nodes visited and triangles tested for each pixel, over all bounces and both kinds of rays of one pass. The last colour stands for all that is above it.",
        settings(findings),
        panels,
        reasons.into_iter().next().unwrap_or_else(|| "there is no recording".to_owned()),
    )
}

fn beside(findings: &Findings<'_>, recording: &RecordingAnalysis, cost: &PixelCost) -> [Panel; 2] {
    let panel = |title: &str, picture: Picture| {
        let title = panel_title(findings, recording, title);
        Panel::new(title, Axis::from_zero(""), Axis::from_zero(""), Content::Picture(picture))
    };
    let PixelCost { width, height, image, work, .. } = cost;
    let (width, height) = (*width, *height);
    let photograph =
        Picture { width, height, rgb: image.iter().map(tone_mapped).collect(), colour_bar: None };
    let most = shown_most(work);
    let colours: Vec<[u8; 3]> = (0..COLOURS).map(|at| viridis(at as f64 / (COLOURS - 1) as f64)).collect();
    let colour = |&work: &u32| colours[(f64::from(work) / most * (COLOURS - 1) as f64).min(255.0) as usize];
    let map = Picture {
        width,
        height,
        rgb: work.iter().map(colour).collect(),
        colour_bar: Some(ColourBar {
            label: "nodes + triangles".to_owned(),
            range: (0.0, most),
            colours: colours.clone(),
        }),
    };
    [panel("picture", photograph), panel("work per pixel", map)]
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

/// The colour map viridis at 0 to 1, by a polynomial of degree 6 (coefficients: Zucker 2019, public
/// domain), which is within 0.01 of the table.
fn viridis(at: f64) -> [u8; 3] {
    const COEFFICIENTS: [[f64; 3]; 7] = [
        [0.277_727_327_223_417_9, 0.005_407_344_544_966_578, 0.334_099_805_335_306_1],
        [0.105_093_043_108_577_4, 1.404_613_529_898_575, 1.384_590_162_594_685],
        [-0.330_861_828_725_556_3, 0.214_847_559_468_213, 0.095_095_163_028_236_59],
        [-4.634_230_498_983_486, -5.799_100_973_351_585, -19.332_440_956_279_87],
        [6.228_269_936_347_081, 14.179_933_366_805_09, 56.690_552_600_681_05],
        [4.776_384_997_670_288, -13.745_145_377_748_57, -65.353_032_633_372_34],
        [-5.435_455_855_934_631, 4.645_852_612_178_535, 26.312_435_249_583_2],
    ];
    let at = at.clamp(0.0, 1.0);
    let channel = |k: usize| COEFFICIENTS.iter().rev().fold(0.0, |sum, row| sum * at + row[k]);
    [0, 1, 2].map(|k| (channel(k).clamp(0.0, 1.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends and middle of matplotlib's table.
    #[test]
    fn viridis_is_that_of_matplotlib() {
        for (at, expected) in [(0.0, [68, 1, 84]), (0.5, [33, 145, 140]), (1.0, [253, 231, 37])] {
            for (found, expected) in viridis(at).into_iter().zip(expected) {
                assert!(found.abs_diff(expected) <= 4, "{at}: {:?}", viridis(at));
            }
        }
    }

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
