//! The image plane coloured by each ray's place in the order; the key of the ray under the pointer.

use std::ops::Range;
use std::sync::Arc;

use egui::Color32;
use formats::metrics::quantity::Quantity;
use rayon::prelude::*;
use serde::de::Error as _;

use super::brush::brush;
use super::colour_bar;
use super::notes::{about_ray, found, missing, select};
use super::picture::{DrawnPicture, Painted, Picture};
use crate::analysis::GroupWidth;
use crate::analysis::image_plane::ImagePlane;
use crate::colour_map::ColourMap;
use crate::filter::Expression;
use crate::model::colour_by::ColourBy;
use crate::model::derived::Filtered;
use crate::model::key::ReadKey;
use crate::model::numbers::Numbers;
use crate::model::{Context, Order, Recording};
use crate::output::{count, counted};
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::render::range::{ValueRange, Values};
use crate::theme::{Theme, opaque};

/// What pixels may be coloured by.
const COLOURS: [(Quantity, &str); 8] = [
    (Quantity::Place, "First rays of the order dark, last ones bright"),
    (Quantity::Displacement, "How far sorting moved the ray from its place in pixel order"),
    (Quantity::Key, "The key over the largest key of as many bits"),
    (Quantity::Nodes, "Heat: nodes of the hierarchy that the ray visited"),
    (Quantity::Triangles, "Heat: triangles that the ray was tested against"),
    (Quantity::Lanes, "Lane utilisation of the ray's group: dark where lanes wait"),
    (Quantity::Length, "Traced length"),
    (Quantity::Area, "Capsule area of the ray's group: bright where rays of a group scatter"),
];

/// What the picture depends on: the order, the filter and whether it is known yet, the places that the playhead
/// leaves, and the colours.
type Wanted = (u64, Option<(Arc<Expression>, GroupWidth, bool)>, Range<usize>, (Quantity, GroupWidth), bool);

pub(super) struct PixelsPanel {
    colouring: Quantity,
    picture: Picture<Wanted>,
}

impl Default for PixelsPanel {
    fn default() -> Self {
        Self { colouring: Quantity::Place, picture: Picture::default() }
    }
}

impl Panel for PixelsPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let Some(order) = found(ui, context.order()) else { return };
        if !context.is_bare {
            ui.horizontal_wrapped(|ui| {
                for (quantity, about) in COLOURS {
                    ui.selectable_value(&mut self.colouring, quantity, quantity.name()).on_hover_text(about);
                }
            });
        }
        let filtered = context.filtered(&order);
        let rays = counted(order.len() as u64, "ray", "rays");
        let rays = match &filtered {
            Filtered::Some(passing) => format!("{} of {rays}", count(passing.len() as u64)),
            _ => rays,
        };
        let is_row = context.recording().is_some_and(|open| open.dump.manifest().header.options.height == 1);
        let folded = if is_row { ", one row of a picture folded into a square" } else { "" };
        ui.weak(format!("{}, {rays} by {}{folded}", self.colouring.name(), order.method));
        let Some(plane) = context.recording().map(Recording::image_plane) else { return };
        let Some(numbers) = context.numbers(order.clone()) else { return };
        if let Some(reason) = self.colouring.missing(&numbers.rays()) {
            return missing(ui, reason.to_owned());
        }
        let (selection, theme) = (&context.selection, Theme::of(ui.ctx()));
        let is_known = !matches!(filtered, Filtered::Unknown);
        let filter =
            selection.filter.in_force().cloned().map(|filter| (filter, selection.group_width, is_known));
        let played = context.playhead.places(order.len());
        let key = (
            order.serial,
            filter,
            played.clone(),
            (self.colouring, selection.group_width),
            ui.visuals().dark_mode,
        );
        // The lines under the picture have their place before there is a ray to speak of.
        let lines = 3.0 * ui.text_style_height(&egui::TextStyle::Small) + colour_bar::height(ui) + 16.0;
        let shown = ui
            .allocate_ui((ui.available_size() - egui::vec2(0.0, lines)).max(egui::Vec2::ZERO), |ui| {
                let colouring = self.colouring;
                let make = move || pixels((&numbers, &filtered, &played), plane, colouring, theme);
                self.picture.show(ui, context.waker(), ("pixels", key), plane.size(), make)
            })
            .inner;
        // The ray of a pixel, or else of the nearest one whose path is still alive.
        let alive = |at| plane.near(at, REACH).find_map(|path| order.queue.ray_of_pixel(path));
        let under_pointer = shown.pixel.and_then(alive);
        if shown.response.clicked() {
            select(ui, context, under_pointer);
        }
        mark(&shown, context, &order, (plane, theme));
        let colouring = self.colouring;
        let legend = self.picture.legend(ui, map(colouring), colouring.logarithm(), &colouring.title());
        // Of a key colours say a part alone.
        if let Some((bar, range)) = legend.filter(|_| colouring != Quantity::Key) {
            let number_at = |x: f32| {
                let value = range.low + (x - bar.rect.left()) / bar.rect.width() * (range.high - range.low);
                f64::from(colouring.logarithm().map_or(value, |base| base.powf(value)))
            };
            brush(ui, &bar, (colouring, number_at), context);
        }
        if let Some(ray) = under_pointer.or(context.selection.ray) {
            ui.small(about_ray(&order, ray));
        }
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let order = context.order()?;
        let width = context.recording().map_or(1, |open| open.dump.manifest().header.options.width.max(1));
        let rows = (0..order.len()).map(move |ray| {
            let (pixel, place) = (order.queue.path_ids[ray], order.place_of_ray()[ray]);
            let key = ReadKey::of(&order, ray).map_or_else(|_| String::new(), |key| key.hexadecimal());
            let [column, row] = [pixel % width, pixel / width];
            vec![column.to_string(), row.to_string(), ray.to_string(), place.to_string(), key]
        });
        Ok(Data::new(&["column", "row", "ray", "place", "key"], rows))
    }

    fn state(&self) -> serde_json::Value {
        serde_json::json!({ "colouring": self.colouring })
    }

    fn set_state(&mut self, state: serde_json::Value) -> Result<(), serde_json::Error> {
        let colouring = serde_json::from_value(state["colouring"].clone())?;
        if COLOURS.iter().all(|(known, _)| *known != colouring) {
            return Err(serde_json::Error::custom("pixels are not coloured by that"));
        }
        self.colouring = colouring;
        Ok(())
    }
}

/// Farthest that a living path may be from the pointer, points of the picture.
const REACH: u32 = 3;

fn map(colouring: Quantity) -> ColourMap {
    match colouring {
        Quantity::Place | Quantity::Displacement | Quantity::Key => ColourMap::Turbo,
        _ => ColourMap::Magma,
    }
}

/// A colour for each pixel; grey where the ray does not pass the filter or the playhead.
fn pixels(
    (numbers, filtered, played): (&Numbers, &Filtered, &Range<usize>),
    plane: ImagePlane,
    colouring: Quantity,
    theme: Theme,
) -> Painted {
    let order = &*numbers.order;
    let last = order.len().saturating_sub(1).max(1) as f32;
    let values = ColourBy::Quantity(colouring).values(numbers, 0..order.len());
    // Every place has one ray.
    let sorted = match colouring {
        Quantity::Place => Values::default(),
        _ => Values::of(values.par_iter().copied()),
    };
    let range = match colouring {
        Quantity::Place | Quantity::Displacement => ValueRange { low: 0.0, high: last },
        Quantity::Key => ValueRange { low: 0.0, high: 1.0 },
        _ => sorted.percentiles(2.0, 98.0),
    };
    let map = map(colouring);
    let place_of_ray = order.place_of_ray();
    let value = |ray: usize| range.part(values[place_of_ray[ray] as usize]);
    let is_shown = |place: usize| played.contains(&place) && filtered.contains(place);
    let colours: Vec<Color32> = (0..order.len())
        .into_par_iter()
        .map(|ray| match value(ray) {
            _ if !is_shown(place_of_ray[ray] as usize) => theme.left_out(),
            value if value.is_nan() => theme.nothing(),
            value => opaque(map.colour(value)),
        })
        .collect();
    let [columns, rows] = plane.size();
    let mut pixels = vec![theme.nothing(); columns * rows];
    for (colour, &path) in colours.into_iter().zip(&*order.queue.path_ids) {
        if let Some([column, row]) = plane.point(path) {
            pixels[row as usize * columns + column as usize] = colour;
        }
    }
    Painted { pixels, range, values: sorted }
}

/// Marks what is selected: rings at the rays, dots at the rays of their groups.
fn mark(shown: &DrawnPicture, context: &Context, order: &Order, (plane, theme): (ImagePlane, Theme)) {
    let colour = theme.selected_mark();
    let at = |ray: usize| Some(shown.rect_of(plane.point(order.queue.path_ids[ray])?).center());
    let (groups, width) = (context.selection.groups(order), context.selection.group_width);
    let places = groups.into_iter().flat_map(|group| order.places_of_group(group, width));
    for centre in places.filter_map(|place| at(order.places.ray(place))) {
        shown.painter.circle_filled(centre, 1.5, colour);
    }
    for centre in context.selection.rays().into_iter().filter(|&ray| ray < order.len()).filter_map(at) {
        shown.painter.circle_stroke(centre, 6.0, egui::Stroke::new(1.5, colour));
    }
}
