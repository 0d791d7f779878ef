//! The command line's words: what each verb takes, and the help that teaches it.

use clap::{Args, Parser, Subcommand, ValueEnum};
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
    /// Make procedural captures, with the truth about every frame
    Synth(Synth),
}

#[derive(Debug, Args, Clone)]
pub(crate) struct PlanArgs {
    /// A shipped pipeline (annotate, graph, enrich, demo) or a file of your own
    pub(crate) pipeline: String,
    /// A shipped config (default, cmu, bandai-namco) or a file of your own
    #[arg(long, short, value_name = "CONFIG")]
    pub(crate) config: Option<String>,
    /// Overrides one value: --set contacts.thesis.max_height_m=0.04
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) sets: Vec<String>,
    /// A folder with captures; may be given several times
    #[arg(long, short, value_name = "DIR")]
    pub(crate) input: Vec<PathBuf>,
    /// Warnings become faults: a clip that deviates is left out
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  motionmill run enrich --input cmu --config cmu --out corpus
  motionmill run annotate --input a --input b --out corpus --set contacts.thesis.max_speed_mps=0.8

Exit codes: 0 done; 2 arguments, config or plan; 1 anything else that prevents or ends a run;
3 done, with quarantined clips; 130 interrupted (the same command continues).")]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// Where the corpus lies or is to be made
    #[arg(long, short, value_name = "CORPUS")]
    pub(crate) out: Option<PathBuf>,
    /// Threads that mill [default: the machine's processors]
    #[arg(long, short, value_name = "N")]
    pub(crate) workers: Option<usize>,
    /// A file with host:port of every process, a line each; all see the same folders
    #[arg(long, value_name = "FILE", requires = "process")]
    pub(crate) hosts: Option<PathBuf>,
    /// Which line of the hosts file this process is, from 0
    #[arg(long, value_name = "I", requires = "hosts")]
    pub(crate) process: Option<usize>,
    /// Removes clips whose files have gone
    #[arg(long)]
    pub(crate) prune: bool,
    /// Prints the result as JSON
    #[arg(long)]
    pub(crate) json: bool,
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
  motionmill synth --clips 40 --seed 1 --out captures
  motionmill synth --clips 300 --seed 2 --format bvh --out bench")]
pub(crate) struct Synth {
    /// How many clips
    #[arg(long, value_name = "N", default_value_t = 40)]
    pub(crate) clips: usize,
    /// Every clip follows from the seed and its name
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Text format
    #[arg(long, short, value_enum, default_value_t = TextFormat::Amc)]
    pub(crate) format: TextFormat,
    /// Folder to write to
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: PathBuf,
}
