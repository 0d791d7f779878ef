//! The shards that have something to be done: what the plan wants beside what the records say was made (DESIGN 4).

use super::prepare::unlisted;
use super::work::{ClipJob, ClipOrigin, FileJob, KeptJob, ShardJob, Todo};
use crate::corpus::{ClipEntry, Manifest, ShardId, ShardRecord, StageKeys};
use crate::inputs::Input;
use crate::plan::{Plan, PlanKeys, Stage, shard_key};
use std::collections::BTreeMap;

/// What is wanted, and what there is.
pub(super) struct Wanted<'a> {
    pub(super) plan: &'a Plan,
    pub(super) keys: PlanKeys,
    /// Whether the inputs were made by the program.
    pub(super) procedural: bool,
    pub(super) manifest: &'a Manifest,
    /// Of the corpus that is written.
    pub(super) records: &'a [ShardRecord],
    /// The inputs that are there, by (source, name).
    pub(super) found: BTreeMap<(&'a str, &'a str), &'a Input>,
    /// Records of another corpus, whose stored clips are taken instead of inputs.
    pub(super) stored: Option<&'a [ShardRecord]>,
}

/// What has to be done.
pub(super) struct Jobs {
    /// Largest text first.
    pub(super) shards: Vec<ShardJob>,
    /// Clips to be parsed.
    pub(super) to_read: usize,
    /// Clips that need nothing.
    pub(super) finished: usize,
}

/// The clips of a shard: source, name, what the manifest knows.
type Listed<'a> = (&'a str, &'a str, &'a ClipEntry);

impl Wanted<'_> {
    pub(super) fn jobs(&self) -> Jobs {
        let records_of: BTreeMap<ShardId, &ShardRecord> =
            self.records.iter().map(|record| (record.shard, record)).collect();
        let mut listed = BTreeMap::<ShardId, Vec<Listed<'_>>>::new();
        for (source, entry) in &self.manifest.sources {
            for (name, clip) in &entry.clips {
                listed.entry(clip.shard).or_default().push((source, name, clip));
            }
        }
        let replaced = replaced_shards(&listed, self.records);
        let mut jobs = Jobs { shards: Vec::new(), to_read: 0, finished: 0 };
        let mut sized: Vec<(u64, ShardJob)> = Vec::new();
        for (shard, mut clips) in listed {
            clips.sort_by_key(|(.., clip)| clip.clip_id);
            let record = records_of.get(&shard).copied();
            let keys = self.keys_of(&clips, record);
            let Some(todo) = self.todo(&clips, record, &keys) else {
                jobs.finished += clips.len();
                continue;
            };
            let clip_jobs: Vec<ClipJob> = clips.iter().filter_map(|&clip| self.clip_job(todo, clip, record)).collect();
            let to_parse = clip_jobs.iter().filter(|clip| matches!(clip.origin, ClipOrigin::File(_))).count();
            if todo == Todo::Everything && to_parse == 0 && self.stored.is_none() {
                continue; // none of its files is there
            }
            jobs.to_read += to_parse;
            sized.push((
                clips.iter().map(|(.., clip)| clip.bytes).sum(),
                ShardJob {
                    shard,
                    replaces: replaced.get(&shard).cloned().unwrap_or_default(),
                    todo,
                    keys: keys_once_done(todo, keys, record),
                    clips: clip_jobs,
                },
            ));
        }
        sized.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.shard.cmp(&b.1.shard)));
        jobs.shards = sized.into_iter().map(|(_, job)| job).collect();
        jobs
    }

    fn all_found(&self, clips: &[Listed<'_>]) -> bool {
        clips.iter().all(|(source, name, _)| self.found.contains_key(&(*source, *name)))
    }

    /// The keys that the shard's stages should have.
    fn keys_of(&self, clips: &[Listed<'_>], record: Option<&ShardRecord>) -> StageKeys {
        let clip_keys: Vec<String> = clips.iter().map(|(.., clip)| format!("{}:{}", clip.clip_id, clip.key)).collect();
        // Without its files a shard can't be read otherwise: it counts as read as it should be.
        let ingest = match record {
            Some(record) if !self.all_found(clips) && record.is_whole() => record.keys.ingest.clone(),
            _ => shard_key(&self.keys.ingest, &clip_keys),
        };
        let rests_on = [ingest.clone()];
        let of = |stage, key: &str| {
            if self.plan.has(stage) { shard_key(key, &rests_on) } else { String::new() }
        };
        StageKeys {
            features: of(Stage::Features, &self.keys.features),
            labels: of(Stage::Contacts, &self.keys.labels),
            ingest,
        }
    }

    /// How much of a shard has to be made. None: nothing, or nothing that could be.
    fn todo(&self, clips: &[Listed<'_>], record: Option<&ShardRecord>, wanted: &StageKeys) -> Option<Todo> {
        let has = |of: fn(&StageKeys) -> &String| {
            let want = of(wanted);
            want.is_empty() || record.is_some_and(|record| of(&record.keys) == want)
        };
        let (features, labels) = (!has(|keys| &keys.features), !has(|keys| &keys.labels));
        // Without stored channels, or with no clip in the tables, there is nothing to make other tables from.
        let stored = self.plan.config.tables.channels && record.is_some_and(|record| !record.clips.is_empty());
        if !has(|keys| &keys.ingest) {
            Some(Todo::Everything)
        } else if !features && !labels {
            None
        } else if stored {
            Some(Todo::Again { features, labels })
        } else {
            self.all_found(clips).then_some(Todo::Everything)
        }
    }

    fn clip_job(&self, todo: Todo, (source, name, clip): Listed<'_>, record: Option<&ShardRecord>) -> Option<ClipJob> {
        let origin = match (todo, self.found.get(&(source, name))) {
            (Todo::Everything, Some(input)) => Some(ClipOrigin::File(Box::new(FileJob {
                path: input.path.clone(),
                asf: input.asf.clone(),
                blake3: clip.blake3.clone(),
                skeleton_blake3: clip.skeleton_blake3.clone(),
                settings: input.settings.clone(),
                procedural: self.procedural,
            }))),
            // Its file is not there, or not among this run's inputs: what a corpus has of it stays.
            (Todo::Everything, None) => self.kept(source, name, clip).map(|kept| ClipOrigin::Kept(Box::new(kept))),
            _ => record.is_some_and(|record| record.clip(clip.clip_id).is_some()).then_some(ClipOrigin::Stored),
        };
        Some(ClipJob { clip_id: clip.clip_id, source: source.to_owned(), name: name.to_owned(), origin: origin? })
    }

    /// What a corpus holds of a clip, to be taken over into another shard.
    fn kept(&self, source: &str, name: &str, clip: &ClipEntry) -> Option<KeptJob> {
        let whole = self.stored.unwrap_or(self.records).iter().filter(|record| record.is_whole());
        whole.into_iter().find_map(|record| {
            let is_it = |input: &&crate::corpus::InputFile| match self.stored {
                Some(_) => input.source == source && input.name == name,
                None => input.clip_id == clip.clip_id,
            };
            let input = record.inputs.iter().find(is_it)?;
            let of_it = |row: &&crate::corpus::FaultRow| row.source == source && row.name == name;
            let mut kept = KeptJob {
                stored_as: input.clip_id,
                row: record.clip(input.clip_id).cloned(),
                notices: record.faults.iter().filter(of_it).map(|row| row.notice.clone()).collect(),
                input: input.clone(),
            };
            kept.input.clip_id = clip.clip_id;
            kept.row.iter_mut().for_each(|row| row.clip_id = clip.clip_id);
            Some(kept)
        })
    }
}

/// What the keys of a shard are when the job is done: those of stages that the plan lacks stay.
fn keys_once_done(todo: Todo, wanted: StageKeys, record: Option<&ShardRecord>) -> StageKeys {
    match todo {
        Todo::Everything | Todo::Samples { .. } => wanted,
        Todo::Again { .. } => {
            let kept = record.map(|record| record.keys.clone()).unwrap_or_default();
            let or_kept = |want: String, kept: String| if want.is_empty() { kept } else { want };
            StageKeys {
                ingest: kept.ingest,
                features: or_kept(wanted.features, kept.features),
                labels: or_kept(wanted.labels, kept.labels),
            }
        }
    }
}

/// Shards that the manifest doesn't list any more, by the shard that has their clips now.
fn replaced_shards(
    listed: &BTreeMap<ShardId, Vec<Listed<'_>>>,
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
