//! Names of lines beside their right ends, where a legend would be far from them.

use super::FigureError;
use super::axis::Mapping;
use super::mark;
use super::model::{Content, Figure, Panel, Point, Series};
use super::style::{LINE_HEIGHT, TEXT_SIZE};
use super::svg::{Area, text_style, units};
use super::text;

/// Most names beside a panel: more are found faster below it.
const MOST: usize = 7;
/// From the plot area to the marker of a name, and from there to the name, points.
const TO_MARKER: f64 = 10.0;
const TO_NAME: f64 = 4.5;
/// Widest name, points.
const WIDEST: f64 = 70.0;
/// From one name to the next, points.
const STEP: f64 = TEXT_SIZE * LINE_HEIGHT;

/// A name beside the end of its line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LineName {
    text: String,
    style: usize,
    /// Where the line ends, points to the right and below the plot area's upper left corner.
    end: (f64, f64),
    /// Middle of the name, points below the plot area's upper end.
    middle: f64,
}

/// Whether a figure of so many panels beside each other shows nothing but lines, few enough to be named at their ends.
pub(crate) fn are_beside(figure: &Figure, columns: usize) -> bool {
    let can_be_named = |panel: &Panel| {
        let Content::Lines(lines) = &panel.content else { return false };
        let named: Vec<&Series> = lines.iter().filter(|line| !line.label.is_empty()).collect();
        (1..=MOST).contains(&named.len())
            && named.iter().all(|line| text::width(&line.label, TEXT_SIZE) <= WIDEST)
    };
    columns == 1 && figure.panels.iter().all(can_be_named)
}

/// Room that the names of a panel take beside it, points.
pub(crate) fn room(names: &[LineName]) -> f64 {
    let widest = names.iter().map(|name| text::width(&name.text, TEXT_SIZE)).fold(0.0, f64::max);
    if names.is_empty() { 0.0 } else { TO_MARKER + TO_NAME + widest }
}

impl LineName {
    /// The names of a panel's lines, none above another, each as near as it can be to the end of its line.
    pub(crate) fn all(panel: &Panel, axes: (&Mapping, &Mapping), (width, height): (f64, f64)) -> Vec<Self> {
        let end = |line: &Series| {
            let place = |at: &Point| Some((axes.0.place(at.x)?, axes.1.place(at.y)?));
            let (right, up) = line.points.iter().rev().find_map(place)?;
            Some((right * width, (1.0 - up) * height))
        };
        let named = panel.content.series().iter().filter(|line| !line.label.is_empty());
        let mut names: Vec<Self> = named
            .filter_map(|line| {
                let end = end(line)?;
                Some(Self { text: line.label.clone(), style: line.style, end, middle: end.1 })
            })
            .collect();
        names.sort_by(|a, b| a.end.1.total_cmp(&b.end.1));
        let middles = spread(&names.iter().map(|name| name.end.1).collect::<Vec<_>>(), height);
        names.iter_mut().zip(middles).for_each(|(name, middle)| name.middle = middle);
        names
    }

    /// Draws it beside a plot area, whose upper left corner and width these are.
    ///
    /// # Errors
    /// As plotters: none is known.
    pub(crate) fn draw(&self, page: &Area, (left, top): (f64, f64), width: f64) -> Result<(), FigureError> {
        let at = |right: f64, down: f64| (units(left + right), units(top + down));
        let marker = at(width + TO_MARKER, self.middle);
        page.draw(&mark::leader([at(self.end.0, self.end.1), at(width, self.end.1), marker]))?;
        page.draw(&mark::marker(marker, self.style, String::new()))?;
        let place = at(width + TO_MARKER + TO_NAME, self.middle - 0.5 * STEP);
        page.draw_text(&self.text, &text_style(TEXT_SIZE), place)?;
        Ok(())
    }
}

/// Ascending places at least a step apart and inside `height` as far as they have room, each moved as little as the
/// squares of all moves together allow: the pool-adjacent-violators algorithm on places less their steps.
fn spread(ends: &[f64], height: f64) -> Vec<f64> {
    // Sum and number of the places that are moved together.
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for (at, end) in ends.iter().enumerate() {
        pools.push((end - STEP * at as f64, 1));
        while let [.., (before, b), (last, l)] = pools[..]
            && before / b as f64 > last / l as f64
        {
            pools.truncate(pools.len() - 2);
            pools.push((before + last, b + l));
        }
    }
    let highest = (height - STEP * (ends.len().max(1) - 1) as f64).max(0.0);
    let starts = pools.iter().flat_map(|&(sum, count)| std::iter::repeat_n(sum / count as f64, count));
    starts.enumerate().map(|(at, start)| start.clamp(0.0, highest) + STEP * at as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_moved_apart_and_no_further() {
        let near = |ends: &[f64], expected: &[f64]| {
            let found = spread(ends, 100.0);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        };
        near(&[10.0, 40.0, 90.0], &[10.0, 40.0, 90.0]);
        near(&[50.0, 50.0, 80.0], &[50.0 - 0.5 * STEP, 50.0 + 0.5 * STEP, 80.0]);
        // At the ends there is room on one side alone.
        near(&[0.0, 1.0], &[0.0, STEP]);
        near(&[99.0, 100.0], &[100.0 - STEP, 100.0]);
        assert_eq!(spread(&[], 100.0), [0.0; 0]);
    }
}
