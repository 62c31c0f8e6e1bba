//! A figure as SVG: each panel a chart of plotters, the legend below them.

use std::cell::RefCell;
use std::rc::Rc;

use plotters::chart::ChartBuilder;
use plotters::element::Rectangle;
use plotters::style::WHITE;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::FigureError;
use super::axis::Mapping;
use super::layout::{COLOUR_BAR_GAP, COLOUR_BAR_WIDTH, Layout, Plot, TICK_GAP, widest_label};
use super::mark;
use super::model::{ColourBar, Content, Figure};
use super::series;
use super::style::{AXIS_STROKE, Colour, GRID_COLOUR, TEXT_SIZE, TITLE_SIZE, Width};
use super::svg::{Area, Svg, stroke, text_style, units};
use super::text;

/// Of the lines between labelled ones, which show that an axis is not an even one.
const LIGHT_GRID_COLOUR: Colour = Colour([0xf1, 0xf1, 0xf1]);
const GRID_STROKE: f64 = 0.35;

/// Draws a figure.
///
/// # Errors
/// If a picture has another number of pixels than its sides say.
pub fn draw(figure: &Figure, width: Width) -> Result<String, FigureError> {
    let layout = Layout::new(figure, width);
    let svg = Rc::new(RefCell::new(Svg::new(layout.size)));
    let page = Area::from(&svg);
    page.fill(&WHITE)?;
    for plot in &layout.plots {
        panel(&page, plot)?;
        if let Content::Picture(picture) = &plot.panel.content
            && let Some(bar) = &picture.colour_bar
        {
            colour_bar(&page, plot, bar)?;
        }
    }
    layout.legend.draw(&page, layout.legend_place)?;
    let drawn = svg.borrow().finish(&figure.title);
    Ok(drawn)
}

/// A part of the page, points.
fn part(page: &Area, (left, top): (f64, f64), (width, height): (f64, f64)) -> Area {
    page.clone().shrink((units(left), units(top)), (units(width), units(height)))
}

fn panel(page: &Area, plot: &Plot) -> Result<(), FigureError> {
    let (left, right) = (plot.own_left, plot.margins.right);
    let place = (plot.place.0 - left, plot.place.1 - plot.top);
    let size = (left + plot.width + right, plot.top + plot.height + plot.bottom);
    let cell = part(page, place, size);
    cell.titled(&plot.title, text_style(TITLE_SIZE))?;
    let mut chart = ChartBuilder::on(&cell)
        .margin_top(units(plot.top))
        .margin_right(units(right))
        .x_label_area_size(units(plot.bottom))
        .y_label_area_size(units(left))
        .build_cartesian_2d(plot.x.clone(), plot.y.clone())?;
    let axis = stroke(Colour::BLACK, AXIS_STROKE);
    let mut mesh = chart.configure_mesh();
    mesh.axis_style(axis)
        .bold_line_style(stroke(GRID_COLOUR, GRID_STROKE))
        .light_line_style(stroke(LIGHT_GRID_COLOUR, GRID_STROKE))
        .label_style(text_style(TEXT_SIZE))
        .x_desc(&plot.x_label)
        .y_desc(&plot.y_label)
        .set_all_tick_mark_size(units(0.5 * TICK_GAP));
    if plot.panel.content.is_in_rows() {
        mesh.disable_y_mesh();
    }
    if matches!(plot.panel.content, Content::Picture(_)) {
        mesh.disable_mesh();
    }
    mesh.draw()?;
    series::draw(&mut chart, plot)?;
    let (x, y) = (plot.x.range, plot.y.range);
    chart.plotting_area().draw(&Rectangle::new([(x.0, y.0), (x.1, y.1)], axis))?;
    plot.line_names.iter().try_for_each(|name| name.draw(page, plot.place, plot.width))
}

/// The colours of a picture with their numbers, right of it.
fn colour_bar(page: &Area, plot: &Plot, bar: &ColourBar) -> Result<(), FigureError> {
    let Some((numbers, label)) = &plot.colour_bar else { return Ok(()) };
    let place = (plot.place.0 + plot.width + COLOUR_BAR_GAP, plot.place.1);
    let words_width = TICK_GAP + widest_label(numbers) + 1.0;
    let cell = part(page, place, (COLOUR_BAR_WIDTH + words_width, plot.height));
    let mut chart = ChartBuilder::on(&cell)
        .right_y_label_area_size(units(words_width))
        .build_cartesian_2d(Mapping::exact(0.0, 1.0, 2), numbers.clone())?;
    let (low, high) = bar.range;
    let start = |at: usize| low + (high - low) * at as f64 / bar.colours.len() as f64;
    // Each reaches under those above it, so that no seam is seen between them.
    chart.draw_series(bar.colours.iter().enumerate().map(|(at, &colour)| {
        Rectangle::new([(0.0, start(at)), (1.0, high)], stroke(Colour(colour), 0.0).filled())
    }))?;
    let axis = stroke(Colour::BLACK, AXIS_STROKE);
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh()
        .axis_style(axis)
        .label_style(text_style(TEXT_SIZE))
        .set_all_tick_mark_size(units(0.5 * TICK_GAP));
    mesh.draw()?;
    chart.plotting_area().draw(&Rectangle::new([(0.0, low), (1.0, high)], axis))?;
    let length = plot.height.max(text::width(label, TEXT_SIZE));
    let beside = (units(place.0 + COLOUR_BAR_WIDTH + words_width), units(place.1 + 0.5 * length));
    page.draw(&mark::words(label, beside, Pos::new(HPos::Center, VPos::Top), -90))?;
    Ok(())
}
