//! The rays of an order that pass a filter: blocks of places, node by node, on all threads.

use std::ops::Range;

use formats::key::Coordinate;
use formats::key::decode::FieldReader;
use formats::metrics::quantity::OrderedRays;
use formats::ray::Kind;
use rayon::prelude::*;

use super::error::FilterError;
use super::parse::Expression;
use super::tree::{BLOCK, Block, Fact, Node};

/// Blocks that a thread takes at a time.
const BLOCKS_PER_TASK: usize = 32;

/// The places of an order whose rays pass.
#[derive(Debug, Default)]
pub struct Passing {
    places: Vec<u32>,
    /// A bit for each place.
    bits: Vec<u64>,
}

impl Passing {
    /// Of ascending places of an order of so many rays.
    ///
    /// # Panics
    /// If there is a place that the order does not have.
    pub fn of(places: Vec<u32>, rays: usize) -> Self {
        let mut bits = vec![0u64; rays.div_ceil(64)];
        for &place in &places {
            bits[place as usize / 64] |= 1 << (place % 64);
        }
        Self { places, bits }
    }

    /// Places that pass, ascending.
    pub fn places(&self) -> &[u32] {
        &self.places
    }

    /// How many pass.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether none passes.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether the ray at a place passes.
    pub fn contains(&self, place: usize) -> bool {
        self.bits.get(place / 64).is_some_and(|word| word >> (place % 64) & 1 == 1)
    }

    /// Which of [`Passing::places`] lie in a range of places.
    pub fn between(&self, places: &Range<usize>) -> Range<usize> {
        let before = |end: usize| self.places.partition_point(|&place| (place as usize) < end);
        before(places.start)..before(places.end)
    }
}

/// What expressions are evaluated with.
pub struct FilteredRays<'a> {
    /// The rays of an order, with their groups where the expression [takes](Expression::takes_groups) them.
    pub rays: OrderedRays<'a>,
    /// What the order is called.
    pub method: &'a str,
    /// What reads each coordinate that can be read out of its keys, in the layout's order.
    pub fields: Vec<(Coordinate, FieldReader)>,
}

/// The places whose rays meet an expression.
///
/// # Errors
/// If it asks for what is not known of these rays, such as a field that their keys do not have.
pub fn passing(expression: &Expression, of: &FilteredRays<'_>) -> Result<Passing, FilterError> {
    of.check(&expression.condition)?;
    let rays = of.rays.places.len();
    let of_task = |task: usize| {
        let size = BLOCK * BLOCKS_PER_TASK;
        let (first, end) = (task * size, rays.min((task + 1) * size));
        let mut found = Vec::new();
        for first in (first..end).step_by(BLOCK) {
            let places = first..end.min(first + BLOCK);
            let mut passes = [0.0; BLOCK];
            of.values(&expression.condition, &places, &mut passes);
            let passed = places.zip(passes).filter(|(_, passes)| *passes != 0.0);
            found.extend(passed.map(|(place, _)| place as u32));
        }
        found
    };
    let tasks = rays.div_ceil(BLOCK * BLOCKS_PER_TASK);
    let found: Vec<Vec<u32>> = (0..tasks).into_par_iter().map(of_task).collect();
    Ok(Passing::of(found.concat(), rays))
}

impl FilteredRays<'_> {
    fn check(&self, node: &Node) -> Result<(), FilterError> {
        match node {
            Node::Literal(_) | Node::Fact(_) => Ok(()),
            Node::Quantity(quantity, span) => quantity.missing(&self.rays).map_or(Ok(()), |reason| {
                Err(FilterError::new(span, format!("'{}' is not known here: {reason}", quantity.name())))
            }),
            Node::Field(coordinate, span) => self.reader(*coordinate, span).map(|_| ()),
            Node::Unary(_, inner) => self.check(inner),
            Node::Binary(_, both) => both.iter().try_for_each(|node| self.check(node)),
        }
    }

    fn reader(&self, coordinate: Coordinate, span: &Range<usize>) -> Result<&FieldReader, FilterError> {
        let name = coordinate.name();
        if let Err(reason) = self.rays.keys {
            return Err(FilterError::new(span, format!("'field({name})' is not known here: {reason}")));
        }
        let found = self.fields.iter().find(|(known, _)| *known == coordinate).map(|(_, reader)| reader);
        found.ok_or_else(|| {
            let known: Vec<&str> = self.fields.iter().map(|(known, _)| known.name()).collect();
            let known = if known.is_empty() { "none that can be read".to_owned() } else { known.join(" ") };
            let message = format!("keys of {} have no field {name}; they have {known}", self.method);
            FilterError::new(span, message)
        })
    }

    /// The values of a node at the places of a block.
    fn values(&self, node: &Node, places: &Range<usize>, out: &mut Block) {
        match node {
            Node::Literal(value) => out.fill(*value),
            Node::Quantity(quantity, _) => {
                let value = quantity.value();
                fill(out, places, |place| value(self.rays.at(place)));
            }
            Node::Field(coordinate, span) => {
                let reader = self.reader(*coordinate, span).ok();
                let key = |place| self.rays.at(place).key().unwrap_or(0);
                fill(out, places, |place| reader.map_or(0.0, |reader| reader.value(key(place)) as f64));
            }
            Node::Fact(fact) => {
                let OrderedRays { traced, id, places: order, .. } = self.rays;
                fill(out, places, |place| {
                    f64::from(match fact {
                        Fact::Hit => traced.is_at_surface(order.ray(place)),
                        Fact::Shadow => id.kind == Kind::Shadow,
                    })
                });
            }
            Node::Unary(function, inner) => {
                self.values(inner, places, out);
                out.iter_mut().for_each(|value| *value = (function.of)(*value));
            }
            Node::Binary(operator, both) => {
                let [left, right] = &**both;
                self.values(left, places, out);
                // What is decided for the whole block needs no second look.
                let is_decided = |by: bool| out[..places.len()].iter().all(|&met| (met != 0.0) == by);
                if !operator.decided_by.is_some_and(is_decided) {
                    let mut second = [0.0; BLOCK];
                    self.values(right, places, &mut second);
                    (operator.apply)(out, &second);
                }
            }
        }
    }
}

fn fill(out: &mut Block, places: &Range<usize>, value: impl Fn(usize) -> f64) {
    places.clone().zip(out).for_each(|(place, out)| *out = value(place));
}
