//! The rays of an order that pass a filter: blocks of places, node by node, on all threads.

use std::collections::BTreeMap;
use std::ops::Range;

use formats::key::Coordinate;
use formats::metrics::quantity::OrderedRays;
use rayon::prelude::*;

use super::error::FilterError;
use super::parse::Expression;
use super::tree::{Condition, Connective, Fact, Number};
use crate::model::numbers::Numbers;

/// Places that each node of the tree is evaluated for at a time.
const BLOCK: usize = 256;
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

/// The places whose rays meet an expression.
///
/// # Errors
/// If it asks for what is not known of these rays, such as a field that their keys do not have.
pub fn passing(expression: &Expression, numbers: &Numbers) -> Result<Passing, FilterError> {
    let evaluation = Evaluation::of(expression, numbers)?;
    let rays = numbers.order.len();
    let of_task = |task: usize| {
        let size = BLOCK * BLOCKS_PER_TASK;
        let (first, end) = (task * size, rays.min((task + 1) * size));
        let mut found = Vec::new();
        for first in (first..end).step_by(BLOCK) {
            let places = first..end.min(first + BLOCK);
            let mut passes = [false; BLOCK];
            evaluation.conditions(&expression.condition, &places, &mut passes);
            let passed = places.zip(passes).filter(|(_, passes)| *passes);
            found.extend(passed.map(|(place, _)| place as u32));
        }
        found
    };
    let tasks = rays.div_ceil(BLOCK * BLOCKS_PER_TASK);
    let found: Vec<Vec<u32>> = (0..tasks).into_par_iter().map(of_task).collect();
    Ok(Passing::of(found.concat(), rays))
}

/// What an expression is evaluated with.
struct Evaluation<'a> {
    numbers: &'a Numbers,
    rays: OrderedRays<'a>,
    /// Positions in the key of each coordinate that is asked for, highest bit first.
    fields: BTreeMap<Coordinate, Vec<u32>>,
}

impl<'a> Evaluation<'a> {
    fn of(expression: &Expression, numbers: &'a Numbers) -> Result<Self, FilterError> {
        let mut evaluation = Self { numbers, rays: numbers.rays(), fields: BTreeMap::new() };
        evaluation.check_condition(&expression.condition)?;
        // With the groups that were found meanwhile.
        evaluation.rays = numbers.rays();
        Ok(evaluation)
    }

    fn check_condition(&mut self, condition: &Condition) -> Result<(), FilterError> {
        match condition {
            Condition::Fact(_) => Ok(()),
            Condition::Compare(_, numbers) => numbers.iter().try_for_each(|number| self.check_number(number)),
            Condition::Not(inner) => self.check_condition(inner),
            Condition::Both(_, both) => both.iter().try_for_each(|condition| self.check_condition(condition)),
        }
    }

    fn check_number(&mut self, number: &Number) -> Result<(), FilterError> {
        match number {
            Number::Literal(_) => Ok(()),
            Number::Quantity(quantity, span) => match quantity.missing(&self.rays) {
                Some(reason) => {
                    let message = format!("'{}' is not known here: {reason}", quantity.name());
                    Err(FilterError::new(span, message))
                }
                None => {
                    self.numbers.prepare(*quantity);
                    Ok(())
                }
            },
            Number::Field(coordinate, span) => self.check_field(*coordinate, span),
            Number::Call(_, inner) => self.check_number(inner),
            Number::Binary(_, both) => both.iter().try_for_each(|number| self.check_number(number)),
        }
    }

    fn check_field(&mut self, coordinate: Coordinate, span: &Range<usize>) -> Result<(), FilterError> {
        let name = coordinate.name();
        let unknown = |reason: String| FilterError::new(span, reason);
        let (_, layout) = self
            .numbers
            .order
            .keys
            .as_ref()
            .map_err(|reason| unknown(format!("'field({name})' is not known here: {reason}")))?;
        let fields = layout.layout.fields(layout.key_bits);
        let Some(field) = fields.iter().find(|field| field.coordinate == coordinate) else {
            let known: Vec<&str> = fields.iter().map(|field| field.coordinate.name()).collect();
            let method = &self.numbers.order.method;
            return Err(unknown(format!(
                "keys of {method} have no field {name}; they have {}",
                known.join(" ")
            )));
        };
        self.fields.insert(coordinate, field.positions.clone());
        Ok(())
    }

    fn conditions(&self, condition: &Condition, places: &Range<usize>, out: &mut [bool; BLOCK]) {
        match condition {
            Condition::Fact(fact) => {
                let queue = &self.numbers.order.queue;
                for (place, out) in places.clone().zip(out) {
                    *out = match fact {
                        Fact::Hit => queue.is_at_surface(self.numbers.order.places.ray(place)),
                        Fact::Shadow => queue.id.kind == formats::ray::Kind::Shadow,
                    };
                }
            }
            Condition::Compare(comparison, both) => {
                let [left, right] = self.two_numbers(both, places);
                let pairs = left.into_iter().zip(right).zip(out);
                pairs.for_each(|((left, right), out)| *out = comparison.of(left, right));
            }
            Condition::Not(inner) => {
                self.conditions(inner, places, out);
                out.iter_mut().for_each(|out| *out = !*out);
            }
            Condition::Both(connective, both) => {
                let [left, right] = &**both;
                self.conditions(left, places, out);
                // What is decided for the whole block needs no second look.
                let decided = *connective == Connective::Or;
                if out[..places.len()].iter().all(|&out| out == decided) {
                    return;
                }
                let mut second = [false; BLOCK];
                self.conditions(right, places, &mut second);
                out.iter_mut().zip(second).for_each(|(out, second)| *out = connective.of(*out, second));
            }
        }
    }

    fn two_numbers(&self, both: &[Number; 2], places: &Range<usize>) -> [[f64; BLOCK]; 2] {
        let mut found = [[0.0; BLOCK]; 2];
        both.iter().zip(&mut found).for_each(|(number, out)| self.numbers(number, places, out));
        found
    }

    fn numbers(&self, number: &Number, places: &Range<usize>, out: &mut [f64; BLOCK]) {
        match number {
            Number::Literal(value) => out.fill(*value),
            Number::Quantity(quantity, _) => {
                let value = quantity.value();
                let places = places.clone().zip(out);
                places.for_each(|(place, out)| *out = value(self.rays.at(place)));
            }
            Number::Field(coordinate, _) => {
                let positions = self.fields.get(coordinate).map_or(&[][..], Vec::as_slice);
                for (place, out) in places.clone().zip(out) {
                    let key = self.rays.at(place).key().unwrap_or(0);
                    let bits = positions.iter().fold(0, |bits, &at| bits << 1 | key >> at & 1);
                    *out = bits as f64;
                }
            }
            Number::Call(function, inner) => {
                self.numbers(inner, places, out);
                out.iter_mut().for_each(|out| *out = function.of(*out));
            }
            Number::Binary(arithmetic, both) => {
                let [left, right] = self.two_numbers(both, places);
                let pairs = left.into_iter().zip(right).zip(out);
                pairs.for_each(|((left, right), out)| *out = arithmetic.of(left, right));
            }
        }
    }
}
