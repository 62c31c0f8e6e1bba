//! The numbers that a ray or its group has: each is one entry of the list below, with its name, its unit and
//! how it is found. Filters name them, tables show and sort by them, colours stand for them.

use serde::{Deserialize, Serialize};

use crate::key::{Encoder, Facts};
use crate::manifest::QueueId;
use crate::metrics::capsule::Segment;
use crate::metrics::group::Group;
use crate::metrics::lanes::work_of;
use crate::metrics::order::{Keys, Places};
use crate::ray::{Ray, Work};
use crate::stored_table::StoredTable;
use crate::traced::{Results, Traced};

/// All that the numbers of a queue's rays in one order are read from; arrays are in canonical order.
#[derive(Clone, Copy)]
pub struct OrderedRays<'a> {
    /// The queue.
    pub id: QueueId,
    /// Columns of the image.
    pub image_width: u32,
    /// The rays and what came of them.
    pub traced: &'a Traced,
    /// Traced lengths, unit lengths.
    pub lengths: &'a [f32],
    /// Pixels, ascending.
    pub path_ids: &'a [u32],
    /// Lights of shadow rays.
    pub lights: Option<&'a [u32]>,
    /// The material of each triangle of the scene, or why it is not known.
    pub materials: Result<&'a [u32], &'a str>,
    /// Work of each ray, or why it is not known.
    pub work: Result<&'a [Work], &'a str>,
    /// The length table that the methods read, or why it is not known.
    pub table: Result<&'a StoredTable, &'a str>,
    /// How cells of that table are addressed; `None` if the recording does not say.
    pub cells: Option<&'a Encoder>,
    /// The ray at each place.
    pub places: &'a Places,
    /// Keys and their bits, or why there are none.
    pub keys: Result<(&'a Keys, u32), &'a str>,
    /// Rays of a group.
    pub group_width: usize,
    /// The groups of the order; none until they are found.
    pub groups: &'a [Group],
}

/// A ray at a place of an order.
#[derive(Clone, Copy)]
pub struct RayAt<'a> {
    of: &'a OrderedRays<'a>,
    place: usize,
    index: usize,
}

/// How a number looks in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Real,
    Whole,
}

/// From a number to what colours stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Linear,
    /// Logarithm to the base 10, of no less than this.
    Log10(f64),
    Log2,
    /// Neighbours differ, and colours repeat after so many.
    Repeats(u32),
    /// Part of the largest key.
    OfLargestKey,
}

/// What must be known to know a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needs {
    Nothing,
    Keys,
    Work,
    Table,
    Cells,
    Groups,
    GroupsAndWork,
    Triangles,
    Materials,
    Lights,
}

/// One quantity of the list.
#[derive(Clone, Copy)]
struct Definition {
    label: &'static str,
    unit: &'static str,
    form: Form,
    scale: Scale,
    needs: Needs,
    value: fn(RayAt<'_>) -> f64,
}

const fn real(label: &'static str, unit: &'static str, value: fn(RayAt<'_>) -> f64) -> Definition {
    Definition { label, unit, form: Form::Real, scale: Scale::Linear, needs: Needs::Nothing, value }
}

const fn whole(label: &'static str, value: fn(RayAt<'_>) -> f64) -> Definition {
    Definition { form: Form::Whole, ..real(label, "", value) }
}

impl Definition {
    const fn needs(self, needs: Needs) -> Self {
        Self { needs, ..self }
    }

    const fn scale(self, scale: Scale) -> Self {
        Self { scale, ..self }
    }
}

macro_rules! quantities {
    ($($variant:ident = $name:literal $(| $alias:literal)?, $about:literal: $definition:expr;)*) => {
        /// A number that a ray or its group has.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum Quantity { $(#[doc = $about] #[serde(rename = $name)] $variant,)* }

        impl Quantity {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The word for it.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What it is, in a sentence without its full stop.
            pub fn about(self) -> &'static str {
                match self { $(Self::$variant => $about,)* }
            }

            /// The quantity of a name.
            pub fn of_name(name: &str) -> Option<Self> {
                match name { $($name $(| $alias)? => Some(Self::$variant),)* _ => None }
            }

            fn definition(self) -> &'static Definition {
                static DEFINITIONS: &[Definition] = &[$($definition,)*];
                &DEFINITIONS[self as usize]
            }
        }
    };
}

quantities! {
    Place = "place", "Place in the order, from 0":
        whole("place in the order", |at| at.place as f64);
    Ray = "ray", "Canonical index: the place in pixel order":
        whole("canonical index", |at| at.index as f64);
    Pixel = "pixel", "Index of the pixel, row by row":
        whole("pixel, row by row", |at| f64::from(at.pixel()));
    Column = "x", "Column of the pixel in the image":
        whole("column of the pixel", |at| f64::from(at.pixel() % at.of.image_width));
    Row = "y", "Row of the pixel in the image":
        whole("row of the pixel", |at| f64::from(at.pixel() / at.of.image_width));
    Pass = "pass", "Pass of the queue: one sample of each pixel":
        whole("pass", |at| f64::from(at.of.id.pass));
    Bounce = "bounce", "Surfaces between the camera and the ray's origin":
        whole("bounce; 0 is the camera rays", |at| f64::from(at.of.id.bounce));
    HitDistance = "t", "Distance to what was hit, world units; infinite for nothing":
        real("distance to what was hit", "world units", |at| at.hit_distance());
    Length = "length", "Traced length, unit lengths: the scene's largest side is 1":
        real("traced length", "unit lengths", |at| at.length());
    Jump = "jump", "Distance to the origin of the next ray of the order: where the curve jumps":
        real("distance to the next ray's origin", "unit lengths", |at| at.jump()).scale(Scale::Log10(1e-6));
    OriginX = "origin.x", "Origin, world units": real("origin x", "world units", |at| at.origin(0));
    OriginY = "origin.y", "Origin, world units": real("origin y", "world units", |at| at.origin(1));
    OriginZ = "origin.z", "Origin, world units": real("origin z", "world units", |at| at.origin(2));
    DirectionX = "direction.x" | "dir.x", "Direction, a unit vector":
        real("direction x", "", |at| at.direction(0));
    DirectionY = "direction.y" | "dir.y", "Direction, a unit vector":
        real("direction y", "", |at| at.direction(1));
    DirectionZ = "direction.z" | "dir.z", "Direction, a unit vector":
        real("direction z", "", |at| at.direction(2));
    Key = "key", "What the rays are sorted by; filters round what is longer than 53 bits":
        whole("key", |at| at.key().map_or(f64::NAN, |key| key as f64))
            .scale(Scale::OfLargestKey)
            .needs(Needs::Keys);
    Displacement = "displacement", "How far sorting moved the ray from its place in pixel order":
        whole("places from pixel order", |at| (at.place as f64 - at.index as f64).abs());
    Group = "group", "Number of the ray's group in the order, from 0":
        whole("group", |at| (at.place / at.of.group_width) as f64).scale(Scale::Repeats(7));
    Area = "area", "Area of the capsule around the ray's group, unit space":
        real("capsule area of the group", "", |at| at.group().map_or(f64::NAN, |group| group.area))
            .scale(Scale::Log10(1e-12))
            .needs(Needs::Groups);
    Spread = "spread", "Direction spread of the ray's group: 0 if all its rays are parallel":
        real("direction spread of the group", "", |at| at.group().map_or(f64::NAN, |group| group.spread))
            .needs(Needs::Groups);
    Lanes = "lanes", "Lane utilisation of the ray's group, a model of divergence: 1 if no lane waits":
        real("lane utilisation of the group (model)", "", |at| at.lanes()).needs(Needs::GroupsAndWork);
    Nodes = "nodes", "Nodes of the BVH that the ray visited":
        whole("nodes visited", |at| at.work(|work| u64::from(work.nodes))).needs(Needs::Work);
    Triangles = "triangles", "Triangles that the ray was tested against":
        whole("triangles tested", |at| at.work(|work| u64::from(work.triangles))).needs(Needs::Work);
    Work = "work", "Nodes visited and triangles tested":
        whole("nodes visited + triangles tested", |at| at.work(work_of)).needs(Needs::Work);
    Cell = "cell", "Address of the ray's cell in the length table":
        whole("cell of the length table", |at| at.cell()).needs(Needs::Cells);
    Estimate = "estimate", "What two-point-adaptive assumes, unit lengths: the mean of the ray's table cell, cut by its end and the scene's box":
        real("estimated length", "unit lengths", |at| at.estimate()).needs(Needs::Table);
    Ratio = "ratio", "Estimated over traced length: 1 if the table is right":
        real("estimated over actual length", "", |at| at.estimate() / at.length())
            .scale(Scale::Log2)
            .needs(Needs::Table);
    Triangle = "triangle", "Index of the triangle that was hit":
        whole("triangle that was hit", |at| at.triangle()).needs(Needs::Triangles);
    Material = "material", "Index of the material that was hit: what sorting hits before shading brings together":
        whole("material that was hit", |at| at.material()).scale(Scale::Repeats(7)).needs(Needs::Materials);
    Light = "light", "Index of the light that a shadow ray goes to":
        whole("light", |at| at.of.lights.map_or(f64::NAN, |lights| f64::from(lights[at.index])))
            .needs(Needs::Lights);
    Occlusion = "occlusion", "1 where a surface was hit, 0 where nothing was":
        whole("0 nothing hit, 1 a surface hit", |at| f64::from(u8::from(at.of.traced.is_at_surface(at.index))));
}

impl<'a> OrderedRays<'a> {
    /// The ray at a place.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn at(&'a self, place: usize) -> RayAt<'a> {
        RayAt { of: self, place, index: self.places.ray(place) }
    }
}

impl RayAt<'_> {
    fn ray(&self) -> &Ray {
        &self.of.traced.rays()[self.index]
    }

    fn pixel(&self) -> u32 {
        self.of.path_ids[self.index]
    }

    fn origin(&self, axis: usize) -> f64 {
        f64::from(self.ray().origin[axis])
    }

    fn direction(&self, axis: usize) -> f64 {
        f64::from(self.ray().direction[axis])
    }

    fn length(self) -> f64 {
        f64::from(self.of.lengths[self.index])
    }

    fn hit_distance(self) -> f64 {
        f64::from(match self.of.traced.results() {
            Results::Hits(hits) => hits[self.index].t,
            Results::Distances(distances) => distances[self.index],
        })
    }

    fn triangle(self) -> f64 {
        match self.of.traced.results() {
            Results::Hits(hits) if hits[self.index].is_hit() => f64::from(hits[self.index].triangle),
            _ => f64::NAN,
        }
    }

    fn material(self) -> f64 {
        let material = |triangle: f64| self.of.materials.ok()?.get(triangle as usize).copied();
        let triangle = Some(self.triangle()).filter(|triangle| triangle.is_finite());
        triangle.and_then(material).map_or(f64::NAN, f64::from)
    }

    /// To the origin of the ray at the next place; NaN for the last one.
    fn jump(self) -> f64 {
        if self.place + 1 >= self.of.places.len() {
            return f64::NAN;
        }
        let [here, next] = [self, self.of.at(self.place + 1)]
            .map(|at| Segment::of(at.of.traced.unit(), at.ray(), at.of.lengths[at.index]).origin);
        [0, 1, 2].map(|axis| (next[axis] - here[axis]).powi(2)).iter().sum::<f64>().sqrt()
    }

    /// The key, all of its bits; `None` if it has none.
    pub fn key(self) -> Option<u64> {
        let (keys, _) = self.of.keys.ok()?;
        Some(keys.at(self.index))
    }

    fn work(&self, of: impl Fn(&Work) -> u64) -> f64 {
        self.of.work.map_or(f64::NAN, |work| of(&work[self.index]) as f64)
    }

    fn group(&self) -> Option<&Group> {
        self.of.groups.get(self.place / self.of.group_width)
    }

    fn lanes(self) -> f64 {
        self.group().and_then(|group| group.lanes).unwrap_or(f64::NAN)
    }

    fn cell(self) -> f64 {
        self.of.cells.map_or(f64::NAN, |cells| cells.encode(self.ray(), Facts::default()) as f64)
    }

    fn estimate(self) -> f64 {
        self.of.table.map_or(f64::NAN, |table| f64::from(table.estimate(self.of.traced.unit(), self.ray())))
    }
}

impl Quantity {
    /// Of a ray; NaN where it does not have it. To be asked for once for many rays.
    pub fn value(self) -> fn(RayAt<'_>) -> f64 {
        self.definition().value
    }

    /// Whether it takes the groups of the order to know it.
    pub fn is_of_group(self) -> bool {
        matches!(self.definition().needs, Needs::Groups | Needs::GroupsAndWork)
    }

    /// Why it is not known of these rays, if so.
    pub fn missing<'a>(self, rays: &OrderedRays<'a>) -> Option<&'a str> {
        let is_closest = matches!(rays.traced.results(), Results::Hits(_));
        match self.definition().needs {
            Needs::Nothing | Needs::Groups => None,
            Needs::Keys => rays.keys.err(),
            Needs::Work | Needs::GroupsAndWork => rays.work.err(),
            Needs::Table => rays.table.err(),
            Needs::Cells => {
                rays.cells.is_none().then_some("the recording does not say how cells are addressed")
            }
            Needs::Triangles => (!is_closest).then_some("shadow rays have no triangle"),
            Needs::Materials if !is_closest => Some("shadow rays have no material"),
            Needs::Materials => rays.materials.err(),
            Needs::Lights => is_closest.then_some("only shadow rays have a light"),
        }
    }

    /// What colours stand for, with its unit.
    pub fn title(self) -> String {
        let Definition { label, unit, scale, .. } = self.definition();
        match scale {
            Scale::Linear | Scale::Log10(_) | Scale::Log2 if unit.is_empty() => (*label).to_owned(),
            Scale::Linear | Scale::Log10(_) | Scale::Log2 => format!("{label}, {unit}"),
            Scale::Repeats(_) => format!("{label} (colours repeat)"),
            Scale::OfLargestKey => format!("{label}, part of the largest"),
        }
    }

    /// The base of the logarithm that colours stand for, if they stand for one.
    pub fn logarithm(self) -> Option<f32> {
        match self.definition().scale {
            Scale::Log10(_) => Some(10.0),
            Scale::Log2 => Some(2.0),
            Scale::Linear | Scale::Repeats(_) | Scale::OfLargestKey => None,
        }
    }

    /// What colours stand for, of its value; not finite where it is not known.
    pub fn coloured(self, value: f64, rays: &OrderedRays<'_>) -> f32 {
        let scaled = match self.definition().scale {
            Scale::Linear => value,
            // `max` would take the least for it.
            _ if value.is_nan() => value,
            Scale::Log10(least) => value.max(least).log10(),
            Scale::Log2 => value.log2(),
            Scale::Repeats(after) => value % f64::from(after),
            Scale::OfLargestKey => rays.keys.map_or(f64::NAN, |(_, bits)| value / 2f64.powi(bits as i32)),
        };
        scaled as f32
    }

    /// The number of a ray as a table shows it.
    pub fn text(self, at: RayAt<'_>) -> String {
        let value = (self.value())(at);
        match (self, at.of.keys) {
            (Self::Key, Ok((keys, bits))) => {
                format!("{:0digits$x}", keys.at(at.index), digits = bits.div_ceil(4) as usize)
            }
            (Self::Pixel, _) => {
                let [column, row] = [Self::Column, Self::Row].map(|along| (along.value())(at));
                format!("{column},{row}")
            }
            (Self::Triangle | Self::Material, _) if value.is_nan() && self.missing(at.of).is_none() => {
                "none".to_owned()
            }
            _ if value.is_nan() => "-".to_owned(),
            (Self::Cell, _) => format!("{:05x}", value as u64),
            _ if self.definition().form == Form::Whole => value.to_string(),
            _ => format!("{value:.4}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_found_and_differ() {
        let names: BTreeSet<&str> = Quantity::ALL.iter().map(|quantity| quantity.name()).collect();
        assert_eq!(names.len(), Quantity::ALL.len());
        for &quantity in Quantity::ALL {
            assert_eq!(Quantity::of_name(quantity.name()), Some(quantity));
        }
        assert_eq!(Quantity::of_name("dir.y"), Some(Quantity::DirectionY));
        assert_eq!(Quantity::of_name("nope"), None);
    }

    #[test]
    fn titles_say_label_scale_and_unit() {
        for (quantity, title) in [
            (Quantity::Place, "place in the order"),
            (Quantity::Length, "traced length, unit lengths"),
            (Quantity::Jump, "distance to the next ray's origin, unit lengths"),
            (Quantity::Area, "capsule area of the group"),
            (Quantity::Ratio, "estimated over actual length"),
            (Quantity::Group, "group (colours repeat)"),
            (Quantity::Key, "key, part of the largest"),
        ] {
            assert_eq!(quantity.title(), title);
        }
        let bases = [Quantity::Length, Quantity::Area, Quantity::Ratio].map(Quantity::logarithm);
        assert_eq!(bases, [None, Some(10.0), Some(2.0)]);
    }
}
