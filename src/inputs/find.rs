//! The list of inputs: every clip below the input folders, with its name, skeleton and settings.

use super::names::{clip_names, path_text, text_of};
use super::pairing::{Pairing, pair};
use super::settings::{InputRules, SourceRule, SourceSettings, fits_name};
use super::walk::{Obstacle, ObstacleKind, Walk, Walked, walk};
use crate::motion::{Format, Notice, Severity};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// A clip to read.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Label of its source.
    pub source: String,
    /// Unique within the source.
    pub name: String,
    /// Where it lies.
    pub path: PathBuf,
    /// What it is, by its extension.
    pub kind: Format,
    /// The skeleton of an AMC.
    pub asf: Option<PathBuf>,
    /// Size of the file.
    pub bytes: u64,
    /// What the config says of it.
    pub settings: SourceSettings,
}

/// A notice about a clip, or about a folder (its name ends in `/`).
#[derive(Clone, Debug, PartialEq)]
pub struct InputNotice {
    /// Label of the source.
    pub source: String,
    /// Clip or folder.
    pub name: String,
    /// What there is to say.
    pub notice: Notice,
}

/// An input folder and its label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputSource {
    /// Unique among the sources of a run.
    pub label: String,
    /// As the user named it; for single files the folder that they are in.
    pub folder: PathBuf,
}

/// Clips that can't be called gone: what is there could not be seen, or can't be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsure {
    /// Label of the source.
    pub source: String,
    /// A clip's path without extension, or a folder's.
    pub below: String,
}

/// All that the input folders hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Clips that can be read, by (source, name).
    pub inputs: Vec<Input>,
    /// Notes, warnings and faults, by (source, name). A fault's clip is not among the inputs.
    pub notices: Vec<InputNotice>,
    /// The folders, by label.
    pub sources: Vec<InputSource>,
    /// What could not be looked at.
    pub unsure: Vec<Unsure>,
    /// Clips left out by `skip`.
    pub skipped: usize,
}

/// An input that can't be walked at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// Nothing there, or not to be looked at.
    #[error("input {path} can't be read: {reason}")]
    Absent {
        /// As the user named it.
        path: String,
        /// The system's words.
        reason: String,
    },
    /// A file of another kind.
    #[error("input {path} is neither a folder nor a .bvh or .amc file")]
    NotAClip {
        /// As the user named it.
        path: String,
    },
    /// Two folders would be one source.
    #[error("inputs {} and {} are both called `{label}`", paths[0], paths[1])]
    SameLabel {
        /// Of both.
        label: String,
        /// As the user named them.
        paths: [String; 2],
    },
}

/// Finds every `.bvh` and `.amc` below the folders (or named as single files), in any case, with the skeletons of the latter.
///
/// The result depends on neither the order of the folders nor of their entries. Hidden entries are passed over.
/// Clips above `max_clip_bytes`, and AMC files without a skeleton, become faults.
///
/// # Errors
/// [`InputError`] for every input that is not there or is no motion.
pub fn find_inputs(inputs: &[PathBuf], rules: &InputRules, max_clip_bytes: u64) -> Result<Found, Vec<InputError>> {
    let mut found = Found::default();
    let mut names = Vec::new();
    for (root, source) in labelled(roots(inputs)?, rules)? {
        let rule = rules.rule_of_folder(&root.path());
        let mut search = Search { root: &root, source: &source, rule, rules, found: &mut found };
        names.extend(search.take(root.walk(), max_clip_bytes).into_iter().map(|name| (source.clone(), name)));
        found.sources.push(InputSource { label: source, folder: root.given });
    }
    found.notices.extend(unused_rules(rules, &names));
    found.inputs.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    found.notices.sort_by(|a, b| (&a.source, &a.name, &a.notice.kind).cmp(&(&b.source, &b.name, &b.notice.kind)));
    Ok(found)
}

impl Unsure {
    /// Whether that clip may be there after all.
    pub fn covers(&self, source: &str, name: &str) -> bool {
        let below = self.below.as_str();
        let inside = || name.strip_prefix(below).is_some_and(|rest| rest.starts_with('/'));
        self.source == source && (below.is_empty() || name == below || inside())
    }
}

/// An input folder, or some files of one.
struct Root {
    given: PathBuf,
    canonical: PathBuf,
    /// None: all of the folder.
    only: Option<BTreeSet<PathBuf>>,
}

/// Folders named twice are one; so are single files of one folder.
fn roots(inputs: &[PathBuf]) -> Result<Vec<Root>, Vec<InputError>> {
    let mut roots: BTreeMap<PathBuf, Root> = BTreeMap::new();
    let mut errors = Vec::new();
    for given in inputs {
        match root_of(given) {
            Err(error) => errors.push(error),
            Ok(new) => match roots.get_mut(&new.canonical) {
                None => {
                    roots.insert(new.canonical.clone(), new);
                }
                Some(root) => {
                    root.given = new.given.min(root.given.clone());
                    root.only = match (root.only.take(), new.only) {
                        (Some(some), Some(more)) => Some(some.union(&more).cloned().collect()),
                        _ => None,
                    };
                }
            },
        }
    }
    if errors.is_empty() { Ok(roots.into_values().collect()) } else { Err(errors) }
}

fn root_of(given: &Path) -> Result<Root, InputError> {
    let path = given.display().to_string();
    let absent = |error: io::Error| InputError::Absent { path: path.clone(), reason: error.to_string() };
    if fs::metadata(given).map_err(absent)?.is_dir() {
        return Ok(Root { given: given.to_owned(), canonical: fs::canonicalize(given).map_err(absent)?, only: None });
    }
    let (Some(name), Some(_), Some(parent)) = (given.file_name(), kind_of(given), given.parent()) else {
        return Err(InputError::NotAClip { path });
    };
    let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    let canonical = fs::canonicalize(folder).map_err(absent)?;
    Ok(Root { given: folder.to_owned(), canonical, only: Some(BTreeSet::from([PathBuf::from(name)])) })
}

/// The folders with their labels, by label.
///
/// Equal ones are refused: numbered, they would depend on where the folders lie and which of them a run names.
fn labelled(roots: Vec<Root>, rules: &InputRules) -> Result<Vec<(Root, String)>, Vec<InputError>> {
    let label = |root: &Root| {
        let own = rules.rule_of_folder(&root.path()).and_then(|rule| rule.label.clone());
        own.unwrap_or_else(|| root.name())
    };
    let mut labelled: Vec<(String, Root)> = roots.into_iter().map(|root| (label(&root), root)).collect();
    labelled.sort_by(|a, b| (&a.0, &a.1.given).cmp(&(&b.0, &b.1.given)));
    let given = |root: &Root| root.given.display().to_string();
    let equal = labelled.windows(2).filter(|two| two[0].0 == two[1].0);
    let errors: Vec<InputError> = equal
        .map(|two| InputError::SameLabel { label: two[0].0.clone(), paths: [given(&two[0].1), given(&two[1].1)] })
        .collect();
    if errors.is_empty() { Ok(labelled.into_iter().map(|(label, root)| (root, label)).collect()) } else { Err(errors) }
}

impl Root {
    /// The folder's name, as the user knows it.
    fn name(&self) -> String {
        let name = self.given.file_name().or_else(|| self.canonical.file_name());
        name.map_or_else(|| "inputs".to_owned(), text_of)
    }

    /// The folder as rules name it: with `/`, and its last part as [`Root::name`].
    fn path(&self) -> String {
        let above = self.given.parent().map(path_text).filter(|above| !above.is_empty());
        above.map_or_else(|| self.name(), |above| format!("{above}/{}", self.name()))
    }

    fn walk(&self) -> Walk {
        let walked = walk(&self.given, |name| kind_of(Path::new(name)).is_some() || is_asf(Path::new(name)));
        let Some(only) = &self.only else { return walked };
        // Single files: these, and whatever skeletons lie beside them.
        let beside = |below: &Path| below.parent() == Some(Path::new(""));
        let files = walked
            .files
            .into_iter()
            .filter(|file| only.contains(&file.below) || is_asf(&file.below) && beside(&file.below));
        let obstacles = walked.obstacles.into_iter().filter(|obstacle| only.contains(&obstacle.below));
        Walk { files: files.collect(), obstacles: obstacles.collect() }
    }
}

/// The search through one input folder.
struct Search<'a> {
    root: &'a Root,
    source: &'a str,
    rule: Option<&'a SourceRule>,
    rules: &'a InputRules,
    found: &'a mut Found,
}

/// ASF files of one folder: stems and paths, in one order.
#[derive(Default)]
struct Skeletons {
    stems: Vec<String>,
    paths: Vec<PathBuf>,
}

impl Search<'_> {
    /// Sorts the files into inputs and notices; gives the names of all clips, used or not.
    fn take(&mut self, walked: Walk, max_clip_bytes: u64) -> Vec<String> {
        let Walk { mut files, obstacles } = walked;
        files.sort_by(|a, b| a.below.cmp(&b.below));
        let mut skeletons: BTreeMap<PathBuf, Skeletons> = BTreeMap::new();
        for file in files.iter().filter(|file| is_asf(&file.below)) {
            let beside = skeletons.entry(folder_of(&file.below)).or_default();
            beside.stems.push(stem_of(&file.below));
            beside.paths.push(self.root.given.join(&file.below));
        }
        let clips: Vec<(Walked, Format)> =
            files.into_iter().filter_map(|file| kind_of(&file.below).map(|kind| (file, kind))).collect();
        let names = clip_names(&clips.iter().map(|(file, _)| file.below.as_path()).collect::<Vec<_>>());
        for ((file, kind), name) in clips.iter().zip(&names) {
            if self.rules.skips(name) {
                self.found.skipped += 1;
                continue;
            }
            if file.bytes > max_clip_bytes {
                self.refuse(name, too_large(file.bytes, max_clip_bytes));
                continue;
            }
            let asf = match kind {
                Format::Bvh => None,
                Format::Amc => match self.skeleton(file, name, &skeletons) {
                    Ok(path) => Some(path),
                    Err(notice) => {
                        self.refuse(name, notice);
                        continue;
                    }
                },
            };
            self.found.inputs.push(Input {
                source: self.source.to_owned(),
                name: name.clone(),
                path: self.root.given.join(&file.below),
                kind: *kind,
                asf,
                bytes: file.bytes,
                settings: self.rules.resolve(self.rule, self.source, name),
            });
        }
        for obstacle in obstacles {
            self.meet(&obstacle);
        }
        names
    }

    /// The clip's own rule first, since it is the user's word; then names; then the source's rule.
    fn skeleton(
        &mut self,
        file: &Walked,
        name: &str,
        skeletons: &BTreeMap<PathBuf, Skeletons>,
    ) -> Result<PathBuf, Notice> {
        let fitting = self.rules.clips.iter().rev().filter(|rule| rule.fits(self.source, name));
        if let Some(named) = fitting.filter_map(|rule| rule.asf.as_deref()).next() {
            return self.named_skeleton(file, named);
        }
        let folder = folder_of(&file.below);
        if let Some(beside) = skeletons.get(&folder)
            && let Some((index, how)) = pair(&stem_of(&file.below), &beside.stems)
        {
            if how == Pairing::OnlyOne {
                self.note_guess(&folder, &beside.paths[index]);
            }
            return Ok(beside.paths[index].clone());
        }
        match self.rule.and_then(|rule| rule.asf.as_deref()) {
            Some(named) => self.named_skeleton(file, named),
            None => Err(skeleton_absent(file, skeletons.get(&folder))),
        }
    }

    fn named_skeleton(&self, file: &Walked, named: &str) -> Result<PathBuf, Notice> {
        let path = self.root.given.join(named);
        if path.is_file() {
            return Ok(path);
        }
        Err(notice(
            Severity::Fault,
            "skeleton-absent",
            format!("{} needs {named}, which is not in the input folder", path_text(&file.below)),
            "an AMC holds angles only; bones and axes are in the ASF, so the clip is left out",
            "mend `asf` in your config: a path from the input folder",
        ))
    }

    /// One note a folder.
    fn note_guess(&mut self, folder: &Path, asf: &Path) {
        let asf = asf.file_name().map_or_else(String::new, text_of);
        let name = format!("{}/", path_text(folder));
        let kind = "skeleton-guessed";
        let same =
            |other: &&mut InputNotice| other.source == self.source && other.name == name && other.notice.kind == kind;
        if let Some(known) = self.found.notices.iter_mut().find(same) {
            known.notice.count += 1;
            return;
        }
        let note = notice(
            Severity::Note,
            kind,
            // Names below the input folder only: where that lies must not show in the tables.
            format!("AMC files without an ASF of their name take {asf}, the only one in the folder"),
            "a wrong skeleton gives wrong poses",
            "if it is another body's, name the right one as `asf` in a [[clip]] of your config",
        );
        self.found.notices.push(InputNotice { source: self.source.to_owned(), name, notice: note });
    }

    fn refuse(&mut self, name: &str, notice: Notice) {
        self.found.unsure.push(Unsure { source: self.source.to_owned(), below: name.to_owned() });
        self.found.notices.push(InputNotice { source: self.source.to_owned(), name: name.to_owned(), notice });
    }

    fn meet(&mut self, obstacle: &Obstacle) {
        let below = path_text(&obstacle.below);
        let (name, notice) = match &obstacle.kind {
            ObstacleKind::Folder(error) => (
                format!("{below}/"),
                notice(
                    Severity::Fault,
                    "folder-unreadable",
                    format!("folder {below}/ can't be listed: {error}"),
                    "clips in it are left out; the others go on",
                    "give permission to read it, or move it out of the input folder",
                ),
            ),
            ObstacleKind::Entry(error) => (
                below.clone(),
                notice(
                    Severity::Fault,
                    "file-unreadable",
                    format!("{below} can't be looked at: {error}"),
                    "without its bytes it is left out; the others go on",
                    "mend or remove it",
                ),
            ),
            ObstacleKind::Special => (
                below.clone(),
                notice(
                    Severity::Fault,
                    "not-a-file",
                    format!("{below} is a pipe, socket or device"),
                    "reading it could wait forever, so it is left out",
                    "put a regular file there",
                ),
            ),
            ObstacleKind::Loop => (
                format!("{below}/"),
                notice(
                    Severity::Note,
                    "folder-linked-again",
                    format!("{below} links to a folder that is walked already, or that holds the input folder"),
                    "following it would give every clip twice, or never end",
                    "nothing to do; remove the link to be rid of this note",
                ),
            ),
        };
        if !matches!(obstacle.kind, ObstacleKind::Loop) {
            let stem = path_text(&obstacle.below.with_extension(""));
            for below in BTreeSet::from([below, stem]) {
                self.found.unsure.push(Unsure { source: self.source.to_owned(), below });
            }
        }
        self.found.notices.push(InputNotice { source: self.source.to_owned(), name, notice });
    }
}

/// Rules that fit no clip are most likely mistyped.
fn unused_rules(rules: &InputRules, names: &[(String, String)]) -> Vec<InputNotice> {
    let sources: BTreeSet<&String> = names.iter().map(|(source, _)| source).collect();
    let clips = rules.clips.iter().filter(|rule| {
        // A rule for a source that is not looked through today may fit tomorrow.
        let here = rule.source.as_ref().is_none_or(|source| sources.contains(source));
        here && !names.iter().any(|(source, name)| rule.fits(source, name))
    });
    let skips = rules.inputs.skip.iter().filter(|pattern| !names.iter().any(|(_, name)| fits_name(pattern, name)));
    let note = |pattern: &String, what: &str| InputNotice {
        source: String::new(),
        name: pattern.clone(),
        notice: notice(
            Severity::Note,
            "rule-unused",
            format!("{what} \"{pattern}\" of the config fits no clip"),
            "a mistyped name would leave the clip as it is, without a word",
            "names are paths below the input folder without extension; `*` stands for anything",
        ),
    };
    clips.map(|rule| note(&rule.name, "[[clip]] name =")).chain(skips.map(|skip| note(skip, "skip"))).collect()
}

fn too_large(bytes: u64, limit: u64) -> Notice {
    notice(
        Severity::Fault,
        "clip-too-large",
        format!("{bytes} bytes, the limit is {limit}"),
        "a clip is held in memory while it is read, so it is left out",
        "cut it, or raise `max_clip_bytes` in [limits] of your config",
    )
}

fn skeleton_absent(file: &Walked, beside: Option<&Skeletons>) -> Notice {
    let stem = stem_of(&file.below);
    let wanted = match stem.rsplit_once('_') {
        Some((subject, _)) => format!("{stem}.asf or {subject}.asf"),
        None => format!("{stem}.asf"),
    };
    let others = match beside.map_or(0, |skeletons| skeletons.stems.len()) {
        0 => "no .asf".to_owned(),
        n => format!("{n} .asf files, none of its name,"),
    };
    notice(
        Severity::Fault,
        "skeleton-absent",
        format!("{}: {others} beside it", path_text(&file.below)),
        "an AMC holds angles only; bones and axes are in the ASF, so the clip is left out",
        &format!("put {wanted} into its folder, or name it as `asf` in a [[clip]] or [[source]] of your config"),
    )
}

fn notice(severity: Severity, kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    let (why, remedy) = (why.to_owned(), remedy.to_owned());
    Notice { severity, kind: kind.to_owned(), line: None, frame: None, count: 1, message, why, remedy }
}

fn kind_of(path: &Path) -> Option<Format> {
    let extension = path.extension()?;
    if extension.eq_ignore_ascii_case("bvh") {
        Some(Format::Bvh)
    } else if extension.eq_ignore_ascii_case("amc") {
        Some(Format::Amc)
    } else {
        None
    }
}

fn is_asf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("asf"))
}

fn stem_of(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, text_of)
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}
