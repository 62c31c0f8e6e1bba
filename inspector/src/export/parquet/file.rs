//! A Parquet file: pages that are compressed one after the other, and what they are at its end.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::column::page::{CompressedPage, Page, PageWriteSpec, PageWriter};
use parquet::errors::ParquetError;
use parquet::file::metadata::{
    ColumnChunkMetaData, FileMetaData, KeyValue, PageEncodingStats, ParquetMetaDataBuilder,
    ParquetMetaDataWriter, RowGroupMetaData,
};
use parquet::file::statistics::Statistics;
use parquet::file::writer::{SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{SchemaDescPtr, SchemaDescriptor, TypePtr};
use zstd::bulk::Compressor;

/// What a Parquet file starts with.
const MAGIC: &[u8] = b"PAR1";
/// Version of the format whose pages these are.
const VERSION: i32 = 1;

/// A column of a row group as pages that are not compressed yet. Its room serves one after the other.
pub(super) struct Chunk {
    /// The dictionary, entry by entry; empty for none.
    pub(super) dictionary: Vec<u8>,
    /// How many entries it has.
    pub(super) entries: usize,
    /// Which rows have a cell, then the cells.
    pub(super) page: Vec<u8>,
    /// How the cells are encoded.
    pub(super) encoding: Encoding,
    /// What is known of all cells.
    pub(super) statistics: Option<Statistics>,
}

impl Chunk {
    /// Without a cell.
    pub(super) fn new() -> Self {
        Self {
            dictionary: Vec::new(),
            entries: 0,
            page: Vec::new(),
            encoding: Encoding::PLAIN,
            statistics: None,
        }
    }

    /// Starts the page with the runs that say which rows have a cell.
    pub(super) fn levels(&mut self, write: impl FnOnce(&mut Vec<u8>)) {
        const LENGTH: usize = size_of::<u32>();
        self.page.extend([0; LENGTH]);
        write(&mut self.page);
        let bytes = (self.page.len() - LENGTH) as u32;
        self.page[..LENGTH].copy_from_slice(&bytes.to_le_bytes());
    }

    fn clear(&mut self) {
        self.dictionary.clear();
        self.page.clear();
        self.entries = 0;
        self.statistics = None;
    }
}

/// A file in the making.
pub(super) struct ColumnFile {
    file: TrackedWrite<File>,
    schema: SchemaDescPtr,
    compressor: Compressor<'static>,
    /// Room of a compressed page.
    packed: Vec<u8>,
    /// Columns of the row group.
    columns: Vec<ColumnChunkMetaData>,
    groups: Vec<RowGroupMetaData>,
}

impl ColumnFile {
    /// Starts a file that is not there yet.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(super) fn create(path: &Path, schema: TypePtr) -> Result<Self, ParquetError> {
        let mut file = TrackedWrite::new(File::create_new(path)?);
        file.write_all(MAGIC)?;
        Ok(Self {
            file,
            schema: Arc::new(SchemaDescriptor::new(schema)),
            compressor: Compressor::new(ZstdLevel::default().compression_level())?,
            packed: Vec::new(),
            columns: Vec::new(),
            groups: Vec::new(),
        })
    }

    /// Writes the next column of the row group, and empties it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(&mut self, rows: usize, chunk: &mut Chunk) -> Result<(), ParquetError> {
        let mut metadata = ColumnChunkMetaData::builder(self.schema.column(self.columns.len()))
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_num_values(rows as i64);
        if let Some(statistics) = chunk.statistics.take() {
            metadata = metadata.set_statistics(statistics);
        }
        let mut pages = Vec::new();
        let mut encodings = vec![Encoding::RLE, chunk.encoding];
        if chunk.entries > 0 {
            let page = self.write_page(&chunk.dictionary, |buf| Page::DictionaryPage {
                buf: buf.into(),
                num_values: chunk.entries as u32,
                encoding: Encoding::PLAIN,
                is_sorted: false,
            })?;
            metadata = metadata.set_dictionary_page_offset(Some(page.offset as i64));
            encodings.push(Encoding::PLAIN);
            pages.push((page, Encoding::PLAIN));
        }
        let page = self.write_page(&chunk.page, |buf| Page::DataPage {
            buf: buf.into(),
            num_values: rows as u32,
            encoding: chunk.encoding,
            def_level_encoding: Encoding::RLE,
            rep_level_encoding: Encoding::RLE,
            statistics: None,
        })?;
        metadata = metadata.set_data_page_offset(page.offset as i64).set_encodings(encodings);
        pages.push((page, chunk.encoding));
        let stats = |(page, encoding): &(PageWriteSpec, _)| PageEncodingStats {
            page_type: page.page_type,
            encoding: *encoding,
            count: 1,
        };
        metadata = metadata
            .set_total_compressed_size(pages.iter().map(|(page, _)| page.compressed_size as i64).sum())
            .set_total_uncompressed_size(pages.iter().map(|(page, _)| page.uncompressed_size as i64).sum())
            .set_page_encoding_stats(pages.iter().map(stats).collect());
        self.columns.push(metadata.build()?);
        chunk.clear();
        Ok(())
    }

    fn write_page(
        &mut self,
        plain: &[u8],
        page: impl FnOnce(Vec<u8>) -> Page,
    ) -> Result<PageWriteSpec, ParquetError> {
        let mut packed = std::mem::take(&mut self.packed);
        packed.clear();
        packed.reserve(zstd::zstd_safe::compress_bound(plain.len()));
        self.compressor.compress_to_buffer(plain, &mut packed)?;
        let page = page(packed);
        let room = page.buffer().clone();
        let written =
            SerializedPageWriter::new(&mut self.file).write_page(CompressedPage::new(page, plain.len()))?;
        // No longer shared, so that nothing is copied.
        self.packed = room.into();
        Ok(written)
    }

    /// Ends a row group, all of whose columns were written.
    ///
    /// # Errors
    /// If some were not.
    pub(super) fn end_group(&mut self, rows: usize) -> Result<(), ParquetError> {
        let columns = std::mem::take(&mut self.columns);
        let group = RowGroupMetaData::builder(self.schema.clone())
            .set_total_byte_size(columns.iter().map(ColumnChunkMetaData::uncompressed_size).sum())
            .set_num_rows(rows as i64)
            .set_ordinal(self.groups.len() as i32)
            .set_column_metadata(columns);
        self.groups.push(group.build()?);
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn finish(mut self, about: Vec<KeyValue>) -> Result<(), ParquetError> {
        let rows = self.groups.iter().map(RowGroupMetaData::num_rows).sum();
        let by = format!("Rayscope {}", env!("CARGO_PKG_VERSION"));
        let metadata = FileMetaData::new(VERSION, rows, Some(by), Some(about), self.schema, None);
        let metadata = ParquetMetaDataBuilder::new(metadata).set_row_groups(self.groups).build();
        // By way of memory: it drops what it writes to, and with it the errors of what was not written yet.
        let mut end = Vec::new();
        ParquetMetaDataWriter::new(&mut end, &metadata).finish()?;
        self.file.write_all(&end)?;
        Ok(self.file.flush()?)
    }
}
