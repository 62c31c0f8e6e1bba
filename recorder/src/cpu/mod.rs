//! The backend on native threads.

use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use formats::key::{Encoder, Layout};
use formats::length_table::{LengthCell, LengthTable};
use formats::manifest::QueueId;
use formats::ray::{Hit, Kind, Ray};
use glam::Vec3;

use crate::backend::{Backend, Queue, RecordedRays, Setup, Shaded, Sink, Table};
use crate::stages::key::Keys;
use crate::stages::key::cpu::{Lengths, encode};
use crate::stages::shade::cpu::{Compacted, Paths};
use crate::stages::shade::path::ShadowState;
use crate::stages::shared::PathState;
use crate::stages::trace::cpu::{CpuTracer, ScatteredDistances, ScatteredHits};
use crate::stages::{accumulate, gather, generate, shade, sort};

/// Bytes that are handed to a sink at once.
const SINK_BYTES: usize = 4 << 20;

/// Runs every stage on the threads of the current rayon pool.
pub struct CpuBackend {
    setup: Arc<Setup>,
    tracer: Arc<CpuTracer>,
    encoders: Vec<Encoder>,
    cells: Encoder,
    tables: [LengthTable; 2],
    scratch_tables: [LengthTable; 2],
    film: Vec<Vec3>,
    elapsed_ns: u64,
}

/// A queue on the CPU.
#[derive(Debug)]
pub enum CpuRays {
    /// Closest rays.
    Closest(QueueId, Compacted<PathState>),
    /// Shadow rays.
    Shadow(QueueId, Compacted<ShadowState>),
}

/// Results of a queue in canonical order.
#[derive(Debug)]
pub enum CpuHits {
    /// Of closest rays.
    Closest(Vec<Hit>),
    /// Distances to the occluders of shadow rays, `+inf` for none.
    Shadow(Vec<f32>),
}

/// Results that were written from another order.
#[derive(Debug)]
pub enum CpuScattered {
    /// Of closest rays.
    Closest(ScatteredHits),
    /// Of shadow rays.
    Shadow(ScatteredDistances),
}

/// Rays copied into another order.
#[derive(Debug)]
pub struct CpuGathered {
    kind: Kind,
    rays: Vec<Ray>,
}

impl CpuRays {
    fn rays(&self) -> &[Ray] {
        match self {
            Self::Closest(_, queue) => &queue.rays,
            Self::Shadow(_, queue) => &queue.rays,
        }
    }

    fn path_ids(&self) -> &[u32] {
        match self {
            Self::Closest(_, queue) => &queue.path_ids,
            Self::Shadow(_, queue) => &queue.path_ids,
        }
    }

    fn light(&self, index: usize) -> u32 {
        match self {
            Self::Closest(..) => 0,
            Self::Shadow(_, queue) => queue.states[index].light,
        }
    }
}

impl Queue for CpuRays {
    fn len(&self) -> usize {
        self.rays().len()
    }

    fn id(&self) -> QueueId {
        match self {
            Self::Closest(id, _) | Self::Shadow(id, _) => *id,
        }
    }
}

impl CpuBackend {
    /// A backend for one run.
    pub fn new(setup: Arc<Setup>, tracer: Arc<CpuTracer>) -> Self {
        let encoder = |layout, bits| Encoder::new(layout, bits, setup.unit, &setup.light_sites);
        let encoders = setup.methods.iter().map(|method| encoder(&method.layout, method.key_bits)).collect();
        let cells = encoder(&setup.table_layout, setup.table_bits);
        let tables = || [LengthTable::new(setup.table_bits), LengthTable::new(setup.table_bits)];
        Self {
            tables: tables(),
            scratch_tables: tables(),
            encoders,
            cells,
            tracer,
            film: vec![Vec3::ZERO; setup.width as usize * setup.height as usize],
            elapsed_ns: 0,
            setup,
        }
    }

    fn traced_length(&self, rays: &CpuRays, hits: &CpuHits, index: usize) -> f32 {
        let ray = &rays.rays()[index];
        match hits {
            CpuHits::Closest(hits) => self.setup.unit.closest_length(ray, &hits[index]),
            CpuHits::Shadow(distances) => self.setup.unit.shadow_length(ray, distances[index]),
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
    type Hits = CpuHits;
    type Scattered = CpuScattered;
    type Keys = KeysOfWidth;
    type Order = Vec<u32>;
    type Gathered = CpuGathered;

    fn elapsed_ns(&self) -> u64 {
        self.elapsed_ns
    }

    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<CpuRays> {
        let RecordedRays { id, rays, path_ids, lights, lengths } = queue;
        if let Some(cells) = lengths {
            self.tables[id.kind as usize] = LengthTable::from_touched(self.setup.table_bits, cells)?;
        }
        let (rays, path_ids, count) = (rays.to_vec(), path_ids.to_vec(), rays.len());
        Ok(match id.kind {
            Kind::Closest => {
                let states = vec![PathState { color: [0.0; 3], density: 0.0 }; count];
                CpuRays::Closest(id, Compacted { rays, path_ids, states })
            }
            Kind::Shadow => {
                let states = lights.iter().map(|&light| ShadowState { color: [0.0; 3], light }).collect();
                CpuRays::Shadow(id, Compacted { rays, path_ids, states })
            }
        })
    }

    fn address_tables(&mut self, bits: u32, layout: &Layout) -> Result<()> {
        let setup = Arc::make_mut(&mut self.setup);
        setup.table_bits = bits;
        setup.table_layout = layout.clone();
        self.cells = Encoder::new(layout, bits, setup.unit, &setup.light_sites);
        let tables = || [LengthTable::new(bits), LengthTable::new(bits)];
        (self.tables, self.scratch_tables) = (tables(), tables());
        Ok(())
    }

    fn generate(&mut self, pass: u32) -> Result<CpuRays> {
        let params = generate::params(&self.setup, pass);
        let rays = self.timed(|_| generate::cpu::generate(&params));
        let count = rays.len();
        let queue = Compacted {
            rays,
            path_ids: (0..count as u32).collect(),
            states: vec![PathState { color: [1.0; 3], density: 0.0 }; count],
        };
        Ok(CpuRays::Closest(QueueId { pass, bounce: 0, kind: Kind::Closest }, queue))
    }

    fn trace(&mut self, rays: &CpuRays) -> Result<CpuHits> {
        Ok(match rays {
            CpuRays::Closest(_, queue) => {
                let mut hits = vec![Hit::MISS; queue.rays.len()];
                self.timed(|backend| backend.tracer.closest(&queue.rays, &mut hits));
                CpuHits::Closest(hits)
            }
            CpuRays::Shadow(_, queue) => {
                let mut distances = vec![f32::INFINITY; queue.rays.len()];
                self.timed(|backend| backend.tracer.occlusion(&queue.rays, &mut distances));
                CpuHits::Shadow(distances)
            }
        })
    }

    fn accumulate(&mut self, rays: &CpuRays, hits: &CpuHits, table: Table) -> Result<()> {
        self.timed(|backend| {
            let tables = match table {
                Table::Learnt => &backend.tables,
                Table::Scratch => &backend.scratch_tables,
            };
            accumulate::on_threads(&tables[rays.id().kind as usize], &backend.cells, rays.rays(), |index| {
                backend.traced_length(rays, hits, index)
            });
        });
        Ok(())
    }

    fn shade(&mut self, rays: &CpuRays, hits: &CpuHits) -> Result<Shaded<CpuRays>> {
        let (CpuRays::Closest(id, queue), CpuHits::Closest(hits)) = (rays, hits) else {
            anyhow::bail!("only closest rays are shaded");
        };
        let params = shade::params(&self.setup, *id);
        let paths = Paths { rays: &queue.rays, hits, path_ids: &queue.path_ids, states: &queue.states };
        let (next, shadow) = self.timed(|Self { setup, film, .. }| {
            shade::cpu::shade(&setup.tables, &setup.features, &params, paths, film)
        });
        Ok(Shaded {
            next: CpuRays::Closest(QueueId { bounce: id.bounce + 1, ..*id }, next),
            shadow: CpuRays::Shadow(QueueId { kind: Kind::Shadow, ..*id }, shadow),
        })
    }

    fn add_light(&mut self, rays: &CpuRays, hits: &CpuHits) -> Result<()> {
        let (CpuRays::Shadow(_, queue), CpuHits::Shadow(distances)) = (rays, hits) else {
            anyhow::bail!("only shadow rays bring light");
        };
        self.timed(|backend| {
            shade::cpu::add_light(&queue.path_ids, &queue.states, distances, &mut backend.film);
        });
        Ok(())
    }

    fn key(&mut self, rays: &CpuRays, hits: &CpuHits, method: usize) -> Result<KeysOfWidth> {
        Ok(self.timed(|backend| {
            let plan = &backend.setup.methods[method];
            let real = |index: usize| backend.traced_length(rays, hits, index);
            let table = &backend.tables[rays.id().kind as usize];
            let lengths = Lengths::of(plan.termination, plan.two_point_length, table, &backend.cells, &real);
            let encoder = &backend.encoders[method];
            let keys = encode(encoder, plan.key_bits, rays.rays(), &lengths, |index| rays.light(index));
            KeysOfWidth { keys, bits: plan.key_bits }
        }))
    }

    fn sort(&mut self, keys: &KeysOfWidth) -> Result<Vec<u32>> {
        Ok(self.timed(|_| match &keys.keys {
            Keys::Narrow(narrow) => sort::cpu::sort_u32(narrow, keys.bits),
            Keys::Wide(wide) => sort::cpu::sort_u64(wide, keys.bits),
        }))
    }

    fn gather(&mut self, rays: &CpuRays, order: &Vec<u32>) -> Result<CpuGathered> {
        let kind = rays.id().kind;
        Ok(self.timed(|_| CpuGathered { kind, rays: gather::on_threads(rays.rays(), order) }))
    }

    fn trace_gathered(&mut self, gathered: &CpuGathered, order: &Vec<u32>) -> Result<CpuScattered> {
        let (rays, count) = (&gathered.rays, order.len());
        Ok(match gathered.kind {
            Kind::Closest => {
                let hits = ScatteredHits::new(count);
                self.timed(|backend| backend.tracer.closest_gathered(rays, order, &hits));
                CpuScattered::Closest(hits)
            }
            Kind::Shadow => {
                let distances = ScatteredDistances::new(count);
                self.timed(|backend| backend.tracer.occlusion_gathered(rays, order, &distances));
                CpuScattered::Shadow(distances)
            }
        })
    }

    fn trace_indirect(&mut self, rays: &CpuRays, order: &Vec<u32>) -> Result<CpuScattered> {
        let (kind, rays, count) = (rays.id().kind, rays.rays(), order.len());
        Ok(match kind {
            Kind::Closest => {
                let hits = ScatteredHits::new(count);
                self.timed(|backend| backend.tracer.closest_indirect(rays, order, &hits));
                CpuScattered::Closest(hits)
            }
            Kind::Shadow => {
                let distances = ScatteredDistances::new(count);
                self.timed(|backend| backend.tracer.occlusion_indirect(rays, order, &distances));
                CpuScattered::Shadow(distances)
            }
        })
    }

    fn differences(&mut self, _rays: &CpuRays, hits: &CpuHits, other: &CpuScattered) -> Result<u64> {
        match (hits, other) {
            (CpuHits::Closest(hits), CpuScattered::Closest(other)) => Ok(other.differences(hits)),
            (CpuHits::Shadow(distances), CpuScattered::Shadow(other)) => Ok(other.differences(distances)),
            _ => anyhow::bail!("results of different kinds were compared"),
        }
    }

    fn read_rays(&mut self, rays: &CpuRays, sink: &mut Sink<'_>) -> Result<()> {
        in_pieces(bytemuck::cast_slice(rays.rays()), sink)
    }

    fn read_path_ids(&mut self, rays: &CpuRays, sink: &mut Sink<'_>) -> Result<()> {
        in_pieces(bytemuck::cast_slice(rays.path_ids()), sink)
    }

    fn read_lights(&mut self, rays: &CpuRays, sink: &mut Sink<'_>) -> Result<()> {
        let CpuRays::Shadow(_, queue) = rays else {
            anyhow::bail!("only shadow rays have lights");
        };
        for states in queue.states.chunks(SINK_BYTES / 4) {
            let lights: Vec<u32> = states.iter().map(|state| state.light).collect();
            sink(bytemuck::cast_slice(&lights))?;
        }
        Ok(())
    }

    fn read_hits(&mut self, hits: &CpuHits, sink: &mut Sink<'_>) -> Result<()> {
        match hits {
            CpuHits::Closest(hits) => in_pieces(bytemuck::cast_slice(hits), sink),
            CpuHits::Shadow(distances) => in_pieces(bytemuck::cast_slice(distances), sink),
        }
    }

    fn read_work(&mut self, rays: &CpuRays, sink: &mut Sink<'_>) -> Result<()> {
        in_pieces(bytemuck::cast_slice(&self.tracer.work(rays.rays(), rays.id().kind)), sink)
    }

    fn read_keys(&mut self, keys: &KeysOfWidth, sink: &mut Sink<'_>) -> Result<()> {
        match &keys.keys {
            Keys::Narrow(keys) => in_pieces(bytemuck::cast_slice(keys), sink),
            Keys::Wide(keys) => in_pieces(bytemuck::cast_slice(keys), sink),
        }
    }

    fn read_order(&mut self, order: &Vec<u32>, sink: &mut Sink<'_>) -> Result<()> {
        in_pieces(bytemuck::cast_slice(order), sink)
    }

    fn touched_cells(&mut self, kind: Kind) -> Result<Vec<LengthCell>> {
        Ok(self.tables[kind as usize].touched())
    }

    fn image(&mut self, passes: u32) -> Result<Vec<[f32; 3]>> {
        Ok(self.film.iter().map(|pixel| (*pixel * (1.0 / passes as f32)).to_array()).collect())
    }
}

/// Keys and how many bits of them count.
#[derive(Debug)]
pub struct KeysOfWidth {
    keys: Keys,
    bits: u32,
}

fn in_pieces(bytes: &[u8], sink: &mut Sink<'_>) -> Result<()> {
    bytes.chunks(SINK_BYTES).try_for_each(sink)
}
