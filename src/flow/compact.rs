//! Making a corpus as if from nothing again, out of what is stored in it (DESIGN 3, P2): a grown corpus has gaps in its
//! numbers and small shards; made anew it has the tables that one run over all inputs gives.
//!
//! It is a run like any other, by the plan of the last one, whose clips come from the old corpus instead of from files.
//! So it is interrupted and continued like any other, and the old corpus stays as it is until the new one is whole.

use super::gauges::Gauges;
use super::halt::HaltFlag;
use super::jobs::{Jobs, Wanted};
use super::prepare::{NewClip, Prepared, give_numbers};
use super::run::{RunError, RunReport, RunRequest, noted_plan, run};
use crate::corpus::{
    ClipState, CorpusError, FAULTS, Manifest, Replacement, Store, open_to_run, read_faults, read_records,
};
use crate::plan::Plan;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// Makes a corpus anew from what it holds, and puts the new one in its place.
///
/// # Errors
/// [`RunError`]; [`RunError::NoPlan`] for a corpus that doesn't say how it was made. The corpus is then as it was, and the
/// same request continues.
pub fn compact(
    corpus: &Path,
    workers: usize,
    gauges: &Arc<Gauges>,
    flag: &Arc<HaltFlag>,
) -> Result<RunReport, RunError> {
    let replacement = Replacement::of(corpus)?;
    if !Store::new(corpus).is_there(crate::corpus::MANIFEST) {
        return Err(CorpusError::NotACorpus { path: corpus.to_owned() }.into());
    }
    let held = open_to_run(corpus)?;
    let plan = noted_plan(&held.manifest).ok_or_else(|| RunError::NoPlan { corpus: corpus.to_owned() })?;
    let begun = Manifest::read(&Store::new(replacement.new_folder()));
    if !begun.is_ok_and(|begun| begun.is_some_and(|begun| is_of(&begun, &held.manifest))) {
        replacement.start_anew()?;
    }
    let request = RunRequest {
        plan,
        inputs: Vec::new(),
        procedural: false,
        out: replacement.new_folder().to_owned(),
        workers,
        hosts: None,
        prune: false,
        from: Some(corpus.to_owned()),
    };
    let report = run(&request, gauges, flag, |_| ())?;
    drop(held);
    replacement.put()?;
    Ok(report)
}

/// Whether a corpus that was begun is made of the same clips in the same way.
fn is_of(begun: &Manifest, old: &Manifest) -> bool {
    let clips = |manifest: &Manifest| -> Vec<(String, String, String)> {
        let clips =
            manifest.sources.iter().flat_map(|(source, entry)| entry.clips.iter().map(move |clip| (source, clip)));
        clips.map(|(source, (name, clip))| (source.clone(), name.clone(), clip.key.clone())).collect()
    };
    begun.plan == old.plan && clips(begun) == clips(old)
}

/// What is to be done to make a corpus of the clips that another one holds.
pub(super) fn prepare_stored(
    plan: &Plan,
    from: &Store,
    store: &Store,
    manifest: &mut Manifest,
) -> Result<Prepared, RunError> {
    let old = Manifest::read(from)?.ok_or_else(|| CorpusError::NotACorpus { path: from.root().to_owned() })?;
    let stored = read_records(from)?;
    if manifest.sources.is_empty() {
        let clips = old.sources.iter().flat_map(|(source, entry)| entry.clips.iter().map(move |clip| (source, clip)));
        let clips: Vec<NewClip> = clips
            .map(|(source, (name, clip))| NewClip {
                source: source.clone(),
                name: name.clone(),
                bytes: clip.bytes,
                blake3: clip.blake3.clone(),
                skeleton_blake3: clip.skeleton_blake3.clone(),
                key: clip.key.clone(),
            })
            .collect();
        give_numbers(&clips, &plan.config.shards, manifest);
        for (source, entry) in &mut manifest.sources {
            for (name, clip) in &mut entry.clips {
                let was = old.sources.get(source).and_then(|entry| entry.clips.get(name)).map(|clip| clip.state);
                clip.state = was.unwrap_or(ClipState::Present);
            }
        }
    }
    manifest.put(store)?;
    let mut records = read_records(store)?;
    records.iter_mut().for_each(|record| record.forget_lost(store));
    let wanted = Wanted {
        plan,
        keys: plan.keys(),
        procedural: false,
        manifest,
        records: &records,
        found: BTreeMap::new(),
        stored: Some(&stored),
    };
    let Jobs { shards, to_read, finished } = wanted.jobs();
    let clips = old.sources.values().flat_map(|source| source.clips.values());
    let (found, bytes) = clips.fold((0, 0), |(count, bytes), clip| (count + 1, bytes + clip.bytes));
    // What was said of inputs that are no clips, such as an AMC without its skeleton, is in no record.
    let in_records: BTreeSet<(&str, &str)> = stored
        .iter()
        .flat_map(|record| &record.inputs)
        .map(|input| (input.source.as_str(), input.name.as_str()))
        .collect();
    let mut faults = if from.is_there(FAULTS) { read_faults(from)? } else { Vec::new() };
    faults.retain(|row| !in_records.contains(&(row.source.as_str(), row.name.as_str())));
    Ok(Prepared { shards, to_read, finished, found, bytes, faults, gone: Vec::new(), replaced: Vec::new() })
}
