//! The backend on native threads.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Result, ensure};
use formats::auto::sample;
use formats::key::{Encoder, Facts, Termination};
use formats::length_table::LengthTable;
use formats::manifest::QueueId;
use formats::metrics::lanes::LaneUse;
use formats::pages::make_room;
use formats::permutation::check_bijection;
use formats::ray::{Kind, Ray};

use super::pool::Pool;
use super::{gathered, untraced};
use crate::backends::{Array, Backend, Queue, RecordedRays, Shaded, Sink, Table};
use crate::clock::{Clock, Sample};
use crate::stages::accumulate::cpu::Accumulator;
use crate::stages::compact::cpu::Paths;
use crate::stages::key::cpu::{Lengths, encode};
use crate::stages::setup::Setup;
use crate::stages::shade::cpu::{Film, Shader, add_light, dark_film, light_of};
use crate::stages::shared::PathState;
use crate::stages::sort::cpu::{Keys, Permutation, Sorter, permutation_of};
use crate::stages::trace::Order;
use crate::stages::trace::cpu::CpuTracer;
use crate::stages::trace::cpu_strangers::Strangers;
use crate::stages::trace::hits::Hits;
use crate::stages::{compare, gather, generate, scatter, shade};

/// Bytes that are handed to a sink at once: so few that memory which they are copied to need not be new.
const SINK_BYTES: usize = 1 << 20;
/// Items that are, where they are copied for it.
const SINK_ITEMS: usize = 1 << 16;

/// Runs every stage on the threads of the current rayon pool.
pub struct CpuBackend {
    setup: Arc<Setup>,
    tracer: Arc<CpuTracer>,
    encoders: Vec<Encoder>,
    cells: Encoder,
    /// By [`Table`] and kind.
    tables: [[LengthTable; 2]; 2],
    film: Film,
    accumulator: Accumulator,
    sorter: Sorter,
    shader: Shader,
    /// By kind.
    paths: [Pool<Paths>; 2],
    /// Rays in another order, without what their paths carry.
    gathered: Pool<Paths>,
    /// By kind.
    hits: [Pool<Hits>; 2],
    /// Of up to 32 bits, and wider ones.
    keys: [Pool<Keys>; 2],
    permutations: Pool<Permutation>,
    strangers: Strangers,
    clock: Clock,
}

/// A queue on the CPU.
#[derive(Debug)]
pub struct CpuRays {
    id: QueueId,
    /// Without indices and states where rays were gathered.
    paths: Arc<Paths>,
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
            film: dark_film(setup.width as usize * setup.height as usize),
            accumulator: Accumulator::default(),
            sorter: Sorter::default(),
            shader: Shader::default(),
            paths: [Pool::default(), Pool::default()],
            gathered: Pool::default(),
            hits: [Pool::default(), Pool::default()],
            keys: [Pool::default(), Pool::default()],
            permutations: Pool::default(),
            strangers: Strangers::default(),
            clock: Clock::of_processor(),
            tracer,
            setup,
        }
    }
}

#[cfg(test)]
impl CpuBackend {
    /// One over the Cornell box.
    pub(crate) fn in_cornell(setup: Arc<Setup>) -> Self {
        let scene = scenes::load("builtin:cornell").unwrap();
        let bvh = scenes::bvh::build(&scene, scenes::bvh::BvhKind::Bvh2).unwrap();
        Self::new(setup, Arc::new(CpuTracer::new(&scene, &bvh)))
    }

    /// A queue of shadow rays to the first light, of bounce 1.
    pub(crate) fn shadow_queue(&mut self, pass: u32, rays: &[Ray]) -> CpuRays {
        let (path_ids, lights): (Vec<u32>, Vec<u32>) = (0..rays.len() as u32).map(|at| (at, 0)).unzip();
        let id = QueueId { pass, bounce: 1, kind: Kind::Shadow };
        self.upload(RecordedRays { id, rays, path_ids: &path_ids, lights: &lights, lengths: None }).unwrap()
    }
}

impl Backend for CpuBackend {
    type Rays = CpuRays;
    type Hits = Arc<Hits>;
    type Keys = Arc<Keys>;
    type Permutation = Arc<Permutation>;

    fn sample(&self) -> Sample {
        self.clock.last()
    }

    fn restart(&mut self) -> Result<()> {
        self.film.iter_mut().flatten().for_each(|channel| *channel.get_mut() = 0);
        self.tables[Table::Learnt as usize].iter_mut().for_each(LengthTable::clear);
        Ok(())
    }

    fn generate(&mut self, pass: u32) -> Result<CpuRays> {
        let params = generate::params(&self.setup, pass);
        let (paths, ()) = self.paths[Kind::Closest as usize].filled(|paths| {
            paths.make_room(params.count as usize);
            paths.ids.iter_mut().zip(0..).for_each(|(id, pixel)| *id = pixel);
            paths.states.fill(PathState { color: [1.0; 3], ..PathState::default() });
            self.clock.time(|| generate::cpu::generate(&params, &mut paths.rays));
        });
        Ok(CpuRays { id: QueueId { pass, bounce: 0, kind: Kind::Closest }, paths })
    }

    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<CpuRays> {
        queue.check(&self.setup)?;
        let RecordedRays { id, rays, path_ids, lights, lengths } = queue;
        if let Some(cells) = lengths {
            let table = LengthTable::from_touched(self.setup.table_bits, cells)?;
            self.tables[Table::Learnt as usize][id.kind as usize] = table;
        }
        let (paths, ()) = self.paths[id.kind as usize].filled(|paths| {
            paths.make_room(rays.len());
            paths.rays.copy_from_slice(rays);
            paths.ids.copy_from_slice(path_ids);
            paths.lights.fill(0);
            paths.lights[..lights.len()].copy_from_slice(lights);
            paths.states.fill(PathState::default());
        });
        Ok(CpuRays { id, paths })
    }

    fn upload_permutation(&mut self, indices: &[u32]) -> Result<Arc<Permutation>> {
        check_bijection(indices, indices.len())?;
        Ok(Arc::new(permutation_of(indices)))
    }

    fn upload_keys(&mut self, keys: &[u64], bits: u32) -> Result<Arc<Keys>> {
        Ok(Arc::new(Keys::of(keys, bits)))
    }

    fn trace(&mut self, rays: &CpuRays, order: Order<&Arc<Permutation>>) -> Result<Arc<Hits>> {
        let kind = rays.id.kind;
        let (filled, ()) = self.hits[kind as usize].filled(|hits| {
            hits.make_room(kind, rays.len());
            let order = order.map(|permutation| permutation.as_slice());
            self.clock.time(|| self.tracer.trace(rays.rays(), order, hits));
        });
        Ok(filled)
    }

    fn forget(&mut self, rays: &CpuRays) -> Result<()> {
        self.strangers.trace(&self.tracer, rays.rays(), rays.id.kind);
        Ok(())
    }

    fn scatter(&mut self, hits: &Arc<Hits>, permutation: &Arc<Permutation>) -> Result<Arc<Hits>> {
        let kind = hits.kind();
        let (filled, ()) = self.hits[kind as usize].filled(|home| {
            home.make_room(kind, hits.len());
            self.clock.time(|| scatter::cpu::scatter(hits, permutation, home));
        });
        Ok(filled)
    }

    fn accumulate(&mut self, rays: &CpuRays, hits: &Arc<Hits>, table: Table) -> Result<()> {
        let Self { setup, accumulator, tables, cells, clock, .. } = self;
        let table = &mut tables[table as usize][rays.id.kind as usize];
        accumulator.make_room(rays.len());
        clock.time(|| accumulator.accumulate(table, cells, &setup.unit, (rays.rays(), hits)));
        Ok(())
    }

    fn shade(&mut self, rays: &CpuRays, hits: &Arc<Hits>) -> Result<Shaded<CpuRays>> {
        let id = rays.id;
        ensure!(id.kind == Kind::Closest, "{id} was to be shaded, which only closest rays are");
        let params = shade::params(&self.setup, id);
        let Self { setup, film, shader, clock, paths: [closest_paths, shadow_paths], .. } = self;
        let (shadow, (next, ())) = shadow_paths.filled(|shadow| {
            closest_paths.filled(|next| {
                shader.make_room(rays.len(), [next, shadow]);
                let live = clock.time(|| {
                    let queue = (&*rays.paths, &**hits);
                    shader.shade(&setup.tables, &params, queue, film, [next, shadow])
                });
                next.truncate(live[0]);
                shadow.truncate(live[1]);
            })
        });
        Ok(Shaded {
            next: CpuRays { id: QueueId { bounce: id.bounce + 1, ..id }, paths: next },
            shadow: CpuRays { id: QueueId { kind: Kind::Shadow, ..id }, paths: shadow },
        })
    }

    fn add_light(&mut self, rays: &CpuRays, hits: &Arc<Hits>) -> Result<()> {
        self.clock.time(|| add_light(&rays.paths, hits, &self.film));
        Ok(())
    }

    fn key(&mut self, rays: &CpuRays, hits: Option<&Arc<Hits>>, method: usize) -> Result<Arc<Keys>> {
        let Self { setup, cells, tables, encoders, clock, .. } = self;
        let plan = &setup.methods[method];
        ensure!(hits.is_some() || plan.termination != Termination::Real, untraced(rays.id, &plan.name));
        let real =
            |index: usize| hits.map_or(0.0, |hits| hits.length(&setup.unit, &rays.rays()[index], index));
        let table = &tables[Table::Learnt as usize][rays.id.kind as usize];
        let length = Lengths::of(plan.termination, plan.two_point_length, table, cells, &real);
        let light = |index: usize| rays.paths.lights[index];
        let facts = Facts { length, light, path: |index: usize| rays.paths.ids[index] };
        let (filled, ()) = self.keys[usize::from(plan.key_bits > 32)].filled(|keys| {
            keys.make_room(rays.len(), plan.key_bits);
            clock.time(|| encode(&encoders[method], rays.rays(), &facts, keys));
        });
        Ok(filled)
    }

    fn sort(&mut self, keys: &Arc<Keys>) -> Result<Arc<Permutation>> {
        let (filled, ()) = self.permutations.filled(|permutation| {
            self.sorter.make_room(keys, permutation);
            self.clock.time(|| self.sorter.sort(keys, permutation));
        });
        Ok(filled)
    }

    fn gather(&mut self, rays: &CpuRays, permutation: &Arc<Permutation>) -> Result<CpuRays> {
        let (paths, ()) = self.gathered.filled(|paths| {
            make_room(&mut paths.rays, rays.len());
            self.clock.time(|| gather::cpu::gather(rays.rays(), permutation, &mut paths.rays));
        });
        Ok(CpuRays { id: rays.id, paths })
    }

    fn reorder(&mut self, rays: &CpuRays, permutation: &Arc<Permutation>) -> Result<CpuRays> {
        let id = rays.id;
        ensure!(rays.paths.ids.len() == rays.len(), gathered(id));
        let (paths, ()) = self.paths[id.kind as usize].filled(|paths| {
            paths.make_room(rays.len());
            self.clock.time(|| gather::cpu::gather_paths(&rays.paths, permutation, paths));
        });
        Ok(CpuRays { id, paths })
    }

    fn differences(&mut self, hits: &Arc<Hits>, others: &Arc<Hits>) -> Result<u64> {
        Ok(compare::cpu::differences(hits, others))
    }

    fn read(&mut self, array: Array<'_, Self>, sink: &mut Sink<'_>) -> Result<()> {
        let mut whole = |bytes: &[u8]| bytes.chunks(SINK_BYTES).try_for_each(&mut *sink);
        match array {
            Array::Rays(rays) => whole(bytemuck::cast_slice(rays.rays())),
            Array::Sample(rays) => {
                let mut groups = sample(rays.len()).map(|range| &rays.rays()[range]);
                groups.try_for_each(|group| whole(bytemuck::cast_slice(group)))
            }
            Array::PathIds(rays) => whole(bytemuck::cast_slice(&rays.paths.ids)),
            Array::Lights(rays) => whole(bytemuck::cast_slice(&rays.paths.lights)),
            Array::Throughput(rays) => rays.paths.states.chunks(SINK_ITEMS).try_for_each(|states| {
                let carried: Vec<[f32; 3]> = states.iter().map(|state| state.color).collect();
                sink(bytemuck::cast_slice(&carried))
            }),
            Array::Work(rays) => whole(bytemuck::cast_slice(&self.tracer.work(rays.rays(), rays.id.kind))),
            Array::LaneUse(rays) => match self.tracer.lane_use(rays.rays(), rays.id.kind) {
                Some(LaneUse { width, work, capacity }) => {
                    whole(bytemuck::bytes_of(&[width as u64, work, capacity]))
                }
                None => Ok(()),
            },
            Array::Hits(hits) => (0..hits.len())
                .step_by(SINK_ITEMS)
                .try_for_each(|first| sink(&hits.bytes(first..hits.len().min(first + SINK_ITEMS)))),
            Array::Keys(keys) => whole(keys.words.bytes()),
            Array::Permutation(permutation) => permutation.chunks(SINK_ITEMS).try_for_each(|places| {
                let places: Vec<u32> = places.iter().map(|place| place.load(Relaxed)).collect();
                sink(bytemuck::cast_slice(&places))
            }),
            Array::Lengths(kind) => {
                let table = &self.tables[Table::Learnt as usize][kind as usize];
                let (mut cells, mut piece) = (table.touched_cells().peekable(), Vec::new());
                while cells.peek().is_some() {
                    piece.clear();
                    piece.extend(cells.by_ref().take(SINK_ITEMS));
                    sink(bytemuck::cast_slice(&piece))?;
                }
                Ok(())
            }
            Array::Film => self.film.chunks(SINK_ITEMS).try_for_each(|pixels| {
                let pixels: Vec<[f32; 3]> = pixels.iter().map(light_of).collect();
                sink(bytemuck::cast_slice(&pixels))
            }),
        }
    }
}
