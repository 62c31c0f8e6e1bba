//! What if: another order of recorded rays, made here by another method, other bits or another layout.
//!
//! Keys are made as the recorder makes them, from what was recorded: settings of a recorded method give
//! its recorded keys.

use std::sync::Arc;

use clap::ValueEnum;
use formats::key::{
    Coordinate, Encoder, Extent, Facts, KEY_BITS_MIN, LAYOUT_BITS, Layout, LayoutError, LayoutText, Method,
    Termination,
};
use formats::manifest::{Header, MethodRecord};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::order::{KeyLayout, Order};
use super::queue::Queue;
use crate::shown;

/// What the order is called, where orders have the names of methods.
pub const WHAT_IF: &str = "what-if";

/// Rays that a thread takes at a time.
const RAYS_PER_TASK: usize = 8192;

/// How keys are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The layout, in words as `recorder record --method` takes them.
    pub text: String,
    /// Bits of a key, 8 to 64.
    pub key_bits: u32,
    /// Where the estimate of a ray's length comes from, if the layout needs one and does not say it.
    pub estimate: Estimate,
    /// The estimate if it is one for all rays, unit lengths.
    pub length: f32,
}

/// Where the estimate of a ray's length comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Estimate {
    /// One length for all rays.
    #[default]
    Fixed,
    /// The mean of the ray's cell in the recorded length table.
    Table,
    /// The traced length: an upper bound, since the ray must be traced first.
    Traced,
}

impl Estimate {
    /// All of them, with name and what it is.
    pub const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Fixed, "one length", "The same length for all rays, as two-point has it"),
        (Self::Table, "length table", "Mean length of the ray's table cell, as two-point-adaptive has it"),
        (
            Self::Traced,
            "traced length",
            "The length that was traced: an upper bound, as two-point-real has it",
        ),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    fn of(termination: Termination) -> Self {
        match termination {
            Termination::Unused | Termination::Fixed => Self::Fixed,
            Termination::Adaptive => Self::Table,
            Termination::Real => Self::Traced,
        }
    }
}

impl Settings {
    /// Those of a recorded method; its bits as far as keys can have them.
    pub fn of(record: &MethodRecord) -> Self {
        Self {
            text: shown::sentence(record.text.clone()),
            key_bits: record.key_bits.clamp(KEY_BITS_MIN, LAYOUT_BITS),
            estimate: Estimate::of(record.termination),
            length: record.two_point_length,
        }
    }

    /// Those of a layout, with the key bits and the length of a recording.
    fn with(text: &str, estimate: Estimate, header: &Header) -> Self {
        let key_bits = header.options.key_bits.clamp(KEY_BITS_MIN, LAYOUT_BITS);
        Self { text: text.to_owned(), key_bits, estimate, length: header.options.two_point_length }
    }

    /// Those of a method that is built in, with the key bits and the length of a recording.
    pub fn builtin(name: &str, header: &Header) -> Option<Self> {
        let method = Method::builtin(name).ok()?;
        Some(Self::with(method.layout.text(), Estimate::of(method.termination), header))
    }

    /// Those of a method that is built in, or of a layout with the same length for all rays; key bits and
    /// length are those of a recording.
    pub fn named(name_or_layout: &str, header: &Header) -> Self {
        let builtin = Self::builtin(name_or_layout, header);
        builtin.unwrap_or_else(|| Self::with(name_or_layout, Estimate::Fixed, header))
    }

    /// What each bit comes from, for as much as a recording has to number.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn layout(&self, extent: Extent) -> Result<Layout, LayoutError> {
        LayoutText::parse(&self.text)?.expand(extent)
    }

    /// Where the text says that the estimate comes from, if it does.
    pub fn said_estimate(&self) -> Option<Estimate> {
        LayoutText::parse(&self.text).ok()?.length().map(Estimate::of)
    }

    /// The keys of a queue's rays, in canonical order, and how they are made.
    ///
    /// # Errors
    /// If layout or bits are wrong, as a session may have them, or need what the recording did not keep.
    pub fn keys(&self, header: &Header, queue: &Queue) -> Result<(Vec<u64>, KeyLayout), String> {
        if !(KEY_BITS_MIN..=LAYOUT_BITS).contains(&self.key_bits) {
            return Err(format!("{} key bits, expected {KEY_BITS_MIN} to {LAYOUT_BITS}", self.key_bits));
        }
        let layout = self.layout(header.extent()).map_err(|error| error.message)?;
        let lights = if layout.uses(Coordinate::needs_light) {
            let lights =
                queue.lights.as_ref().ok_or("the layout needs a light, which only shadow rays have")?;
            if let Some(light) = lights.iter().find(|&&light| light as usize >= header.lights.len()) {
                return Err(format!("a ray goes to light {light} of {}", header.lights.len()));
            }
            Some(&lights[..])
        } else {
            None
        };
        let estimate = self.said_estimate().unwrap_or(self.estimate);
        let table = match (layout.uses(Coordinate::needs_length), estimate) {
            (true, Estimate::Table) => Some(queue.table.as_ref().map_err(String::clone)?),
            _ => None,
        };
        let rays = queue.traced.rays();
        let length = |ray: usize| match estimate {
            Estimate::Fixed => self.length,
            Estimate::Table => table.map_or(self.length, |table| table.mean(&rays[ray])),
            Estimate::Traced => queue.lengths[ray],
        };
        let light = |ray: usize| lights.map_or(0, |lights| lights[ray]);
        let path = |ray: usize| queue.path_ids[ray];
        let encoder = Encoder::new(&layout, self.key_bits, *queue.traced.unit(), &header.lights);
        let mut keys = vec![0; queue.len()];
        keys.par_chunks_mut(RAYS_PER_TASK).zip(rays.par_chunks(RAYS_PER_TASK)).enumerate().for_each(
            |(task, (keys, rays))| {
                let first = task * RAYS_PER_TASK;
                let facts = Facts {
                    length: |at| length(first + at),
                    light: |at| light(first + at),
                    path: |at| path(first + at),
                };
                encoder.encode_all(rays, &facts, keys);
            },
        );
        Ok((keys, KeyLayout { layout, key_bits: self.key_bits, text: self.text.clone() }))
    }

    /// The order of a queue by these keys.
    ///
    /// # Errors
    /// As [`Settings::keys`].
    pub fn order(&self, header: &Header, queue: Arc<Queue>) -> Result<Order, String> {
        let (keys, layout) = self.keys(header, &queue)?;
        Ok(Order::of_keys(queue, WHAT_IF, keys, layout))
    }
}
