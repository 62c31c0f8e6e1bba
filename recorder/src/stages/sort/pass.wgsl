// What all kernels of the sort share: the arrays, and what a pass finds out about itself.
//
// Where a look at the keys says which digits differ, the device alone knows: every pass is dispatched, and decides
// there whether it runs, which arrays it reads and which it writes. No thread waits for the CPU.

struct SortPass {
    // Keys to sort.
    count: u32,
    // Tiles: stretches of consecutive keys that are counted apart.
    tiles: u32,
    // Which digit to sort by: 0 to 3 of the low word, 4 to 7 of the high word, lowest first.
    digit: u32,
    // The digits that get a pass, a bit each; 0 where a look at the keys says.
    digits: u32,
}

struct Totals {
    // Bits that are 1 in some key, then bits that are 0 in some key, of the low and of the high word.
    seen: array<atomic<u32>, 4>,
    // Keys of each bin.
    bins: array<u32, BINS>,
}

// The words of the keys in canonical order; the high words only where keys have them.
@group(0) @binding(0) var<storage, read> low_words: array<u32>;
@group(0) @binding(1) var<storage, read> high_words: array<u32>;
// Pairs of word and index, read and written in turn. The last pass leaves its order in order_a.
@group(0) @binding(2) var<storage, read_write> keys_a: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys_b: array<u32>;
@group(0) @binding(4) var<storage, read_write> order_a: array<u32>;
@group(0) @binding(5) var<storage, read_write> order_b: array<u32>;
// [bin][tile]: keys of a bin in a tile; after the scan, those of the bin in the tiles before.
@group(0) @binding(6) var<storage, read_write> tile_counts: array<u32>;
@group(0) @binding(7) var<storage, read_write> totals: Totals;

var<immediate> sort_pass: SortPass;

struct Pair {
    key: u32,
    index: u32,
}

// Where a pass reads its pairs.
const FROM_LOW_WORDS: u32 = 0u;
const FROM_HIGH_WORDS: u32 = 1u;
const FROM_A: u32 = 2u;
const FROM_B: u32 = 3u;

// What a pass writes as keys.
const SAME_WORD: u32 = 0u;
// The last pass over the low word hands over the high words.
const HIGH_WORD: u32 = 1u;
// Nobody reads them after the last pass.
const NO_WORD: u32 = 2u;

struct Plan {
    // False where the digit is the same in all keys.
    runs: bool,
    source: u32,
    writes_a: bool,
    word_written: u32,
}

fn differing_digits(word: u32) -> u32 {
    let bits = atomicLoad(&totals.seen[2u * word]) & atomicLoad(&totals.seen[2u * word + 1u]);
    var digits = 0u;
    for (var digit = 0u; digit < DIGITS_PER_WORD; digit++) {
        let differs = extractBits(bits, digit * DIGIT_BITS, DIGIT_BITS) != 0u;
        digits |= u32(differs) << digit;
    }
    return digits;
}

fn plan_pass() -> Plan {
    var digits = sort_pass.digits;
    if digits == 0u {
        // If all keys are equal, one pass over a constant digit writes the canonical order.
        digits = max(1u, differing_digits(0u) | (differing_digits(1u) << DIGITS_PER_WORD));
    }
    let before = digits & ((1u << sort_pass.digit) - 1u);
    let after = digits & ~((2u << sort_pass.digit) - 1u);
    let is_low = sort_pass.digit < DIGITS_PER_WORD;
    let after_in_low = after & ((1u << DIGITS_PER_WORD) - 1u);
    var plan: Plan;
    plan.runs = ((digits >> sort_pass.digit) & 1u) == 1u;
    // The last pass writes a, the one before it b, and so on.
    plan.writes_a = (countOneBits(after) & 1u) == 0u;
    plan.source = select(FROM_A, FROM_B, plan.writes_a);
    if before == 0u {
        plan.source = select(FROM_HIGH_WORDS, FROM_LOW_WORDS, is_low);
    }
    plan.word_written = SAME_WORD;
    if after == 0u {
        plan.word_written = NO_WORD;
    } else if is_low && after_in_low == 0u {
        plan.word_written = HIGH_WORD;
    }
    return plan;
}

fn bin_of(key: u32) -> u32 {
    return extractBits(key, sort_pass.digit % DIGITS_PER_WORD * DIGIT_BITS, DIGIT_BITS);
}

fn write_pair(place: u32, pair: Pair, plan: Plan) {
    var key = pair.key;
    if plan.word_written == HIGH_WORD {
        key = high_words[pair.index];
    }
    if plan.writes_a {
        order_a[place] = pair.index;
        if plan.word_written != NO_WORD {
            keys_a[place] = key;
        }
    } else {
        order_b[place] = pair.index;
        // The last pass writes a, so somebody reads these.
        keys_b[place] = key;
    }
}
