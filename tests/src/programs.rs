//! The programs `recorder` and `inspector`, run as a user runs them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// Exit code of a command that failed.
pub const FAILED: i32 = 1;
/// Exit code of a command line that makes no sense.
pub const USAGE: i32 = 2;

struct Programs {
    recorder: PathBuf,
    inspector: PathBuf,
    /// Where the programs keep what they cache, so that a test starts from nothing and leaves nothing.
    cache: TempDir,
}

/// Builds the programs once a test process: in this process's profile, with the cargo that runs it.
fn programs() -> &'static Programs {
    static PROGRAMS: OnceLock<Programs> = OnceLock::new();
    PROGRAMS.get_or_init(|| {
        let mut build = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        // With a test of the whole workspace, which is there already: without one, dependencies that tests share have
        // fewer features than in `cargo test`, and all that stands above them is compiled once more.
        build.args([
            "build",
            "--workspace",
            "--bins",
            "--test",
            "sources",
            "--quiet",
            "--message-format=json",
        ]);
        if !cfg!(debug_assertions) {
            build.arg("--release");
        }
        let output = build.current_dir(crate::sources::root()).stderr(Stdio::inherit()).output();
        let output = output.expect("cargo starts");
        assert!(output.status.success(), "cargo build --bins failed: see its messages above");
        let messages = String::from_utf8(output.stdout).expect("cargo's messages are UTF-8");
        Programs {
            recorder: executable(&messages, "recorder"),
            inspector: executable(&messages, "inspector"),
            cache: tempfile::tempdir().expect("a temporary folder can be made"),
        }
    })
}

/// The path of the program `name` in cargo's messages, one JSON object a line.
fn executable(messages: &str, name: &str) -> PathBuf {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .find(|message| message["target"]["name"] == name && message["executable"].is_string())
        .and_then(|message| message["executable"].as_str().map(PathBuf::from))
        .unwrap_or_else(|| panic!("cargo built no program called {name}"))
}

/// What a finished program left behind.
#[derive(Debug)]
pub struct Outcome {
    /// What was run, for messages.
    pub command: String,
    /// Exit code; `None` if a signal ended the program.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Outcome {
    /// The same, after checking that the exit code is 0.
    ///
    /// # Panics
    /// If it is not, with everything that the program said.
    pub fn succeeded(self) -> Self {
        assert_eq!(
            self.code,
            Some(0),
            "{} failed\nstdout: {}\nstderr: {}",
            self.command,
            self.stdout,
            self.stderr
        );
        self
    }

    /// Standard output in one line: what is longer than a terminal is wide is broken anywhere.
    pub fn in_a_line(&self) -> String {
        self.stdout.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Standard output as JSON.
    ///
    /// # Panics
    /// If it is not one JSON value.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| {
            panic!("{}: standard output is no JSON ({error}): {}", self.command, self.stdout)
        })
    }

    /// Checks that the program failed with `code` and said one clear sentence that has all of `words` in it.
    ///
    /// # Panics
    /// If the exit code is another, it panicked, or its last line lacks a word.
    pub fn failed_with(&self, code: i32, words: &[&str]) {
        let Self { command, stderr, .. } = self;
        assert_eq!(
            self.code,
            Some(code),
            "exit code of {command}\nstdout: {}\nstderr: {stderr}",
            self.stdout
        );
        assert!(!stderr.contains("panicked at"), "{command} panicked: {stderr}");
        for word in words {
            assert!(
                stderr.to_lowercase().contains(&word.to_lowercase()),
                "{command} does not mention {word:?}: {stderr}"
            );
        }
        // A usage error is followed by how to use it; any other is one line.
        let lines = stderr.lines().filter(|line| line.to_lowercase().contains("error")).count();
        assert!(lines <= 1, "{command} says {lines} lines of errors, expected one: {stderr}");
    }
}

/// Which program to run.
#[derive(Clone, Copy, Debug)]
pub enum Program {
    /// `recorder`
    Recorder,
    /// `inspector`
    Inspector,
}

impl Program {
    /// Its executable.
    pub fn path(self) -> &'static Path {
        match self {
            Self::Recorder => &programs().recorder,
            Self::Inspector => &programs().inspector,
        }
    }

    /// The program with these arguments, not started yet: without standard input, with a cache of its own.
    pub fn command<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(self, arguments: I) -> Command {
        let mut command = Command::new(self.path());
        command.args(arguments).stdin(Stdio::null()).env("XDG_CACHE_HOME", programs().cache.path());
        command
    }

    /// Runs the program with the words of `line` as arguments, in `folder`.
    pub fn run(self, folder: &Path, line: &str) -> Outcome {
        finish(self.command(line.split_whitespace()).current_dir(folder))
    }
}

/// The Python that `PYTHON` names, as `tests/run` does, else the system's.
pub fn python() -> Command {
    Command::new(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()))
}

/// Waits until something is so.
///
/// # Panics
/// If it is not after a minute.
pub fn until(what: &str, is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60), "not so after a minute: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Runs `command` to its end.
///
/// # Panics
/// If it cannot be started or says something that is not UTF-8.
pub fn finish(command: &mut Command) -> Outcome {
    let described = format!("{command:?}");
    let output = command.output().unwrap_or_else(|error| panic!("cannot start {described}: {error}"));
    Outcome {
        command: described,
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("standard output is UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("standard error is UTF-8"),
    }
}
