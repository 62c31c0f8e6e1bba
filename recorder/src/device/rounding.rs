//! Arithmetic that is rounded as it is written: what traces rays and makes keys is written in it, so that every device
//! finds the hits and keys that threads find. WGSL promises neither quotients as IEEE 754 has them nor that a product
//! is rounded before it is added to.

/// What a device rounds otherwise than IEEE 754 has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounding {
    /// `a·b + c` may be rounded once.
    pub contracts: bool,
    /// Quotients and square roots may be off by a few units in the last place.
    pub divides_roughly: bool,
}

impl Rounding {
    /// Of a device that was not asked yet: the guard that costs little stands.
    pub const UNKNOWN: Self = Self { contracts: true, divides_roughly: false };

    /// `fn rounded(x: f32) -> f32`, for products before a sum, and for sums of a constant before a product, which compilers
    /// multiply out; `rounded3` of three, `quotient(a, b)` and `root(x)`.
    /// `zero` is an expression whose value is 0, as no compiler knows.
    pub fn wgsl(self, zero: &str) -> String {
        // A product that went through an integer operation is no product any more.
        let [one, three] = match self.contracts {
            true => [
                format!("bitcast<f32>(bitcast<u32>(x) | ({zero}))"),
                format!("bitcast<vec3<f32>>(bitcast<vec3<u32>>(x) | vec3<u32>({zero}))"),
            ],
            false => ["x", "x"].map(str::to_owned),
        };
        let products = format!(
            "fn rounded(x: f32) -> f32 {{\n    return {one};\n}}\n\n\
             fn rounded3(x: vec3<f32>) -> vec3<f32> {{\n    return {three};\n}}\n"
        );
        products + if self.divides_roughly { include_str!("quotients.wgsl") } else { QUOTIENTS }
    }
}

const QUOTIENTS: &str = "
fn quotient(a: f32, b: f32) -> f32 {
    return a / b;
}

fn root(x: f32) -> f32 {
    return sqrt(x);
}
";
