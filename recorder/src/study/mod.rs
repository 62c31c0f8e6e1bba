//! Studies: many recordings made from one plan, job after job, each by a process of its own.
//!
//! - [`plan`]: what `study.toml` asks for; [`words`]: its options as words of a command line
//! - [`jobs`]: the plan over its scenes, cameras and seeds; [`estimate`]: about what a job takes
//! - [`state`]: how far the jobs of a folder are; [`run`]: makes what is not finished, by [`child`] processes
//! - [`slurm`]: hands that to a cluster in place of this machine
//!
//! The folder is [`formats::study`]'s.

pub mod child;
pub mod estimate;
pub mod jobs;
pub mod plan;
pub mod run;
pub mod slurm;
pub mod state;
pub mod words;

/// What is wrong with a plan: problems, each a sentence that names the file and the key.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("{}", problems.join("\n"))]
pub struct PlanError {
    /// At least one.
    pub problems: Vec<String>,
}
