//! What files say, made fit to be shown: in tables, figures, reports and the window. A file may name a scene in
//! megabytes, and figures repeat names often.

use formats::manifest::{Header, Source};
use formats::text::one_line;

/// The longest name that is shown whole, characters: longer than a method's may be.
const NAME_CHARACTERS: usize = 120;

/// The longest sentence that is shown whole, characters.
const SENTENCE_CHARACTERS: usize = 2000;

/// A name, or a few words, on one line.
pub(crate) fn name(text: &str) -> String {
    one_line(text, NAME_CHARACTERS)
}

/// What was said to the user, or why something is not known; such sentences may quote names.
pub(crate) fn sentence(text: String) -> String {
    match text.char_indices().nth(SENTENCE_CHARACTERS) {
        None => text,
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

/// A header all of whose names can be shown. What is looked up goes by the header as it is.
pub(crate) fn header(header: &Header) -> Header {
    let mut shown = header.clone();
    let Header {
        program_version, options, scene, adapter, self_check, features, time_source, notices, ..
    } = &mut shown;
    let of_options = [
        &mut options.camera,
        &mut options.table_method,
        &mut options.table_layout,
        &mut options.trace_kernel,
        &mut options.keep_passes,
    ];
    let of_adapter = [&mut adapter.name, &mut adapter.driver, &mut adapter.device_type, &mut adapter.backend];
    let others = [program_version, &mut scene.name, time_source];
    let lists = [&mut options.methods, &mut options.keep, &mut features.used, &mut features.skipped];
    let listed = lists.into_iter().flatten();
    let checks =
        self_check.iter_mut().flat_map(|check| [&mut check.name, &mut check.outcome, &mut check.detail]);
    for text in of_options.into_iter().chain(of_adapter).chain(others).chain(listed).chain(checks) {
        *text = name(text);
    }
    for notice in notices {
        *notice = one_line(notice, SENTENCE_CHARACTERS);
    }
    match &mut shown.source {
        Source::Traced => {}
        Source::Replayed { name: of, .. } | Source::Imported { name: of, .. } => *of = name(of),
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_cut_between_characters() {
        assert_eq!(sentence("größer".to_owned()), "größer");
        let long = sentence("ß".repeat(5_000_000));
        assert_eq!(long.chars().count(), SENTENCE_CHARACTERS + 1);
    }
}
