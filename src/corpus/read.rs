//! Reading the clips of a corpus: by id, or shard by shard.

use super::error::CorpusError;
use super::paths::Table;
use super::reader::{Gather, TableFile};
use super::record::{ShardRecord, read_records};
use super::store::Store;
use super::tables::{
    ClipRow, GatherChannels, GatherFeatures, GatherLabels, GatherPlants, GatherPoses, GatherProvenance, GatherSegments,
    SkeletonRow, pose_layout,
};
use super::unchanged::Unchanged;
use crate::annotate::{Features, FrameLabels, Plant, Segment};
use crate::motion::{Clip, Poses};
use crate::synthesis::ProvenanceRow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Which shard every clip is in. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Catalog {
    store: Store,
    records: Arc<Vec<ShardRecord>>,
    shard_of_clip: Arc<BTreeMap<u32, usize>>,
    unchanged: Unchanged,
}

/// One shard, open for reading; every call opens the file it needs.
#[derive(Clone, Debug)]
pub struct ShardReader<'a> {
    store: &'a Store,
    record: &'a ShardRecord,
    unchanged: Unchanged,
}

impl Catalog {
    /// Reads all commit records; shards that are being made anew count as not there.
    ///
    /// # Errors
    /// As [`read_records`]; [`CorpusError::Damaged`] where two shards hold one clip.
    pub fn open(store: &Store) -> Result<Catalog, CorpusError> {
        let mut records = read_records(store)?;
        records.retain(ShardRecord::is_whole);
        let mut shard_of_clip = BTreeMap::new();
        for (at, record) in records.iter().enumerate() {
            for clip in &record.clips {
                if shard_of_clip.insert(clip.clip_id, at).is_some() {
                    let path = store.path(&record.shard.record_file());
                    return Err(CorpusError::damaged(&path, format!("clip {} is in two shards", clip.clip_id)));
                }
            }
        }
        let (records, shard_of_clip) = (Arc::new(records), Arc::new(shard_of_clip));
        Ok(Catalog { store: store.clone(), records, shard_of_clip, unchanged: Unchanged::default() })
    }

    /// All records, captured shards first, by number.
    pub fn records(&self) -> &[ShardRecord] {
        &self.records
    }

    /// All clips, by clip_id.
    pub fn clips(&self) -> impl Iterator<Item = &ClipRow> {
        self.shard_of_clip.iter().filter_map(|(&clip_id, &at)| self.records[at].clip(clip_id))
    }

    /// All shards, in the order of their records.
    pub fn shards(&self) -> impl Iterator<Item = ShardReader<'_>> {
        self.records.iter().map(|record| self.reader(record))
    }

    /// The shard of a clip.
    ///
    /// # Errors
    /// [`CorpusError::NotThere`].
    pub fn shard_of(&self, clip_id: u32) -> Result<ShardReader<'_>, CorpusError> {
        match self.shard_of_clip.get(&clip_id) {
            Some(&at) => Ok(self.reader(&self.records[at])),
            None => Err(CorpusError::NotThere { what: format!("clip {clip_id}") }),
        }
    }

    fn reader<'a>(&'a self, record: &'a ShardRecord) -> ShardReader<'a> {
        ShardReader { store: &self.store, record, unchanged: self.unchanged.clone() }
    }
}

impl<'a> ShardReader<'a> {
    /// The shard of a record.
    pub fn new(store: &'a Store, record: &'a ShardRecord) -> ShardReader<'a> {
        ShardReader { store, record, unchanged: Unchanged::default() }
    }

    /// Its record.
    pub fn record(&self) -> &'a ShardRecord {
        self.record
    }

    /// The row of a clip.
    ///
    /// # Errors
    /// [`CorpusError::NotThere`].
    pub fn row(&self, clip_id: u32) -> Result<&'a ClipRow, CorpusError> {
        let row = self.record.clip(clip_id);
        row.ok_or_else(|| CorpusError::NotThere { what: format!("clip {clip_id} in {}", self.record.shard) })
    }

    /// The skeleton of a clip, with its own offsets and ends.
    ///
    /// # Errors
    /// [`CorpusError::NotThere`].
    pub fn skeleton(&self, clip_id: u32) -> Result<&'a SkeletonRow, CorpusError> {
        let clip = self.row(clip_id)?;
        let row = self.record.skeleton_of(clip);
        row.ok_or_else(|| CorpusError::NotThere { what: format!("skeleton {}", clip.skeleton) })
    }

    /// A clip's channels, `[frame][channel]`, file units, as they were written.
    ///
    /// # Errors
    /// [`CorpusError::NotThere`] and [`CorpusError::Damaged`], here and below.
    pub fn channels(&self, clip_id: u32) -> Result<Vec<f32>, CorpusError> {
        let body = &self.skeleton(clip_id)?.body;
        let values = self.clip::<GatherChannels>(Table::Channels, &self.row(clip_id)?.layout, clip_id)?;
        self.check_count(clip_id, Table::Channels, values.len(), body.n_channels())?;
        Ok(values)
    }

    /// A clip as motion: its channels, skeleton, rate and unit.
    pub fn motion(&self, clip_id: u32) -> Result<Clip, CorpusError> {
        let row = self.row(clip_id)?;
        Ok(Clip {
            skeleton: Arc::new(self.skeleton(clip_id)?.body.clone()),
            rate_hz: row.rate_hz,
            unit_m: row.unit_m,
            up: row.up_axis,
            n_frames: row.frames as usize,
            channels: self.channels(clip_id)?,
        })
    }

    /// A clip's world positions, as f32 had them.
    pub fn poses(&self, clip_id: u32) -> Result<Poses, CorpusError> {
        let body = &self.skeleton(clip_id)?.body;
        let poses = self.clip::<GatherPoses>(Table::Poses, &pose_layout(body), clip_id)?;
        let n_points = body.joints.len() + body.ends().len();
        self.check_count(clip_id, Table::Poses, poses.world.len(), n_points)?;
        Ok(Poses { n_points, ..poses })
    }

    /// A clip's labels; None: it has no hips.
    pub fn labels(&self, clip_id: u32) -> Result<Option<FrameLabels>, CorpusError> {
        let labels = self.clip::<GatherLabels>(Table::Annotations, "", clip_id)?;
        if let Some(labels) = &labels {
            self.check_count(clip_id, Table::Annotations, labels.time_s.len(), 1)?;
        }
        Ok(labels)
    }

    /// A clip's features, empty where an effector is missing. The feet are called toes; where the body has none they
    /// are its ankles.
    pub fn features(&self, clip_id: u32) -> Result<Features, CorpusError> {
        let features = self.clip::<GatherFeatures>(Table::Features, "", clip_id)?;
        if !features.effectors.is_empty() {
            self.check_count(clip_id, Table::Features, features.values.len(), 9 * features.effectors.len())?;
        }
        Ok(features)
    }

    /// A clip's plants, in the order written.
    pub fn plants(&self, clip_id: u32) -> Result<Vec<Plant>, CorpusError> {
        self.clip::<GatherPlants>(Table::Plants, "", clip_id)
    }

    /// A clip's segments, in the order written.
    pub fn segments(&self, clip_id: u32) -> Result<Vec<Segment>, CorpusError> {
        self.clip::<GatherSegments>(Table::Segments, "", clip_id)
    }

    /// A made clip's provenance, by frame.
    pub fn provenance(&self, clip_id: u32) -> Result<Vec<ProvenanceRow>, CorpusError> {
        self.clip::<GatherProvenance>(Table::Provenance, "", clip_id)
    }

    /// Features of all clips that have some, by clip_id; one clip is held at a time.
    pub fn all_features(
        &self,
    ) -> Result<impl Iterator<Item = Result<(u32, Features), CorpusError>> + Send + use<>, CorpusError> {
        self.open(Table::Features, "")?.clips::<GatherFeatures>()
    }

    /// Labels of all clips that have some, by clip_id; one clip is held at a time.
    pub fn all_labels(
        &self,
    ) -> Result<impl Iterator<Item = Result<(u32, FrameLabels), CorpusError>> + Send + use<>, CorpusError> {
        let clips = self.open(Table::Annotations, "")?.clips::<GatherLabels>()?;
        Ok(clips.filter_map(|clip| clip.map(|(id, labels)| labels.map(|labels| (id, labels))).transpose()))
    }

    /// Channels of all clips of a layout, by clip_id; one clip is held at a time.
    pub fn all_channels(
        &self,
        layout: &str,
    ) -> Result<impl Iterator<Item = Result<(u32, Vec<f32>), CorpusError>> + Send + use<>, CorpusError> {
        self.open(Table::Channels, layout)?.clips::<GatherChannels>()
    }

    /// File metadata of a table: detectors, constants, weights, format version.
    pub fn notes(&self, table: Table, layout: &str) -> Result<BTreeMap<String, String>, CorpusError> {
        Ok(self.open(table, layout)?.notes())
    }

    fn clip<G: Gather>(&self, table: Table, layout: &str, clip_id: u32) -> Result<G::Clip, CorpusError> {
        self.row(clip_id)?;
        self.open(table, layout)?.clip::<G>(clip_id)
    }

    fn open(&self, table: Table, layout: &str) -> Result<TableFile, CorpusError> {
        match self.record.file(table, layout) {
            Some(file) => TableFile::open(self.store, &file.path, Some((file, &self.unchanged))),
            None => Err(CorpusError::NotThere { what: format!("{} of {}", table.name(), self.record.shard) }),
        }
    }

    fn check_count(&self, clip_id: u32, table: Table, found: usize, width: usize) -> Result<(), CorpusError> {
        let frames = self.row(clip_id)?.frames as usize;
        match found == frames * width {
            true => Ok(()),
            false => {
                let path = self.store.path(&self.record.shard.record_file());
                let what = format!("clip {clip_id} has {frames} frames, {} has {found} values", table.name());
                Err(CorpusError::damaged(&path, what))
            }
        }
    }
}
