//! What has to be done: inputs beside the manifest, shards beside their keys (DESIGN 4). Process 0 only.
//!
//! Numbers are given out here, from the sorted list of new inputs, before anything is parsed, and put into the manifest
//! before any work: a run that is killed finds the same shards again.

use super::run::RunError;
use super::work::{ClipJob, ClipOrigin, FileJob, KeptJob, ShardJob, Todo};
use crate::corpus::{
    ClipEntry, ClipState, FaultRow, Manifest, ShardId, ShardKind, ShardRecord, StageKeys, Store, read_records,
    remove_shard,
};
use crate::inputs::{Found, Input, InputHash, Keyed, cut_shards, find_inputs, hash_inputs};
use crate::plan::{ClipFacts, Plan, PlanKeys, Stage, shard_key};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// A corpus is cut into about so many shards at least, unless they would hold less than [`LEAST_TEXT_BYTES`].
const SHARDS_AT_LEAST: u64 = 16;
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
    /// Clips that were in the corpus already and need nothing.
    pub(crate) finished: usize,
    /// Clips to be read.
    pub(crate) to_read: usize,
    /// Clips found.
    pub(crate) found: usize,
    /// Bytes found.
    pub(crate) bytes: u64,
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
    enter(&readable, &found, plan.config.shards.text_bytes, prune, manifest, &mut prepared);
    manifest.put(store)?;
    let mut records = read_records(store)?;
    records.iter_mut().for_each(|record| record.forget_lost(store));
    remove_empty_shards(store, manifest, &records)?;
    let keys = plan.keys();
    prepared.shards =
        jobs(&readable, plan, &keys, procedural, manifest, &records, &mut prepared.to_read, &mut prepared.finished);
    Ok(prepared)
}

/// Gives new clips their numbers and shards, moves the shards of changed clips to new numbers, and notes what has gone.
fn enter(
    readable: &[(Input, InputHash)],
    found: &Found,
    text_bytes: u64,
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
    let mut moved = BTreeSet::new();
    for &index in &difference.changed {
        let (input, hash) = &readable[index];
        if let Some(clip) = manifest.sources.get_mut(&input.source).and_then(|source| source.clips.get_mut(&input.name))
        {
            clip.blake3 = hash.file.clone();
            clip.skeleton_blake3 = hash.asf.clone();
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
    let new: Vec<&(Input, InputHash)> = difference.new.iter().map(|&index| &readable[index]).collect();
    let new_inputs: Vec<Input> = new.iter().map(|(input, _)| input.clone()).collect();
    // A small corpus is cut finer, so that every worker gets some of it. Depends on the inputs only.
    let all_bytes: u64 = new_inputs.iter().map(|input| input.bytes).sum();
    let text_bytes = text_bytes.min((all_bytes / SHARDS_AT_LEAST).max(LEAST_TEXT_BYTES));
    for shard in cut_shards(&new_inputs, text_bytes) {
        let id = ShardId::captured(manifest.next_shard);
        manifest.next_shard += 1;
        for (input, hash) in &new[shard.clips] {
            let clip = ClipEntry {
                clip_id: manifest.next_clip_id,
                blake3: hash.file.clone(),
                skeleton_blake3: hash.asf.clone(),
                state: ClipState::Present,
                shard: id,
            };
            manifest.next_clip_id += 1;
            manifest.sources.entry(input.source.clone()).or_default().clips.insert(input.name.clone(), clip);
        }
    }
}

/// The shards that have something to be done.
#[expect(clippy::too_many_arguments, reason = "the two last are counters of one report")]
fn jobs(
    readable: &[(Input, InputHash)],
    plan: &Plan,
    keys: &PlanKeys,
    procedural: bool,
    manifest: &Manifest,
    records: &[ShardRecord],
    to_read: &mut usize,
    finished: &mut usize,
) -> Vec<ShardJob> {
    let found: BTreeMap<(&str, &str), &(Input, InputHash)> =
        readable.iter().map(|pair| ((pair.0.source.as_str(), pair.0.name.as_str()), pair)).collect();
    let records_of: BTreeMap<ShardId, &ShardRecord> = records.iter().map(|record| (record.shard, record)).collect();
    let mut shards = BTreeMap::<ShardId, Vec<(&str, &str, &ClipEntry)>>::new();
    for (source, entry) in &manifest.sources {
        for (name, clip) in &entry.clips {
            shards.entry(clip.shard).or_default().push((source, name, clip));
        }
    }
    let replaced = replaced_shards(&shards, records);
    let mut jobs: Vec<(u64, ShardJob)> = Vec::new();
    for (shard, mut clips) in shards {
        clips.sort_by_key(|(.., clip)| clip.clip_id);
        let clip_keys: Vec<String> = clips
            .iter()
            .map(|(source, name, clip)| {
                let said = found.get(&(*source, *name)).map(|(input, hash)| hash.key(&input.settings));
                format!(
                    "{}:{}",
                    clip.clip_id,
                    said.unwrap_or_else(|| digest_of(&clip.blake3, clip.skeleton_blake3.as_deref()))
                )
            })
            .collect();
        let record = records_of.get(&shard).copied();
        let all_there = clips.iter().all(|(source, name, _)| found.contains_key(&(*source, *name)));
        // What a clip whose file is not there was read with can't be told: its shard counts as read as it should be.
        let ingest = match record {
            Some(record) if !all_there && record.is_whole() => record.keys.ingest.clone(),
            _ => shard_key(&keys.ingest, &clip_keys),
        };
        let rests_on = [ingest.clone()];
        let wanted = StageKeys {
            ingest,
            features: if plan.has(Stage::Features) { shard_key(&keys.features, &rests_on) } else { String::new() },
            labels: if plan.has(Stage::Contacts) { shard_key(&keys.labels, &rests_on) } else { String::new() },
        };
        let has = |of: fn(&StageKeys) -> &String| {
            let want = of(&wanted);
            want.is_empty() || record.is_some_and(|record| of(&record.keys) == want)
        };
        // Without stored channels, or with no clip in the tables, there is nothing to make other tables from.
        let stored = plan.config.tables.channels && record.is_some_and(|record| !record.clips.is_empty());
        let todo = if !has(|keys| &keys.ingest) {
            Todo::Everything
        } else if has(|keys| &keys.features) && has(|keys| &keys.labels) {
            *finished += clips.len();
            continue;
        } else if stored {
            Todo::Again { features: !has(|keys| &keys.features), labels: !has(|keys| &keys.labels) }
        } else if all_there {
            Todo::Everything
        } else {
            *finished += clips.len();
            continue;
        };
        let kept = record.map(|record| record.keys.clone()).unwrap_or_default();
        let or_kept = |want: &str, kept: &str| if want.is_empty() { kept.to_owned() } else { want.to_owned() };
        let origin = |source: &str, name: &str, clip: &ClipEntry| match (todo, found.get(&(source, name))) {
            (Todo::Everything, Some((input, _))) => Some(ClipOrigin::File(Box::new(FileJob {
                path: input.path.clone(),
                asf: input.asf.clone(),
                blake3: clip.blake3.clone(),
                skeleton_blake3: clip.skeleton_blake3.clone(),
                settings: input.settings.clone(),
                procedural,
            }))),
            // Its file is not there, or not among this run's inputs: what the corpus has of it stays.
            (Todo::Everything, None) => kept_job(clip.clip_id, records).map(|kept| ClipOrigin::Kept(Box::new(kept))),
            _ => record.is_some_and(|record| record.clip(clip.clip_id).is_some()).then_some(ClipOrigin::Stored),
        };
        let job = ShardJob {
            shard,
            replaces: replaced.get(&shard).cloned().unwrap_or_default(),
            todo,
            keys: match todo {
                Todo::Everything | Todo::Samples { .. } => wanted.clone(),
                Todo::Again { .. } => StageKeys {
                    ingest: kept.ingest.clone(),
                    features: or_kept(&wanted.features, &kept.features),
                    labels: or_kept(&wanted.labels, &kept.labels),
                },
            },
            clips: clips
                .iter()
                .filter_map(|&(source, name, clip)| {
                    let origin = origin(source, name, clip)?;
                    Some(ClipJob { clip_id: clip.clip_id, source: source.to_owned(), name: name.to_owned(), origin })
                })
                .collect(),
        };
        let to_parse = job.clips.iter().filter(|clip| matches!(clip.origin, ClipOrigin::File(_))).count();
        if todo == Todo::Everything && to_parse == 0 {
            continue; // none of its files is there
        }
        *to_read += to_parse;
        let bytes = clips
            .iter()
            .filter_map(|(source, name, _)| found.get(&(*source, *name)))
            .map(|(input, _)| input.bytes)
            .sum();
        jobs.push((bytes, job));
    }
    jobs.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.shard.cmp(&b.1.shard)));
    jobs.into_iter().map(|(_, job)| job).collect()
}

/// What the corpus holds of a clip, to be taken over into another shard.
fn kept_job(clip_id: u32, records: &[ShardRecord]) -> Option<KeptJob> {
    let whole = records.iter().filter(|record| record.is_whole());
    whole.into_iter().find_map(|record| {
        let input = record.inputs.iter().find(|input| input.clip_id == clip_id)?;
        let of_it = |row: &&FaultRow| row.source == input.source && row.name == input.name;
        Some(KeptJob {
            row: record.clip(clip_id).cloned(),
            notices: record.faults.iter().filter(of_it).map(|row| row.notice.clone()).collect(),
            input: input.clone(),
        })
    })
}

/// Shards that the manifest doesn't list any more, by the shard that has their clips now.
fn replaced_shards(
    listed: &BTreeMap<ShardId, Vec<(&str, &str, &ClipEntry)>>,
    records: &[ShardRecord],
) -> BTreeMap<ShardId, Vec<ShardId>> {
    let shard_of: BTreeMap<u32, ShardId> =
        listed.iter().flat_map(|(&shard, clips)| clips.iter().map(move |(.., clip)| (clip.clip_id, shard))).collect();
    let mut replaced = BTreeMap::<ShardId, Vec<ShardId>>::new();
    for record in unlisted(listed, records) {
        if let Some(&new) = record.inputs.iter().find_map(|input| shard_of.get(&input.clip_id)) {
            replaced.entry(new).or_default().push(record.shard);
        }
    }
    replaced
}

fn unlisted<'a, T>(
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

fn digest_of(file: &str, asf: Option<&str>) -> String {
    format!("{file}/{}", asf.unwrap_or(""))
}
