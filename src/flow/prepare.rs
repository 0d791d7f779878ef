//! What has to be done: inputs beside the manifest, shards beside their keys (DESIGN 4). Process 0 only.
//!
//! Numbers are given out here, from the sorted list of new inputs, before anything is parsed, and put into the manifest
//! before any work: a run that is killed finds the same shards again.

use super::jobs::{Jobs, Wanted};
use super::run::RunError;
use super::work::ShardJob;
use crate::corpus::{
    ClipEntry, ClipState, FaultRow, Manifest, ShardId, ShardKind, ShardRecord, Store, read_records, remove_shard,
};
use crate::inputs::{Difference, Found, Input, InputHash, Keyed, cut_shards, find_inputs, hash_inputs};
use crate::plan::config::ShardSettings;
use crate::plan::{ClipFacts, Plan, Stage};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Below this a shard costs more in files than it gains in balance.
const LEAST_TEXT_BYTES: u64 = 1 << 20;

/// The work of the first dataflow, and what is to be said of the inputs.
#[derive(Debug, Default)]
pub(crate) struct Prepared {
    /// Largest text first.
    pub(crate) shards: Vec<ShardJob>,
    /// Faults of inputs that no shard can hold: no skeleton, unreadable.
    pub(crate) faults: Vec<FaultRow>,
    /// `source/name` of clips whose files have gone.
    pub(crate) gone: Vec<String>,
    /// Sources that none of the known clips of is as it was: most likely another folder of that name was meant.
    pub(crate) replaced: Vec<String>,
    /// Clips that were in the corpus already and need nothing.
    pub(crate) finished: usize,
    /// Clips to be read.
    pub(crate) to_read: usize,
    /// Clips found.
    pub(crate) found: usize,
    /// Bytes found.
    pub(crate) bytes: u64,
}

/// A clip that the manifest doesn't know yet.
pub(super) struct NewClip {
    pub(super) source: String,
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) blake3: String,
    pub(super) skeleton_blake3: Option<String>,
    /// [`InputHash::key`].
    pub(super) key: String,
}

/// Compares inputs, manifest and shards; updates the manifest and puts it.
pub(crate) fn prepare(
    plan: &Plan,
    inputs: &[PathBuf],
    procedural: bool,
    prune: bool,
    store: &Store,
    manifest: &mut Manifest,
) -> Result<Prepared, RunError> {
    let mut found =
        find_inputs(inputs, &plan.config.input_rules(), plan.config.limits.max_clip_bytes).map_err(RunError::Inputs)?;
    let filter = plan.filter(Stage::Ingest);
    found.inputs.retain(|input| {
        filter.lets_through(&ClipFacts {
            source: &input.source,
            name: &input.name,
            format: Some(input.kind),
            ..ClipFacts::default()
        })
    });
    let hashes = hash_inputs(&found.inputs);
    let mut prepared = Prepared {
        found: found.inputs.len(),
        bytes: found.inputs.iter().map(|input| input.bytes).sum(),
        ..Prepared::default()
    };
    prepared.faults = found
        .notices
        .iter()
        .map(|notice| FaultRow {
            source: notice.source.clone(),
            name: notice.name.clone(),
            notice: notice.notice.clone(),
        })
        .collect();
    let mut readable: Vec<(Input, InputHash)> = Vec::new();
    for (input, hash) in found.inputs.drain(..).zip(hashes) {
        match hash {
            Ok(hash) => readable.push((input, hash)),
            Err(notice) => prepared.faults.push(FaultRow { source: input.source, name: input.name, notice }),
        }
    }
    if manifest.next_clip_id == 0 && readable.is_empty() {
        return Err(RunError::NothingToRead { faults: prepared.faults.len() });
    }
    enter(&readable, &found, &plan.config.shards, prune, manifest, &mut prepared);
    manifest.put(store)?;
    let mut records = read_records(store)?;
    records.iter_mut().for_each(|record| record.forget_lost(store));
    remove_empty_shards(store, manifest, &records)?;
    let found = readable.iter().map(|(input, _)| ((input.source.as_str(), input.name.as_str()), input)).collect();
    let wanted = Wanted { plan, keys: plan.keys(), procedural, manifest, records: &records, found, stored: None };
    let Jobs { shards, to_read, finished } = wanted.jobs();
    Ok(Prepared { shards, to_read, finished, ..prepared })
}

/// Gives new clips their numbers and shards, moves the shards of changed clips to new numbers, and notes what has gone.
fn enter(
    readable: &[(Input, InputHash)],
    found: &Found,
    shards: &ShardSettings,
    prune: bool,
    manifest: &mut Manifest,
    prepared: &mut Prepared,
) {
    let keyed: Vec<Keyed> = readable
        .iter()
        .map(|(input, hash)| Keyed {
            source: input.source.clone(),
            name: input.name.clone(),
            key: digest_of(&hash.file, hash.asf.as_deref()),
        })
        .collect();
    let known: Vec<Keyed> = manifest
        .sources
        .iter()
        .flat_map(|(source, entry)| entry.clips.iter().map(move |(name, clip)| (source, name, clip)))
        .map(|(source, name, clip)| Keyed {
            source: source.clone(),
            name: name.clone(),
            key: digest_of(&clip.blake3, clip.skeleton_blake3.as_deref()),
        })
        .collect();
    let difference = found.difference(&keyed, &known);
    prepared.replaced = replaced_sources(&known, &keyed, &difference);
    let mut moved = BTreeSet::new();
    for &index in &difference.changed {
        let (input, hash) = &readable[index];
        if let Some(clip) = manifest.sources.get_mut(&input.source).and_then(|source| source.clips.get_mut(&input.name))
        {
            clip.blake3 = hash.file.clone();
            clip.skeleton_blake3 = hash.asf.clone();
            clip.bytes = input.bytes;
            clip.state = ClipState::Present;
            moved.insert(clip.shard);
        }
    }
    for &index in &difference.gone {
        let Keyed { source, name, .. } = &known[index];
        prepared.gone.push(format!("{source}/{name}"));
        let Some(entry) = manifest.sources.get_mut(source) else { continue };
        if prune {
            if let Some(clip) = entry.clips.remove(name) {
                moved.insert(clip.shard);
            }
        } else if let Some(clip) = entry.clips.get_mut(name) {
            clip.state = ClipState::Gone;
        }
    }
    for &index in &difference.unchanged {
        let (input, _) = &readable[index];
        if let Some(clip) = manifest.sources.get_mut(&input.source).and_then(|source| source.clips.get_mut(&input.name))
            && clip.state == ClipState::Gone
        {
            clip.state = ClipState::Present;
        }
    }
    for (input, hash) in readable {
        let known = manifest.sources.get_mut(&input.source).and_then(|source| source.clips.get_mut(&input.name));
        if let Some(clip) = known {
            clip.key = hash.key(&input.settings);
        }
    }
    // A shard that lost or changed a clip is rewritten under a new number.
    for old in moved {
        let new = ShardId::captured(manifest.next_shard);
        manifest.next_shard += 1;
        for clip in
            manifest.sources.values_mut().flat_map(|source| source.clips.values_mut()).filter(|clip| clip.shard == old)
        {
            clip.shard = new;
        }
    }
    let new = difference.new.iter().map(|&index| NewClip::of(&readable[index].0, &readable[index].1));
    give_numbers(&new.collect::<Vec<_>>(), shards, manifest);
}

/// Sources whose known clips have all changed or gone.
fn replaced_sources(known: &[Keyed], found: &[Keyed], difference: &Difference) -> Vec<String> {
    let same: BTreeSet<&str> = difference.unchanged.iter().map(|&index| found[index].source.as_str()).collect();
    let other = difference.changed.iter().map(|&index| found[index].source.as_str());
    let gone = difference.gone.iter().map(|&index| known[index].source.as_str());
    let other: BTreeSet<&str> = other.chain(gone).filter(|source| !same.contains(source)).collect();
    other.into_iter().map(str::to_owned).collect()
}

impl NewClip {
    fn of(input: &Input, hash: &InputHash) -> NewClip {
        NewClip {
            source: input.source.clone(),
            name: input.name.clone(),
            bytes: input.bytes,
            blake3: hash.file.clone(),
            skeleton_blake3: hash.asf.clone(),
            key: hash.key(&input.settings),
        }
    }
}

/// Gives clips, sorted by (source, name), the next numbers, and cuts them into shards.
pub(super) fn give_numbers(clips: &[NewClip], shards: &ShardSettings, manifest: &mut Manifest) {
    debug_assert!(clips.is_sorted_by_key(|clip| (&clip.source, &clip.name)), "numbers follow the sorted list");
    // A small corpus is cut finer, so that every worker gets some of it. Depends on the inputs only.
    let all_bytes: u64 = clips.iter().map(|clip| clip.bytes).sum();
    let text_bytes = shards.text_bytes.min((all_bytes / shards.min_count).max(LEAST_TEXT_BYTES));
    for shard in cut_shards(clips.iter().map(|clip| clip.bytes), text_bytes) {
        let id = ShardId::captured(manifest.next_shard);
        manifest.next_shard += 1;
        for clip in &clips[shard.clips] {
            let entry = ClipEntry {
                clip_id: manifest.next_clip_id,
                blake3: clip.blake3.clone(),
                skeleton_blake3: clip.skeleton_blake3.clone(),
                key: clip.key.clone(),
                bytes: clip.bytes,
                state: ClipState::Present,
                shard: id,
            };
            manifest.next_clip_id += 1;
            manifest.sources.entry(clip.source.clone()).or_default().clips.insert(clip.name.clone(), entry);
        }
    }
}

/// Records of captured shards that the manifest doesn't list any more.
pub(super) fn unlisted<'a, T>(
    listed: &'a BTreeMap<ShardId, T>,
    records: &'a [ShardRecord],
) -> impl Iterator<Item = &'a ShardRecord> {
    records.iter().filter(|record| record.shard.kind == ShardKind::Captured && !listed.contains_key(&record.shard))
}

/// Removes the shards whose clips have all been pruned.
fn remove_empty_shards(store: &Store, manifest: &Manifest, records: &[ShardRecord]) -> Result<(), RunError> {
    let ids: BTreeSet<u32> =
        manifest.sources.values().flat_map(|source| source.clips.values()).map(|clip| clip.clip_id).collect();
    let listed: BTreeMap<ShardId, ()> =
        manifest.sources.values().flat_map(|source| source.clips.values()).map(|clip| (clip.shard, ())).collect();
    for record in unlisted(&listed, records) {
        if !record.inputs.iter().any(|input| ids.contains(&input.clip_id)) {
            remove_shard(store, record)?;
        }
    }
    Ok(())
}

/// Notes in the manifest which clips the shards have no row for.
pub(crate) fn note_quarantined(manifest: &mut Manifest, records: &[ShardRecord]) {
    let mut rows = BTreeSet::new();
    let mut read = BTreeSet::new();
    for record in records.iter().filter(|record| record.shard.kind == ShardKind::Captured) {
        rows.extend(record.clips.iter().map(|row| row.clip_id));
        read.extend(record.inputs.iter().map(|input| input.clip_id));
    }
    for clip in manifest.sources.values_mut().flat_map(|source| source.clips.values_mut()) {
        if read.contains(&clip.clip_id) && clip.state != ClipState::Gone {
            clip.state = if rows.contains(&clip.clip_id) { ClipState::Present } else { ClipState::Quarantined };
        }
    }
}

pub(super) fn digest_of(file: &str, asf: Option<&str>) -> String {
    format!("{file}/{}", asf.unwrap_or(""))
}
