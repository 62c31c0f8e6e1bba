//! The sort on the GPU: one sweep a pass where subgroups sort tiles together, else reduce, then scan. No workgroup
//! ever has to wait for another.

use bytemuck::{Pod, Zeroable};

use super::{BINS, COUNT_BITS, DIGIT_BITS, DIGITS_PER_WORD, Digits};
use crate::device::kernel::{LINEAR_WORKGROUP_WGSL, constants_wgsl};
use crate::device::{AdapterDescription, Binding, DeviceArray, Gpu, GpuError, Kernel, KernelSource};
use crate::stages::compact::WORKGROUP_SCAN_WGSL;

/// Threads of a workgroup that looks at keys before the first pass.
const LOOK_THREADS: u32 = 256;
/// Keys that one of them looks at.
const LOOK_KEYS_PER_THREAD: u32 = 16;

/// Keys in canonical order.
#[derive(Clone, Debug)]
pub struct Keys {
    /// Bits of a key, 1 to 64; all above are 0.
    pub bits: u32,
    /// How many keys there are; the arrays may be longer.
    pub count: usize,
    /// The low 32 bits of every key.
    pub low: DeviceArray<u32>,
    /// The high 32 bits, where keys are longer than 32 bits, or may come to be.
    pub high: Option<DeviceArray<u32>>,
}

impl Keys {
    /// Room for `count` keys of any width and value.
    ///
    /// # Errors
    /// If there are too many for the adapter.
    pub fn new(gpu: &Gpu, count: usize) -> Result<Self, GpuError> {
        let high = Some(gpu.array("key::high", count)?);
        Ok(Self { bits: u64::BITS, count, low: gpu.array("key::low", count)?, high })
    }

    /// Uploads keys of `bits` bits.
    ///
    /// # Errors
    /// If there are too many for the adapter.
    pub fn upload(gpu: &Gpu, keys: &[u64], bits: u32) -> Result<Self, GpuError> {
        let high = (bits > u32::BITS).then(|| gpu.array("key::high", keys.len())).transpose()?;
        let mut uploaded = Self { bits, count: keys.len(), low: gpu.array("key::low", keys.len())?, high };
        uploaded.fill(gpu, keys, bits)?;
        Ok(uploaded)
    }

    /// Uploads other keys in their place.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// If there is no room for so many.
    pub fn fill(&mut self, gpu: &Gpu, keys: &[u64], bits: u32) -> Result<(), GpuError> {
        let words = |shift: u32| keys.iter().map(|key| (key >> shift) as u32).collect::<Vec<_>>();
        (self.bits, self.count) = (bits, keys.len());
        gpu.write(&self.low, &words(0))?;
        self.high.iter().try_for_each(|high| gpu.write(high, &words(u32::BITS)))
    }
}

/// Digits of keys so short that a look that only says which bits differ takes as long as a pass.
const UNSEEN_DIGITS: u32 = 2;
/// Words in front of the totals of the bins: bits seen as 1 and as 0 in the low and high words.
const SEEN_WORDS: usize = 4;
/// Subgroups of a workgroup that sorts a tile together.
const SUBGROUPS: u32 = 8;
/// Most threads of such a workgroup.
const MOST_THREADS: u32 = 256;
/// Keys that each of its threads sorts; they stay in registers.
const KEYS_PER_THREAD: u32 = 12;
/// Tiles that a thread asks at once for what they have counted.
const ASKED_AT_ONCE: u32 = 2;
/// How often it asks after an answer before its workgroup counts the next tile itself.
const PATIENCE: u32 = 64;
/// Most threads of a workgroup whose threads walk tiles of their own.
const MOST_SERIAL_THREADS: u32 = 32;
/// Threads of a workgroup that scans the tiles of a bin; a power of two.
const SCAN_THREADS: u32 = 64;
/// Keys of the tile of a thread on its own: enough that moving its 256 counters does not show.
const SERIAL_TILE_KEYS: u32 = 2048;

/// How tiles are spread over threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Tiling {
    /// The kernels that do it, in parts.
    wgsl: [&'static str; 2],
    /// Threads of a workgroup.
    threads: u32,
    /// Keys of a tile.
    tile_keys: u32,
    /// Tiles that one workgroup takes care of.
    tiles_per_workgroup: u32,
    /// [`PATIENCE`] where a pass is one sweep; none where it is reduce, then scan.
    patience: Option<u32>,
}

impl Tiling {
    /// Workgroups that sort tiles together where subgroups let them, else threads on their own.
    fn of(adapter: &AdapterDescription) -> Self {
        let threads = (SUBGROUPS * adapter.subgroup_min_size).min(MOST_THREADS);
        // What Direct3D 12 says of the most lanes is not to be relied on, by its documentation.
        let most_lanes = if adapter.backend == "dx12" { 128 } else { adapter.subgroup_max_size };
        let shared = Self::shared(threads, KEYS_PER_THREAD, most_lanes);
        let can_share = adapter.subgroups
            && threads >= adapter.subgroup_max_size
            && shared.shared_bytes() <= adapter.limits.workgroup_bytes;
        if can_share && !adapter.is_software() {
            shared
        } else {
            let columns = adapter.limits.workgroup_bytes / (BINS * size_of::<u32>()) as u32;
            Self::serial(columns.min(MOST_SERIAL_THREADS), SERIAL_TILE_KEYS)
        }
    }

    /// Each thread walks a tile of its own.
    fn serial(threads: u32, tile_keys: u32) -> Self {
        Self {
            wgsl: [WORKGROUP_SCAN_WGSL, include_str!("serial.wgsl")],
            threads,
            tile_keys,
            tiles_per_workgroup: threads,
            patience: None,
        }
    }

    /// The threads of a workgroup, [`SUBGROUPS`] subgroups at most, sort a tile together. A power
    /// of two of threads, at most [`BINS`].
    fn shared(threads: u32, keys_per_thread: u32, most_lanes: u32) -> Self {
        let lanes = match most_lanes {
            ..=32 => include_str!("lanes_32.wgsl"),
            _ => include_str!("lanes_128.wgsl"),
        };
        Self {
            wgsl: [lanes, include_str!("subgroup.wgsl")],
            threads,
            tile_keys: threads * keys_per_thread,
            tiles_per_workgroup: 1,
            patience: Some(PATIENCE),
        }
    }

    /// Bytes of workgroup memory that sorting a tile together takes: the tile, the bins of each subgroup,
    /// their starts and offsets, those of a tile that is waited for and which one that is, and the sums of the
    /// subgroups.
    fn shared_bytes(&self) -> u32 {
        let bins = BINS as u32 * (SUBGROUPS + 3);
        (self.tile_keys + bins + SUBGROUPS + 2) * size_of::<u32>() as u32
    }
}

/// The kernels of the sort, and room that all sorts use.
#[derive(Debug)]
pub struct Sorter {
    tiling: Tiling,
    look: Kernel,
    pass: PassKernels,
    totals: DeviceArray<u32>,
    /// Which half of the totals the next sort finds cleared.
    half: u32,
    room: Option<Room>,
    digits: Digits,
}

/// What a pass dispatches, in this order.
#[derive(Debug)]
enum PassKernels {
    Sweep(Kernel),
    ReduceThenScan { count: Kernel, scan: Kernel, scatter: Kernel },
}

/// Arrays whose size depends on the number of keys.
#[derive(Clone, Debug)]
struct Room {
    keys: [DeviceArray<u32>; 2],
    order: DeviceArray<u32>,
    /// What tiles have counted: once, or for a sweep in two turns.
    tile_counts: DeviceArray<u32>,
}

/// What the kernels are told.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SortPass {
    count: u32,
    tiles: u32,
    digit: u32,
    digits: u32,
    skips: u32,
    half: u32,
}

impl Sorter {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// If the driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Self::with_tiling(gpu, Tiling::of(gpu.adapter()))
    }

    fn with_tiling(gpu: &Gpu, tiling: Tiling) -> Result<Self, GpuError> {
        let mut wgsl = wgsl(&tiling);
        if tiling.patience.is_some() {
            wgsl = write_out(&wgsl, "LOOK_KEYS_PER_THREAD", LOOK_KEYS_PER_THREAD);
            wgsl = write_out(&wgsl, "ROWS", tiling.tile_keys / tiling.threads);
        }
        let mut bindings = [Binding::ReadWrite; 8];
        bindings[..2].fill(Binding::Read);
        let compile = |entry_point: &str| {
            let source = KernelSource {
                label: &format!("sort::{entry_point}"),
                wgsl: &wgsl,
                entry_point,
                bindings: &bindings,
                immediate_bytes: size_of::<SortPass>() as u32,
            };
            // SAFETY: places are below `count`, or clamped to the last of them where there is one (without keys
            // there are no workgroups), or in a tile before the last, which is full; tiles are below `tiles`, to
            // which `sort` sizes the arrays. Slots are sums of counts, of totals that the sort before cleared and of
            // fewer than 2^30 keys, and stay below `count`. Subgroups are full in workgroups of a multiple of
            // their size, as far as drivers keep to that; sorts of the self-check would show it. Loops count up to
            // bounds, but for two of a sweep: one polls, up to `PATIENCE` times after each answer, of which there is
            // one for each tile before; the loop around it lowers the largest `end` in each round. Divisors are
            // constants.
            unsafe { Kernel::trusted(gpu, &source) }
        };
        let pass = match tiling.patience {
            Some(_) => PassKernels::Sweep(compile("sweep")?),
            None => PassKernels::ReduceThenScan {
                count: compile("count")?,
                scan: compile("scan")?,
                scatter: compile("scatter")?,
            },
        };
        Ok(Self {
            tiling,
            look: compile("look")?,
            pass,
            totals: gpu.array("sort::totals", 2 * (SEEN_WORDS + (u64::BITS / DIGIT_BITS) as usize * BINS))?,
            half: 0,
            room: None,
            digits: Digits::Differing,
        })
    }

    /// The same that sorts by these digits; the order is the same.
    #[must_use]
    pub fn by(self, digits: Digits) -> Self {
        Self { digits, ..self }
    }

    /// Writes the stable order of keys, the canonical index of the key at each place; returns how long it took,
    /// in nanoseconds.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// If an array is shorter than the count of keys, there are 2^30 of them, or keys of more than 32 bits have no
    /// high words.
    pub fn sort(&mut self, gpu: &Gpu, keys: &Keys, permutation: &DeviceArray<u32>) -> Result<u64, GpuError> {
        let count = keys.count;
        let is_wide = keys.bits > u32::BITS;
        let high = if is_wide { keys.high.as_ref() } else { Some(&keys.low) };
        let high = high.expect("keys of more than 32 bits have high words");
        for array in [&keys.low, high, permutation] {
            assert!(count <= array.len(), "{count} keys, {} in {}", array.len(), array.label());
        }
        let count = u32::try_from(count).ok().filter(|&count| count < 1 << COUNT_BITS);
        let count = count.expect("fewer than 2^30 keys");
        let tiles = count.div_ceil(self.tiling.tile_keys);
        let room = self.make_room(gpu, count as usize, tiles as usize)?;
        let resources = [
            keys.low.binding(),
            high.binding(),
            room.keys[0].binding(),
            room.keys[1].binding(),
            permutation.binding(),
            room.order.binding(),
            room.tile_counts.binding(),
            self.totals.binding(),
        ];
        let group = self.look.bind(gpu, &resources)?;
        let mut run = gpu.stage("sort");
        if count == 0 {
            return run.finish();
        }
        let passes = keys.bits.div_ceil(DIGIT_BITS);
        // A look that counts the bins of a sweep finds out what differs on the way.
        let sweeps = matches!(self.pass, PassKernels::Sweep(_));
        let skips = self.digits == Digits::Differing && (sweeps || passes > UNSEEN_DIGITS);
        let (digits, skips, half) = ((1 << passes) - 1, u32::from(skips), self.half);
        let pass_of = |digit| SortPass { count, tiles, digit, digits, skips, half };
        let looks = sweeps || skips == 1;
        if looks {
            let workgroups = count.div_ceil(LOOK_THREADS * LOOK_KEYS_PER_THREAD);
            for word in 0..if is_wide { 2 } else { 1 } {
                run.dispatch(&self.look, &group, &pass_of(word * DIGITS_PER_WORD), workgroups);
            }
        }
        let workgroups = tiles.div_ceil(self.tiling.tiles_per_workgroup);
        for pass in (0..passes).map(pass_of) {
            match &self.pass {
                PassKernels::Sweep(sweep) => run.dispatch(sweep, &group, &pass, workgroups),
                PassKernels::ReduceThenScan { count, scan, scatter } => {
                    run.dispatch(count, &group, &pass, workgroups);
                    run.dispatch(scan, &group, &pass, BINS as u32);
                    run.dispatch(scatter, &group, &pass, workgroups);
                }
            }
        }
        let elapsed_ns = run.finish()?;
        if looks {
            // The other half is clear now, and this one is not.
            self.half = 1 - half;
        }
        Ok(elapsed_ns)
    }

    /// The stable order of keys, in an array of its own.
    ///
    /// # Errors
    /// Those of the device.
    pub fn sorted(&mut self, gpu: &Gpu, keys: &Keys) -> Result<DeviceArray<u32>, GpuError> {
        let permutation = gpu.array("sort::permutation", keys.count)?;
        self.sort(gpu, keys, &permutation)?;
        Ok(permutation)
    }

    /// The arrays that depend on the number of keys, made anew unless those there are large enough.
    fn make_room(&mut self, gpu: &Gpu, count: usize, tiles: usize) -> Result<Room, GpuError> {
        let turns = if self.tiling.patience.is_some() { 2 } else { 1 };
        // Taken out first: large arrays must not be there twice.
        let room = match self.room.take().filter(|room| room.order.len() >= count) {
            Some(room) => room,
            None => Room {
                keys: [gpu.array("sort::keys_a", count)?, gpu.array("sort::keys_b", count)?],
                order: gpu.array("sort::order_b", count)?,
                tile_counts: gpu.array("sort::tile_counts", turns * tiles * BINS)?,
            },
        };
        Ok(self.room.insert(room).clone())
    }
}

/// Label and text of the module of each way to tile, for tests that look at every module.
pub(crate) fn sources() -> Vec<(String, String)> {
    let tilings = [
        ("sort::serial", Tiling::serial(32, 2048)),
        ("sort::shared", Tiling::shared(64, KEYS_PER_THREAD, 32)),
        ("sort::shared, wide subgroups", Tiling::shared(64, KEYS_PER_THREAD, 64)),
    ];
    tilings.into_iter().map(|(label, tiling)| (label.to_owned(), wgsl(&tiling))).collect()
}

/// The whole module.
fn wgsl(tiling: &Tiling) -> String {
    let constants = [
        ("DIGIT_BITS", DIGIT_BITS),
        ("DIGITS_PER_WORD", DIGITS_PER_WORD),
        ("BINS", BINS as u32),
        ("SCAN_THREADS", SCAN_THREADS),
        ("LOOK_THREADS", LOOK_THREADS),
        ("LOOK_KEYS_PER_THREAD", LOOK_KEYS_PER_THREAD),
        ("TILE_THREADS", tiling.threads),
        ("TILE_KEYS", tiling.tile_keys),
        ("SUBGROUPS", SUBGROUPS),
        ("ASKED_AT_ONCE", ASKED_AT_ONCE),
        ("COUNT_BITS", COUNT_BITS),
        ("PATIENCE", tiling.patience.unwrap_or_default()),
    ];
    [&constants_wgsl(&constants), LINEAR_WORKGROUP_WGSL, include_str!("pass.wgsl"), &tiling.wgsl.join("\n")]
        .concat()
}

/// Writes the loops out that count `row` up to `bound`: drivers keep an array that a loop indexes in memory, but a
/// thread's keys in registers if no loop does, and then overlap what its rows wait for.
fn write_out(wgsl: &str, bound: &str, turns: u32) -> String {
    let head = format!("for (var row = 0u; row < {bound}; row++) {{");
    let mut parts = wgsl.split(&head);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let mut depth = 1;
        let (body, rest) = part.split_at(
            part.find(|letter| {
                depth += i32::from(letter == '{') - i32::from(letter == '}');
                depth == 0
            })
            .expect("braces of WGSL are closed"),
        );
        for turn in 0..turns {
            text += &format!("{{ const row = {turn}u;{body}}}\n");
        }
        text += &rest[1..];
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{skipped, test_gpu};
    use crate::stages::sort::test_keys::{self, expected};

    fn check(sorter: &mut Sorter, keys: &[u64], bits: u32, what: &str) {
        let gpu = test_gpu();
        let order = sorter.sorted(gpu, &Keys::upload(gpu, keys, bits).unwrap()).unwrap();
        let found = gpu.read_vec(&order).unwrap();
        let expected = expected(keys);
        let wrong = found.iter().zip(&expected).position(|(found, expected)| found != expected);
        assert_eq!(wrong, None, "first wrong place of {} {what} of {bits} bits", keys.len());
        assert_eq!(found.len(), keys.len());
    }

    /// Small tiles, so that few keys already have many borders.
    fn small_tilings() -> Vec<Tiling> {
        let adapter = test_gpu().adapter();
        let mut tilings = vec![Tiling::serial(16, 64)];
        if adapter.subgroups {
            let threads = (SUBGROUPS * adapter.subgroup_min_size).min(MOST_THREADS);
            tilings.push(Tiling::shared(threads, 2, adapter.subgroup_max_size));
        } else {
            skipped("sorting tiles together", "the adapter has no subgroups");
        }
        tilings
    }

    #[test]
    fn keys_of_any_width_sort_like_the_standard_stable_sort() {
        for tiling in small_tilings() {
            let mut sorter = Sorter::with_tiling(test_gpu(), tiling).unwrap();
            let workgroup_keys = (tiling.tile_keys * tiling.tiles_per_workgroup) as usize;
            let borders = [1, tiling.tile_keys as usize, workgroup_keys, 8192, 20_011];
            for count in borders.iter().flat_map(|&border| border - 1..=border + 1) {
                for (what, bits, keys) in test_keys::cases(count) {
                    check(&mut sorter, &keys, bits, what);
                }
            }
        }
    }

    /// What graphics cards get, with as many threads as this adapter's subgroups allow, but fewer keys a thread,
    /// since every row is compiled by itself.
    #[test]
    fn tiles_that_a_workgroup_shares_sort_right() {
        let adapter = test_gpu().adapter();
        if !adapter.subgroups {
            return skipped("tiles that a workgroup shares", "the adapter has no subgroups");
        }
        let threads = (SUBGROUPS * adapter.subgroup_min_size).min(MOST_THREADS);
        // Ballots in one word and in four.
        for most_lanes in [32, 128].into_iter().filter(|&most| most >= adapter.subgroup_max_size) {
            // With no patience but for one question a workgroup asks tiles and counts them itself in turns.
            for patience in [PATIENCE, 1] {
                let tiling = Tiling { patience: Some(patience), ..Tiling::shared(threads, 2, most_lanes) };
                let mut sorter = Sorter::with_tiling(test_gpu(), tiling).unwrap();
                let tile = tiling.tile_keys as usize;
                for count in [tile - 1, tile + 1, 9 * tile + 5] {
                    for (what, bits, keys) in test_keys::cases(count) {
                        check(&mut sorter, &keys, bits, what);
                    }
                }
            }
        }
    }

    /// The same in processes of their own, since a driver reads its settings once.
    #[test]
    fn tiles_sort_right_on_other_drivers_and_subgroups() {
        let second = std::env::var("RAYSCOPE_SECOND_DRIVER").unwrap_or_default();
        if second.is_empty() {
            skipped("the sort on a second driver", "RAYSCOPE_SECOND_DRIVER names none; tests/run sets it");
        }
        // Only lavapipe asks for a width; others run the same once more.
        let settings = [("LP_NATIVE_VECTOR_WIDTH", "128"), ("LP_NATIVE_VECTOR_WIDTH", "512")];
        let driver = Some(("VK_DRIVER_FILES", second.as_str())).filter(|_| !second.is_empty());
        for (name, value) in settings.into_iter().chain(driver) {
            let mut child = std::process::Command::new(std::env::current_exe().unwrap());
            child.args(["tiles_that_a_workgroup_shares_sort_right", "--nocapture"]).env(name, value);
            let output = child.output().unwrap();
            let said = String::from_utf8_lossy(&output.stdout);
            assert!(output.status.success() && said.contains("1 passed"), "with {name}={value}: {said}");
        }
    }

    #[test]
    fn passes_over_constant_digits_change_nothing() {
        let mut sorter = Sorter::new(test_gpu()).unwrap().by(Digits::All);
        for (what, bits, keys) in test_keys::cases(5000) {
            check(&mut sorter, &keys, bits, what);
        }
    }

    #[test]
    fn a_sorter_serves_few_keys_after_many_and_many_after_few() {
        for tiling in small_tilings() {
            let mut sorter = Sorter::with_tiling(test_gpu(), tiling).unwrap();
            for count in [10, 70_003, 0, 5, 0, 0, 150_001] {
                for bits in [32, 12, 64] {
                    check(&mut sorter, &test_keys::random(count, bits, 1), bits, "random keys");
                }
            }
        }
    }

    #[test]
    fn sixteen_million_keys_and_more() {
        let mut sorter = Sorter::new(test_gpu()).unwrap();
        let count = (1 << 24) + 12_345;
        check(&mut sorter, &test_keys::random(count, 24, 3), 24, "random keys");
    }
}
