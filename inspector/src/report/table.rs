//! A table of numbers, which are text already, in three forms: for the page, for Markdown and for LaTeX.

use crate::figures::{pgfplots, svg};

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Above it.
    pub title: String,
    /// What its numbers are, in sentences.
    pub caption: String,
    /// Names of the columns; the first is that of the rows.
    pub header: Vec<String>,
    /// As many cells as there are columns in each.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// What it says.
    pub text: String,
    /// Whether it is the best of its row.
    pub is_best: bool,
}

impl Cell {
    /// Of some text that is not the best of anything.
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), is_best: false }
    }
}

/// Tables below each other, as GitHub and others read Markdown.
pub fn markdown(tables: &[Table]) -> String {
    let escape = |text: &str| {
        let mut escaped = String::new();
        for character in text.chars() {
            if "|<*_`\\[".contains(character) {
                escaped.push('\\');
            }
            escaped.push(if character == '\n' { ' ' } else { character });
        }
        escaped
    };
    let table = |table: &Table| {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let header = line(table.header.iter().map(|name| escape(name)).collect());
        let rule = line(vec!["---".to_owned(); table.header.len()]);
        let cell = |cell: &Cell| match (escape(&cell.text), cell.is_best) {
            (text, true) => format!("**{text}**"),
            (text, false) => text,
        };
        let rows: String = table.rows.iter().map(|row| line(row.iter().map(cell).collect())).collect();
        format!("## {}\n{}\n\n{header}{rule}{rows}", escape(&table.title), escape(&table.caption))
    };
    tables.iter().map(table).collect::<Vec<_>>().join("\n")
}

/// Tables for a LaTeX document that loads `booktabs`; `\input` takes the file.
pub fn latex(tables: &[Table]) -> String {
    let escape = pgfplots::escape;
    let table = |table: &Table| {
        // Braces, since a bracket or a star at the start of a row would belong to the end of the one before.
        let line = |cells: Vec<String>| format!("{{}}{} \\\\\n", cells.join(" & "));
        let header = line(table.header.iter().map(|name| escape(name)).collect());
        let cell = |cell: &Cell| match (escape(&cell.text), cell.is_best) {
            (text, true) => format!("\\textbf{{{text}}}"),
            (text, false) => text,
        };
        let rows: String = table.rows.iter().map(|row| line(row.iter().map(cell).collect())).collect();
        let columns = "r".repeat(table.header.len().saturating_sub(1));
        format!(
            "\\begin{{table}}\n\\centering\n\\caption{{{}. {}}}\n\\begin{{tabular}}{{l{columns}}}\n\\toprule\n{header}\
             \\midrule\n{rows}\\bottomrule\n\\end{{tabular}}\n\\end{{table}}\n",
            escape(&table.title),
            escape(&table.caption),
        )
    };
    let head = "% Needs \\usepackage[utf8]{inputenc} and \\usepackage{booktabs}.\n".to_owned();
    std::iter::once(head).chain(tables.iter().map(table)).collect::<Vec<_>>().join("\n")
}

/// A table of the page, which scrolls by itself where it is too wide.
pub(super) fn html(table: &Table) -> String {
    let escape = svg::escape;
    let header: String =
        table.header.iter().map(|name| format!("<th scope=\"col\">{}</th>", escape(name))).collect();
    let cell = |cell: &Cell| match (escape(&cell.text), cell.is_best) {
        (text, true) => format!("<td><b>{text}</b></td>"),
        (text, false) => format!("<td>{text}</td>"),
    };
    let row = |row: &Vec<Cell>| format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
    format!(
        "<h3>{}</h3>\n<p class=\"note\">{}</p>\n<div class=\"wide\"><table>\n<thead><tr>{header}</tr></thead>\n\
         <tbody>\n{}</tbody></table></div>\n",
        escape(&table.title),
        escape(&table.caption),
        table.rows.iter().map(row).collect::<String>(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_form_has_each_cell_and_names_cannot_break_it() {
        let hostile = "[z] a|b & <c> *d* 50 % $x_1$ \\e {f}";
        let table = Table {
            title: hostile.into(),
            caption: hostile.into(),
            header: vec!["scene".into(), hostile.into(), "aila".into()],
            rows: vec![
                vec![
                    Cell::plain(hostile),
                    Cell::plain("0.98 / 0.91"),
                    Cell { text: "1.21".into(), is_best: true },
                ];
                2
            ],
        };
        let tables = [table.clone(), table.clone()];
        let markdown = markdown(&tables);
        let rows: Vec<&str> = markdown.lines().filter(|line| line.starts_with('|')).collect();
        assert_eq!(rows.len(), 2 * 4);
        for row in rows {
            assert_eq!(row.replace("\\|", "").matches('|').count(), 4, "{row}");
        }
        assert!(markdown.contains("**1.21**") && !markdown.replace("\\<", "").contains("<c>"));
        let latex = latex(&tables);
        for row in latex.lines().filter(|line| line.ends_with("\\\\")) {
            assert_eq!(row.replace("\\&", "").matches('&').count(), 2, "{row}");
            assert!(!row.starts_with('['), "what is before takes it: {row}");
        }
        assert_eq!(
            (latex.matches("\\begin{tabular}{lrr}").count(), latex.matches("\\bottomrule").count()),
            (2, 2)
        );
        assert!(latex.contains("\\textbf{1.21}") && latex.contains("50 \\% \\$x\\_1\\$"));
        let html = html(&table);
        assert!(html.contains("<td><b>1.21</b></td>") && !html.contains("<c>"));
        assert_eq!((html.matches("<tr>").count(), html.matches("<td>").count()), (3, 6));
    }
}
