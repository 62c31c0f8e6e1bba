//! Text from a file, as messages may show it: on one line, without what a terminal obeys, not endless.

/// Longest text that is shown whole, in characters.
const LONGEST: usize = 200;

/// `text` with control and invisible characters escaped, cut where it gets too long.
pub(crate) fn shown(text: &str) -> String {
    let mut shown = String::new();
    for character in text.chars().take(LONGEST) {
        match character {
            '"' | '\'' | '\\' => shown.push(character),
            _ => shown.extend(character.escape_debug()),
        }
    }
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_and_nothing_else_does() {
        for text in ["", "nave", "it's \"quoted\" \\ here", "Küche 台所"] {
            assert_eq!(shown(text), text);
        }
        assert_eq!(shown("a\nb\u{1b}[2J\u{202e}"), "a\\nb\\u{1b}[2J\\u{202e}");
        assert_eq!(shown(&"a".repeat(LONGEST)), "a".repeat(LONGEST));
        assert_eq!(shown(&"a".repeat(LONGEST + 1)), format!("{}…", "a".repeat(LONGEST)));
    }
}
