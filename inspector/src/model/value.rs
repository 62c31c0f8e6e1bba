//! The numbers that colours stand for.

use std::borrow::Cow;

use formats::key::Coordinate;
use formats::metrics::lanes::work_of;
use serde::{Deserialize, Serialize};

use super::order::Order;
use crate::analysis::GroupWidth;

/// What rays are coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Cow<'static, str>", try_from = "String")]
pub enum ColourBy {
    /// Place in the order.
    #[default]
    Place,
    /// Group, so that neighbours differ.
    Group,
    /// Key.
    Key,
    /// What the key says of one coordinate.
    Field(Coordinate),
    /// Distance to the origin of the next ray in the order: where the curve jumps.
    Jump,
    /// Traced length.
    Length,
    /// Mean length of the ray's table cell over its traced length.
    EstimateRatio,
    /// Nodes visited and triangles tested.
    Work,
    /// Lane utilisation of the group.
    Lanes,
    /// Capsule area of the group.
    CapsuleArea,
    /// Direction spread of the group.
    Spread,
    /// Bounce of the queue.
    Bounce,
    /// Whether a surface was hit.
    Occlusion,
}

/// What comes before the coordinate in the name of [`ColourBy::Field`].
const FIELD_PREFIX: &str = "key:";

/// Colours that neighbouring groups go through.
const GROUP_CYCLE: usize = 7;

/// Logarithm of the distance from the ray at a place to the next; NaN for the last.
fn jump(order: &Order, place: usize) -> f32 {
    if place + 1 >= order.len() {
        return f32::NAN;
    }
    let [here, next] = [place, place + 1].map(|place| order.queue.segment(order.places.ray(place)).origin);
    let squared = [0, 1, 2].map(|axis| (next[axis] - here[axis]).powi(2)).iter().sum::<f64>();
    squared.sqrt().max(1e-6).log10() as f32
}

/// The middle of the range that a key's bits leave of a coordinate; NaN if it has none of them.
fn field(order: &Order, coordinate: Coordinate, ray: usize) -> f32 {
    let Ok((keys, layout)) = &order.keys else { return f32::NAN };
    let (key, mut value, mut bits) = (keys.at(ray), 0u64, 0i32);
    for (at, _) in layout
        .layout
        .bits()
        .iter()
        .enumerate()
        .take(layout.key_bits as usize)
        .filter(|(_, bit)| **bit == coordinate)
    {
        value = value << 1 | key >> (layout.key_bits as usize - 1 - at) & 1;
        bits += 1;
    }
    if bits == 0 { f32::NAN } else { ((value as f64 + 0.5) / 2f64.powi(bits)) as f32 }
}

impl From<ColourBy> for Cow<'static, str> {
    fn from(colour_by: ColourBy) -> Self {
        colour_by.name()
    }
}

impl TryFrom<String> for ColourBy {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        if let Some(field) = name.strip_prefix(FIELD_PREFIX) {
            let found = Coordinate::ALL.iter().find(|coordinate| coordinate.name() == field);
            return found.copied().map(Self::Field).ok_or_else(|| {
                let known: Vec<&str> = Coordinate::ALL.iter().map(|coordinate| coordinate.name()).collect();
                format!("there is no coordinate {field}; there are: {}", known.join(", "))
            });
        }
        Self::ALL.into_iter().find(|choice| choice.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|choice| choice.name()).collect();
            format!("nothing is coloured by {name}; there are: {}, key:ox and the like", known.join(", "))
        })
    }
}

impl ColourBy {
    /// All of them but the fields of a key, which depend on its layout.
    pub const ALL: [Self; 12] = [
        Self::Place,
        Self::Group,
        Self::Key,
        Self::Jump,
        Self::Length,
        Self::EstimateRatio,
        Self::Work,
        Self::Lanes,
        Self::CapsuleArea,
        Self::Spread,
        Self::Bounce,
        Self::Occlusion,
    ];

    /// Name in lists, in sessions and on the command line.
    pub fn name(self) -> Cow<'static, str> {
        Cow::Borrowed(match self {
            Self::Field(coordinate) => return Cow::Owned(format!("{FIELD_PREFIX}{}", coordinate.name())),
            Self::Place => "place",
            Self::Group => "group",
            Self::Key => "key",
            Self::Jump => "jump",
            Self::Length => "length",
            Self::EstimateRatio => "estimate",
            Self::Work => "work",
            Self::Lanes => "lanes",
            Self::CapsuleArea => "capsule-area",
            Self::Spread => "spread",
            Self::Bounce => "bounce",
            Self::Occlusion => "occlusion",
        })
    }

    /// What the colour bar says.
    pub fn title(self) -> &'static str {
        match self {
            Self::Place => "place in the order",
            Self::Group => "group (colours repeat)",
            Self::Key => "key, part of the largest",
            Self::Field(_) => "one coordinate as far as the key's bits say it, 0 to 1",
            Self::Jump => "distance to the next ray's origin, log10 of unit lengths",
            Self::Length => "traced length, unit lengths",
            Self::EstimateRatio => "estimated over actual length, log2",
            Self::Work => "nodes visited + triangles tested",
            Self::Lanes => "lane utilisation of the group (model)",
            Self::CapsuleArea => "capsule area of the group, log10",
            Self::Spread => "direction spread of the group",
            Self::Bounce => "bounce; 0 is the camera rays",
            Self::Occlusion => "0 nothing hit, 1 a surface hit",
        }
    }

    /// The number of the ray at a place; NaN where it is not known.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn value(self, order: &Order, width: GroupWidth, place: usize) -> f32 {
        let (queue, ray) = (&order.queue, order.places.ray(place));
        let group = || {
            let groups = order.groups(width);
            &groups.groups[groups.of_place(place)]
        };
        match self {
            Self::Place => place as f32,
            Self::Group => (place / width.rays() % GROUP_CYCLE) as f32,
            Self::Key => order.keys.as_ref().map_or(f32::NAN, |(keys, layout)| {
                (keys.at(ray) as f64 / 2f64.powi(layout.key_bits as i32)) as f32
            }),
            Self::Field(coordinate) => field(order, coordinate, ray),
            Self::Jump => jump(order, place),
            Self::Length => queue.lengths[ray],
            Self::EstimateRatio => queue.table.as_ref().map_or(f32::NAN, |table| {
                (table.mean(&queue.traced.rays()[ray]) / queue.lengths[ray].max(f32::MIN_POSITIVE)).log2()
            }),
            Self::Work => queue.work.as_ref().map_or(f32::NAN, |work| work_of(&work[ray]) as f32),
            Self::Lanes => group().lanes.map_or(f32::NAN, |lanes| lanes as f32),
            Self::CapsuleArea => group().area.max(1e-12).log10() as f32,
            Self::Spread => group().spread as f32,
            Self::Bounce => queue.id.bounce as f32,
            Self::Occlusion => f32::from(u8::from(queue.is_at_surface(ray))),
        }
    }

    /// Whether it takes the groups of the order to know it.
    pub fn is_of_group(self) -> bool {
        matches!(self, Self::Lanes | Self::CapsuleArea | Self::Spread)
    }

    /// Why nothing is known of it in an order, if so.
    pub fn missing(self, order: &Order) -> Option<&str> {
        match self {
            Self::Key | Self::Field(_) => order.keys.as_ref().err().map(String::as_str),
            Self::EstimateRatio => order.queue.table.as_ref().err().map(String::as_str),
            Self::Work | Self::Lanes => order.queue.work.as_ref().err().map(String::as_str),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        let fields = Coordinate::ALL.iter().map(|&coordinate| ColourBy::Field(coordinate));
        for choice in ColourBy::ALL.into_iter().chain(fields) {
            assert_eq!(ColourBy::try_from(choice.name().into_owned()), Ok(choice));
        }
        assert!(ColourBy::try_from("colour".to_owned()).unwrap_err().contains("place, group"));
        assert!(ColourBy::try_from("key:no".to_owned()).unwrap_err().contains("ox, oy"));
    }
}
