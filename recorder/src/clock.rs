//! The clock: how long a verb took, and what else the machine did meanwhile.
//!
//! What stands inside a timed section writes to memory that was there and was touched before, and nothing of
//! this program runs beside it: see ARCHITECTURE, "The clock's contract".

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread::yield_now;
use std::time::{Duration, Instant};

use rayon::prelude::*;

/// How long a section waits for the threads of its pool to be awake.
const ROLL_CALL: Duration = Duration::from_millis(1);

/// One time, and what disturbed it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sample {
    /// Nanoseconds.
    pub elapsed_ns: u64,
    /// Pages that this process touched for the first time meanwhile; 0 where the system does not tell.
    pub page_faults: u64,
    /// Whether threads of this process were made to wait for others, or the machine for its host, as far as
    /// the system tells, or did other work when it began.
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

    /// Takes the time of `work`. The threads of the current pool are awake when it begins: a thread that sleeps
    /// wakes tens of microseconds late, and whether it sleeps depends on what came before.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let mut before = self.machine.read(Instant::now());
        let all_are_awake = wake_threads();
        // Threads that wait for each other make way, which counts as being put aside.
        before.switches = self.machine.switches();
        let start = Instant::now();
        let value = work();
        let elapsed_ns = start.elapsed().as_nanos() as u64;
        self.last = before.sample(&self.machine.read(Instant::now()), elapsed_ns);
        self.last.is_disturbed |= !all_are_awake;
        value
    }

    /// Keeps the time that `work` took on another clock, in nanoseconds.
    ///
    /// # Errors
    /// Any of `work`.
    pub fn keep<E>(&mut self, work: impl FnOnce() -> Result<u64, E>) -> Result<(), E> {
        let before = self.machine.read(Instant::now());
        let elapsed_ns = work()?;
        self.last = before.sample(&self.machine.read(Instant::now()), elapsed_ns);
        Ok(())
    }
}

/// Wakes the threads of the current pool; whether all came, or one of them has other work.
fn wake_threads() -> bool {
    let (threads, awake, start) = (rayon::current_num_threads(), AtomicUsize::new(0), Instant::now());
    // Each waits for the others, so that none takes the part of two. This allocates nothing.
    (0..threads).into_par_iter().with_max_len(1).all(|_| {
        awake.fetch_add(1, Relaxed);
        while awake.load(Relaxed) < threads && start.elapsed() < ROLL_CALL {
            yield_now();
        }
        awake.load(Relaxed) == threads
    })
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
    use std::time::{Duration, Instant};

    use nix::sys::resource::{Usage, UsageWho, getrusage};

    use super::Counts;

    /// How long one tick is.
    const TICK: Duration = Duration::from_millis(10);

    #[derive(Debug)]
    pub(super) struct Counters {
        is_read: bool,
        /// `/proc/stat`, whose first line says for all processors together how ticks were spent. It is read once a
        /// tick at most: that takes longer than tracing a short queue, and leaves traces in the caches that one feels. So
        /// of sections shorter than a tick the one that meets the next reading bears what was stolen since the last.
        pub(super) ticks: Option<File>,
        /// What was stolen, and when that was read.
        stolen: Option<(Instant, u64)>,
    }

    impl Counters {
        pub(super) fn open() -> Self {
            Self { is_read: true, ticks: File::open("/proc/stat").ok(), stolen: None }
        }

        pub(super) fn none() -> Self {
            Self { is_read: false, ticks: None, stolen: None }
        }

        fn usage(&self) -> Option<Usage> {
            self.is_read.then(|| getrusage(UsageWho::RUSAGE_SELF).ok()).flatten()
        }

        pub(super) fn switches(&self) -> u64 {
            self.usage().map_or(0, |usage| usage.involuntary_context_switches() as u64)
        }

        pub(super) fn read(&mut self, now: Instant) -> Counts {
            let Some(usage) = self.usage() else { return Counts::default() };
            Counts {
                page_faults: usage.minor_page_faults() as u64,
                switches: usage.involuntary_context_switches() as u64,
                stolen: self.stolen(now),
            }
        }

        fn stolen(&mut self, now: Instant) -> u64 {
            match self.stolen {
                Some((read, stolen)) if now < read + TICK => stolen,
                _ => self.stolen.insert((now, self.read_stolen().unwrap_or(0))).1,
            }
        }

        /// The eighth number of the first line.
        fn read_stolen(&self) -> Option<u64> {
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
    use std::time::Instant;

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

        pub(super) fn read(&mut self, _: Instant) -> Counts {
            Counts::default()
        }

        pub(super) fn switches(&self) -> u64 {
            0
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn what_the_host_took_is_read_once_a_tick_at_most() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stat");
        let mut counters = machine::Counters::open();
        let start = Instant::now();
        let mut stolen = |ticks, after| {
            std::fs::write(&path, format!("cpu  1 2 3 4 5 6 7 {ticks} 8 9\ncpu0 0\n")).unwrap();
            counters.ticks = Some(std::fs::File::open(&path).unwrap());
            counters.read(start + Duration::from_millis(after)).stolen
        };
        assert_eq!(
            [stolen(40, 0), stolen(41, 9), stolen(42, 10), stolen(43, 11), stolen(44, 30)],
            [40, 40, 42, 42, 44]
        );
    }

    #[test]
    fn a_section_begins_when_all_threads_are_awake() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let is_disturbed = || {
            let mut clock = Clock::of_processor();
            pool.install(|| clock.time(|| ()));
            clock.last().is_disturbed
        };
        let (start, rest) = (Instant::now(), Duration::from_secs(60));
        while is_disturbed() {
            assert!(start.elapsed() < rest, "both have nothing else to do");
        }
        let [(began, has_begun), (end, ends)] = [channel(), channel()];
        pool.spawn(move || {
            began.send(()).unwrap();
            ends.recv_timeout(rest).unwrap();
        });
        has_begun.recv_timeout(rest).unwrap();
        assert!((0..10).all(|_| is_disturbed()), "one of them has other work");
        end.send(()).unwrap();
    }
}
