//! Folding the commit records into the tables over all shards: clips, skeletons, faults.

use super::error::CorpusError;
use super::manifest::{ClipState, Manifest};
use super::read::Catalog;
use super::record::FileRecord;
use super::store::Store;
use super::tables::{ClipRow, FaultRow, SkeletonRow};
use super::whole::{write_clips, write_faults, write_skeletons};
use super::writer::FileNotes;
use crate::motion::Severity;
use std::collections::{BTreeMap, BTreeSet};

/// Rows of `faults` that one kind of one clip may have; its `count` says how many there were.
pub const FAULT_ROWS_A_KIND: usize = 20;

/// `source/name` of all that was to be a clip and is none: quarantined in a shard, or left out before it came to one, such as
/// an AMC without its skeleton.
pub fn left_out(manifest: &Manifest, faults: &[FaultRow]) -> BTreeSet<String> {
    let known = |row: &FaultRow| {
        manifest.sources.get(&row.source).and_then(|source| source.clips.get(&row.name)).map(|clip| clip.state)
    };
    // What is said of a folder has a name that ends in `/`.
    let faults = faults.iter().filter(|row| row.notice.severity == Severity::Fault && !row.name.ends_with('/'));
    let without_clip = faults.filter(|row| known(row).is_none_or(|state| state == ClipState::Quarantined));
    without_clip.map(|row| format!("{}/{}", row.source, row.name)).collect()
}

/// The rows of all shards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Folded {
    /// By clip_id.
    pub clips: Vec<ClipRow>,
    /// By id.
    pub skeletons: Vec<SkeletonRow>,
    /// By source and name, then as the reader had them.
    pub faults: Vec<FaultRow>,
}

impl Folded {
    /// Gathers the rows of all shards; `more_faults` are those that belong to no shard.
    pub fn gather(catalog: &Catalog, more_faults: &[FaultRow]) -> Folded {
        let clips = catalog.clips().cloned().collect();
        let mut skeletons: BTreeMap<&str, &SkeletonRow> = BTreeMap::new();
        for row in catalog.records().iter().flat_map(|record| &record.skeletons) {
            let kept = skeletons.entry(&row.skeleton_id).or_insert(row);
            if row.first_clip < kept.first_clip {
                *kept = row;
            }
        }
        let mut faults: Vec<FaultRow> =
            catalog.records().iter().flat_map(|record| &record.faults).chain(more_faults).cloned().collect();
        faults.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
        let mut seen: BTreeMap<(String, String, String), usize> = BTreeMap::new();
        faults.retain(|row| {
            let rows = seen.entry((row.source.clone(), row.name.clone(), row.notice.kind.clone())).or_default();
            *rows += 1;
            *rows <= FAULT_ROWS_A_KIND
        });
        Folded { clips, skeletons: skeletons.into_values().cloned().collect(), faults }
    }

    /// Writes the three tables; the manifest is to note what comes back, and to be put after them.
    ///
    /// # Errors
    /// The file system's refusals. A table is then as it was, or new; folding again puts it right.
    pub fn write(&self, store: &Store, notes: &FileNotes) -> Result<Vec<FileRecord>, CorpusError> {
        Ok(vec![
            write_clips(store, &self.clips, notes)?,
            write_skeletons(store, &self.skeletons, notes)?,
            write_faults(store, &self.faults, notes)?,
        ])
    }
}
