//! Walking a folder: every file below it, in a fixed order, whatever links and permissions do.

use super::names::text_of;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// A file below the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Walked {
    /// Path from the folder, links not resolved.
    pub(crate) below: PathBuf,
    /// Size.
    pub(crate) bytes: u64,
}

/// Something below the folder that could not be looked at.
#[derive(Debug)]
pub(crate) struct Obstacle {
    /// Path from the folder; empty: the folder itself.
    pub(crate) below: PathBuf,
    pub(crate) kind: ObstacleKind,
}

/// Why.
#[derive(Debug)]
pub(crate) enum ObstacleKind {
    /// A folder that can't be listed.
    Folder(io::Error),
    /// An entry whose kind or size can't be had, such as a link to nothing.
    Entry(io::Error),
    /// A pipe, socket or device: reading it could wait forever.
    Special,
    /// A link to a folder that is walked already, or to one that holds the whole folder.
    Loop,
}

/// What a folder holds.
#[derive(Debug, Default)]
pub(crate) struct Walk {
    pub(crate) files: Vec<Walked>,
    pub(crate) obstacles: Vec<Obstacle>,
}

/// Names and kinds of a folder's entries, in any order.
type Entries = Vec<(OsString, io::Result<fs::FileType>)>;

/// Walks all folders below `root`, real ones before linked ones, each once. `wanted` says by its name whether a
/// file matters; hidden entries never do.
pub(crate) fn walk(root: &Path, wanted: impl Fn(&OsStr) -> bool) -> Walk {
    walk_with(root, wanted, list)
}

fn walk_with(root: &Path, wanted: impl Fn(&OsStr) -> bool, list: impl Fn(&Path) -> io::Result<Entries>) -> Walk {
    let mut walk = Walk::default();
    let canonical_root = match fs::canonicalize(root) {
        Ok(path) => path,
        Err(error) => {
            walk.obstacles.push(Obstacle { below: PathBuf::new(), kind: ObstacleKind::Folder(error) });
            return walk;
        }
    };
    let mut seen = BTreeSet::from([canonical_root.clone()]);
    let mut folders = VecDeque::from([(PathBuf::new(), canonical_root.clone())]);
    let mut links: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    loop {
        while let Some((below, canonical)) = folders.pop_front() {
            let mut entries = match list(&canonical) {
                Ok(entries) => entries,
                Err(error) => {
                    walk.obstacles.push(Obstacle { below, kind: ObstacleKind::Folder(error) });
                    continue;
                }
            };
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            for (name, kind) in entries.into_iter().filter(|(name, _)| !is_hidden(name)) {
                let (below, canonical) = (below.join(&name), canonical.join(&name));
                match kind {
                    Ok(kind) if kind.is_dir() => {
                        if seen.insert(canonical.clone()) {
                            folders.push_back((below, canonical));
                        }
                    }
                    Ok(kind) if kind.is_symlink() => match fs::metadata(&canonical) {
                        Ok(target) if target.is_dir() => {
                            links.insert(below, canonical);
                        }
                        Ok(target) if wanted(&name) => walk.file(below, Ok(target)),
                        Ok(_) => {}
                        Err(error) => walk.file(below, Err(error)),
                    },
                    Ok(_) if wanted(&name) => walk.file(below, fs::metadata(&canonical)),
                    Ok(_) => {}
                    Err(error) => walk.file(below, Err(error)),
                }
            }
        }
        // Links wait until no real folder is left, so that a folder is known by its real name.
        let Some((below, link)) = links.pop_first() else { return walk };
        match fs::canonicalize(&link) {
            Ok(target) if canonical_root.starts_with(&target) || !seen.insert(target.clone()) => {
                walk.obstacles.push(Obstacle { below, kind: ObstacleKind::Loop });
            }
            Ok(target) => folders.push_back((below, target)),
            Err(error) => walk.obstacles.push(Obstacle { below, kind: ObstacleKind::Folder(error) }),
        }
    }
}

impl Walk {
    fn file(&mut self, below: PathBuf, metadata: io::Result<fs::Metadata>) {
        match metadata {
            Ok(metadata) if metadata.is_file() => self.files.push(Walked { below, bytes: metadata.len() }),
            Ok(_) => self.obstacles.push(Obstacle { below, kind: ObstacleKind::Special }),
            Err(error) => self.obstacles.push(Obstacle { below, kind: ObstacleKind::Entry(error) }),
        }
    }
}

fn list(folder: &Path) -> io::Result<Entries> {
    fs::read_dir(folder)?.map(|entry| entry.map(|entry| (entry.file_name(), entry.file_type()))).collect()
}

fn is_hidden(name: &OsStr) -> bool {
    text_of(name).starts_with('.')
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn below(walk: &Walk) -> Vec<String> {
        walk.files.iter().map(|file| file.below.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_folder_that_cannot_be_listed_is_an_obstacle_and_the_rest_is_walked() {
        let root = tempfile::tempdir().unwrap();
        for file in ["a/1.bvh", "closed/2.bvh", "z/3.bvh"] {
            fs::create_dir_all(root.path().join(file).parent().unwrap()).unwrap();
            fs::write(root.path().join(file), "x").unwrap();
        }
        let closed = |folder: &Path| match folder.ends_with("closed") {
            true => Err(io::Error::from(io::ErrorKind::PermissionDenied)),
            false => list(folder),
        };
        let walk = walk_with(root.path(), |_| true, closed);
        assert_eq!(below(&walk), ["a/1.bvh", "z/3.bvh"]);
        assert!(
            matches!(&walk.obstacles[..], [Obstacle { below, kind: ObstacleKind::Folder(_) }] if below == Path::new("closed"))
        );
    }

    #[test]
    fn the_order_of_the_listing_does_not_matter() {
        let root = tempfile::tempdir().unwrap();
        for file in ["b.bvh", "a/1.bvh", "a/0.bvh", "c/d/4.bvh"] {
            fs::create_dir_all(root.path().join(file).parent().unwrap()).unwrap();
            fs::write(root.path().join(file), "x").unwrap();
        }
        let forwards = |folder: &Path| {
            list(folder).map(|mut entries| {
                entries.sort_by(|a, b| a.0.cmp(&b.0));
                entries
            })
        };
        let backwards = |folder: &Path| {
            forwards(folder).map(|mut entries| {
                entries.reverse();
                entries
            })
        };
        let one = walk_with(root.path(), |_| true, forwards);
        let other = walk_with(root.path(), |_| true, backwards);
        assert_eq!(one.files, other.files);
        assert_eq!(below(&one), ["b.bvh", "a/0.bvh", "a/1.bvh", "c/d/4.bvh"]);
    }
}
