//! Verifying a corpus: every file against the digest it was written with.

use super::error::CorpusError;
use super::manifest::Manifest;
use super::paths::{COMMITS, MANIFEST, ShardId, Table};
use super::record::{FileRecord, ShardRecord, read_record, shards_with_records};
use super::store::Store;
use std::collections::BTreeSet;
use std::fs::File;

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// The file.
    pub path: String,
    /// What is wrong.
    pub what: Wrong,
}

/// The ways a file can be wrong.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wrong {
    /// It should be there.
    Missing,
    /// It has another length or digest than it was written with.
    Changed,
    /// A record or manifest that can't be read: why.
    Unreadable(String),
    /// A stage of the shard has to be made again; the next run does.
    Unfinished,
    /// It looks like a file of a shard, but no record names it; the next run removes it.
    Stray,
}

/// What was looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    /// Files whose digests were taken.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// By path; empty: the corpus is as it was written.
    pub findings: Vec<Finding>,
}

impl std::fmt::Display for Wrong {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Wrong::Missing => f.write_str("missing"),
            Wrong::Changed => f.write_str("not what was written"),
            Wrong::Unreadable(why) => write!(f, "unreadable: {why}"),
            Wrong::Unfinished => f.write_str("a stage of this shard has to be made again"),
            Wrong::Stray => f.write_str("left by a run that was ended"),
        }
    }
}

/// Takes the digest of every file that the records and the manifest name, and compares.
///
/// # Errors
/// Only the file system's refusals; what is wrong with the corpus comes back as findings.
pub fn verify(store: &Store) -> Result<Verified, CorpusError> {
    let mut verified = Verified::default();
    let mut named: BTreeSet<String> = BTreeSet::new();
    let mut replaced: BTreeSet<ShardId> = BTreeSet::new();
    let mut records: Vec<ShardRecord> = Vec::new();
    for shard in shards_with_records(store)? {
        match read_record(store, shard) {
            Ok(Some(record)) => records.push(record),
            Ok(None) => {}
            Err(error @ CorpusError::Io { .. }) => return Err(error),
            Err(error) => verified.find(shard.record_file(), Wrong::Unreadable(error.to_string())),
        }
    }
    let unreadable = !verified.findings.is_empty();
    for record in records.iter().filter(|record| record.is_whole()) {
        replaced.extend(&record.replaces);
    }
    for record in records.iter().filter(|record| !replaced.contains(&record.shard)) {
        if [&record.keys.ingest, &record.keys.features, &record.keys.labels].into_iter().any(String::is_empty) {
            verified.find(record.shard.record_file(), Wrong::Unfinished);
        }
        for file in &record.files {
            verified.check(store, file)?;
            named.insert(file.path.clone());
        }
    }
    match Manifest::read(store) {
        Ok(Some(manifest)) => {
            for (path, digest) in manifest.tables {
                let file = FileRecord { path, bytes: digest.bytes, blake3: digest.blake3, rows: digest.rows };
                verified.check(store, &file)?;
            }
            let listed = manifest.sources.values().flat_map(|source| source.clips.values()).map(|clip| clip.shard);
            for shard in listed.collect::<BTreeSet<_>>() {
                if store.read(&shard.record_file())?.is_none() {
                    verified.find(shard.record_file(), Wrong::Missing);
                }
            }
        }
        Ok(None) => verified.find(MANIFEST.to_owned(), Wrong::Missing),
        Err(error @ CorpusError::Io { .. }) => return Err(error),
        Err(error) => verified.find(MANIFEST.to_owned(), Wrong::Unreadable(error.to_string())),
    }
    for name in store.list_ours()? {
        // Without its record nobody can tell whether a shard's file is a stray.
        let unnamed = Table::of_file(&name).is_some() && !named.contains(&name) && !unreadable;
        let old = name.starts_with(COMMITS) && ShardId::of_file(&name).is_some_and(|shard| replaced.contains(&shard));
        if unnamed || old || Store::temporary_for(&name).is_some() {
            verified.find(name, Wrong::Stray);
        }
    }
    verified.findings.sort();
    Ok(verified)
}

impl Verified {
    fn find(&mut self, path: String, what: Wrong) {
        self.findings.push(Finding { path, what });
    }

    fn check(&mut self, store: &Store, file: &FileRecord) -> Result<(), CorpusError> {
        let path = store.path(&file.path);
        let mut open = match File::open(&path) {
            Ok(open) => open,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                self.find(file.path.clone(), Wrong::Missing);
                return Ok(());
            }
            Err(error) => return Err(CorpusError::io(&path, "opening", error)),
        };
        let mut hasher = blake3::Hasher::new();
        let bytes = std::io::copy(&mut open, &mut hasher).map_err(|error| CorpusError::io(&path, "reading", error))?;
        self.files += 1;
        self.bytes += bytes;
        if bytes != file.bytes || hasher.finalize().to_hex().as_str() != file.blake3 {
            self.find(file.path.clone(), Wrong::Changed);
        }
        Ok(())
    }
}
