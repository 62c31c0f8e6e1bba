//! A filter as a tree of numbers and conditions: what was parsed has the right types.

use std::ops::Range;

use formats::key::Coordinate;
use formats::metrics::quantity::Quantity;

/// A number of a ray.
#[derive(Clone, Debug, PartialEq)]
pub enum Number {
    /// The same for all rays.
    Literal(f64),
    /// What the ray has, and where in the text it was asked for.
    Quantity(Quantity, Range<usize>),
    /// The whole number of a coordinate's bits in the key, and where in the text it was asked for.
    Field(Coordinate, Range<usize>),
    /// A function of a number.
    Call(Function, Box<Number>),
    /// Of two numbers.
    Binary(Arithmetic, Box<[Number; 2]>),
}

/// What a ray meets or not.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Of the ray itself.
    Fact(Fact),
    /// How two numbers compare.
    Compare(Comparison, Box<[Number; 2]>),
    /// The opposite.
    Not(Box<Condition>),
    /// Two conditions together.
    Both(Connective, Box<[Condition; 2]>),
}

macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $word:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[$variant_doc])* $variant,)* }

        impl $name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// How it is written.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }

            /// The one that is written so.
            pub fn of_name(name: &str) -> Option<Self> {
                match name { $($word => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

words! {
    /// A condition that has a name.
    Fact {
        /// A surface was hit.
        Hit = "hit",
        /// It is a shadow ray.
        Shadow = "shadow",
    }
}

words! {
    /// A function of one number.
    Function {
        /// Absolute value.
        Absolute = "abs",
        /// Logarithm to the base 2.
        Logarithm = "log2",
        /// The opposite number.
        Minus = "-",
    }
}

words! {
    /// What two numbers become.
    Arithmetic {
        /// Sum.
        Plus = "+",
        /// Difference.
        Minus = "-",
        /// Product.
        Times = "*",
        /// Quotient.
        Over = "/",
    }
}

words! {
    /// How two numbers compare. A number that a ray does not have is equal to nothing.
    Comparison {
        /// Less.
        Less = "<",
        /// Less or equal.
        AtMost = "<=",
        /// More.
        More = ">",
        /// More or equal.
        AtLeast = ">=",
        /// Equal.
        Equal = "==",
        /// Not equal.
        Unequal = "!=",
    }
}

words! {
    /// What two conditions become.
    Connective {
        /// Both are met.
        And = "&&",
        /// One of them is met, or both.
        Or = "||",
    }
}

impl Function {
    /// Of a number.
    pub fn of(self, value: f64) -> f64 {
        match self {
            Self::Absolute => value.abs(),
            Self::Logarithm => value.log2(),
            Self::Minus => -value,
        }
    }
}

impl Arithmetic {
    /// Of two numbers.
    pub fn of(self, left: f64, right: f64) -> f64 {
        match self {
            Self::Plus => left + right,
            Self::Minus => left - right,
            Self::Times => left * right,
            Self::Over => left / right,
        }
    }
}

impl Comparison {
    /// Whether two numbers compare so.
    #[expect(clippy::float_cmp, reason = "what is asked for is whether they are the same number")]
    pub fn of(self, left: f64, right: f64) -> bool {
        match self {
            Self::Less => left < right,
            Self::AtMost => left <= right,
            Self::More => left > right,
            Self::AtLeast => left >= right,
            Self::Equal => left == right,
            Self::Unequal => left != right,
        }
    }
}

impl Connective {
    /// Of two conditions.
    pub fn of(self, left: bool, right: bool) -> bool {
        match self {
            Self::And => left && right,
            Self::Or => left || right,
        }
    }
}
