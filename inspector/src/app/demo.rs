//! Records the demo by running the `recorder` program, in the background.

use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Instant;

use formats::folder::partial_of;
use formats::reader::Dump;

/// The program as the system calls it.
fn program_name() -> OsString {
    format!("recorder{}", std::env::consts::EXE_SUFFIX).into()
}

/// The `recorder` program: beside this one, or else where the system looks for programs.
pub fn find_recorder() -> Option<PathBuf> {
    let own = std::env::current_exe().ok();
    let beside = own.as_deref().and_then(Path::parent).map(Path::to_owned);
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let folders = beside.into_iter().chain(std::env::split_paths(&paths).collect::<Vec<_>>());
    folders.map(|folder| folder.join(program_name())).find(|program| program.is_file())
}

/// A recording of the demo.
pub struct Demo {
    program: Option<PathBuf>,
    /// The folder that demo.raydump is put into.
    pub(super) folder: String,
    running: Option<Running>,
    /// What the program said, the latest at the end.
    pub(super) log: Vec<String>,
}

struct Running {
    child: Child,
    lines: Receiver<String>,
    recording: PathBuf,
    start: Instant,
}

/// What there is to say of it.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum News {
    Nothing,
    /// The recording is finished.
    Recorded(PathBuf),
    Failed(String),
}

impl Demo {
    /// With this program, if there is one.
    pub fn with(program: Option<PathBuf>) -> Self {
        let folder = std::env::current_dir().unwrap_or_default().display().to_string();
        Self { program, folder, running: None, log: Vec::new() }
    }

    /// Puts the recording into another folder.
    pub fn into_folder(mut self, folder: &Path) -> Self {
        self.folder = folder.display().to_string();
        self
    }

    /// Whether there is a program to run.
    pub fn has_program(&self) -> bool {
        self.program.is_some()
    }

    /// Whether it is being recorded.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Starts to record. `wake` is called whenever the program says something, and at its end.
    pub(super) fn start(&mut self, wake: impl Fn() + Clone + Send + 'static) -> Result<(), String> {
        let program = self.program.as_ref().ok_or("there is no recorder program")?;
        let folder = PathBuf::from(self.folder.trim());
        std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let mut command = Command::new(program);
        command.arg("demo").arg("--out").arg(&folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| format!("{}: {error}", program.display()))?;
        let (sender, lines) = channel();
        if let Some(errors) = child.stderr.take() {
            listen(errors, sender.clone(), wake.clone());
        }
        if let Some(output) = child.stdout.take() {
            listen(output, sender, wake);
        }
        self.log = vec![format!("{} demo --out {}", program.display(), folder.display())];
        let recording = folder.join("demo.raydump");
        self.running = Some(Running { child, lines, recording, start: Instant::now() });
        Ok(())
    }

    /// How far it is, by what is written: the program shows its own bar in a terminal alone.
    pub(super) fn progress(&self) -> Option<String> {
        let running = self.running.as_ref()?;
        let seconds = running.start.elapsed().as_secs();
        let partial = Dump::open(&partial_of(&running.recording)).ok();
        let Some(last) = partial.as_ref().and_then(|dump| dump.manifest().queues.last()) else {
            return Some(format!("{seconds} s: preparing the scene, or tracing the first rays"));
        };
        Some(format!("{seconds} s: recorded up to {}", last.id))
    }

    pub(super) fn cancel(&mut self) {
        if let Some(mut running) = self.running.take() {
            // It may have ended by itself just now; then there is nothing to end.
            let _ = running.child.kill();
            let _ = running.child.wait();
            self.log.push("cancelled; what it has written is demo.raydump.partial".to_owned());
        }
    }

    /// Takes what the program has said, and whether it has ended.
    pub(super) fn news(&mut self) -> News {
        let Some(running) = &mut self.running else { return News::Nothing };
        self.log.extend(running.lines.try_iter());
        match running.child.try_wait() {
            Ok(None) => News::Nothing,
            Ok(Some(status)) => {
                self.log.extend(running.lines.iter());
                let recording = running.recording.clone();
                self.running = None;
                if status.success() {
                    return News::Recorded(recording);
                }
                let last = self.log.last().cloned().unwrap_or_default();
                News::Failed(format!("the recorder ended with {status}: {last}"))
            }
            Err(error) => {
                self.running = None;
                News::Failed(error.to_string())
            }
        }
    }
}

impl Drop for Demo {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Sends each line on.
fn listen(stream: impl Read + Send + 'static, sender: Sender<String>, wake: impl Fn() + Send + 'static) {
    thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            // A bar that is drawn over itself: its last state alone.
            let line = line.rsplit('\r').next().unwrap_or_default().trim_end().to_owned();
            if sender.send(line).is_err() {
                return;
            }
            wake();
        }
        drop(sender);
        wake();
    });
}
