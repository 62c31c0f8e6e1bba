//! What can be asked of a figure before it is drawn.

use std::collections::BTreeMap;

use super::FigureError;
use super::model::{Content, Figure, Panel, Scale, Series};

impl Content {
    /// Its series; none for a picture.
    pub fn series(&self) -> &[Series] {
        match self {
            Self::Lines(series) | Self::Scatter(series) | Self::Bars(series) | Self::Stacks(series) => series,
            Self::Picture(_) => &[],
        }
    }

    /// Every number that must have a place on the upward axis: values, ends of spreads, tops of stacks.
    pub(crate) fn reached(&self) -> Vec<f64> {
        let mut reached = Vec::new();
        let mut tops: BTreeMap<u64, f64> = BTreeMap::new();
        for point in self.series().iter().flat_map(|series| &series.points) {
            let below = match self {
                Self::Stacks(_) if point.y.is_finite() => {
                    let top = tops.entry(point.x.to_bits()).or_insert(0.0);
                    *top += point.y;
                    *top - point.y
                }
                _ => 0.0,
            };
            reached.push(below + point.y);
            if let Some((low, high)) = point.spread {
                reached.extend([below + low, below + high]);
            }
        }
        reached
    }
}

impl Figure {
    /// Whether it can be drawn: its name is a file name, bars stand at categories, points on an axis
    /// of categories are places in its list, and pictures have as many pixels as their sides say.
    ///
    /// # Errors
    /// If not: what contradicts what.
    pub fn check(&self) -> Result<(), FigureError> {
        let refuse = |what: String| Err(FigureError::Contradiction { figure: self.name.clone(), what });
        let is_word = |character: char| character.is_ascii_alphanumeric() || "-_.".contains(character);
        if self.name.is_empty() || self.name.starts_with('.') || !self.name.chars().all(is_word) {
            return refuse("its name is not made of letters, digits, - and _".to_owned());
        }
        if self.panels.is_empty() {
            return refuse("it has no panels".to_owned());
        }
        for panel in &self.panels {
            if let Some(what) = contradiction(panel) {
                return refuse(what);
            }
        }
        Ok(())
    }
}

fn contradiction(panel: &Panel) -> Option<String> {
    match (&panel.content, &panel.x.scale) {
        (Content::Picture(picture), _) => {
            let expected = u64::from(picture.width) * u64::from(picture.height);
            let found = picture.rgb.len() as u64;
            (found != expected || found == 0)
                .then(|| format!("a picture of {} × {} has {found} pixels", picture.width, picture.height))
        }
        (content, Scale::Categories(names)) => {
            let is_place = |x: f64| x >= 0.0 && x.fract() == 0.0 && x < names.len() as f64;
            let mut points = content.series().iter().flat_map(|series| &series.points);
            let lost = points.find(|point| !is_place(point.x))?;
            Some(format!("{} is at {}, but there are {} categories", lost.name, lost.x, names.len()))
        }
        (Content::Bars(_) | Content::Stacks(_), _) => Some("its bars do not stand at categories".to_owned()),
        (Content::Lines(_) | Content::Scatter(_), _) => None,
    }
}
