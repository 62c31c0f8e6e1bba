//! The length table: what adding and asking cost, and how far its means are from traced lengths.
//!
//! Paths are traced once. Of every queue the traced lengths are kept, and of every ray the cell that each
//! method would address in the largest table; a smaller table's cell is a prefix of it. Errors then come
//! from tables that are filled in the order in which the path tracer would.

use anyhow::Result;
use formats::bench_result::error::EstimatorRow;
use formats::key::termination::bounded_length;
use formats::key::{Encoder, Facts, Method};
use formats::length_table::LengthTable;
use formats::manifest::QueueId;
use formats::metrics::estimator::EstimateError;
use formats::ray::{Kind, Ray};
use formats::unit_space::UnitSpace;
use rayon::prelude::*;

use super::super::backends::OnBackend;
use super::super::queues::{Copied, strata};
use super::Bench;
use super::table_costs::{Address, CONSTANT, Cost, FIXED, TABLE_BITS, costs};
use crate::backends::{Array, Backend, Queue, collected};
use crate::options::RecordOptions;
use crate::stages::trace::hits::Hits;
use crate::wavefront;

/// Methods whose keys can address a table: those that need no length and no light.
pub const TABLE_METHODS: [&str; 5] = ["origin", "reis", "costa", "aila", "octahedron"];
/// Bits of the cells that are kept; smaller tables take the top bits of them.
const MOST_BITS: u32 = TABLE_BITS[TABLE_BITS.len() - 1];
/// Passes of learning.
const PASSES: u32 = 8;
/// The queue on which costs are measured: rays that left the first surface, and their shadow rays.
const TIMED_BOUNCE: u32 = 1;

/// Measures all tables on all rays of a scene.
pub(super) fn run(bench: Bench<'_>) -> Result<Vec<EstimatorRow>> {
    let methods = ["two-point-adaptive", "two-point"].map(Method::builtin);
    let run = RecordOptions {
        orders: methods.into_iter().collect::<Result<Vec<_>, _>>()?.into(),
        ..bench.options.run.clone()
    };
    let setup = bench.setup(&run)?;
    let unit = bench.unit();
    let mut addresses = Vec::new();
    for name in TABLE_METHODS {
        let layout = Method::builtin(name)?.layout.expand(setup.extent())?;
        let encoder = Encoder::new(&layout, MOST_BITS, unit, &[]);
        addresses.push(Address { name, layout, encoder });
    }
    let Learnt { queues, timed } = bench.measure(&setup, Learning { bench, addresses: &addresses })?;
    let costs = costs(bench, &setup, &addresses, &timed)?;
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        let of_kind: Vec<&Lengths> = queues.iter().filter(|queue| queue.id.kind == kind).collect();
        rows.extend(constant_rows(bench, &of_kind, kind, setup.methods[FIXED].two_point_length));
        for (at, address) in addresses.iter().enumerate() {
            for bits in TABLE_BITS {
                rows.extend(table_rows(bench, &of_kind, kind, at, address.name, bits));
            }
        }
    }
    for row in rows.iter_mut().filter(|row| row.pass == PASSES) {
        let is_it = |cost: &&Cost| {
            (cost.kind, cost.method, cost.bits) == (row.kind, row.table_method.as_str(), row.table_bits)
        };
        if let Some(cost) = costs.iter().find(is_it) {
            row.rays_timed = cost.rays;
            row.accumulate_ns.clone_from(&cost.accumulate_ns);
            row.key_ns.clone_from(&cost.key_ns);
        }
    }
    Ok(rows)
}

/// What is kept of a queue.
struct Lengths {
    id: QueueId,
    /// Traced length of each ray, unit lengths.
    traced: Vec<f32>,
    /// Per method the cell of each ray in a table of [`MOST_BITS`].
    cells: Vec<Vec<u32>>,
    /// Rays whose errors are looked at, with the longest length that a key would take.
    looked_at: Vec<(u32, f32)>,
}

struct Learnt {
    queues: Vec<Lengths>,
    /// The queues on which costs are measured.
    timed: Vec<Copied>,
}

struct Learning<'a> {
    bench: Bench<'a>,
    addresses: &'a [Address],
}

impl OnBackend for Learning<'_> {
    type Output = Learnt;

    fn run<B: Backend>(self, backend: &mut B) -> Result<Learnt> {
        let (mut queues, mut timed) = (Vec::new(), Vec::new());
        let mut learn = |backend: &mut B, rays: &B::Rays, hits: &B::Hits| {
            let id = rays.id();
            if id.pass + 1 == PASSES && id.bounce == TIMED_BOUNCE {
                timed.push(Copied::of(backend, rays)?);
            }
            queues.push(self.lengths(backend, rays, hits)?);
            Ok(())
        };
        wavefront::run(backend, 0..PASSES, self.bench.options.run.bounces, &mut learn)?;
        Ok(Learnt { queues, timed })
    }
}

impl Learning<'_> {
    fn lengths<B: Backend>(&self, backend: &mut B, queue: &B::Rays, hits: &B::Hits) -> Result<Lengths> {
        let (id, unit) = (queue.id(), self.bench.unit());
        let rays: Vec<Ray> = collected(backend, Array::Rays(queue))?;
        let traced = traced_lengths(backend, id.kind, &unit, &rays, hits)?;
        let cells = |address: &Address| -> Vec<u32> {
            rays.par_iter().map(|ray| address.encoder.encode(ray, Facts::default()) as u32).collect()
        };
        let longest = |at: usize| {
            let ray = &rays[at];
            (at as u32, bounded_length(&unit, ray, unit.point(ray.origin), f32::INFINITY))
        };
        Ok(Lengths {
            id,
            cells: self.addresses.iter().map(cells).collect(),
            looked_at: strata(rays.len(), self.bench.options.rays).map(longest).collect(),
            traced,
        })
    }
}

/// Traced length of each ray of a queue, unit lengths.
pub(super) fn traced_lengths<B: Backend>(
    backend: &mut B,
    kind: Kind,
    unit: &UnitSpace,
    rays: &[Ray],
    hits: &B::Hits,
) -> Result<Vec<f32>> {
    let hits = Hits::from_bytes(kind, &collected(backend, Array::Hits(hits))?);
    Ok(rays.par_iter().enumerate().map(|(index, ray)| hits.length(unit, ray, index)).collect())
}

/// Whether the errors of a queue count: camera rays are not sorted.
fn is_looked_at(id: QueueId) -> bool {
    id.kind == Kind::Shadow || id.bounce > 0
}

/// Errors of every pass when the rays of a kind are estimated by `estimate` (queue and place of the ray) and
/// then `learn` sees the queue; second, the cells touched at the end of the pass.
fn errors_by_pass(
    queues: &[&Lengths],
    estimate: impl Fn(&Lengths, u32) -> f32 + Sync,
    learn: impl Fn(&Lengths),
    touched: impl Fn() -> u64,
) -> Vec<(u32, EstimateError, u64)> {
    let mut errors = Vec::new();
    for pass in 0..PASSES {
        let mut pairs = Vec::new();
        for queue in queues.iter().filter(|queue| queue.id.pass == pass) {
            if is_looked_at(queue.id) {
                let pair = |&(at, longest): &(u32, f32)| {
                    (estimate(queue, at).min(longest).max(0.0), queue.traced[at as usize])
                };
                pairs.par_extend(queue.looked_at.par_iter().map(pair));
            }
            learn(queue);
        }
        errors.extend(EstimateError::of(pairs).map(|error| (pass + 1, error, touched())));
    }
    errors
}

fn row(
    bench: Bench<'_>,
    kind: Kind,
    method: &str,
    bits: u32,
) -> impl Fn((u32, EstimateError, u64)) -> EstimatorRow {
    let (scene, table_method) = (bench.scene.name.clone(), method.to_owned());
    move |(pass, error, cells_touched)| EstimatorRow {
        scene: scene.clone(),
        kind,
        table_method: table_method.clone(),
        table_bits: bits,
        pass,
        cells_touched,
        error,
        rays_timed: 0,
        accumulate_ns: Vec::new(),
        key_ns: Vec::new(),
    }
}

fn constant_rows(bench: Bench<'_>, queues: &[&Lengths], kind: Kind, length: f32) -> Vec<EstimatorRow> {
    let errors = errors_by_pass(queues, |_, _| length, |_| (), || 0);
    errors.into_iter().map(row(bench, kind, CONSTANT, 0)).collect()
}

fn table_rows(
    bench: Bench<'_>,
    queues: &[&Lengths],
    kind: Kind,
    address: usize,
    method: &str,
    bits: u32,
) -> Vec<EstimatorRow> {
    let table = LengthTable::new(bits);
    let cell = |queue: &Lengths, at: usize| queue.cells[address][at] >> (MOST_BITS - bits);
    let learn = |queue: &Lengths| {
        let add = |(at, &length): (usize, &f32)| table.add(cell(queue, at), length);
        queue.traced.par_iter().enumerate().with_min_len(1 << 14).for_each(add);
    };
    let estimate = |queue: &Lengths, at: u32| table.mean(cell(queue, at as usize));
    let touched = || table.cells().filter(|&(_, count)| count > 1).count() as u64;
    errors_by_pass(queues, estimate, learn, touched).into_iter().map(row(bench, kind, method, bits)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of cells kept by hand, in double precision.
    #[test]
    fn estimates_come_from_what_was_learnt_before() {
        let cell = |at: usize, pass: usize| (at * 7 + pass) as u32 % 5;
        let length = |at: usize, pass: usize| ((at * 13 + pass * 5) % 32) as f32 / 32.0;
        let queue = |pass: usize| Lengths {
            id: QueueId { pass: pass as u32, bounce: 1, kind: Kind::Closest },
            traced: (0..100).map(|at| length(at, pass)).collect(),
            cells: vec![(0..100).map(|at| cell(at, pass)).collect()],
            looked_at: (0..100).map(|at| (at, 1.5)).collect(),
        };
        let queues: Vec<Lengths> = (0..PASSES as usize).map(queue).collect();
        let table = LengthTable::new(8);
        let estimate = |queue: &Lengths, at: u32| table.mean(queue.cells[0][at as usize]);
        let learn = |queue: &Lengths| {
            for (&cell, &length) in queue.cells[0].iter().zip(&queue.traced) {
                table.add(cell, length);
            }
        };
        let found = errors_by_pass(&queues.iter().collect::<Vec<_>>(), estimate, learn, || 5);
        let mut known = [(0.25f64, 1.0f64); 5];
        for (pass, (number, error, _)) in found.iter().enumerate() {
            assert_eq!(*number as usize, pass + 1);
            let mean = |at: usize| {
                let (sum, count) = known[cell(at, pass) as usize];
                sum / count
            };
            let errors = (0..100).map(|at| (mean(at) - f64::from(length(at, pass))).abs());
            let expected = errors.sum::<f64>() / 100.0;
            assert!((error.mean_absolute - expected).abs() < 1e-6, "pass {pass}: {error:?}, not {expected}");
            for at in 0..100 {
                let (sum, count) = &mut known[cell(at, pass) as usize];
                *sum += f64::from(length(at, pass));
                *count += 1.0;
            }
        }
        assert_eq!(found.len(), PASSES as usize);
    }
}
