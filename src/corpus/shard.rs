//! Writing a shard: clip by clip into temporary files, then renames, then the commit record.
//!
//! A shard may be written whole, or some of its tables anew (other thresholds: annotations, plants, segments). In
//! both cases the record is what counts: before the first file of an existing shard is replaced, its record is put
//! with the keys of the tables' stages emptied, so that a kill between leaves a stage to be made, never a lie.

use super::columns::Columns;
use super::error::CorpusError;
use super::paths::{ShardId, ShardStage, Table};
use super::record::{FileRecord, ShardRecord, read_record};
use super::store::{Store, Temporary};
use super::tables::{
    ChannelsTable, FeaturesTable, GatherLabels, GatherPlants, GatherSegments, PosesTable, annotations_columns,
    plants_columns, pose_layout, provenance_columns, refuse_provenance, segments_columns,
};
use super::writer::{Compressing, FileNotes, TableWriter, block_rows};
use crate::annotate::{Features, FrameLabels, Plant, Segment};
use crate::motion::{Poses, RoleMap, Rotations, Skeleton};
use crate::synthesis::ProvenanceRow;
use arrow::datatypes::SchemaRef;
use std::collections::BTreeMap;

/// What to write of a shard.
#[derive(Clone, Debug, Default)]
pub struct ShardSettings {
    /// Which tables. Others are left as they are.
    pub tables: Vec<Table>,
    /// File metadata of each table: detectors, constants, weights.
    pub notes: BTreeMap<Table, FileNotes>,
    /// `poses` has local rotations too.
    pub rotations: bool,
    /// How files are compressed.
    pub compressing: Compressing,
}

/// The rows of one clip, for the tables that are written; others are not looked at.
#[derive(Clone, Copy, Debug)]
pub struct ClipTables<'a> {
    /// Greater than that of the clip before.
    pub clip_id: u32,
    /// Number of frames.
    pub n_frames: usize,
    /// Frames a second: `time_s` of `poses` is frame over rate.
    pub rate_hz: f64,
    /// Gives channels and poses their columns.
    pub skeleton: &'a Skeleton,
    /// Gives columns their metadata.
    pub roles: &'a RoleMap,
    /// `[frame][channel]`, file units.
    pub channels: Option<&'a [f32]>,
    /// World positions.
    pub poses: Option<&'a Poses>,
    /// Local rotations, where the settings ask for them.
    pub rotations: Option<&'a Rotations>,
    /// None: no rows (no hips).
    pub labels: Option<&'a FrameLabels>,
    /// None, or without effectors: no rows.
    pub features: Option<&'a Features>,
    /// Feet on the ground.
    pub plants: &'a [Plant],
    /// Runs of one gait.
    pub segments: &'a [Segment],
    /// Of a made clip, by frame.
    pub provenance: &'a [ProvenanceRow],
}

/// A shard being written. Dropped before its commit it leaves nothing behind.
#[derive(Debug)]
pub struct ShardWriter {
    store: Store,
    shard: ShardId,
    settings: ShardSettings,
    sinks: BTreeMap<(Table, String), Sink>,
    /// `(clip_id, frames)`.
    pushed: Vec<(u32, u32)>,
    /// Part of a clip may have been written: nothing but dropping is left.
    broken: bool,
}

/// A shard whose files are written and synced under temporary names.
#[derive(Debug)]
pub struct FinishedShard {
    store: Store,
    shard: ShardId,
    tables: Vec<Table>,
    pushed: Vec<(u32, u32)>,
    files: Vec<(FileRecord, Temporary)>,
}

#[derive(Debug)]
struct Sink {
    name: String,
    writer: TableWriter<Temporary>,
    filling: Filling,
}

/// What turns rows into columns before the writer.
#[derive(Debug)]
enum Filling {
    Channels(ChannelsTable),
    Poses(PosesTable),
    Features(FeaturesTable),
    Columns,
}

impl ShardWriter {
    /// Begins a shard, or some of its tables. No file is made before the first clip with rows for it; a table
    /// without any gets a file without rows when the writer finishes, unless its columns depend on a layout.
    pub fn create(store: &Store, shard: ShardId, settings: ShardSettings) -> ShardWriter {
        ShardWriter { store: store.clone(), shard, settings, sinks: BTreeMap::new(), pushed: Vec::new(), broken: false }
    }

    /// Appends a clip. Its rows are checked first.
    ///
    /// # Errors
    /// [`CorpusError::Refused`]: lengths that don't fit, numbers that aren't finite, clips out of order; nothing of
    /// the clip was written and the next one may follow. Anything else: the file system's or the encoder's refusal,
    /// after which the writer can only be dropped.
    pub fn push(&mut self, clip: &ClipTables<'_>) -> Result<(), CorpusError> {
        self.check(clip)?;
        self.pushed.push((clip.clip_id, clip.n_frames as u32));
        self.broken = true;
        for table in self.settings.tables.clone() {
            self.push_table(table, clip)?;
        }
        self.broken = false;
        Ok(())
    }

    /// Ends the files and syncs them, still under their temporary names.
    ///
    /// # Errors
    /// The file system's refusals.
    pub fn finish(mut self) -> Result<FinishedShard, CorpusError> {
        if self.broken {
            let path = self.store.path(&self.shard.record_file());
            return Err(CorpusError::Encoding { path, what: "a clip was written in part".to_owned() });
        }
        for table in self.settings.tables.clone() {
            if let Some(schema) = empty_schema(table) {
                self.sink(table, "", || (schema, Filling::Columns))?;
            }
        }
        let mut files = Vec::new();
        for sink in self.sinks.into_values() {
            let (record, temporary) = sink.finish()?;
            files.push((record, temporary));
        }
        files.sort_by(|(a, _), (b, _)| a.path.cmp(&b.path));
        Ok(FinishedShard {
            store: self.store,
            shard: self.shard,
            tables: self.settings.tables,
            pushed: self.pushed,
            files,
        })
    }

    /// Bytes that wait in memory for their row group to end, about.
    pub fn buffered_bytes(&self) -> usize {
        self.sinks.values().map(|sink| sink.writer.buffered_bytes()).sum()
    }

    fn check(&self, clip: &ClipTables<'_>) -> Result<(), CorpusError> {
        let refused = |table: &'static str, what: String| CorpusError::Refused { clip_id: clip.clip_id, table, what };
        if let Some((last, _)) = self.pushed.last().filter(|(last, _)| *last >= clip.clip_id) {
            return Err(refused("clips", format!("it comes after clip {last}")));
        }
        if !(clip.rate_hz.is_finite() && clip.rate_hz > 0.0) || u32::try_from(clip.n_frames).is_err() {
            return Err(refused("clips", format!("{} frames at {} Hz", clip.n_frames, clip.rate_hz)));
        }
        for &table in &self.settings.tables {
            let n = clip.n_frames;
            let checked = match table {
                Table::Channels => match clip.channels {
                    Some(values) => ChannelsTable::refuse(values, n, clip.skeleton.n_channels()),
                    None => Err("not given".to_owned()),
                },
                Table::Poses => match (clip.poses, clip.rotations, self.settings.rotations) {
                    (None, ..) | (_, None, true) => Err("not given".to_owned()),
                    (Some(poses), rotations, wanted) => {
                        PosesTable::refuse(clip.skeleton, n, poses, rotations.filter(|_| wanted))
                    }
                },
                Table::Annotations => clip.labels.map_or(Ok(()), |labels| GatherLabels::refuse(labels, n)),
                Table::Features => clip.features().map_or(Ok(()), |features| FeaturesTable::refuse(features, n)),
                Table::Plants => GatherPlants::refuse(clip.plants, n),
                Table::Segments => GatherSegments::refuse(clip.segments, n),
                Table::Provenance => refuse_provenance(clip.provenance, n),
            };
            checked.map_err(|what| refused(table.name(), what))?;
        }
        Ok(())
    }

    fn push_table(&mut self, table: Table, clip: &ClipTables<'_>) -> Result<(), CorpusError> {
        let id = clip.clip_id;
        match table {
            Table::Channels => {
                let values = clip.channels.unwrap_or_default();
                let (layout, n_channels) = (clip.skeleton.layout_id(), clip.skeleton.n_channels());
                let sink = self.sink(table, &layout, || {
                    let schema = ChannelsTable::schema(clip.skeleton, clip.roles);
                    let filling = ChannelsTable::new(schema.clone(), block_rows(&schema), n_channels);
                    (schema, Filling::Channels(filling))
                })?;
                let Filling::Channels(filling) = &mut sink.filling else { return Ok(()) };
                filling.push(id, clip.n_frames, values, |batch| sink.writer.write(batch))
            }
            Table::Poses => {
                let Some(poses) = clip.poses else { return Ok(()) };
                let rotations = clip.rotations.filter(|_| self.settings.rotations);
                let sink = self.sink(table, &pose_layout(clip.skeleton), || {
                    let schema = PosesTable::schema(clip.skeleton, clip.roles, rotations.is_some());
                    let n_rotations = rotations.map_or(0, |rotations| rotations.n_joints);
                    let filling = PosesTable::new(schema.clone(), block_rows(&schema), poses.n_points, n_rotations);
                    (schema, Filling::Poses(filling))
                })?;
                let Filling::Poses(filling) = &mut sink.filling else { return Ok(()) };
                filling.push(id, clip.rate_hz, poses, rotations, |batch| sink.writer.write(batch))
            }
            Table::Features => {
                let Some(features) = clip.features() else { return Ok(()) };
                let sink = self.sink(table, "", || {
                    let schema = FeaturesTable::schema();
                    let filling = FeaturesTable::new(schema.clone(), block_rows(&schema));
                    (schema, Filling::Features(filling))
                })?;
                let Filling::Features(filling) = &mut sink.filling else { return Ok(()) };
                filling.push(id, &features.values, |batch| sink.writer.write(batch))
            }
            Table::Annotations => match clip.labels {
                Some(labels) => self.push_columns(table, annotations_columns(id, labels)),
                None => Ok(()),
            },
            Table::Plants => self.push_columns(table, plants_columns(id, clip.plants)),
            Table::Segments => self.push_columns(table, segments_columns(id, clip.segments)),
            Table::Provenance => self.push_columns(table, provenance_columns(id, clip.provenance)),
        }
    }

    fn push_columns(&mut self, table: Table, columns: Columns) -> Result<(), CorpusError> {
        let sink = self.sink(table, "", || (columns.schema(), Filling::Columns))?;
        let batch = columns.into_batch()?;
        sink.writer.write(batch)
    }

    fn sink(
        &mut self,
        table: Table,
        layout: &str,
        make: impl FnOnce() -> (SchemaRef, Filling),
    ) -> Result<&mut Sink, CorpusError> {
        use std::collections::btree_map::Entry;
        match self.sinks.entry((table, layout.to_owned())) {
            Entry::Occupied(entry) => Ok(entry.into_mut()),
            Entry::Vacant(entry) => {
                let name = self.shard.file(table, layout);
                let temporary = self.store.temporary(&name)?;
                let path = temporary.path().to_owned();
                let none = FileNotes::new();
                let notes = self.settings.notes.get(&table).unwrap_or(&none);
                let (schema, filling) = make();
                let how = self.settings.compressing;
                let writer = TableWriter::new(temporary, &path, table.name(), schema, notes, how)?;
                Ok(entry.insert(Sink { name, writer, filling }))
            }
        }
    }
}

impl FinishedShard {
    /// The files, by path.
    pub fn files(&self) -> Vec<FileRecord> {
        self.files.iter().map(|(record, _)| record.clone()).collect()
    }

    /// Puts the files in their places and then the record, whose `files` are set here: those written, and of an
    /// existing shard those of the tables that were not. Files that the new record doesn't name any more go last.
    ///
    /// # Errors
    /// [`CorpusError::Encoding`] for a record of another shard or of other clips than were pushed, or with numbers that
    /// aren't finite; nothing was changed. The file system's refusals, after which the shard is as it was, or a stage
    /// of it has to be made again.
    pub fn commit(self, mut record: ShardRecord) -> Result<ShardRecord, CorpusError> {
        self.check(&record)?;
        let old = match read_record(&self.store, self.shard) {
            Ok(old) => old,
            // A record that can't be read is no record, and its shard is not there.
            Err(CorpusError::Damaged { .. } | CorpusError::Version { .. }) => {
                self.store.remove(&self.shard.record_file())?;
                None
            }
            Err(error) => return Err(error),
        };
        let stays = |file: &FileRecord| Table::of_file(&file.path).is_some_and(|table| !self.tables.contains(&table));
        let before = old.as_ref().map(|old| old.files.clone()).unwrap_or_default();
        record.files = before.iter().filter(|file| stays(file)).cloned().collect();
        record.files.extend(self.files());
        record.files.sort();
        if let Some(mut emptied) = old {
            for stage in [ShardStage::Ingest, ShardStage::Features, ShardStage::Labels] {
                if self.tables.iter().any(|table| table.stage() == stage) {
                    emptied.keys.set(stage, "");
                }
            }
            emptied.files.retain(stays);
            emptied.put(&self.store)?;
        }
        for (file, temporary) in self.files {
            temporary.rename()?;
            self.store.sync_folder_of(&file.path)?;
        }
        record.put(&self.store)?;
        for file in before {
            if !record.files.iter().any(|now| now.path == file.path) {
                self.store.remove(&file.path)?;
            }
        }
        for shard in &record.replaces {
            if let Some(replaced) = read_record(&self.store, *shard)? {
                remove_shard(&self.store, &replaced)?;
            }
        }
        Ok(record)
    }

    fn check(&self, record: &ShardRecord) -> Result<(), CorpusError> {
        let refused = |what: String| {
            let path = self.store.path(&self.shard.record_file());
            Err(CorpusError::Encoding { path, what })
        };
        if record.shard != self.shard {
            return refused(format!("given the record of {}", record.shard));
        }
        let rows = record.clips.iter().map(|clip| (clip.clip_id, clip.frames));
        if !self.tables.is_empty() && !rows.eq(self.pushed.iter().copied()) {
            return refused("its clips are not those that were written".to_owned());
        }
        record.refuse(&self.store).or_else(refused)
    }
}

impl Sink {
    fn finish(mut self) -> Result<(FileRecord, Temporary), CorpusError> {
        let writer = &mut self.writer;
        match &mut self.filling {
            Filling::Channels(filling) => filling.take(|batch| writer.write(batch))?,
            Filling::Poses(filling) => filling.take(|batch| writer.write(batch))?,
            Filling::Features(filling) => filling.take(|batch| writer.write(batch))?,
            Filling::Columns => {}
        }
        let (mut temporary, written) = self.writer.finish()?;
        temporary.sync()?;
        let record = FileRecord { path: self.name, bytes: written.bytes, blake3: written.blake3, rows: written.rows };
        Ok((record, temporary))
    }
}

impl ClipTables<'_> {
    fn features(&self) -> Option<&Features> {
        self.features.filter(|features| !features.effectors.is_empty())
    }
}

/// The schema of a table whose columns don't depend on a layout.
fn empty_schema(table: Table) -> Option<SchemaRef> {
    match table {
        Table::Channels | Table::Poses => None,
        Table::Features => Some(FeaturesTable::schema()),
        Table::Annotations => Some(annotations_columns(0, &FrameLabels::default()).schema()),
        Table::Plants => Some(plants_columns(0, &[]).schema()),
        Table::Segments => Some(segments_columns(0, &[]).schema()),
        Table::Provenance => Some(provenance_columns(0, &[]).schema()),
    }
}

/// Removes a shard: its record first, then its files.
///
/// # Errors
/// The file system's refusals; what is left then goes when the next run opens the corpus.
pub fn remove_shard(store: &Store, record: &ShardRecord) -> Result<(), CorpusError> {
    let name = record.shard.record_file();
    store.remove(&name)?;
    store.sync_folder_of(&name)?;
    record.files.iter().try_for_each(|file| store.remove(&file.path))
}
