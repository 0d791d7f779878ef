//! Parquet files with pinned settings: the same rows give the same bytes.
//!
//! Floats are byte-stream-split, whole numbers delta-packed, strings dictionary-encoded, all under zstd. Pages and
//! row groups end at row counts that follow from the schema alone, never from what happens to be buffered.
//!
//! Measured with `benches/tables.rs`, channels table, one thread, processor time on a busy machine. Sizes (bytes a byte
//! of text) are exact; speeds (MB of text a second, lowest and highest of three) only tell large differences.
//! 21 MB of Bandai-Namco text, 92 clips, 132 channels:
//!
//! | settings | size | speed |
//! | --- | --- | --- |
//! | these | 0.1646 | 604-673 (457-688 over 20 more runs) |
//! | zstd 3 | 0.1627 | 482-615 |
//! | floats plain | 0.1911 | 666-736 |
//! | dictionaries everywhere, floats plain (the crate's default) | 0.2816 | 209-211 |
//! | whole numbers plain | 0.1648 | 602-697 |
//! | statistics a row group only | 0.1644 | 674-729 |
//! | pages of 4,096 rows | 0.1671 | 480-507 |
//! | no compression, floats plain | 0.4240 | 881-1236 |
//!
//! 105 MB of it, 982 clips: 0.1419 and 768-874. So the dictionary costs three times the speed and 1.7 times the size,
//! byte stream split saves a seventh of the size, small pages cost both; the rest lies within the noise of the clock.

use super::error::CorpusError;
use super::paths::Table;
use arrow::array::RecordBatch;
use arrow::compute::concat_batches;
use arrow::datatypes::{DataType, Field, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::metadata::SortingColumn;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterVersion};
use parquet::schema::types::ColumnPath;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Version of the tables and records; a new one when a column changes its name, type or meaning.
pub const FORMAT_VERSION: u32 = 2;

/// File metadata beyond the format version: detectors, constants, weights.
pub type FileNotes = BTreeMap<String, String>;

/// How the tables are compressed; the corpus uses [`Compressing::default`], the bench compares others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compressing {
    /// zstd level; None: no compression.
    pub zstd_level: Option<i32>,
    /// Byte stream split for floats, instead of plain.
    pub split_floats: bool,
    /// Dictionaries for every column, instead of strings alone.
    pub dictionary_everywhere: bool,
    /// Delta packing for whole numbers, instead of plain.
    pub delta_integers: bool,
    /// Statistics a page, instead of a row group only.
    pub page_statistics: bool,
    /// Rows a page.
    pub page_rows: usize,
}

impl Default for Compressing {
    fn default() -> Compressing {
        Compressing {
            zstd_level: Some(1),
            split_floats: true,
            dictionary_everywhere: false,
            delta_integers: true,
            page_statistics: true,
            page_rows: 20_480,
        }
    }
}

/// What a written file is known by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Written {
    pub(super) bytes: u64,
    pub(super) blake3: String,
    pub(super) rows: u64,
}

/// One Parquet file being written, block by block.
pub(super) struct TableWriter<W: Write + Send> {
    writer: ArrowWriter<Counted<W>>,
    schema: SchemaRef,
    path: PathBuf,
    block_rows: usize,
    waiting: Vec<RecordBatch>,
    waiting_rows: usize,
    rows: u64,
}

/// A writer that knows how much went through it, and its digest.
struct Counted<W> {
    inner: W,
    hasher: blake3::Hasher,
    bytes: u64,
}

/// Rows that go to the encoder at once: about 8 MiB of them, 256 to 4,096.
pub(super) fn block_rows(schema: &SchemaRef) -> usize {
    let fit = (8 << 20) / row_bytes(schema).max(1);
    // A power of two, so that pages and row groups are whole numbers of blocks.
    (fit.clamp(256, 4096) + 1).next_power_of_two() / 2
}

impl<W: Write + Send> TableWriter<W> {
    /// `path` is what errors name; `out` gets the bytes.
    pub(super) fn new(
        out: W,
        path: &Path,
        table: &str,
        schema: SchemaRef,
        notes: &FileNotes,
        how: Compressing,
    ) -> Result<TableWriter<W>, CorpusError> {
        let block_rows = block_rows(&schema);
        let counted = Counted { inner: out, hasher: blake3::Hasher::new(), bytes: 0 };
        let properties = properties(table, &schema, notes, how, block_rows);
        let writer = ArrowWriter::try_new(counted, schema.clone(), Some(properties))
            .map_err(|error| CorpusError::while_writing(path, error))?;
        let path = path.to_owned();
        Ok(TableWriter { writer, schema, path, block_rows, waiting: Vec::new(), waiting_rows: 0, rows: 0 })
    }

    /// Appends rows; they reach the encoder in whole blocks, so that the cut into batches can't show in the bytes.
    pub(super) fn write(&mut self, batch: RecordBatch) -> Result<(), CorpusError> {
        self.rows += batch.num_rows() as u64;
        self.waiting_rows += batch.num_rows();
        self.waiting.push(batch);
        if self.waiting_rows >= self.block_rows {
            let all = self.take_waiting()?;
            let whole = all.num_rows() / self.block_rows * self.block_rows;
            for start in (0..whole).step_by(self.block_rows) {
                self.encode(&all.slice(start, self.block_rows))?;
            }
            if whole < all.num_rows() {
                self.waiting_rows = all.num_rows() - whole;
                self.waiting.push(all.slice(whole, all.num_rows() - whole));
            }
        }
        Ok(())
    }

    /// Writes what is left and the footer, and gives `out` back.
    pub(super) fn finish(mut self) -> Result<(W, Written), CorpusError> {
        if self.waiting_rows > 0 {
            let all = self.take_waiting()?;
            self.encode(&all)?;
        }
        let counted = self.writer.into_inner().map_err(|error| CorpusError::while_writing(&self.path, error))?;
        let blake3 = counted.hasher.finalize().to_hex().to_string();
        Ok((counted.inner, Written { bytes: counted.bytes, blake3, rows: self.rows }))
    }

    /// Bytes that wait in memory for their row group to end, about.
    pub(super) fn buffered_bytes(&self) -> usize {
        let waiting: usize = self.waiting.iter().map(RecordBatch::get_array_memory_size).sum();
        self.writer.memory_size() + waiting
    }

    fn take_waiting(&mut self) -> Result<RecordBatch, CorpusError> {
        self.waiting_rows = 0;
        let mut waiting = std::mem::take(&mut self.waiting);
        if waiting.len() == 1 {
            return Ok(waiting.remove(0));
        }
        concat_batches(&self.schema, &waiting)
            .map_err(|error| CorpusError::Encoding { path: self.path.clone(), what: error.to_string() })
    }

    fn encode(&mut self, block: &RecordBatch) -> Result<(), CorpusError> {
        self.writer.write(block).map_err(|error| CorpusError::while_writing(&self.path, error))
    }
}

impl<W: Write + Send> std::fmt::Debug for TableWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TableWriter").field("path", &self.path).field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..n]);
        self.bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

fn properties(
    table: &str,
    schema: &SchemaRef,
    notes: &FileNotes,
    how: Compressing,
    block_rows: usize,
) -> WriterProperties {
    // About 64 MiB of values a row group; what is buffered is their compressed form.
    let group = ((64 << 20) / row_bytes(schema).max(1)).clamp(block_rows, 1 << 20) / block_rows * block_rows;
    let statistics = if how.page_statistics { EnabledStatistics::Page } else { EnabledStatistics::Chunk };
    let level = how.zstd_level.map(|level| ZstdLevel::try_new(level).unwrap_or_default());
    let mut metadata = vec![
        KeyValue::new("motionmill.format_version".to_owned(), FORMAT_VERSION.to_string()),
        KeyValue::new("motionmill.table".to_owned(), table.to_owned()),
    ];
    metadata.extend(notes.iter().map(|(key, value)| KeyValue::new(format!("motionmill.{key}"), value.clone())));
    // Everything that shows in the bytes is set, so that an upgrade of the crate changes nothing.
    let mut builder = WriterProperties::builder()
        .set_writer_version(WriterVersion::PARQUET_1_0)
        .set_created_by(format!("motionmill {FORMAT_VERSION}"))
        .set_compression(level.map_or(Compression::UNCOMPRESSED, Compression::ZSTD))
        .set_statistics_enabled(statistics)
        .set_statistics_truncate_length(Some(64))
        .set_column_index_truncate_length(Some(64))
        .set_write_page_header_statistics(false)
        .set_dictionary_enabled(how.dictionary_everywhere)
        .set_dictionary_page_size_limit(1 << 20)
        .set_data_page_size_limit(1 << 20)
        .set_data_page_row_count_limit(how.page_rows)
        .set_write_batch_size(1024)
        .set_max_row_group_row_count(Some(group))
        .set_bloom_filter_enabled(false)
        .set_coerce_types(false)
        .set_key_value_metadata(Some(metadata));
    if Table::from_name(table).is_some() && schema.fields().first().is_some_and(|field| field.name() == "clip_id") {
        let sorted = |column_idx| SortingColumn { column_idx, descending: false, nulls_first: false };
        let by_frame = schema.fields().get(1).is_some_and(|field| field.name() == "frame");
        builder = builder.set_sorting_columns(Some((0..if by_frame { 2 } else { 1 }).map(sorted).collect()));
    }
    for field in schema.fields() {
        let (path, kind) = leaf(field);
        let encoding = match kind {
            DataType::Float32 | DataType::Float64 if how.split_floats => Encoding::BYTE_STREAM_SPLIT,
            DataType::Int32 | DataType::UInt32 | DataType::UInt64 | DataType::UInt8 if how.delta_integers => {
                Encoding::DELTA_BINARY_PACKED
            }
            _ => Encoding::PLAIN,
        };
        if kind == DataType::Utf8 {
            builder = builder.set_column_dictionary_enabled(path.clone(), true);
        }
        builder = builder.set_column_encoding(path, encoding);
    }
    builder.build()
}

/// Path and type of a column's values: its own, or its list elements'.
fn leaf(field: &Field) -> (ColumnPath, DataType) {
    let name = field.name().clone();
    match field.data_type() {
        DataType::List(element) => {
            (ColumnPath::new(vec![name, "list".to_owned(), element.name().clone()]), element.data_type().clone())
        }
        kind => (ColumnPath::new(vec![name]), kind.clone()),
    }
}

fn row_bytes(schema: &SchemaRef) -> usize {
    schema.fields().iter().map(|field| field.data_type().primitive_width().unwrap_or(8)).sum()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::columns::{Columns, PLAIN};
    use super::*;
    use std::sync::Arc;

    struct Full(usize);

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0 < bytes.len() {
                return Err(io::Error::from(io::ErrorKind::StorageFull));
            }
            self.0 -= bytes.len();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn batch(range: std::ops::Range<u32>) -> RecordBatch {
        Columns::new()
            .u32("clip_id", PLAIN, range.clone().map(|n| n / 700))
            .f32("a.Xposition", PLAIN, range.map(|n| (n as f32).sqrt()))
            .into_batch()
            .unwrap()
    }

    fn write(cuts: &[u32]) -> (Vec<u8>, Written) {
        let schema = batch(0..0).schema();
        let how = Compressing::default();
        let mut writer =
            TableWriter::new(Vec::new(), Path::new("x"), "channels", schema, &FileNotes::new(), how).unwrap();
        for pair in cuts.windows(2) {
            writer.write(batch(pair[0]..pair[1])).unwrap();
        }
        writer.finish().unwrap()
    }

    #[test]
    fn the_cut_into_batches_does_not_show() {
        let (bytes, written) = write(&[0, 50_000]);
        assert_eq!((written.bytes, written.rows), (bytes.len() as u64, 50_000));
        assert_eq!(written.blake3, blake3::hash(&bytes).to_hex().to_string());
        assert_eq!(write(&[0, 1, 700, 4096, 4097, 12_288, 49_999, 50_000]).0, bytes);
    }

    #[test]
    fn a_full_disk_comes_through_the_encoder() {
        for room in [0, 100, 3000] {
            let schema = batch(0..0).schema();
            let how = Compressing::default();
            let notes = FileNotes::new();
            let error = TableWriter::new(Full(room), Path::new("x.parquet"), "channels", schema, &notes, how)
                .and_then(|mut writer| {
                    writer.write(batch(0..50_000))?;
                    writer.finish()
                })
                .err()
                .unwrap();
            assert_eq!(error.to_string(), "x.parquet: the disk is full while writing", "room for {room}");
        }
    }

    #[test]
    fn blocks_shrink_for_wide_tables() {
        let wide = |n: usize| -> SchemaRef {
            let field = |k| Field::new(format!("c{k}"), DataType::Float32, false);
            Arc::new(arrow::datatypes::Schema::new((0..n).map(field).collect::<Vec<_>>()))
        };
        assert_eq!(block_rows(&wide(1)), 4096);
        assert_eq!(block_rows(&wide(132)), 4096);
        assert_eq!(block_rows(&wide(1000)), 2048);
        assert_eq!(block_rows(&wide(12_300)), 256);
    }
}
