//! The backend on native threads.

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, ensure};
use formats::key::Encoder;
use formats::length_table::LengthTable;
use formats::manifest::QueueId;
use formats::ray::{Kind, Ray};
use glam::Vec3;

use crate::backends::{Array, Backend, Queue, RecordedRays, Shaded, Sink, Table};
use crate::stages::compact::cpu::{Paths, RayState};
use crate::stages::key::cpu::{Lengths, encode};
use crate::stages::setup::Setup;
use crate::stages::sort::cpu::{Keys, Sorter, Words};
use crate::stages::trace::Order;
use crate::stages::trace::cpu::CpuTracer;
use crate::stages::trace::hits::Hits;
use crate::stages::{accumulate, compare, gather, generate, shade};

/// Bytes that are handed to a sink at once.
const SINK_BYTES: usize = 4 << 20;
/// Items that are, where they are copied for it.
const SINK_ITEMS: usize = 1 << 18;

/// Runs every stage on the threads of the current rayon pool.
pub struct CpuBackend {
    setup: Arc<Setup>,
    tracer: Arc<CpuTracer>,
    encoders: Vec<Encoder>,
    cells: Encoder,
    /// By [`Table`] and kind.
    tables: [[LengthTable; 2]; 2],
    film: Vec<Vec3>,
    elapsed_ns: u64,
}

/// A queue on the CPU.
#[derive(Debug)]
pub struct CpuRays {
    id: QueueId,
    /// Without indices and states where rays were gathered.
    paths: Paths,
}

impl CpuRays {
    fn rays(&self) -> &[Ray] {
        &self.paths.rays
    }
}

impl Queue for CpuRays {
    fn id(&self) -> QueueId {
        self.id
    }

    fn len(&self) -> usize {
        self.rays().len()
    }
}

impl CpuBackend {
    /// A backend for one run.
    pub fn new(setup: Arc<Setup>, tracer: Arc<CpuTracer>) -> Self {
        let encoder = |layout, bits| Encoder::new(layout, bits, setup.unit, &setup.light_sites);
        let tables = || [LengthTable::new(setup.table_bits), LengthTable::new(setup.table_bits)];
        Self {
            encoders: setup.methods.iter().map(|method| encoder(&method.layout, method.key_bits)).collect(),
            cells: encoder(&setup.table_layout, setup.table_bits),
            tables: [tables(), tables()],
            film: vec![Vec3::ZERO; setup.width as usize * setup.height as usize],
            elapsed_ns: 0,
            tracer,
            setup,
        }
    }

    /// Runs a stage and remembers how long it took.
    fn timed<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let start = Instant::now();
        let value = work(self);
        self.elapsed_ns = start.elapsed().as_nanos() as u64;
        value
    }
}

impl Backend for CpuBackend {
    type Rays = CpuRays;
    type Hits = Hits;
    type Keys = Keys;
    type Permutation = Vec<u32>;

    fn elapsed_ns(&self) -> u64 {
        self.elapsed_ns
    }

    fn generate(&mut self, pass: u32) -> Result<CpuRays> {
        let params = generate::params(&self.setup, pass);
        let rays = self.timed(|_| generate::cpu::generate(&params));
        let ids = (0..rays.len() as u32).collect();
        let states = vec![RayState { color: [1.0; 3], ..RayState::default() }; rays.len()];
        let id = QueueId { pass, bounce: 0, kind: Kind::Closest };
        Ok(CpuRays { id, paths: Paths { rays, ids, states } })
    }

    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<CpuRays> {
        queue.check(&self.setup)?;
        let RecordedRays { id, rays, path_ids, lights, lengths } = queue;
        if let Some(cells) = lengths {
            let table = LengthTable::from_touched(self.setup.table_bits, cells)?;
            self.tables[Table::Learnt as usize][id.kind as usize] = table;
        }
        let mut states = vec![RayState::default(); rays.len()];
        states.iter_mut().zip(lights).for_each(|(state, &light)| state.light = light);
        Ok(CpuRays { id, paths: Paths { rays: rays.to_vec(), ids: path_ids.to_vec(), states } })
    }

    fn trace(&mut self, rays: &CpuRays, order: Order<&Vec<u32>>) -> Result<Hits> {
        let hits = Hits::new(rays.id.kind, rays.len());
        self.timed(|backend| backend.tracer.trace(rays.rays(), order.map(Vec::as_slice), &hits));
        Ok(hits)
    }

    fn accumulate(&mut self, rays: &CpuRays, hits: &Hits, table: Table) -> Result<()> {
        self.timed(|Self { setup, cells, tables, .. }| {
            let table = &tables[table as usize][rays.id.kind as usize];
            let length = |index: usize| hits.length(&setup.unit, &rays.rays()[index], index);
            accumulate::cpu::accumulate(table, cells, rays.rays(), length);
        });
        Ok(())
    }

    fn shade(&mut self, rays: &CpuRays, hits: &Hits) -> Result<Shaded<CpuRays>> {
        let id = rays.id;
        ensure!(id.kind == Kind::Closest, "{id} was to be shaded, which only closest rays are");
        let params = shade::params(&self.setup, id);
        let [next, shadow] = self.timed(|Self { setup, film, .. }| {
            shade::cpu::shade(&setup.tables, &setup.features, &params, (&rays.paths, hits), film)
        });
        Ok(Shaded {
            next: CpuRays { id: QueueId { bounce: id.bounce + 1, ..id }, paths: next },
            shadow: CpuRays { id: QueueId { kind: Kind::Shadow, ..id }, paths: shadow },
        })
    }

    fn add_light(&mut self, rays: &CpuRays, hits: &Hits) -> Result<()> {
        self.timed(|backend| shade::cpu::add_light(&rays.paths, hits, &mut backend.film));
        Ok(())
    }

    fn key(&mut self, rays: &CpuRays, hits: &Hits, method: usize) -> Result<Keys> {
        Ok(self.timed(|Self { setup, cells, tables, encoders, .. }| {
            let plan = &setup.methods[method];
            let real = |index: usize| hits.length(&setup.unit, &rays.rays()[index], index);
            let table = &tables[Table::Learnt as usize][rays.id.kind as usize];
            let lengths = Lengths::of(plan.termination, plan.two_point_length, table, cells, &real);
            // States are not touched where they say nothing.
            let light = |index: usize| match rays.id.kind {
                Kind::Closest => 0,
                Kind::Shadow => rays.paths.states[index].light,
            };
            encode(&encoders[method], plan.key_bits, rays.rays(), &lengths, light)
        }))
    }

    fn sort(&mut self, keys: &Keys) -> Result<Vec<u32>> {
        Ok(self.timed(|_| Sorter::default().sort(keys)))
    }

    fn gather(&mut self, rays: &CpuRays, permutation: &Vec<u32>) -> Result<CpuRays> {
        let gathered = self.timed(|_| gather::cpu::gather(rays.rays(), permutation));
        Ok(CpuRays { id: rays.id, paths: Paths { rays: gathered, ..Paths::default() } })
    }

    fn differences(&mut self, hits: &Hits, others: &Hits) -> Result<u64> {
        Ok(compare::cpu::differences(hits, others))
    }

    fn read(&mut self, array: Array<'_, Self>, sink: &mut Sink<'_>) -> Result<()> {
        let mut whole = |bytes: &[u8]| bytes.chunks(SINK_BYTES).try_for_each(&mut *sink);
        match array {
            Array::Rays(rays) => whole(bytemuck::cast_slice(rays.rays())),
            Array::PathIds(rays) => whole(bytemuck::cast_slice(&rays.paths.ids)),
            Array::Lights(rays) => rays.paths.states.chunks(SINK_ITEMS).try_for_each(|states| {
                let lights: Vec<u32> = states.iter().map(|state| state.light).collect();
                sink(bytemuck::cast_slice(&lights))
            }),
            Array::Work(rays) => whole(bytemuck::cast_slice(&self.tracer.work(rays.rays(), rays.id.kind))),
            Array::Hits(hits) => (0..hits.len())
                .step_by(SINK_ITEMS)
                .try_for_each(|first| sink(&hits.bytes(first..hits.len().min(first + SINK_ITEMS)))),
            Array::Keys(Keys { words: Words::Narrow(words), .. }) => whole(bytemuck::cast_slice(words)),
            Array::Keys(Keys { words: Words::Wide(words), .. }) => whole(bytemuck::cast_slice(words)),
            Array::Permutation(permutation) => whole(bytemuck::cast_slice(permutation)),
            Array::Lengths(kind) => {
                let cells = self.tables[Table::Learnt as usize][kind as usize].touched();
                whole(bytemuck::cast_slice(&cells))
            }
            Array::Film => self.film.chunks(SINK_ITEMS).try_for_each(|pixels| {
                let pixels: Vec<[f32; 3]> = pixels.iter().map(Vec3::to_array).collect();
                sink(bytemuck::cast_slice(&pixels))
            }),
        }
    }
}
