//! Files of truth about clips, and which clip each of them is about.

use super::names::path_text;
use super::walk::{ObstacleKind, walk};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What the name of such a file ends in, behind the name of its clip.
pub const TRUTH_SUFFIX: &str = ".truth.csv";

/// The files of truth below a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TruthFiles {
    /// `[clip]`: its file, if it has one.
    pub of_clip: Vec<Option<PathBuf>>,
    /// Files that are about none of the clips, sorted.
    pub unused: Vec<PathBuf>,
    /// How many files of truth there are.
    pub n_files: usize,
}

/// Why it can't be told which file is about which clip.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TruthFileError {
    /// Nothing there, or not to be looked at.
    #[error("{path} can't be read: {reason}")]
    Absent {
        /// The folder, as the user named it, or one below it.
        path: String,
        /// The system's words.
        reason: String,
    },
    /// Something that is called as a file of truth and is none: a link to nothing, a pipe.
    #[error("{path} is no file that can be read: {reason}")]
    NoFile {
        /// Where it is.
        path: String,
        /// The system's words, or what it is.
        reason: String,
    },
    /// Several files fit a clip equally well.
    #[error("{} and {} are both called as clip {clip}", files[0], files[1])]
    SeveralFiles {
        /// Its full name.
        clip: String,
        /// The first two.
        files: [String; 2],
    },
    /// A file fits several clips equally well.
    #[error("{file} is called as clips {} and {}", clips[0], clips[1])]
    SeveralClips {
        /// The file.
        file: String,
        /// The first two, by their full names.
        clips: [String; 2],
    },
}

/// Finds the file of each clip, at any depth below the folder: `source/name.truth.csv`, failing that `name.truth.csv`,
/// failing that the last component of the name. A file that is one clip's by a longer name is no other's by a shorter.
///
/// `clips`: source and name of each, of all that there are: which file a clip gets depends on the others. `matters` says
/// of which it must be certain; where it isn't certain of another, that one gets none.
///
/// # Errors
/// [`TruthFileError`].
pub fn find_truth_files(
    folder: &Path,
    clips: &[(&str, &str)],
    matters: impl Fn(usize) -> bool,
) -> Result<TruthFiles, TruthFileError> {
    let files = truth_files_below(folder)?;
    let mut by_last: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (at, (text, _)) in files.iter().enumerate() {
        by_last.entry(last_component(stem(text))).or_default().push(at);
    }
    let mut file_of_clip: Vec<Option<usize>> = vec![None; clips.len()];
    // Clips whose search has ended, and files that some clip is called as.
    let (mut settled, mut taken) = (vec![false; clips.len()], BTreeSet::new());
    let shown = |at: usize| folder.join(&files[at].1).display().to_string();
    let full_name = |clip: usize| format!("{}/{}", clips[clip].0, clips[clip].1);
    let rules: [fn(&str, &str) -> String; 3] = [
        |source, name| format!("{source}/{name}"),
        |_, name| name.to_owned(),
        |_, name| last_component(name).to_owned(),
    ];
    for rule in rules {
        let mut clips_of_file: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut doubtful = Vec::new();
        for (clip, (source, name)) in clips.iter().enumerate().filter(|&(clip, _)| !settled[clip]) {
            let wanted = rule(source, name);
            let called = by_last.get(last_component(&wanted)).into_iter().flatten().copied();
            let fits: Vec<usize> =
                called.filter(|at| !taken.contains(at) && is_called(stem(&files[*at].0), &wanted)).collect();
            match fits[..] {
                [] => {}
                [file] => clips_of_file.entry(file).or_default().push(clip),
                [first, second, ..] if matters(clip) => {
                    let files = [shown(first), shown(second)];
                    return Err(TruthFileError::SeveralFiles { clip: full_name(clip), files });
                }
                _ => doubtful.push((clip, fits)),
            }
        }
        for (file, of_file) in clips_of_file {
            match of_file[..] {
                [clip] => file_of_clip[clip] = Some(file),
                [first, second, ..] => {
                    if let Some(&clip) = of_file.iter().find(|&&clip| matters(clip)) {
                        let other = if clip == first { second } else { first };
                        let clips = [full_name(clip.min(other)), full_name(clip.max(other))];
                        return Err(TruthFileError::SeveralClips { file: shown(file), clips });
                    }
                }
                [] => {}
            }
            of_file.iter().for_each(|&clip| settled[clip] = true);
            taken.insert(file);
        }
        for (clip, fits) in doubtful {
            settled[clip] = true;
            taken.extend(fits);
        }
    }
    let path = |at: usize| folder.join(&files[at].1);
    Ok(TruthFiles {
        of_clip: file_of_clip.iter().map(|file| file.map(path)).collect(),
        unused: (0..files.len()).filter(|at| !taken.contains(at)).map(path).collect(),
        n_files: files.len(),
    })
}

/// Their paths from the folder, as text and as they are, sorted.
fn truth_files_below(folder: &Path) -> Result<Vec<(String, PathBuf)>, TruthFileError> {
    let walked = walk(folder, |name| name.to_string_lossy().ends_with(TRUTH_SUFFIX));
    for obstacle in &walked.obstacles {
        let below = &obstacle.below;
        let path = if below.as_os_str().is_empty() { folder.to_owned() } else { folder.join(below) };
        let path = path.display().to_string();
        let is_truth = path_text(below).ends_with(TRUTH_SUFFIX);
        match &obstacle.kind {
            ObstacleKind::Folder(error) => return Err(TruthFileError::Absent { path, reason: error.to_string() }),
            ObstacleKind::Entry(error) if is_truth => {
                return Err(TruthFileError::NoFile { path, reason: error.to_string() });
            }
            ObstacleKind::Special if is_truth => {
                return Err(TruthFileError::NoFile { path, reason: "a pipe, socket or device".to_owned() });
            }
            // Links that were not truth, or to folders that are walked already.
            ObstacleKind::Entry(_) | ObstacleKind::Special | ObstacleKind::Loop => {}
        }
    }
    let mut files: Vec<(String, PathBuf)> =
        walked.files.into_iter().map(|file| (path_text(&file.below), file.below)).collect();
    files.sort();
    Ok(files)
}

/// Whether a path ends in a name, at the border of a folder.
fn is_called(path: &str, name: &str) -> bool {
    path.strip_suffix(name).is_some_and(|before| before.is_empty() || before.ends_with('/'))
}

fn stem(path: &str) -> &str {
    path.strip_suffix(TRUTH_SUFFIX).unwrap_or(path)
}

fn last_component(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use std::fs;

    fn found(files: &[&str], clips: &[(&str, &str)]) -> Result<Vec<String>, String> {
        found_for(files, clips, |_| true)
    }

    fn found_for(
        files: &[&str],
        clips: &[(&str, &str)],
        matters: impl Fn(usize) -> bool,
    ) -> Result<Vec<String>, String> {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let root = format!("{}/", folder.path().display());
        let short = |path: &PathBuf| path.display().to_string().replace(&root, "");
        match find_truth_files(folder.path(), clips, matters) {
            Ok(found) => {
                let mut names: Vec<String> =
                    found.of_clip.iter().map(|file| file.as_ref().map_or("-".to_owned(), short)).collect();
                names.extend(found.unused.iter().map(|file| format!("unused {}", short(file))));
                Ok(names)
            }
            Err(error) => Err(error.to_string().replace(&root, "")),
        }
    }

    #[test]
    fn the_longest_name_that_fits_counts() {
        let clips = [("a", "p/walk"), ("b", "walk"), ("b", "run"), ("b", "jump")];
        let files = ["p/walk.truth.csv", "b/walk.truth.csv", "x/y/run.truth.csv", "run.csv", "hop.truth.csv"];
        assert_eq!(
            found(&files, &clips).unwrap(),
            ["p/walk.truth.csv", "b/walk.truth.csv", "x/y/run.truth.csv", "-", "unused hop.truth.csv"]
        );
        // The only file is that of the clip whose whole name it has.
        assert_eq!(
            found(&["p/walk.truth.csv"], &[("a", "p/walk"), ("a", "q/walk")]).unwrap(),
            ["p/walk.truth.csv", "-"]
        );
        // `bwalk` is not called `walk`.
        assert_eq!(found(&["bwalk.truth.csv"], &[("b", "walk")]).unwrap(), ["-", "unused bwalk.truth.csv"]);
    }

    #[test]
    fn what_can_mean_two_is_an_error() {
        assert_eq!(
            found(&["walk.truth.csv", "old/walk.truth.csv"], &[("a", "walk")]).unwrap_err(),
            "old/walk.truth.csv and walk.truth.csv are both called as clip a/walk"
        );
        assert_eq!(
            found(&["walk.truth.csv"], &[("a", "p/walk"), ("a", "q/walk")]).unwrap_err(),
            "walk.truth.csv is called as clips a/p/walk and a/q/walk"
        );
        assert!(find_truth_files(Path::new("no/such/folder"), &[], |_| true).is_err());
    }

    #[test]
    fn doubt_about_clips_that_do_not_matter_gives_their_files_to_no_other() {
        let clips = [("a", "p/walk"), ("a", "q/walk"), ("b", "x/walk"), ("b", "run")];
        let files = ["b/x/walk.truth.csv", "walk.truth.csv", "run.truth.csv", "old/run.truth.csv"];
        // The file with the long name is its own clip's, also if only that of the others matters.
        let error = "walk.truth.csv is called as clips a/p/walk and a/q/walk";
        assert_eq!(found_for(&files, &clips, |clip| clip == 1).unwrap_err(), error);
        assert_eq!(found_for(&files, &clips, |clip| clip == 2).unwrap(), ["-", "-", "b/x/walk.truth.csv", "-"]);
        let error = "old/run.truth.csv and run.truth.csv are both called as clip b/run";
        assert_eq!(found_for(&files, &clips, |clip| clip == 3).unwrap_err(), error);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_called_as_truth_and_is_no_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("nowhere", folder.path().join("walk.bvh")).unwrap();
        assert_eq!(find_truth_files(folder.path(), &[("a", "walk")], |_| true).unwrap().n_files, 0);
        std::os::unix::fs::symlink("nowhere", folder.path().join("walk.truth.csv")).unwrap();
        let error = find_truth_files(folder.path(), &[("a", "walk")], |_| true).unwrap_err();
        assert!(matches!(&error, TruthFileError::NoFile { path, .. } if path.ends_with("walk.truth.csv")), "{error}");
        fs::remove_file(folder.path().join("walk.truth.csv")).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(folder.path().join("run.truth.csv")).unwrap();
        let error = find_truth_files(folder.path(), &[], |_| true).unwrap_err().to_string();
        assert!(error.ends_with("run.truth.csv is no file that can be read: a pipe, socket or device"), "{error}");
    }
}
