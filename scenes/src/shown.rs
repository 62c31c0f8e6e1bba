//! Text from a file, as messages and names may show it: on one line, without what a terminal obeys, not
//! endless.

use std::path::Path;

/// Longest text that is shown whole, in characters.
const LONGEST: usize = 200;

/// `text` with control and invisible characters escaped, cut where it gets too long.
pub(crate) fn shown(text: &str) -> String {
    let end = text.char_indices().nth(LONGEST).map(|(end, _)| end);
    let mut shown = escaped(&text[..end.unwrap_or(text.len())]);
    if end.is_some() {
        shown.push('…');
    }
    shown
}

/// A path with the same characters escaped, but whole: systems bound its length.
pub(crate) fn shown_path(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '"' | '\'' | '\\' => escaped.push(character),
            // After another character, so that an accent that belongs to it stays.
            _ => escaped.extend(format!("_{character}").escape_debug().skip(1)),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_and_nothing_else_does() {
        for text in ["", "nave", "it's \"quoted\" \\ here", "Küche 台所", "Ku\u{308}che"] {
            assert_eq!(shown(text), text);
            assert_eq!(shown_path(Path::new(text)), text);
        }
        assert_eq!(shown("a\nb\u{1b}[2J\u{202e}"), "a\\nb\\u{1b}[2J\\u{202e}");
        assert_eq!(shown(&"a".repeat(LONGEST)), "a".repeat(LONGEST));
        assert_eq!(shown(&"a".repeat(LONGEST + 1)), format!("{}…", "a".repeat(LONGEST)));
        let long = "a".repeat(LONGEST + 1);
        assert_eq!(shown_path(Path::new(&format!("{long}\u{9b}"))), format!("{long}\\u{{9b}}"));
    }
}
