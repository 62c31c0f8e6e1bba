//! Text that came from a file or was typed, on its way to a terminal or a shell; counts for people.

use std::borrow::Cow;

/// Whether a terminal would do more with a character than show it: control characters but line feed and
/// tab, and the marks that turn the direction of the text around them.
fn is_unsafe(character: char) -> bool {
    let steers = character.is_control() && character != '\n' && character != '\t';
    let turns = matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    steers || turns
}

fn with_escapes(text: &str, escape: fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(is_unsafe) {
        return Cow::Borrowed(text);
    }
    let escaped = |character| if is_unsafe(character) { escape(character) } else { character.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// The text with every character that steers a terminal or turns the direction of text written as
/// `\u{1b}`. Line feeds and tabs stay: names that must keep to a line take [`one_line`].
pub fn printable(text: &str) -> Cow<'_, str> {
    with_escapes(text, |character| character.escape_unicode().to_string())
}

/// JSON with the same characters escaped in JSON's own way, so that it stays JSON.
pub fn printable_json(json: &str) -> Cow<'_, str> {
    // All of them lie below 2^16, where one escape is enough.
    with_escapes(json, |character| format!("\\u{:04x}", u32::from(character)))
}

/// A name from a file as messages show it: on one line, not endless.
pub(crate) fn shown(name: &str) -> String {
    one_line(name, 100)
}

/// A name from a file on one line, at most `characters` long; a longer one ends in `…`.
pub fn one_line(name: &str, characters: usize) -> String {
    let escaped = |character: char| match character {
        '\n' | '\t' => character.escape_default().to_string(),
        _ if is_unsafe(character) => character.escape_unicode().to_string(),
        _ => character.to_string(),
    };
    let mut shown: String = name.chars().take(characters).map(escaped).collect();
    // Escapes are longer than what they stand for.
    let cut = shown.char_indices().nth(characters).map(|(at, _)| at);
    if cut.is_some() || name.chars().nth(characters).is_some() {
        shown.truncate(
            shown.char_indices().nth(characters.saturating_sub(1)).map_or(shown.len(), |(at, _)| at),
        );
        shown.push('…');
    }
    shown
}

/// Text in lines of at most `columns` characters, broken at blanks; all lines but the first begin with `indent` blanks.
/// A word that is longer stays whole.
pub fn wrapped(text: &str, columns: usize, indent: usize) -> String {
    let mut lines = String::new();
    let mut used = 0;
    for word in text.split(' ') {
        let length = word.chars().count();
        if used > 0 && used + 1 + length > columns {
            lines.push('\n');
            lines.push_str(&" ".repeat(indent));
            used = indent;
        } else if used > 0 {
            lines.push(' ');
            used += 1;
        }
        lines.push_str(word);
        used += length;
    }
    lines
}

/// A word as it is typed into a shell: in quotes where a shell would split it or see more than text.
pub fn shell_word(word: &str) -> Cow<'_, str> {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_=./:,+@%".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        return Cow::Borrowed(word);
    }
    Cow::Owned(format!("'{}'", word.replace('\'', r"'\''")))
}

/// A count with its digits in groups of three: `2,073,600`.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// A count and what is counted: `1 light`, `3 lights`.
pub fn counted(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", count(number), if number == 1 { one } else { many })
}

/// The known word that a mistyped one is most like, if it is like any.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    // Half of a word may be wrong, so that 'len' is 'length'; nothing is like a single letter, or like what nobody
    // would type.
    let like = |known: &&'a str| (strsim::jaro_winkler(name, known), *known);
    let best = known.iter().filter(|_| name.len() <= 100).map(like).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= 0.75).then_some(best.1)
}

/// For a message about an unknown word: the known one that is near, else all of them.
pub fn did_you_mean(name: &str, known: &[&str]) -> String {
    match nearest(name, known) {
        Some(meant) => format!("did you mean '{meant}'?"),
        None => format!("there are {}", known.join(" ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_word_is_named_if_it_is_near() {
        let known = ["origin", "octahedron", "light-octahedron", "two-point", "two-point-real"];
        for (found, meant) in [
            ("octahedrn", "octahedron"),
            ("lightoctahedron", "light-octahedron"),
            ("orgin", "origin"),
            ("two-pont", "two-point"),
            ("twopoint-real", "two-point-real"),
        ] {
            assert_eq!(did_you_mean(found, &known), format!("did you mean '{meant}'?"));
        }
        for far in ["", "nope", "xyz", &"octahedron".repeat(50)] {
            let all = "there are origin octahedron light-octahedron two-point two-point-real";
            assert_eq!(did_you_mean(far, &known), all, "{far}");
        }
    }

    #[test]
    fn what_steers_a_terminal_is_escaped() {
        assert_eq!(printable("a\x1b[2Jb\u{202e}c\u{9b}\r"), "a\\u{1b}[2Jb\\u{202e}c\\u{9b}\\u{d}");
        for same in ["two\nlines\tand a tab", "größer × 2 → \u{1f600}", ""] {
            assert!(matches!(printable(same), Cow::Borrowed(shown) if shown == same));
        }
    }

    #[test]
    fn json_stays_json() {
        for text in ["plain", "\u{9b}2J \u{202e} \\u{9b} \x1b"] {
            let json = serde_json::to_string(text).unwrap();
            let shown = printable_json(&json).into_owned();
            assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), text);
            assert!(!shown.contains(is_unsafe), "{shown:?}");
        }
    }

    #[test]
    fn lines_are_as_long_as_they_may_be() {
        assert_eq!(wrapped("one two three four", 9, 2), "one two\n  three\n  four");
        assert_eq!(wrapped("one two", 7, 0), "one two");
        assert_eq!(wrapped("endless words", 3, 0), "endless\nwords");
        assert_eq!(wrapped("note     kept", 20, 9), "note     kept");
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        for (word, typed) in [
            ("a/b-1.raydump", "a/b-1.raydump"),
            ("a b.glb", "'a b.glb'"),
            ("--method=mine=(ox)*4", "'--method=mine=(ox)*4'"),
            ("it's", r"'it'\''s'"),
            ("größer", "'größer'"),
            ("", "''"),
        ] {
            assert_eq!(shell_word(word), typed);
        }
    }

    #[test]
    fn counts_are_written_for_people() {
        assert_eq!([count(0), count(999), count(1000), count(2_073_600)], ["0", "999", "1,000", "2,073,600"]);
        assert_eq!(
            [0, 1, 2000].map(|number| counted(number, "pass", "passes")),
            ["0 passes", "1 pass", "2,000 passes"]
        );
    }

    #[test]
    fn names_keep_to_a_line_and_a_length() {
        assert_eq!(one_line("kitchen", 7), "kitchen");
        assert_eq!(one_line("it's \"a\\b\"", 40), "it's \"a\\b\"");
        assert_eq!(one_line("kitchens", 7), "kitche…");
        assert_eq!(one_line("a\nb\u{202e}", 40), "a\\nb\\u{202e}");
        assert_eq!(one_line(&"\n".repeat(5_000_000), 4), "\\n\\…");
    }
}
