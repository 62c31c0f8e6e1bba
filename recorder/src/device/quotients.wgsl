// Quotients and roots that are the nearest floats, but for one in ten million, for devices whose own are off by a few
// units in the last place: Markstein 2000, "IA-64 and Elementary Functions". `fma` gives what is left of a quotient
// without an error; where a driver makes two operations of it, the self-check says that rays and keys differ.

fn exponent(x: f32) -> i32 {
    return i32((bitcast<u32>(x) >> 23u) & 255u);
}

fn quotient(dividend: f32, divisor: f32) -> f32 {
    // A sum that is divided may be multiplied out.
    let a = rounded(dividend);
    let b = rounded(divisor);
    let rough = 1.0 / b;
    let inverse = fma(fma(-b, rough, 1.0), rough, rough);
    let first = a * inverse;
    let second = fma(fma(-b, first, a), inverse, first);
    let nearest = fma(fma(-b, second, a), inverse, second);
    // Where nothing on the way is too large or too small to be exact.
    let apart = exponent(a) - exponent(b);
    let is_exact = exponent(a) > 30 && exponent(a) < 255 && exponent(b) > 1 && exponent(b) < 253 && apart > -120 && apart < 126;
    return select(a / b, nearest, is_exact);
}

fn root(x: f32) -> f32 {
    let rough = sqrt(x);
    let half = 0.5 / rough;
    let second = fma(fma(-rough, rough, x), half, rough);
    let nearest = fma(fma(-second, second, x), half, second);
    return select(rough, nearest, exponent(x) > 30 && exponent(x) < 255);
}
