//! A table as Parquet: its columns are data, its rows are written a row group at a time.

use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, ZstdLevel};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type, TypePtr};

/// Rows of a row group: whole groups of 32, 64 and 128 rays; about what engines read at a time.
pub(super) const ROWS_PER_GROUP: usize = 1 << 17;

type RowGroup<'a> = SerializedRowGroupWriter<'a, File>;

/// What a cell can hold, and how Parquet has it.
pub(super) trait Cell {
    /// Its type there.
    type Stored: DataType;
    /// What that type stands for; nothing where it says enough.
    fn meaning() -> Option<LogicalType>;
    /// The cell as it is there.
    fn stored(self) -> <Self::Stored as DataType>::T;
}

macro_rules! cells {
    ($($type:ty => $stored:ty, $meaning:expr, $convert:expr;)*) => { $(impl Cell for $type {
        type Stored = $stored;
        fn meaning() -> Option<LogicalType> { $meaning }
        fn stored(self) -> <$stored as DataType>::T { $convert(self) }
    })* };
}

cells! {
    u32 => Int32Type, Some(LogicalType::integer(32, false)), |value| value as i32;
    u64 => Int64Type, Some(LogicalType::integer(64, false)), |value| value as i64;
    f32 => FloatType, None, std::convert::identity;
    f64 => DoubleType, None, std::convert::identity;
    bool => BoolType, None, std::convert::identity;
    ByteArray => ByteArrayType, Some(LogicalType::String), std::convert::identity;
}

/// Cells of a constant column that are written at a time.
const ROWS_AT_ONCE: usize = 1 << 10;

/// What a column takes from rows, and what it has in the rows of the row group so far.
trait Cells<R> {
    /// The column's type.
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError>;
    /// Takes what rows have in this column.
    fn take(&mut self, rows: &[R]);
    /// Writes what was taken.
    fn write(&mut self, group: &mut RowGroup<'_>) -> Result<(), ParquetError>;
}

/// Cells of rows each of which has one.
struct Known<T: Cell, F> {
    of: F,
    values: Vec<<T::Stored as DataType>::T>,
}

/// Cells of rows some of which may have none, which is null.
struct Optional<T: Cell, F> {
    of: F,
    values: Vec<<T::Stored as DataType>::T>,
    /// For each row whether it has one, as its definition level, 0 or 1.
    levels: Vec<i16>,
}

impl<R, T: Cell, F: FnMut(&R) -> T> Cells<R> for Known<T, F> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::REQUIRED)
    }

    fn take(&mut self, rows: &[R]) {
        self.values.extend(rows.iter().map(|row| (self.of)(row).stored()));
    }

    fn write(&mut self, group: &mut RowGroup<'_>) -> Result<(), ParquetError> {
        write::<T>(group, [(&self.values[..], None)])?;
        self.values.clear();
        Ok(())
    }
}

impl<R, T: Cell, F: FnMut(&R) -> Option<T>> Cells<R> for Optional<T, F> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::OPTIONAL)
    }

    fn take(&mut self, rows: &[R]) {
        for row in rows {
            let cell = (self.of)(row);
            self.levels.push(i16::from(cell.is_some()));
            self.values.extend(cell.map(T::stored));
        }
    }

    fn write(&mut self, group: &mut RowGroup<'_>) -> Result<(), ParquetError> {
        write::<T>(group, [(&self.values[..], Some(&self.levels[..]))])?;
        self.values.clear();
        self.levels.clear();
        Ok(())
    }
}

/// The same cell in all rows.
struct Constant<T: Cell> {
    /// It, again and again.
    values: Vec<<T::Stored as DataType>::T>,
    rows: usize,
}

impl<R, T: Cell> Cells<R> for Constant<T> {
    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        schema::<T>(name, Repetition::REQUIRED)
    }

    fn take(&mut self, rows: &[R]) {
        self.rows += rows.len();
    }

    fn write(&mut self, group: &mut RowGroup<'_>) -> Result<(), ParquetError> {
        let parts = (0..self.rows).step_by(self.values.len());
        let parts = parts.map(|first| &self.values[..self.values.len().min(self.rows - first)]);
        write::<T>(group, parts.map(|values| (values, None)))?;
        self.rows = 0;
        Ok(())
    }
}

fn schema<T: Cell>(name: &str, repetition: Repetition) -> Result<TypePtr, ParquetError> {
    let column = Type::primitive_type_builder(name, T::Stored::get_physical_type());
    Ok(Arc::new(column.with_repetition(repetition).with_logical_type(T::meaning()).build()?))
}

/// Writes values of a column, and the levels of those that may be null.
fn write<'v, T: Cell>(
    group: &mut RowGroup<'_>,
    parts: impl IntoIterator<Item = (&'v [<T::Stored as DataType>::T], Option<&'v [i16]>)>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("a table has more columns than its schema".to_owned()));
    };
    for (values, levels) in parts {
        column.typed::<T::Stored>().write_batch(values, levels, None)?;
    }
    column.close()
}

/// How the values of a column are, which decides how they take least space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Values {
    /// A few, again and again: a dictionary.
    Few,
    /// The same for many rows on end: as they are, since compression finds that sooner than a dictionary.
    Runs,
    /// Whole numbers, each of about as many bits as its distance from the one before: these distances.
    Near,
    /// None of these: their first bytes, then their second bytes and so on, of which some are alike.
    Vary,
}

/// One column of a table whose rows are `R`.
pub(super) struct Column<'a, R> {
    /// Its name.
    pub(super) name: &'static str,
    /// Its unit; empty for what has none, such as names, indices and ratios.
    pub(super) unit: &'static str,
    /// What it is, in a sentence without its full stop.
    pub(super) about: &'static str,
    values: Values,
    cells: Box<dyn Cells<R> + 'a>,
}

impl<'a, R: 'a> Column<'a, R> {
    fn of(name: &'static str, about: &'static str, values: Values, cells: impl Cells<R> + 'a) -> Self {
        Self { name, unit: "", about, values, cells: Box::new(cells) }
    }

    /// A column that has a value in every row, which costs less to write.
    pub(super) fn known<T: Cell + 'a>(
        name: &'static str,
        about: &'static str,
        values: Values,
        of: impl FnMut(&R) -> T + 'a,
    ) -> Self {
        Self::of(name, about, values, Known { of, values: Vec::new() })
    }

    /// A column that is null where a row has nothing.
    pub(super) fn optional<T: Cell + 'a>(
        name: &'static str,
        about: &'static str,
        values: Values,
        of: impl FnMut(&R) -> Option<T> + 'a,
    ) -> Self {
        Self::of(name, about, values, Optional { of, values: Vec::new(), levels: Vec::new() })
    }

    /// A column with the same value in every row.
    pub(super) fn constant<T: Cell + 'a>(name: &'static str, about: &'static str, value: T) -> Self {
        let values = vec![value.stored(); ROWS_AT_ONCE];
        Self::of(name, about, Values::Few, Constant::<T> { values, rows: 0 })
    }

    /// A column of names, null where a row has none.
    pub(super) fn text(
        name: &'static str,
        about: &'static str,
        of: for<'r> fn(&'r R) -> Option<&'r str>,
    ) -> Self {
        // Rows that follow each other mostly share their text.
        let mut last = ByteArray::from("");
        Self::optional(name, about, Values::Few, move |row| {
            let text = of(row)?;
            if last.data() != text.as_bytes() {
                last = ByteArray::from(text);
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
    file: SerializedFileWriter<File>,
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
        let cannot = || format!("cannot write {}", path.display());
        let file = File::create_new(&path).with_context(cannot)?;
        let fields = columns.iter().map(|column| column.cells.schema(column.name));
        let fields = fields.collect::<Result<Vec<_>, _>>().with_context(cannot)?;
        let schema = Type::group_type_builder("rayscope").with_fields(fields).build().with_context(cannot)?;
        let file = SerializedFileWriter::new(file, Arc::new(schema), properties(&columns));
        let file = file.with_context(cannot)?;
        Ok(Self { path, columns, file, taken: 0, written: 0 })
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
        let mut write = || {
            let mut group = self.file.next_row_group()?;
            self.columns.iter_mut().try_for_each(|column| column.cells.write(&mut group))?;
            group.close()
        };
        write().with_context(|| format!("cannot write {}", self.path.display()))?;
        self.written += self.taken as u64;
        self.taken = 0;
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
        self.file.close().with_context(|| format!("cannot write {}", self.path.display()))?;
        Ok(self.written)
    }
}

fn properties<R>(columns: &[Column<'_, R>]) -> WriterPropertiesPtr {
    let mut properties = WriterProperties::builder()
        .set_created_by(format!("Rayscope {}", env!("CARGO_PKG_VERSION")))
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_data_page_row_count_limit(ROWS_PER_GROUP)
        .set_key_value_metadata(Some(columns.iter().flat_map(Column::metadata).collect()));
    for column in columns {
        let path = ColumnPath::from(column.name);
        properties = properties.set_column_dictionary_enabled(path.clone(), column.values == Values::Few);
        let encoding = match column.values {
            Values::Few | Values::Runs => continue,
            Values::Near => Encoding::DELTA_BINARY_PACKED,
            Values::Vary => Encoding::BYTE_STREAM_SPLIT,
        };
        properties = properties.set_column_encoding(path, encoding);
    }
    Arc::new(properties.build())
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};

    use super::*;

    #[test]
    fn row_groups_are_whole_groups_of_rays_and_lose_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        let columns = vec![
            Column::known("row", "Row", Values::Near, |row: &u32| *row),
            Column::optional("even", "The same, if it is even", Values::Few, |row: &u32| {
                Some(*row).filter(|row| row.is_multiple_of(2))
            }),
            Column::constant("pass", "Pass", 7u32),
        ];
        let mut table = TableWriter::create(path.clone(), columns).unwrap();
        let rows: Vec<u32> = (0..ROWS_PER_GROUP as u32 + 1000).collect();
        // Whatever is added at a time.
        rows.chunks(777).try_for_each(|rows| table.add(rows)).unwrap();
        assert_eq!(table.finish().unwrap(), rows.len() as u64);
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let groups: Vec<i64> = reader.metadata().row_groups().iter().map(|group| group.num_rows()).collect();
        assert_eq!(groups, [ROWS_PER_GROUP as i64, 1000]);
        assert!(groups[..1].iter().all(|rows| rows % 128 == 0));
        for (at, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let expected = if at.is_multiple_of(2) { at.to_string() } else { "null".to_owned() };
            assert_eq!(row.unwrap().to_string(), format!("{{row: {at}, even: {expected}, pass: 7}}"));
        }
        let taken = TableWriter::<u32>::create(path, Vec::new()).err().unwrap().to_string();
        assert!(taken.contains("cannot write "), "{taken}");
    }
}
