//! A command of a job as a process of its own, so that nothing that happens to it happens to the study.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};

use formats::text::one_line;

use crate::interrupt::PARENT_VARIABLE;

/// Most characters of a sentence about a failure.
const SENTENCE_CHARACTERS: usize = 1000;
/// What Rust's runtime ends a process with that panicked.
const PANICKED: i32 = 101;

/// Runs `program` with `words` in `folder`, and copies what it says to `log`. The child holds `lock` as long as it
/// lives, also where this process was killed; on Linux it then ends, too.
///
/// # Errors
/// In a sentence, if it cannot be started or does not end well.
pub fn run<S: AsRef<OsStr>>(
    program: &Path,
    words: &[S],
    folder: &Path,
    lock: &File,
    log: &mut dyn Write,
) -> Result<(), String> {
    let start = || -> io::Result<_> {
        let (said, writer) = io::pipe()?;
        let mut command = Command::new(program);
        command.args(words).current_dir(folder).env(PARENT_VARIABLE, std::process::id().to_string());
        command.stdin(Stdio::from(lock.try_clone()?)).stdout(writer.try_clone()?).stderr(writer);
        // The command, and with it our ends of the pipe, is dropped here.
        command.spawn().map(|child| (child, said))
    };
    let (mut child, said) = start().map_err(|error| format!("it cannot be started: {error}"))?;
    let mut last = Last::default();
    let mut said = BufReader::new(said);
    let mut line = Vec::new();
    let copied = loop {
        line.clear();
        match said.read_until(b'\n', &mut line) {
            Ok(0) => break Ok(()),
            Ok(_) => last.hear(&String::from_utf8_lossy(&line)),
            Err(error) => break Err(error),
        }
        if let Err(error) = log.write_all(&line) {
            // The child goes on; what it says is needed for the sentence.
            last.log_error.get_or_insert(error);
        }
    };
    let status = child.wait().and_then(|status| copied.map(|()| status));
    match status {
        Ok(status) if status.success() => match last.log_error {
            None => Ok(()),
            Some(error) => Err(format!("what it said cannot be written to the log: {error}")),
        },
        Ok(status) => Err(one_line(&last.sentence(status), SENTENCE_CHARACTERS)),
        Err(error) => Err(format!("how it ended is not known: {error}")),
    }
}

/// What a process said last.
#[derive(Default)]
struct Last {
    line: String,
    /// Of an error, without that word.
    error: Option<String>,
    /// Of a panic, with the line that says why.
    panic: Option<String>,
    log_error: Option<io::Error>,
}

impl Last {
    fn hear(&mut self, line: &str) {
        let line = line.trim();
        if line.is_empty() {
            return;
        }
        if self.line.contains("panicked at") {
            self.panic.get_or_insert_with(|| line.to_owned());
        }
        if let Some(error) = line.strip_prefix("error: ") {
            self.error = Some(error.to_owned());
        }
        line.clone_into(&mut self.line);
    }

    fn sentence(self, status: ExitStatus) -> String {
        #[cfg(unix)]
        if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
            let why = match signal {
                9 => " (killed: by somebody, or by the system for want of memory)",
                2 | 15 => " (interrupted)",
                _ => " (it crashed)",
            };
            return format!("it was ended by signal {signal}{why}");
        }
        match (status.code(), self.panic, self.error) {
            (Some(PANICKED), Some(panic), _) => format!("it panicked: {panic}"),
            (_, _, Some(error)) => error,
            (Some(code), ..) => format!("it ended with code {code}: {}", self.line),
            (None, ..) => format!("it ended without a code: {}", self.line),
        }
    }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    /// What a shell script comes to, and what it said.
    fn ended(script: &str) -> (Result<(), String>, String) {
        let folder = tempfile::tempdir().unwrap();
        let lock = File::create(folder.path().join("lock")).unwrap();
        let mut log = Vec::new();
        let result = run(Path::new("sh"), &["-c", script], folder.path(), &lock, &mut log);
        (result, String::from_utf8(log).unwrap())
    }

    #[test]
    fn however_a_child_ends_it_is_a_sentence() {
        assert_eq!(ended("echo table; echo word >&2"), (Ok(()), "table\nword\n".to_owned()));
        for (script, expected) in [
            ("echo 'error: the disk is full' >&2; exit 1", "the disk is full"),
            (
                "echo \"thread 'main' panicked at src/x.rs:1:2:\" >&2; echo 'index out of bounds' >&2; echo note; exit 101",
                "it panicked: index out of bounds",
            ),
            (
                "kill -KILL $$",
                "it was ended by signal 9 (killed: by somebody, or by the system for want of memory)",
            ),
            ("kill -SEGV $$", "it was ended by signal 11 (it crashed)"),
            ("echo why; exit 3", "it ended with code 3: why"),
        ] {
            assert_eq!(ended(script).0.unwrap_err(), expected, "{script}");
        }
        let (file, words) = (File::open(".").unwrap(), ["x"]);
        let missing = run(Path::new("/no/such/program"), &words, Path::new("."), &file, &mut Vec::new());
        assert!(missing.unwrap_err().starts_with("it cannot be started: "));
    }

    #[test]
    fn a_log_that_cannot_be_written_is_a_failure_and_does_not_hide_another() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::Error::other("no space"))
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let lock = File::open(".").unwrap();
        let run =
            |script| run(Path::new("sh"), &["-c", script], Path::new("."), &lock, &mut Full).unwrap_err();
        assert_eq!(run("echo table"), "what it said cannot be written to the log: no space");
        assert_eq!(run("echo 'error: a wall'; exit 1"), "a wall");
    }
}
