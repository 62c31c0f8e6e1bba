//! The jobs of a plan: each scene, camera and seed, with its commands.

use std::collections::BTreeMap;

use anyhow::Result;
use formats::summary::hexadecimal;
use scenes::hash::content_hash;
use scenes::{Camera, Scene, views};
use sha2::{Digest, Sha256};

use super::estimate::{Estimate, Size};
use super::plan::{Cameras, Plan, Planned, PlannedScene};
use super::words::typed;
use crate::recording::choose_camera;

/// Most characters of a scene's or a camera's name in that of a folder.
const NAME_CHARACTERS: usize = 60;

/// One recording with its replays.
#[derive(Clone, Debug)]
pub struct Job {
    /// From 1, in the order of the plan.
    pub number: usize,
    /// Its folder's, unlike those of all other jobs.
    pub name: String,
    /// Scene as the plan names it.
    pub scene: String,
    /// Camera by name.
    pub camera: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The recording and its replays.
    pub commands: Vec<Command>,
    /// SHA-256 of what it is made from: program, commands, the scene's content and the camera; hexadecimal.
    pub content_hash: String,
    /// About what it takes.
    pub estimate: Estimate,
    /// Why it cannot be made, as long as its scene or camera is not there.
    pub problem: Option<String>,
}

/// A command of a job, run in its folder.
#[derive(Clone, Debug)]
pub struct Command {
    /// Name of the recording that it makes, a folder in the job's.
    pub recording: String,
    /// Words after the program's name.
    pub words: Vec<String>,
    /// Share of the job's time, 0 to 1.
    pub share: f64,
}

impl Command {
    /// As it would be typed.
    pub fn typed(&self) -> String {
        format!("recorder {}", typed(&self.words))
    }
}

/// What a plan comes to.
pub struct Jobs {
    /// In the order of the plan: scene by scene, camera by camera, seed by seed.
    pub jobs: Vec<Job>,
    /// Scenes and cameras that there are not; their jobs are listed, and fail without a folder.
    pub problems: Vec<String>,
}

/// Expands a plan; loads each of its scenes, one after the other.
///
/// # Errors
/// If the options of a replay exclude each other.
pub fn jobs(plan: &Plan) -> Result<Jobs> {
    let mut found = Jobs { jobs: Vec::new(), problems: Vec::new() };
    for planned in &plan.scenes {
        let (scene, no_scene) = match scenes::load(&planned.source) {
            Ok(scene) => (Some(scene), None),
            Err(error) => (None, Some(format!("{:#}", anyhow::Error::from(error)))),
        };
        found.problems.extend(no_scene.iter().map(|problem| format!("scenes: {problem}")));
        let size = Size::of(plan, scene.as_ref())?;
        let content = scene.as_ref().map(content_hash);
        for camera in cameras(planned, scene.as_ref()) {
            let pose = scene.as_ref().map(|scene| choose_camera(scene, Some(&camera)));
            let (pose, no_camera) = match pose.transpose() {
                Ok(pose) => (pose, None),
                Err(error) => (None, Some(format!("{error:#}"))),
            };
            found.problems.extend(no_camera.iter().map(|problem| format!("cameras: {problem}")));
            let problem = no_scene.clone().or(no_camera);
            for &seed in &plan.seeds {
                let commands = commands(plan, planned, &camera, seed, &size);
                found.jobs.push(Job {
                    number: found.jobs.len() + 1,
                    name: format!("{}-{}-{seed}", plain(stem(&planned.name)), plain(&camera)),
                    scene: planned.name.clone(),
                    camera: camera.clone(),
                    seed,
                    content_hash: hash(plan, planned, content, pose.as_ref(), seed),
                    commands,
                    estimate: size.job(),
                    problem: problem.clone(),
                });
            }
        }
    }
    tell_apart(&mut found.jobs);
    Ok(found)
}

/// Names of the cameras that a scene is recorded from; of one that cannot be loaded, whatever is known.
fn cameras(planned: &PlannedScene, scene: Option<&Scene>) -> Vec<String> {
    let of_scene = || scene.iter().flat_map(|scene| &scene.cameras).map(|camera| camera.name.clone());
    let found: Vec<String> = match &planned.cameras {
        Cameras::First => of_scene().take(1).collect(),
        Cameras::All => of_scene().collect(),
        Cameras::Named(names) => names.clone(),
        Cameras::Automatic(count) => views::names(*count),
    };
    if found.is_empty() { vec!["unknown".to_owned()] } else { found }
}

fn commands(plan: &Plan, planned: &PlannedScene, camera: &str, seed: u64, size: &Size) -> Vec<Command> {
    let recording = &plan.record.name;
    let record = [
        "record".to_owned(),
        planned.source.clone(),
        format!("--out={recording}"),
        format!("--camera={camera}"),
        format!("--seed={seed}"),
        "--force".to_owned(),
    ];
    let mut commands = vec![(recording, [&record[..], &plan.record.words].concat())];
    for Planned { name, words, .. } in &plan.replays {
        let replay = ["replay", &format!("{recording}.raydump"), &format!("--out={name}"), "--force"];
        commands.push((name, [&replay.map(str::to_owned)[..], words].concat()));
    }
    let command = |((name, words), share): ((&String, Vec<String>), f64)| Command {
        recording: format!("{name}.{}", formats::folder::EXTENSION),
        words,
        share,
    };
    commands.into_iter().zip(size.shares()).map(command).collect()
}

/// SHA-256 of what a job is made from. Where the scene's file lies does not count, what is in it does.
fn hash(
    plan: &Plan,
    planned: &PlannedScene,
    content: Option<[u8; 32]>,
    camera: Option<&Camera>,
    seed: u64,
) -> String {
    let mut hasher = Sha256::new();
    let mut add = |text: &str| {
        hasher.update((text.len() as u64).to_le_bytes());
        hasher.update(text);
    };
    add(env!("CARGO_PKG_VERSION"));
    add(&planned.name);
    add(&format!("{content:?} {camera:?} {seed}"));
    add(&typed(&plan.record.words));
    for replay in &plan.replays {
        add(&replay.name);
        add(&typed(&replay.words));
    }
    hexadecimal(&hasher.finalize())
}

/// What a scene is called: a file without folders and extension, a built-in one without its prefix.
fn stem(scene: &str) -> &str {
    match scene.strip_prefix("builtin:") {
        Some(name) => name,
        None => std::path::Path::new(scene).file_stem().and_then(|stem| stem.to_str()).unwrap_or(scene),
    }
}

/// A name that every file system takes.
fn plain(name: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_".contains(letter);
    let letters = name.chars().take(NAME_CHARACTERS);
    letters.map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

/// Adds to names that more than one job has, also to a file system that takes `A` for `a`, what tells them apart.
fn tell_apart(jobs: &mut [Job]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for job in jobs.iter() {
        *counts.entry(job.name.to_lowercase()).or_default() += 1;
    }
    for job in jobs.iter_mut().filter(|job| counts[&job.name.to_lowercase()] > 1) {
        let digest = Sha256::digest(format!("{}\n{}", job.scene, job.camera));
        job.name += &hexadecimal(&digest[..4]);
    }
}
