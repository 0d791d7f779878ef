//! Opening a corpus: to look, or to run, which takes the lock and clears what an earlier run left half-written.

use super::error::CorpusError;
use super::lock::{RunLock, is_lock_file};
use super::manifest::Manifest;
use super::paths::{COMMITS, MANIFEST, ShardId, Table};
use super::record::{ShardRecord, read_record, read_records, shards_with_records};
use super::store::Store;
use std::collections::{BTreeMap, BTreeSet};

/// A corpus held by this run.
#[derive(Debug)]
pub struct OpenCorpus {
    /// Its files.
    pub store: Store,
    /// Held until this is dropped.
    pub lock: RunLock,
    /// As found; the default for a new corpus.
    pub manifest: Manifest,
    /// Files that were cleared away, by name.
    pub cleared: Vec<String>,
}

/// Opens a corpus to look at it. Takes no lock: files appear whole or not at all.
///
/// # Errors
/// [`CorpusError::NotACorpus`], [`CorpusError::Version`], [`CorpusError::Damaged`], and the file system's refusals.
pub fn open_to_read(folder: impl Into<std::path::PathBuf>) -> Result<(Store, Manifest), CorpusError> {
    let store = Store::new(folder);
    match Manifest::read(&store)? {
        Some(manifest) => Ok((store, manifest)),
        None => Err(CorpusError::NotACorpus { path: store.root().to_owned() }),
    }
}

/// Opens a corpus to run, or makes one: takes the lock, then removes what a killed run left: temporary files, shards
/// that others replaced, and files of shards that no record names.
///
/// # Errors
/// [`CorpusError::Locked`]; [`CorpusError::Occupied`] for a folder with other things in it, whose README a dataset
/// card would replace; as [`open_to_read`] except that a corpus need not be there. A damaged commit record is
/// an error too, so that nothing is removed on its word; deleting it makes its shard be made anew.
pub fn open_to_run(folder: impl Into<std::path::PathBuf>) -> Result<OpenCorpus, CorpusError> {
    let store = Store::new(folder);
    refuse_others(&store)?;
    let lock = RunLock::acquire(&store)?;
    let manifest = Manifest::read(&store)?.unwrap_or_default();
    let cleared = clear_leftovers(&store)?;
    Ok(OpenCorpus { store, lock, manifest, cleared })
}

fn refuse_others(store: &Store) -> Result<(), CorpusError> {
    let (files, folders) = store.entries("")?;
    let ours = |name: &String| name == MANIFEST || name == COMMITS || is_lock_file(name);
    let empty = files.iter().chain(&folders).all(|name| name.starts_with('.'));
    match empty || files.iter().chain(&folders).any(ours) {
        true => Ok(()),
        false => Err(CorpusError::Occupied { path: store.root().to_owned() }),
    }
}

fn clear_leftovers(store: &Store) -> Result<Vec<String>, CorpusError> {
    let current: BTreeMap<ShardId, ShardRecord> =
        read_records(store)?.into_iter().map(|record| (record.shard, record)).collect();
    let mut cleared = Vec::new();
    for shard in shards_with_records(store)?.into_iter().filter(|shard| !current.contains_key(shard)) {
        if let Some(record) = read_record(store, shard)? {
            super::shard::remove_shard(store, &record)?;
            cleared.push(shard.record_file());
            cleared.extend(record.files.into_iter().map(|file| file.path));
        }
    }
    let named: BTreeSet<&str> =
        current.values().flat_map(|record| record.files.iter().map(|file| file.path.as_str())).collect();
    for name in store.list_ours()? {
        let temporary = Store::temporary_for(&name).is_some();
        let unnamed = Table::of_file(&name).is_some() && !named.contains(name.as_str());
        if temporary || unnamed {
            store.remove(&name)?;
            cleared.push(name);
        }
    }
    cleared.sort();
    cleared.dedup();
    Ok(cleared)
}
