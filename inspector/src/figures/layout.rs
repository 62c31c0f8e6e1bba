//! Where the panels of a figure go, and how much room their words take, points.

use std::collections::BTreeMap;

use super::axis::Mapping;
use super::legend::{Legend, entries};
use super::line_names::{self, LineName};
use super::model::{Content, Figure, Panel};
use super::series::has_spreads;
use super::style::{LINE_HEIGHT, TEXT_SIZE, TITLE_SIZE, Width};
use super::text;
use super::tick_labels;

/// Between an axis and its tick labels.
pub(crate) const TICK_GAP: f64 = 4.0;
/// Between a picture and its colour bar.
pub(crate) const COLOUR_BAR_GAP: f64 = 6.0;
/// Of a colour bar, across.
pub(crate) const COLOUR_BAR_WIDTH: f64 = 8.0;
/// Between panels.
const GAP: f64 = 8.0;
/// Around the whole.
const PAGE_EDGE: f64 = 3.0;
/// Above and beside the axes, where there are no words.
const EDGE: f64 = 5.0;
/// Highest picture.
const TALLEST_PICTURE: f64 = 300.0;
/// Width that a panel needs, with numbers on both axes and with names of rows.
const LEAST: f64 = 110.0;
const LEAST_OF_ROWS: f64 = 125.0;
/// Height of a row of dots and of stacks.
const ROW: f64 = 11.0;
/// Of that, what a line of text needs.
const LEAST_ROW_SQUEEZE: f64 = TEXT_SIZE * LINE_HEIGHT / ROW;
/// Highest figure that a column of a page has room for, with its caption.
const HIGHEST: f64 = 650.0;
/// How much lower than usual the panels of a figure are that would be higher.
const SQUEEZES: [f64; 3] = [1.0, 0.85, 0.7];
/// Between two tick labels of an upward axis, at least.
const Y_TICK_ROOM: f64 = 17.0;
/// Lines beside a colour bar, at most.
const MOST_BAR_LINES: usize = 2;
/// How often the room for words is settled with the words that fit beside what is left of it.
const ROUNDS: usize = 8;

/// A figure laid out: panels in a grid as wide as the page, the legend below them.
pub(crate) struct Layout<'a> {
    /// Panels beside each other.
    pub(crate) columns: usize,
    /// Height of a row of dots and of stacks.
    pub(crate) row: f64,
    /// All panels, row by row.
    pub(crate) plots: Vec<Plot<'a>>,
    /// Below them.
    pub(crate) legend: Legend,
    /// Upper left corner of the legend.
    pub(crate) legend_place: (f64, f64),
    /// Of the whole.
    pub(crate) size: (f64, f64),
}

/// What is left beside a plot area for words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Margins {
    pub(crate) left: f64,
    /// With a colour bar, if there is one.
    pub(crate) right: f64,
}

/// A panel laid out.
pub(crate) struct Plot<'a> {
    pub(crate) panel: &'a Panel,
    /// Upper left corner of the plot area on the page.
    pub(crate) place: (f64, f64),
    /// Of the plot area.
    pub(crate) width: f64,
    /// Of the plot area.
    pub(crate) height: f64,
    /// Beside the plot area.
    pub(crate) margins: Margins,
    /// What its own words need of that on the left: panels below each other share the margin, not the place of words.
    pub(crate) own_left: f64,
    /// For words above it.
    pub(crate) top: f64,
    /// For words below it.
    pub(crate) bottom: f64,
    pub(crate) x: Mapping,
    pub(crate) y: Mapping,
    pub(crate) title: String,
    pub(crate) x_label: String,
    pub(crate) y_label: String,
    /// The numbers beside the colour bar of a picture, and what they are.
    pub(crate) colour_bar: Option<(Mapping, String)>,
    /// Of its lines, if they stand beside it.
    pub(crate) line_names: Vec<LineName>,
}

impl<'a> Layout<'a> {
    /// Lays a figure out, no higher than a page if its panels may be lower.
    pub(crate) fn new(figure: &'a Figure, width: Width) -> Self {
        let of = |squeeze: f64| Self::squeezed(figure, width, squeeze);
        let fits = |layout: &Self| layout.size.1 <= HIGHEST;
        SQUEEZES.into_iter().map(of).find(fits).unwrap_or_else(|| of(SQUEEZES[SQUEEZES.len() - 1]))
    }

    fn squeezed(figure: &'a Figure, width: Width, squeeze: f64) -> Self {
        let page = width.points() - 2.0 * PAGE_EDGE;
        let columns = columns(figure, width);
        let mut plots = measure(figure, columns, page - (columns - 1) as f64 * GAP, squeeze);
        let mut below = PAGE_EDGE - GAP;
        for row in plots.chunks_mut(columns) {
            let largest = |part: fn(&Plot) -> f64| row.iter().map(part).fold(0.0, f64::max);
            let (top, bottom) = (largest(|plot| plot.top), largest(|plot| plot.height + plot.bottom));
            let mut beside = PAGE_EDGE;
            for plot in row {
                plot.place = (beside + plot.margins.left, below + GAP + top);
                beside += plot.cell() + GAP;
            }
            below += GAP + top + bottom;
        }
        let legend = Legend::new(entries(figure, line_names::are_beside(figure, columns)), page);
        let size = (page + 2.0 * PAGE_EDGE, (below + legend.height() + 2.0 * PAGE_EDGE).ceil());
        Self {
            columns,
            row: ROW * squeeze.max(LEAST_ROW_SQUEEZE),
            plots,
            legend,
            legend_place: (PAGE_EDGE, below + 0.5 * GAP),
            size,
        }
    }
}

/// Panels beside each other.
fn columns(figure: &Figure, width: Width) -> usize {
    let panels = figure.panels.len().max(1);
    if panels.is_multiple_of(2) && figure.panels.iter().all(is_picture) {
        // A picture and what belongs to it stand beside each other, unless a column is all that they have.
        return if width == Width::OneColumn && panels == 2 { 1 } else { 2 };
    }
    let most = match (width, panels) {
        (Width::OneColumn, 1..=3) => 1,
        (Width::OneColumn, _) => 2,
        (Width::TwoColumn, 4 | 8) => 2,
        (Width::TwoColumn, _) => panels.min(3),
    };
    let widest = figure.panels.iter().map(least_width).fold(0.0, f64::max);
    (2..=most).rev().find(|&columns| width.points() / columns as f64 >= widest).unwrap_or(1)
}

/// How much room a panel needs for what it shows and the words beside it.
fn least_width(panel: &Panel) -> f64 {
    if panel.content.is_in_rows() { LEAST_OF_ROWS } else { LEAST }
}

fn is_picture(panel: &Panel) -> bool {
    matches!(panel.content, Content::Picture(_))
}

/// All panels, in a width without the gaps between them. Plot areas are as wide as each other, and those below each
/// other begin in one line.
fn measure(figure: &Figure, columns: usize, page: f64, squeeze: f64) -> Vec<Plot<'_>> {
    let mut all = vec![Margins { left: 0.0, right: EDGE }; columns];
    let mut plots = Vec::new();
    for _ in 0..ROUNDS {
        let words: f64 = all.iter().map(|margins| margins.left + margins.right).sum();
        let room =
            Room { width: ((page - words) / columns as f64).max(20.0), cell: page / columns as f64, squeeze };
        let panels = figure.panels.iter().enumerate();
        let measured = panels.map(|(at, panel)| {
            let is_repeated = figure.panels.get(at + columns).is_some_and(|below| has_axis_of(below, panel));
            let left = (at % columns > 0).then(|| &figure.panels[at - 1]);
            let repeats = Repeats {
                rows: has_names_of(left, panel),
                across: is_repeated,
                has_line_names: line_names::are_beside(figure, columns),
            };
            Plot::measure(figure, panel, repeats, room, all[at % columns])
        });
        let needed: Vec<Margins>;
        (plots, needed) = measured.unzip();
        let settled = all.clone();
        for (at, needed) in needed.iter().enumerate() {
            let margins = &mut all[at % columns];
            margins.left = margins.left.max(needed.left);
            margins.right = margins.right.max(needed.right);
        }
        if all == settled {
            break;
        }
    }
    plots
}

/// Whether the rows of a panel are those of the one to its left, beside which their names stand.
fn has_names_of(left: Option<&Panel>, panel: &Panel) -> bool {
    left.is_some_and(|left| left.content.is_in_rows() && panel.content.is_in_rows() && left.x == panel.x)
}

/// Whether two panels have the same axis below them.
fn has_axis_of(below: &Panel, panel: &Panel) -> bool {
    match (below.content.is_in_rows(), panel.content.is_in_rows()) {
        (true, true) => below.y == panel.y,
        (false, false) => below.x == panel.x && !is_picture(panel),
        _ => false,
    }
}

/// What a panel need not say, since a neighbour says it, and what it says itself.
#[derive(Clone, Copy)]
struct Repeats {
    /// The names of its rows stand to its left.
    rows: bool,
    /// What is across stands below it.
    across: bool,
    /// Its lines are named beside it.
    has_line_names: bool,
}

/// What a panel has to be laid out in.
#[derive(Clone, Copy)]
struct Room {
    /// Of the plot area.
    width: f64,
    /// Of an average panel, with its words.
    cell: f64,
    /// How much lower than usual it is.
    squeeze: f64,
}

impl<'a> Plot<'a> {
    /// From the left end of its words to the right end.
    fn cell(&self) -> f64 {
        self.margins.left + self.width + self.margins.right
    }

    /// Measures a panel with this room for words; gives the room that its own need. Panels of `figure`
    /// that have the same axis share its range.
    fn measure(
        figure: &'a Figure,
        panel: &'a Panel,
        repeats: Repeats,
        Room { mut width, cell, squeeze }: Room,
        margins: Margins,
    ) -> (Self, Margins) {
        let mut height = squeeze * (0.62 * cell).clamp(90.0, 180.0);
        if let Content::Picture(picture) = &panel.content {
            // A picture keeps its sides.
            let aspect = f64::from(picture.height.max(1)) / f64::from(picture.width.max(1));
            height = (aspect * width).min(1.3 * cell).min(TALLEST_PICTURE);
            width = height / aspect;
        }
        let is_in_rows = panel.content.is_in_rows();
        let (across, upwards) = if is_in_rows { (&panel.y, &panel.x) } else { (&panel.x, &panel.y) };
        let (x, y) = if is_in_rows {
            // The first row is the topmost one.
            let mut y = Mapping::new(&panel.x.scale, [], 0).reversed();
            height = ROW * squeeze.max(LEAST_ROW_SQUEEZE) * (y.range.0 - y.range.1);
            if repeats.rows {
                y.ticks.clear();
            }
            let values = values_of(figure, panel);
            (fitting(width, |room| Mapping::new(&panel.y.scale, values.iter().copied(), room)), y)
        } else {
            (x_mapping(figure, panel, width), y_mapping(figure, panel, height))
        };
        let y_label = text::wrap(&upwards.label, TEXT_SIZE, height + 20.0);
        let across_label = if repeats.across { "" } else { across.label.as_str() };
        let x_label = text::wrap_evenly(across_label, TEXT_SIZE, width + margins.left.min(margins.right));
        let left = widest_label(&y) + text::height(&y_label, TEXT_SIZE) + TICK_GAP + 3.0;
        // It is centred above what the panel has itself: a panel below may have longer names.
        let title_room = left + width + margins.right - EDGE;
        let title = text::wrap_evenly(&panel.title, TITLE_SIZE, title_room);
        let colour_bar = colour_bar(panel, height);
        let bar_room = colour_bar.as_ref().map_or(0.0, |(mapping, label)| {
            let words = widest_label(mapping) + TICK_GAP + text::height(label, TEXT_SIZE);
            COLOUR_BAR_GAP + COLOUR_BAR_WIDTH + words
        });
        // The label of a colour bar may be higher than the picture.
        let bar_label = colour_bar.as_ref().map_or(0.0, |(_, label)| text::width(label, TEXT_SIZE));
        let line_names =
            if repeats.has_line_names { LineName::all(panel, (&x, &y), (width, height)) } else { Vec::new() };
        // The last label may reach over the end of the axis.
        let overhang = tick_labels::overhang(&x, width);
        let words = tick_labels::height(&x) + text::height(&x_label, TEXT_SIZE);
        let needed =
            Margins { left, right: (EDGE + bar_room).max(overhang + 1.0).max(line_names::room(&line_names)) };
        let (place, top) = ((0.0, 0.0), text::height(&title, TITLE_SIZE) + EDGE);
        let bottom = (words + TICK_GAP + 1.5).max(bar_label - height);
        let plot = Self {
            panel,
            place,
            width,
            height,
            margins,
            own_left: needed.left,
            top,
            bottom,
            x,
            y,
            title,
            x_label,
            y_label,
            colour_bar,
            line_names,
        };
        (plot, needed)
    }
}

/// Of the labels at the ticks of an upward axis.
pub(crate) fn widest_label(axis: &Mapping) -> f64 {
    axis.ticks.iter().map(|tick| text::width(&tick.label, TEXT_SIZE)).fold(0.0, f64::max)
}

fn colour_bar(panel: &Panel, height: f64) -> Option<(Mapping, String)> {
    let Content::Picture(picture) = &panel.content else { return None };
    let bar = picture.colour_bar.as_ref()?;
    let mapping = Mapping::exact(bar.range.0, bar.range.1, (height / 24.0) as usize);
    // Of a low picture the label may be higher, rather than take all of its width.
    let mut labels =
        (0..).map(|tenths| text::wrap(&bar.label, TEXT_SIZE, height * (1.0 + 0.1 * f64::from(tenths))));
    Some((mapping, labels.find(|label| label.lines().count() <= MOST_BAR_LINES)?))
}

fn y_mapping(figure: &Figure, panel: &Panel, height: f64) -> Mapping {
    let room = (height / Y_TICK_ROOM) as usize;
    if let Content::Picture(picture) = &panel.content {
        return pixels(&panel.y.label, picture.height, room).reversed();
    }
    Mapping::new(&panel.y.scale, values_of(figure, panel), room)
}

/// Every number of the panels that share the axis of numbers with this one.
fn values_of(figure: &Figure, panel: &Panel) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for alike in figure.panels.iter().filter(|other| other.y == panel.y) {
        values.extend(alike.reference.iter().map(|reference| reference.y));
        values.extend(reached(&alike.content));
    }
    values
}

/// The axis below a panel, with as many labels as have their place beside each other: what `with_labels` gives
/// for so many at most.
fn fitting(width: f64, with_labels: impl Fn(usize) -> Mapping) -> Mapping {
    let thinned = |most| {
        let mut mapping = with_labels(most);
        let are_some_left_out = tick_labels::thin_out(&mut mapping, width);
        (mapping, are_some_left_out)
    };
    let most = ((width / 22.0) as usize).clamp(2, 12);
    let complete = (2..=most).rev().map(thinned).find(|(_, are_some_left_out)| !are_some_left_out);
    complete.unwrap_or_else(|| thinned(2)).0
}

/// Every number that must have a place on the axis of numbers: values, ends of spreads, tops of stacks.
fn reached(content: &Content) -> Vec<f64> {
    let mut reached = Vec::new();
    let mut tops: BTreeMap<u64, f64> = BTreeMap::new();
    for series in content.series() {
        // Parts of numbers are drawn as dots alone.
        let has_spreads = has_spreads(content) && !series.is_part;
        for point in &series.points {
            let below = match content {
                Content::Stacks(_) if point.y.is_finite() => {
                    let top = tops.entry(point.x.to_bits()).or_insert(0.0);
                    *top += point.y;
                    *top - point.y
                }
                _ => 0.0,
            };
            reached.push(below + point.y);
            if let Some((low, high)) = point.spread.filter(|_| has_spreads) {
                reached.extend([below + low, below + high]);
            }
        }
    }
    reached
}

/// An axis along a picture; without a label it has no ticks either.
fn pixels(label: &str, count: u32, room: usize) -> Mapping {
    let mut mapping = Mapping::exact(0.0, f64::from(count), room);
    if label.is_empty() {
        mapping.ticks.clear();
    }
    mapping
}

fn x_mapping(figure: &Figure, panel: &Panel, width: f64) -> Mapping {
    if let Content::Picture(picture) = &panel.content {
        return fitting(width, |most| pixels(&panel.x.label, picture.width, most));
    }
    let alike = figure.panels.iter().filter(|other| other.x == panel.x);
    let points = alike.flat_map(|other| other.content.series()).flat_map(|series| &series.points);
    let values: Vec<f64> = points.map(|point| point.x).collect();
    fitting(width, |most| Mapping::new(&panel.x.scale, values.iter().copied(), most))
}

#[cfg(test)]
mod tests {
    use super::super::model::{Of, Point, Series};
    use super::*;

    #[test]
    fn what_is_not_drawn_takes_no_room() {
        let point = Point { x: 0.0, y: 1.1, spread: Some((0.1, 9.0)), n: 7, of: Of::default() };
        let of = |is_part| {
            let series = Series { is_part, ..Series::new("aila", 0, vec![point.clone()]) };
            reached(&Content::Dots(vec![series]))
        };
        assert_eq!([of(true), of(false)], [vec![1.1], vec![1.1, 0.1, 9.0]]);
    }
}
