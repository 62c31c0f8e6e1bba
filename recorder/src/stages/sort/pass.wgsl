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
    // The digits that keys have, a bit each.
    digits: u32,
    // 1 where those get no pass whose bits are the same in all keys, as a look at the keys found.
    skips: u32,
    // Which of the two totals is this sort's; the other one is cleared for the next.
    half: u32,
}

struct Totals {
    // Bits that are 1 in some key, then bits that are 0 in some key, of the low and of the high word.
    seen: array<atomic<u32>, 4>,
    // Keys of each bin, digit by digit; the serial kernels count one digit at a time, in the first bins.
    bins: array<atomic<u32>, 2u * DIGITS_PER_WORD * BINS>,
}

// What tiles have counted is binding 6, declared by each way to tile.
// The words of the keys in canonical order; the high words only where keys have them.
@group(0) @binding(0) var<storage, read> low_words: array<u32>;
@group(0) @binding(1) var<storage, read> high_words: array<u32>;
// Pairs of word and index, read and written in turn. The last pass leaves its order in order_a.
@group(0) @binding(2) var<storage, read_write> keys_a: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys_b: array<u32>;
@group(0) @binding(4) var<storage, read_write> order_a: array<u32>;
@group(0) @binding(5) var<storage, read_write> order_b: array<u32>;
@group(0) @binding(7) var<storage, read_write> totals: array<Totals, 2>;

var<immediate> sort_pass: SortPass;

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
    // Alternates between 0 and 1 over the passes that run.
    turn: u32,
    source: u32,
    writes_a: bool,
    word_written: u32,
}

fn differing_digits(word: u32) -> u32 {
    let bits = atomicLoad(&totals[sort_pass.half].seen[2u * word]) & atomicLoad(&totals[sort_pass.half].seen[2u * word + 1u]);
    var digits = 0u;
    for (var digit = 0u; digit < DIGITS_PER_WORD; digit++) {
        let differs = extractBits(bits, digit * DIGIT_BITS, DIGIT_BITS) != 0u;
        digits |= u32(differs) << digit;
    }
    return digits;
}

fn plan_pass() -> Plan {
    var digits = sort_pass.digits;
    if sort_pass.skips == 1u {
        // If all keys are equal, one pass over a constant digit writes the canonical order.
        digits = max(1u, differing_digits(0u) | (differing_digits(1u) << DIGITS_PER_WORD));
    }
    let before = digits & ((1u << sort_pass.digit) - 1u);
    let after = digits & ~((2u << sort_pass.digit) - 1u);
    let is_low = sort_pass.digit < DIGITS_PER_WORD;
    let after_in_low = after & ((1u << DIGITS_PER_WORD) - 1u);
    var plan: Plan;
    plan.runs = ((digits >> sort_pass.digit) & 1u) == 1u;
    plan.turn = countOneBits(before) & 1u;
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

// For the next sort, by the threads of one workgroup.
fn clear_next_totals(thread: u32, threads: u32) {
    let next = 1u - sort_pass.half;
    for (var entry = thread; entry < 2u * DIGITS_PER_WORD * BINS; entry += threads) {
        atomicStore(&totals[next].bins[entry], 0u);
    }
    for (var word = thread; word < 4u; word += threads) {
        atomicStore(&totals[next].seen[word], 0u);
    }
}

fn bin_of(key: u32) -> u32 {
    return extractBits(key, sort_pass.digit % DIGITS_PER_WORD * DIGIT_BITS, DIGIT_BITS);
}

fn key_at(place: u32, source: u32) -> u32 {
    switch source {
        case FROM_A: { return keys_a[place]; }
        case FROM_B: { return keys_b[place]; }
        case FROM_LOW_WORDS: { return low_words[place]; }
        default: { return high_words[place]; }
    }
}

fn write_index(place: u32, index: u32, plan: Plan) {
    if plan.writes_a { order_a[place] = index; } else { order_b[place] = index; }
}

fn write_word(place: u32, word: u32, plan: Plan) {
    if plan.writes_a { keys_a[place] = word; } else { keys_b[place] = word; }
}
