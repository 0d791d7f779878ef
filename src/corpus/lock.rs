//! One run at a time: an advisory lock on a file of the corpus, and the token of the run that holds it.
//!
//! The system lets go of the lock when the process ends, however it ends. The token lies in a file of its own,
//! because Windows lets nobody read a locked file.

use super::error::CorpusError;
use super::store::Store;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, RandomState};

const LOCK: &str = ".lock";
const RUN: &str = ".run";

/// The right to write in a corpus, until dropped.
#[derive(Debug)]
pub struct RunLock {
    store: Store,
    token: String,
    file: File,
}

impl RunLock {
    /// Takes the lock; at once, or not at all.
    ///
    /// # Errors
    /// [`CorpusError::Locked`] when another run holds it, and the file system's refusals.
    pub fn acquire(store: &Store) -> Result<RunLock, CorpusError> {
        store.create_root()?;
        let path = store.path(LOCK);
        let file = File::options().create(true).truncate(false).write(true).open(&path);
        let file = file.map_err(|error| CorpusError::io(&path, "opening the lock", error))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let text = store.read(RUN)?.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
                let holder = text.and_then(|text| text.lines().nth(1).map(str::to_owned));
                return Err(CorpusError::Locked { path: store.root().to_owned(), holder });
            }
            Err(TryLockError::Error(error)) => return Err(CorpusError::io(&path, "locking", error)),
        }
        // Random, for it only has to differ from the tokens of runs that are gone; it reaches no table.
        let halves = [0, 1].map(|salt: u8| RandomState::new().hash_one((std::process::id(), salt)));
        let token = format!("{:016x}{:016x}", halves[0], halves[1]);
        store.put_atomic(RUN, format!("{token}\nprocess {}\n", std::process::id()).as_bytes())?;
        Ok(RunLock { store: store.clone(), token, file })
    }

    /// What the other processes of the run show to [`check_token`].
    pub fn token(&self) -> &str {
        &self.token
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // Left behind it does no harm: the lock decides.
        let _ = self.store.remove(RUN);
        // By itself and not by closing the file: a process that is being started elsewhere may hold a copy of it still.
        let _ = self.file.unlock();
    }
}

/// Whether a name is one of the lock's own files.
pub(super) fn is_lock_file(name: &str) -> bool {
    name == LOCK || name == RUN
}

/// Checks in another process that the run with this token still holds the corpus.
///
/// # Errors
/// [`CorpusError::NotOurRun`].
pub fn check_token(store: &Store, token: &str) -> Result<(), CorpusError> {
    let text = store.read(RUN)?.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    match text.lines().next() == Some(token) {
        true => Ok(()),
        false => Err(CorpusError::NotOurRun { path: store.root().to_owned() }),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_second_run_is_told_who_holds_the_corpus() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let first = RunLock::acquire(&store).unwrap();
        check_token(&store, first.token()).unwrap();
        let error = RunLock::acquire(&store).unwrap_err();
        let told = format!("another run is at work in this corpus (process {})", std::process::id());
        assert!(error.to_string().ends_with(&told), "{error}");
        let token = first.token().to_owned();
        drop(first);
        assert!(matches!(check_token(&store, &token), Err(CorpusError::NotOurRun { .. })));
        let second = RunLock::acquire(&store).unwrap();
        assert_ne!(second.token(), token);
    }
}
