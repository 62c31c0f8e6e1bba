//! A filter as a tree, and the operators and functions that it is made of.

use std::ops::Range;

use formats::key::Coordinate;
use formats::metrics::quantity::Quantity;

/// Places that each node is evaluated for at a time.
pub(super) const BLOCK: usize = 256;

/// A value for each place of a block. A condition is 1 where it is met, else 0.
pub(super) type Block = [f64; BLOCK];

/// A part of a filter whose operands have the right kinds.
#[derive(Clone, Debug)]
pub(super) enum Node {
    /// The same for all rays.
    Literal(f64),
    /// What the ray has, and where in the text it was asked for.
    Quantity(Quantity, Range<usize>),
    /// The whole number of a coordinate's bits in the key, and where in the text it was asked for.
    Field(Coordinate, Range<usize>),
    Fact(Fact),
    Unary(&'static Function, Box<Node>),
    Binary(&'static Operator, Box<[Node; 2]>),
}

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueKind {
    Number,
    Condition,
}

/// A condition that has a name.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fact {
    /// A surface was hit.
    Hit,
    /// It is a shadow ray.
    Shadow,
}

/// The facts by their names.
pub(super) const FACTS: [(&str, Fact); 2] = [("hit", Fact::Hit), ("shadow", Fact::Shadow)];

/// Makes a value of another one of the same kind.
#[derive(Debug)]
pub(super) struct Function {
    pub(super) name: &'static str,
    pub(super) kind: ValueKind,
    pub(super) of: fn(f64) -> f64,
}

/// Functions that are called.
pub(super) static FUNCTIONS: [Function; 2] = [
    Function { name: "abs", kind: ValueKind::Number, of: f64::abs },
    Function { name: "log2", kind: ValueKind::Number, of: f64::log2 },
];

/// Signs before a value.
pub(super) static PREFIXES: [Function; 2] = [
    Function { name: "-", kind: ValueKind::Number, of: |value| -value },
    Function { name: "!", kind: ValueKind::Condition, of: |met| 1.0 - met },
];

/// Stands between two values of the same kind.
#[derive(Debug)]
pub(super) struct Operator {
    pub(super) sign: &'static str,
    /// How tightly it binds: 0 to [`LEVELS`] - 1.
    pub(super) level: usize,
    pub(super) takes: ValueKind,
    pub(super) gives: ValueKind,
    /// Puts the result in place of the left values.
    pub(super) apply: fn(&mut Block, &Block),
    /// What of the left condition decides, whatever the right one is.
    pub(super) decided_by: Option<bool>,
}

/// How many levels of binding there are.
pub(super) const LEVELS: usize = 5;
/// The level of comparisons, which are not chained.
pub(super) const COMPARISONS: usize = 2;

/// All operators. A number that a ray does not have, NaN, is equal to nothing.
#[expect(clippy::float_cmp, reason = "what is asked for is whether they are the same number")]
pub(super) static OPERATORS: [Operator; 12] = [
    connective("||", 0, |left, right| each(left, right, f64::max), true),
    connective("&&", 1, |left, right| each(left, right, f64::min), false),
    comparison("<", |left, right| each(left, right, |a, b| f64::from(a < b))),
    comparison("<=", |left, right| each(left, right, |a, b| f64::from(a <= b))),
    comparison(">", |left, right| each(left, right, |a, b| f64::from(a > b))),
    comparison(">=", |left, right| each(left, right, |a, b| f64::from(a >= b))),
    comparison("==", |left, right| each(left, right, |a, b| f64::from(a == b))),
    comparison("!=", |left, right| each(left, right, |a, b| f64::from(a != b))),
    arithmetic("+", 3, |left, right| each(left, right, |a, b| a + b)),
    arithmetic("-", 3, |left, right| each(left, right, |a, b| a - b)),
    arithmetic("*", 4, |left, right| each(left, right, |a, b| a * b)),
    arithmetic("/", 4, |left, right| each(left, right, |a, b| a / b)),
];

/// A loop for each operator, so that none is looked up for each value.
fn each(left: &mut Block, right: &Block, of: impl Fn(f64, f64) -> f64) {
    left.iter_mut().zip(right).for_each(|(left, right)| *left = of(*left, *right));
}

const fn connective(
    sign: &'static str,
    level: usize,
    apply: fn(&mut Block, &Block),
    decided_by: bool,
) -> Operator {
    let kind = ValueKind::Condition;
    Operator { sign, level, takes: kind, gives: kind, apply, decided_by: Some(decided_by) }
}

const fn comparison(sign: &'static str, apply: fn(&mut Block, &Block)) -> Operator {
    let (takes, gives) = (ValueKind::Number, ValueKind::Condition);
    Operator { sign, level: COMPARISONS, takes, gives, apply, decided_by: None }
}

const fn arithmetic(sign: &'static str, level: usize, apply: fn(&mut Block, &Block)) -> Operator {
    let kind = ValueKind::Number;
    Operator { sign, level, takes: kind, gives: kind, apply, decided_by: None }
}
