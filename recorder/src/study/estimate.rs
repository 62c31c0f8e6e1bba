//! About how long a job takes, and how much it writes.
//!
//! Bytes are counted array by array, as FORMAT.md describes them. How many rays live is not known before they are
//! traced: at most all paths on every bounce, and about [`LIVING`] of those.

use anyhow::Result;
use formats::key::Extent;
use scenes::Scene;

use super::plan::Plan;
use crate::options::{AskedOrders, KeepPasses, RecordOptions};

/// Share of all possible rays that are traced: paths end where they leave a scene, and shadow rays are not traced where
/// no light can be.
const LIVING: f64 = 0.6;
/// Traces a second and thread, with all that is done beside.
const TRACES_PER_SECOND: f64 = 2.5e6;
/// By what the time of a first estimate may be too long or too short: scenes and machines differ by more than that.
pub const TIME_FACTOR: f64 = 3.0;
/// What every command takes before its first ray, seconds.
const START_SECONDS: f64 = 0.5;
/// Share of a length table's cells that are kept: those that more than one ray fell into.
const CELLS_KEPT: f64 = 0.2;
/// A stored cell: `{cell u4, count u4, sum u8}`.
const CELL_BYTES: f64 = 16.0;

/// About what something takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Seconds, within [`TIME_FACTOR`] either way.
    pub seconds: f64,
    /// Bytes, about.
    pub bytes: f64,
    /// Bytes, at most.
    pub bytes_max: f64,
}

impl std::iter::Sum for Estimate {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, one| Self {
            seconds: sum.seconds + one.seconds,
            bytes: sum.bytes + one.bytes,
            bytes_max: sum.bytes_max + one.bytes_max,
        })
    }
}

/// What the jobs of one scene take, command by command.
pub struct Size {
    commands: Vec<Estimate>,
}

impl Size {
    /// Of a plan's jobs with a scene; without one, as if it had no triangles.
    ///
    /// # Errors
    /// If the options of a replay exclude each other.
    pub fn of(plan: &Plan, scene: Option<&Scene>) -> Result<Self> {
        let options = &plan.record.options;
        let unnamed = |asked: &AskedOrders| usize::from(asked.shuffled) + usize::from(asked.auto);
        let orders = options.orders.methods.len() + unnamed(&options.orders);
        let mut commands = vec![record(options, orders, scene)];
        for replay in &plan.replays {
            let lights = scene.map_or(1, |scene| scene.lights.len());
            let extent = Extent { lights, picture: [options.width, options.height] };
            let asked = replay.options.orders.as_ref().unwrap_or(&options.orders);
            let sweep = &replay.options.sweep;
            let plans = sweep.plans(&asked.methods, extent, options.key_bits, options.two_point_length)?;
            let orders = plans.len() + unnamed(asked);
            let rays = Rays::of(options);
            let repeats = replay.options.repeats.unwrap_or(options.repeats);
            let keep = replay.options.keep;
            let queues = Rays { passes: 1.0, ..rays };
            let wide = plans.iter().filter(|plan| plan.key_bits > 32).count();
            let keys = if keep.keys { 4 * plans.len() + 4 * wide } else { 0 };
            let permutations = if keep.permutations { 4 * orders } else { 0 };
            let work = if keep.work { 8 } else { 0 };
            let bytes_max = (keys + permutations + work) as f64 * queues.kept(options.keep_passes);
            let threads = replay.options.device.threads;
            commands.push(Estimate {
                seconds: seconds(queues.measured_traces(repeats, orders), threads),
                bytes: LIVING * bytes_max,
                bytes_max,
            });
        }
        Ok(Self { commands })
    }

    /// Of a whole job.
    pub fn job(&self) -> Estimate {
        self.commands.iter().copied().sum()
    }

    /// Each command's share of the time.
    pub fn shares(&self) -> Vec<f64> {
        let all = self.job().seconds;
        self.commands.iter().map(|command| command.seconds / all).collect()
    }
}

/// The rays that there may be.
#[derive(Clone, Copy)]
struct Rays {
    /// Of one pass, all bounces: so many closest rays, and as many shadow rays.
    a_kind: f64,
    passes: f64,
}

impl Rays {
    fn of(options: &RecordOptions) -> Self {
        let pixels = f64::from(options.width) * f64::from(options.height);
        Self { a_kind: pixels * f64::from(options.bounces), passes: f64::from(options.passes) }
    }

    /// Rays of one kind or the other in the passes that are kept.
    fn kept(&self, passes: KeepPasses) -> f64 {
        2.0 * self.a_kind
            * match passes {
                KeepPasses::All => self.passes,
                KeepPasses::Measured => 1.0,
            }
    }

    /// How often rays of the measured pass are traced: gathered and through indices by each order, the baseline and the
    /// control, in each round and two before.
    fn measured_traces(&self, repeats: u32, orders: usize) -> f64 {
        2.0 * self.a_kind * f64::from(2 + repeats) * 2.0 * (2 + orders) as f64
    }
}

fn seconds(traces: f64, threads: Option<usize>) -> f64 {
    let threads = threads.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    START_SECONDS + LIVING * traces / (TRACES_PER_SECOND * threads as f64)
}

fn record(options: &RecordOptions, orders: usize, scene: Option<&Scene>) -> Estimate {
    let (keep, rays) = (options.keep, Rays::of(options));
    let of = |is_kept: bool, bytes: f64| if is_kept { bytes } else { 0.0 };
    let methods = options.orders.methods.len() as f64;
    let key = if options.key_bits > 32 { 8.0 } else { 4.0 };
    // Half of the rays are shadow rays, which have a distance in place of a hit, and a light.
    let per_ray = of(keep.rays, 36.0 + 0.5 * 4.0)
        + of(keep.hits, 0.5 * (16.0 + 4.0))
        + of(keep.work, 8.0)
        + of(keep.throughput, 0.5 * 12.0)
        + of(keep.keys, methods * key)
        + of(keep.permutations, 4.0 * orders as f64);
    let rays_bytes = per_ray * rays.kept(options.keep_passes);
    let queues = 2.0
        * f64::from(options.bounces)
        * if options.keep_passes == KeepPasses::All { rays.passes } else { 1.0 };
    let cells = f64::from(1u32 << options.table_bits).min(rays.a_kind * rays.passes);
    let tables = of(keep.lengths, (queues + 2.0) * cells * CELL_BYTES);
    let geometry =
        scene.map_or(0.0, |scene| 12.0 * scene.positions.len() as f64 + 19.0 * scene.triangles.len() as f64);
    let picture = 12.0 * f64::from(options.width) * f64::from(options.height);
    let whole = of(keep.scene, geometry) + of(keep.image, picture);
    let passes = 2.0 * rays.a_kind * rays.passes;
    Estimate {
        seconds: seconds(passes + rays.measured_traces(options.repeats, orders), options.device.threads),
        bytes: whole + LIVING * rays_bytes + CELLS_KEPT * tables,
        bytes_max: whole + rays_bytes + tables,
    }
}
