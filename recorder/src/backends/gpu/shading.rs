//! Shading on the GPU: the kernels in turn, then the queues that are left moved together.

use anyhow::Result;
use formats::manifest::QueueId;
use formats::ray::Kind;

use super::kernels::Kernels;
use super::scene::SceneArrays;
use super::{GpuRays, Queues};
use crate::backends::Shaded;
use crate::device::item::ITEMS_PER_SUBMISSION;
use crate::device::{DeviceArray, Gpu, ITEMS};
use crate::stages::compact::gpu::Scan;
use crate::stages::setup::Setup;
use crate::stages::shared::{ShadeParams, SurfaceData};
use crate::stages::trace::gpu::Hits;

/// The scene as shading reads it, and what its kernels write.
pub(super) struct Shading {
    scene: SceneArrays,
    /// Of one dispatch.
    surfaces: DeviceArray<SurfaceData>,
    /// Where rays of both kinds start, at the place of each path.
    origins: DeviceArray<[f32; 4]>,
    shadow: Candidates,
    next: Candidates,
    scan: Scan,
    places: DeviceArray<u32>,
}

/// What shading writes at the place of each path: shadow rays or next rays, none where t_max is 0.
struct Candidates {
    directions: DeviceArray<[f32; 4]>,
    states: DeviceArray<[u32; 4]>,
}

impl Candidates {
    fn new(gpu: &Gpu, queue: &str, pixels: usize) -> Result<Self> {
        Ok(Self {
            directions: gpu.array(&format!("shade::{queue}_directions"), pixels)?,
            states: gpu.array(&format!("shade::{queue}_states"), pixels)?,
        })
    }
}

impl Shading {
    /// Uploads the scene and makes room for a picture.
    ///
    /// # Errors
    /// If something does not fit the adapter.
    pub(super) fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        let pixels = setup.width as usize * setup.height as usize;
        Ok(Self {
            scene: SceneArrays::new(gpu, &setup.tables, &setup.features)?,
            surfaces: gpu.array("shade::surfaces", pixels.min(ITEMS_PER_SUBMISSION as usize))?,
            origins: gpu.array("shade::origins", pixels)?,
            shadow: Candidates::new(gpu, "shadow", pixels)?,
            next: Candidates::new(gpu, "next", pixels)?,
            scan: Scan::new(gpu)?,
            places: gpu.array("compact::places", pixels)?,
        })
    }

    /// Shades a queue: light to `film`; returns the queues that are left, and the time in nanoseconds.
    ///
    /// # Errors
    /// Those of the device.
    pub(super) fn run(
        &self,
        gpu: &Gpu,
        kernels: &Kernels,
        queues: &mut Queues,
        params: ShadeParams,
        (rays, hits): (&GpuRays, &Hits),
        film: &DeviceArray<[f32; 4]>,
    ) -> Result<(Shaded<GpuRays>, u64)> {
        let (scene, paths) = (&self.scene, rays.paths()?);
        let mut resources = vec![
            rays.rays.directions.binding(),
            hits.words.binding(),
            scene.triangles.binding(),
            scene.positions.binding(),
            scene.tables.binding(),
        ];
        resources.extend(scene.normals.iter().map(DeviceArray::binding));
        resources.extend(scene.uvs.iter().map(DeviceArray::binding));
        resources.push(self.surfaces.binding());
        let surface = kernels.surface.bind(gpu, &resources, rays.count)?;
        let path = [
            self.surfaces.binding(),
            rays.rays.directions.binding(),
            paths.ids.binding(),
            paths.states.binding(),
        ];
        let to_shadow = [
            scene.emitters.binding(),
            film.binding(),
            self.shadow.directions.binding(),
            self.shadow.states.binding(),
        ];
        let shadow = kernels.shadow.bind(gpu, &[&path[..], &to_shadow].concat(), rays.count)?;
        let to_next = [self.origins.binding(), self.next.directions.binding(), self.next.states.binding()];
        let next = kernels.next.bind(gpu, &[&path[..], &to_next].concat(), rays.count)?;
        let mut run = gpu.stage("shade");
        run.for_items(&[surface, shadow, next], params);
        let shade_ns = run.finish()?;
        let id = QueueId { kind: Kind::Shadow, ..rays.id };
        let (shadow, shadow_ns) = self.compact(gpu, kernels, queues, &self.shadow, rays, id)?;
        let id = QueueId { bounce: rays.id.bounce + 1, ..rays.id };
        let (next, next_ns) = self.compact(gpu, kernels, queues, &self.next, rays, id)?;
        Ok((Shaded { next, shadow }, shade_ns + shadow_ns + next_ns))
    }

    /// The candidates that live, as a queue.
    fn compact(
        &self,
        gpu: &Gpu,
        kernels: &Kernels,
        queues: &mut Queues,
        candidates: &Candidates,
        rays: &GpuRays,
        id: QueueId,
    ) -> Result<(GpuRays, u64)> {
        let scanned = self.scan.run(gpu, &candidates.directions, &self.places, rays.count)?;
        let live = queues.queue(gpu, id, scanned.total as usize)?;
        let from = [candidates.directions.binding(), self.places.binding()];
        let [live_origins, live_directions] = live.rays.bindings();
        let ray = [self.origins.binding(), live_origins, live_directions];
        let live_paths = live.paths()?;
        let path = [
            candidates.states.binding(),
            rays.paths()?.ids.binding(),
            live_paths.states.binding(),
            live_paths.ids.binding(),
        ];
        let [move_rays, move_paths] = &kernels.compact;
        let ray = move_rays.bind(gpu, &[&from[..], &ray].concat(), rays.count)?;
        let path = move_paths.bind(gpu, &[&from[..], &path].concat(), rays.count)?;
        let mut run = gpu.stage("compact");
        run.for_items(&[ray, path], ITEMS);
        Ok((live, scanned.elapsed_ns + run.finish()?))
    }
}
