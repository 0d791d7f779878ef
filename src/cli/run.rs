//! `run`: a pipeline over captures.

use super::args::Run;
use super::numbers::{bytes, counted, duration, grouped};
use super::output::{Refusal, idle_thresholds, say, tell};
use super::overview::Overview;
use super::progress::Progress;
use super::synth::{SynthError, write_captures};
use super::{Ending, give};
use crate::corpus::open_to_read;
use crate::flow::gauges::{Gauges, Station};
use crate::flow::halt::HaltFlag;
use crate::flow::mesh::Hosts;
use crate::flow::{Dataflow, RunError, RunReport, RunRequest};
use crate::inputs::find_inputs;
use crate::motion::Format;
use crate::plan::{Plan, WithoutInput};
use crate::procedural;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Clips of one kind that are named.
const SHOWN: usize = 20;

/// Runs the verb.
pub(super) fn run(args: Run) -> Ending {
    let start = Instant::now();
    let plan = match args.plan.load() {
        Ok(plan) => plan,
        Err(errors) => {
            return give(Err(errors.into()));
        }
    };
    let hosts = match args
        .hosts
        .as_deref()
        .map(|file| read_hosts(file, args.process.unwrap_or(0), args.hosts_deadline_s))
        .transpose()
    {
        Ok(hosts) => hosts,
        Err(message) => {
            tell(&message);
            return Ending::BadPlan;
        }
    };
    let workers = workers(args.workers);
    let makes_people = args.plan.input.is_empty() && plan.config.ingest.without_input == WithoutInput::Procedural;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(if makes_people { "demo/corpus" } else { "corpus" }));
    let mut inputs = args.plan.input.clone();
    let leads = hosts.as_ref().is_none_or(|hosts| hosts.process == 0);
    if makes_people && leads {
        match people(&out, &plan) {
            Ok(folder) => inputs.push(folder),
            Err(error) => {
                tell(&format!("error: {error}"));
                return Ending::Failed;
            }
        }
    }
    if leads && inputs.is_empty() && !out.join("manifest.json").exists() {
        let pipeline = &plan.pipeline;
        let why = format!("pipeline `{pipeline}` reads captures, and none were named");
        let remedy = "--input DIR with a folder of .bvh, or .asf and .amc, files";
        return give(Err(Refusal::new("no input", why, remedy).in_arguments()));
    }
    // A folder that is not there is a mistake in the arguments, found before any work.
    let rules = plan.config.input_rules();
    if leads && let Err(errors) = find_inputs(&inputs, &rules, plan.config.limits.max_clip_bytes) {
        return give(Err(errors.into()));
    }
    if leads {
        idle_thresholds(&plan.config).iter().for_each(|note| tell(note));
    }
    let procedural = makes_people;
    let request = RunRequest { plan, inputs, procedural, out, workers, hosts, prune: args.prune, from: None };
    let stages: Vec<&str> = request.plan.stages.iter().map(|planned| planned.stage.name()).collect();
    let with = counted(workers as u64, "worker");
    tell(&format!("plan     {}: {}    {with}", request.plan.pipeline, stages.join(" ")));
    let flag = interruptible();
    let gauges = Arc::new(Gauges::default());
    let progress = Progress::show(Arc::clone(&gauges));
    let result = crate::flow::run(&request, &gauges, &flag, tell);
    drop(progress);
    let name = request.out.display().to_string();
    match result {
        Ok(report) => finish(&request, &report, &gauges, start.elapsed(), args.json),
        Err(RunError::Interrupted { safe, .. }) => {
            let safe = counted(safe as u64, "clip");
            tell(&format!("interrupted: {safe} safe in {name}; the same command continues"));
            Ending::Interrupted
        }
        Err(error) => {
            tell(&format!("error: {error}"));
            Ending::Failed
        }
    }
}

/// As many threads as were asked for, else as the machine has processors.
pub(super) fn workers(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()))
}

/// A flag that Ctrl-C sets; the second time it ends the process at once.
pub(super) fn interruptible() -> Arc<HaltFlag> {
    let flag = Arc::new(HaltFlag::default());
    let heard = Arc::clone(&flag);
    // Without a handler Ctrl-C would end the process at once; the corpus stays resumable either way.
    let _ = ctrlc::set_handler(move || {
        if !heard.interrupt() {
            std::process::exit(130);
        }
    });
    flag
}

/// The folder of the captures that the program makes for itself, beside the corpus.
fn people(out: &Path, plan: &Plan) -> Result<PathBuf, SynthError> {
    let folder = out.parent().unwrap_or(Path::new("")).join("captures");
    let settings = &plan.config.procedural;
    write_captures(&folder, &procedural::corpus(settings.clips as usize, settings.seed), Format::Amc, 0.0)?;
    Ok(folder)
}

fn finish(request: &RunRequest, report: &RunReport, gauges: &Gauges, took: Duration, as_json: bool) -> Ending {
    let leads = request.hosts.as_ref().is_none_or(|hosts| hosts.process == 0);
    if !leads {
        tell("done: process 0 has the table");
        return Ending::Done;
    }
    let name = request.out.display().to_string();
    let overview = open_to_read(&request.out).and_then(|(store, manifest)| Overview::of(&store, &manifest));
    let overview = match overview {
        Ok(overview) => overview,
        Err(error) => return give(Err(error.into())),
    };
    let stay = if request.prune { "its rows went" } else { "its rows stay (--prune removes them)" };
    for clip in report.gone.iter().take(SHOWN) {
        tell(&format!("note: {clip}: its file has gone, or the config skips it; {stay}"));
    }
    if report.gone.len() > SHOWN {
        tell(&format!("note: ... and {}", counted((report.gone.len() - SHOWN) as u64, "clip")));
    }
    for source in &report.replaced {
        tell(&format!(
            "warning: source `{source}`: none of its clips is as it was\n  why: a source is known by its label, and another folder of that name takes the place of the first\n  try: if both are meant, a label for one: [[source]] folder = \"...\" label = \"...\""
        ));
    }
    let peak = report.dataflows.iter().filter_map(|flow| flow.peak_bytes).max();
    let mut lines = Vec::new();
    if as_json {
        let stations: serde_json::Map<String, serde_json::Value> =
            Station::ALL.iter().map(|&s| (s.name().to_owned(), json!(gauges.time_at(s).as_secs_f64()))).collect();
        let dataflows: Vec<_> = report
            .dataflows
            .iter()
            .map(|Dataflow { name, frames, time, peak_bytes }| {
                json!({"name": name, "frames": frames, "seconds": time.as_secs_f64(), "peak_bytes": peak_bytes})
            })
            .collect();
        let result = json!({
            "corpus": name, "up_to_date": report.up_to_date, "found": report.found, "parsed": report.parsed,
            "finished": report.finished, "quarantined": overview.quarantined(), "gone": report.gone,
            "seconds": took.as_secs_f64(), "peak_bytes": peak, "stations_s": stations,
            "dataflows": dataflows, "holds": overview,
        });
        lines.push(result.to_string());
    } else if report.up_to_date {
        lines.push(format!("corpus is up to date ({}); nothing to do", counted(report.finished as u64, "clip")));
    } else {
        lines.push(format!(
            "inputs   {}, {} found; {} read, {} already in {name}",
            counted(report.found as u64, "clip"),
            bytes(report.bytes),
            grouped(report.parsed as u64),
            grouped(report.finished as u64)
        ));
        for Dataflow { name, frames, time, peak_bytes } in report.dataflows.iter().filter(|flow| flow.frames > 0) {
            let rate = *frames as f64 / time.as_secs_f64().max(1e-3);
            let peak = peak_bytes.map_or(String::new(), |peak| format!(", peak {}", bytes(peak)));
            let (frames, rate) = (grouped(*frames), grouped(rate as u64));
            lines.push(format!("{name:<8} {frames} frames in {}, {rate} frames/s{peak}", duration(*time)));
        }
        lines.push(shares(gauges));
        lines.push(overview.text(&name));
        let text = if report.bytes > 0 && report.parsed == report.found {
            format!(" ({:.2} of the text)", overview.bytes() as f64 / report.bytes as f64)
        } else {
            String::new()
        };
        let peak = peak.map_or(String::new(), |peak| format!(", peak {}", bytes(peak)));
        lines.push(format!("corpus   {name} {}{text}, {}{peak}", bytes(overview.bytes()), duration(took)));
        lines.push(format!(
            "\nOpen it:  duckdb -c \"SELECT gait_class, sum(duration_s) FROM '{name}/clips.parquet' GROUP BY 1\""
        ));
    }
    say(&(lines.join("\n") + "\n"));
    if overview.quarantined() > 0 { Ending::Quarantined } else { Ending::Done }
}

/// Where the workers' time went.
fn shares(gauges: &Gauges) -> String {
    let total: f64 = Station::ALL.iter().map(|&station| gauges.time_at(station).as_secs_f64()).sum();
    let mut parts: Vec<(f64, &str)> = Station::ALL
        .iter()
        .map(|&station| (gauges.time_at(station).as_secs_f64() / total.max(1e-9), station.name()))
        .collect();
    parts.retain(|(share, _)| *share >= 0.005);
    let words: Vec<String> = parts.iter().map(|(share, name)| format!("{name} {:.0} %", share * 100.0)).collect();
    format!("time     {}", words.join(", "))
}

fn read_hosts(file: &Path, process: usize, deadline_s: u64) -> Result<Hosts, String> {
    let refused = |what: String, why: &str, remedy: &str| {
        format!("error: {}: {what}\n  why: {why}\n  try: {remedy}", file.display())
    };
    let text = std::fs::read_to_string(file).map_err(|error| {
        refused(
            error.to_string(),
            "the hosts file says where the processes of the run are",
            "a file with host:port of every process, a line each",
        )
    })?;
    let addresses: Vec<String> =
        text.lines().map(str::trim).filter(|line| !line.is_empty()).map(str::to_owned).collect();
    if let Some(twice) = addresses.iter().enumerate().find(|(at, address)| addresses[..*at].contains(address)) {
        return Err(refused(
            format!("{} stands there twice", twice.1),
            "each process of the run has an address of its own",
            "one line for each process",
        ));
    }
    if process >= addresses.len() {
        return Err(refused(
            format!("it has {} lines, and this is process {process}", addresses.len()),
            "processes are numbered from 0, a line each",
            "--process with the number of this process' line",
        ));
    }
    Ok(Hosts { addresses, process, deadline: Duration::from_secs(deadline_s) })
}
