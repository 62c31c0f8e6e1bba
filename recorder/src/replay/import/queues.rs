//! What another tracer wrote: a file of rays, or a folder `bounce-BB/KIND/` for each queue.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use formats::files::read_plain;
use formats::key::method::is_method_name;
use formats::manifest::QueueId;
use formats::manifest::check::BOUNCES_MAX;
use formats::npy::{self, Dtype, Element};
use formats::ray::{Hit, Kind, Ray};
use formats::text::one_line;
use sha2::{Digest, Sha256};

use super::{ImportFrom, claims, rays};
use crate::backends::RecordedRays;
use crate::foreign::ForeignOrder;
use crate::stages::sort::cpu::Words;

/// Path indices lie below this, the pixels of a picture of 8192 × 8192, since something is kept for each.
const PATHS_MAX: usize = 1 << 26;
/// Most characters of a name that a message shows.
const SHOWN: usize = 80;

/// A queue as it came.
#[derive(Debug)]
pub(super) struct Queue {
    pub(super) id: QueueId,
    pub(super) rays: Vec<Ray>,
    pub(super) path_ids: Vec<u32>,
    /// Empty if the folder does not say.
    pub(super) lights: Vec<u32>,
    pub(super) results: Option<Results>,
    pub(super) orders: Vec<ForeignOrder>,
}

impl Queue {
    /// As the loop takes it.
    pub(super) fn rays(&self) -> RecordedRays<'_> {
        let Self { id, rays, path_ids, lights, .. } = self;
        RecordedRays { id: *id, rays, path_ids, lights, lengths: None }
    }
}

/// What the other tracer found, distances in world units.
#[derive(Debug)]
pub(super) enum Results {
    Hits(Vec<Hit>),
    Distances(Vec<f32>),
}

/// All that came.
pub(super) struct Queues {
    /// By bounce, closest rays first.
    pub(super) list: Vec<Queue>,
    /// The text of `orders.txt`.
    pub(super) claims: String,
    hash: Sha256,
}

impl Queues {
    /// # Errors
    /// What is wrong with the first file that cannot be taken.
    pub(super) fn read(from: &ImportFrom) -> Result<Self> {
        let mut queues = Self { list: Vec::new(), claims: String::new(), hash: Sha256::new() };
        match from {
            ImportFrom::Rays { file, kind, bounce } => {
                let bytes = bytes_of(file)?;
                queues.hash.update(&bytes);
                let (rays, _) = rays::parse(&bytes).with_context(|| file.display().to_string())?;
                let id = QueueId { pass: 0, bounce: *bounce, kind: *kind };
                let path_ids = (0..rays.len() as u32).collect();
                let (lights, orders) = (Vec::new(), Vec::new());
                queues.list.push(Queue { id, rays, path_ids, lights, results: None, orders });
            }
            ImportFrom::Queues(folder) => queues.read_folder(folder)?,
        }
        Ok(queues)
    }

    /// SHA-256 of what was read.
    pub(super) fn sha256(&self) -> [u8; 32] {
        self.hash.clone().finalize().into()
    }

    /// One more than the largest path index.
    ///
    /// # Errors
    /// If there are too many.
    pub(super) fn paths(&self) -> Result<u32> {
        let last = self.list.iter().flat_map(|queue| &queue.path_ids).max().copied().unwrap_or(0);
        let most_rays = self.list.iter().map(|queue| queue.rays.len()).max().unwrap_or(0);
        let limit = most_rays.max(PATHS_MAX);
        ensure!(
            (last as usize) < limit,
            "there is a path index {last}, expected those of a picture's pixels, below {limit}"
        );
        Ok(last + 1)
    }

    fn read_folder(&mut self, folder: &Path) -> Result<()> {
        let mut claims = None;
        for (name, path) in entries(folder)? {
            if name == claims::FILE {
                claims = Some(path);
                continue;
            }
            let bounce = name.strip_prefix("bounce-").filter(|digits| digits.len() >= 2);
            let bounce = bounce.and_then(|digits| digits.parse().ok()).filter(|bounce| *bounce < BOUNCES_MAX);
            let Some(bounce) = bounce else {
                bail!(
                    "{}: found '{}', expected bounce-00 to bounce-{} and {}",
                    folder.display(),
                    one_line(&name, SHOWN),
                    BOUNCES_MAX - 1,
                    claims::FILE
                );
            };
            for (name, path) in entries(&path)? {
                let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name).with_context(|| {
                    let found = one_line(&name, SHOWN);
                    format!("{}: found '{found}', expected closest and shadow", folder.display())
                })?;
                let queue = self.queue(&path, QueueId { pass: 0, bounce, kind })?;
                self.list.push(queue);
            }
        }
        ensure!(
            !self.list.is_empty(),
            "{} has no queue of rays; expected bounce-00/closest/rays.npy or others like it",
            folder.display()
        );
        self.list.sort_by_key(|queue| queue.id);
        let twice = self.list.windows(2).find(|pair| pair[0].id == pair[1].id);
        ensure!(twice.is_none(), "{} has a bounce twice, such as bounce-01 and bounce-001", folder.display());
        if let Some(path) = claims {
            let text = String::from_utf8(self.file(&path)?).ok();
            self.claims = text.with_context(|| format!("{} is not UTF-8", path.display()))?;
        }
        Ok(())
    }

    fn queue(&mut self, folder: &Path, id: QueueId) -> Result<Queue> {
        let path = folder.join("rays.npy");
        let bytes = self.file(&path).context("each queue has its rays in rays.npy")?;
        let (rays, lengths) = rays::parse(&bytes).with_context(|| path.display().to_string())?;
        let count = rays.len();
        let path_ids = self.array::<u32>(&folder.join("path_ids.npy"), count)?;
        let mut queue = Queue {
            id,
            path_ids: path_ids.unwrap_or_else(|| (0..count as u32).collect()),
            lights: Vec::new(),
            results: None,
            orders: Vec::new(),
            rays,
        };
        match id.kind {
            Kind::Closest => {
                let hits = self.array::<Hit>(&folder.join("hits.npy"), count)?;
                queue.results = hits.map(|mut hits| {
                    hits.iter_mut().zip(&lengths).for_each(|(hit, length)| scale(&mut hit.t, *length));
                    Results::Hits(hits)
                });
            }
            Kind::Shadow => {
                let distances = self.array::<f32>(&folder.join("distances.npy"), count)?;
                queue.results = distances.map(|mut distances| {
                    distances.iter_mut().zip(&lengths).for_each(|(t, length)| scale(t, *length));
                    Results::Distances(distances)
                });
                let lights = self.array::<u32>(&folder.join("lights.npy"), count)?;
                queue.lights = lights.unwrap_or_default();
            }
        }
        for (name, path) in entries(folder)? {
            if path.is_dir() {
                queue.orders.push(self.order(&path, name, id, count)?);
            }
        }
        Ok(queue)
    }

    fn order(&mut self, folder: &Path, name: String, queue: QueueId, count: usize) -> Result<ForeignOrder> {
        ensure!(
            is_method_name(&name),
            "{}: an order's name has small letters, digits and dashes",
            folder.display()
        );
        let path = folder.join("permutation.npy");
        let permutation = self.array::<u32>(&path, count)?;
        let permutation = permutation.with_context(|| {
            format!("there is no {}; an order has the index of the ray at each place in it", path.display())
        })?;
        let path = folder.join("keys.npy");
        let keys = match self.existing(&path)? {
            None => None,
            Some(bytes) => Some(keys(&bytes, count).with_context(|| path.display().to_string())?),
        };
        Ok(ForeignOrder { queue, name, permutation, is_permutation: false, keys })
    }

    /// An array with an entry for each of `count` rays, if it is there.
    fn array<T: Element>(&mut self, path: &Path, count: usize) -> Result<Option<Vec<T>>> {
        let bytes = self.existing(path)?;
        bytes.map(|bytes| entries_of(&bytes, count).with_context(|| path.display().to_string())).transpose()
    }

    fn existing(&mut self, path: &Path) -> Result<Option<Vec<u8>>> {
        // A link that leads nowhere is there, and cannot be read.
        if path.symlink_metadata().is_ok() { self.file(path).map(Some) } else { Ok(None) }
    }

    fn file(&mut self, path: &Path) -> Result<Vec<u8>> {
        let bytes = bytes_of(path)?;
        let from_the_folder = path.components().rev().take(4).map(|part| part.as_os_str().as_encoded_bytes());
        let parts: Vec<&[u8]> = from_the_folder.collect();
        parts.iter().rev().for_each(|part| self.hash.update(part));
        self.hash.update(&bytes);
        Ok(bytes)
    }
}

/// A distance in lengths of a direction, in world units.
fn scale(t: &mut f32, length: f64) {
    *t = (f64::from(*t) * length) as f32;
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    read_plain(path, u64::MAX).with_context(|| format!("cannot read {}", path.display()))
}

fn keys(bytes: &[u8], count: usize) -> Result<Words> {
    Ok(match npy::parse_header(bytes)?.dtype {
        Dtype::U8 => Words::Wide(entries_of(bytes, count)?),
        _ => Words::Narrow(entries_of(bytes, count)?),
    })
}

fn entries_of<T: Element>(bytes: &[u8], count: usize) -> Result<Vec<T>> {
    let header = npy::parse_header(bytes)?;
    ensure!(
        header.dtype == T::DTYPE && header.shape == [count as u64],
        "found {} {:?}, expected {} [{count}], an entry for each ray",
        header.dtype.descr(),
        header.shape,
        T::DTYPE.descr()
    );
    Ok(bytemuck::pod_collect_to_vec(rays::data(bytes, &header)?))
}

/// What a folder holds, by name, but for hidden files.
fn entries(folder: &Path) -> Result<BTreeMap<String, PathBuf>> {
    let read = || -> std::io::Result<_> {
        let paths = std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
        paths.collect::<std::io::Result<Vec<_>>>()
    };
    let paths = read().with_context(|| format!("cannot read the folder {}", folder.display()))?;
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let named = paths.into_iter().filter_map(|path| Some((name(&path)?, path)));
    Ok(named.filter(|(name, _)| !name.starts_with('.')).collect())
}
