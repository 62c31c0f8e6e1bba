//! Rows as Markdown: a table per subject, a line per contestant, a column per peer.

use formats::metrics::speedup::Speedup;

use crate::contest::{Row, Side};

/// One table per subject; subjects and tasks in the order in which they first come.
pub fn markdown(rows: &[Row]) -> String {
    let subjects = firsts(rows.iter().map(|row| row.subject.as_str()));
    subjects.into_iter().map(|subject| table(subject, rows)).collect()
}

fn table(subject: &str, rows: &[Row]) -> String {
    let of_subject = || rows.iter().filter(|row| row.subject == subject);
    let tasks = firsts(of_subject().map(|row| (row.task.as_str(), row.items)));
    let peers = firsts(of_subject().flat_map(|row| row.over.keys().map(String::as_str)));
    let over: Vec<String> = peers.iter().map(|peer| format!("over {peer}")).collect();
    let mut lines = vec![
        format!("\n### {subject}\n"),
        format!("| task | threads | tracer or sort | M/s | {} | differ |", over.join(" | ")),
        format!("|---|---|---|---|{}---|", "---|".repeat(peers.len())),
    ];
    for (task, items) in tasks {
        let of_task = || of_subject().filter(|row| (row.task.as_str(), row.items) == (task, items));
        for threads in firsts(of_task().map(|row| row.threads)) {
            let mut shown = format!("{task}, {items} | {threads}");
            for row in of_task().filter(|row| row.threads == threads) {
                lines.push(line(&shown, row, &peers));
                // A block says once what it is about.
                shown = " | ".to_owned();
            }
        }
    }
    lines.join("\n") + "\n"
}

fn line(task: &str, row: &Row, peers: &[&str]) -> String {
    let ratios: Vec<String> =
        peers.iter().map(|peer| row.over.get(*peer).map_or(String::new(), ratio)).collect();
    let name = match row.side {
        Side::Ours => format!("**{}**", row.name),
        Side::Peer => row.name.clone(),
        Side::Control => format!("control: {} again", row.name),
    };
    format!("| {task} | {name} | {:.2} | {} | {} |", row.rate, ratios.join(" | "), row.differing)
}

/// The median and its 95 % interval; `≈` for what is no difference.
fn ratio(speedup: &Speedup) -> String {
    let sign = if speedup.is_significant() { "" } else { "≈ " };
    match speedup.interval {
        Some((low, high)) => format!("{sign}{:.2} ({low:.2}–{high:.2})", speedup.ratio),
        None => format!("{:.2}", speedup.ratio),
    }
}

/// Each value once, where it first comes.
fn firsts<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut firsts, value| {
        if !firsts.contains(&value) {
            firsts.push(value);
        }
        firsts
    })
}
