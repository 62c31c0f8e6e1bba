//! How wide text is in the embedded font, and where it may be broken.

use std::sync::LazyLock;

use skrifa::charmap::Charmap;
use skrifa::instance::{LocationRef, Size};
use skrifa::metrics::GlyphMetrics;
use skrifa::{FontRef, MetadataProvider};

use super::style::{FONT, LINE_HEIGHT};

/// Which glyph a character has, and how wide it is, in sizes.
static GLYPHS: LazyLock<Option<(Charmap<'static>, GlyphMetrics<'static>)>> = LazyLock::new(|| {
    let font = FontRef::new(FONT).ok()?;
    Some((font.charmap(), font.glyph_metrics(Size::new(1.0), LocationRef::default())))
});

/// Advance of a character that the font lacks, in sizes.
const UNKNOWN_ADVANCE: f64 = 0.75;

/// Width of the widest line of a text at a size, both in the same unit. Kerning, which only narrows, is
/// left out.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let advance = |character: char| {
        let (glyphs, metrics) = GLYPHS.as_ref()?;
        metrics.advance_width(glyphs.map(character)?).map(f64::from)
    };
    let of_line =
        |line: &str| line.chars().map(|character| advance(character).unwrap_or(UNKNOWN_ADVANCE)).sum();
    text.lines().map(of_line).fold(0.0, f64::max) * size
}

/// Height of the lines of a text, in the unit of its size.
pub(crate) fn height(text: &str, size: f64) -> f64 {
    text.lines().count() as f64 * LINE_HEIGHT * size
}

/// Breaks text into lines no wider than `room`: after spaces, hyphens and slashes. A piece that is wider
/// than that stays whole.
pub(crate) fn wrap(text: &str, size: f64, room: f64) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for piece in text.split_inclusive([' ', '-', '/']) {
        let longer = format!("{line}{piece}");
        if !line.is_empty() && width(longer.trim_end(), size) > room {
            lines.push(line.trim_end().to_owned());
            line = piece.to_owned();
        } else {
            line = longer;
        }
    }
    lines.push(line.trim_end().to_owned());
    lines.join("\n")
}

/// As [`wrap`], with lines as even as their number lets them be: no word stands alone below a full line. Two lines
/// part after a colon if both fit.
pub(crate) fn wrap_evenly(text: &str, size: f64, room: f64) -> String {
    let lines = |room: f64| wrap(text, size, room).lines().count();
    let (fewest, mut narrow, mut wide) = (lines(room), 0.0, room);
    let at_colon = text.replacen(": ", ":\n", 1);
    if fewest == 2 && at_colon != text && width(&at_colon, size) <= room {
        return at_colon;
    }
    while fewest > 1 && wide - narrow > 0.5 {
        let middle = 0.5 * (narrow + wide);
        if lines(middle) > fewest { narrow = middle } else { wide = middle }
    }
    wrap(text, size, wide)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_grow_with_text_and_size() {
        assert!(GLYPHS.is_some(), "the embedded font cannot be read");
        assert!((width("00", 10.0) - 2.0 * 5.56).abs() < 0.05, "digits are 0.556 wide");
        assert_eq!(width("", 8.0), 0.0);
        assert!(width("iiii", 8.0) < width("mmmm", 8.0));
    }

    #[test]
    fn the_font_has_what_labels_are_written_with() {
        let (glyphs, _) = GLYPHS.as_ref().unwrap();
        for character in ('!'..='~').chain("–—×µ²³≥≤−→±·Δ…“”éäß•°∞√½".chars())
        {
            assert!(glyphs.map(character).is_some(), "{character} is missing");
        }
    }

    #[test]
    fn lines_break_where_they_may_and_lose_nothing() {
        let text = "two-point-adaptive of Crytek Sponza/bounce 2";
        let wrapped = wrap(text, 8.0, 60.0);
        let lines: Vec<&str> = wrapped.lines().collect();
        assert!(lines.len() > 2, "{lines:?}");
        for line in &lines {
            assert!(width(line, 8.0) <= 60.0, "{line}");
        }
        assert!(width(&wrapped, 8.0) <= 60.0);
        let without_spaces = |text: &str| text.replace(' ', "");
        assert_eq!(without_spaces(&lines.concat()), without_spaces(text));
        assert_eq!(wrap("unbreakable", 8.0, 1.0), "unbreakable");
        assert!(wrap("", 8.0, 10.0).is_empty());
    }

    #[test]
    fn even_lines_leave_no_word_alone() {
        let text = "kitchen: closest rays, bounce 1";
        let room = width("kitchen: closest rays, bounce", 8.0) + 1.0;
        assert_eq!(wrap(text, 8.0, room), "kitchen: closest rays, bounce\n1");
        assert_eq!(wrap_evenly(text, 8.0, room), "kitchen:\nclosest rays, bounce 1");
        let text = text.replace(':', "");
        assert_eq!(wrap_evenly(&text, 8.0, room), "kitchen closest\nrays, bounce 1");
        let text = &*text;
        assert_eq!(wrap_evenly(text, 8.0, 500.0), text);
        assert_eq!(wrap_evenly("unbreakable", 8.0, 1.0), "unbreakable");
    }
}
