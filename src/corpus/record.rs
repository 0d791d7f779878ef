//! Commit records: one JSON file a shard, put last, that says all about it. Without its record a shard isn't there.

use super::error::CorpusError;
use super::paths::{COMMITS, ShardId, ShardStage, Table};
use super::sealed::{seal, unseal};
use super::store::Store;
use super::tables::{ClipRow, FaultRow, SkeletonRow};
use super::writer::FORMAT_VERSION;
use crate::synthesis::Made;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A file of a corpus, as it was written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FileRecord {
    /// Relative to the corpus, with `/`.
    pub path: String,
    /// Length.
    pub bytes: u64,
    /// Digest, 64 hexadecimal digits.
    pub blake3: String,
    /// Rows of the table.
    pub rows: u64,
}

/// A file that was read to make a shard.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct InputFile {
    /// Label of the source.
    pub source: String,
    /// Name of the clip.
    pub name: String,
    /// Its number.
    pub clip_id: u32,
    /// Digest of the file.
    pub blake3: String,
    /// Digest of the ASF that goes with an AMC.
    pub skeleton_blake3: Option<String>,
}

/// Keys of a shard's stages: digests of (inputs, configuration values read, version of the algorithm). Empty: the
/// stage has to be made.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageKeys {
    /// Of channels, poses and provenance.
    pub ingest: String,
    /// Of features.
    pub features: String,
    /// Of annotations, plants, segments and the labels of the clip rows.
    pub labels: String,
}

/// All about a shard: put atomically after its files, and read back in place of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShardRecord {
    /// [`FORMAT_VERSION`] of the program that wrote it.
    pub format_version: u32,
    /// Its name.
    pub shard: ShardId,
    /// Shards whose clips this one holds now; they count as gone as soon as this record is there.
    pub replaces: Vec<ShardId>,
    /// Keys of its stages.
    pub keys: StageKeys,
    /// What was read, by clip_id.
    pub inputs: Vec<InputFile>,
    /// Its files, by path; set by the commit.
    pub files: Vec<FileRecord>,
    /// Rows of `clips`, by clip_id; quarantined clips have none.
    pub clips: Vec<ClipRow>,
    /// Skeletons of its clips, by id, then by the clip that each was taken from: offsets that frames replace, and ends, may
    /// differ within one id.
    pub skeletons: Vec<SkeletonRow>,
    /// Clips whose body is not the first row of their skeleton, by clip_id: the `first_clip` of the row that it is.
    #[serde(default)]
    pub bodies: BTreeMap<u32, [String; 2]>,
    /// Rows of `faults`, in the order of the clips.
    pub faults: Vec<FaultRow>,
    /// Rows of `made`, in the order of the recipes; rejected ones too.
    pub made: Vec<Made>,
}

impl StageKeys {
    /// The key of a stage.
    pub fn get(&self, stage: ShardStage) -> &str {
        match stage {
            ShardStage::Ingest => &self.ingest,
            ShardStage::Features => &self.features,
            ShardStage::Labels => &self.labels,
        }
    }

    /// Gives a stage a key; empty: it has to be made.
    pub fn set(&mut self, stage: ShardStage, key: impl Into<String>) {
        let place = match stage {
            ShardStage::Ingest => &mut self.ingest,
            ShardStage::Features => &mut self.features,
            ShardStage::Labels => &mut self.labels,
        };
        *place = key.into();
    }
}

impl ShardRecord {
    /// The record of a shard without clips.
    pub fn new(shard: ShardId) -> ShardRecord {
        ShardRecord {
            format_version: FORMAT_VERSION,
            shard,
            replaces: Vec::new(),
            keys: StageKeys::default(),
            inputs: Vec::new(),
            files: Vec::new(),
            clips: Vec::new(),
            skeletons: Vec::new(),
            bodies: BTreeMap::new(),
            faults: Vec::new(),
            made: Vec::new(),
        }
    }

    /// Whether its clips can be read; false while they are being made anew.
    pub fn is_whole(&self) -> bool {
        !self.keys.ingest.is_empty()
    }

    /// Empties the keys of stages that a file of is not there any more, or was cut, so that they are made anew.
    pub fn forget_lost(&mut self, store: &Store) {
        for file in self.files.iter().filter(|file| !store.holds(&file.path, file.bytes)) {
            if let Some(table) = Table::of_file(&file.path) {
                self.keys.set(table.stage(), "");
            }
        }
    }

    /// The file of a table, if the table was made.
    pub fn file(&self, table: Table, layout: &str) -> Option<&FileRecord> {
        let path = self.shard.file(table, layout);
        self.files.iter().find(|file| file.path == path)
    }

    /// The row of a clip.
    pub fn clip(&self, clip_id: u32) -> Option<&ClipRow> {
        self.clips.iter().find(|row| row.clip_id == clip_id)
    }

    /// The skeleton of a clip, as the clip had it.
    pub fn skeleton_of(&self, clip: &ClipRow) -> Option<&SkeletonRow> {
        match self.bodies.get(&clip.clip_id) {
            Some(first) => {
                self.skeletons.iter().find(|row| row.first_clip == *first && row.skeleton_id == clip.skeleton)
            }
            None => self.skeleton(&clip.skeleton),
        }
    }

    /// The first skeleton of that id.
    pub fn skeleton(&self, skeleton: &str) -> Option<&SkeletonRow> {
        self.skeletons.iter().find(|row| row.skeleton_id == skeleton)
    }

    /// What keeps it from being read back as it is, if anything.
    pub(super) fn refuse(&self, store: &Store) -> Result<(), String> {
        if !self.clips.is_sorted_by(|a, b| a.clip_id < b.clip_id) {
            return Err("clips out of order".to_owned());
        }
        for clip in &self.clips {
            match self.skeleton_of(clip) {
                None => return Err(format!("clip {} without its skeleton {}", clip.clip_id, clip.skeleton)),
                Some(row) if row.body.layout_id() != clip.layout => {
                    return Err(format!("clip {} is of layout {}, its skeleton is not", clip.clip_id, clip.layout));
                }
                Some(_) => {}
            }
        }
        let path = store.path(&self.shard.record_file());
        let back = seal(self, &path).and_then(|bytes| unseal::<ShardRecord>(&bytes, &path));
        // JSON has no word for a number that isn't finite, and nothing else is lost on the way.
        match back.is_ok_and(|back| &back == self) {
            true => Ok(()),
            false => Err("a number that isn't finite".to_owned()),
        }
    }

    pub(super) fn put(&self, store: &Store) -> Result<(), CorpusError> {
        let name = self.shard.record_file();
        store.put_atomic(&name, &seal(self, &store.path(&name))?)
    }
}

/// The record of a shard; None: there is no such shard, whatever files lie about.
///
/// # Errors
/// [`CorpusError::Damaged`], [`CorpusError::Version`], and the file system's refusals.
pub fn read_record(store: &Store, shard: ShardId) -> Result<Option<ShardRecord>, CorpusError> {
    let name = shard.record_file();
    let Some(bytes) = store.read(&name)? else { return Ok(None) };
    let path = store.path(&name);
    let record: ShardRecord = unseal(&bytes, &path).map_err(|error| version_error(&bytes, &path, error))?;
    check_version(record.format_version, &path)?;
    let foreign = |file: &&FileRecord| ShardId::of_file(&file.path) != Some(shard) || !Store::is_inside(&file.path);
    if record.shard != shard {
        return Err(CorpusError::damaged(&path, format!("it is the record of {}", record.shard)));
    }
    match record.files.iter().find(foreign) {
        None => Ok(Some(record)),
        Some(file) => Err(CorpusError::damaged(&path, format!("it names `{}`, which is no file of it", file.path))),
    }
}

/// The records of all shards, captured ones first, by number; without those that another one replaces.
///
/// # Errors
/// As [`read_record`].
pub fn read_records(store: &Store) -> Result<Vec<ShardRecord>, CorpusError> {
    let mut records = Vec::new();
    for shard in shards_with_records(store)? {
        records.extend(read_record(store, shard)?);
    }
    let replaced: Vec<ShardId> =
        records.iter().filter(|record| record.is_whole()).flat_map(|record| record.replaces.clone()).collect();
    records.retain(|record| !replaced.contains(&record.shard));
    Ok(records)
}

/// Names of all shards that have a record, in order.
pub(super) fn shards_with_records(store: &Store) -> Result<Vec<ShardId>, CorpusError> {
    let mut shards: Vec<ShardId> = store.list(COMMITS)?.iter().filter_map(|name| ShardId::of_file(name)).collect();
    shards.sort();
    Ok(shards)
}

pub(super) fn check_version(found: u32, path: &Path) -> Result<(), CorpusError> {
    match found == FORMAT_VERSION {
        true => Ok(()),
        false => Err(CorpusError::Version { path: path.to_owned(), found, known: FORMAT_VERSION }),
    }
}

/// The error for a file that can't be read: its version, where that is the reason.
pub(super) fn version_error(bytes: &[u8], path: &Path, error: CorpusError) -> CorpusError {
    #[derive(Deserialize)]
    struct Versioned {
        format_version: u32,
    }
    let versioned = unseal::<Versioned>(bytes, path);
    versioned.ok().and_then(|versioned| check_version(versioned.format_version, path).err()).unwrap_or(error)
}
