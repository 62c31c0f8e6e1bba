//! A table as Parquet: its columns are data, its rows are written a row group at a time.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use parquet::basic::Repetition;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::schema::types::{Type, TypePtr};

use super::cell::Cell;
use super::encode;
use super::file::{Chunk, ColumnFile};
use super::runs::Runs;

/// Rows of a row group: whole groups of 32, 64 and 128 rays; about what engines read at a time.
pub(super) const ROWS_PER_GROUP: usize = 1 << 17;

/// What a column takes from rows, and what it has in the rows of the row group so far.
trait Cells<R> {
    /// The column's type.
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError>;
    /// Takes what rows have in this column.
    fn take(&mut self, rows: &[R]);
    /// Gives what was taken.
    fn give(&mut self, chunk: &mut Chunk);
}

/// Cells of rows each of which has one.
struct Known<T: Cell, F> {
    of: F,
    values: Vec<T::Stored>,
}

/// Cells of rows some of which may have none, which is null.
struct Optional<T: Cell, F> {
    of: F,
    /// The cell of each row, anything where there is none.
    values: Vec<T::Stored>,
    /// For each row whether it has one.
    present: Vec<bool>,
}

/// Cells that are the same for many rows on end.
struct Repeated<T: Cell, F> {
    of: F,
    runs: Runs<T>,
}

/// The same cell in all rows, or none in any.
struct Constant<T: Cell> {
    value: Option<T::Stored>,
    runs: Runs<T>,
}

impl<R, T: Cell, F: Fn(&R) -> T> Cells<R> for Known<T, F> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::REQUIRED)
    }

    fn take(&mut self, rows: &[R]) {
        self.values.extend(rows.iter().map(|row| (self.of)(row).stored()));
    }

    fn give(&mut self, chunk: &mut Chunk) {
        chunk.encoding = T::encode(&self.values, &mut chunk.page);
        chunk.statistics = Some(T::statistics(&self.values, 0));
        self.values.clear();
    }
}

impl<R, T: Cell, F: Fn(&R) -> Option<T>> Cells<R> for Optional<T, F> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::OPTIONAL)
    }

    fn take(&mut self, rows: &[R]) {
        self.values.extend(rows.iter().map(|row| (self.of)(row).unwrap_or_default().stored()));
        self.present.extend(rows.iter().map(|row| (self.of)(row).is_some()));
    }

    fn give(&mut self, chunk: &mut Chunk) {
        let known = self.present.iter().filter(|&&is_present| is_present).count();
        let nulls = self.present.len() - known;
        if nulls > 0 {
            let mut next = 0;
            for (at, &is_present) in self.present.iter().enumerate() {
                self.values[next] = self.values[at].clone();
                next += usize::from(is_present);
            }
            self.values.truncate(known);
        }
        chunk.levels(|levels| match (known, nulls) {
            (_, 0) => encode::run(known, 1, 1, levels),
            (0, _) => encode::run(nulls, 0, 1, levels),
            _ => encode::presence(&self.present, levels),
        });
        chunk.encoding = T::encode(&self.values, &mut chunk.page);
        chunk.statistics = Some(T::statistics(&self.values, nulls));
        self.values.clear();
        self.present.clear();
    }
}

impl<R, T: Cell, F: FnMut(&R) -> Option<T>> Cells<R> for Repeated<T, F> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::OPTIONAL)
    }

    fn take(&mut self, rows: &[R]) {
        rows.iter().for_each(|row| self.runs.add((self.of)(row).map(T::stored), 1));
    }

    fn give(&mut self, chunk: &mut Chunk) {
        self.runs.give(Repetition::OPTIONAL, chunk);
    }
}

impl<R, T: Cell> Cells<R> for Constant<T> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, self.repetition())
    }

    fn take(&mut self, rows: &[R]) {
        self.runs.add(self.value.clone(), rows.len());
    }

    fn give(&mut self, chunk: &mut Chunk) {
        self.runs.give(self.repetition(), chunk);
    }
}

impl<T: Cell> Constant<T> {
    fn repetition(&self) -> Repetition {
        if self.value.is_some() { Repetition::REQUIRED } else { Repetition::OPTIONAL }
    }
}

fn schema<T: Cell>(name: &str, repetition: Repetition) -> Result<TypePtr, ParquetError> {
    let column = Type::primitive_type_builder(name, T::KIND);
    Ok(Arc::new(column.with_repetition(repetition).with_logical_type(T::meaning()).build()?))
}

/// One column of a table whose rows are `R`.
pub(super) struct Column<'a, R> {
    /// Its name.
    pub(super) name: &'static str,
    /// Its unit; empty for what has none, such as names, indices and ratios.
    pub(super) unit: &'static str,
    /// What it is, in a sentence without its full stop.
    pub(super) about: &'static str,
    cells: Box<dyn Cells<R> + 'a>,
}

impl<'a, R: 'a> Column<'a, R> {
    fn of(name: &'static str, about: &'static str, cells: impl Cells<R> + 'a) -> Self {
        Self { name, unit: "", about, cells: Box::new(cells) }
    }

    /// A column that has a value in every row, which costs less to write.
    pub(super) fn known<T: Cell + 'a>(
        name: &'static str,
        about: &'static str,
        of: impl Fn(&R) -> T + 'a,
    ) -> Self {
        Self::of(name, about, Known { of, values: Vec::with_capacity(ROWS_PER_GROUP) })
    }

    /// A column that is null where a row has nothing.
    pub(super) fn optional<T: Cell + 'a>(
        name: &'static str,
        about: &'static str,
        of: impl Fn(&R) -> Option<T> + 'a,
    ) -> Self {
        Self::of(
            name,
            about,
            Optional {
                of,
                values: Vec::with_capacity(ROWS_PER_GROUP),
                present: Vec::with_capacity(ROWS_PER_GROUP),
            },
        )
    }

    /// The same where rows that follow each other mostly have the same.
    pub(super) fn repeated<T: Cell + 'a>(
        name: &'static str,
        about: &'static str,
        of: impl FnMut(&R) -> Option<T> + 'a,
    ) -> Self {
        Self::of(name, about, Repeated { of, runs: Runs::new() })
    }

    /// A column with the same value in every row.
    pub(super) fn constant<T: Cell + 'a>(name: &'static str, about: &'static str, value: T) -> Self {
        Self::of(name, about, Constant { value: Some(value.stored()), runs: Runs::<T>::new() })
    }

    /// A column that is null in every row.
    pub(super) fn absent<T: Cell + 'a>(name: &'static str, about: &'static str) -> Self {
        Self::of(name, about, Constant { value: None, runs: Runs::<T>::new() })
    }

    /// A column of names, null where a row has none.
    pub(super) fn text(
        name: &'static str,
        about: &'static str,
        of: for<'r> fn(&'r R) -> Option<&'r str>,
    ) -> Self {
        let mut last: Arc<str> = Arc::default();
        Self::repeated(name, about, move |row| {
            let text = of(row)?;
            if *last != *text {
                last = text.into();
            }
            Some(last.clone())
        })
    }

    /// A column of quantities.
    pub(super) fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// `NAME.unit` and `NAME.about`, for the metadata of the file.
    fn metadata(&self) -> impl Iterator<Item = KeyValue> + use<R> {
        let name = self.name;
        let entries = [("unit", self.unit), ("about", self.about)];
        let known = entries.into_iter().filter(|(_, text)| !text.is_empty());
        known.map(move |(what, text)| KeyValue::new(format!("{name}.{what}"), text.to_owned()))
    }
}

/// A table that is being written. Memory: the rows of one row group.
pub(super) struct TableWriter<'a, R> {
    path: PathBuf,
    columns: Vec<Column<'a, R>>,
    file: ColumnFile,
    chunk: Chunk,
    /// Rows of the row group so far.
    taken: usize,
    written: u64,
}

impl<'a, R: 'a> TableWriter<'a, R> {
    /// Starts a file that is not there yet.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(super) fn create(path: PathBuf, columns: Vec<Column<'a, R>>) -> anyhow::Result<Self> {
        let create = || {
            let fields = columns.iter().map(|column| column.cells.schema(column.name));
            let schema = Type::group_type_builder("rayscope").with_fields(fields.collect::<Result<_, _>>()?);
            ColumnFile::create(&path, Arc::new(schema.build()?))
        };
        let file = create().with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { path, columns, file, chunk: Chunk::new(), taken: 0, written: 0 })
    }

    /// Adds rows: soonest as many at a time as a cache holds.
    ///
    /// # Errors
    /// If a full row group cannot be written.
    pub(super) fn add(&mut self, mut rows: &[R]) -> anyhow::Result<()> {
        while !rows.is_empty() {
            let (now, later) = rows.split_at(rows.len().min(ROWS_PER_GROUP - self.taken));
            self.columns.iter_mut().for_each(|column| column.cells.take(now));
            self.taken += now.len();
            if self.taken == ROWS_PER_GROUP {
                self.write_group()?;
            }
            rows = later;
        }
        Ok(())
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let rows = std::mem::take(&mut self.taken);
        let mut write = || {
            for column in &mut self.columns {
                column.cells.give(&mut self.chunk);
                self.file.write(rows, &mut self.chunk)?;
            }
            self.file.end_group(rows)
        };
        write().with_context(|| format!("cannot write {}", self.path.display()))?;
        self.written += rows as u64;
        Ok(())
    }

    /// Ends the file; gives its rows.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn finish(mut self) -> anyhow::Result<u64> {
        if self.taken > 0 {
            self.write_group()?;
        }
        let about = self.columns.iter().flat_map(Column::metadata).collect();
        self.file.finish(about).with_context(|| format!("cannot write {}", self.path.display()))?;
        Ok(self.written)
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::file::statistics::Statistics;
    use parquet::record::Field;

    use super::*;

    /// Of any size, the same in each run.
    fn mixed(row: u32) -> u64 {
        let mixed = u64::from(row).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed >> (mixed >> 58)
    }

    fn columns() -> Vec<Column<'static, u32>> {
        vec![
            Column::known("row", "Row", |&row| row),
            Column::known("narrow", "Whole numbers of any width", |&row| mixed(row) as u32),
            Column::optional("wide", "Likewise, in three rows of four", |&row| {
                Some(mixed(row)).filter(|_| row % 4 != 1)
            }),
            Column::known("single", "Numbers", |&row| row as f32 - 1e4),
            Column::optional("double", "Numbers, in no row but the last", |&row| {
                Some(f64::from(row) / 7.0).filter(|_| row == ROWS - 1)
            }),
            Column::repeated("group", "Numbers that are repeated, in two groups of three", |&row: &u32| {
                Some(f64::from(row / 64 % 500)).filter(|_| !(row / 64).is_multiple_of(3))
            }),
            Column::optional("even", "Whether the row is even", |&row: &u32| Some(row.is_multiple_of(2))),
            Column::text("word", "A word", |&row| Some(["", "one", "two"][row as usize / 1000 % 3])),
            Column::constant("pass", "Pass", 7u32),
            Column::absent::<f32>("nothing", "Nothing"),
        ]
    }

    fn fields(row: u32) -> Vec<Field> {
        let or_null = |is_known: bool, field| if is_known { field } else { Field::Null };
        vec![
            Field::UInt(row),
            Field::UInt(mixed(row) as u32),
            or_null(row % 4 != 1, Field::ULong(mixed(row))),
            Field::Float(row as f32 - 1e4),
            or_null(row == ROWS - 1, Field::Double(f64::from(row) / 7.0)),
            or_null(!(row / 64).is_multiple_of(3), Field::Double(f64::from(row / 64 % 500))),
            Field::Bool(row.is_multiple_of(2)),
            Field::Str(["", "one", "two"][row as usize / 1000 % 3].to_owned()),
            Field::UInt(7),
            Field::Null,
        ]
    }

    /// A full row group, and one whose last blocks and bytes are not full.
    const ROWS: u32 = ROWS_PER_GROUP as u32 + 1003;

    #[test]
    fn row_groups_are_whole_groups_of_rays_and_lose_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        let mut table = TableWriter::create(path.clone(), columns()).unwrap();
        // Whatever is added at a time.
        let rows: Vec<u32> = (0..ROWS).collect();
        rows.chunks(777).try_for_each(|rows| table.add(rows)).unwrap();
        assert_eq!(table.finish().unwrap(), u64::from(ROWS));
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let groups: Vec<i64> = reader.metadata().row_groups().iter().map(|group| group.num_rows()).collect();
        assert_eq!(groups, [ROWS_PER_GROUP as i64, 1003]);
        assert!(groups[..1].iter().all(|rows| rows % 128 == 0));
        let mut read = 0;
        for row in reader.get_row_iter(None).unwrap() {
            let found: Vec<Field> = row.unwrap().into_columns().into_iter().map(|column| column.1).collect();
            assert_eq!(found, fields(read));
            read += 1;
        }
        assert_eq!(read, ROWS);
        let taken = TableWriter::<u32>::create(path, Vec::new()).err().unwrap().to_string();
        assert!(taken.contains("cannot write "), "{taken}");
    }

    #[test]
    fn statistics_are_the_ends_of_the_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        let numbers = vec![
            // Beyond what fits a number with a sign.
            Column::optional("whole", "", |&row: &u32| Some(row << 31).filter(|&row| row > 0)),
            Column::known("negative", "", |&row| -(row as f32)),
            Column::known("some", "Numbers and what is none", |&row| [1.0, f32::NAN][row as usize % 2]),
            Column::repeated("double", "", |&row| Some(f64::from(row) - 2.0)),
            Column::text("word", "", |&row| Some(["a", "c", "b", "d"][row as usize])),
            Column::absent::<f32>("nothing", ""),
        ];
        let mut table = TableWriter::create(path.clone(), numbers).unwrap();
        table.add(&[0, 1, 2, 3]).unwrap();
        table.finish().unwrap();
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let ends = |of: &Statistics| {
            let bytes = |bytes: Option<&[u8]>| bytes.map(<[u8]>::to_vec);
            (bytes(of.min_bytes_opt()), bytes(of.max_bytes_opt()), of.null_count_opt())
        };
        let columns = reader.metadata().row_group(0).columns();
        let found: Vec<_> = columns.iter().map(|column| ends(column.statistics().unwrap())).collect();
        let expected = [
            Statistics::int32(Some(i32::MIN), Some(i32::MIN), None, Some(2), false),
            Statistics::float(Some(-3.0), Some(-0.0), None, Some(0), false),
            Statistics::float(None, None, None, Some(0), false),
            Statistics::double(Some(-2.0), Some(1.0), None, Some(0), false),
            Statistics::byte_array(Some("a".into()), Some("d".into()), None, Some(0), false),
            Statistics::float(None, None, None, Some(4), false),
        ];
        assert_eq!(found, expected.each_ref().map(ends));
    }
}
