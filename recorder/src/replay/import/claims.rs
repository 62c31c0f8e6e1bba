//! What a folder of queues says of the keys of its orders: `orders.txt`, a line `NAME = LAYOUT @ BITS` each.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail, ensure};
use formats::key::method::{BUILTIN, WITHOUT_LAYOUT};
use formats::key::{KEY_BITS_MIN, LAYOUT_BITS, Layout, Method, Termination};
use formats::text::one_line;

use crate::foreign::ForeignOrder;
use crate::options::RecordOptions;
use crate::stages::setup::{MethodPlan, Setup};

/// Name of the file.
pub(super) const FILE: &str = "orders.txt";
/// Most characters of a line that a message shows.
const SHOWN: usize = 200;

/// Layout and key bits that the keys of an order are said to have, by the order's name.
#[derive(Debug)]
pub(super) struct Claims(BTreeMap<String, (Method, u32)>);

impl Claims {
    /// # Errors
    /// The first line that claims nothing that can be checked.
    pub(super) fn read(text: &str) -> Result<Self> {
        let mut claims = BTreeMap::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let place = || format!("{FILE}, line {number}");
            let (name, claim) = parse(line).with_context(place)?;
            let before = claims.insert(name.clone(), claim);
            ensure!(before.is_none(), "{}: {name} was there before; a line for each order", place());
        }
        Ok(Self(claims))
    }

    /// A method for each order, of the layout that it claims, if any.
    ///
    /// # Errors
    /// Names that are taken, claims of orders that are not there, keys that no such claim can have.
    pub(super) fn methods(
        &self,
        orders: &[ForeignOrder],
        setup: &Setup,
        options: &RecordOptions,
    ) -> Result<Vec<MethodPlan>> {
        let names: BTreeSet<&str> = orders.iter().map(|order| order.name.as_str()).collect();
        if let Some(unknown) = self.0.keys().find(|name| !names.contains(name.as_str())) {
            let there = names.iter().copied().collect::<Vec<_>>().join(", ");
            let there = if there.is_empty() { "none" } else { &there };
            bail!("{FILE} speaks of an order '{unknown}'; those with a permutation.npy are: {there}");
        }
        let method = |&name: &&str| {
            let is_ours = WITHOUT_LAYOUT.contains(&name) || BUILTIN.iter().any(|(ours, ..)| *ours == name);
            let is_asked_for = options.orders.methods.iter().any(|method| method.name == name);
            ensure!(
                !is_ours && !is_asked_for,
                "the order '{name}' has the name of a method of ours; rename its folders, for example to 'their-{name}'"
            );
            let orders: Vec<&ForeignOrder> = orders.iter().filter(|order| order.name == name).collect();
            match self.0.get(name) {
                Some((method, bits)) => claimed(method, *bits, &orders, setup, options),
                None => unclaimed(name, &orders, options),
            }
        };
        names.iter().map(method).collect()
    }
}

fn parse(line: &str) -> Result<(String, (Method, u32))> {
    let parts = line.split_once('=').and_then(|(name, claim)| Some((name.trim(), claim.rsplit_once('@')?)));
    let Some((name, (layout, bits))) = parts else {
        bail!(
            "found '{}', expected NAME = LAYOUT @ BITS, such as mine = (ox oy oz)*10 @ 32",
            one_line(line, SHOWN)
        );
    };
    let (layout, bits) = (layout.trim(), bits.trim());
    let bits = bits.parse().ok().filter(|bits| (KEY_BITS_MIN..=LAYOUT_BITS).contains(bits));
    let bits = bits.with_context(|| format!("a key has {KEY_BITS_MIN} to {LAYOUT_BITS} bits"))?;
    let method = match Method::builtin(layout) {
        Ok(method) => Method { name: name.to_owned(), ..method },
        Err(_) => Method::from_user(&format!("{name}={layout}"))?,
    };
    ensure!(
        matches!(method.termination, Termination::Unused | Termination::Fixed),
        "the keys of {layout} depend on lengths that only this program knows; claim a layout without them"
    );
    Ok((name.to_owned(), (method, bits)))
}

/// An order whose keys are of a layout.
fn claimed(
    method: &Method,
    key_bits: u32,
    orders: &[&ForeignOrder],
    setup: &Setup,
    options: &RecordOptions,
) -> Result<MethodPlan> {
    for ForeignOrder { name, queue, keys, .. } in orders {
        let Some(keys) = keys else {
            bail!("{FILE} says what the keys of {name} are, but there is no keys.npy of it in {queue}");
        };
        let expected = if key_bits <= 32 { 32 } else { 64 };
        ensure!(
            keys.stored_bits() == expected,
            "{FILE} says that the keys of {name} have {key_bits} bits, which are stored in <u{}, but those in {queue} are <u{}",
            expected / 8,
            keys.stored_bits() / 8
        );
        ensure!(
            method.applies_to(queue.kind),
            "{FILE} says that the keys of {name} are made from lights, which the rays of {queue} have not"
        );
    }
    Ok(MethodPlan::new(method, setup.extent(), key_bits, options.two_point_length)?)
}

/// An order of whose keys nothing is said.
fn unclaimed(name: &str, orders: &[&ForeignOrder], options: &RecordOptions) -> Result<MethodPlan> {
    let mut bits = orders.iter().filter_map(|order| Some(order.keys.as_ref()?.stored_bits()));
    let key_bits = bits.next().unwrap_or(u32::BITS);
    ensure!(
        bits.all(|other| other == key_bits),
        "the keys of {name} are <u4 in some queues and <u8 in others; write them alike"
    );
    Ok(MethodPlan {
        name: name.to_owned(),
        base: name.to_owned(),
        text: String::new(),
        layout: Layout::default(),
        termination: Termination::Unused,
        key_bits,
        two_point_length: options.two_point_length,
        for_kinds: [true; 2],
    })
}
