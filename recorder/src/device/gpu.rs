//! One adapter, opened, and its errors as `Err` of the call that ran.

use std::panic::AssertUnwindSafe;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::ThreadId;

use super::adapter::choose;
use super::timing::Timestamps;
use super::{AdapterDescription, AdapterRequest, GpuError, Rounding, limits};

/// A device that is open, with the queue that work is sent to. Clones are the same device.
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: AdapterDescription,
    faults: Arc<Mutex<Faults>>,
    /// Those that no run holds.
    timestamps: Arc<Mutex<Vec<Timestamps>>>,
    rounding: Rounding,
}

/// What wgpu reported outside of any return value, until the call that caused it picks it up.
#[derive(Debug, Default)]
struct Faults {
    /// Errors, with the thread whose call raised them: wgpu reports on the calling thread.
    errors: Vec<(ThreadId, wgpu::Error)>,
    /// Why the device was lost; stays for good.
    lost: Option<String>,
}

impl Gpu {
    /// Opens an adapter with all of its own limits but one, [`limits::STORAGE_BUFFERS`], and the features
    /// that the stages use.
    ///
    /// # Errors
    /// When there is no such adapter, or it cannot be opened.
    pub fn open(request: &AdapterRequest) -> Result<Self, GpuError> {
        Self::open_adapter(&choose(request)?, wgpu::Features::empty())
    }

    /// As [`Gpu::open`], with traversal by the driver (`ray-query`).
    ///
    /// # Errors
    /// As [`Gpu::open`], and [`GpuError::Unfit`] where the adapter has no ray query.
    pub fn open_with_ray_query(request: &AdapterRequest) -> Result<Self, GpuError> {
        let adapter = choose(request)?;
        let description = AdapterDescription::of(&adapter);
        if !description.ray_query {
            let lack = "offers no ray query; use --trace cwbvh or --trace bvh2".to_owned();
            return Err(GpuError::Unfit { adapter: description.title(), lack });
        }
        Self::open_adapter(&adapter, wgpu::Features::EXPERIMENTAL_RAY_QUERY)
    }

    /// Opens this very adapter with `extra` features, which it must offer.
    pub(crate) fn open_adapter(adapter: &wgpu::Adapter, extra: wgpu::Features) -> Result<Self, GpuError> {
        let description = AdapterDescription::of(adapter);
        if !adapter.features().contains(wgpu::Features::IMMEDIATES) {
            let lack =
                "offers no immediate data (push constants); use another adapter or --backend cpu".to_owned();
            return Err(GpuError::Unfit { adapter: description.title(), lack });
        }
        let optional = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::SUBGROUP;
        let features = wgpu::Features::IMMEDIATES | extra | (adapter.features() & optional);
        let mut limits = adapter.limits();
        limits::check(&description, &limits)?;
        limits.max_storage_buffers_per_shader_stage = limits::STORAGE_BUFFERS;
        let experimental = if extra.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY) {
            // SAFETY: ray query is used by our own kernels alone, which keep to its call order.
            unsafe { wgpu::ExperimentalFeatures::enabled() }
        } else {
            wgpu::ExperimentalFeatures::disabled()
        };
        let opening = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("rayscope"),
            required_features: features,
            required_limits: limits,
            experimental_features: experimental,
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(opening)
            .map_err(|source| GpuError::Open { adapter: description.title(), source })?;
        let faults = Arc::new(Mutex::new(Faults::default()));
        listen(&device, &faults);
        Ok(Self {
            device,
            queue,
            adapter: description,
            faults,
            timestamps: Arc::default(),
            rounding: Rounding::UNKNOWN,
        })
    }

    /// wgpu's device, for what has no helper here. Follow up with [`Gpu::check`].
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// wgpu's queue, for what has no helper here. Follow up with [`Gpu::check`].
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// What was opened.
    pub fn adapter(&self) -> &AdapterDescription {
        &self.adapter
    }

    /// The same device, known to round so: its kernels have the guards that it needs, and no others.
    #[must_use]
    pub fn with_rounding(self, rounding: Rounding) -> Self {
        Self { rounding, ..self }
    }

    /// How it is thought to round.
    pub fn rounding(&self) -> Rounding {
        self.rounding
    }

    /// Whether the device was opened with these features.
    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// Turns what wgpu reported on this thread since the last check into an error.
    /// `running` says what was being done, as in "compiling sort::scatter".
    ///
    /// # Errors
    /// [`GpuError::Lost`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn check(&self, running: &str) -> Result<(), GpuError> {
        let errors = self.take_errors();
        if !errors.is_empty() {
            // What follows from a lost device is reported as "invalid"; only a poll says why.
            let _ = self.poll(wgpu::PollType::Poll);
        }
        let faults = lock(&self.faults);
        if let Some(reason) = &faults.lost {
            return Err(GpuError::Lost {
                adapter: self.adapter.title(),
                running: running.to_owned(),
                reason: reason.clone(),
            });
        }
        // The first error is the cause; those after it mostly follow from it.
        match errors.into_iter().next() {
            None => Ok(()),
            Some(wgpu::Error::OutOfMemory { .. }) => {
                Err(GpuError::OutOfMemory { adapter: self.adapter.title(), running: running.to_owned() })
            }
            Some(error) => Err(self.refused(running, error)),
        }
    }

    /// Sends commands to the device without waiting for them.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn submit(
        &self,
        running: &str,
        commands: wgpu::CommandBuffer,
    ) -> Result<wgpu::SubmissionIndex, GpuError> {
        let submission = self.queue.submit([commands]);
        self.check(running)?;
        Ok(submission)
    }

    /// Waits until the device has done what was submitted, up to `submission` if one is given.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn wait(&self, running: &str, submission: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let wait = wgpu::PollType::Wait { submission_index: submission, timeout: None };
        let waited = self.poll(wait);
        self.check(running)?;
        waited.map_err(|description| self.refused(running, description))
    }

    /// Timestamps for a run, to be kept after it.
    pub(super) fn take_timestamps(&self) -> Result<Timestamps, GpuError> {
        let free = lock(&self.timestamps).pop();
        free.map_or_else(|| Timestamps::new(self), Ok)
    }

    /// Keeps timestamps for the next run.
    pub(super) fn keep_timestamps(&self, timestamps: Timestamps) {
        lock(&self.timestamps).push(timestamps);
    }

    /// A call that wgpu refused, in its words.
    pub(super) fn refused(&self, running: &str, description: impl ToString) -> GpuError {
        let description = description.to_string();
        GpuError::Refused { adapter: self.adapter.title(), running: running.to_owned(), description }
    }

    /// Takes the errors that calls on this thread have raised.
    fn take_errors(&self) -> Vec<wgpu::Error> {
        let here = std::thread::current().id();
        let mut faults = lock(&self.faults);
        let mine = faults.errors.extract_if(.., |(thread, _)| *thread == here);
        mine.map(|(_, error)| error).collect()
    }

    /// Polls the device; `Err` says in words what went wrong.
    fn poll(&self, poll: wgpu::PollType) -> Result<(), String> {
        // wgpu panics when it finds the device lost; nothing of ours is left half-changed by that.
        match std::panic::catch_unwind(AssertUnwindSafe(|| self.device.poll(poll))) {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(error.to_string()),
            Err(_) => Err("the wait for the device broke off".to_owned()),
        }
    }
}

/// Collects what wgpu would otherwise panic about.
fn listen(device: &wgpu::Device, faults: &Arc<Mutex<Faults>>) {
    let errors = Arc::clone(faults);
    device.on_uncaptured_error(Arc::new(move |error| {
        lock(&errors).errors.push((std::thread::current().id(), error));
    }));
    let lost = Arc::clone(faults);
    device.set_device_lost_callback(move |reason, message| {
        lock(&lost).lost.get_or_insert(format!("{reason:?} {message}").trim().to_owned());
    });
}

/// The lock, also after a panic elsewhere: what is in there is only ever added or taken whole.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::{AdapterRequest, Gpu, lock};
    use crate::device::{GpuError, skipped, test_gpu};

    #[test]
    fn ray_query_is_opened_where_it_is_offered_and_refused_elsewhere() {
        match Gpu::open_with_ray_query(&AdapterRequest::Any) {
            Ok(gpu) => assert!(gpu.has(wgpu::Features::EXPERIMENTAL_RAY_QUERY)),
            Err(error) => {
                assert!(!test_gpu().adapter().ray_query, "{error}");
                assert!(matches!(error, GpuError::Unfit { .. }), "{error}");
                skipped("opening ray queries", "the adapter has none");
            }
        }
    }

    #[test]
    fn what_wgpu_refuses_is_an_error_of_the_call_and_of_no_later_one() {
        let gpu = Gpu::open(&AdapterRequest::Any).unwrap();
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE;
        let broken = wgpu::BufferDescriptor {
            label: Some("test::broken"),
            size: 16,
            usage,
            mapped_at_creation: false,
        };
        let _buffer = gpu.device().create_buffer(&broken);
        let elsewhere = std::thread::scope(|scope| scope.spawn(|| gpu.check("b")).join().unwrap());
        assert!(elsewhere.is_ok(), "another thread's call is blamed: {elsewhere:?}");
        let error = gpu.check("making a broken buffer").unwrap_err();
        assert!(error.to_string().contains("making a broken buffer"), "{error}");
        gpu.check("the next call").unwrap();
    }

    #[test]
    fn a_lost_device_is_an_error_with_what_was_being_run() {
        let gpu = Gpu::open(&AdapterRequest::Any).unwrap();
        let array = gpu.array::<u32>("test::array", 4).unwrap();
        gpu.device().destroy();
        let error = gpu.read_vec(&array).unwrap_err();
        assert!(matches!(error, GpuError::Lost { .. }), "{error}");
        assert!(error.to_string().contains("reading test::array"), "{error}");
    }

    /// As wgpu reports it: no driver here runs out of memory before the system does.
    #[test]
    fn an_array_that_memory_has_no_room_for_is_refused_with_its_name() {
        let gpu = Gpu::open(&AdapterRequest::Any).unwrap();
        let full = wgpu::Error::OutOfMemory { source: "the driver's words".into() };
        lock(&gpu.faults).errors.push((std::thread::current().id(), full));
        let error = gpu.array::<u32>("test::filler", 4).unwrap_err();
        assert!(matches!(error, GpuError::OutOfMemory { .. }), "{error}");
        assert!(error.to_string().contains("allocating test::filler"), "{error}");
    }

    #[test]
    fn an_array_beyond_the_limits_is_refused_with_the_limit() {
        let gpu = test_gpu();
        let limit = gpu.adapter().limits.storage_binding_bytes;
        let error = gpu.array::<u32>("test::huge", limit as usize / 4 + 1).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("test::huge") && text.contains(&limit.to_string()), "{text}");
    }
}
