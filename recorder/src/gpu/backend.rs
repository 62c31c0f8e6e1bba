//! The backend on a GPU.

use std::sync::Arc;

use anyhow::{Context, Result, bail};
use formats::key::Layout;
use formats::length_table::{LengthCell, LengthTable};
use formats::manifest::QueueId;
use formats::ray::{Kind, Ray};
use scenes::Scene;
use scenes::bvh::Bvh;

use super::kernels::Kernels;
use super::run::ItemRange;
use super::shading::Shading;
use super::table::GpuTable;
use super::{DeviceArray, Gpu, GpuError, Kernel, Readback, StageRun};
use crate::backend::{Backend, Queue, RecordedRays, Setup, Shaded, Sink, Table};
use crate::stages::shared::{GenerateParams, Span};
use crate::stages::sort::gpu::{SortKeys, Sorter};
use crate::stages::trace::TraceKernel;
use crate::stages::trace::gpu::{Order, Tracer};
use crate::stages::{generate, key, shade};

/// Threads of a workgroup, in every kernel here.
pub(super) const WORKGROUP: u32 = 64;
/// Rays that are read back at once where halves have to be joined.
const JOIN_RAYS: usize = 1 << 18;

/// Runs every stage as a compute kernel.
pub struct GpuBackend {
    gpu: Gpu,
    setup: Arc<Setup>,
    kernels: Kernels,
    tracer: Tracer,
    sorter: Sorter,
    shading: Shading,
    light_sites: DeviceArray<crate::stages::shared::LightSiteData>,
    film: DeviceArray<[f32; 4]>,
    tables: [GpuTable; 2],
    scratch_tables: Option<[GpuTable; 2]>,
    scratch: Scratch,
    elapsed_ns: u64,
}

/// Arrays for one ray per pixel that every queue uses anew.
struct Scratch {
    keys_low: DeviceArray<u32>,
    keys_high: Option<DeviceArray<u32>>,
    gathered_origins: DeviceArray<[f32; 4]>,
    gathered_directions: DeviceArray<[f32; 4]>,
    hits: DeviceArray<[u32; 4]>,
    distances: DeviceArray<f32>,
    counter: DeviceArray<u32>,
}

/// A queue on the GPU.
pub struct GpuRays {
    pub(super) id: QueueId,
    pub(super) count: usize,
    pub(crate) origins: DeviceArray<[f32; 4]>,
    pub(crate) directions: DeviceArray<[f32; 4]>,
    pub(super) path_ids: DeviceArray<u32>,
    pub(super) states: DeviceArray<[u32; 4]>,
}

/// Results in canonical order.
pub enum GpuHits {
    /// t, triangle, u, v of closest rays.
    Closest(DeviceArray<[u32; 4]>),
    /// Distances of shadow rays.
    Shadow(DeviceArray<f32>),
}

/// Keys in the scratch arrays.
pub struct GpuKeys {
    keys: SortKeys,
    count: usize,
}

/// A permutation.
pub struct GpuOrder {
    permutation: DeviceArray<u32>,
    count: usize,
}

/// Gathered rays in the scratch arrays.
pub struct GpuGathered {
    kind: Kind,
}

impl Queue for GpuRays {
    fn len(&self) -> usize {
        self.count
    }

    fn id(&self) -> QueueId {
        self.id
    }
}

impl GpuRays {
    /// Room for a queue.
    pub(super) fn new(gpu: &Gpu, id: QueueId, count: usize) -> Result<Self, GpuError> {
        Ok(Self {
            id,
            count,
            origins: gpu.array("queue::origins", count)?,
            directions: gpu.array("queue::directions", count)?,
            path_ids: gpu.array("queue::path_ids", count)?,
            states: gpu.array("queue::states", count)?,
        })
    }
}

impl GpuHits {
    pub(super) fn array(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Closest(array) => array.binding(),
            Self::Shadow(array) => array.binding(),
        }
    }
}

impl Scratch {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        let pixels = setup.width as usize * setup.height as usize;
        let wide = setup.methods.iter().any(|method| method.key_bits > 32);
        Ok(Self {
            keys_low: gpu.array("key::low", pixels)?,
            keys_high: wide.then(|| gpu.array("key::high", pixels)).transpose()?,
            gathered_origins: gpu.array("gather::origins", pixels)?,
            gathered_directions: gpu.array("gather::directions", pixels)?,
            hits: gpu.array("trace::scattered_hits", pixels)?,
            distances: gpu.array("trace::scattered_distances", pixels)?,
            counter: gpu.array("measure::counter", 1)?,
        })
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
            scratch: Scratch::new(&gpu, &setup)?,
            scratch_tables: None,
            elapsed_ns: 0,
            tables,
            setup,
            gpu,
        })
    }

    fn add_spans(
        &self,
        run: &mut StageRun<'_>,
        kernel: &Kernel,
        resources: &[wgpu::BindingResource<'_>],
        count: usize,
    ) -> Result<()> {
        let group = kernel.bind(&self.gpu, 0, resources)?;
        let total = count as u32;
        run.dispatch_chunks(kernel, &group, ItemRange::new(total, WORKGROUP), |chunk| Span::of(chunk, total));
        Ok(())
    }

    /// Runs a kernel over spans of `count` items; returns its time in nanoseconds.
    fn run_spans(
        &self,
        kernel: &Kernel,
        resources: &[wgpu::BindingResource<'_>],
        count: usize,
    ) -> Result<u64> {
        let mut run = self.gpu.stage(kernel.label());
        self.add_spans(&mut run, kernel, resources, count)?;
        Ok(run.finish()?.elapsed_ns)
    }

    fn trace_in(
        &mut self,
        kind: Kind,
        order: Order<'_>,
        origins: &DeviceArray<[f32; 4]>,
        directions: &DeviceArray<[f32; 4]>,
        count: usize,
    ) -> Result<GpuHits> {
        let results = match kind {
            Kind::Closest => GpuHits::Closest(self.scratch.hits.clone()),
            Kind::Shadow => GpuHits::Shadow(self.scratch.distances.clone()),
        };
        self.elapsed_ns =
            self.tracer.trace(&self.gpu, kind, order, origins, directions, results.array(), count)?;
        Ok(results)
    }

    fn read_words(&self, array: &DeviceArray<u32>, count: usize, sink: &mut Sink<'_>) -> Result<()> {
        Readback::new(&self.gpu).read_chunks(array, 0..count, sink)
    }
}

impl Backend for GpuBackend {
    type Rays = GpuRays;
    type Hits = GpuHits;
    type Scattered = GpuHits;
    type Keys = GpuKeys;
    type Order = GpuOrder;
    type Gathered = GpuGathered;

    fn elapsed_ns(&self) -> u64 {
        self.elapsed_ns
    }

    fn upload(&mut self, queue: RecordedRays<'_>) -> Result<GpuRays> {
        if let Some(cells) = queue.lengths {
            let table = LengthTable::from_touched(self.setup.table_bits, cells)?;
            self.tables[queue.id.kind as usize] = GpuTable::filled(&self.gpu, &table)?;
        }
        let halves = |half: fn(&Ray) -> [f32; 4]| queue.rays.iter().map(half).collect::<Vec<_>>();
        let origins = halves(|ray| [ray.origin[0], ray.origin[1], ray.origin[2], ray.t_min]);
        let directions = halves(|ray| [ray.direction[0], ray.direction[1], ray.direction[2], ray.t_max]);
        let light = |at: usize| queue.lights.get(at).copied().unwrap_or(0);
        let states: Vec<[u32; 4]> = (0..queue.rays.len()).map(|at| [0, 0, 0, light(at)]).collect();
        Ok(GpuRays {
            id: queue.id,
            count: queue.rays.len(),
            origins: self.gpu.array_of("queue::origins", &origins)?,
            directions: self.gpu.array_of("queue::directions", &directions)?,
            path_ids: self.gpu.array_of("queue::path_ids", queue.path_ids)?,
            states: self.gpu.array_of("queue::states", &states)?,
        })
    }

    fn address_tables(&mut self, bits: u32, layout: &Layout) -> Result<()> {
        let setup = Arc::make_mut(&mut self.setup);
        setup.table_bits = bits;
        setup.table_layout = layout.clone();
        self.kernels.for_table(&self.gpu, &self.setup)?;
        self.tables = [GpuTable::new(&self.gpu, bits)?, GpuTable::new(&self.gpu, bits)?];
        self.scratch_tables = None;
        Ok(())
    }

    fn generate(&mut self, pass: u32) -> Result<GpuRays> {
        let params = generate::params(&self.setup, pass);
        let id = QueueId { pass, bounce: 0, kind: Kind::Closest };
        let rays = GpuRays::new(&self.gpu, id, params.count as usize)?;
        let kernel = &self.kernels.generate;
        let resources = [
            rays.origins.binding(),
            rays.directions.binding(),
            rays.path_ids.binding(),
            rays.states.binding(),
        ];
        let group = kernel.bind(&self.gpu, 0, &resources)?;
        let mut run = self.gpu.stage(kernel.label());
        run.dispatch_chunks(kernel, &group, ItemRange::new(params.count, WORKGROUP), |chunk| {
            GenerateParams { first: chunk.first, count: chunk.count, ..params }
        });
        self.elapsed_ns = run.finish()?.elapsed_ns;
        Ok(rays)
    }

    fn trace(&mut self, rays: &GpuRays) -> Result<GpuHits> {
        let kind = rays.id.kind;
        let results = match kind {
            Kind::Closest => GpuHits::Closest(self.gpu.array("trace::hits", rays.count)?),
            Kind::Shadow => GpuHits::Shadow(self.gpu.array("trace::distances", rays.count)?),
        };
        self.elapsed_ns = self.tracer.trace(
            &self.gpu,
            kind,
            Order::Canonical,
            &rays.origins,
            &rays.directions,
            results.array(),
            rays.count,
        )?;
        Ok(results)
    }

    fn accumulate(&mut self, rays: &GpuRays, hits: &GpuHits, table: Table) -> Result<()> {
        let kind = rays.id.kind as usize;
        if table == Table::Scratch && self.scratch_tables.is_none() {
            let bits = self.setup.table_bits;
            self.scratch_tables = Some([GpuTable::new(&self.gpu, bits)?, GpuTable::new(&self.gpu, bits)?]);
        }
        let table = match (table, &self.scratch_tables) {
            (Table::Scratch, Some(scratch)) => &scratch[kind],
            _ => &self.tables[kind],
        };
        let resources = [
            rays.origins.binding(),
            rays.directions.binding(),
            hits.array(),
            table.sums.binding(),
            table.counts.binding(),
        ];
        self.elapsed_ns = self.run_spans(&self.kernels.accumulate[kind], &resources, rays.count)?;
        Ok(())
    }

    fn shade(&mut self, rays: &GpuRays, hits: &GpuHits) -> Result<Shaded<GpuRays>> {
        let params = shade::params(&self.setup, rays.id);
        let (shaded, elapsed_ns) =
            self.shading.run(&self.gpu, &self.kernels, params, (rays, hits), &self.film)?;
        self.elapsed_ns = elapsed_ns;
        Ok(shaded)
    }

    fn add_light(&mut self, rays: &GpuRays, hits: &GpuHits) -> Result<()> {
        let resources = [rays.path_ids.binding(), rays.states.binding(), hits.array(), self.film.binding()];
        self.elapsed_ns = self.run_spans(&self.kernels.add_light, &resources, rays.count)?;
        Ok(())
    }

    fn key(&mut self, rays: &GpuRays, hits: &GpuHits, method: usize) -> Result<GpuKeys> {
        let plan = &self.setup.methods[method];
        let kernel = self.kernels.key[method][rays.id.kind as usize].as_ref();
        let kernel = kernel
            .with_context(|| format!("method '{}' has no keys for {} rays", plan.name, rays.id.kind))?;
        let inputs = key::gpu::KeyInputs::of(plan);
        let mut resources = vec![rays.origins.binding(), rays.directions.binding()];
        if inputs.table {
            let table = &self.tables[rays.id.kind as usize];
            resources.extend([table.sums.binding(), table.counts.binding()]);
        }
        if inputs.results {
            resources.push(hits.array());
        }
        if inputs.lights {
            resources.extend([rays.states.binding(), self.light_sites.binding()]);
        }
        let high = self.scratch.keys_high.as_ref().filter(|_| plan.key_bits > 32);
        resources.push(self.scratch.keys_low.binding());
        resources.extend(high.map(DeviceArray::binding));
        self.elapsed_ns = self.run_spans(kernel, &resources, rays.count)?;
        let keys = SortKeys { low: self.scratch.keys_low.clone(), high: high.cloned(), bits: plan.key_bits };
        Ok(GpuKeys { keys, count: rays.count })
    }

    fn sort(&mut self, keys: &GpuKeys) -> Result<GpuOrder> {
        let sorted = self.sorter.sort(&self.gpu, &keys.keys, keys.count)?;
        self.elapsed_ns = sorted.elapsed_ns;
        Ok(GpuOrder { permutation: sorted.permutation, count: keys.count })
    }

    fn gather(&mut self, rays: &GpuRays, order: &GpuOrder) -> Result<GpuGathered> {
        let resources = [
            order.permutation.binding(),
            rays.origins.binding(),
            rays.directions.binding(),
            self.scratch.gathered_origins.binding(),
            self.scratch.gathered_directions.binding(),
        ];
        self.elapsed_ns = self.run_spans(&self.kernels.gather, &resources, rays.count)?;
        Ok(GpuGathered { kind: rays.id.kind })
    }

    fn trace_gathered(&mut self, gathered: &GpuGathered, order: &GpuOrder) -> Result<GpuHits> {
        let (origins, directions) =
            (self.scratch.gathered_origins.clone(), self.scratch.gathered_directions.clone());
        self.trace_in(gathered.kind, Order::Gathered(&order.permutation), &origins, &directions, order.count)
    }

    fn trace_indirect(&mut self, rays: &GpuRays, order: &GpuOrder) -> Result<GpuHits> {
        self.trace_in(
            rays.id.kind,
            Order::Indirect(&order.permutation),
            &rays.origins,
            &rays.directions,
            rays.count,
        )
    }

    fn differences(&mut self, rays: &GpuRays, hits: &GpuHits, other: &GpuHits) -> Result<u64> {
        let kernel = &self.kernels.differences[rays.id.kind as usize];
        let mut run = self.gpu.stage(kernel.label());
        run.clear(&self.scratch.counter);
        self.add_spans(
            &mut run,
            kernel,
            &[hits.array(), other.array(), self.scratch.counter.binding()],
            rays.count,
        )?;
        run.submit()?;
        Ok(self.gpu.read_vec(&self.scratch.counter)?.iter().map(|&count| u64::from(count)).sum())
    }

    fn read_rays(&mut self, rays: &GpuRays, sink: &mut Sink<'_>) -> Result<()> {
        let mut readback = Readback::new(&self.gpu);
        let mut joined = Vec::with_capacity(JOIN_RAYS.min(rays.count));
        for first in (0..rays.count).step_by(JOIN_RAYS) {
            let range = first..rays.count.min(first + JOIN_RAYS);
            let origins = readback.read_vec(&rays.origins, range.clone())?;
            let directions = readback.read_vec(&rays.directions, range)?;
            joined.clear();
            joined.extend(origins.iter().zip(&directions).map(
                |(&[ox, oy, oz, t_min], &[dx, dy, dz, t_max])| Ray {
                    origin: [ox, oy, oz],
                    t_min,
                    direction: [dx, dy, dz],
                    t_max,
                },
            ));
            sink(bytemuck::cast_slice(&joined))?;
        }
        Ok(())
    }

    fn read_path_ids(&mut self, rays: &GpuRays, sink: &mut Sink<'_>) -> Result<()> {
        self.read_words(&rays.path_ids, rays.count, sink)
    }

    fn read_lights(&mut self, rays: &GpuRays, sink: &mut Sink<'_>) -> Result<()> {
        if rays.id.kind != Kind::Shadow {
            bail!("only shadow rays have lights");
        }
        Readback::new(&self.gpu).read_chunks(&rays.states, 0..rays.count, |bytes| {
            let lights: Vec<u8> = bytes.chunks_exact(16).flat_map(|state| &state[12..]).copied().collect();
            sink(&lights)
        })
    }

    fn read_hits(&mut self, hits: &GpuHits, sink: &mut Sink<'_>) -> Result<()> {
        let mut readback = Readback::new(&self.gpu);
        match hits {
            GpuHits::Closest(array) => readback.read_chunks(array, 0..array.len(), sink),
            GpuHits::Shadow(array) => readback.read_chunks(array, 0..array.len(), sink),
        }
    }

    fn read_work(&mut self, rays: &GpuRays, sink: &mut Sink<'_>) -> Result<()> {
        let work = self.tracer.work(&self.gpu, rays.id.kind, &rays.origins, &rays.directions, rays.count)?;
        Readback::new(&self.gpu).read_chunks(&work, 0..rays.count, sink)
    }

    fn read_keys(&mut self, keys: &GpuKeys, sink: &mut Sink<'_>) -> Result<()> {
        let Some(high) = &keys.keys.high else {
            return self.read_words(&keys.keys.low, keys.count, sink);
        };
        let mut readback = Readback::new(&self.gpu);
        for first in (0..keys.count).step_by(JOIN_RAYS) {
            let range = first..keys.count.min(first + JOIN_RAYS);
            let low = readback.read_vec(&keys.keys.low, range.clone())?;
            let high = readback.read_vec(high, range)?;
            let joined: Vec<u64> =
                low.iter().zip(&high).map(|(&low, &high)| u64::from(high) << 32 | u64::from(low)).collect();
            sink(bytemuck::cast_slice(&joined))?;
        }
        Ok(())
    }

    fn read_order(&mut self, order: &GpuOrder, sink: &mut Sink<'_>) -> Result<()> {
        self.read_words(&order.permutation, order.count, sink)
    }

    fn touched_cells(&mut self, kind: Kind) -> Result<Vec<LengthCell>> {
        Ok(self.tables[kind as usize].touched(&self.gpu)?)
    }

    fn image(&mut self, passes: u32) -> Result<Vec<[f32; 3]>> {
        let scale = 1.0 / passes as f32;
        Ok(self
            .gpu
            .read_vec(&self.film)?
            .iter()
            .map(|&[r, g, b, _]| [r * scale, g * scale, b * scale])
            .collect())
    }
}
