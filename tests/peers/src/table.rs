//! Rows as Markdown: a table per subject, a column per peer with its rates and the ratios of ours over them.

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
    let peers = firsts(of_subject().filter(|row| row.side == Side::Peer).map(|row| row.name.as_str()));
    let mut lines = vec![
        format!("\n### {subject}\n"),
        format!("| task | threads | | M/s | {} |", peers.join(" | ")),
        format!("|---|---|---|---|{}", "---|".repeat(peers.len())),
    ];
    for (task, items) in tasks {
        let of_task = || of_subject().filter(|row| (row.task.as_str(), row.items) == (task, items));
        for threads in firsts(of_task().map(|row| row.threads)) {
            let block: Vec<&Row> = of_task().filter(|row| row.threads == threads).collect();
            let rates = peers.iter().map(|peer| {
                let row = block.iter().find(|row| row.side == Side::Peer && row.name == *peer);
                row.map_or(String::new(), |row| format!("{:.2}{}", row.rate, differing(row)))
            });
            let rates: Vec<String> = rates.collect();
            lines.push(format!("| {task}, {items} | {threads} | peers, M/s | | {} |", rates.join(" | ")));
            lines.extend(block.iter().filter(|row| row.side != Side::Peer).map(|row| line(row, &peers)));
        }
    }
    lines.join("\n") + "\n"
}

fn line(row: &Row, peers: &[&str]) -> String {
    let ratios: Vec<String> =
        peers.iter().map(|peer| row.over.get(*peer).map_or(String::new(), ratio)).collect();
    let name = match row.side {
        Side::Control => "control".to_owned(),
        _ => format!("**{}**{}", row.name, differing(row)),
    };
    format!("| | | {name} | {:.2} | {} |", row.rate, ratios.join(" | "))
}

fn differing(row: &Row) -> String {
    match row.differing {
        0 => String::new(),
        count => format!(", {count} differ"),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_stand_below_the_rates_of_the_peers_that_they_are_over() {
        let row = |name: &str, side, rate, over: &[(&str, f64)], differing| Row {
            subject: "scene".to_owned(),
            task: "camera".to_owned(),
            items: 1000,
            threads: 2,
            name: name.to_owned(),
            side,
            samples_ns: Vec::new(),
            rate,
            over: over
                .iter()
                .map(|(peer, ratio)| {
                    let interval = Some((ratio - 0.25, ratio + 0.25));
                    ((*peer).to_owned(), Speedup { ratio: *ratio, interval })
                })
                .collect(),
            differing,
        };
        let rows = [
            row("wide", Side::Ours, 3.0, &[("a", 1.5), ("b", 0.75)], 0),
            row("b", Side::Peer, 4.0, &[], 0),
            row("a", Side::Peer, 2.0, &[], 5),
            row("b", Side::Control, 4.25, &[("b", 1.0)], 0),
        ];
        let expected = "
### scene

| task | threads | | M/s | b | a |
|---|---|---|---|---|---|
| camera, 1000 | 2 | peers, M/s | | 4.00 | 2.00, 5 differ |
| | | **wide** | 3.00 | ≈ 0.75 (0.50–1.00) | 1.50 (1.25–1.75) |
| | | control | 4.25 | ≈ 1.00 (0.75–1.25) |  |
";
        assert_eq!(markdown(&rows), expected);
    }
}
