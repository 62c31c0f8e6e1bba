//! Results on standard output, words about them on standard error.

use std::io::{self, Write};

use anyhow::{Context, Result};
use clap::ValueEnum;
use formats::text::{printable, printable_json};
use serde::Serialize;

/// Writes a result to standard output, on a line or lines of its own.
///
/// A reader that has seen enough, such as `head`, is no failure; a full disk is one.
pub(crate) fn print(text: impl std::fmt::Display) -> Result<()> {
    let mut output = io::stdout().lock();
    let text = text.to_string();
    match writeln!(output, "{}", printable(&text)).and_then(|()| output.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write to standard output"),
    }
}

/// Writes a sentence to standard error. Where that cannot be written to, there is nobody to tell.
pub(crate) fn say(text: impl std::fmt::Display) {
    let text = text.to_string();
    let _ = writeln!(io::stderr().lock(), "{}", printable(&text));
}

/// A choice as it is typed.
pub(crate) fn typed(choice: &impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Writes a result as JSON.
pub(crate) fn print_json(value: &impl Serialize) -> Result<()> {
    print(printable_json(&serde_json::to_string_pretty(value)?))
}
