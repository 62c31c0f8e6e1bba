//! The numbers that a ray has: what filters name, and what columns show and sort by.

use std::sync::Arc;

use formats::key::Encoder;
use formats::manifest::Header;
use formats::metrics::lanes::work_of;
use formats::traced::Results;
use serde::{Deserialize, Serialize};

use super::order::Order;
use crate::analysis::GroupWidth;

macro_rules! quantities {
    ($($variant:ident = $name:literal $(| $alias:literal)?, $about:literal;)*) => {
        /// A number that a ray has.
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
        }
    };
}

quantities! {
    Place = "place", "Place in the order, from 0";
    Ray = "ray", "Canonical index: the place in pixel order";
    Pixel = "pixel", "Index of the pixel, row by row";
    Column = "x", "Column of the pixel in the image";
    Row = "y", "Row of the pixel in the image";
    Pass = "pass", "Pass of the queue: one sample of each pixel";
    Bounce = "bounce", "Surfaces between the camera and the ray's origin";
    HitDistance = "t", "Distance to what was hit, world units; infinite for nothing";
    Length = "length", "Traced length, unit lengths: the scene's largest side is 1";
    OriginX = "origin.x", "Origin, world units";
    OriginY = "origin.y", "Origin, world units";
    OriginZ = "origin.z", "Origin, world units";
    DirectionX = "direction.x" | "dir.x", "Direction, a unit vector";
    DirectionY = "direction.y" | "dir.y", "Direction, a unit vector";
    DirectionZ = "direction.z" | "dir.z", "Direction, a unit vector";
    Key = "key", "What the rays are sorted by; filters round what is longer than 53 bits";
    Displacement = "displacement", "How far sorting moved the ray from its place in pixel order";
    Group = "group", "Number of the ray's group in the order, from 0";
    Area = "area", "Area of the capsule around the ray's group, unit space";
    Spread = "spread", "Direction spread of the ray's group: 0 if all its rays are parallel";
    Lanes = "lanes", "Lane utilisation of the ray's group, a model of divergence: 1 if no lane waits";
    Nodes = "nodes", "Nodes of the BVH that the ray visited";
    Triangles = "triangles", "Triangles that the ray was tested against";
    Work = "work", "Nodes visited and triangles tested";
    Cell = "cell", "Address of the ray's cell in the length table";
    Estimate = "estimate", "Mean length of the ray's table cell, unit lengths: what two-point-adaptive assumes";
    Ratio = "ratio", "Estimated over traced length: 1 if the table is right";
    Triangle = "triangle", "Index of the triangle that was hit";
    Light = "light", "Index of the light that a shadow ray goes to";
}

/// All that numbers of an order's rays are read from.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// The order.
    pub order: Arc<Order>,
    /// Rays of a group.
    pub width: GroupWidth,
    image_width: u32,
    cells: Option<Encoder>,
}

impl Numbers {
    /// Of an order of a recording.
    pub fn of(order: Arc<Order>, header: &Header, width: GroupWidth) -> Self {
        Self { order, width, image_width: header.options.width.max(1), cells: header.cell_encoder() }
    }

    /// Why a quantity is not known of these rays, if so.
    pub fn missing(&self, quantity: Quantity) -> Option<String> {
        let queue = &self.order.queue;
        let is_closest = matches!(queue.traced.results(), Results::Hits(_));
        match quantity {
            Quantity::Key => self.order.keys.as_ref().err().cloned(),
            Quantity::Nodes | Quantity::Triangles | Quantity::Work | Quantity::Lanes => {
                queue.work.as_ref().err().cloned()
            }
            Quantity::Estimate | Quantity::Ratio => queue.table.as_ref().err().cloned(),
            Quantity::Cell if self.cells.is_none() => {
                Some("the recording does not say how cells are addressed".to_owned())
            }
            Quantity::Triangle if !is_closest => Some("shadow rays have no triangle".to_owned()),
            Quantity::Light if is_closest => Some("only shadow rays have a light".to_owned()),
            _ => None,
        }
    }

    /// The number of the ray at a place; NaN where there is none.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn value(&self, quantity: Quantity, place: usize) -> f64 {
        let (order, queue) = (&self.order, &self.order.queue);
        let index = order.places.ray(place);
        let ray = || &queue.traced.rays()[index];
        let pixel = || queue.path_ids[index];
        match quantity {
            Quantity::Place => place as f64,
            Quantity::Ray => index as f64,
            Quantity::Pixel => f64::from(pixel()),
            Quantity::Column => f64::from(pixel() % self.image_width),
            Quantity::Row => f64::from(pixel() / self.image_width),
            Quantity::Pass => f64::from(queue.id.pass),
            Quantity::Bounce => f64::from(queue.id.bounce),
            Quantity::HitDistance => match queue.traced.results() {
                Results::Hits(hits) => f64::from(hits[index].t),
                Results::Distances(distances) => f64::from(distances[index]),
            },
            Quantity::Length => f64::from(queue.lengths[index]),
            Quantity::OriginX => f64::from(ray().origin[0]),
            Quantity::OriginY => f64::from(ray().origin[1]),
            Quantity::OriginZ => f64::from(ray().origin[2]),
            Quantity::DirectionX => f64::from(ray().direction[0]),
            Quantity::DirectionY => f64::from(ray().direction[1]),
            Quantity::DirectionZ => f64::from(ray().direction[2]),
            Quantity::Key => order.keys.as_ref().map_or(f64::NAN, |(keys, _)| keys.at(index) as f64),
            Quantity::Displacement => (place as f64 - index as f64).abs(),
            Quantity::Group => (place / self.width.rays()) as f64,
            Quantity::Area | Quantity::Spread | Quantity::Lanes => self.of_group(quantity, place),
            Quantity::Nodes => self.of_work(index, |work| u64::from(work.nodes)),
            Quantity::Triangles => self.of_work(index, |work| u64::from(work.triangles)),
            Quantity::Work => self.of_work(index, work_of),
            Quantity::Cell => {
                self.cells.as_ref().map_or(f64::NAN, |cells| cells.encode(ray(), 0.0, 0) as f64)
            }
            Quantity::Estimate => self.estimate(index),
            Quantity::Ratio => self.estimate(index) / f64::from(queue.lengths[index]),
            Quantity::Triangle => match queue.traced.results() {
                Results::Hits(hits) if hits[index].is_hit() => f64::from(hits[index].triangle),
                _ => f64::NAN,
            },
            Quantity::Light => queue.lights.as_ref().map_or(f64::NAN, |lights| f64::from(lights[index])),
        }
    }

    fn estimate(&self, index: usize) -> f64 {
        let queue = &self.order.queue;
        queue.table.as_ref().map_or(f64::NAN, |table| f64::from(table.mean(&queue.traced.rays()[index])))
    }

    fn of_work(&self, index: usize, of: impl Fn(&formats::ray::Work) -> u64) -> f64 {
        self.order.queue.work.as_ref().map_or(f64::NAN, |work| of(&work[index]) as f64)
    }

    /// Finds what is found once for all rays, on this thread: to be called before many threads ask for the
    /// values of a quantity at once.
    pub fn prepare(&self, quantity: Quantity) {
        if quantity.is_of_group() {
            self.order.groups(self.width);
        }
    }

    fn of_group(&self, quantity: Quantity, place: usize) -> f64 {
        let groups = self.order.groups(self.width);
        let Some(group) = groups.groups.get(groups.of_place(place)) else { return f64::NAN };
        match quantity {
            Quantity::Area => group.area,
            Quantity::Spread => group.spread,
            _ => group.lanes.unwrap_or(f64::NAN),
        }
    }

    /// The key of the ray at a place, all of its bits; `None` if it has none.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn key(&self, place: usize) -> Option<u64> {
        let (keys, _) = self.order.keys.as_ref().ok()?;
        Some(keys.at(self.order.places.ray(place)))
    }

    /// The number as a table shows it.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn text(&self, quantity: Quantity, place: usize) -> String {
        let value = self.value(quantity, place);
        match quantity {
            Quantity::Key => match &self.order.keys {
                Ok((keys, layout)) => {
                    let digits = layout.key_bits.div_ceil(4) as usize;
                    format!("{:0digits$x}", keys.at(self.order.places.ray(place)))
                }
                Err(_) => "-".to_owned(),
            },
            Quantity::Pixel => {
                format!("{},{}", self.value(Quantity::Column, place), self.value(Quantity::Row, place))
            }
            Quantity::Triangle if value.is_nan() && self.missing(quantity).is_none() => "none".to_owned(),
            _ if value.is_nan() => "-".to_owned(),
            Quantity::Cell => format!("{:05x}", value as u64),
            _ if quantity.is_whole() => value.to_string(),
            _ => format!("{value:.4}"),
        }
    }
}

impl Quantity {
    /// Whether it takes the groups of the order to know it.
    pub fn is_of_group(self) -> bool {
        matches!(self, Self::Area | Self::Spread | Self::Lanes)
    }

    /// Whether all of its values are whole numbers.
    pub fn is_whole(self) -> bool {
        use Quantity as Q;
        matches!(
            self,
            Q::Place
                | Q::Ray
                | Q::Pixel
                | Q::Column
                | Q::Row
                | Q::Pass
                | Q::Bounce
                | Q::Key
                | Q::Displacement
                | Q::Group
                | Q::Nodes
                | Q::Triangles
                | Q::Work
                | Q::Cell
                | Q::Triangle
                | Q::Light
        )
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
}
