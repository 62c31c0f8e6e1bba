//! The clock: how long a verb took, and what else the machine did meanwhile.
//!
//! What stands inside a timed section writes to memory that was there and was touched before, and nothing of
//! this program runs beside it: see ARCHITECTURE, "The clock's contract".

use std::time::Instant;

/// One time, and what disturbed it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sample {
    /// Nanoseconds.
    pub elapsed_ns: u64,
    /// Pages that this process touched for the first time meanwhile; 0 where the system does not tell.
    pub page_faults: u64,
    /// Whether threads of this process were made to wait for others, or the machine for its host, as far as
    /// the system tells.
    pub is_disturbed: bool,
}

/// Takes times, and keeps the last one.
#[derive(Debug)]
pub struct Clock {
    machine: machine::Counters,
    last: Sample,
}

impl Clock {
    /// A clock for what runs on the processor, where the rest of the machine is in its way.
    pub fn of_processor() -> Self {
        Self { machine: machine::Counters::open(), last: Sample::default() }
    }

    /// A clock for what runs on a device of its own. Software adapters count as such: their threads stand in
    /// each other's way, and the system cannot tell those from others.
    pub fn of_device() -> Self {
        Self { machine: machine::Counters::none(), last: Sample::default() }
    }

    /// The last sample.
    pub fn last(&self) -> Sample {
        self.last
    }

    /// Takes the time of `work`.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let before = self.machine.read();
        let start = Instant::now();
        let value = work();
        let elapsed_ns = start.elapsed().as_nanos() as u64;
        self.last = before.sample(&self.machine.read(), elapsed_ns);
        value
    }

    /// Keeps the time that `work` took on another clock, in nanoseconds.
    ///
    /// # Errors
    /// Any of `work`.
    pub fn keep<E>(&mut self, work: impl FnOnce() -> Result<u64, E>) -> Result<(), E> {
        let before = self.machine.read();
        let elapsed_ns = work()?;
        self.last = before.sample(&self.machine.read(), elapsed_ns);
        Ok(())
    }
}

/// What the system has counted up to a moment.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    page_faults: u64,
    /// How often a thread of this process was put aside for others.
    switches: u64,
    /// Time that the host took from the machine, in ticks of the system.
    stolen: u64,
}

impl Counts {
    fn sample(&self, after: &Self, elapsed_ns: u64) -> Sample {
        let threads = rayon::current_num_threads() as u64;
        let is_disturbed = after.stolen > self.stolen || after.switches > self.switches + threads;
        Sample { elapsed_ns, page_faults: after.page_faults - self.page_faults, is_disturbed }
    }
}

/// The counters of Linux.
#[cfg(target_os = "linux")]
mod machine {
    use std::fs::File;
    use std::os::unix::fs::FileExt;

    use nix::sys::resource::{UsageWho, getrusage};

    use super::Counts;

    #[derive(Debug)]
    pub(super) struct Counters {
        is_read: bool,
        /// `/proc/stat`, whose first line says for all processors together how ticks were spent.
        ticks: Option<File>,
    }

    impl Counters {
        pub(super) fn open() -> Self {
            Self { is_read: true, ticks: File::open("/proc/stat").ok() }
        }

        pub(super) fn none() -> Self {
            Self { is_read: false, ticks: None }
        }

        pub(super) fn read(&self) -> Counts {
            let usage = self.is_read.then(|| getrusage(UsageWho::RUSAGE_SELF).ok()).flatten();
            let Some(usage) = usage else { return Counts::default() };
            Counts {
                page_faults: usage.minor_page_faults() as u64,
                switches: usage.involuntary_context_switches() as u64,
                stolen: self.stolen().unwrap_or(0),
            }
        }

        /// The eighth number of the first line.
        fn stolen(&self) -> Option<u64> {
            let mut bytes = [0; 256];
            let count = self.ticks.as_ref()?.read_at(&mut bytes, 0).ok()?;
            let line = std::str::from_utf8(&bytes[..count]).ok()?.lines().next()?;
            line.split_whitespace().nth(8)?.parse().ok()
        }
    }
}

/// Systems that are not asked.
#[cfg(not(target_os = "linux"))]
mod machine {
    use super::Counts;

    #[derive(Debug)]
    pub(super) struct Counters;

    impl Counters {
        pub(super) fn open() -> Self {
            Self
        }

        pub(super) fn none() -> Self {
            Self
        }

        pub(super) fn read(&self) -> Counts {
            Counts::default()
        }
    }
}
