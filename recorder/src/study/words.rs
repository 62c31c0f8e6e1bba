//! Options of a command as a plan writes them: long names and values, which become words of a command line.

use anyhow::Result;
use clap::ArgAction;
use formats::text::{did_you_mean, one_line, shell_word};
use toml::Value;

use crate::options::RecordOptions;
use crate::replay::ReplayOptions;

/// Most characters of a problem's words that are shown.
const SHOWN: usize = 200;

/// A command as the command line knows it.
pub struct Parser<T> {
    /// Its options by name.
    pub command: clap::Command,
    /// What words after it stand for.
    pub options: fn(&[String]) -> Result<T>,
}

/// The commands that a study runs.
pub struct Commands {
    /// `recorder record`.
    pub record: Parser<RecordOptions>,
    /// `recorder replay`.
    pub replay: Parser<ReplayOptions>,
}

/// Options that the study itself gives, and how a plan asks for them, if it may.
const OWN: [(&str, &str); 6] = [
    ("out", "each recording has its place in the study's folder; leave it out"),
    ("scene", "scenes are listed in `scenes` at the top"),
    ("camera", "cameras are chosen by `cameras` at the top"),
    ("seed", "seeds are listed in `seeds` at the top"),
    ("force", "what is finished stays, the rest is made again anyway; leave it out"),
    ("json", "what commands say goes to log.txt; leave it out"),
];

/// The words for a table of options; what is wrong goes to `problems`, after the name of the table.
pub fn words(
    table: &toml::Table,
    place: &str,
    command: &clap::Command,
    problems: &mut Vec<String>,
) -> Vec<String> {
    let mut words = Vec::new();
    for (key, value) in table {
        match option_words(key, value, command) {
            Ok(more) => words.extend(more),
            Err(problem) => problems.push(format!("{place} {}: {problem}", one_line(key, SHOWN))),
        }
    }
    words
}

/// The words for one option, or what is wrong with it.
fn option_words(key: &str, value: &Value, command: &clap::Command) -> Result<Vec<String>, String> {
    if let Some((_, instead)) = OWN.iter().find(|(own, _)| *own == key) {
        return Err(format!("the study gives this option itself: {instead}"));
    }
    let Some(option) = command.get_arguments().find(|option| option.get_long() == Some(key)) else {
        let known = command.get_arguments().filter_map(clap::Arg::get_long);
        let known = known.filter(|name| !OWN.iter().any(|(own, _)| own == name));
        let hint = did_you_mean(key, &known.collect::<Vec<_>>());
        return Err(format!("`recorder {}` has no such option; {hint}", command.get_name()));
    };
    let takes_values = option.get_action().takes_values();
    let word = |value: &Value| match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        _ => Err(format!("found {value}, expected a number, a string, or a list of such")),
    };
    match value {
        Value::Boolean(true) if !takes_values => Ok(vec![format!("--{key}")]),
        Value::Boolean(false) if !takes_values => Ok(Vec::new()),
        _ if !takes_values => Err(format!("found {value}, expected true or false")),
        Value::Array(values) => {
            let values = values.iter().map(word).collect::<Result<Vec<String>, String>>()?;
            Ok(match option.get_action() {
                // Of an option that may be repeated each value is whole.
                ArgAction::Append => values.iter().map(|value| format!("--{key}={value}")).collect(),
                _ => vec![format!("--{key}={}", values.join(","))],
            })
        }
        _ => Ok(vec![format!("--{key}={}", word(value)?)]),
    }
}

/// A parser's error on one line, without the lines about how to use it.
pub fn sentence(error: &anyhow::Error) -> String {
    // With its causes, clap would say them twice.
    let text = error.to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with("For more information"));
    let joined = lines.collect::<Vec<_>>().join("; ");
    joined.strip_prefix("error: ").unwrap_or(&joined).to_owned()
}

/// Words as they would be typed into a shell.
pub fn typed(words: &[String]) -> String {
    words.iter().map(|word| shell_word(word)).collect::<Vec<_>>().join(" ")
}
