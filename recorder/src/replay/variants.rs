//! Methods at several key bits and several lengths: a sweep in one run, on the same rays.

use anyhow::{Context, Result, bail, ensure};
use formats::key::{Extent, Method, Termination};

use super::split::{can_split, split};
use crate::options::OptionError;
use crate::stages::setup::MethodPlan;

/// Key bits and lengths to measure; empty for what was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Bits of a key, 8 to 64.
    pub key_bits: Vec<u32>,
    /// Lengths that fixed estimates assume, in unit lengths.
    pub lengths: Vec<f32>,
    /// Bits of a key that are the origin's; where there are none, layouts are as they are.
    pub origin_bits: Vec<u32>,
}

impl Sweep {
    /// From the words of `--key-bits`, `--two-point-length` and `--split`.
    ///
    /// # Errors
    /// If they are neither a list nor a range.
    pub fn parse(
        key_bits: Option<&str>,
        lengths: Option<&str>,
        split: Option<&str>,
    ) -> Result<Self, OptionError> {
        let whole = |option, text: Option<&str>, min| {
            let Some(text) = text else { return Ok(Vec::new()) };
            let values = values(option, text, min, 64.0)?.into_iter();
            let values = values.map(|value| (value.fract() == 0.0).then_some(value as u32));
            values.collect::<Option<Vec<u32>>>().ok_or_else(|| range(option, text, "whole numbers"))
        };
        let mut sweep = Self {
            key_bits: whole("key-bits", key_bits, 8.0)?,
            origin_bits: whole("split", split, 0.0)?,
            lengths: lengths
                .map(|text| values("two-point-length", text, 0.0, 2.0))
                .transpose()?
                .unwrap_or_default(),
        };
        sweep.key_bits.dedup();
        sweep.origin_bits.dedup();
        sweep.lengths.dedup();
        Ok(sweep)
    }

    /// One plan per method, key bits, share of the origin where a method has one to change and, where a method
    /// assumes a length, length. With one number of bits and one length, the methods keep their names; else a
    /// variant's name says what it differs in: `aila-16-bits`, `two-point-length-0-1`, `octahedron-split-12-20`.
    ///
    /// # Errors
    /// If a layout needs a picture where there is none, two variants would have one name, or no method's origin can have such
    /// shares.
    pub fn plans(
        &self,
        methods: &[Method],
        extent: Extent,
        recorded_bits: u32,
        recorded_length: f32,
    ) -> Result<Vec<MethodPlan>> {
        let or_recorded = |bits: &[u32]| if bits.is_empty() { vec![recorded_bits] } else { bits.to_vec() };
        let all_bits = or_recorded(&self.key_bits);
        let first_length = self.lengths.first().copied().unwrap_or(recorded_length);
        let mut plans: Vec<MethodPlan> = Vec::new();
        if !self.origin_bits.is_empty() && !methods.iter().any(can_split) {
            bail!(
                "--split: no method has an origin and a direction or end point whose bits could be shared out; name one that has both, such as octahedron or two-point"
            );
        }
        for method in methods {
            let has_length = method.termination == Termination::Fixed && self.lengths.len() > 1;
            let lengths = if has_length { self.lengths.clone() } else { vec![first_length] };
            for &bits in &all_bits {
                for variant in self.splits(method, bits)? {
                    for &length in &lengths {
                        let plan = MethodPlan::new(&variant, extent, bits, length)?;
                        let mut plan = MethodPlan { base: method.name.clone(), ..plan };
                        if all_bits.len() > 1 {
                            plan.name += &format!("-{bits}-bits");
                        }
                        if has_length {
                            plan.name += &format!("-length-{}", format!("{length}").replace('.', "-"));
                        }
                        let is_known = plans.iter().any(|known| known.name == plan.name);
                        ensure!(!is_known, "'{}' is asked for twice", plan.name);
                        plans.push(plan);
                    }
                }
            }
        }
        Ok(plans)
    }

    /// A method with keys of so many bits for each share of the origin, or as it is.
    fn splits(&self, method: &Method, key_bits: u32) -> Result<Vec<Method>> {
        if self.origin_bits.is_empty() || !can_split(method) {
            return Ok(vec![method.clone()]);
        }
        let variant = |&origin_bits: &u32| {
            let variant = split(method, origin_bits, key_bits).with_context(|| {
                format!("--split: keys of {key_bits} bits have no {origin_bits} for the origin")
            })?;
            variant.with_context(|| {
                format!("--split: {} cannot give {origin_bits} of {key_bits} bits to the origin", method.name)
            })
        };
        self.origin_bits.iter().map(variant).collect()
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
        let sweep = Sweep::parse(Some("8, 16,64"), Some("0.05..0.4:8"), Some("4..28:7")).unwrap();
        assert_eq!(sweep.key_bits, [8, 16, 64]);
        assert_eq!(sweep.lengths, [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]);
        assert_eq!(sweep.origin_bits, [4, 8, 12, 16, 20, 24, 28]);
        assert_eq!(Sweep::parse(None, None, None).unwrap(), Sweep::default());
        assert!(Sweep::parse(None, None, Some("4..28:6")).unwrap_err().to_string().contains("whole"));
        for (bits, length) in [
            ("7", "0.1"),
            ("65", "0.1"),
            ("8,x", "0.1"),
            ("8.5", "0.1"),
            ("", "0.1"),
            ("8", "0.1..0.2"),
            ("8", "3"),
        ] {
            assert!(Sweep::parse(Some(bits), Some(length), None).is_err(), "{bits} {length}");
        }
    }

    #[test]
    fn variants_have_names_that_say_what_differs() {
        let methods = ["aila", "two-point"].map(|name| Method::builtin(name).unwrap());
        let names = |bits: &str, lengths: &str| -> Vec<String> {
            let sweep = Sweep::parse(Some(bits), Some(lengths), None).unwrap();
            let plans = sweep.plans(&methods, Extent::NOTHING, 32, 0.25).unwrap();
            plans.into_iter().map(|plan| plan.name).collect()
        };
        assert_eq!(names("32", "0.25"), ["aila", "two-point"]);
        assert_eq!(names("8,16", "0.25").len(), 4);
        assert_eq!(names("16", "0.1,0.25"), ["aila", "two-point-length-0-1", "two-point-length-0-25"]);
        assert_eq!(names("8,16", "0.1,0.25")[2], "two-point-8-bits-length-0-1");
        let sweep = Sweep { key_bits: vec![8, 16, 8], ..Sweep::default() };
        assert!(sweep.plans(&methods, Extent::NOTHING, 32, 0.25).is_err());
    }

    #[test]
    fn shares_of_the_origin_are_for_methods_that_have_another_part() {
        let plans = |methods: &[&str], bits: &str, split: &str| {
            let methods: Vec<Method> = methods.iter().map(|name| Method::builtin(name).unwrap()).collect();
            let sweep = Sweep::parse(Some(bits), None, Some(split)).unwrap();
            sweep.plans(&methods, Extent::NOTHING, 32, 0.25).map_err(|error| format!("{error:#}"))
        };
        let found = plans(&["origin", "octahedron"], "32", "4..28:2").unwrap();
        let names: Vec<_> = found.iter().map(|plan| (plan.name.as_str(), plan.base.as_str())).collect();
        let octahedron = |name| (name, "octahedron");
        assert_eq!(
            names,
            [("origin", "origin"), octahedron("octahedron-split-4-28"), octahedron("octahedron-split-28-4")]
        );
        assert_eq!(plans(&["aila"], "16,32", "8").unwrap()[0].name, "aila-split-8-8-16-bits");
        assert!(plans(&["origin"], "32", "8").unwrap_err().contains("no method has"));
        assert!(plans(&["aila"], "16", "20").unwrap_err().contains("16 bits have no 20"));
        assert!(plans(&["octahedron"], "64", "4").unwrap_err().contains("mentioned more than 22"));
    }
}
