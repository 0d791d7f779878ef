//! Putting a corpus that was made anew in the place of the old one.
//!
//! The new one grows in a folder beside it and takes its place by two renames. A kill between them leaves the corpus under
//! its other name; whoever prepares the next replacement puts that right first.

use super::error::CorpusError;
use super::lock::is_lock_file;
use super::store::Store;
use std::fs;
use std::path::{Path, PathBuf};

/// A corpus, and the folders beside it.
#[derive(Clone, Debug)]
pub struct Replacement {
    corpus: PathBuf,
    new: PathBuf,
    old: PathBuf,
}

impl Replacement {
    /// Prepares to replace a corpus, and ends what a kill left half done.
    ///
    /// # Errors
    /// The file system's refusals; [`CorpusError::NotACorpus`] for a path without a last component.
    pub fn of(corpus: &Path) -> Result<Replacement, CorpusError> {
        // Through links: the folder itself is replaced, in the folder that it lies in.
        let corpus = fs::canonicalize(corpus).unwrap_or_else(|_| corpus.to_owned());
        let name = corpus.file_name().ok_or_else(|| CorpusError::NotACorpus { path: corpus.clone() })?.to_owned();
        let beside = |ending: &str| {
            let mut own = std::ffi::OsString::from(".");
            own.push(&name);
            own.push(ending);
            corpus.with_file_name(own)
        };
        let (new, old) = (beside(".compacting"), beside(".replaced"));
        let replacement = Replacement { corpus, new, old };
        if replacement.old.exists() {
            if !replacement.corpus.exists() {
                replacement.rename(&replacement.new, &replacement.corpus)?;
            }
            replacement.remove_old()?;
        }
        Ok(replacement)
    }

    /// Where the new one is to be made.
    pub fn new_folder(&self) -> &Path {
        &self.new
    }

    /// Removes what is there of a new one.
    ///
    /// # Errors
    /// The file system's refusals.
    pub fn start_anew(&self) -> Result<(), CorpusError> {
        remove_folder(&self.new)
    }

    /// Puts the new one in the place of the old one, which goes. Files that are none of the corpus' own stay.
    ///
    /// # Errors
    /// The file system's refusals; nothing is lost, and [`Replacement::of`] ends what was begun.
    pub fn put(&self) -> Result<(), CorpusError> {
        self.rename(&self.corpus, &self.old)?;
        self.rename(&self.new, &self.corpus)?;
        self.remove_old()
    }

    fn remove_old(&self) -> Result<(), CorpusError> {
        let old = Store::new(&self.old);
        let ours = old.list_ours()?;
        for name in old.list("")?.into_iter().filter(|name| !ours.contains(name) && !is_lock_file(name)) {
            let to = self.corpus.join(&name);
            let folder = to.parent().unwrap_or(&self.corpus);
            fs::create_dir_all(folder).map_err(|error| CorpusError::io(folder, "making the folder", error))?;
            self.rename(&old.path(&name), &to)?;
        }
        remove_folder(&self.old)
    }

    fn rename(&self, from: &Path, to: &Path) -> Result<(), CorpusError> {
        fs::rename(from, to).map_err(|error| CorpusError::io(from, "renaming", error))
    }
}

fn remove_folder(folder: &Path) -> Result<(), CorpusError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(CorpusError::io(folder, "removing", error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn corpora(folder: &Path) -> PathBuf {
        let corpus = folder.join("corpus");
        Store::new(&corpus).put_atomic("clips.parquet", b"old").unwrap();
        Store::new(&corpus).put_atomic("notes/mine.txt", b"mine").unwrap();
        Store::new(folder.join(".corpus.compacting")).put_atomic("clips.parquet", b"new").unwrap();
        corpus
    }

    #[track_caller]
    fn is_replaced(corpus: &Path) {
        assert_eq!(Store::new(corpus).list("").unwrap(), ["clips.parquet", "notes/mine.txt"]);
        assert_eq!(fs::read(corpus.join("clips.parquet")).unwrap(), b"new");
        assert_eq!(fs::read_dir(corpus.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn the_new_one_takes_the_place_and_files_of_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let corpus = corpora(folder.path());
        Replacement::of(&corpus).unwrap().put().unwrap();
        is_replaced(&corpus);
    }

    #[test]
    fn a_kill_after_either_rename_is_put_right() {
        for renames in 1..=2 {
            let folder = tempfile::tempdir().unwrap();
            let corpus = corpora(folder.path());
            let replacement = Replacement::of(&corpus).unwrap();
            replacement.rename(&replacement.corpus, &replacement.old).unwrap();
            if renames == 2 {
                replacement.rename(&replacement.new, &replacement.corpus).unwrap();
            }
            Replacement::of(&folder.path().canonicalize().unwrap().join("corpus")).unwrap();
            is_replaced(&corpus);
        }
    }
}
