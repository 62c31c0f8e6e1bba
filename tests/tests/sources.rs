//! Holds what every source file promises: what it is for, its length, and why its unsafe code is sound.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use tests::sources::{Source, files};

const LONGEST_FILE: usize = 600;

/// How many lines above `unsafe` its reason may begin.
const REASON_WITHIN: usize = 8;

fn all_sources() -> Vec<Source> {
    let mut sources = files("", "rs");
    sources.extend(files("", "wgsl"));
    sources
}

#[test]
fn every_file_begins_with_what_it_is_for() {
    for source in all_sources() {
        // WGSL has no inner doc comments.
        let start = if source.path.ends_with(".rs") { "//! " } else { "//" };
        let first = source.text.lines().next().unwrap_or_default();
        assert!(
            first.starts_with(start) && first.len() > 12,
            "{}: line 1 says {first:?}, not what the file is for",
            source.path
        );
    }
}

#[test]
fn no_file_is_longer_than_600_lines() {
    for source in all_sources() {
        let lines = source.text.lines().count();
        assert!(
            lines <= LONGEST_FILE,
            "{} has {lines} lines, more than {LONGEST_FILE}; split it by concept",
            source.path
        );
    }
}

/// Numbers (from 1) of the lines of unsafe code without a reason in the lines above.
fn unreasoned_unsafe(text: &str) -> Vec<usize> {
    let lines: Vec<&str> = text.lines().collect();
    let is_unsafe = |line: &str| {
        let code = line.split("//").next().unwrap();
        ["{", "fn", "impl", "extern"].iter().any(|next| code.contains(&format!("unsafe {next}")))
    };
    let has_reason = |index: usize| {
        // A comment right above counts whole.
        let comment = lines[..index].iter().rev().take_while(|line| line.trim_start().starts_with("//"));
        lines[index.saturating_sub(REASON_WITHIN)..=index]
            .iter()
            .chain(comment)
            .any(|line| line.contains("SAFETY:") || line.contains("# Safety"))
    };
    (0..lines.len())
        .filter(|&index| is_unsafe(lines[index]) && !has_reason(index))
        .map(|index| index + 1)
        .collect()
}

#[test]
fn all_unsafe_code_says_why_it_is_sound() {
    let reasoned = format!("// SAFETY: the map is read-only\nlet a = unsafe {} f() }};\n", '{');
    assert!(unreasoned_unsafe(&reasoned).is_empty(), "the check must accept a reason");
    assert_eq!(
        unreasoned_unsafe(&reasoned.replace("SAFETY", "note")),
        [2],
        "the check must find a missing one"
    );
    for source in files("", "rs").iter().filter(|source| source.path != file!()) {
        let found = unreasoned_unsafe(&source.text);
        assert!(found.is_empty(), "{}: unsafe without a SAFETY line above, at lines {found:?}", source.path);
    }
}
