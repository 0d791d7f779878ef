//! What can go wrong with a corpus on disk: facts for the messages that the command line prints.

use arrow::error::ArrowError;
use parquet::errors::ParquetError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a corpus could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CorpusError {
    /// The file system refused.
    #[error("{}: {trouble} while {doing}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Such as `writing` or `listing`.
        doing: &'static str,
        /// What kind of refusal.
        trouble: Trouble,
        /// As the system said it.
        source: io::Error,
    },
    /// Another run holds the corpus.
    #[error("{}: another run is at work in this corpus{}", path.display(), holder.as_ref().map_or(String::new(), |h| format!(" ({h})")))]
    Locked {
        /// The corpus folder.
        path: PathBuf,
        /// What the other run wrote about itself.
        holder: Option<String>,
    },
    /// This process was started by a run that no longer holds the corpus.
    #[error("{}: the run that started this process no longer holds the corpus", path.display())]
    NotOurRun {
        /// The corpus folder.
        path: PathBuf,
    },
    /// The folder has no manifest.
    #[error("{}: not a corpus: there is no manifest.json in it", path.display())]
    NotACorpus {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds other things and no corpus.
    #[error("{}: the folder is not empty, and what is in it is no corpus", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
    /// Written by another version of the program.
    #[error("{}: format version {found}, this program knows {known}", path.display())]
    Version {
        /// Record or manifest.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// [`FORMAT_VERSION`](super::FORMAT_VERSION).
        known: u32,
    },
    /// A file is not what was written.
    #[error("{}: damaged: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What was found.
        what: String,
    },
    /// A name or an id that the corpus doesn't hold, or a table of it that has not been made.
    #[error("{what} is not in this corpus")]
    NotThere {
        /// Clip, shard or table.
        what: String,
    },
    /// Rows that no table can hold; nothing of the clip was written.
    #[error("clip {clip_id}: {table} refused: {what}")]
    Refused {
        /// The clip.
        clip_id: u32,
        /// Which table.
        table: &'static str,
        /// What is wrong with the rows.
        what: String,
    },
    /// The table encoder failed for a reason that is not the disk's.
    #[error("{}: could not encode: {what}", path.display())]
    Encoding {
        /// The file.
        path: PathBuf,
        /// As the encoder said it.
        what: String,
    },
}

/// The kinds of refusal by a file system that a user can do something about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// No space, or no quota, left.
    DiskFull,
    /// The file system is mounted read-only.
    ReadOnly,
    /// No permission.
    Permission,
    /// Not there.
    Missing,
    /// Anything else.
    Other,
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Trouble::DiskFull => "the disk is full",
            Trouble::ReadOnly => "the file system is read-only",
            Trouble::Permission => "no permission",
            Trouble::Missing => "no such file or folder",
            Trouble::Other => "the file system failed",
        })
    }
}

impl CorpusError {
    /// Why the fault matters, in one line without the place.
    pub fn why(&self) -> String {
        match self {
            CorpusError::Io { source, .. } => format!("{source}; the corpus is as it was before this step"),
            CorpusError::Locked { .. } => "two runs at once would write the same files".to_owned(),
            CorpusError::NotOurRun { .. } => "its output would mix with another run's".to_owned(),
            CorpusError::NotACorpus { .. } => "every corpus has a manifest, put there at the end of a stage".to_owned(),
            CorpusError::Occupied { .. } => "a run would mix its files with these".to_owned(),
            CorpusError::Version { .. } => "its tables may mean something else".to_owned(),
            CorpusError::Damaged { .. } => "what it held can't be trusted".to_owned(),
            CorpusError::NotThere { .. } => {
                "it was never ingested, was quarantined, or its stage has not run".to_owned()
            }
            CorpusError::Refused { .. } => "tables hold finite numbers of the right count, or nulls".to_owned(),
            CorpusError::Encoding { .. } => "the table can't be written".to_owned(),
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            CorpusError::Io { trouble, .. } => match trouble {
                Trouble::DiskFull => "make room, then run the same command again: it continues",
                Trouble::ReadOnly => "choose another folder with --out, or mount it writable",
                Trouble::Permission => "change the folder's permissions, or choose another with --out",
                Trouble::Missing => "check the path",
                Trouble::Other => "see what the system said, then run the same command again: it continues",
            },
            CorpusError::Locked { .. } => "wait for it, or end it; a run that was killed leaves no lock behind",
            CorpusError::NotOurRun { .. } => "start all processes of the run again",
            CorpusError::NotACorpus { .. } => "give the folder that a run wrote (its --out)",
            CorpusError::Occupied { .. } => "choose an empty or a new folder with --out",
            CorpusError::Version { .. } => "use the program that wrote it, or make the corpus again",
            CorpusError::Damaged { .. } => "delete the file and run the same command again: it is made anew",
            CorpusError::NotThere { .. } => {
                "look it up with `motionmill search`; or run the same command again, which makes what is missing"
            }
            CorpusError::Refused { .. } | CorpusError::Encoding { .. } => "report it: this is a fault of the program",
        }
    }

    pub(super) fn io(path: &Path, doing: &'static str, source: io::Error) -> CorpusError {
        CorpusError::Io { path: path.to_owned(), doing, trouble: Trouble::of(&source), source }
    }

    pub(super) fn damaged(path: &Path, what: impl Into<String>) -> CorpusError {
        CorpusError::Damaged { path: path.to_owned(), what: what.into() }
    }

    /// Columns that make no table: a fault of ours.
    pub(super) fn batch(error: ArrowError) -> CorpusError {
        CorpusError::Encoding { path: PathBuf::from("columns"), what: error.to_string() }
    }

    /// An error met while writing a table: the disk's, if that is at the bottom of it.
    pub(super) fn while_writing(path: &Path, error: ParquetError) -> CorpusError {
        match error {
            ParquetError::External(inner) => match inner.downcast::<io::Error>() {
                Ok(source) => CorpusError::io(path, "writing", *source),
                Err(other) => CorpusError::Encoding { path: path.to_owned(), what: other.to_string() },
            },
            other => CorpusError::Encoding { path: path.to_owned(), what: other.to_string() },
        }
    }
}

impl Trouble {
    fn of(error: &io::Error) -> Trouble {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Trouble::DiskFull,
            io::ErrorKind::ReadOnlyFilesystem => Trouble::ReadOnly,
            io::ErrorKind::PermissionDenied => Trouble::Permission,
            io::ErrorKind::NotFound => Trouble::Missing,
            _ => Trouble::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_named_through_the_encoder() {
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let error = CorpusError::while_writing(Path::new("out/clips.parquet"), ParquetError::External(Box::new(full)));
        assert_eq!(error.to_string(), "out/clips.parquet: the disk is full while writing");
        assert!(error.remedy().contains("make room"));
        let odd = CorpusError::while_writing(Path::new("x"), ParquetError::General("odd".to_owned()));
        assert!(matches!(odd, CorpusError::Encoding { .. }));
    }
}
