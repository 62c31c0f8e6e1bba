//! Trace on the GPU: a scene's hierarchy, and the kernels that walk it, compiled when they are needed.

use anyhow::{Context, Result, ensure};
use formats::ray::{Hit, Kind, Ray};
use scenes::Scene;
use scenes::bvh::Bvh;
use scenes::features::Features;

use super::driver;
use super::leaves::Leaves;
use super::mask::Masks;
use super::variant::TraceVariant;
use super::{Order, Precision, TraceKernel};
use crate::device::{DeviceArray, Gpu, GpuError, ITEMS, ItemKernel};
use crate::stages::shared::MaskedTriangle;

/// Rays on the GPU; as many of each half.
#[derive(Clone, Debug)]
pub struct RayArrays {
    /// Origin and t_min of each.
    pub origins: DeviceArray<[f32; 4]>,
    /// Direction and t_max of each.
    pub directions: DeviceArray<[f32; 4]>,
}

impl RayArrays {
    /// Room for `count` rays; the labels begin with `owner`.
    ///
    /// # Errors
    /// If there are too many for the adapter.
    pub fn new(gpu: &Gpu, owner: &str, count: usize) -> Result<Self, GpuError> {
        let half = |name: &str| gpu.array(&format!("{owner}::{name}"), count);
        Ok(Self { origins: half("origins")?, directions: half("directions")? })
    }

    /// Uploads rays.
    ///
    /// # Errors
    /// As [`RayArrays::new`].
    pub fn upload(gpu: &Gpu, owner: &str, rays: &[Ray]) -> Result<Self, GpuError> {
        let arrays = Self::new(gpu, owner, rays.len())?;
        let halves: Vec<[[f32; 4]; 2]> = rays.iter().map(|ray| bytemuck::cast(*ray)).collect();
        let half = |at: usize| halves.iter().map(|halves| halves[at]).collect::<Vec<_>>();
        gpu.write(&arrays.origins, &half(0))?;
        gpu.write(&arrays.directions, &half(1))?;
        Ok(arrays)
    }

    /// Both halves, to be bound.
    pub fn bindings(&self) -> [wgpu::BindingResource<'_>; 2] {
        [self.origins.binding(), self.directions.binding()]
    }
}

/// Results of rays, each at its ray's place.
#[derive(Clone, Debug)]
pub struct Hits {
    /// What its rays asked for.
    pub kind: Kind,
    /// How many rays there are; the array may be longer.
    pub count: usize,
    /// t, triangle, u and v of each closest ray; of shadow rays the distance at which each is blocked.
    pub words: DeviceArray<u32>,
}

impl Hits {
    /// Room for `count` results of unknown value.
    ///
    /// # Errors
    /// If there are too many for the adapter.
    pub fn new(gpu: &Gpu, label: &str, kind: Kind, count: usize) -> Result<Self, GpuError> {
        Ok(Self { kind, count, words: gpu.array(label, count.max(1) * Self::words_each(kind))? })
    }

    /// Words of a result.
    pub fn words_each(kind: Kind) -> usize {
        match kind {
            Kind::Closest => size_of::<Hit>() / size_of::<u32>(),
            Kind::Shadow => 1,
        }
    }
}

/// A scene's hierarchy on the GPU and the kernels that walk it.
pub struct Tracer {
    kernel: TraceKernel,
    leaves: Leaves,
    masks: Option<DeviceArray<u32>>,
    hierarchy: Hierarchy,
    precision: Precision,
    compiled: Vec<(TraceVariant, ItemKernel)>,
}

enum Hierarchy {
    Nodes(DeviceArray<[u32; 4]>),
    Driver(wgpu::Tlas),
}

/// All masks in one array of words: per scene triangle the word where its mask begins, 0 for none;
/// the masks, whose `first` counts bytes of the whole array; the alpha bytes.
///
/// # Errors
/// If there are more bytes than a word can count.
fn mask_words(masks: &Masks) -> Result<Vec<u32>> {
    const MASK_WORDS: usize = size_of::<MaskedTriangle>() / size_of::<u32>();
    let first_mask = masks.numbers.len();
    let first_alpha = first_mask + MASK_WORDS * masks.triangles.len();
    let alpha_bytes = first_alpha * size_of::<u32>();
    let bytes = alpha_bytes + masks.alphas.len();
    ensure!(
        u32::try_from(bytes).is_ok(),
        "the alpha masks of {} triangles take {bytes} bytes, more than 32 bits can count; use --backend cpu",
        masks.triangles.len()
    );
    let place = |&number: &u32| {
        number.checked_sub(1).map_or(0, |mask| (first_mask + MASK_WORDS * mask as usize) as u32)
    };
    let mut words: Vec<u32> = masks.numbers.iter().map(place).collect();
    for triangle in &masks.triangles {
        let moved = MaskedTriangle { first: triangle.first + alpha_bytes as u32, ..*triangle };
        words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&moved)));
    }
    words.extend(masks.alphas.chunks(4).map(|bytes| {
        (0..).zip(bytes).fold(0u32, |word, (place, &byte)| word | u32::from(byte) << (8 * place))
    }));
    Ok(words)
}

impl Tracer {
    /// Uploads a hierarchy, or lets the driver build one where `bvh` is `None`.
    ///
    /// # Errors
    /// If something is too large for the adapter.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        bvh: Option<&Bvh>,
        kernel: TraceKernel,
        features: &Features,
    ) -> Result<Self> {
        let limits = &gpu.adapter().limits;
        let limit_bytes = limits.storage_binding_bytes.min(limits.buffer_bytes);
        Self::with_leaves_within(limit_bytes, gpu, scene, bvh, kernel, features)
    }

    /// As [`Tracer::new`]; leaves hold their corners if that takes `limit_bytes` or less.
    fn with_leaves_within(
        limit_bytes: u64,
        gpu: &Gpu,
        scene: &Scene,
        bvh: Option<&Bvh>,
        kernel: TraceKernel,
        features: &Features,
    ) -> Result<Self> {
        ensure!(
            kernel.is_for_gpus(),
            "trace kernel {} is for threads; use --backend cpu, or --trace cwbvh or bvh2",
            kernel.name()
        );
        let masks = Masks::for_features(scene, features);
        let leaves = |triangles: &[u32]| Leaves::new(gpu, scene, triangles, limit_bytes);
        let (leaves, hierarchy) = match (bvh, kernel.bvh_kind()) {
            (None, None) => (
                leaves(&(0..scene.triangles.len() as u32).collect::<Vec<_>>())?,
                Hierarchy::Driver(driver::hierarchy(gpu, scene, masks.is_empty())?),
            ),
            (bvh, _) => {
                let bvh = bvh.with_context(|| format!("trace kernel {} needs a hierarchy", kernel.name()))?;
                let nodes: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(bvh.node_bytes());
                (leaves(bvh.order())?, Hierarchy::Nodes(gpu.array_of("trace::nodes", &nodes)?))
            }
        };
        let masks = (!masks.is_empty()).then(|| mask_words(&masks)).transpose()?;
        Ok(Self {
            kernel,
            leaves,
            masks: masks.map(|words| gpu.array_of("trace::masks", &words)).transpose()?,
            hierarchy,
            precision: Precision::default(),
            compiled: Vec::new(),
        })
    }

    /// The same with other tests of triangles and boxes for closest rays.
    #[must_use]
    pub fn with_precision(self, precision: Precision) -> Self {
        Self { precision, compiled: Vec::new(), ..self }
    }

    /// Traces as many rays as there are results; returns the device's time in nanoseconds.
    ///
    /// # Errors
    /// If the driver refuses a kernel or the device is lost.
    pub fn trace(
        &mut self,
        gpu: &Gpu,
        rays: &RayArrays,
        order: Order<&DeviceArray<u32>>,
        hits: &Hits,
    ) -> Result<u64> {
        let kernel = self.compiled(gpu, hits.kind, order.map(drop), false)?;
        self.run(gpu, &kernel, rays, order, &hits.words, hits.count)
    }

    /// What tracing each of the first `count` rays takes, in canonical order.
    ///
    /// # Errors
    /// As [`Tracer::trace`].
    pub fn work(
        &mut self,
        gpu: &Gpu,
        kind: Kind,
        rays: &RayArrays,
        count: usize,
    ) -> Result<DeviceArray<[u32; 2]>> {
        let work = gpu.array("trace::work", count)?;
        let kernel = self.compiled(gpu, kind, Order::Stored, true)?;
        self.run(gpu, &kernel, rays, Order::Stored, &work, count)?;
        Ok(work)
    }

    fn run<T>(
        &self,
        gpu: &Gpu,
        kernel: &ItemKernel,
        rays: &RayArrays,
        order: Order<&DeviceArray<u32>>,
        results: &DeviceArray<T>,
        count: usize,
    ) -> Result<u64> {
        let mut resources = rays.bindings().to_vec();
        if let Order::Indirect(permutation) = order {
            resources.push(permutation.binding());
        }
        resources.push(results.binding());
        resources.extend(self.leaves.bindings());
        resources.extend(self.masks.as_ref().map(DeviceArray::binding));
        resources.push(match &self.hierarchy {
            Hierarchy::Nodes(nodes) => nodes.binding(),
            Hierarchy::Driver(top) => top.as_binding(),
        });
        Ok(kernel.run(gpu, &resources, count, ITEMS)?)
    }

    /// Compiles what tracing in canonical order needs, which else happens with the first rays.
    ///
    /// # Errors
    /// If the driver refuses a kernel.
    pub fn compile(&mut self, gpu: &Gpu) -> Result<()> {
        Kind::ALL.into_iter().try_for_each(|kind| self.compiled(gpu, kind, Order::Stored, false).map(drop))
    }

    /// The kernel of a variant, compiled when it is first needed.
    fn compiled(&mut self, gpu: &Gpu, kind: Kind, order: Order<()>, count_work: bool) -> Result<ItemKernel> {
        let variant = TraceVariant {
            kernel: self.kernel,
            kind,
            order,
            leaves: self.leaves.form(),
            masks: self.masks.is_some(),
            count_work,
            precision: if kind == Kind::Closest { self.precision } else { Precision::default() },
        };
        if let Some((_, kernel)) = self.compiled.iter().find(|(known, _)| *known == variant) {
            return Ok(kernel.clone());
        }
        let kernel = variant.module().compile(gpu)?;
        self.compiled.push((variant, kernel.clone()));
        Ok(kernel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{Rounding, test_gpu};
    use crate::machine::self_check::SelfCheck;
    use crate::stages::trace::cpu::CpuTracer;
    use crate::stages::trace::{LeafForm, hits};

    /// Rays in all directions from around the middle of a scene.
    fn rays(scene: &Scene) -> Vec<Ray> {
        let mut random = fastrand::Rng::with_seed(61);
        let (bounds, mut draw) = (scene.bounds(), || [0; 3].map(|_| 2.0 * random.f32() - 1.0));
        let mut ray = |_| {
            let (offset, direction) = (draw(), draw());
            let origin =
                [0, 1, 2].map(|axis| bounds.centre()[axis] + 0.4 * offset[axis] * bounds.extent()[axis]);
            Ray { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
        };
        (0..4000).map(&mut ray).collect()
    }

    #[test]
    fn leaves_of_either_form_and_guarded_products_find_what_threads_find() {
        let scene = scenes::load("builtin:city?triangles=5000").unwrap();
        let (gpu, rays, features) = (test_gpu(), rays(&scene), Features::of(&scene));
        let needed = SelfCheck::run(gpu).unwrap().rounding;
        let plain = &gpu.clone().with_rounding(needed);
        let guarded = &gpu.clone().with_rounding(Rounding { contracts: true, ..needed });
        let uploaded = RayArrays::upload(gpu, "test", &rays).unwrap();
        for kernel in [TraceKernel::Cwbvh, TraceKernel::Bvh2] {
            let bvh = scenes::bvh::build(&scene, kernel.bvh_kind().unwrap()).unwrap();
            let threads = CpuTracer::new(&scene, &bvh);
            for (gpu, limit_bytes, form) in [
                (guarded, u64::MAX, LeafForm::Gathered),
                (guarded, 0, LeafForm::Indexed),
                (plain, u64::MAX, LeafForm::Gathered),
                (plain, 0, LeafForm::Indexed),
            ] {
                let mut tracer =
                    Tracer::with_leaves_within(limit_bytes, gpu, &scene, Some(&bvh), kernel, &features)
                        .unwrap();
                assert_eq!(tracer.leaves.form(), form);
                for kind in Kind::ALL {
                    let expected = hits::Hits::new(kind, rays.len());
                    threads.trace(&rays, Order::Stored, &expected);
                    let found = Hits::new(gpu, "test::hits", kind, rays.len()).unwrap();
                    tracer.trace(gpu, &uploaded, Order::Stored, &found).unwrap();
                    let words = gpu.read_vec(&found.words).unwrap();
                    assert_eq!(
                        bytemuck::cast_slice::<u32, u8>(&words),
                        expected.bytes(0..rays.len()),
                        "{kind} rays by {} with {form:?} leaves, {:?}",
                        kernel.name(),
                        gpu.rounding()
                    );
                }
            }
        }
    }
}
