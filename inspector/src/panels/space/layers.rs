//! From a selection to vertices: made anew only when the selection or what is shown of it changes.

use std::ops::Range;
use std::sync::Arc;

use formats::metrics::quantity::Quantity;
use formats::reader::Dump;
use rayon::prelude::*;

use super::options::{CapsuleChoice, Options};
use super::places::ShownPlaces;
use crate::analysis::GroupWidth;
use crate::model::background::Background;
use crate::model::colour_by::ColourBy;
use crate::model::derived::{Filtered, Grouped};
use crate::model::filter::{Expression, Passing};
use crate::model::numbers::Numbers;
use crate::model::{Absent, Context, Order};
use crate::render::cell_box::{cell_box, cells};
use crate::render::detail::Detail;
use crate::render::frame::{Layer, Paint, Stage};
use crate::render::geometry::{
    CapsuleInstance, Geometry, RayEnd, Shape, Vertex, box_edges, boxes, curve, ends, rays,
};
use crate::render::range::{ValueRange, Values};
use crate::theme::{ShaderColour, Theme};

/// Rays of a group that are drawn bold.
const SELECTED_WIDTH: f32 = 3.0;

/// Length of an arrow's head, and width of a mark, pixels.
const ARROW_WIDTH: f32 = 9.0;
const MARK_WIDTH: f32 = 8.0;

/// What the vertices of all rays depend on. Of the filter: whether it is known yet which rays pass.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    order: Grouped,
    filter: Option<(Arc<Expression>, bool)>,
    places: Range<usize>,
    detail: usize,
    curve: Option<RayEnd>,
    rays: bool,
    ends: bool,
    cells: Option<usize>,
    colour_by: ColourBy,
    /// The numbers in place of `colour_by`, if there are any, by their own number.
    values: Option<u64>,
    capsules: Option<(CapsuleChoice, usize, Option<usize>)>,
}

/// What the vertices of what is selected depend on.
#[derive(Clone, Debug, PartialEq, Eq)]
struct WantedSelected {
    order: Grouped,
    chosen: (Option<usize>, Option<usize>, Option<u32>),
}

/// What vertices are made of, besides the order.
struct Behind {
    /// The rays that pass the filter; all if `None`.
    passing: Option<Arc<Passing>>,
    values: Option<RayValues>,
    dump: Arc<Dump>,
}

/// The vertices of all rays that are shown.
struct Made {
    places: ShownPlaces,
    curve: Option<Geometry>,
    rays: Option<Geometry>,
    ends: Option<Geometry>,
    capsules: Option<Capsules>,
    cells: Option<(Geometry, ValueRange)>,
    values: Values,
}

/// Bounces that colours tell apart.
const BOUNCES_SHOWN: f32 = 8.0;

/// A number for each ray of a queue, by its canonical index: what rays may be coloured by.
#[derive(Clone, Debug)]
pub struct RayValues {
    /// Two with one number are the same.
    pub id: u64,
    /// What the colour bar says.
    pub title: &'static str,
    /// NaN where it is not known.
    pub of_ray: Arc<Vec<f32>>,
    /// What the ends of the colours stand for; percentiles if `None`.
    pub range: Option<ValueRange>,
}

/// Capsules, and how many there are.
struct Capsules {
    geometry: Geometry,
    shown: usize,
    all: usize,
}

/// Logarithms of areas that colours of capsules stand for, the same in all orders: a capsule around the
/// whole scene has an area of a few units.
pub(super) const AREAS: ValueRange = ValueRange { low: -3.0, high: 1.0 };

/// The vertices of what is selected: its lines, its capsule, the box of its cell.
struct Selected {
    lines: Geometry,
    group: Geometry,
    capsule: Option<Geometry>,
    cell: Option<Geometry>,
}

/// The vertices of the last picture.
#[derive(Default)]
pub struct Layers {
    making: Background<Wanted, Arc<Made>, 1>,
    /// What the picture is made of: while other rays are being made, those of before, if of the same
    /// order and in the same colours.
    made: Option<(Wanted, Arc<Made>)>,
    selected: Option<(WantedSelected, Selected)>,
    problem: Option<Absent>,
    /// What rays are coloured by in place of what the options say.
    values_of_rays: Option<RayValues>,
    range: Option<ValueRange>,
    shown: usize,
    all: usize,
    passing: Option<usize>,
}

impl Layers {
    /// Rays in the last picture, and all rays of the queue.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.made.as_ref().map(|_| (self.shown, self.all))
    }

    /// Rays that pass the filter; `None` without one.
    pub fn passing(&self) -> Option<usize> {
        self.passing
    }

    /// Capsules in the last picture, and all groups of the order; none if it shows no capsules.
    pub(super) fn capsule_counts(&self) -> Option<(usize, usize)> {
        let (_, made) = self.made.as_ref()?;
        made.capsules.as_ref().map(|capsules| (capsules.shown, capsules.all))
    }

    /// The range of the numbers that cells are coloured by, and how many cells there are; none if none are shown.
    pub(super) fn cells(&self) -> Option<(ValueRange, usize)> {
        let (_, made) = self.made.as_ref()?;
        let (geometry, range) = made.cells.as_ref()?;
        let Shape::Boxes(boxes) = geometry.shape() else { return None };
        Some((*range, boxes.len()))
    }

    /// Why the last picture lacks something, if it does.
    pub fn problem(&self) -> Option<&Absent> {
        self.problem.as_ref()
    }

    /// Colours rays by these numbers, or by what the options say.
    pub fn colour_by(&mut self, values: Option<RayValues>) {
        self.values_of_rays = values;
    }

    /// What the colour bar says, if rays are not coloured by what the options say.
    pub(super) fn title(&self) -> Option<&'static str> {
        self.values_of_rays.as_ref().map(|values| values.title)
    }

    /// What the ends of the colours stand for.
    pub(super) fn range(&self) -> Option<ValueRange> {
        self.range
    }

    /// The numbers behind the colours of the rays shown.
    pub(super) fn values(&self) -> Option<&Values> {
        self.made.as_ref().map(|(_, made)| &made.values)
    }

    /// The places shown: what the pointer can choose.
    pub(super) fn places(&self) -> impl Iterator<Item = usize> {
        self.made.iter().flat_map(|(_, made)| made.places.places())
    }

    /// The places of the rays in the last picture.
    pub(super) fn shown_places(&self, options: &Options, rays: usize) -> impl Iterator<Item = usize> {
        let shown = scrubbed(options, rays);
        self.places().filter(move |place| shown.contains(place))
    }

    /// The layers of a picture.
    pub fn show(&mut self, theme: Theme, options: &Options, context: &mut Context) -> Vec<Layer> {
        let order = match context.order() {
            Ok(order) => order,
            Err(absent) => {
                (self.made, self.selected, self.range, self.problem) = (None, None, None, Some(absent));
                return Vec::new();
            }
        };
        let filtered = context.filtered(&order);
        let selection = &context.selection;
        let of_order = (order.serial, selection.group_width);
        let is_known = !matches!(filtered, Filtered::Unknown);
        let key = Wanted {
            order: of_order,
            filter: selection.filter.in_force().map(|filter| (filter.clone(), is_known)),
            places: drawn_from(options, order.len()),
            detail: options.detail,
            curve: options.curve.then_some(options.curve_end),
            rays: options.rays,
            ends: options.ends,
            cells: options.cells.then_some(options.cell_count),
            colour_by: options.colour_by,
            values: self.values_of_rays.as_ref().map(|values| values.id),
            capsules: options.capsules.then(|| {
                let group = selection.group.filter(|_| options.capsule_choice == CapsuleChoice::Selected);
                (options.capsule_choice, options.capsule_count, group)
            }),
        };
        let Some(numbers) = context.numbers(order.clone()) else { return Vec::new() };
        let missing = options.colour_by.missing(&numbers).filter(|_| self.values_of_rays.is_none());
        self.problem = missing.map(Absent::from);
        self.make(numbers, key, filtered.passing(), context);
        let chosen = (selection.ray, selection.group, selection.cell);
        self.passing = filtered.passing().map(|passing| passing.len());
        let key = WantedSelected { order: of_order, chosen };
        if self.selected.as_ref().is_none_or(|(known, _)| *known != key) {
            let selected = Selected::of(&order, &key, context);
            self.selected = Some((key, selected));
        }
        self.layers(theme, options, &order)
    }

    /// Has the vertices of all rays made by another thread.
    fn make(&mut self, numbers: Numbers, key: Wanted, passing: Option<Arc<Passing>>, context: &Context) {
        let Some(recording) = context.recording() else { return };
        if self.made.as_ref().is_some_and(|(known, _)| *known == key) {
            return;
        }
        let behind = Behind { passing, values: self.values_of_rays.clone(), dump: recording.dump.clone() };
        let wanted = key.clone();
        let making = move || Arc::new(Made::of(&numbers, &wanted, &behind));
        match self.making.of(key.clone(), context.waker(), making) {
            Ok(made) => self.made = Some((key, made.clone())),
            Err(absent) => {
                self.problem = Some(absent);
                let shows = |known: &Wanted| (&known.order, known.colour_by) == (&key.order, key.colour_by);
                self.made.take_if(|(known, _)| !shows(known));
            }
        }
    }

    fn layers(&mut self, theme: Theme, options: &Options, order: &Order) -> Vec<Layer> {
        let (Some((_, made)), Some((_, selected))) = (&self.made, &self.selected) else { return Vec::new() };
        let values = self.values_of_rays.as_ref();
        let range = match options.colour_by {
            _ if values.is_some_and(|values| values.range.is_some()) && options.range.is_none() => {
                values.and_then(|values| values.range).unwrap_or(AREAS)
            }
            ColourBy::Quantity(Quantity::Bounce) if values.is_none() => {
                ValueRange { low: 0.0, high: BOUNCES_SHOWN }
            }
            ColourBy::Quantity(Quantity::Place) if values.is_none() => {
                ValueRange { low: 0.0, high: order.len().saturating_sub(1).max(1) as f32 }
            }
            _ if options.range.is_some() => {
                let (low, high) = options.range.unwrap_or_default();
                ValueRange { low, high }
            }
            _ => made.values.percentiles(options.percentiles.0, options.percentiles.1),
        };
        self.range = Some(range);
        let part = made.places.between(&scrubbed(options, order.len()));
        self.shown = part.len();
        self.all = order.len();
        let part = part.start as u32..part.end as u32;
        let drawing = Drawing { options, part, paint: Paint::Values(options.map, range) };
        let mut layers = Vec::new();
        // A line of the curve goes to the next point, so the last point has none.
        layers.extend(made.curve.as_ref().map(|curve| drawing.lines(curve, 1, 0.9)));
        layers.extend(made.rays.as_ref().map(|rays| drawing.lines(rays, 0, 0.7)));
        let heads = made.rays.as_ref().filter(|_| options.arrows);
        layers.extend(heads.map(|rays| Layer {
            stage: Stage::Arrows,
            width: ARROW_WIDTH.max(5.0 * options.line_width),
            ..drawing.lines(rays, 0, 1.0)
        }));
        layers.extend(made.ends.as_ref().map(|ends| Layer {
            stage: Stage::Marks,
            width: MARK_WIDTH,
            ..drawing.lines(ends, 0, 1.0)
        }));
        layers.extend(made.cells.as_ref().map(|(cells, range)| Layer {
            geometry: cells.clone(),
            part: None,
            stage: Stage::Boxes,
            paint: Paint::Values(options.map, *range),
            opacity: options.capsule_opacity,
            hidden_opacity: 0.0,
            width: 0.0,
        }));
        layers.extend(made.capsules.as_ref().map(|capsules| Layer {
            geometry: capsules.geometry.clone(),
            part: None,
            stage: Stage::Capsules,
            paint: Paint::Values(options.map, AREAS),
            opacity: options.capsule_opacity,
            hidden_opacity: 0.0,
            width: 0.0,
        }));
        layers.extend(selected.layers(theme.selected()));
        layers
    }
}

/// The places that the scrub slider leaves.
fn scrubbed(options: &Options, rays: usize) -> Range<usize> {
    let until = (f64::from(options.until) * rays as f64).round();
    let from = (until - f64::from(options.window) * rays as f64).max(0.0).round();
    from as usize..until as usize
}

/// The places that detail is spread over: all of them while the slider leaves everything before it, so
/// that nothing is made anew while it moves; else those that it leaves, which then show more detail.
fn drawn_from(options: &Options, rays: usize) -> Range<usize> {
    if options.window >= 1.0 { 0..rays } else { scrubbed(options, rays) }
}

/// What layers of lines have in common.
struct Drawing<'a> {
    options: &'a Options,
    part: Range<u32>,
    paint: Paint,
}

impl Drawing<'_> {
    fn lines(&self, geometry: &Geometry, fewer: u32, opacity: f32) -> Layer {
        let Range { start, end } = self.part.clone();
        Layer {
            geometry: geometry.clone(),
            part: Some(start..end.saturating_sub(fewer).max(start)),
            stage: Stage::Lines,
            paint: self.paint,
            opacity,
            hidden_opacity: self.options.hidden_opacity,
            width: self.options.line_width,
        }
    }
}

impl Made {
    fn of(numbers: &Numbers, key: &Wanted, behind: &Behind) -> Self {
        let (order, width) = (&*numbers.order, key.order.1);
        let shown = ShownPlaces::of(&key.places, key.detail, behind.passing.clone());
        let values = match &behind.values {
            Some(values) => {
                let value = |place| values.of_ray.get(order.places.ray(place)).copied().unwrap_or(f32::NAN);
                shown.places().map(value).collect()
            }
            None => key.colour_by.values(numbers, shown.places()),
        };
        let places = || shown.places().zip(values.iter().copied());
        Self {
            curve: key.curve.map(|end| curve(order, places(), end).into()),
            rays: key.rays.then(|| rays(order, places()).into()),
            ends: key.ends.then(|| ends(order, places()).into()),
            capsules: key.capsules.map(|(choice, most, group)| capsules(order, width, choice, most, group)),
            cells: key.cells.map(|most| cells(&behind.dump.manifest().header.options, &order.queue, most)),
            values: Values::of(values.into_par_iter()),
            places: shown,
        }
    }
}

/// Capsules as the analysis computes them, coloured by the logarithm of their area over all groups.
fn capsules(
    order: &Order,
    width: GroupWidth,
    choice: CapsuleChoice,
    most: usize,
    group: Option<usize>,
) -> Capsules {
    let groups = order.groups(width);
    let chosen: Vec<usize> = match choice {
        CapsuleChoice::Selected => group.into_iter().collect(),
        CapsuleChoice::Worst => groups.worst(most),
        CapsuleChoice::Spread => Detail::of(&(0..groups.groups.len()), most).places().collect(),
    };
    let value = |area: f64| area.max(1e-12).log10() as f32;
    let found = chosen.into_iter().filter_map(|at| groups.groups.get(at));
    let capsules: Vec<_> =
        found.map(|group| CapsuleInstance::of(&group.capsule, value(group.area))).collect();
    let shown = capsules.len();
    Capsules { geometry: Shape::Capsules(capsules).into(), shown, all: groups.groups.len() }
}

impl Selected {
    fn of(order: &Order, key: &WantedSelected, context: &Context) -> Self {
        let (ray, group, cell) = key.chosen;
        let mut lines: Vec<[Vertex; 2]> = Vec::new();
        let place = ray.and_then(|ray| order.place_of_ray().get(ray));
        if let (Some(&place), Some(_)) = (place, ray)
            && let Shape::Segments(found) = rays(order, std::iter::once((place as usize, 0.0)))
        {
            lines.extend(found);
        }
        let options = context.recording().map(|recording| &recording.dump.manifest().header.options);
        let corners = cell.zip(options).and_then(|(cell, options)| cell_box(options, cell).ok());
        lines.extend(corners.map(|corners| box_edges(corners, 0.0)).unwrap_or_default());
        let cell = corners.map(|corners| boxes(std::iter::once((corners, 0.0))).into());
        let width = key.order.1;
        let places = group.map_or(0..0, |group| order.places_of_group(group, width));
        let found = group.and_then(|group| order.group(group, width));
        let capsule =
            found.map(|group| Shape::Capsules(vec![CapsuleInstance::of(&group.capsule, 0.0)]).into());
        Self {
            lines: Shape::Segments(lines).into(),
            group: rays(order, places.map(|place| (place, 0.0))).into(),
            capsule,
            cell,
        }
    }

    fn layers(&self, colour: ShaderColour) -> Vec<Layer> {
        let layer = |geometry: &Geometry, stage, opacity, width| Layer {
            geometry: geometry.clone(),
            part: None,
            stage,
            paint: Paint::Plain(colour),
            opacity,
            hidden_opacity: 0.0,
            width,
        };
        let capsule = self.capsule.as_ref().map(|capsule| layer(capsule, Stage::Capsules, 0.16, 0.0));
        let group = layer(&self.group, Stage::OnTop, 0.5, 1.0);
        let lines = layer(&self.lines, Stage::OnTop, 1.0, SELECTED_WIDTH);
        let cell = self.cell.as_ref().map(|cell| layer(cell, Stage::Boxes, 0.16, 0.0));
        capsule.into_iter().chain(cell).chain([group, lines]).collect()
    }
}
