//! A table as Parquet: its columns are data, its rows are written a row group at a time.

use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::ColumnWriterImpl;
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

/// Rows that are taken apart into columns at a time: as many as a cache holds.
const ROWS_PER_BLOCK: usize = 1 << 10;

/// What a column has in a row, `None` being null, and what it has in the rows of the row group so far.
enum Cells<R> {
    Text(for<'r> fn(&'r R) -> Option<&'r str>, Buffer<ByteArray>),
    U32(fn(&R) -> Option<u32>, Buffer<i32>),
    U64(fn(&R) -> Option<u64>, Buffer<i64>),
    F32(fn(&R) -> Option<f32>, Buffer<f32>),
    F64(fn(&R) -> Option<f64>, Buffer<f64>),
    Flag(fn(&R) -> Option<bool>, Buffer<bool>),
}

/// Values that are not null, and for each row whether it has one, as its definition level, 0 or 1; no levels where
/// every row has one.
struct Buffer<T> {
    values: Vec<T>,
    levels: Vec<i16>,
}

impl<T> Buffer<T> {
    const EMPTY: Self = Self { values: Vec::new(), levels: Vec::new() };

    fn extend(&mut self, is_required: bool, cells: impl Iterator<Item = Option<T>>) {
        if is_required {
            return self.values.extend(cells.flatten());
        }
        for cell in cells {
            self.levels.push(i16::from(cell.is_some()));
            self.values.extend(cell);
        }
    }

    fn write<D: DataType<T = T>>(
        &mut self,
        column: &mut ColumnWriterImpl<'_, D>,
    ) -> Result<(), ParquetError> {
        let levels = (!self.levels.is_empty()).then_some(&self.levels[..]);
        column.write_batch(&self.values, levels, None)?;
        self.values.clear();
        self.levels.clear();
        Ok(())
    }
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

/// One column.
pub(super) struct Column<R> {
    /// Its name.
    pub(super) name: &'static str,
    /// Its unit; empty for what has none, such as names, indices and ratios.
    pub(super) unit: &'static str,
    /// What it is, in a sentence without its full stop.
    pub(super) about: &'static str,
    values: Values,
    is_required: bool,
    cells: Cells<R>,
}

impl<R> Column<R> {
    fn new(name: &'static str, about: &'static str, values: Values, cells: Cells<R>) -> Self {
        Self { name, unit: "", about, values, is_required: false, cells }
    }

    /// A column of names.
    pub(super) fn text(
        name: &'static str,
        about: &'static str,
        of: for<'r> fn(&'r R) -> Option<&'r str>,
    ) -> Self {
        Self::new(name, about, Values::Few, Cells::Text(of, Buffer::EMPTY))
    }

    /// A column of whole numbers.
    pub(super) fn u32(
        name: &'static str,
        about: &'static str,
        values: Values,
        of: fn(&R) -> Option<u32>,
    ) -> Self {
        Self::new(name, about, values, Cells::U32(of, Buffer::EMPTY))
    }

    /// A column of large whole numbers.
    pub(super) fn u64(
        name: &'static str,
        about: &'static str,
        values: Values,
        of: fn(&R) -> Option<u64>,
    ) -> Self {
        Self::new(name, about, values, Cells::U64(of, Buffer::EMPTY))
    }

    /// A column of numbers in single precision.
    pub(super) fn f32(name: &'static str, about: &'static str, of: fn(&R) -> Option<f32>) -> Self {
        Self::new(name, about, Values::Vary, Cells::F32(of, Buffer::EMPTY))
    }

    /// A column of numbers in double precision.
    pub(super) fn f64(
        name: &'static str,
        about: &'static str,
        values: Values,
        of: fn(&R) -> Option<f64>,
    ) -> Self {
        Self::new(name, about, values, Cells::F64(of, Buffer::EMPTY))
    }

    /// A column of yes and no.
    pub(super) fn flag(name: &'static str, about: &'static str, of: fn(&R) -> Option<bool>) -> Self {
        Self::new(name, about, Values::Few, Cells::Flag(of, Buffer::EMPTY))
    }

    /// A column of quantities.
    pub(super) fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// A column that has a value in every row, which costs less to write.
    pub(super) fn required(self) -> Self {
        Self { is_required: true, ..self }
    }

    fn schema(&self) -> Result<TypePtr, ParquetError> {
        let unsigned = |bits| Some(LogicalType::integer(bits, false));
        let (physical, logical) = match self.cells {
            Cells::Text(..) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Cells::U32(..) => (Physical::INT32, unsigned(32)),
            Cells::U64(..) => (Physical::INT64, unsigned(64)),
            Cells::F32(..) => (Physical::FLOAT, None),
            Cells::F64(..) => (Physical::DOUBLE, None),
            Cells::Flag(..) => (Physical::BOOLEAN, None),
        };
        let repetition = if self.is_required { Repetition::REQUIRED } else { Repetition::OPTIONAL };
        let column = Type::primitive_type_builder(self.name, physical).with_repetition(repetition);
        Ok(Arc::new(column.with_logical_type(logical).build()?))
    }

    /// `NAME.unit` and `NAME.about`, for the metadata of the file.
    fn metadata(&self) -> impl Iterator<Item = KeyValue> + use<R> {
        let name = self.name;
        let entries = [("unit", self.unit), ("about", self.about)];
        let known = entries.into_iter().filter(|(_, text)| !text.is_empty());
        known.map(move |(what, text)| KeyValue::new(format!("{name}.{what}"), text.to_owned()))
    }

    /// Takes what rows have in this column.
    fn take(&mut self, rows: &[R]) {
        let required = self.is_required;
        match &mut self.cells {
            Cells::U32(of, buffer) => {
                buffer.extend(required, rows.iter().map(|row| of(row).map(|value| value as i32)));
            }
            Cells::U64(of, buffer) => {
                buffer.extend(required, rows.iter().map(|row| of(row).map(|value| value as i64)));
            }
            Cells::F32(of, buffer) => buffer.extend(required, rows.iter().map(of)),
            Cells::F64(of, buffer) => buffer.extend(required, rows.iter().map(of)),
            Cells::Flag(of, buffer) => buffer.extend(required, rows.iter().map(of)),
            Cells::Text(of, buffer) => {
                // Rows that follow each other mostly share their text.
                let mut last = ByteArray::from("");
                buffer.extend(
                    required,
                    rows.iter().map(|row| {
                        let text = of(row)?;
                        if last.data() != text.as_bytes() {
                            last = ByteArray::from(text);
                        }
                        Some(last.clone())
                    }),
                );
            }
        }
    }

    /// Writes what was taken.
    fn write(&mut self, group: &mut SerializedRowGroupWriter<'_, File>) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("a table has more columns than its schema".to_owned()));
        };
        match &mut self.cells {
            Cells::U32(_, buffer) => buffer.write(column.typed::<Int32Type>()),
            Cells::U64(_, buffer) => buffer.write(column.typed::<Int64Type>()),
            Cells::F32(_, buffer) => buffer.write(column.typed::<FloatType>()),
            Cells::F64(_, buffer) => buffer.write(column.typed::<DoubleType>()),
            Cells::Flag(_, buffer) => buffer.write(column.typed::<BoolType>()),
            Cells::Text(_, buffer) => buffer.write(column.typed::<ByteArrayType>()),
        }?;
        column.close()
    }
}

/// A table that is being written. Memory: the rows of one row group.
pub(super) struct TableWriter<R> {
    path: PathBuf,
    columns: Vec<Column<R>>,
    file: SerializedFileWriter<File>,
    /// Rows that are no columns yet, fewer than a block.
    rows: Vec<R>,
    /// Rows of the row group that are.
    taken: usize,
    written: u64,
}

impl<R> TableWriter<R> {
    /// Starts a file that is not there yet.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(super) fn create(path: PathBuf, columns: Vec<Column<R>>) -> anyhow::Result<Self> {
        let cannot = || format!("cannot write {}", path.display());
        let file = File::create_new(&path).with_context(cannot)?;
        let fields =
            columns.iter().map(Column::schema).collect::<Result<Vec<_>, _>>().with_context(cannot)?;
        let schema = Type::group_type_builder("rayscope").with_fields(fields).build().with_context(cannot)?;
        let file = SerializedFileWriter::new(file, Arc::new(schema), properties(&columns));
        let file = file.with_context(cannot)?;
        Ok(Self { path, columns, file, rows: Vec::new(), taken: 0, written: 0 })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If a full row group cannot be written.
    pub(super) fn push(&mut self, row: R) -> anyhow::Result<()> {
        self.rows.push(row);
        if self.rows.len() == ROWS_PER_BLOCK {
            self.take_block();
        }
        if self.taken == ROWS_PER_GROUP { self.write_group() } else { Ok(()) }
    }

    fn take_block(&mut self) {
        self.columns.iter_mut().for_each(|column| column.take(&self.rows));
        self.taken += self.rows.len();
        self.rows.clear();
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let mut write = || {
            let mut group = self.file.next_row_group()?;
            self.columns.iter_mut().try_for_each(|column| column.write(&mut group))?;
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
        self.take_block();
        if self.taken > 0 {
            self.write_group()?;
        }
        self.file.close().with_context(|| format!("cannot write {}", self.path.display()))?;
        Ok(self.written)
    }
}

fn properties<R>(columns: &[Column<R>]) -> WriterPropertiesPtr {
    let mut properties = WriterProperties::builder()
        .set_created_by(format!("Rayscope {}", env!("CARGO_PKG_VERSION")))
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
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
        let even = |row: &usize| row.is_multiple_of(2).then_some(*row as u32);
        let columns = vec![
            Column::u32("row", "Row", Values::Near, |row: &usize| Some(*row as u32)),
            Column::u32("even", "The same, if it is even", Values::Few, even),
        ];
        let mut table = TableWriter::create(path.clone(), columns).unwrap();
        let rows = ROWS_PER_GROUP + ROWS_PER_BLOCK + 7;
        (0..rows).try_for_each(|row| table.push(row)).unwrap();
        assert_eq!(table.finish().unwrap(), rows as u64);
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let groups: Vec<i64> = reader.metadata().row_groups().iter().map(|group| group.num_rows()).collect();
        assert_eq!(groups, [ROWS_PER_GROUP as i64, ROWS_PER_BLOCK as i64 + 7]);
        assert!(groups[..1].iter().all(|rows| rows % 128 == 0));
        for (at, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let expected = if at.is_multiple_of(2) { at.to_string() } else { "null".to_owned() };
            assert_eq!(row.unwrap().to_string(), format!("{{row: {at}, even: {expected}}}"));
        }
        let taken = TableWriter::<usize>::create(path, Vec::new()).err().unwrap().to_string();
        assert!(taken.contains("cannot write "), "{taken}");
    }
}
