//! A run on a device: the loop or recorded rays, measured and written.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use formats::folder::partial_of;
use formats::manifest::{self, CalibrationRecord, End, Header, ImageDigest, Outcome, Place, Record};
use formats::ray::ORIGIN_LIMIT;
use formats::reader::Dump;
use formats::summary::Summary;
use formats::text::counted;
use formats::writer::DumpWriter;
use scenes::Scene;
use scenes::bvh::Source;
use sha2::{Digest, Sha256};

use super::{header, scene_arrays};
use crate::auto::Auto;
use crate::backends::cpu::CpuBackend;
use crate::backends::gpu::GpuBackend;
use crate::backends::{Backend, RecordedRays, picture};
use crate::cache_model::CacheModel;
use crate::calibrate;
use crate::capture::Capture;
use crate::foreign::Foreign;
use crate::interrupt;
use crate::machine::Device;
use crate::measure::{Measured, Subject};
use crate::observer::{Plan, Recorder};
use crate::options::RecordOptions;
use crate::progress::Progress;
use crate::stages::setup::Setup;
use crate::stages::trace::TraceKernel;
use crate::stages::trace::cpu::CpuTracer;
use crate::wavefront;

/// A finished recording.
pub struct Recorded {
    /// The dump.
    pub path: PathBuf,
    /// Scene, adapter and settings in a line each.
    pub headline: Vec<String>,
    /// Things the user should know.
    pub notices: Vec<String>,
}

impl Recorded {
    /// What the dump says, for programs.
    ///
    /// # Errors
    /// If the dump cannot be read back.
    pub fn summary(&self) -> Result<Summary> {
        Ok(Summary::new(&self.path, Dump::open(&self.path)?.manifest()))
    }
}

/// Where the rays of a run come from.
pub(crate) enum RaySource<'a> {
    /// Paths from the camera.
    Paths,
    /// Queues that were recorded or imported.
    Recorded(Vec<RecordedRays<'a>>),
}

impl RaySource<'_> {
    /// How often each ray is traced beyond the first time, pass by pass as they run: of a calibration, where there is
    /// one, and of `passes`, of which the last is measured. Queues that were recorded are of as many as were kept, and
    /// the last of them is the calibration's, too.
    fn traces(&self, passes: u32, calibration: &[u64], measured: u64) -> Vec<u64> {
        let (passes, calibration) = match self {
            Self::Paths => (passes as usize, calibration),
            Self::Recorded(queues) => {
                let passes: BTreeSet<u32> = queues.iter().map(|queue| queue.id.pass).collect();
                (passes.len(), &calibration[..calibration.len().min(1)])
            }
        };
        let unmeasured = (1..passes).map(|_| 0);
        calibration.iter().copied().chain(unmeasured).chain([measured]).collect()
    }
}

/// Everything of a run but the device.
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) setup: Arc<Setup>,
    pub(crate) options: &'a RecordOptions,
    /// What was asked for, or the fastest on the device.
    pub(crate) kernel: TraceKernel,
    pub(crate) header: Header,
    pub(crate) rays: RaySource<'a>,
    /// Orders that came with them.
    pub(crate) foreign: Foreign,
    /// The recording whose queues these are, if they are.
    pub(crate) recorded: Option<&'a Dump>,
    /// What `auto` chooses by; made before the run if there is nothing.
    pub(crate) calibration: Vec<CalibrationRecord>,
    pub(crate) start: Instant,
}

/// What a run left: the dump, and how many rays did not find what was recorded.
pub(crate) type Outcomes = (PathBuf, u64);

impl<'a> Run<'a> {
    /// A run of paths from the camera.
    pub(crate) fn of_paths(
        device: &Device,
        scene: &'a Scene,
        setup: Arc<Setup>,
        options: &'a RecordOptions,
        notices: Vec<String>,
        start: Instant,
    ) -> Self {
        Self {
            header: header::header(scene, &setup, options, device, notices, manifest::Source::Traced),
            kernel: device.kernel(&options.device),
            rays: RaySource::Paths,
            foreign: Foreign::default(),
            recorded: None,
            calibration: Vec::new(),
            scene,
            setup,
            options,
            start,
        }
    }

    /// Runs on a device.
    ///
    /// # Errors
    /// One sentence on what went wrong with the device or the disk.
    pub(crate) fn on(self, device: Device) -> Result<Recorded> {
        // The backend comes first: what does not fit a device is refused before anything is written.
        let kernel = self.kernel;
        let (bvh, source) = kernel.hierarchy(self.scene)?.unzip();
        let eye = self.setup.camera.eye;
        ensure!(
            eye.iter().all(|along| along.abs() <= ORIGIN_LIMIT),
            "the camera stands at {eye:?}, expected coordinates of at most {ORIGIN_LIMIT:e} either way"
        );
        let setup = Arc::clone(&self.setup);
        let tracer = || bvh.as_ref().map(|bvh| Arc::new(CpuTracer::new(self.scene, bvh).with_kernel(kernel)));
        let model = |tracer| CacheModel { tracer, l2_bytes: self.options.device.l2_kib << 10 };
        let (path, differing) = match device {
            Device::Cpu(cpu) => cpu.pool.install(|| {
                let tracer = tracer().context("threads trace a hierarchy of their own")?;
                let model = self.options.keep.caches.then(|| model(Arc::clone(&tracer)));
                self.with(&mut CpuBackend::new(setup, tracer), model)
            })?,
            Device::Gpu(gpu) => {
                let mut backend = GpuBackend::new(gpu.gpu, self.scene, bvh.as_ref(), setup, kernel)?;
                let tracer = self.options.keep.caches.then(tracer).flatten();
                self.with(&mut backend, tracer.map(model))?
            }
        };
        let headline = header::headline(&self.header, &self.setup);
        let mut notices = self.header.notices;
        if differing > 0 {
            let rays = counted(differing, "ray", "rays");
            notices.push(format!("{rays} found something else than in the recording"));
        }
        if let Some(Source::BuiltNotKept { reason }) = source {
            notices.push(format!("every run builds the hierarchy anew, since it cannot be kept: {reason}"));
        }
        Ok(Recorded { path, headline, notices })
    }

    fn plan(&self, cache_model: Option<CacheModel>) -> Plan<'_> {
        Plan {
            methods: [&self.setup.methods[..], &self.foreign.methods].concat(),
            options: self.options,
            measured: self.measured(),
            kernel_is_ours: self.kernel.is_ours(),
            cache_model,
            foreign: &self.foreign.orders,
            auto: None,
            recorded: self.recorded,
        }
    }

    /// The baseline and all that is compared with it, and the control where there is any.
    fn measured(&self) -> Measured {
        let methods = (0..self.setup.named().len()).map(Subject::Method);
        let asked = &self.options.orders;
        let unnamed = [asked.shuffled.then_some(Subject::Shuffled), asked.auto.then_some(Subject::Auto)];
        let first = self.setup.methods.len();
        let foreign = (first..first + self.foreign.methods.len()).map(Subject::Foreign);
        let compared = unnamed.into_iter().flatten().chain(methods).chain(foreign);
        let mut orders = vec![Subject::Unsorted, Subject::Control];
        orders.extend(compared);
        if orders.len() == 2 && !asked.control {
            orders.pop();
        }
        Measured { orders, repeats: self.options.repeats, seed: self.options.seed }
    }

    /// Runs on a backend that begins a picture.
    ///
    /// # Errors
    /// As [`Run::on`].
    pub(crate) fn with<B: Backend>(
        &self,
        backend: &mut B,
        cache_model: Option<CacheModel>,
    ) -> Result<Outcomes> {
        let options = self.options;
        let mut plan = self.plan(cache_model);
        let progress = self.progress();
        if options.orders.auto {
            plan.auto = Some(self.calibrated(backend, &progress)?);
        }
        let writer = DumpWriter::create(&options.out, self.header.clone(), options.force)?;
        interrupt::leaves(Some(partial_of(writer.target())));
        let mut capture = Capture::start(writer)?;
        if options.keep.scene {
            scene_arrays::write(&mut capture, self.scene)?;
        }
        if options.keep.hierarchy {
            scene_arrays::write_hierarchy(&mut capture, self.scene)?;
        }
        for method in self.setup.named().iter().chain(&self.foreign.methods) {
            capture.record(Record::Method(header::method_record(method)))?;
        }
        for calibration in plan.auto.iter().flat_map(Auto::calibration) {
            capture.record(Record::Calibration(calibration.clone()))?;
        }
        capture.drain()?;
        let mut recorder = Recorder::new(&plan, &mut capture, &progress);
        match &self.rays {
            RaySource::Paths => wavefront::run(backend, 0..options.passes, options.bounces, &mut recorder)?,
            RaySource::Recorded(queues) => wavefront::run_recorded(backend, queues, &mut recorder)?,
        }
        recorder.finish(backend)?;
        let differing = recorder.differing;
        progress.finish();
        let image = match self.rays {
            RaySource::Paths => Some(self.write_image(backend, &mut capture)?),
            RaySource::Recorded(_) => None,
        };
        let wall_ns = self.start.elapsed().as_nanos() as u64;
        let path = capture.finish(End { outcome: Outcome::Complete, image, wall_ns })?;
        interrupt::leaves(None);
        Ok((path, differing))
    }

    /// What `auto` chooses by: measured on passes after the last one, whose rays are not recorded, or on the recorded
    /// queues of the last one; then the run begins anew.
    fn calibrated<B: Backend>(&self, backend: &mut B, progress: &Progress) -> Result<Auto> {
        if !self.calibration.is_empty() {
            return Auto::new(&self.setup, self.calibration.clone());
        }
        let (pass, bounces) = (self.options.passes, self.options.bounces);
        calibrate::calibrate(backend, &self.setup, progress, |backend, calibrator| match &self.rays {
            RaySource::Paths => wavefront::run(backend, pass..pass + calibrate::PASSES, bounces, calibrator),
            RaySource::Recorded(queues) => {
                let measured: Vec<_> =
                    queues.iter().copied().filter(|queue| queue.id.pass + 1 == pass).collect();
                wavefront::run_recorded(backend, &measured, calibrator)
            }
        })
    }

    fn progress(&self) -> Progress {
        let repeats = u64::from(self.options.repeats);
        // Two rounds come before those that count; the control and the baseline are traced once in each.
        let traces = (2 + repeats) * 2 * (1 + self.setup.named().len() as u64);
        let calibration = calibrate::traces(&self.setup);
        let is_calibrated = self.options.orders.auto && self.calibration.is_empty();
        let calibration = if is_calibrated { &calibration[..] } else { &[] };
        Progress::new(self.options.bounces, self.rays.traces(self.options.passes, calibration, traces))
    }

    fn write_image<B: Backend>(&self, backend: &mut B, capture: &mut Capture) -> Result<ImageDigest> {
        let image = picture(backend, self.options.passes)?;
        let (width, height) = (self.setup.width, self.setup.height);
        let digest = Sha256::digest(bytemuck::cast_slice::<_, u8>(&image));
        if self.options.keep.image {
            capture.whole_array(Place::Image, &[height.into(), width.into(), 3], &image)?;
        }
        Ok(ImageDigest { width, height, sha256: digest.into() })
    }
}

#[cfg(test)]
mod tests {
    use formats::manifest::QueueId;
    use formats::ray::Kind;

    use super::*;

    fn recorded(passes: &[u32]) -> RaySource<'static> {
        let id = |&pass: &u32| Kind::ALL.map(|kind| QueueId { pass, bounce: 0, kind });
        let queue = |id| RecordedRays { id, rays: &[], path_ids: &[], lights: &[], lengths: None };
        RaySource::Recorded(passes.iter().flat_map(id).map(queue).collect())
    }

    #[test]
    fn as_many_passes_are_expected_as_run() {
        let paths = RaySource::Paths;
        assert_eq!(paths.traces(3, &[], 9), [0, 0, 9]);
        assert_eq!(paths.traces(3, &[5, 4], 9), [5, 4, 0, 0, 9]);
        let (all, last) = (recorded(&[0, 1, 2]), recorded(&[2]));
        assert_eq!([&all, &last].map(|rays| rays.traces(3, &[], 9)), [vec![0, 0, 9], vec![9]]);
        assert_eq!([&all, &last].map(|rays| rays.traces(3, &[5, 4], 9)), [vec![5, 0, 0, 9], vec![5, 9]]);
    }
}
