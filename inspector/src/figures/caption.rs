//! The words of a figure: caption and settings, for whoever puts it into a paper.

use super::model::Figure;

/// Title, caption and settings as plain text.
pub fn write(figure: &Figure) -> String {
    let mut text = format!("{}\n\n{}\n", figure.title, figure.caption);
    if !figure.settings.is_empty() {
        text.push('\n');
    }
    for line in &figure.settings {
        text.push_str(line);
        text.push('\n');
    }
    text
}
