//! Folders that say what is in them, as Hive, DuckDB, Polars and Spark read them: `NAME=VALUE`, percent-escaped.

use std::path::PathBuf;

use formats::manifest::QueueId;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

/// What stands for itself in a folder's name, everywhere.
const PLAIN: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.');

/// Bytes of the longest value, escaped: file systems hold names of 255.
const BYTES_MAX: usize = 240;

/// The folder of a queue's rays in the order of a method, below that of all rays.
pub(super) fn folder(scene: &str, machine: &str, queue: QueueId, method: &str) -> PathBuf {
    let parts: [(&str, &str); 5] = [
        ("scene", scene),
        ("machine", machine),
        ("bounce", &queue.bounce.to_string()),
        ("kind", queue.kind.name()),
        ("method", method),
    ];
    parts.iter().map(|(name, value)| format!("{name}={}", escaped(value))).collect()
}

fn escaped(value: &str) -> String {
    utf8_percent_encode(value, PLAIN).to_string()
}

/// A name that its folder has room for: longer ones are cut, here and in the tables.
pub(super) fn cut(name: &str) -> String {
    let mut bytes = 0;
    let fits = |character: &char| {
        bytes += escaped(character.encode_utf8(&mut [0; 4])).len();
        bytes <= BYTES_MAX
    };
    name.chars().take_while(fits).collect()
}

#[cfg(test)]
mod tests {
    use formats::ray::Kind;

    use super::*;

    #[test]
    fn values_are_escaped_and_numbers_are_numbers() {
        let queue = QueueId { pass: 3, bounce: 1, kind: Kind::Shadow };
        let found = folder("a=b/c d%", "cpu, größer", queue, "two-point");
        let expected =
            "scene=a%3Db%2Fc%20d%25/machine=cpu%2C%20gr%C3%B6%C3%9Fer/bounce=1/kind=shadow/method=two-point";
        assert_eq!(found, PathBuf::from(expected));
        assert_eq!(folder("..", ".", queue, "x").components().count(), 5);
    }

    #[test]
    fn names_are_cut_between_characters() {
        assert_eq!(cut("kitchen"), "kitchen");
        assert_eq!(cut(&"a".repeat(500)).len(), BYTES_MAX);
        let long = cut(&"ß".repeat(500));
        assert_eq!(long, "ß".repeat(BYTES_MAX / 6));
    }
}
