//! Hands jobs of a study to Slurm: one array, a task for each job, a node of its own for each task.

use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use formats::study::SLURM_NAME;
use formats::text::one_line;

use super::words::typed;
use crate::interrupt;

/// Most characters of what Slurm says that are shown.
const SHOWN: usize = 1000;

/// What is handed over.
pub struct Array<'a> {
    /// The plan's file.
    pub file: &'a Path,
    /// The folder whose scenes take the place of the plan's.
    pub scenes: Option<&'a Path>,
    /// Folder of the study, the same on all nodes.
    pub out: &'a Path,
    /// Numbers of the jobs, ascending; at least one.
    pub numbers: &'a [usize],
    /// Which nodes will do, in the words of `sbatch --constraint`.
    pub constraint: Option<&'a str>,
    /// Whether all tasks are to have ended before this program goes on.
    pub wait: bool,
}

impl Array<'_> {
    /// Hands the array over, calls `submitted` with its number in Slurm, and waits if that is asked for. How its tasks
    /// ended is in the study's folder.
    ///
    /// # Errors
    /// If Slurm does not take it.
    pub fn submit(&self, submitted: impl FnOnce(&str) -> Result<()>) -> Result<()> {
        let program =
            std::env::current_exe().context("cannot find this program to have it started by Slurm")?;
        let logs = self.out.join(SLURM_NAME);
        std::fs::create_dir_all(&logs)
            .with_context(|| format!("cannot make the folder {}", logs.display()))?;
        let mut command = Command::new("sbatch");
        command.args(self.words(&program)?);
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let mut child = match child {
            Err(error) if error.kind() == ErrorKind::NotFound => bail!(
                "there is no sbatch here, which hands jobs to Slurm; run this where the cluster's jobs are submitted, or without --slurm to make the jobs here"
            ),
            child => child.context("cannot start sbatch")?,
        };
        let mut line = String::new();
        if let Some(said) = child.stdout.take() {
            BufReader::new(said).read_line(&mut line).context("cannot read what sbatch says")?;
        }
        // NUMBER, or NUMBER;CLUSTER.
        let number = line.trim().split(';').next().unwrap_or_default();
        if !number.is_empty() {
            interrupt::say_at_end(Some(format!(
                "array {number} goes on in Slurm; `scancel {number}` ends it"
            )));
            submitted(number)?;
        }
        let output = child.wait_with_output().context("cannot wait for sbatch")?;
        interrupt::say_at_end(None);
        if number.is_empty() {
            bail!("Slurm does not take the jobs: {}", self.refusal(&String::from_utf8_lossy(&output.stderr)));
        }
        // After it was taken, sbatch ends as the worst task did; the study's folder says more.
        Ok(())
    }

    /// The words after `sbatch`.
    fn words(&self, program: &Path) -> Result<Vec<String>> {
        let (file, out) = (text(self.file)?, text(self.out)?);
        let mut task: Vec<String> =
            [&text(program)?, "study", "run", &file, "--out", &out].map(str::to_owned).into();
        if let Some(scenes) = self.scenes {
            task.extend(["--scenes".to_owned(), text(scenes)?]);
        }
        let name = self.out.file_name().unwrap_or_default().to_string_lossy();
        let mut words = vec![
            "--parsable".to_owned(),
            "--exclusive".to_owned(),
            "--requeue".to_owned(),
            format!("--job-name={name}"),
            format!("--array={}", ranges(self.numbers)),
            // What Slurm would fill in.
            format!("--output={}/{SLURM_NAME}/%A_%a.log", out.replace('%', "%%")),
        ];
        words.extend(self.wait.then(|| "--wait".to_owned()));
        words.extend(self.constraint.map(|features| format!("--constraint={features}")));
        words.push(format!("--wrap=exec {} --job \"$SLURM_ARRAY_TASK_ID\"", typed(&task)));
        Ok(words)
    }

    /// What sbatch said, as a sentence.
    fn refusal(&self, said: &str) -> String {
        let lines =
            said.lines().map(|line| line.trim().trim_start_matches("sbatch: ").trim_start_matches("error: "));
        let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
        let mut sentence = one_line(&lines.join("; "), SHOWN);
        if let (true, Some(last)) = (sentence.contains("Invalid job array"), self.numbers.last()) {
            sentence += &format!(
                "; the last job is number {last}, and MaxArraySize in the cluster's slurm.conf must be above that"
            );
        }
        sentence
    }
}

/// A path from the root, since tasks need not start where they were submitted.
fn text(path: &Path) -> Result<String> {
    let path = std::path::absolute(path).with_context(|| format!("cannot find {}", path.display()))?;
    let text = path.to_str().with_context(|| format!("{} is no name in UTF-8; rename it", path.display()))?;
    Ok(text.to_owned())
}

/// Ascending numbers as `sbatch --array` takes them: `1-3,7`.
fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|before, after| before + 1 == *after);
    let run = |run: &[usize]| match run {
        [first, .., last] => format!("{first}-{last}"),
        _ => run.iter().map(usize::to_string).collect(),
    };
    runs.map(run).collect::<Vec<String>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_listed_as_ranges() {
        for (numbers, expected) in
            [(&[4][..], "4"), (&[1, 2], "1-2"), (&[1, 2, 3, 7, 9, 10], "1-3,7,9-10"), (&[1, 3], "1,3")]
        {
            assert_eq!(ranges(numbers), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn paths_reach_the_task_as_they_are() {
        let array = Array {
            file: Path::new("/a b/it's.toml"),
            scenes: Some(Path::new("/rooms")),
            out: Path::new("/to/50 %A"),
            numbers: &[2, 3],
            constraint: Some("a100&quiet"),
            wait: true,
        };
        let words = array.words(Path::new("/bin/recorder")).unwrap();
        assert_eq!(
            words,
            [
                "--parsable",
                "--exclusive",
                "--requeue",
                "--job-name=50 %A",
                "--array=2-3",
                "--output=/to/50 %%A/slurm/%A_%a.log",
                "--wait",
                "--constraint=a100&quiet",
                r#"--wrap=exec /bin/recorder study run '/a b/it'\''s.toml' --out '/to/50 %A' --scenes /rooms --job "$SLURM_ARRAY_TASK_ID""#,
            ]
        );
    }

    #[test]
    fn what_sbatch_refuses_is_one_sentence() {
        let path = Path::new("x");
        let array =
            Array { file: path, scenes: None, out: path, numbers: &[1, 1200], constraint: None, wait: false };
        assert_eq!(
            array.refusal("sbatch: error: Batch job submission failed: Invalid feature specification\n"),
            "Batch job submission failed: Invalid feature specification"
        );
        let large =
            array.refusal("sbatch: error: Batch job submission failed: Invalid job array specification");
        assert!(large.contains("the last job is number 1200, and MaxArraySize"), "{large}");
    }
}
