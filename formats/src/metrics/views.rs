//! Means over scenes that were each seen from several views, with intervals.

use super::speedup::{INTERVAL_ROUNDS, Speedup, SplitMix, median_of, tail_of};

/// How many resamples an interval is taken from, and how few where there are very many views.
const RESAMPLES: [usize; 2] = [200, 1000];
/// Views that are drawn for an interval at most, but for the fewest resamples.
const DRAWN_VIEWS: usize = 20_000_000;
/// Medians that are drawn for the views of a scene together, but for the fewest of a view.
const DRAWN_MEDIANS: usize = 50_000;
/// Medians that are drawn for each view at least.
const FEWEST_MEDIANS: usize = 16;

/// Speedups of a scene: for each view the ratios of its rounds.
pub type Scene = Vec<Vec<f64>>;

/// A mean over scenes: of each view the median over rounds, of each scene the geometric mean over its views, of those
/// the geometric mean. Ratios are averaged as logarithms, so that twice as fast and half as fast cancel.
///
/// The interval holds the mean over all views of these scenes with 95 % confidence: scenes are what they are, views
/// and rounds are drawn again (a bootstrap in two stages, percentiles, a fixed seed). Few views deviate too little
/// from their own mean, so that their deviations are widened by √(k / (k − 1)) for k of them, and the tails as for
/// few rounds. With one view a scene it is an interval over rounds alone. `None` with fewer than six rounds, or with
/// fewer than five views more than scenes where some have several. Rounds without a positive number do not count.
///
/// `None` if a scene has no round.
pub fn mean_over_views(scenes: &[Scene]) -> Option<Speedup> {
    let scenes: Vec<Scene> = scenes.iter().map(logarithms).collect();
    let centres: Vec<f64> = scenes.iter().map(centre).collect::<Option<_>>()?;
    if scenes.is_empty() {
        return None;
    }
    let ratio = mean(&centres).exp();
    let views: usize = scenes.iter().map(Vec::len).sum();
    let rounds = scenes.iter().flatten().map(Vec::len).min().unwrap_or(0);
    let drawn = if views > scenes.len() { views - scenes.len() + 1 } else { rounds };
    if rounds < INTERVAL_ROUNDS || drawn < INTERVAL_ROUNDS {
        return Some(Speedup { ratio, interval: None });
    }
    let mut random = SplitMix::new();
    let medians: Vec<Vec<f64>> = scenes.iter().map(|views| medians_again(views, &mut random)).collect();
    let [fewest, most] = RESAMPLES;
    let resamples = (DRAWN_VIEWS / views).clamp(fewest, most);
    let mut means: Vec<f64> = (0..resamples)
        .map(|_| {
            let scene = |((views, medians), centre): ((&Scene, &Vec<f64>), &f64)| {
                let count = views.len() as f64;
                let again: f64 = (0..views.len()).map(|_| medians[random.below(medians.len())]).sum();
                let widening = if views.len() > 1 { (count / (count - 1.0)).sqrt() } else { 1.0 };
                centre + widening * (again / count - centre)
            };
            mean(&scenes.iter().zip(&medians).zip(&centres).map(scene).collect::<Vec<_>>())
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let tail = (resamples as f64 * tail_of(drawn)) as usize;
    Some(Speedup { ratio, interval: Some((means[tail].exp(), means[resamples - 1 - tail].exp())) })
}

/// Medians of each view's rounds, drawn again: as many of each as of any other, so that drawing one of them is
/// drawing a view and then its rounds. The more views there are, the fewer medians each needs.
fn medians_again(views: &Scene, random: &mut SplitMix) -> Vec<f64> {
    let draws = (DRAWN_MEDIANS / views.len()).clamp(FEWEST_MEDIANS, RESAMPLES[1]);
    let drawn = views.iter().flat_map(|view| std::iter::repeat_n(view, draws));
    drawn.filter_map(|view| median_of(&mut random.resample(view))).collect()
}

/// The mean of one scene, as in [`mean_over_views`].
pub fn mean_of_scene(views: &Scene) -> Option<f64> {
    centre(&logarithms(views)).map(f64::exp)
}

/// Of the rounds that count, in views that have any.
fn logarithms(views: &Scene) -> Scene {
    let of_view = |view: &Vec<f64>| -> Vec<f64> {
        view.iter().filter(|ratio| **ratio > 0.0 && ratio.is_finite()).map(|ratio| ratio.ln()).collect()
    };
    views.iter().map(of_view).filter(|view| !view.is_empty()).collect()
}

/// Mean over views of medians over rounds.
fn centre(views: &Scene) -> Option<f64> {
    let medians: Vec<f64> = views.iter().filter_map(|view| median_of(&mut view.clone())).collect();
    (!medians.is_empty()).then(|| mean(&medians))
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_by_hand() {
        // Medians 2 and 8 of one scene, 1 of the other: 4 and 1, whose mean is 2.
        let scenes = [vec![vec![2.0, 1.0, 3.0], vec![8.0, 8.0, 9.0]], vec![vec![1.0, 1.0, 1.0]]];
        let mean = mean_over_views(&scenes).unwrap();
        assert!((mean.ratio - 2.0).abs() < 1e-12 && mean.interval.is_none(), "{mean:?}");
        assert_eq!(mean_over_views(&[]), None);
        assert_eq!(mean_over_views(&[vec![vec![1.0]], vec![vec![f64::NAN]]]), None);
        let steady = mean_over_views(&[vec![vec![1.5; 6]]]).unwrap();
        let (low, high) = steady.interval.unwrap();
        assert!((low - 1.5).abs() < 1e-12 && (high - 1.5).abs() < 1e-12);
    }

    /// Made-up studies whose true mean is known: how many intervals hold it.
    fn coverage(scenes: usize, views: usize, spread_of_views: f64) -> usize {
        let mut random = fastrand::Rng::with_seed(7);
        let mut normal = move || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let truth: Vec<f64> = (0..scenes).map(|scene| 0.1 * scene as f64).collect();
        let mut held = 0;
        for _ in 0..200 {
            let study: Vec<Scene> = truth
                .iter()
                .map(|scene| {
                    let view = |_| {
                        let centre = scene + spread_of_views * normal();
                        (0..8).map(|_| (centre + 0.05 * normal()).exp()).collect()
                    };
                    (0..views).map(view).collect()
                })
                .collect();
            let (low, high) = mean_over_views(&study).unwrap().interval.unwrap();
            let mean = (truth.iter().sum::<f64>() / scenes as f64).exp();
            held += usize::from(low <= mean && mean <= high);
        }
        held
    }

    #[test]
    fn intervals_hold_the_mean_as_often_as_they_say() {
        for (scenes, views, spread) in [(4, 3, 0.1), (1, 8, 0.2), (5, 1, 0.0), (3, 4, 0.02)] {
            let held = coverage(scenes, views, spread);
            assert!((182..=200).contains(&held), "{scenes} scenes, {views} views: {held} of 200");
        }
    }
}
