//! The axes of one panel: how much room their words take, and where they go.

use super::axis::{Mapping, Tick};
use super::canvas::{Anchor, Canvas, Rectangle, Stroke, Text};
use super::model::{Content, Figure, Panel, Scale};
use super::style::{AXIS_STROKE, Colour, GRID_COLOUR, LINE_HEIGHT, TEXT_SIZE, TITLE_SIZE};
use super::text;
use super::tick_labels::{Direction, TickLabels};

/// One line of small text with the gap to the next, points.
pub(crate) const LINE: f64 = TEXT_SIZE * LINE_HEIGHT;
/// Between an axis and its tick labels.
pub(crate) const TICK_GAP: f64 = 4.0;
const TICK_LENGTH: f64 = 2.5;
const TITLE_LINE: f64 = TITLE_SIZE * LINE_HEIGHT;
/// From the middle of a line of text to its baseline, in sizes.
pub(crate) const HALF_CAPITAL: f64 = 0.36;
const COLOUR_BAR_GAP: f64 = 6.0;
const COLOUR_BAR_WIDTH: f64 = 8.0;
const EDGE: f64 = 5.0;
/// Where a logarithmic axis of bars starts at the latest, in lowest values.
const LOWEST_BAR: f64 = 0.7;

/// Between two tick labels of an upward axis, at least.
const Y_TICK_ROOM: f64 = 17.0;
/// Lines beside a colour bar, at most.
const MOST_BAR_LINES: usize = 2;
/// How often a picture's height is settled with the room for its colour bar.
const MOST_FITTINGS: usize = 8;

/// What a panel is given to be measured in, points.
#[derive(Clone, Copy)]
pub(crate) struct Room {
    /// Of the panel with all that stands around it.
    pub(crate) cell_width: f64,
    /// Of the plot area; a picture may take less.
    pub(crate) height: f64,
    /// The least room left of the plot area, so that panels above each other line up.
    pub(crate) left: f64,
    /// The least turn of category labels, so that those of all panels have the same.
    pub(crate) turn: Direction,
}

/// The axes of a panel, measured: the plot area and what stands around it, points.
pub(crate) struct Frame<'a> {
    pub(crate) panel: &'a Panel,
    pub(crate) x: Mapping,
    pub(crate) y: Mapping,
    /// Left of the plot area.
    pub(crate) left: f64,
    /// Right of it.
    pub(crate) right: f64,
    /// Above it.
    pub(crate) top: f64,
    /// Below it.
    pub(crate) bottom: f64,
    /// Of the plot area.
    pub(crate) width: f64,
    /// Of the plot area.
    pub(crate) height: f64,
    /// Lines above it.
    pub(crate) title: Vec<String>,
    /// Lines below the ticks.
    pub(crate) x_label: Vec<String>,
    /// Lines left of the ticks, read from below.
    pub(crate) y_label: Vec<String>,
    /// The words at the ticks below.
    pub(crate) x_ticks: TickLabels,
    /// The numbers beside the colour bar of a picture, and the lines beside these, read from below.
    pub(crate) colour_bar: Option<(Mapping, Vec<String>)>,
}

impl<'a> Frame<'a> {
    /// Measures a panel. Panels of `figure` that have the same axis share its range.
    pub(crate) fn measure(figure: &'a Figure, panel: &'a Panel, room: Room) -> Self {
        let mut frame = Self::with_height(figure, panel, room);
        let Content::Picture(picture) = &panel.content else { return frame };
        // A picture keeps its sides. The lower it is, the more lines, and so the more of its width, the
        // label of its colour bar takes.
        let aspect = f64::from(picture.height.max(1)) / f64::from(picture.width.max(1));
        for _ in 0..MOST_FITTINGS {
            let height = frame.width * aspect;
            if height >= frame.height {
                break;
            }
            frame = Self::with_height(figure, panel, Room { height, ..room });
        }
        let width = (frame.height / aspect).min(frame.width);
        frame.right += frame.width - width;
        frame.width = width;
        (frame.x, frame.x_ticks) = x_mapping(figure, panel, width, frame.left, room.turn);
        frame
    }

    fn with_height(figure: &'a Figure, panel: &'a Panel, room: Room) -> Self {
        let Room { cell_width, height, left, turn } = room;
        let y = y_mapping(figure, panel, height);
        let y_label = text::wrap(&panel.y.label, TEXT_SIZE, height + 20.0);
        let ticks: Vec<String> = y.ticks.iter().map(|tick| tick.label.clone()).collect();
        let y_words = text::widest(&ticks, TEXT_SIZE) + y_label.len() as f64 * LINE + TICK_GAP + 3.0;
        let left = left.max(y_words);
        let colour_bar = colour_bar(panel, height);
        let bar_room = colour_bar.as_ref().map_or(0.0, |(mapping, lines)| {
            let ticks: Vec<String> = mapping.ticks.iter().map(|tick| tick.label.clone()).collect();
            let words = text::widest(&ticks, TEXT_SIZE) + TICK_GAP + lines.len() as f64 * LINE;
            COLOUR_BAR_GAP + COLOUR_BAR_WIDTH + words
        });
        let mut right = EDGE + bar_room;
        let mut width = (cell_width - left - right).max(20.0);
        let (mut x, mut x_ticks) = x_mapping(figure, panel, width, left, turn);
        // The last label may reach over the end of the axis.
        let overhang = x_ticks.overhang(&x, width);
        if overhang > right {
            right = overhang + 1.0;
            width = (cell_width - left - right).max(20.0);
            (x, x_ticks) = x_mapping(figure, panel, width, left, turn);
        }
        let title = text::wrap_evenly(&panel.title, TITLE_SIZE, cell_width - EDGE);
        let x_label = text::wrap_evenly(&panel.x.label, TEXT_SIZE, width + left.min(right));
        let top = title.len() as f64 * TITLE_LINE + EDGE;
        let bar_label = colour_bar.as_ref().map_or(0.0, |(_, lines)| text::widest(lines, TEXT_SIZE));
        let bottom = x_ticks.height() + TICK_GAP + x_label.len() as f64 * LINE + 3.0;
        let bottom = bottom.max(bar_label - height);
        Self {
            panel,
            x,
            y,
            left,
            right,
            top,
            bottom,
            width,
            height,
            title,
            x_label,
            y_label,
            x_ticks,
            colour_bar,
        }
    }

    /// Width of a category, points.
    pub(crate) fn slot(&self) -> f64 {
        self.width / (self.x.range.1 - self.x.range.0)
    }

    /// Draws everything but what the panel shows, with the plot area's upper left corner here; gives
    /// the plot area.
    pub(crate) fn draw(&self, canvas: &mut Canvas, left: f64, top: f64) -> Rectangle {
        let plot = Rectangle { left, top, width: self.width, height: self.height };
        let axis = Stroke { colour: Colour::BLACK, width: AXIS_STROKE, dash: &[] };
        self.draw_grid(canvas, plot);
        canvas.frame(plot, axis);
        self.draw_y_ticks(canvas, plot, axis);
        self.draw_x_ticks(canvas, plot, axis);
        for (at, line) in self.title.iter().enumerate() {
            let above = (self.title.len() - at) as f64 * TITLE_LINE;
            // Over the whole cell, since titles may be wider than narrow axes.
            let centre = left - self.left + 0.5 * (self.left + self.width + self.right);
            let room = 0.5 * text::width(line, TITLE_SIZE);
            let over_plot = left + 0.5 * self.width;
            let fits =
                over_plot + room < left + self.width + self.right && over_plot - room > left - self.left;
            canvas.text(Text {
                text: line,
                place: (if fits { over_plot } else { centre }, top - EDGE - above + TITLE_SIZE),
                size: TITLE_SIZE,
                anchor: Anchor::Middle,
                rotate_degrees: 0.0,
            });
        }
        for (at, line) in self.x_label.iter().enumerate() {
            let below = self.x_ticks.height() + TICK_GAP + at as f64 * LINE + TEXT_SIZE;
            let place = (left + 0.5 * self.width, top + self.height + below + 1.0);
            canvas.text(Text {
                text: line,
                place,
                size: TEXT_SIZE,
                anchor: Anchor::Middle,
                rotate_degrees: 0.0,
            });
        }
        let y_label_left = left - self.left;
        draw_upright(canvas, &self.y_label, y_label_left, top + 0.5 * self.height);
        plot
    }

    fn draw_grid(&self, canvas: &mut Canvas, plot: Rectangle) {
        let stroke = Stroke { colour: GRID_COLOUR, width: 0.5, dash: &[] };
        if matches!(self.panel.content, Content::Picture(_)) {
            return;
        }
        for y in labelled(&self.y).filter_map(|tick| self.y.place(tick.value)) {
            let y = plot.bottom() - y * plot.height;
            canvas.line((plot.left, y), (plot.right(), y), stroke);
        }
        if !matches!(self.panel.x.scale, Scale::Categories(_)) {
            for x in labelled(&self.x).filter_map(|tick| self.x.place(tick.value)) {
                let x = plot.left + x * plot.width;
                canvas.line((x, plot.top), (x, plot.bottom()), stroke);
            }
        }
    }

    fn draw_y_ticks(&self, canvas: &mut Canvas, plot: Rectangle, axis: Stroke) {
        for tick in &self.y.ticks {
            let Some(place) = self.y.place(tick.value) else { continue };
            let y = self.y_of(plot, place);
            let length = if tick.label.is_empty() { 0.6 * TICK_LENGTH } else { TICK_LENGTH };
            canvas.line((plot.left - length, y), (plot.left, y), axis);
            canvas.text(Text {
                text: &tick.label,
                place: (plot.left - TICK_GAP, y + HALF_CAPITAL * TEXT_SIZE),
                size: TEXT_SIZE,
                anchor: Anchor::End,
                rotate_degrees: 0.0,
            });
        }
    }

    fn draw_x_ticks(&self, canvas: &mut Canvas, plot: Rectangle, axis: Stroke) {
        for tick in &self.x.ticks {
            let Some(place) = self.x.place(tick.value) else { continue };
            let x = plot.left + place * plot.width;
            let length = if tick.label.is_empty() { 0.6 * TICK_LENGTH } else { TICK_LENGTH };
            canvas.line((x, plot.bottom()), (x, plot.bottom() + length), axis);
        }
        self.x_ticks.draw(canvas, &self.x, plot);
    }

    /// Pictures count their rows from the top, everything else upwards.
    fn y_of(&self, plot: Rectangle, place: f64) -> f64 {
        match self.panel.content {
            Content::Picture(_) => plot.top + place * plot.height,
            _ => plot.bottom() - place * plot.height,
        }
    }

    /// Draws the colour bar of a picture to the right of the plot area.
    pub(crate) fn draw_colour_bar(&self, canvas: &mut Canvas, plot: Rectangle) {
        let (Content::Picture(picture), Some((mapping, label))) = (&self.panel.content, &self.colour_bar)
        else {
            return;
        };
        let Some(bar) = &picture.colour_bar else { return };
        let area = Rectangle { left: plot.right() + COLOUR_BAR_GAP, width: COLOUR_BAR_WIDTH, ..plot };
        let step = area.height / bar.colours.len().max(1) as f64;
        for (at, &colour) in bar.colours.iter().enumerate() {
            // Each reaches under the next, so that no seam is seen between them.
            let top = area.bottom() - (at + 1) as f64 * step;
            let height = (step * if at == 0 { 1.0 } else { 1.5 }).min(area.bottom() - top);
            canvas.fill(Rectangle { top, height, ..area }, Colour(colour));
        }
        let axis = Stroke { colour: Colour::BLACK, width: AXIS_STROKE, dash: &[] };
        canvas.frame(area, axis);
        let mut widest = 0.0f64;
        for tick in labelled(mapping) {
            let Some(place) = mapping.place(tick.value) else { continue };
            let y = area.bottom() - place * area.height;
            canvas.line((area.right(), y), (area.right() + TICK_LENGTH, y), axis);
            widest = widest.max(text::width(&tick.label, TEXT_SIZE));
            canvas.text(Text {
                text: &tick.label,
                place: (area.right() + TICK_GAP, y + HALF_CAPITAL * TEXT_SIZE),
                size: TEXT_SIZE,
                anchor: Anchor::Start,
                rotate_degrees: 0.0,
            });
        }
        let height = area.height.max(text::widest(label, TEXT_SIZE));
        draw_upright(canvas, label, area.right() + TICK_GAP + widest + 1.0, area.top + 0.5 * height);
    }
}

fn labelled(mapping: &Mapping) -> impl Iterator<Item = &Tick> {
    mapping.ticks.iter().filter(|tick| !tick.label.is_empty())
}

/// Lines that are read from below, their left edge and their middle here.
fn draw_upright(canvas: &mut Canvas, lines: &[String], left: f64, middle: f64) {
    for (at, line) in lines.iter().enumerate() {
        canvas.text(Text {
            text: line,
            place: (left + at as f64 * LINE + TEXT_SIZE, middle),
            size: TEXT_SIZE,
            anchor: Anchor::Middle,
            rotate_degrees: -90.0,
        });
    }
}

fn colour_bar(panel: &Panel, height: f64) -> Option<(Mapping, Vec<String>)> {
    let Content::Picture(picture) = &panel.content else { return None };
    let bar = picture.colour_bar.as_ref()?;
    let mapping = Mapping::exact(bar.range.0, bar.range.1, (height / 24.0) as usize);
    // Of a low picture the label may be higher, rather than take all of its width.
    let label =
        (0..).map(|tenths| text::wrap(&bar.label, TEXT_SIZE, height * (1.0 + 0.1 * f64::from(tenths))));
    let label = label.into_iter().find(|lines| lines.len() <= MOST_BAR_LINES)?;
    Some((mapping, label))
}

fn y_mapping(figure: &Figure, panel: &Panel, height: f64) -> Mapping {
    let room = (height / Y_TICK_ROOM) as usize;
    if let Content::Picture(picture) = &panel.content {
        return pixels(&panel.y.label, picture.height, room);
    }
    let mut values: Vec<f64> = Vec::new();
    for alike in figure.panels.iter().filter(|other| other.y == panel.y) {
        values.extend(alike.references.iter().map(|reference| reference.y));
        values.extend(alike.content.reached());
    }
    if matches!(panel.content, Content::Bars(_) | Content::Stacks(_)) {
        match panel.y.scale {
            Scale::Logarithmic { .. } => {
                // So that the lowest bar has a height.
                let lowest =
                    values.iter().copied().filter(|value| *value > 0.0).fold(f64::INFINITY, f64::min);
                values.push(LOWEST_BAR * lowest);
            }
            _ => values.push(0.0),
        }
    }
    Mapping::new(&panel.y.scale, values, room)
}

/// An axis along a picture; without a label it has no ticks either.
fn pixels(label: &str, count: u32, room: usize) -> Mapping {
    let mut mapping = Mapping::exact(0.0, f64::from(count), room);
    if label.is_empty() {
        mapping.ticks.clear();
    }
    mapping
}

fn x_mapping(
    figure: &Figure,
    panel: &Panel,
    width: f64,
    left: f64,
    turn: Direction,
) -> (Mapping, TickLabels) {
    let values = || {
        let alike = figure.panels.iter().filter(|other| other.x == panel.x);
        alike.flat_map(|other| other.content.series()).flat_map(|series| &series.points).map(|point| point.x)
    };
    let with_room = |room| match &panel.content {
        Content::Picture(picture) => pixels(&panel.x.label, picture.width, room),
        _ => Mapping::new(&panel.x.scale, values(), room),
    };
    if let Scale::Categories(names) = &panel.x.scale {
        return (with_room(0), TickLabels::of_categories(names, width, left, turn));
    }
    let most = ((width / 24.0) as usize).clamp(2, 12);
    let fitting = (2..=most).rev().map(with_room).find(|mapping| TickLabels::fit_level(mapping, width));
    let mapping = fitting.unwrap_or_else(|| with_room(2));
    let labels = TickLabels::of_numbers(&mapping, width);
    (mapping, labels)
}
