//! Files that were found to be as they were written. Parquet has no checksum that its readers look at: a flipped bit in a
//! page of floats would come out as another number, and what is made of it would get a sound digest.

use super::error::CorpusError;
use super::record::FileRecord;
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// The files whose digests have been taken by this reader. Cheap to clone; clones share what they know.
#[derive(Clone, Debug, Default)]
pub(super) struct Unchanged {
    checked: Arc<Mutex<BTreeSet<PathBuf>>>,
}

impl Unchanged {
    /// Takes the digest of a file, unless that was done.
    ///
    /// # Errors
    /// [`CorpusError::Damaged`] for a file that is not the one of its record.
    pub(super) fn check(&self, path: &Path, record: &FileRecord) -> Result<(), CorpusError> {
        if self.checked.lock().is_ok_and(|checked| checked.contains(path)) {
            return Ok(());
        }
        match is_as_written(path, record)? {
            true => {}
            false => {
                let what = format!("it is not the {} bytes that were written", record.bytes);
                return Err(CorpusError::damaged(path, what));
            }
        }
        if let Ok(mut checked) = self.checked.lock() {
            checked.insert(path.to_owned());
        }
        Ok(())
    }
}

/// Whether a file has the length and the digest of its record.
pub(super) fn is_as_written(path: &Path, record: &FileRecord) -> Result<bool, CorpusError> {
    let mut file = File::open(path).map_err(|error| CorpusError::io(path, "opening", error))?;
    let bytes = file.metadata().map_err(|error| CorpusError::io(path, "opening", error))?.len();
    if bytes != record.bytes {
        return Ok(false);
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(&mut file).map_err(|error| CorpusError::io(path, "reading", error))?;
    Ok(hasher.finalize().to_hex().as_str() == record.blake3)
}
