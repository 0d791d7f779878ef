//! The manifest: what was read, what it was called, what was made of it. Sorted, without times and absolute paths.

use super::error::CorpusError;
use super::paths::{MANIFEST, ShardId};
use super::record::{FileRecord, check_version, version_error};
use super::sealed::{seal, unseal};
use super::store::Store;
use super::unchanged::is_as_written;
use super::writer::FORMAT_VERSION;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `manifest.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT_VERSION`] of the program that wrote it.
    pub format_version: u32,
    /// Version of that program.
    pub program: String,
    /// The lowest clip_id that was never given out.
    pub next_clip_id: u32,
    /// The lowest number of a captured shard that was never given out.
    pub next_shard: u32,
    /// The lowest number of a made shard that was never given out.
    pub next_made_shard: u32,
    /// By label.
    pub sources: BTreeMap<String, SourceEntry>,
    /// Keys of the stages over the whole corpus: tree, graph, recipes, make ...
    pub stages: BTreeMap<String, String>,
    /// The tables that are one file, and other files outside the shards, by path.
    pub tables: BTreeMap<String, TableDigest>,
    /// Recipes that could be made, by rule: whole numbers as text, for they may exceed what JSON readers keep exact.
    pub products: BTreeMap<String, String>,
    /// The plan of the run that made it, as that wrote it: what `compact` makes it anew by. Opaque to this room.
    pub plan: serde_json::Value,
    /// Digest of the reference that the first enrichment froze.
    pub reference: Option<String>,
}

/// The clips of one source.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceEntry {
    /// By name.
    pub clips: BTreeMap<String, ClipEntry>,
}

/// What the manifest knows of a clip's input.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipEntry {
    /// Its number.
    pub clip_id: u32,
    /// Digest of the file.
    pub blake3: String,
    /// Digest of the ASF that goes with an AMC.
    pub skeleton_blake3: Option<String>,
    /// Digest of both and of what the config said of the clip when it was last found.
    pub key: String,
    /// Length of the file: what shards are cut by.
    pub bytes: u64,
    /// Whether it is in the tables.
    pub state: ClipState,
    /// The shard that holds it, or would.
    pub shard: ShardId,
}

/// Whether a clip is in the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClipState {
    /// It is.
    Present,
    /// It could not be used; `faults` says why.
    Quarantined,
    /// It is, but its file has gone from the source.
    Gone,
}

/// A file as it was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as FileRecord")]
pub struct TableDigest {
    pub bytes: u64,
    pub blake3: String,
    pub rows: u64,
}

impl Default for Manifest {
    fn default() -> Manifest {
        Manifest {
            format_version: FORMAT_VERSION,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            next_clip_id: 0,
            next_shard: 0,
            next_made_shard: 0,
            sources: BTreeMap::new(),
            stages: BTreeMap::new(),
            tables: BTreeMap::new(),
            products: BTreeMap::new(),
            plan: serde_json::Value::Null,
            reference: None,
        }
    }
}

impl Manifest {
    /// Notes files as they were written.
    pub fn note_files(&mut self, files: impl IntoIterator<Item = FileRecord>) {
        for FileRecord { path, bytes, blake3, rows } in files {
            self.tables.insert(path, TableDigest { bytes, blake3, rows });
        }
    }

    /// The tables that are not there any more, or not as they were written.
    pub fn changed_tables(&self, store: &Store) -> Vec<String> {
        let changed = |(path, digest): &(&String, &TableDigest)| {
            let TableDigest { bytes, blake3, rows } = (*digest).clone();
            let record = FileRecord { path: (*path).clone(), bytes, blake3, rows };
            !is_as_written(&store.path(path), &record).unwrap_or(false)
        };
        self.tables.iter().filter(changed).map(|(path, _)| path.clone()).collect()
    }

    /// How many recipes a rule allows.
    pub fn set_product(&mut self, rule: &str, size: u128) {
        self.products.insert(rule.to_owned(), size.to_string());
    }

    /// How many recipes a rule allows, if that was counted.
    pub fn product(&self, rule: &str) -> Option<u128> {
        self.products.get(rule)?.parse().ok()
    }

    /// Puts it in the corpus, atomically; one that says the same is left as it is.
    ///
    /// # Errors
    /// The file system's refusals.
    pub fn put(&self, store: &Store) -> Result<(), CorpusError> {
        let bytes = seal(self, &store.path(MANIFEST))?;
        if store.read(MANIFEST)?.is_some_and(|there| there == bytes) {
            return Ok(());
        }
        store.put_atomic(MANIFEST, &bytes)
    }

    /// Takes back the keys of stages and puts the manifest, before the stages' files are replaced: killed between files
    /// and key, a run would leave files that are not what their old key says.
    ///
    /// # Errors
    /// As [`Manifest::put`].
    pub fn forget<'a>(&mut self, stages: impl IntoIterator<Item = &'a str>, store: &Store) -> Result<(), CorpusError> {
        stages.into_iter().for_each(|stage| drop(self.stages.remove(stage)));
        self.put(store)
    }

    /// Reads it; None: there is none yet.
    ///
    /// # Errors
    /// [`CorpusError::Damaged`], [`CorpusError::Version`], and the file system's refusals.
    pub fn read(store: &Store) -> Result<Option<Manifest>, CorpusError> {
        let Some(bytes) = store.read(MANIFEST)? else { return Ok(None) };
        let path = store.path(MANIFEST);
        let manifest: Manifest = unseal(&bytes, &path).map_err(|error| version_error(&bytes, &path, error))?;
        check_version(manifest.format_version, &path)?;
        match manifest.tables.keys().find(|name| !Store::is_inside(name)) {
            None => Ok(Some(manifest)),
            Some(name) => Err(CorpusError::damaged(&path, format!("it names `{name}`, outside the corpus"))),
        }
    }
}
