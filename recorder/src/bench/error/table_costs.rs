//! What length tables cost on the device: keys without one, and with tables of every size and address.

use std::sync::Arc;

use anyhow::Result;
use formats::key::{Encoder, Layout};
use formats::ray::Kind;

use super::super::backends::OnBackend;
use super::super::queues::Copied;
use super::Bench;
use crate::backends::{Backend, Table};
use crate::measure::sampled;
use crate::stages::setup::Setup;
use crate::stages::trace::Order;

/// Address bits of the tables.
pub(super) const TABLE_BITS: [u32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];
/// Name of the estimate that `two-point` makes.
pub(super) const CONSTANT: &str = "constant";
/// Methods of the run, by number.
const ADAPTIVE: usize = 0;
pub(super) const FIXED: usize = 1;

/// A way to address tables.
pub(super) struct Address {
    pub(super) name: &'static str,
    pub(super) layout: Layout,
    pub(super) encoder: Encoder,
}

/// What a table costs on the device.
pub(super) struct Cost {
    pub(super) kind: Kind,
    pub(super) method: &'static str,
    pub(super) bits: u32,
    pub(super) rays: u64,
    pub(super) accumulate_ns: Vec<u64>,
    pub(super) key_ns: Vec<u64>,
}

/// What keys cost without a table, and with tables of every size and address: each on a backend of its own.
pub(super) fn costs(
    bench: Bench<'_>,
    setup: &Arc<Setup>,
    addresses: &[Address],
    queues: &[Copied],
) -> Result<Vec<Cost>> {
    let repeats = bench.options.run.repeats;
    let fixed = Timing { queues, repeats, method: FIXED, name: CONSTANT, bits: 0 };
    let mut costs = bench.measure(setup, fixed)?;
    for Address { name, layout, .. } in addresses {
        for bits in TABLE_BITS {
            let addressed = Setup { table_bits: bits, table_layout: layout.clone(), ..Setup::clone(setup) };
            let timing = Timing { queues, repeats, method: ADAPTIVE, name, bits };
            costs.extend(bench.measure(&Arc::new(addressed), timing)?);
        }
    }
    Ok(costs)
}

/// Makes keys of queues by one method, and adds them to the table that it reads, if it does.
struct Timing<'a> {
    queues: &'a [Copied],
    repeats: u32,
    method: usize,
    /// Of the table.
    name: &'static str,
    bits: u32,
}

impl OnBackend for Timing<'_> {
    type Output = Vec<Cost>;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Vec<Cost>> {
        let mut costs = Vec::new();
        for queue in self.queues {
            let rays = backend.upload(queue.queue(None))?;
            let hits = backend.trace(&rays, Order::Stored)?;
            let rounds = sampled(1, self.repeats, 0, |_| {
                let mut accumulate_ns = None;
                if self.method == ADAPTIVE {
                    backend.accumulate(&rays, &hits, Table::Scratch)?;
                    accumulate_ns = Some(backend.elapsed_ns());
                }
                backend.key(&rays, Some(&hits), self.method)?;
                Ok((accumulate_ns, backend.elapsed_ns()))
            })?;
            let (accumulate_ns, key_ns): (Vec<_>, Vec<u64>) = rounds.into_iter().flatten().unzip();
            costs.push(Cost {
                kind: queue.id.kind,
                method: self.name,
                bits: self.bits,
                rays: queue.rays.len() as u64,
                accumulate_ns: accumulate_ns.into_iter().flatten().collect(),
                key_ns,
            });
        }
        Ok(costs)
    }
}
