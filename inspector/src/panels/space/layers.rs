//! From a selection to vertices: made anew only when the selection or what is shown of it changes.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use formats::metrics::group::Group;
use formats::metrics::quantity::{OrderedRays, Quantity};
use formats::ray::Kind;
use formats::reader::Dump;
use glam::Vec3;
use rayon::prelude::*;

use super::options::{CapsuleChoice, SpaceOptions, VisitChoice};
use super::places::ShownPlaces;
use crate::analysis::GroupWidth;
use crate::analysis::jumps;
use crate::analysis::neighbours::take_means;
use crate::analysis::visits::{EnteredBox, Visits};
use crate::colour_map::ColourMap;
use crate::filter::{Expression, Passing};
use crate::model::background::Background;
use crate::model::colour_by::ColourBy;
use crate::model::derived::{Filtered, Grouped};
use crate::model::numbers::Numbers;
use crate::model::path::PathRay;
use crate::model::selection::Playhead;
use crate::model::{Absent, Context, Order};
use crate::render::cell_box::{cell_box, cells};
use crate::render::detail::Detail;
use crate::render::geometry::{
    CapsuleInstance, Geometry, RayEnd, Shape, Vertex, axes, box_edges, boxes, curve, ends,
    jumps as jump_lines, path, rays,
};
use crate::render::picture::{Layer, Paint, Stage};
use crate::render::range::{ValueRange, Values};
use crate::theme::Theme;

/// Rays of a group that are drawn bold.
const SELECTED_WIDTH: f32 = 3.0;

/// Width of jumps and of the axes of capsules, pixels.
const JUMP_WIDTH: f32 = 2.0;

/// Opacity of axes that surfaces hide.
const HIDDEN_AXES: f32 = 0.5;

/// Opacity of the curve below its jumps.
const BELOW_JUMPS: f32 = 0.25;

/// What is left of the opacity of what is not selected.
const FADED: f32 = 0.1;

/// Length of an arrow's head, and width of a mark, pixels.
const ARROW_WIDTH: f32 = 9.0;
const MARK_WIDTH: f32 = 8.0;

/// More marks than this are drawn half as wide.
const MANY: usize = 20_000;

/// What the vertices of all rays depend on. Of the filter: whether it is known yet which rays pass.
#[derive(Clone, Debug, PartialEq)]
struct Wanted {
    order: Grouped,
    filter: Option<(Arc<Expression>, bool)>,
    places: Range<usize>,
    detail: usize,
    curve: Option<RayEnd>,
    jumps: usize,
    rays: bool,
    ends: bool,
    cells: Option<usize>,
    colour_by: ColourBy,
    near_mean: bool,
    /// The numbers in place of `colour_by`, if there are any, by their own number.
    values: Option<u64>,
    capsules: Option<(CapsuleChoice, usize, Option<usize>)>,
}

/// What the layers of what is selected depend on.
#[derive(Clone, Debug, PartialEq)]
struct WantedSelected {
    order: Grouped,
    rays: Vec<usize>,
    groups: BTreeSet<usize>,
    cell: Option<u32>,
    /// The paths of the ray or its group, if they are shown.
    paths: Option<Arc<[PathRay]>>,
    bounces: ValueRange,
    /// The boxes that are visited, if they are shown, and down to which level.
    visits: Option<(VisitChoice, Arc<Visits>, u32)>,
    theme: Theme,
    map: ColourMap,
}

/// The vertices of all rays that are shown.
struct Made {
    places: ShownPlaces,
    curve: Option<Geometry>,
    /// The longest jumps, and after which places they are.
    jumps: Option<(Geometry, Vec<usize>)>,
    rays: Option<Geometry>,
    ends: Option<Geometry>,
    /// Capsules, their axes, and how many groups there are.
    capsules: Option<([Geometry; 2], usize)>,
    /// Cells, the range of their colours, and how many there are.
    cells: Option<(Geometry, ValueRange, usize)>,
    values: Values,
}

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
    /// The base, where they are logarithms; of ratios to 2.
    pub logarithm: Option<f32>,
}

/// Logarithms of areas that colours of capsules stand for, the same in all orders: a capsule around the
/// whole scene has an area of a few units.
pub(super) const AREAS: ValueRange = ValueRange { low: -3.0, high: 1.0 };

/// The vertices of the last picture.
#[derive(Default)]
pub struct Layers {
    making: Background<Wanted, Arc<Made>, 1>,
    /// What the picture is made of: while other rays are being made, those of before, if of the same
    /// order and in the same colours.
    made: Option<(Wanted, Arc<Made>)>,
    selected: Option<(WantedSelected, Vec<Layer>)>,
    /// Why the last picture lacks something, if it does.
    pub problem: Option<Absent>,
    /// What rays are coloured by in place of what the options say.
    pub ray_values: Option<RayValues>,
    /// Rays that pass the filter; `None` without one.
    pub passing: Option<usize>,
    /// What the ends of the colours stand for.
    pub(super) range: Option<ValueRange>,
    shown: usize,
    all: usize,
}

impl Layers {
    /// Of how many rays one is in the last picture, and how many it is picked from.
    pub(super) fn step(&self) -> (usize, usize) {
        self.made.as_ref().map_or((1, 0), |(_, made)| made.places.step())
    }

    /// What of the rays the curve of the last picture goes through.
    pub(super) fn curve_end(&self) -> Option<RayEnd> {
        self.made.as_ref()?.0.curve
    }

    /// Jumps in the last picture.
    pub(super) fn jump_count(&self) -> Option<usize> {
        Some(self.made.as_ref()?.1.jumps.as_ref()?.1.len())
    }

    /// Rays in the last picture, and all rays of the queue.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.made.as_ref().map(|_| (self.shown, self.all))
    }

    /// Which capsules are in the last picture, how many, and all groups of the order; none if it shows none.
    pub(super) fn capsules_shown(&self) -> Option<(CapsuleChoice, usize, usize)> {
        let (wanted, made) = self.made.as_ref()?;
        let ([capsules, _], all) = made.capsules.as_ref()?;
        Some((wanted.capsules?.0, capsules.shape().len(), *all))
    }

    /// The rays of the paths in the last picture.
    pub(super) fn paths(&self) -> Option<&[PathRay]> {
        self.selected.as_ref()?.0.paths.as_deref()
    }

    /// The bounces of the recording in the last picture, which colours tell apart.
    pub(super) fn bounces(&self) -> Option<ValueRange> {
        Some(self.selected.as_ref()?.0.bounces)
    }

    /// The boxes in the last picture, and the range of what colours them.
    pub(super) fn visits(&self) -> Option<(&Visits, ValueRange)> {
        let (choice, visits, _) = self.selected.as_ref()?.0.visits.as_ref()?;
        Some((visits, visits_range(*choice, visits)))
    }

    /// The range of the numbers that cells are coloured by, how many of them are shown, and of how many; none if none
    /// are.
    pub(super) fn cells(&self) -> Option<(ValueRange, usize, usize)> {
        let (cells, range, all) = self.made.as_ref()?.1.cells.as_ref()?;
        Some((*range, cells.shape().len(), *all))
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
    pub(super) fn shown_places(&self, options: &SpaceOptions, rays: usize) -> impl Iterator<Item = usize> {
        let shown = scrubbed(options, rays);
        self.places().filter(move |place| shown.contains(place))
    }

    /// The layers of a picture.
    pub fn show(&mut self, theme: Theme, options: &SpaceOptions, context: &mut Context) -> Vec<Layer> {
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
        // As camera rays do, where no curve can be seen.
        let is_point = order.queue.starts_in_one_place();
        let curve_end = if is_point { RayEnd::Termination } else { options.curve_end };
        let key = Wanted {
            order: of_order,
            filter: selection.filter.in_force().map(|filter| (filter.clone(), is_known)),
            places: drawn_from(options, order.len()),
            detail: options.detail,
            curve: options.curve.then_some(curve_end),
            // What jumps is the origin of the next ray.
            jumps: if options.curve && curve_end == RayEnd::Origin { options.jumps } else { 0 },
            rays: options.rays,
            ends: options.ends,
            cells: options.cells.then_some(options.cell_count),
            colour_by: options.colour_by,
            near_mean: options.near_mean,
            values: self.ray_values.as_ref().map(|values| values.id),
            capsules: options.capsules.then(|| {
                let choice = options.capsule_choice;
                let group = selection.group.filter(|_| choice == CapsuleChoice::Selected);
                // Nothing would be shown while no group is selected.
                let is_none = choice == CapsuleChoice::Selected && group.is_none();
                (if is_none { CapsuleChoice::Spread } else { choice }, options.capsule_count, group)
            }),
        };
        let Some(numbers) = context.numbers(order.clone()) else { return Vec::new() };
        let missing = options.colour_by.missing(&numbers).filter(|_| self.ray_values.is_none());
        self.problem = missing.map(Absent::from);
        self.make(numbers, key, filtered.passing(), context);
        self.passing = filtered.passing().map(|passing| passing.len());
        // That of the ray in the middle while none is selected.
        let ray = context.selection.ray.unwrap_or(order.len() / 2);
        let paths = paths_of(options, &order, ray, context);
        let visits = self.visits_of(options, &order, ray, context);
        let (cell, mut rays) = (context.selection.cell, context.selection.rays());
        let mut groups = context.selection.groups(&order);
        // Boxes are shown with whose they are.
        if rays.is_empty() && visits.is_some() {
            rays.push(ray);
        }
        if matches!(&visits, Some((VisitChoice::Group, ..))) {
            groups.insert(order.group_of(ray, of_order.1));
        }
        let bounces = context.recording().map_or(1, |open| open.dump.manifest().header.options.bounces);
        let bounces = ValueRange { low: 0.0, high: bounces.saturating_sub(1).max(1) as f32 };
        let (of, map) = (of_order, options.map);
        let key = WantedSelected { order: of, rays, groups, cell, paths, bounces, visits, theme, map };
        if self.selected.as_ref().is_none_or(|(known, _)| *known != key) {
            let selected = selected(&order, &key, context);
            self.selected = Some((key, selected));
        }
        self.layers(options, &order)
    }

    /// The boxes that a ray and its group enter, if they are to be shown.
    fn visits_of(
        &mut self,
        options: &SpaceOptions,
        order: &Arc<Order>,
        ray: usize,
        context: &mut Context,
    ) -> Option<(VisitChoice, Arc<Visits>, u32)> {
        if options.visits == VisitChoice::Hidden || ray >= order.len() {
            return None;
        }
        let visits = context.visits(order, ray).map_err(|absent| self.problem = Some(absent)).ok()?;
        Some((options.visits, visits, options.visit_levels))
    }

    /// Has the vertices of all rays made by another thread.
    fn make(&mut self, numbers: Numbers, key: Wanted, passing: Option<Arc<Passing>>, context: &Context) {
        let Some(recording) = context.recording() else { return };
        if self.made.as_ref().is_some_and(|(known, _)| *known == key) {
            return;
        }
        let (wanted, values, dump) = (key.clone(), self.ray_values.clone(), recording.dump.clone());
        let making = move || Arc::new(Made::of(&numbers, &wanted, (passing, values), &dump));
        match self.making.of(key.clone(), context.waker(), making) {
            Ok(made) => self.made = Some((key, made.clone())),
            Err(absent) => {
                self.problem = Some(absent);
                let shows = |known: &Wanted| (&known.order, known.colour_by) == (&key.order, key.colour_by);
                self.made.take_if(|(known, _)| !shows(known));
            }
        }
    }

    fn layers(&mut self, options: &SpaceOptions, order: &Order) -> Vec<Layer> {
        let (Some((wanted, made)), Some((key, selected))) = (&self.made, &self.selected) else {
            return Vec::new();
        };
        let range = self.range_of(options, made, order, key.bounces);
        self.range = Some(range);
        let places = scrubbed(options, order.len());
        let part = made.places.between(&places);
        (self.shown, self.all) = (part.len(), order.len());
        // What is selected is to be found among the rest.
        let is_selected = !key.rays.is_empty() || !key.groups.is_empty() || key.cell.is_some();
        let rest = if is_selected { FADED } else { 1.0 };
        let lines = |geometry: &Geometry, stage, part: Range<usize>, opacity: f32, width| Layer {
            part: Some(part.start as u32..part.end as u32),
            hidden_opacity: options.hidden_opacity,
            width,
            ..Layer::of(geometry, stage, Paint::Values(options.map, range), rest * opacity)
        };
        // So many that surfaces look painted.
        let mark = if part.len() > MANY { 0.5 * MARK_WIDTH } else { MARK_WIDTH };
        let (thin, arrow) = (options.line_width, ARROW_WIDTH.max(5.0 * options.line_width));
        // A line of the curve goes to the next point, so the last point has none.
        let but_last = part.start..part.end.saturating_sub(1).max(part.start);
        let strength = if made.jumps.is_some() { BELOW_JUMPS } else { 0.9 };
        let curve =
            made.curve.iter().map(|curve| lines(curve, Stage::Lines, but_last.clone(), strength, thin));
        let jumps = made.jumps.iter().map(|(jumps, after)| {
            let [start, end] = [places.start, places.end].map(|end| after.partition_point(|&at| at < end));
            // In front of surfaces, too, or they would look like many short ones.
            let jumps = lines(jumps, Stage::Lines, start..end, 1.0, JUMP_WIDTH.max(thin));
            Layer { hidden_opacity: 1.0, ..jumps }
        });
        let rays = made.rays.iter().map(|rays| lines(rays, Stage::Lines, part.clone(), 0.7, thin));
        let heads = made.rays.iter().filter(|_| options.arrows);
        let heads = heads.map(|rays| lines(rays, Stage::Arrows, part.clone(), 1.0, arrow));
        let ends = made.ends.iter().map(|ends| lines(ends, Stage::Marks, part.clone(), 1.0, mark));
        let translucent = |geometry, stage, range, rest| {
            Layer::of(geometry, stage, Paint::Values(options.map, range), rest * options.capsule_opacity)
        };
        let cells = made.cells.iter().map(|(cells, range, _)| translucent(cells, Stage::Boxes, *range, rest));
        let of_selected = wanted.capsules.is_some_and(|(choice, ..)| choice == CapsuleChoice::Selected);
        let of_rest = if of_selected { 1.0 } else { rest };
        let capsules = made.capsules.iter().flat_map(|([capsules, axes], _)| {
            let axes = translucent(axes, Stage::Lines, AREAS, 1.0);
            let axes = Layer { width: JUMP_WIDTH, opacity: of_rest, hidden_opacity: HIDDEN_AXES, ..axes };
            [translucent(capsules, Stage::Capsules, AREAS, of_rest), axes]
        });
        let lines = curve.chain(jumps).chain(rays).chain(heads).chain(ends);
        lines.chain(cells).chain(capsules).chain(selected.iter().cloned()).collect()
    }

    /// What the ends of the colours of rays stand for.
    fn range_of(
        &self,
        options: &SpaceOptions,
        made: &Made,
        order: &Order,
        bounces: ValueRange,
    ) -> ValueRange {
        match (options.range, &self.ray_values, options.colour_by) {
            (None, Some(RayValues { range: Some(range), .. }), _) => *range,
            (_, None, ColourBy::Quantity(Quantity::Bounce)) => bounces,
            (_, None, ColourBy::Quantity(Quantity::Place)) => {
                ValueRange { low: 0.0, high: order.len().saturating_sub(1).max(1) as f32 }
            }
            (Some((low, high)), ..) => ValueRange { low, high },
            _ => made.values.percentiles(options.percentiles.0, options.percentiles.1),
        }
    }
}

/// The places that the scrub slider leaves.
fn scrubbed(options: &SpaceOptions, rays: usize) -> Range<usize> {
    Playhead { until: options.until, window: options.window }.places(rays)
}

/// The places that detail is spread over: all of them while the slider leaves everything before it, so
/// that nothing is made anew while it moves; else those that it leaves, which then show more detail.
fn drawn_from(options: &SpaceOptions, rays: usize) -> Range<usize> {
    if options.window >= 1.0 { 0..rays } else { scrubbed(options, rays) }
}

impl Made {
    /// Of the rays that pass the filter, all if it is `None`, with their colours.
    fn of(
        numbers: &Numbers,
        key: &Wanted,
        (passing, values): (Option<Arc<Passing>>, Option<RayValues>),
        dump: &Dump,
    ) -> Self {
        let (order, width) = (&*numbers.order, key.order.1);
        let jumps = match key.jumps {
            0 => None,
            wanted => Some(jumps::longest(&numbers.rays(), &key.places, passing.as_deref(), wanted)),
        };
        let shown = ShownPlaces::of(&key.places, key.detail, passing);
        let of = |places: &mut dyn Iterator<Item = usize>| -> Vec<f32> {
            let Some(values) = &values else { return key.colour_by.values(numbers, places) };
            let value = |place| values.of_ray.get(order.places.ray(place)).copied().unwrap_or(f32::NAN);
            places.map(value).collect()
        };
        let mut all = of(&mut shown.places());
        if key.near_mean {
            let ends = shown.places().map(|place| order.queue.segment(order.places.ray(place)).end);
            take_means(ends, &mut all);
        }
        let places = || shown.places().zip(all.iter().copied());
        let is_of_jumps = key.colour_by == ColourBy::Quantity(Quantity::Jump) && values.is_none();
        let jumps = jumps.map(|after| {
            let values = of(&mut after.iter().copied());
            (jump_lines(order, after.iter().copied().zip(values)).into(), after)
        });
        let strip = |end| match curve(order, places(), end) {
            // A line between rays that are not neighbours is another one than the first one's jump.
            Shape::Strip(points) if is_of_jumps => Shape::Strip(by_length(points, &numbers.rays())),
            strip => strip,
        };
        Self {
            curve: key.curve.map(|end| strip(end).into()),
            jumps,
            rays: key.rays.then(|| rays(order, places()).into()),
            ends: key.ends.then(|| ends(order, places()).into()),
            capsules: key.capsules.map(|(choice, most, group)| capsules(order, width, choice, most, group)),
            cells: key.cells.map(|most| cells(&dump.manifest().header.options, &order.queue, most)),
            values: Values::of(all.into_par_iter()),
            places: shown,
        }
    }
}

/// The points of a strip, each with the length of the line that starts there.
fn by_length(mut points: Vec<Vertex>, rays: &OrderedRays<'_>) -> Vec<Vertex> {
    for at in 0..points.len().saturating_sub(1) {
        let [here, next] = [at, at + 1].map(|at| Vec3::from(points[at].position));
        points[at].value = Quantity::Jump.coloured(f64::from(here.distance(next)), rays);
    }
    points
}

/// Capsules as the analysis computes them, coloured by the logarithm of their area over all groups; and how many
/// groups there are.
fn capsules(
    order: &Order,
    width: GroupWidth,
    choice: CapsuleChoice,
    most: usize,
    group: Option<usize>,
) -> ([Geometry; 2], usize) {
    let groups = order.groups(width);
    let chosen: Vec<usize> = match choice {
        CapsuleChoice::Selected => group.into_iter().collect(),
        CapsuleChoice::Worst => groups.worst(most),
        CapsuleChoice::Spread => Detail::of(&(0..groups.groups.len()), most).places().collect(),
    };
    let found = chosen.into_iter().filter_map(|at| groups.groups.get(at));
    let value = |area: f64| area.max(1e-12).log10() as f32;
    let capsule = |group: &Group| CapsuleInstance::of(&group.capsule, value(group.area));
    let capsules: Vec<CapsuleInstance> = found.map(capsule).collect();
    let axes = axes(&capsules).into();
    ([Shape::Capsules(capsules).into(), axes], groups.groups.len())
}

/// The layers of what is selected: the capsules of groups, the box of a cell, the rays of the groups, bold lines
/// around the cell and along the rays, and their paths.
fn selected(order: &Order, wanted: &WantedSelected, context: &Context) -> Vec<Layer> {
    let &WantedSelected { order: (_, width), ref groups, cell, theme, map, .. } = wanted;
    let places = wanted.rays.iter().filter_map(|&ray| order.place_of_ray().get(ray));
    let Shape::Segments(mut lines) = rays(order, places.map(|&place| (place as usize, 0.0))) else {
        return Vec::new();
    };
    let options = context.recording().map(|recording| &recording.dump.manifest().header.options);
    let corners = cell.zip(options).and_then(|(cell, options)| cell_box(options, cell));
    lines.extend(corners.into_iter().flat_map(|corners| box_edges(corners, 0.0)));
    let places = groups.iter().flat_map(|&group| order.places_of_group(group, width));
    let found = groups.iter().filter_map(|&group| order.group(group, width));
    let capsules = found.map(|group| CapsuleInstance::of(&group.capsule, 0.0)).collect();
    let layer = |shape: Shape, stage, opacity, width| {
        let plain = Paint::Plain(theme.selected());
        Layer { width, ..Layer::of(&shape.into(), stage, plain, opacity) }
    };
    let mut layers = vec![
        layer(Shape::Capsules(capsules), Stage::Capsules, 0.16, 0.0),
        layer(boxes(corners.into_iter().map(|corners| (corners, 0.0))), Stage::Boxes, 0.16, 0.0),
        layer(rays(order, places.map(|place| (place, 0.0))), Stage::OnTop, 0.5, 1.0),
        layer(Shape::Segments(lines), Stage::OnTop, 1.0, SELECTED_WIDTH),
    ];
    if let Some((choice, visits, levels)) = &wanted.visits {
        let paint = Paint::Values(map, visits_range(*choice, visits));
        let edges = visited_edges(*choice, visits, *levels);
        let lines = Layer::of(&edges.into(), Stage::Lines, paint, 1.0);
        layers.push(Layer { width: JUMP_WIDTH, hidden_opacity: HIDDEN_AXES, ..lines });
    }
    let Some(rays) = &wanted.paths else { return layers };
    let is_one = rays.iter().all(|ray| ray.path == rays[0].path);
    let (width, mark) = if is_one { (SELECTED_WIDTH, MARK_WIDTH) } else { (JUMP_WIDTH, 0.5 * MARK_WIDTH) };
    for (kind, line_width) in [(Kind::Closest, width), (Kind::Shadow, 1.0)] {
        let [lines, ends] = path(rays, kind);
        let paint = Paint::Values(map, wanted.bounces);
        layers.push(Layer { width: line_width, ..Layer::of(&lines.into(), Stage::OnTop, paint, 1.0) });
        let marks = Layer::of(&ends.into(), Stage::Marks, paint, 1.0);
        layers.push(Layer { width: mark, hidden_opacity: 1.0, ..marks });
    }
    layers
}

/// The paths of a ray or its group, if they are to be shown.
fn paths_of(
    options: &SpaceOptions,
    order: &Order,
    ray: usize,
    context: &mut Context,
) -> Option<Arc<[PathRay]>> {
    let &pixel = order.queue.path_ids.get(ray).filter(|_| options.path)?;
    if !options.path_group {
        return context.paths(vec![pixel]);
    }
    let width = context.selection.group_width;
    let places = order.places_of_group(order.group_of(ray, width), width);
    context.paths(places.map(|place| order.queue.path_ids[order.places.ray(place)]).collect())
}

/// The edges of the boxes that are visited: a ray's by level, a group's by how many of its rays enter each.
fn visited_edges(choice: VisitChoice, visits: &Visits, levels: u32) -> Shape {
    let of_ray = choice == VisitChoice::Ray;
    let shown = visits.boxes.iter().filter(|entered| entered.level <= levels);
    let edges = shown.filter(|entered| entered.is_of_ray || !of_ray).flat_map(|entered| {
        box_edges(entered.corners, if of_ray { entered.level } else { entered.rays } as f32)
    });
    Shape::Segments(edges.collect())
}

/// What the ends of the colours of boxes stand for.
fn visits_range(choice: VisitChoice, visits: &Visits) -> ValueRange {
    let most = |of: fn(&EnteredBox) -> u32| visits.boxes.iter().map(of).max().unwrap_or(0).max(1) as f32;
    match choice {
        VisitChoice::Group => ValueRange { low: 0.0, high: most(|entered| entered.rays) },
        VisitChoice::Hidden | VisitChoice::Ray => {
            ValueRange { low: 0.0, high: most(|entered| entered.level) }
        }
    }
}
