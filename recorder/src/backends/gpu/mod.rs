//! The backend on a GPU.
//!
//! - [`kernels`]: every kernel of a run but those that trace and sort
//! - [`scene`]: a scene's arrays as shading reads them
//! - `shading`: the kernels of shading in turn, and the queues that they leave
//! - `table`: a length table

pub mod kernels;
pub mod scene;
mod shading;
mod table;

use std::iter::once;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use formats::auto::sample;
use formats::length_table::LengthTable;
use formats::manifest::QueueId;
use formats::permutation::check_bijection;
use formats::ray::Kind;
use scenes::Scene;
use scenes::bvh::Bvh;

use self::kernels::Kernels;
use self::shading::Shading;
use self::table::GpuTable;
use super::pool::{Lent, Pool};
use super::{gathered, untraced};
use crate::backends::{Array, Backend, Queue, RecordedRays, Shaded, Sink, Table};
use crate::clock::{Clock, Sample};
use crate::device::{DeviceArray, Gpu, GpuError, ITEMS, Readback};
use crate::stages::setup::Setup;
use crate::stages::shared::LightSiteData;
use crate::stages::sort::gpu::{Keys, Sorter};
use crate::stages::trace::gpu::{Hits, RayArrays, Tracer};
use crate::stages::trace::{Order, TraceKernel};
use crate::stages::{generate, key, shade};

/// Items that are read back at once where halves have to be joined: as much as a core's own cache holds.
const JOIN_ITEMS: usize = 1 << 16;

/// Runs every stage as a compute kernel.
pub struct GpuBackend {
    gpu: Gpu,
    setup: Arc<Setup>,
    kernels: Kernels,
    tracer: Tracer,
    sorter: Sorter,
    shading: Shading,
    light_sites: DeviceArray<LightSiteData>,
    film: DeviceArray<[f32; 4]>,
    tables: [GpuTable; 2],
    /// Made when they are first needed.
    scratch_tables: Option<[GpuTable; 2]>,
    /// What each table is when a picture begins; likewise.
    untouched: Option<GpuTable>,
    counter: DeviceArray<u32>,
    queues: Queues,
    /// By kind.
    hits: [Pool<Hits>; 2],
    keys: Pool<Keys>,
    permutations: Pool<DeviceArray<u32>>,
    readback: Readback,
    clock: Clock,
}

/// A queue on the GPU.
pub struct GpuRays {
    id: QueueId,
    count: usize,
    rays: Arc<RayArrays>,
    /// None where rays were gathered.
    paths: Option<Arc<PathArrays>>,
}

/// What the rays of a queue carry.
struct PathArrays {
    ids: DeviceArray<u32>,
    states: DeviceArray<[u32; 4]>,
}

/// A permutation.
pub struct GpuPermutation {
    permutation: Arc<DeviceArray<u32>>,
    count: usize,
}

impl Queue for GpuRays {
    fn id(&self) -> QueueId {
        self.id
    }

    fn len(&self) -> usize {
        self.count
    }
}

impl PathArrays {
    /// Room for so many.
    fn new(gpu: &Gpu, count: usize) -> Result<Self, GpuError> {
        Ok(Self { ids: gpu.array("queue::path_ids", count)?, states: gpu.array("queue::states", count)? })
    }
}

/// Room for queues, which is used again: drivers clear new memory while it is first used.
struct Queues {
    /// Rays that there is room for in each.
    pixels: usize,
    rays: Pool<RayArrays>,
    paths: Pool<PathArrays>,
}

impl Queues {
    /// Room for a queue.
    fn queue(&mut self, gpu: &Gpu, id: QueueId, count: usize) -> Result<GpuRays, GpuError> {
        let paths = self.paths.get(|| PathArrays::new(gpu, self.pixels))?;
        Ok(GpuRays { paths: Some(paths), ..self.without_paths(gpu, id, count)? })
    }

    /// Room for rays alone.
    fn without_paths(&mut self, gpu: &Gpu, id: QueueId, count: usize) -> Result<GpuRays, GpuError> {
        let rays = self.rays.get(|| RayArrays::new(gpu, "queue", self.pixels))?;
        Ok(GpuRays { id, count, rays, paths: None })
    }
}

impl GpuRays {
    /// What the rays carry.
    fn paths(&self) -> Result<&PathArrays> {
        self.paths.as_deref().with_context(|| gathered(self.id))
    }
}

impl GpuBackend {
    /// A backend for one run; `bvh` is what the trace kernel walks, none for `ray-query`.
    ///
    /// # Errors
    /// If something does not fit the adapter, or the driver refuses a kernel.
    pub fn new(
        gpu: Gpu,
        scene: &Scene,
        bvh: Option<&Bvh>,
        setup: Arc<Setup>,
        kernel: TraceKernel,
    ) -> Result<Self> {
        let pixels = setup.width as usize * setup.height as usize;
        let sites: Vec<_> = setup.light_sites.iter().map(key::gpu::site_data).collect();
        let tables = [GpuTable::new(&gpu, setup.table_bits)?, GpuTable::new(&gpu, setup.table_bits)?];
        Ok(Self {
            kernels: Kernels::new(&gpu, &setup)?,
            shading: Shading::new(&gpu, &setup)?,
            tracer: Tracer::new(&gpu, scene, bvh, kernel, &setup.features)?.with_precision(setup.precision),
            sorter: Sorter::new(&gpu)?,
            light_sites: gpu.array_of("key::light_sites", &sites)?,
            film: gpu.array("film", pixels)?,
            scratch_tables: None,
            untouched: None,
            counter: gpu.array("compare::counter", 1)?,
            queues: Queues { pixels, rays: Pool::default(), paths: Pool::default() },
            hits: [Pool::default(), Pool::default()],
            keys: Pool::default(),
            permutations: Pool::default(),
            readback: Readback::default(),
            clock: Clock::of_device(),
            tables,
            setup,
            gpu,
        })
    }

    /// Room for results of a queue.
    fn results(&mut self, kind: Kind, count: usize) -> Result<Lent<Hits>> {
        let pixels = self.queues.pixels;
        let memory = self.hits[kind as usize].get(|| Hits::new(&self.gpu, "trace::hits", kind, pixels))?;
        Ok(Lent::new(memory, |hits| Hits { count, ..hits.clone() }))
    }

    /// Room for a permutation.
    fn places(&mut self, count: usize) -> Result<GpuPermutation> {
        let pixels = self.queues.pixels;
        let permutation = self.permutations.get(|| self.gpu.array("sort::permutation", pixels))?;
        Ok(GpuPermutation { permutation, count })
    }
}

/// The first three of every four numbers.
fn first_three(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks_exact(16).flat_map(|four| &four[..12]).copied().collect()
}

impl Backend for GpuBackend {
    type Rays = GpuRays;
    type Hits = Lent<Hits>;
    type Keys = Lent<Keys>;
    type Permutation = GpuPermutation;

    fn sample(&self) -> Sample {
        self.clock.last()
    }

    fn restart(&mut self) -> Result<()> {
        let bits = self.setup.table_bits;
        // Within rounds a card does not wait for megabytes from the processor.
        let untouched = match &mut self.untouched {
            Some(untouched) => untouched,
            none => none.insert(GpuTable::new(&self.gpu, bits)?),
        };
        let mut run = self.gpu.stage("film");
        run.clear(&self.film);
        self.tables.iter().for_each(|table| table.copy(&mut run, untouched));
        Ok(run.submit()?)
    }

    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<GpuRays> {
        queue.check(&self.setup)?;
        if let Some(cells) = queue.lengths {
            let table = LengthTable::from_touched(self.setup.table_bits, cells)?;
            self.tables[queue.id.kind as usize] = GpuTable::filled(&self.gpu, &table)?;
        }
        let light = |at: usize| queue.lights.get(at).copied().unwrap_or(0);
        let states: Vec<[u32; 4]> = (0..queue.rays.len()).map(|at| [0, 0, 0, light(at)]).collect();
        let ids = self.gpu.array_of("queue::path_ids", queue.path_ids)?;
        let paths = Arc::new(PathArrays { ids, states: self.gpu.array_of("queue::states", &states)? });
        let rays = Arc::new(RayArrays::upload(&self.gpu, "queue", queue.rays)?);
        Ok(GpuRays { id: queue.id, count: queue.rays.len(), rays, paths: Some(paths) })
    }

    fn generate(&mut self, pass: u32) -> Result<GpuRays> {
        let params = generate::params(&self.setup, pass);
        let id = QueueId { pass, bounce: 0, kind: Kind::Closest };
        let rays = self.queues.queue(&self.gpu, id, params.count as usize)?;
        let paths = rays.paths()?;
        let [origins, directions] = rays.rays.bindings();
        let resources = [origins, directions, paths.ids.binding(), paths.states.binding()];
        self.clock.keep(|| self.kernels.generate.run(&self.gpu, &resources, rays.count, params))?;
        Ok(rays)
    }

    fn upload_permutation(&mut self, indices: &[u32]) -> Result<GpuPermutation> {
        check_bijection(indices, indices.len())?;
        let permutation = Arc::new(self.gpu.array_of("sort::permutation", indices)?);
        Ok(GpuPermutation { permutation, count: indices.len() })
    }

    fn upload_keys(&mut self, keys: &[u64], bits: u32) -> Result<Lent<Keys>> {
        let keys = Keys::upload(&self.gpu, keys, bits)?;
        Ok(Lent::new(Arc::new(keys), Keys::clone))
    }

    fn trace(&mut self, rays: &GpuRays, order: Order<&GpuPermutation>) -> Result<Lent<Hits>> {
        let hits = self.results(rays.id.kind, rays.count)?;
        let order = order.map(|permutation| &*permutation.permutation);
        self.clock.keep(|| self.tracer.trace(&self.gpu, &rays.rays, order, &hits))?;
        Ok(hits)
    }

    fn forget(&mut self, _rays: &GpuRays) -> Result<()> {
        // Graphics cards do not guess branches; of software adapters it was not measured.
        Ok(())
    }

    fn scatter(&mut self, hits: &Lent<Hits>, permutation: &GpuPermutation) -> Result<Lent<Hits>> {
        let home = self.results(hits.kind, hits.count)?;
        let resources = [permutation.permutation.binding(), hits.words.binding(), home.words.binding()];
        let kernel = &self.kernels.scatter[hits.kind as usize];
        self.clock.keep(|| kernel.run(&self.gpu, &resources, hits.count, ITEMS))?;
        Ok(home)
    }

    fn accumulate(&mut self, rays: &GpuRays, hits: &Lent<Hits>, table: Table) -> Result<()> {
        let kind = rays.id.kind as usize;
        if table == Table::Scratch && self.scratch_tables.is_none() {
            let bits = self.setup.table_bits;
            self.scratch_tables = Some([GpuTable::new(&self.gpu, bits)?, GpuTable::new(&self.gpu, bits)?]);
        }
        let table = match (table, &self.scratch_tables) {
            (Table::Scratch, Some(scratch)) => &scratch[kind],
            _ => &self.tables[kind],
        };
        let [origins, directions] = rays.rays.bindings();
        let [sums, counts] = table.bindings();
        let resources = [origins, directions, hits.words.binding(), sums, counts];
        self.clock.keep(|| self.kernels.accumulate[kind].run(&self.gpu, &resources, rays.count, ITEMS))?;
        Ok(())
    }

    fn shade(&mut self, rays: &GpuRays, hits: &Lent<Hits>) -> Result<Shaded<GpuRays>> {
        let id = rays.id;
        ensure!(id.kind == Kind::Closest, "{id} was to be shaded, which only closest rays are");
        let params = shade::params(&self.setup, id);
        let Self { gpu, kernels, shading, film, clock, queues, .. } = self;
        let mut shaded = None;
        clock.keep(|| {
            let (left, elapsed_ns) = shading.run(gpu, kernels, queues, params, (rays, hits), film)?;
            shaded = Some(left);
            anyhow::Ok(elapsed_ns)
        })?;
        shaded.context("shading left nothing")
    }

    fn add_light(&mut self, rays: &GpuRays, hits: &Lent<Hits>) -> Result<()> {
        let paths = rays.paths()?;
        let resources =
            [paths.ids.binding(), paths.states.binding(), hits.words.binding(), self.film.binding()];
        self.clock.keep(|| self.kernels.add_light.run(&self.gpu, &resources, rays.count, ITEMS))?;
        Ok(())
    }

    fn key(&mut self, rays: &GpuRays, hits: Option<&Lent<Hits>>, method: usize) -> Result<Lent<Keys>> {
        let plan = &self.setup.methods[method];
        let kernel = self.kernels.key[method][rays.id.kind as usize].as_ref();
        let kernel = kernel
            .with_context(|| format!("method '{}' has no keys for {} rays", plan.name, rays.id.kind))?;
        let inputs = key::gpu::KeyInputs::of(plan);
        let mut resources = rays.rays.bindings().to_vec();
        if inputs.table {
            resources.extend(self.tables[rays.id.kind as usize].bindings());
        }
        if inputs.results {
            resources.push(hits.with_context(|| untraced(rays.id, &plan.name))?.words.binding());
        }
        if inputs.lights {
            resources.extend([rays.paths()?.states.binding(), self.light_sites.binding()]);
        }
        if inputs.paths {
            resources.push(rays.paths()?.ids.binding());
        }
        let (pixels, is_wide) = (self.queues.pixels, plan.key_bits > u32::BITS);
        let memory = self.keys.get(|| Keys::new(&self.gpu, pixels))?;
        let keys = Lent::new(memory, |keys| Keys {
            bits: plan.key_bits,
            count: rays.count,
            high: keys.high.clone().filter(|_| is_wide),
            low: keys.low.clone(),
        });
        resources.push(keys.low.binding());
        resources.extend(keys.high.as_ref().map(DeviceArray::binding));
        self.clock.keep(|| kernel.run(&self.gpu, &resources, rays.count, ITEMS))?;
        Ok(keys)
    }

    fn sort(&mut self, keys: &Lent<Keys>) -> Result<GpuPermutation> {
        let places = self.places(keys.count)?;
        self.clock.keep(|| self.sorter.sort(&self.gpu, keys, &places.permutation))?;
        Ok(places)
    }

    fn gather(&mut self, rays: &GpuRays, permutation: &GpuPermutation) -> Result<GpuRays> {
        let gathered = self.queues.without_paths(&self.gpu, rays.id, rays.count)?;
        let [origins, directions] = rays.rays.bindings();
        let [to_origins, to_directions] = gathered.rays.bindings();
        let resources = [permutation.permutation.binding(), origins, directions, to_origins, to_directions];
        self.clock.keep(|| self.kernels.gather[0].run(&self.gpu, &resources, rays.count, ITEMS))?;
        Ok(gathered)
    }

    fn reorder(&mut self, rays: &GpuRays, permutation: &GpuPermutation) -> Result<GpuRays> {
        let (paths, gpu) = (rays.paths()?, &self.gpu);
        let reordered = self.queues.queue(gpu, rays.id, rays.count)?;
        let to_paths = reordered.paths()?;
        let [origins, directions] = rays.rays.bindings();
        let [to_origins, to_directions] = reordered.rays.bindings();
        let order = || permutation.permutation.binding();
        let ray = [order(), origins, directions, to_origins, to_directions];
        let path = [
            order(),
            paths.ids.binding(),
            paths.states.binding(),
            to_paths.ids.binding(),
            to_paths.states.binding(),
        ];
        let [gather_rays, gather_paths] = &self.kernels.gather;
        let bound = [gather_rays.bind(gpu, &ray, rays.count)?, gather_paths.bind(gpu, &path, rays.count)?];
        let mut run = gpu.stage("gather");
        run.for_items(&bound, ITEMS);
        self.clock.keep(|| run.finish())?;
        Ok(reordered)
    }

    fn differences(&mut self, hits: &Lent<Hits>, others: &Lent<Hits>) -> Result<u64> {
        let kernel = &self.kernels.compare[hits.kind as usize];
        let mut run = self.gpu.stage(kernel.label());
        run.clear(&self.counter);
        let resources = [hits.words.binding(), others.words.binding(), self.counter.binding()];
        run.for_items(&[kernel.bind(&self.gpu, &resources, hits.count)?], ITEMS);
        run.submit()?;
        Ok(self.gpu.read_vec(&self.counter)?.iter().map(|&count| u64::from(count)).sum())
    }

    fn read(&mut self, array: Array<'_, Self>, sink: &mut Sink<'_>) -> Result<()> {
        let Self { gpu, readback, .. } = self;
        let stretches = |count: usize| {
            let starts = (0..count).step_by(JOIN_ITEMS);
            starts.map(move |start| once(start..count.min(start + JOIN_ITEMS)))
        };
        match array {
            Array::Rays(GpuRays { rays, count, .. }) => {
                readback.read_pairs(gpu, [&rays.origins, &rays.directions], stretches(*count), sink)
            }
            Array::Sample(GpuRays { rays, count, .. }) => {
                let sampled = once(sample(*count).collect::<Vec<_>>());
                readback.read_pairs(gpu, [&rays.origins, &rays.directions], sampled, sink)
            }
            Array::PathIds(rays) => readback.read_chunks(gpu, &rays.paths()?.ids, 0..rays.count, sink),
            Array::Lights(rays) => readback.read_chunks(gpu, &rays.paths()?.states, 0..rays.count, |bytes| {
                let lights: Vec<u8> =
                    bytes.chunks_exact(16).flat_map(|state| &state[12..]).copied().collect();
                sink(&lights)
            }),
            Array::Throughput(rays) => {
                let states = &rays.paths()?.states;
                readback.read_chunks(gpu, states, 0..rays.count, |bytes| sink(&first_three(bytes)))
            }
            Array::Work(rays) => {
                let work = self.tracer.work(gpu, rays.id.kind, &rays.rays, rays.count)?;
                readback.read_chunks(gpu, &work, 0..rays.count, sink)
            }
            Array::LaneUse(_) => Ok(()),
            Array::Hits(hits) => {
                readback.read_chunks(gpu, &hits.words, 0..hits.count * Hits::words_each(hits.kind), sink)
            }
            Array::Keys(keys) => match keys.high.as_ref().filter(|_| keys.bits > u32::BITS) {
                Some(high) => readback.read_pairs(gpu, [&keys.low, high], stretches(keys.count), sink),
                None => readback.read_chunks(gpu, &keys.low, 0..keys.count, sink),
            },
            Array::Permutation(GpuPermutation { permutation, count }) => {
                readback.read_chunks(gpu, permutation, 0..*count, sink)
            }
            Array::Lengths(kind) => {
                let cells = self.tables[kind as usize].touched(gpu)?;
                sink(bytemuck::cast_slice(&cells))
            }
            Array::Film => {
                readback.read_chunks(gpu, &self.film, 0..self.film.len(), |bytes| sink(&first_three(bytes)))
            }
        }
    }
}
