// Traced lengths and the query of the length table: the same on threads is `formats::length_table`.

fn fixed_point(length: f32) -> u32 {
    return u32(min(length, LONGEST_SUMMED) * FIXED_POINT_ONE);
}

// ⌊(high·2³² + low) / count⌋ by long division; the mean fits 32 bits (docs/keys.md).
fn mean_fixed_point(low: u32, high: u32, count: u32) -> u32 {
    if high == 0u {
        return low / count;
    }
    var rest = high % count;
    var quotient = 0u;
    for (var bit = 31; bit >= 0; bit--) {
        let carry = rest >> 31u;
        rest = (rest << 1u) | ((low >> u32(bit)) & 1u);
        quotient = quotient << 1u;
        if carry == 1u || rest >= count {
            rest = rest - count;
            quotient = quotient | 1u;
        }
    }
    return quotient;
}

fn mean_length(low: u32, high: u32, count: u32) -> f32 {
    return f32(mean_fixed_point(low, high, count) >> 1u) * MEAN_SCALE;
}
