//! What rays are coloured by: any of their numbers, or what their keys say of one coordinate.

use formats::key::Coordinate;
use formats::key::decode::FieldReader;
use formats::metrics::quantity::{OrderedRays, Quantity};
use serde::{Deserialize, Serialize};

use super::numbers::Numbers;

/// What rays are coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum ColourBy {
    /// A number that they have.
    Quantity(Quantity),
    /// What the key says of one coordinate.
    Field(Coordinate),
}

/// What comes before the coordinate in the name of [`ColourBy::Field`].
const FIELD_PREFIX: &str = "key:";

impl Default for ColourBy {
    fn default() -> Self {
        Self::Quantity(Quantity::Place)
    }
}

impl From<ColourBy> for String {
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
        Quantity::of_name(&name).map(Self::Quantity).ok_or_else(|| {
            let known: Vec<&str> = Quantity::ALL.iter().map(|quantity| quantity.name()).collect();
            format!("nothing is coloured by {name}; there are: {}, key:ox and the like", known.join(", "))
        })
    }
}

impl ColourBy {
    /// Name in lists, in sessions and on the command line.
    pub fn name(self) -> String {
        match self {
            Self::Quantity(quantity) => quantity.name().to_owned(),
            Self::Field(coordinate) => format!("{FIELD_PREFIX}{}", coordinate.name()),
        }
    }

    /// What the colour bar says.
    pub fn title(self) -> String {
        match self {
            Self::Quantity(quantity) => quantity.title(),
            Self::Field(_) => "one coordinate as far as the key's bits say it, 0 to 1".to_owned(),
        }
    }

    /// The numbers of the rays at some places of an order; NaN where they are not known. Groups that it takes
    /// are found on this thread.
    ///
    /// # Panics
    /// If there is no such place.
    pub fn values(self, numbers: &Numbers, places: impl Iterator<Item = usize>) -> Vec<f32> {
        match self {
            Self::Quantity(quantity) => {
                numbers.prepare(quantity);
                let (rays, value) = (numbers.rays(), quantity.value());
                places.map(|place| quantity.coloured(value(rays.at(place)), &rays)).collect()
            }
            Self::Field(coordinate) => {
                let reader = numbers.order.field_reader(coordinate);
                let rays = numbers.rays();
                places.map(|place| field(&rays, reader.as_ref(), place)).collect()
            }
        }
    }

    /// Why nothing is known of it in an order, if so.
    pub fn missing(self, numbers: &Numbers) -> Option<String> {
        let quantity = match self {
            Self::Quantity(quantity) => quantity,
            Self::Field(_) => Quantity::Key,
        };
        quantity.missing(&numbers.rays()).map(str::to_owned)
    }
}

/// The middle of the range that a key's bits leave of a coordinate; NaN if it has none of them.
fn field(rays: &OrderedRays<'_>, reader: Option<&FieldReader>, place: usize) -> f32 {
    match (rays.at(place).key(), reader) {
        (Some(key), Some(reader)) => {
            ((reader.value(key) as f64 + 0.5) / 2f64.powi(reader.bits() as i32)) as f32
        }
        _ => f32::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        let fields = Coordinate::ALL.iter().map(|&coordinate| ColourBy::Field(coordinate));
        for choice in Quantity::ALL.iter().map(|&quantity| ColourBy::Quantity(quantity)).chain(fields) {
            assert_eq!(ColourBy::try_from(choice.name()), Ok(choice));
        }
        assert!(ColourBy::try_from("colour".to_owned()).unwrap_err().contains("place, ray"));
        assert!(ColourBy::try_from("key:no".to_owned()).unwrap_err().contains("ox, oy"));
    }
}
