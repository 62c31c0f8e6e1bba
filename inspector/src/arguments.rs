//! Words that several commands take.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use formats::ray::Kind;

/// Kinds of rays by their names.
pub(crate) fn kind() -> impl TypedValueParser<Value = Kind> {
    PossibleValuesParser::new(Kind::ALL.map(Kind::name)).try_map(|name| {
        Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or("expected closest or shadow")
    })
}
