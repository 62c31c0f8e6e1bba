// What all kernels of the sort share: the arrays, and what a pass finds out about itself.
//
// Which digits differ is known on the device alone, so every pass is dispatched, and each decides
// there whether it runs, which arrays it reads and which it writes. No thread waits for the CPU.

struct SortPass {
    // Keys to sort.
    count: u32,
    // Tiles: stretches of consecutive keys that are counted apart.
    tiles: u32,
    // Which digit to sort by: 0 to 3 of the low word, 4 to 7 of the high word, lowest first.
    digit: u32,
}

// The word with the digit, in canonical order.
@group(0) @binding(0) var<storage, read> words: array<u32>;
// Pairs of word and index, read and written in turn. The last pass leaves its order in order_a.
@group(0) @binding(1) var<storage, read_write> keys_a: array<u32>;
@group(0) @binding(2) var<storage, read_write> keys_b: array<u32>;
@group(0) @binding(3) var<storage, read_write> order_a: array<u32>;
@group(0) @binding(4) var<storage, read_write> order_b: array<u32>;
// [bin][tile]: keys of a bin in a tile; after the scan, those of the bin in the tiles before.
@group(0) @binding(5) var<storage, read_write> tile_counts: array<u32>;
// Keys of each bin.
@group(0) @binding(6) var<storage, read_write> bin_totals: array<u32>;
// Bits that are 1 in some key, then bits that are 0 in some key, of the low and of the high word.
@group(0) @binding(7) var<storage, read_write> seen: array<atomic<u32>, 4>;

var<immediate> sort_pass: SortPass;

// Where a pass reads.
const FROM_WORDS: u32 = 0u;
const FROM_WORDS_BY_A: u32 = 1u;
const FROM_WORDS_BY_B: u32 = 2u;
const FROM_A: u32 = 3u;
const FROM_B: u32 = 4u;

struct Pair {
    key: u32,
    index: u32,
}

struct Plan {
    // False where the digit is the same in all keys.
    runs: bool,
    from_array: u32,
    writes_a: bool,
    // False in the last pass over a word: nobody reads the keys again.
    writes_keys: bool,
}

fn differing_digits(word: u32) -> u32 {
    let bits = atomicLoad(&seen[2u * word]) & atomicLoad(&seen[2u * word + 1u]);
    var digits = 0u;
    for (var digit = 0u; digit < DIGITS_PER_WORD; digit++) {
        let differs = extractBits(bits, digit * DIGIT_BITS, DIGIT_BITS) != 0u;
        digits |= u32(differs) << digit;
    }
    return digits;
}

fn plan_pass() -> Plan {
    var digits = differing_digits(0u) | (differing_digits(1u) << DIGITS_PER_WORD);
    if digits == 0u {
        // All keys are equal: one pass over a constant digit writes the canonical order.
        digits = 1u;
    }
    let before = digits & ((1u << sort_pass.digit) - 1u);
    let after = digits >> (sort_pass.digit + 1u);
    let first_of_word = sort_pass.digit / DIGITS_PER_WORD * DIGITS_PER_WORD;
    let before_in_word = before >> first_of_word;
    let after_in_word = after & ((1u << (first_of_word + DIGITS_PER_WORD - 1u - sort_pass.digit)) - 1u);
    var plan: Plan;
    plan.runs = ((digits >> sort_pass.digit) & 1u) == 1u;
    // The last pass writes a, the one before it b, and so on.
    plan.writes_a = (countOneBits(after) & 1u) == 0u;
    plan.writes_keys = after_in_word != 0u;
    if before == 0u {
        plan.from_array = FROM_WORDS;
    } else if before_in_word == 0u {
        plan.from_array = select(FROM_WORDS_BY_A, FROM_WORDS_BY_B, plan.writes_a);
    } else {
        plan.from_array = select(FROM_A, FROM_B, plan.writes_a);
    }
    return plan;
}

fn bin_of(key: u32) -> u32 {
    return extractBits(key, sort_pass.digit % DIGITS_PER_WORD * DIGIT_BITS, DIGIT_BITS);
}

fn key_at(place: u32, from_array: u32) -> u32 {
    switch from_array {
        case FROM_A: { return keys_a[place]; }
        case FROM_B: { return keys_b[place]; }
        case FROM_WORDS: { return words[place]; }
        case FROM_WORDS_BY_A: { return words[order_a[place]]; }
        default: { return words[order_b[place]]; }
    }
}

fn pair_at(place: u32, from_array: u32) -> Pair {
    switch from_array {
        case FROM_A: { return Pair(keys_a[place], order_a[place]); }
        case FROM_B: { return Pair(keys_b[place], order_b[place]); }
        case FROM_WORDS: { return Pair(words[place], place); }
        case FROM_WORDS_BY_A: {
            let index = order_a[place];
            return Pair(words[index], index);
        }
        default: {
            let index = order_b[place];
            return Pair(words[index], index);
        }
    }
}

fn write_pair(place: u32, pair: Pair, plan: Plan) {
    if plan.writes_a {
        order_a[place] = pair.index;
        if plan.writes_keys {
            keys_a[place] = pair.key;
        }
    } else {
        order_b[place] = pair.index;
        if plan.writes_keys {
            keys_b[place] = pair.key;
        }
    }
}
