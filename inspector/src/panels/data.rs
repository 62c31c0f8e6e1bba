//! The numbers behind a panel, as a table that other programs read.

use std::path::Path;

use formats::files::replace;

/// The most rows that are copied as text: more than anyone pastes.
const COPIED_ROWS: usize = 100_000;

/// A table whose rows are made one after the other.
pub struct Data {
    /// Names of the columns.
    header: Vec<String>,
    rows: Box<dyn Iterator<Item = Vec<String>>>,
}

impl Data {
    /// With these columns.
    pub fn new(header: &[&str], rows: impl Iterator<Item = Vec<String>> + 'static) -> Self {
        Self { header: header.iter().map(|&name| name.to_owned()).collect(), rows: Box::new(rows) }
    }

    /// Writes it as CSV.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(self, path: &Path) -> Result<(), String> {
        let written = replace(path, |file| {
            let mut writer = csv::Writer::from_writer(file);
            writer.write_record(&self.header)?;
            for row in self.rows {
                writer.write_record(&row)?;
            }
            writer.flush()
        });
        written.map_err(|error| format!("{}: {error}", path.display()))
    }

    /// As text with tabs, which spreadsheets and tables take; of long tables the first rows.
    pub fn text(self) -> String {
        let line = |row: Vec<String>| row.join("\t") + "\n";
        std::iter::once(self.header).chain(self.rows.take(COPIED_ROWS)).map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_and_the_text_have_the_same_cells() {
        let data = || {
            let row = |number: u32| vec![number.to_string(), format!("a, {number}")];
            Data::new(&["number", "name"], (0..2).map(row))
        };
        assert_eq!(data().text(), "number\tname\n0\ta, 0\n1\ta, 1\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        data().write_csv(&path).unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "number,name\n0,\"a, 0\"\n1,\"a, 1\"\n");
        assert!(data().write_csv(&folder.path().join("no/a.csv")).unwrap_err().contains("a.csv"));
        if cfg!(target_os = "linux") {
            assert!(data().write_csv(Path::new("/dev/full")).is_err(), "what was buffered is written, too");
        }
    }
}
