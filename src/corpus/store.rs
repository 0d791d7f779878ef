//! The files of a corpus: put whole or not at all.
//!
//! Everything is written to a temporary file beside its place, synced, and renamed. What a kill leaves behind
//! ends in `.partial`, is read by nobody, and goes when the next run opens the corpus.

use super::error::CorpusError;
use super::paths::{is_ours, our_folders};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Ending of temporary files.
const PARTIAL: &str = ".partial";

/// A folder whose files are named relative to it, with `/`.
#[derive(Clone, Debug)]
pub struct Store {
    root: PathBuf,
}

/// A file that is being written; it goes when it is dropped before [`Temporary::rename`].
#[derive(Debug)]
pub struct Temporary {
    file: Option<File>,
    here: PathBuf,
    there: PathBuf,
}

impl Store {
    /// The store in a folder, which need not exist yet.
    pub fn new(root: impl Into<PathBuf>) -> Store {
        Store { root: root.into() }
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Path of a file of the store.
    pub fn path(&self, name: &str) -> PathBuf {
        debug_assert!(Store::is_inside(name), "{name}");
        self.root.join(name)
    }

    /// Makes the folder.
    pub fn create_root(&self) -> Result<(), CorpusError> {
        fs::create_dir_all(&self.root).map_err(|error| CorpusError::io(&self.root, "making the folder", error))
    }

    /// Puts a file in its place whole, or leaves everything as it was: temporary file, sync, rename, sync of the folder.
    pub fn put_atomic(&self, name: &str, bytes: &[u8]) -> Result<(), CorpusError> {
        let mut temporary = self.temporary(name)?;
        temporary.write_all(bytes).map_err(|error| CorpusError::io(&temporary.here, "writing", error))?;
        temporary.sync()?;
        temporary.rename()?;
        self.sync_folder_of(name)
    }

    /// Opens a temporary file for what is to become `name`; its folder is made.
    pub fn temporary(&self, name: &str) -> Result<Temporary, CorpusError> {
        let there = self.path(name);
        let folder = there.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder).map_err(|error| CorpusError::io(folder, "making the folder", error))?;
        let here = self.path(&format!("{name}{PARTIAL}"));
        let file = File::create(&here).map_err(|error| CorpusError::io(&here, "making the file", error))?;
        Ok(Temporary { file: Some(file), here, there })
    }

    /// Makes renames in a file's folder last through a power cut.
    pub fn sync_folder_of(&self, name: &str) -> Result<(), CorpusError> {
        // Windows can't open a folder as a file; NTFS journals the rename.
        if cfg!(unix) {
            // The folder may be new itself, so its parents up to the root are synced as well.
            let path = self.path(name);
            for folder in path.ancestors().skip(1) {
                let synced = File::open(folder).and_then(|file| file.sync_all());
                synced.map_err(|error| CorpusError::io(folder, "syncing", error))?;
                if folder == self.root {
                    break;
                }
            }
        }
        Ok(())
    }

    /// The bytes of a file; None where there is no such file.
    pub fn read(&self, name: &str) -> Result<Option<Vec<u8>>, CorpusError> {
        let path = self.path(name);
        match fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(CorpusError::io(&path, "reading", error)),
        }
    }

    /// Whether there is such a file.
    pub fn is_there(&self, name: &str) -> bool {
        self.path(name).is_file()
    }

    /// Whether there is such a file, and of that length.
    pub fn holds(&self, name: &str, bytes: u64) -> bool {
        self.path(name).metadata().is_ok_and(|file| file.is_file() && file.len() == bytes)
    }

    /// Names of all files below a folder of the store (`""`: of the whole store), sorted; temporary files too.
    /// Links are not followed; names that are not UTF-8 are not ours and left out.
    pub fn list(&self, folder: &str) -> Result<Vec<String>, CorpusError> {
        let mut names = Vec::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            let (files, below) = self.entries(&folder)?;
            names.extend(files);
            folders.extend(below);
        }
        names.sort();
        Ok(names)
    }

    /// Names of the files that the program itself put, or was putting, into the store: whole ones and temporary ones.
    /// Looks into the corpus' own folders only.
    pub(super) fn list_ours(&self) -> Result<Vec<String>, CorpusError> {
        let mut names = self.entries("")?.0;
        for folder in our_folders() {
            names.extend(self.list(folder)?);
        }
        names.retain(|name| is_ours(Store::temporary_for(name).unwrap_or(name)));
        names.sort();
        Ok(names)
    }

    /// Names of the files and folders right in a folder.
    pub(super) fn entries(&self, folder: &str) -> Result<(Vec<String>, Vec<String>), CorpusError> {
        let path = if folder.is_empty() { self.root.clone() } else { self.path(folder) };
        let (mut files, mut folders) = (Vec::new(), Vec::new());
        let entries = match fs::read_dir(&path) {
            Ok(entries) => entries,
            // A file in the place of a folder holds nothing either; whoever has to write there is refused.
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
                return Ok((files, folders));
            }
            Err(error) => return Err(CorpusError::io(&path, "listing", error)),
        };
        for entry in entries {
            let entry = entry.map_err(|error| CorpusError::io(&path, "listing", error))?;
            let kind = entry.file_type().map_err(|error| CorpusError::io(&path, "listing", error))?;
            let Ok(own) = entry.file_name().into_string() else { continue };
            let name = if folder.is_empty() { own } else { format!("{folder}/{own}") };
            if !Store::is_inside(&name) {
                continue;
            }
            match (kind.is_dir(), kind.is_file()) {
                (true, _) => folders.push(name),
                (_, true) => files.push(name),
                _ => {}
            }
        }
        Ok((files, folders))
    }

    /// Removes a file; that it is not there is no error.
    pub fn remove(&self, name: &str) -> Result<(), CorpusError> {
        let path = self.path(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(CorpusError::io(&path, "removing", error)),
            _ => Ok(()),
        }
    }

    /// What a temporary file was to become; None: it is none.
    pub fn temporary_for(name: &str) -> Option<&str> {
        name.strip_suffix(PARTIAL)
    }

    /// Whether a name stays inside the store.
    pub fn is_inside(name: &str) -> bool {
        name.split('/').all(|part| !part.is_empty() && part != "." && part != "..") && !name.contains(['\\', ':', '\0'])
    }
}

impl Temporary {
    /// Where it is being written.
    pub fn path(&self) -> &Path {
        &self.here
    }

    /// Makes what was written last through a power cut, and closes the file.
    pub fn sync(&mut self) -> Result<(), CorpusError> {
        match self.file.take() {
            Some(file) => file.sync_all().map_err(|error| CorpusError::io(&self.here, "syncing", error)),
            None => Ok(()),
        }
    }

    /// Puts it in its place.
    pub fn rename(mut self) -> Result<(), CorpusError> {
        self.sync()?;
        fs::rename(&self.here, &self.there).map_err(|error| CorpusError::io(&self.there, "renaming", error))?;
        self.here.clear();
        Ok(())
    }
}

impl Write for Temporary {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.file {
            Some(file) => file.write(bytes),
            None => Err(io::Error::other("written to after it was closed")),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), File::flush)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.here.as_os_str().is_empty() {
            drop(self.file.take());
            // What can't be removed now goes when the next run opens the corpus.
            let _ = fs::remove_file(&self.here);
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_file_is_put_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        store.put_atomic("a/b/c.json", b"one").unwrap();
        store.put_atomic("a/b/c.json", b"two").unwrap();
        let mut dropped = store.temporary("a/b/c.json").unwrap();
        dropped.write_all(b"three").unwrap();
        assert_eq!(store.list("").unwrap(), ["a/b/c.json", "a/b/c.json.partial"]);
        drop(dropped);
        assert_eq!(store.list("").unwrap(), ["a/b/c.json"]);
        assert_eq!(store.read("a/b/c.json").unwrap().unwrap(), b"two");
        assert_eq!(store.read("a/b/d.json").unwrap(), None);
        store.remove("a/b/c.json").unwrap();
        store.remove("a/b/c.json").unwrap();
        assert!(store.list("a").unwrap().is_empty());
    }

    #[test]
    fn a_file_in_the_way_is_an_error_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("channels"), b"").unwrap();
        let error = Store::new(folder.path()).put_atomic("channels/x.parquet", b"").unwrap_err();
        assert!(error.to_string().contains("channels: the file system failed while making the folder"), "{error}");
    }
}
