//! Where the truth about each clip of a corpus comes from: files, the program's own people, names.

use super::args::Evaluate;
use super::output::Refusal;
use crate::annotate::Gait;
use crate::corpus::{ClipRow, Manifest, Origin};
use crate::evaluate::{FrameTruth, NameRules, read_truth_csv};
use crate::flow::noted_plan;
use crate::inputs::{TruthFileError, TruthFiles, find_truth_files};
use crate::motion::Format;
use crate::plan::load_name_rules;
use crate::procedural::{self, ClipSpec};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// No table of truth is larger, bytes: some ten million frames.
const MAX_TRUTH_BYTES: u64 = 256 << 20;

/// Truth about the clips of a corpus, as far as there is some. That of frames is read or made when it is asked for.
pub(super) struct Truths {
    files: Option<TruthFiles>,
    people: BTreeMap<String, ClipSpec>,
    /// How the people were made, in words.
    settings: String,
    rules: Option<NameRules>,
}

impl Truths {
    /// Finds what the arguments name. `clips` are all that were not made here; `matters` says which of them are to be
    /// compared: files are matched to all, so that a clip has the same truth whichever others are compared.
    pub(super) fn find(
        args: &Evaluate,
        manifest: &Manifest,
        clips: &[ClipRow],
        matters: &[bool],
    ) -> Result<Truths, Refusal> {
        let rules = args.names.as_deref().map(load_name_rules).transpose()?;
        let names: Vec<(&str, &str)> = clips.iter().map(|clip| (clip.source.as_str(), clip.name.as_str())).collect();
        let find = |folder: &PathBuf| find_truth_files(folder, &names, |clip| matters[clip]).map_err(refusal);
        let files = args.truth.as_ref().map(find).transpose()?;
        let mut truths = Truths { files, people: BTreeMap::new(), settings: String::new(), rules };
        if args.procedural && (clips.iter().zip(matters)).any(|(clip, &is)| is && clip.origin == Origin::Procedural) {
            let plan = noted_plan(manifest).ok_or_else(|| {
                Refusal::new(
                    format!("{}: it does not say how it was made", args.corpus.display()),
                    "the program's people are made again by the settings of the corpus' last run",
                    "--truth with the folder of the captures, where their truth lies too",
                )
            })?;
            let settings = plan.config.procedural;
            truths.settings = format!("procedural.clips = {}, procedural.seed = {}", settings.clips, settings.seed);
            truths.people = procedural::corpus(settings.clips as usize, settings.seed)
                .into_iter()
                .map(|spec| (format!("{}/{}", spec.subject.name, spec.name), spec))
                .collect();
        }
        Ok(truths)
    }

    /// Whether there is truth about the frames of a clip; `at` is its place among those given to [`Truths::find`].
    pub(super) fn has_frames(&self, at: usize, clip: &ClipRow) -> bool {
        self.file(at).is_some() || self.spec(clip).is_some()
    }

    /// Truth about the frames of a clip: its file's, failing that the made person's.
    pub(super) fn frames(&self, at: usize, clip: &ClipRow) -> Result<Option<FrameTruth>, Refusal> {
        let frames = clip.frames as usize;
        let full_name = clip.full_name();
        if let Some(file) = self.file(at) {
            let truth = read_file(file)?;
            return match truth.n_frames == frames {
                true => Ok(Some(truth)),
                false => Err(Refusal::new(
                    format!("{}: rows for {} frames, clip {full_name} has {frames}", file.display(), truth.n_frames),
                    "a row is about a frame: this is the truth of another clip, or of this one at another rate",
                    format!("a row for each of its frames, at {} Hz", clip.rate_hz),
                )),
            };
        }
        let Some(spec) = self.spec(clip) else { return Ok(None) };
        let made = procedural::make(spec, Format::Amc);
        match made {
            Ok(made) if made.clip.n_frames == frames && made.clip.rate_hz == clip.rate_hz => {
                Ok(Some(FrameTruth::from(&made.truth)))
            }
            _ => Err(Refusal::new(
                format!("{full_name}: made again it is another clip than in the corpus"),
                format!(
                    "this program makes it otherwise than the one that made it, or by other settings: {}",
                    self.settings
                ),
                "the run's command once more; or --truth with the folder of its captures",
            )),
        }
    }

    /// Truth about a clip as a whole by its name. None: nobody knows.
    pub(super) fn class_by_name(&self, clip: &ClipRow) -> Option<Gait> {
        self.rules.as_ref()?.class_of(&clip.full_name())
    }

    /// Whether classes come from names; else they come from frames.
    pub(super) fn has_rules(&self) -> bool {
        self.rules.is_some()
    }

    /// Whether there is any file of truth.
    pub(super) fn has_files(&self) -> bool {
        self.files.as_ref().is_some_and(|files| files.n_files > 0)
    }

    /// Files that are about no clip.
    pub(super) fn unused(&self) -> &[PathBuf] {
        self.files.as_ref().map_or(&[], |files| &files.unused)
    }

    fn file(&self, at: usize) -> Option<&Path> {
        self.files.as_ref()?.of_clip.get(at)?.as_deref()
    }

    fn spec(&self, clip: &ClipRow) -> Option<&ClipSpec> {
        self.people.get(&clip.name).filter(|_| clip.origin == Origin::Procedural)
    }
}

fn read_file(path: &Path) -> Result<FrameTruth, Refusal> {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_TRUTH_BYTES + 1).read_to_end(&mut bytes));
    if let Err(error) = read {
        let what = format!("{}: {error}", path.display());
        return Err(Refusal::new(what, "it holds the truth about a clip", "a file that can be read"));
    }
    if bytes.len() as u64 > MAX_TRUTH_BYTES {
        let what = format!("{}: more than {MAX_TRUTH_BYTES} bytes", path.display());
        return Err(Refusal::new(what, "no clip has so many frames", "most likely this is another file"));
    }
    read_truth_csv(&bytes).map_err(|error| {
        let line = error.line.map_or(String::new(), |line| format!(":{line}"));
        let what = format!("{}{line}: {}", path.display(), error.mistake);
        Refusal::new(what, error.mistake.why(), error.mistake.remedy())
    })
}

fn refusal(error: TruthFileError) -> Refusal {
    let what = error.to_string();
    match error {
        TruthFileError::Absent { .. } => Refusal::new(
            what,
            "files of truth are looked for there",
            "--truth with a folder that holds NAME.truth.csv for a clip called NAME",
        )
        .in_arguments(),
        TruthFileError::NoFile { .. } => {
            Refusal::new(what, "it is called as a file of truth", "a file in its place, or take it away")
        }
        TruthFileError::SeveralFiles { files, .. } => {
            Refusal::new(what, "it can't be told which of them is its truth", format!("move {} away", files[0]))
        }
        TruthFileError::SeveralClips { clips, .. } => Refusal::new(
            what,
            "it can't be told which of them it is about",
            format!("its full name, {}.truth.csv in folders", clips[0]),
        ),
    }
}
