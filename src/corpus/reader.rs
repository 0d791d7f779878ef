//! Parquet files of a corpus being read: never trusted, a few columns or the rows of one clip at a time.

use super::error::CorpusError;
use super::guard::guarded;
use super::record::FileRecord;
use super::rows::Rows;
use super::store::Store;
use super::unchanged::Unchanged;
use super::writer::block_rows;
use arrow::array::RecordBatch;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder, RowSelection,
};
use parquet::file::metadata::PageIndexPolicy;
use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An open Parquet file whose footer has been read.
#[derive(Debug)]
pub(super) struct TableFile {
    path: PathBuf,
    metadata: ArrowReaderMetadata,
    n_rows: usize,
}

/// The batches of a reading; after an error it ends.
pub(super) struct Batches {
    path: PathBuf,
    inner: Option<ParquetRecordBatchReader>,
}

/// What the rows of one clip are gathered into.
pub(super) trait Gather: Default {
    /// What they make.
    type Clip;
    /// Takes more rows of the same clip.
    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError>;
    /// All rows have come.
    fn done(self) -> Self::Clip;
}

/// The clips of one file, in order, as `(clip_id, its rows)`; holds one clip and one batch.
pub(super) struct ClipStream<G> {
    batches: Batches,
    batch: Option<RecordBatch>,
    at: usize,
    open: Option<(u32, G)>,
    failed: bool,
}

impl TableFile {
    /// Opens a file and reads its footer. A file of a shard must be the one of its record; its digest is taken the first
    /// time that it is opened.
    pub(super) fn open(
        store: &Store,
        name: &str,
        record: Option<(&FileRecord, &Unchanged)>,
    ) -> Result<TableFile, CorpusError> {
        let path = store.path(name);
        let file = open_file(&path)?;
        if let Some((record, unchanged)) = record {
            unchanged.check(&path, record)?;
        }
        let metadata = guarded(&path, || {
            let options = ArrowReaderOptions::new().with_page_index_policy(PageIndexPolicy::Optional);
            ArrowReaderMetadata::load(&file, options).map_err(|error| CorpusError::damaged(&path, error.to_string()))
        })?;
        let counted = metadata.metadata().row_groups().iter().try_fold(0usize, |sum, group| {
            usize::try_from(group.num_rows()).ok().and_then(|rows| sum.checked_add(rows))
        });
        let n_rows = counted.ok_or_else(|| CorpusError::damaged(&path, "row counts that can't be"))?;
        if let Some((record, _)) = record
            && record.rows != n_rows as u64
        {
            return Err(CorpusError::damaged(&path, format!("{n_rows} rows, {} were written", record.rows)));
        }
        Ok(TableFile { path, metadata, n_rows })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Our own entries of the file metadata, without their prefix.
    pub(super) fn notes(&self) -> BTreeMap<String, String> {
        let entries = self.metadata.metadata().file_metadata().key_value_metadata().into_iter().flatten();
        entries
            .filter_map(|entry| {
                Some((entry.key.strip_prefix("motionmill.")?.to_owned(), entry.value.clone().unwrap_or_default()))
            })
            .collect()
    }

    /// Rows in batches: of all columns or some, from a range or all.
    pub(super) fn batches(&self, columns: Option<&[&str]>, rows: Option<Range<usize>>) -> Result<Batches, CorpusError> {
        let file = open_file(&self.path)?;
        let inner = guarded(&self.path, || {
            let mut builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, self.metadata.clone())
                .with_batch_size(block_rows(self.metadata.schema()));
            if let Some(columns) = columns {
                let indices = columns.iter().map(|name| self.metadata.schema().index_of(name));
                let indices: Vec<usize> = indices
                    .collect::<Result<_, _>>()
                    .map_err(|error| CorpusError::damaged(&self.path, error.to_string()))?;
                let mask = ProjectionMask::roots(builder.parquet_schema(), indices);
                builder = builder.with_projection(mask);
            }
            if let Some(rows) = rows {
                let selection = RowSelection::from_consecutive_ranges(std::iter::once(rows), self.n_rows);
                builder = builder.with_row_selection(selection);
            }
            builder.build().map_err(|error| CorpusError::damaged(&self.path, error.to_string()))
        })?;
        Ok(Batches { path: self.path.clone(), inner: Some(inner) })
    }

    /// The rows of a clip: empty where it has none. Looks at the `clip_id` column alone, which is delta-packed.
    pub(super) fn rows_of_clip(&self, clip_id: u32) -> Result<Range<usize>, CorpusError> {
        let (mut first, mut end) = (0, 0);
        let mut seen = 0;
        for batch in self.batches(Some(&["clip_id"]), None)? {
            let batch = batch?;
            let ids = Rows::new(&batch, &self.path).u32("clip_id")?;
            first += ids.partition_point(|&id| id < clip_id);
            end += ids.partition_point(|&id| id <= clip_id);
            seen += ids.len();
            if end < seen {
                break;
            }
        }
        Ok(first..end.max(first))
    }

    /// The rows of one clip, gathered; those of no rows where it has none.
    pub(super) fn clip<G: Gather>(&self, clip_id: u32) -> Result<G::Clip, CorpusError> {
        let rows = self.rows_of_clip(clip_id)?;
        let mut gathered = G::default();
        if !rows.is_empty() {
            for batch in self.batches(None, Some(rows))? {
                let batch = batch?;
                let rows = Rows::new(&batch, &self.path);
                if rows.u32("clip_id")?.iter().any(|&id| id != clip_id) {
                    return Err(rows.damaged("clips out of order"));
                }
                gathered.gather(&rows)?;
            }
        }
        Ok(gathered.done())
    }

    /// All clips of the file, one after the other.
    pub(super) fn clips<G: Gather>(&self) -> Result<ClipStream<G>, CorpusError> {
        Ok(ClipStream { batches: self.batches(None, None)?, batch: None, at: 0, open: None, failed: false })
    }
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, CorpusError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut inner = self.inner.take()?;
        let result = guarded(&self.path, || match inner.next() {
            Some(Ok(batch)) => Ok(Some(batch)),
            Some(Err(error)) => Err(CorpusError::damaged(&self.path, error.to_string())),
            None => Ok(None),
        });
        if matches!(result, Ok(Some(_))) {
            self.inner = Some(inner);
        }
        result.transpose()
    }
}

impl<G: Gather> Iterator for ClipStream<G> {
    type Item = Result<(u32, G::Clip), CorpusError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let result = self.step();
        self.failed = result.is_err();
        result.transpose()
    }
}

impl<G: Gather> ClipStream<G> {
    fn step(&mut self) -> Result<Option<(u32, G::Clip)>, CorpusError> {
        let finished = |(id, clip): (u32, G)| (id, clip.done());
        loop {
            let batch = match &self.batch {
                Some(batch) if self.at < batch.num_rows() => batch,
                _ => match self.batches.next().transpose()? {
                    Some(batch) => {
                        self.at = 0;
                        self.batch.insert(batch)
                    }
                    None => return Ok(self.open.take().map(finished)),
                },
            };
            let ids = Rows::new(batch, &self.batches.path).u32("clip_id")?;
            let Some(&id) = ids.get(self.at) else { continue };
            match &self.open {
                Some((open, _)) if id < *open => {
                    return Err(CorpusError::damaged(&self.batches.path, "clips out of order"));
                }
                Some((open, _)) if id > *open => return Ok(self.open.take().map(finished)),
                _ => {}
            }
            let n = ids[self.at..].iter().take_while(|&&other| other == id).count();
            let run = batch.slice(self.at, n);
            self.at += n;
            self.open.get_or_insert_with(|| (id, G::default())).1.gather(&Rows::new(&run, &self.batches.path))?;
        }
    }
}

fn open_file(path: &Path) -> Result<File, CorpusError> {
    File::open(path).map_err(|error| CorpusError::io(path, "opening", error))
}
