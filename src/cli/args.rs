//! The command line's words: what each verb takes, and the help that teaches it.

use crate::plan::{Plan, PlanError};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Turns a folder of motion captures into a corpus: Parquet tables of every frame, a graph of where each clip
/// can turn into another, and new clips grafted from the ones that you have.
#[derive(Debug, Parser)]
#[command(name = "motionmill", version, max_term_width = 100, after_help = TOUR)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

const TOUR: &str = "Examples:
  motionmill run demo                                  a small corpus of its own, everything on it
  motionmill run enrich --input ~/mocap --out corpus   your captures
  motionmill inspect corpus                            what is in it, and what to distrust";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Mill captures into a corpus, as a pipeline says
    Run(Run),
    /// Show a corpus, or one clip of it
    Inspect(Inspect),
    /// Find clips by gait, confidence, length, name, source and origin
    Search(Search),
    /// Write clips of a corpus as BVH or AMC
    Export(Export),
    /// Make procedural captures, with the truth about every frame
    Synth(Synth),
    /// Compare labels with truth: contacts, strikes and lift-offs, gaits
    Evaluate(Evaluate),
    /// Validate a pipeline, a config and inputs without working
    Check(Check),
    /// Read every file of a corpus again and compare it with its record
    Verify(Verify),
    /// Make a grown corpus as if from nothing, out of what it holds
    Compact(Compact),
}

#[derive(Debug, Args, Clone)]
pub(crate) struct PlanArgs {
    /// A shipped pipeline (annotate, graph, enrich, demo) or a file of your own
    pub(crate) pipeline: String,
    /// A shipped config (default, cmu, bandai-namco) or a file of your own
    #[arg(long, short, value_name = "CONFIG")]
    pub(crate) config: Option<String>,
    /// Overrides one value: --set contacts.detector=thesis
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) sets: Vec<String>,
    /// A folder with captures; may be given several times
    #[arg(long, short, value_name = "DIR")]
    pub(crate) input: Vec<PathBuf>,
    /// Warnings become faults: a clip that deviates is left out
    #[arg(long)]
    pub(crate) strict: bool,
}

impl PlanArgs {
    /// The plan that they say.
    pub(crate) fn load(&self) -> Result<Plan, Vec<PlanError>> {
        let strict = self.strict.then(|| "ingest.strict=true".to_owned());
        let sets: Vec<String> = self.sets.iter().cloned().chain(strict).collect();
        Plan::load(&self.pipeline, self.config.as_deref(), &sets)
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill run enrich --input cmu --config cmu --out corpus
  motionmill run annotate --input a --input b --out corpus --set annotations.diagnostics=true

Exit codes: 0 done; 2 arguments, config or plan; 1 anything else that prevents or ends a run;
3 done, with quarantined clips; 130 interrupted (the same command continues).")]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// Where the corpus lies or is to be made
    #[arg(long, short, value_name = "CORPUS")]
    pub(crate) out: Option<PathBuf>,
    /// Threads that mill [default: the machine's processors]
    #[arg(long, short, value_name = "N", value_parser = workers)]
    pub(crate) workers: Option<usize>,
    /// A file with host:port of every process, a line each; all see the same folders
    #[arg(long, value_name = "FILE", requires = "process")]
    pub(crate) hosts: Option<PathBuf>,
    /// Which line of the hosts file this process is, from 0
    #[arg(long, value_name = "I", requires = "hosts")]
    pub(crate) process: Option<usize>,
    /// How long the processes of a run wait for each other to come
    #[arg(long, value_name = "SECONDS", default_value_t = 60, hide = true)]
    pub(crate) hosts_deadline_s: u64,
    /// Removes clips whose files have gone
    #[arg(long)]
    pub(crate) prune: bool,
    /// Prints the result as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill inspect demo/corpus
  motionmill inspect demo/corpus walk_01 --strip walk.svg --plot feet.svg")]
pub(crate) struct Inspect {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// A clip: its name, its last part, or a prefix that only it has
    pub(crate) clip: Option<String>,
    /// Lists notes, warnings and faults, of one clip or all
    #[arg(long, conflicts_with_all = ["doubtful", "made", "strip", "plot", "raw"])]
    pub(crate) faults: bool,
    /// Lists clips whose gait is doubtful (confidence below 0.8)
    #[arg(long, conflicts_with_all = ["made", "clip", "strip", "plot", "raw"])]
    pub(crate) doubtful: bool,
    /// Lists recipes and what became of them
    #[arg(long, conflicts_with_all = ["clip", "strip", "plot", "raw"])]
    pub(crate) made: bool,
    /// With a clip: draws it as a strip of stick figures; a made clip below its parents
    #[arg(long, value_name = "FILE.svg", requires = "clip")]
    pub(crate) strip: Option<PathBuf>,
    /// With a clip: plots heights and speeds of its feet, contacts, force, plant states and gait over time
    #[arg(long, value_name = "FILE.svg", requires = "clip")]
    pub(crate) plot: Option<PathBuf>,
    /// With a clip: its joints, roles, channels and kinematic chains
    #[arg(long, requires = "clip")]
    pub(crate) raw: bool,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill search demo/corpus --gait walk --min-fraction 0.75 --min-seconds 2
  motionmill search demo/corpus --gait walk --quiet | motionmill export demo/corpus - --format bvh --out walks")]
pub(crate) struct Search {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// The clip's class; with --min-fraction, the gait that has that share of its frames
    #[arg(long, value_enum, value_name = "GAIT")]
    pub(crate) gait: Option<GaitName>,
    /// The least share of frames of --gait
    #[arg(long, value_name = "0..1", requires = "gait", value_parser = share)]
    pub(crate) min_fraction: Option<f64>,
    /// The least confidence in the gait
    #[arg(long, value_name = "0..1", value_parser = share)]
    pub(crate) min_confidence: Option<f64>,
    /// The shortest duration
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(crate) min_seconds: Option<f64>,
    /// A regular expression that fits somewhere in source/name
    #[arg(long, value_name = "REGEX")]
    pub(crate) name: Option<String>,
    /// A source's label
    #[arg(long, value_name = "LABEL")]
    pub(crate) source: Option<String>,
    /// Where the clip comes from
    #[arg(long, value_enum, value_name = "ORIGIN")]
    pub(crate) origin: Option<OriginName>,
    /// Names only, one a line
    #[arg(long, short, conflicts_with = "json")]
    pub(crate) quiet: bool,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A gait as a word of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GaitName {
    Stand,
    Walk,
    Run,
    Jump,
    Other,
    Unknown,
}

/// An origin as a word of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OriginName {
    Captured,
    Procedural,
    Graft,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TextFormat {
    /// Biovision hierarchy
    Bvh,
    /// Acclaim: an .asf and an .amc
    Amc,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill export demo/corpus walk_01 --format bvh --out clips
  motionmill search demo/corpus --origin graft --quiet | motionmill export demo/corpus - --format amc --out grafts")]
pub(crate) struct Export {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// Clips by name, its last part or a prefix that only it has; - reads names from standard input
    #[arg(required = true, value_name = "CLIP")]
    pub(crate) clips: Vec<String>,
    /// Text format
    #[arg(long, short, value_enum)]
    pub(crate) format: TextFormat,
    /// Folder to write to; files are named SOURCE/NAME in it
    #[arg(long, short, value_name = "DIR", default_value = ".")]
    pub(crate) out: PathBuf,
    /// Overwrites files that are there and differ
    #[arg(long)]
    pub(crate) force: bool,
    /// Prints what was written as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill synth --clips 40 --seed 1 --out captures
  motionmill synth --bench --clips 200 --format bvh --noise-mm 5 --out bench")]
pub(crate) struct Synth {
    /// How many clips
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clips)]
    pub(crate) clips: usize,
    /// Every clip follows from the seed and its name
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Clips of the bench: more ways to move, uneven ground, 24 to 240 frames a second, bodies of 1.2 to 2.1 m
    #[arg(long)]
    pub(crate) bench: bool,
    /// Normal noise of this deviation in every coordinate of every joint; BVH only, with positions at every joint
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = millimetres)]
    pub(crate) noise_mm: f64,
    /// Text format
    #[arg(long, short, value_enum, default_value_t = TextFormat::Amc)]
    pub(crate) format: TextFormat,
    /// Folder to write to
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("known").args(["truth", "procedural", "names"]).required(true).multiple(true)))]
#[command(after_help = "Examples:
  motionmill evaluate demo/corpus --procedural
  motionmill evaluate demo/corpus --truth demo/captures --by-clip --min-confidence 0.8

A file of truth has a header, frame,left,right,gait, and a row for every frame of its clip: whether a foot is on
the ground (1 or 0), and stand, walk, run, jump or unknown. What nobody knows is left empty, or its column out.
`motionmill synth` writes such files.

Rules are a TOML file; the first that fits somewhere in source/name decides, a clip that none fits is left out:
  [[rule]]
  name = \"_(run|dash)_\"
  gait = \"run\"

Exit codes: 0 compared; 2 arguments or rules; 1 nothing could be compared, or truth that can't be used.")]
pub(crate) struct Evaluate {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// A folder with truth of frames: NAME.truth.csv for a clip called NAME, at any depth
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Truth of the people that the program made for the corpus, made again
    #[arg(long)]
    pub(crate) procedural: bool,
    /// Truth of whole clips by their names: shipped rules (bandai-namco) or a file of your own
    #[arg(long, value_name = "RULES")]
    pub(crate) names: Option<String>,
    /// Only clips with a regular expression that fits somewhere in source/name
    #[arg(long, value_name = "REGEX")]
    pub(crate) name: Option<String>,
    /// Only clips of a source, by its label
    #[arg(long, value_name = "LABEL")]
    pub(crate) source: Option<String>,
    /// Says besides how many clips of at least this confidence are of the wrong class
    #[arg(long, value_name = "0..1", value_parser = share)]
    pub(crate) min_confidence: Option<f64>,
    /// Lists the clips, the worst first
    #[arg(long)]
    pub(crate) by_clip: bool,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill check demo
  motionmill check enrich --config cmu --input cmu --set contacts.detector=thesis

Exit codes: 0 nothing to complain of; 2 mistakes in arguments, config or plan; 3 some clips can't be used.")]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill verify demo/corpus
  motionmill verify demo/corpus --json

Exit codes: 0 every file is as it was written; 1 some are not.")]
pub(crate) struct Verify {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill compact corpus
  motionmill compact corpus -w 1 --json

A corpus that was fed several times has small shards and gaps in its numbers. Made anew, by the plan of its last
run, it has the same tables as one run over all inputs gives. The inputs are not read, and need not be there.
The old corpus stays as it is until the new one, in a folder beside it, is whole.

Exit codes: 0 done; 1 anything that prevents or ends it; 130 interrupted (the same command continues).")]
pub(crate) struct Compact {
    /// The corpus
    pub(crate) corpus: PathBuf,
    /// Threads that mill [default: the machine's processors]
    #[arg(long, short, value_name = "N", value_parser = workers)]
    pub(crate) workers: Option<usize>,
    /// Prints the result as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Each worker is a thread with its own share of memory, and channels to all others: more than these help nobody.
const MOST_WORKERS: usize = 512;

/// A number of threads.
fn workers(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(workers) if (1..=MOST_WORKERS).contains(&workers) => Ok(workers),
        _ => Err(format!("a whole number from 1 to {MOST_WORKERS} is needed")),
    }
}

/// More are not made at once: their list is held in memory.
const MOST_CLIPS: usize = 1_000_000;

/// A number of clips.
fn clips(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(clips) if (1..=MOST_CLIPS).contains(&clips) => Ok(clips),
        _ => Err(format!("a whole number from 1 to {MOST_CLIPS} is needed")),
    }
}

/// A length, up to a metre: a body is no larger than that.
fn millimetres(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length_mm) if (0.0..=1000.0).contains(&length_mm) => Ok(length_mm),
        _ => Err("a number of millimetres from 0 to 1000 is needed".to_owned()),
    }
}

/// A length of time.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds >= 0.0 => Ok(seconds),
        _ => Err("a number of seconds, 0 or more, is needed".to_owned()),
    }
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("a number from 0 to 1 is needed".to_owned()),
    }
}
