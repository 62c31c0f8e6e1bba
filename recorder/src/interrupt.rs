//! SIGINT and SIGTERM: one sentence on what is left and what to do with it, then the end that was asked for.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use crate::output::say;

/// What is left if the program is ended, and what to do with it.
static LEFT: Mutex<Option<String>> = Mutex::new(None);

/// Says which folder is left if the program is ended from now on; `None` when there is none any more.
pub(crate) fn leaves(partial: Option<PathBuf>) {
    let sentence = |partial: PathBuf| {
        let partial = partial.display();
        format!("what was complete is in {partial}: `inspector recover {partial}` makes it a recording")
    };
    say_at_end(partial.map(sentence));
}

/// What is said if the program is ended from now on.
pub(crate) fn say_at_end(sentence: Option<String>) {
    *LEFT.lock().unwrap_or_else(PoisonError::into_inner) = sentence;
}

/// Names the process with which a child of this program is to end, for [`end_with_parent`].
pub(crate) const PARENT_VARIABLE: &str = "RAYSCOPE_PARENT";

/// Has the system end this process with the one that started it, if that asked for it. On Linux alone; elsewhere a
/// child whose parent was killed goes on to its end.
pub(crate) fn end_with_parent() {
    #[cfg(target_os = "linux")]
    if let Some(parent) = std::env::var(PARENT_VARIABLE).ok().and_then(|parent| parent.parse::<u32>().ok()) {
        let told = nix::sys::prctl::set_pdeathsig(nix::sys::signal::Signal::SIGTERM);
        // It may have ended before the system was told.
        if told.is_ok() && std::os::unix::process::parent_id() != parent {
            std::process::exit(1);
        }
    }
}

/// Starts the thread that waits for signals, but for those that whoever started this program has it ignore, as
/// scripts do for what they run in the background. On other systems than Unix the system ends the program as ever.
///
/// # Errors
/// If the system has no thread left, or no handlers.
pub(crate) fn listen() -> io::Result<()> {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGINT, SIGTERM};
        let heard = [SIGINT, SIGTERM].into_iter().filter(|&signal| !is_ignored(signal));
        let mut signals = signal_hook::iterator::Signals::new(heard)?;
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            for signal in signals.forever() {
                tell();
                // As if there were no handler, so that a shell sees what ended the program.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        })?;
    }
    Ok(())
}

/// Whether this program was started with the signal ignored. Said by Linux alone; elsewhere no.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(unix)]
fn tell() {
    // Below the progress bar.
    let start = if io::stderr().is_terminal() { "\n" } else { "" };
    let left = LEFT.lock().unwrap_or_else(PoisonError::into_inner);
    let left = left.as_deref().unwrap_or("no recording was being written");
    say(format_args!("{start}interrupted; {left}"));
}
