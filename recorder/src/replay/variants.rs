//! Methods at several key bits and several lengths: a sweep in one run, on the same rays.

use anyhow::{Context, Result};
use formats::key::{Method, Termination};

use crate::options::OptionError;
use crate::stages::setup::MethodPlan;

/// Key bits and lengths to measure; empty for what was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Bits of a key, 8 to 64.
    pub key_bits: Vec<u32>,
    /// Lengths that fixed estimates assume, in unit lengths.
    pub lengths: Vec<f32>,
}

impl Sweep {
    /// From the words of `--key-bits` and `--two-point-length`.
    ///
    /// # Errors
    /// If they are neither a list nor a range.
    pub fn parse(key_bits: Option<&str>, lengths: Option<&str>) -> Result<Self, OptionError> {
        let bits = |text| {
            values("key-bits", text, 8.0, 64.0)?
                .into_iter()
                .map(|value| {
                    let is_whole = value.fract() == 0.0;
                    is_whole.then_some(value as u32).ok_or_else(|| range("key-bits", text, "whole numbers"))
                })
                .collect::<Result<Vec<u32>, _>>()
        };
        let mut sweep = Self {
            key_bits: key_bits.map(bits).transpose()?.unwrap_or_default(),
            lengths: lengths
                .map(|text| values("two-point-length", text, 0.0, 2.0))
                .transpose()?
                .unwrap_or_default(),
        };
        sweep.key_bits.dedup();
        sweep.lengths.dedup();
        Ok(sweep)
    }

    /// One plan per method, key bits and, where a method assumes a length, length. With one value each, the
    /// methods keep their names; else a variant's name says what it differs in: `aila-16-bits`,
    /// `two-point-length-0-1`.
    ///
    /// # Errors
    /// If a layout does not fit the lights, or two variants would have one name.
    pub fn plans(
        &self,
        methods: &[Method],
        lights: usize,
        recorded_bits: u32,
        recorded_length: f32,
    ) -> Result<Vec<MethodPlan>> {
        let or_recorded = |bits: &[u32]| if bits.is_empty() { vec![recorded_bits] } else { bits.to_vec() };
        let all_bits = or_recorded(&self.key_bits);
        let first_length = self.lengths.first().copied().unwrap_or(recorded_length);
        let mut plans: Vec<MethodPlan> = Vec::new();
        for method in methods {
            let has_length = method.termination == Termination::Fixed && self.lengths.len() > 1;
            let lengths = if has_length { self.lengths.clone() } else { vec![first_length] };
            for &bits in &all_bits {
                for &length in &lengths {
                    let mut plan = MethodPlan::new(method, lights, bits, length)?;
                    if all_bits.len() > 1 {
                        plan.name += &format!("-{bits}-bits");
                    }
                    if has_length {
                        plan.name += &format!("-length-{}", format!("{length}").replace('.', "-"));
                    }
                    let is_known = plans.iter().any(|known| known.name == plan.name);
                    (!is_known)
                        .then_some(())
                        .with_context(|| format!("'{}' is asked for twice", plan.name))?;
                    plans.push(plan);
                }
            }
        }
        Ok(plans)
    }
}

/// The numbers of `a,b,c`, or `n` numbers from `a` to `b` for `a..b:n`.
fn values(option: &'static str, text: &str, min: f32, max: f32) -> Result<Vec<f32>, OptionError> {
    let expected = "a number, a list such as 8,16,32, or a range such as 0.05..0.4:8";
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|value| (min..=max).contains(value));
    let found = match text.split_once("..") {
        None => text.split(',').map(number).collect::<Option<Vec<f32>>>(),
        Some((first, rest)) => rest.split_once(':').and_then(|(last, count)| {
            let (first, last) = (number(first)?, number(last)?);
            let count = count.trim().parse::<u16>().ok().filter(|&count| count > 1)?;
            // Rounded to five digits, so that names stay short.
            let step = |at: u16| first + (last - first) * f32::from(at) / f32::from(count - 1);
            Some((0..count).map(|at| (step(at) * 1e5).round() / 1e5).collect())
        }),
    };
    found.ok_or_else(|| range(option, text, &format!("{expected}, each from {min} to {max}")))
}

fn range(option: &'static str, found: &str, expected: &str) -> OptionError {
    OptionError::Range { option, found: found.to_owned(), expected: expected.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_ranges() {
        let sweep = Sweep::parse(Some("8, 16,64"), Some("0.05..0.4:8")).unwrap();
        assert_eq!(sweep.key_bits, [8, 16, 64]);
        assert_eq!(sweep.lengths, [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]);
        assert_eq!(Sweep::parse(None, None).unwrap(), Sweep::default());
        for (bits, length) in [
            ("7", "0.1"),
            ("65", "0.1"),
            ("8,x", "0.1"),
            ("8.5", "0.1"),
            ("", "0.1"),
            ("8", "0.1..0.2"),
            ("8", "3"),
        ] {
            assert!(Sweep::parse(Some(bits), Some(length)).is_err(), "{bits} {length}");
        }
    }

    #[test]
    fn variants_have_names_that_say_what_differs() {
        let methods = ["aila", "two-point"].map(|name| Method::builtin(name).unwrap());
        let names = |bits: &str, lengths: &str| -> Vec<String> {
            let sweep = Sweep::parse(Some(bits), Some(lengths)).unwrap();
            sweep.plans(&methods, 1, 32, 0.25).unwrap().into_iter().map(|plan| plan.name).collect()
        };
        assert_eq!(names("32", "0.25"), ["aila", "two-point"]);
        assert_eq!(names("8,16", "0.25").len(), 4);
        assert_eq!(names("16", "0.1,0.25"), ["aila", "two-point-length-0-1", "two-point-length-0-25"]);
        assert_eq!(names("8,16", "0.1,0.25")[2], "two-point-8-bits-length-0-1");
        let sweep = Sweep { key_bits: vec![8, 16, 8], lengths: vec![] };
        assert!(sweep.plans(&methods, 1, 32, 0.25).is_err());
    }
}
