//! The sort on the GPU: reduce, then scan; no workgroup ever waits for another.

use bytemuck::{Pod, Zeroable};

use super::{BINS, DIGIT_BITS, DIGITS_PER_WORD};
use crate::gpu::kernel::{LINEAR_WORKGROUP_WGSL, constants_wgsl};
use crate::gpu::{Binding, DeviceArray, Gpu, GpuError, Kernel, KernelSource};
use crate::stages::compact::WORKGROUP_SCAN_WGSL;

/// Threads of a workgroup that scans the tiles of a bin; a power of two.
const SCAN_THREADS: u32 = 64;
/// Threads of a workgroup that looks for bits that differ.
const EXAMINE_THREADS: u32 = 128;
/// Keys that one of them looks at.
const EXAMINE_KEYS_PER_THREAD: u32 = 64;

/// Keys to sort, in canonical order.
#[derive(Clone, Debug)]
pub struct SortKeys {
    /// The low 32 bits of every key.
    pub low: DeviceArray<u32>,
    /// The high 32 bits, where keys are longer than 32 bits.
    pub high: Option<DeviceArray<u32>>,
    /// Bits of a key, 1 to 64; all above are 0.
    pub bits: u32,
}

/// What a sort made.
#[derive(Clone, Debug)]
pub struct Sorted {
    /// The canonical index of the key at each place.
    pub permutation: DeviceArray<u32>,
    /// How long it took, in nanoseconds.
    pub elapsed_ns: u64,
}

/// How tiles are spread over threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tiling {
    /// The kernels that do it.
    wgsl: &'static str,
    /// Threads of a workgroup.
    threads: u32,
    /// Keys of a tile.
    tile_keys: u32,
    /// Tiles that one workgroup takes care of.
    tiles_per_workgroup: u32,
}

impl Tiling {
    pub(super) fn serial(threads: u32, tile_keys: u32) -> Self {
        let wgsl = include_str!("serial.wgsl");
        Self { wgsl, threads, tile_keys, tiles_per_workgroup: threads }
    }
}

/// The kernels of the sort, and room that all sorts use.
#[derive(Debug)]
pub struct Sorter {
    tiling: Tiling,
    examine: Kernel,
    count: Kernel,
    scan: Kernel,
    scatter: Kernel,
    seen: DeviceArray<u32>,
    bin_totals: DeviceArray<u32>,
    room: Option<Room>,
}

/// Arrays whose size depends on the number of keys.
#[derive(Debug)]
struct Room {
    keys: [DeviceArray<u32>; 2],
    order: DeviceArray<u32>,
    tile_counts: DeviceArray<u32>,
}

/// What the kernels are told.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SortPass {
    count: u32,
    tiles: u32,
    digit: u32,
}

impl Sorter {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// If the driver refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Self::with_tiling(gpu, Tiling::serial(32, 1024))
    }

    pub(super) fn with_tiling(gpu: &Gpu, tiling: Tiling) -> Result<Self, GpuError> {
        let wgsl = wgsl(&tiling);
        let groups: &[&[Binding]] = &[&[
            Binding::Read,
            Binding::ReadWrite,
            Binding::ReadWrite,
            Binding::ReadWrite,
            Binding::ReadWrite,
            Binding::ReadWrite,
            Binding::ReadWrite,
            Binding::ReadWrite,
        ]];
        let compile = |entry_point: &str| {
            let source = KernelSource {
                label: &format!("sort::{entry_point}"),
                wgsl: &wgsl,
                entry_point,
                groups,
                immediate_bytes: size_of::<SortPass>() as u32,
            };
            // SAFETY: places are below `count` and tiles below `tiles`, to which `sort` sizes the
            // arrays; slots come from sums of counts and stay below `count`; all loops count up to
            // bounds, and divisors are constants.
            unsafe { Kernel::trusted(gpu, &source) }
        };
        Ok(Self {
            tiling,
            examine: compile("examine")?,
            count: compile("count")?,
            scan: compile("scan")?,
            scatter: compile("scatter")?,
            seen: gpu.array("sort::seen", 4)?,
            bin_totals: gpu.array("sort::bin_totals", BINS)?,
            room: None,
        })
    }

    /// The stable order of the first `count` keys, in an array of its own.
    ///
    /// # Errors
    /// Those of the device.
    ///
    /// # Panics
    /// If the arrays of keys are shorter than `count`, or keys of more than 32 bits have no high
    /// words.
    pub fn sort(&mut self, gpu: &Gpu, keys: &SortKeys, count: usize) -> Result<Sorted, GpuError> {
        let words = words_of(keys);
        for word in &words {
            assert!(count <= word.len(), "{count} keys of {} in {}", word.len(), word.label());
        }
        let permutation = gpu.array::<u32>("sort::permutation", count)?;
        let count = u32::try_from(count).expect("binding limits keep arrays below 2^32 elements");
        let tiles = count.div_ceil(self.tiling.tile_keys);
        self.make_room(gpu, count as usize, tiles as usize)?;
        let groups = self.bind(gpu, &words, &permutation)?;
        let mut run = gpu.stage("sort");
        run.clear(&self.seen);
        let examine_tile = EXAMINE_THREADS * EXAMINE_KEYS_PER_THREAD;
        for (word, group) in (0..).zip(&groups) {
            let pass = SortPass { count, tiles, digit: word * DIGITS_PER_WORD };
            run.dispatch(&self.examine, &[group], &pass, count.div_ceil(examine_tile));
        }
        let workgroups = tiles.div_ceil(self.tiling.tiles_per_workgroup);
        for digit in 0..keys.bits.div_ceil(DIGIT_BITS) {
            let pass = SortPass { count, tiles, digit };
            let group = &groups[(digit / DIGITS_PER_WORD) as usize];
            run.dispatch(&self.count, &[group], &pass, workgroups);
            run.dispatch(&self.scan, &[group], &pass, BINS as u32);
            run.dispatch(&self.scatter, &[group], &pass, workgroups);
        }
        let elapsed_ns = run.finish()?.elapsed_ns;
        Ok(Sorted { permutation, elapsed_ns })
    }

    /// Makes the arrays that depend on the number of keys, unless those there are large enough.
    fn make_room(&mut self, gpu: &Gpu, count: usize, tiles: usize) -> Result<(), GpuError> {
        if self.room.as_ref().is_some_and(|room| room.order.len() >= count) {
            return Ok(());
        }
        // Large arrays must not be there twice.
        self.room = None;
        self.room = Some(Room {
            keys: [gpu.array("sort::keys_a", count)?, gpu.array("sort::keys_b", count)?],
            order: gpu.array("sort::order_b", count)?,
            tile_counts: gpu.array("sort::tile_counts", tiles * BINS)?,
        });
        Ok(())
    }

    /// The bindings of the passes over each word.
    fn bind(
        &self,
        gpu: &Gpu,
        words: &[&DeviceArray<u32>],
        permutation: &DeviceArray<u32>,
    ) -> Result<Vec<wgpu::BindGroup>, GpuError> {
        let room = self.room.iter();
        let pairs = words.iter().flat_map(|word| room.clone().map(move |room| (word, room)));
        pairs
            .map(|(word, room)| {
                let resources = [
                    word.binding(),
                    room.keys[0].binding(),
                    room.keys[1].binding(),
                    permutation.binding(),
                    room.order.binding(),
                    room.tile_counts.binding(),
                    self.bin_totals.binding(),
                    self.seen.binding(),
                ];
                self.count.bind(gpu, 0, &resources)
            })
            .collect()
    }
}

/// The words of the keys, low first.
fn words_of(keys: &SortKeys) -> Vec<&DeviceArray<u32>> {
    let mut words = vec![&keys.low];
    if keys.bits > u32::BITS {
        words.push(keys.high.as_ref().expect("keys of more than 32 bits have high words"));
    }
    words
}

/// The whole module.
fn wgsl(tiling: &Tiling) -> String {
    let constants = [
        ("DIGIT_BITS", DIGIT_BITS),
        ("DIGITS_PER_WORD", DIGITS_PER_WORD),
        ("BINS", BINS as u32),
        ("SCAN_THREADS", SCAN_THREADS),
        ("EXAMINE_THREADS", EXAMINE_THREADS),
        ("EXAMINE_KEYS_PER_THREAD", EXAMINE_KEYS_PER_THREAD),
        ("TILE_THREADS", tiling.threads),
        ("TILE_KEYS", tiling.tile_keys),
    ];
    [
        &constants_wgsl(&constants),
        LINEAR_WORKGROUP_WGSL,
        WORKGROUP_SCAN_WGSL,
        include_str!("pass.wgsl"),
        include_str!("kernel.wgsl"),
        tiling.wgsl,
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::test_gpu;
    use crate::stages::sort::test_keys::{self, expected};

    fn upload(keys: &[u64], bits: u32) -> SortKeys {
        let gpu = test_gpu();
        let low: Vec<u32> = keys.iter().map(|&key| key as u32).collect();
        let high: Vec<u32> = keys.iter().map(|&key| (key >> 32) as u32).collect();
        SortKeys {
            low: gpu.array_of("test::low", &low).unwrap(),
            high: (bits > 32).then(|| gpu.array_of("test::high", &high).unwrap()),
            bits,
        }
    }

    fn check(sorter: &mut Sorter, keys: &[u64], bits: u32, what: &str) {
        let gpu = test_gpu();
        let sorted = sorter.sort(gpu, &upload(keys, bits), keys.len()).unwrap();
        let found = gpu.read_vec(&sorted.permutation).unwrap();
        let expected = expected(keys);
        let wrong = found.iter().zip(&expected).position(|(found, expected)| found != expected);
        assert_eq!(wrong, None, "first wrong place of {} {what} of {bits} bits", keys.len());
        assert_eq!(found.len(), keys.len());
    }

    #[test]
    fn keys_of_any_width_sort_like_the_standard_stable_sort() {
        // Borders of tiles of 64 keys, of workgroups of 32 such tiles, and of examined stretches.
        let mut sorter = Sorter::with_tiling(test_gpu(), Tiling::serial(32, 64)).unwrap();
        for count in [0, 1, 2, 3, 63, 64, 65, 2047, 2048, 2049, 8191, 8192, 8193, 20_011] {
            for (what, bits, keys) in test_keys::cases(count) {
                check(&mut sorter, &keys, bits, what);
            }
        }
    }

    #[test]
    fn a_sorter_serves_few_keys_after_many_and_many_after_few() {
        let mut sorter = Sorter::new(test_gpu()).unwrap();
        for count in [10, 70_003, 5, 150_001] {
            check(&mut sorter, &test_keys::random(count, 32, 1), 32, "random keys");
            check(&mut sorter, &test_keys::random(count, 64, 2), 64, "random keys");
        }
    }

    #[test]
    fn sixteen_million_keys_and_more() {
        let mut sorter = Sorter::new(test_gpu()).unwrap();
        let count = (1 << 24) + 12_345;
        check(&mut sorter, &test_keys::random(count, 24, 3), 24, "random keys");
    }

    #[test]
    #[ignore = "a measurement: run it alone, in a release build"]
    fn speed() {
        let gpu = test_gpu();
        let tilings = [(8, 1024), (16, 1024), (32, 512), (32, 1024), (32, 2048), (32, 4096)];
        for (threads, tile_keys) in tilings {
            let mut sorter = Sorter::with_tiling(gpu, Tiling::serial(threads, tile_keys)).unwrap();
            for bits in [16, 32, 64] {
                let keys = upload(&test_keys::random(2_000_000, bits, 1), bits);
                let mut times: Vec<u64> =
                    (0..7).map(|_| sorter.sort(gpu, &keys, 2_000_000).unwrap().elapsed_ns).collect();
                times.sort_unstable();
                println!("{threads} x {tile_keys}, {bits} bits: {:.1} Mkeys/s", 2e9 / times[3] as f64);
            }
        }
    }
}
