//! `check`: a plan and its inputs before any work: what would be read, and every mistake.
//!
//! Of a clip the skeleton and the first frame are read; where these leave a doubt, the whole file.

use super::Ending;
use super::args::Check;
use super::faults;
use super::numbers::{bytes, counted, grouped};
use super::output::{Answer, Refusal, idle_thresholds};
use super::table::{Side, Table};
use crate::corpus::FaultRow;
use crate::formats::{AsfSkeleton, Deviation, Finding, Motion, ReadOptions, Reading, read_amc, read_asf, read_bvh};
use crate::inputs::{Found, Input, find_inputs};
use crate::motion::{Format, Notice, Severity};
use crate::plan::{ClipFacts, IdleThresholds, Plan, PlanError, Stage, WithoutInput};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes that are read of a clip to begin with.
const HEAD_BYTES: u64 = 64 << 10;

/// Clips of one source and format.
#[derive(Debug, Default, Serialize)]
struct Amount {
    source: String,
    folder: PathBuf,
    format: &'static str,
    clips: u64,
    skeletons: usize,
    bytes: u64,
    license: Option<String>,
}

/// Runs the verb.
pub(super) fn check(args: &Check) -> Result<Answer, Refusal> {
    let plan = match args.plan.load() {
        Ok(plan) => plan,
        Err(errors) if args.json => {
            let errors: Vec<_> = errors.iter().map(mistake).collect();
            return Ok(Answer::json(&json!({"mistakes": errors})).ending(Ending::BadPlan));
        }
        Err(errors) => return Err(errors.into()),
    };
    let mut found = find_inputs(&args.plan.input, &plan.config.input_rules(), plan.config.limits.max_clip_bytes)?;
    let filter = plan.filter(Stage::Ingest);
    found.inputs.retain(|input| {
        let format = Some(input.kind);
        filter.lets_through(&ClipFacts { source: &input.source, name: &input.name, format, ..ClipFacts::default() })
    });
    if !args.plan.input.is_empty() && found.inputs.is_empty() && found.notices.is_empty() {
        let what = "no clip to read in the inputs";
        let why = "there is no .bvh and no .amc below them that the pipeline lets through";
        return Err(Refusal::new(what, why, "--input DIR with a folder of motion captures").in_arguments());
    }
    let faults = all_faults(&found, &plan);
    let unusable: BTreeSet<(&str, &str)> = faults
        .iter()
        .filter(|row| row.notice.severity == Severity::Fault)
        .map(|row| (row.source.as_str(), row.name.as_str()))
        .collect();
    let amounts = amounts(&found);
    let stages: Vec<&str> = plan.stages.iter().map(|planned| planned.stage.name()).collect();
    let ending = if unusable.is_empty() { Ending::Done } else { Ending::Quarantined };
    if args.json {
        let notes = plan.config.idle_thresholds();
        let note = |idle: &IdleThresholds| json!({"what": idle.what(), "why": idle.why(), "try": idle.remedy()});
        let notes: Vec<_> = notes.iter().map(note).collect();
        let value = json!({
            "mistakes": [], "notes": notes, "pipeline": plan.pipeline, "stages": stages, "inputs": amounts, "skipped": found.skipped,
            "unusable": unusable.iter().map(|(source, name)| format!("{source}/{name}")).collect::<Vec<_>>(),
            "faults": faults::json(&faults),
        });
        return Ok(Answer::json(&value).ending(ending));
    }
    let mut text = format!("plan     {}: {}\n", plan.pipeline, stages.join(" "));
    if !plan.description.is_empty() {
        text.push_str(&format!("         {}\n", plan.description));
    }
    text.push_str(&inputs_text(&plan, args.plan.input.is_empty(), &amounts, &found));
    if !faults.is_empty() {
        text.push_str(&format!("\n{}", faults::text(&faults)));
    }
    let verdict = match unusable.len() as u64 {
        0 => "no mistake".to_owned(),
        n => format!("no mistake in the plan; {} can't be used and would be left out", counted(n, "clip")),
    };
    text.push_str(&format!("check    {verdict}\n"));
    let mut answer = Answer::text(text).ending(ending);
    answer.remarks.extend(idle_thresholds(&plan.config));
    Ok(answer)
}

fn inputs_text(plan: &Plan, none_named: bool, amounts: &[Amount], found: &Found) -> String {
    if none_named {
        return match plan.config.ingest.without_input {
            WithoutInput::Procedural => {
                let clips = counted(u64::from(plan.config.procedural.clips), "clip");
                format!("inputs   {clips} of the program's own making (--input DIR for yours)\n")
            }
            WithoutInput::Nothing => "inputs   none named (--input DIR)\n".to_owned(),
        };
    }
    let mut table = Table::new(&[
        ("source", Side::Left),
        ("format", Side::Left),
        ("clips", Side::Right),
        ("skeletons", Side::Right),
        ("text", Side::Right),
        ("folder", Side::Left),
        ("license", Side::Left),
    ]);
    for amount in amounts {
        table.row([
            amount.source.clone(),
            amount.format.to_owned(),
            grouped(amount.clips),
            if amount.skeletons > 0 { grouped(amount.skeletons as u64) } else { String::new() },
            bytes(amount.bytes),
            amount.folder.display().to_string(),
            amount.license.clone().unwrap_or_else(|| "not said".to_owned()),
        ]);
    }
    let clips = amounts.iter().map(|amount| amount.clips).sum();
    let skipped =
        if found.skipped > 0 { format!("; {} skipped", grouped(found.skipped as u64)) } else { String::new() };
    let size = bytes(amounts.iter().map(|amount| amount.bytes).sum());
    format!("inputs   {}, {size}{skipped}\n{}", counted(clips, "clip"), table.text())
}

fn amounts(found: &Found) -> Vec<Amount> {
    let mut amounts = BTreeMap::<(&str, &str), (Amount, BTreeSet<&Path>)>::new();
    for input in &found.inputs {
        let folder = found.sources.iter().find(|source| source.label == input.source);
        let (amount, skeletons) = amounts.entry((&input.source, input.kind.name())).or_insert_with(|| {
            let new = Amount {
                source: input.source.clone(),
                folder: folder.map(|source| source.folder.clone()).unwrap_or_default(),
                format: input.kind.name(),
                license: input.settings.license.clone(),
                ..Amount::default()
            };
            (new, BTreeSet::new())
        });
        amount.clips += 1;
        amount.bytes += input.bytes;
        skeletons.extend(input.asf.as_deref());
    }
    let counted = |(amount, skeletons): (Amount, BTreeSet<&Path>)| Amount { skeletons: skeletons.len(), ..amount };
    amounts.into_values().map(counted).collect()
}

/// What finding and looking into the files has to say, by source and name.
fn all_faults(found: &Found, plan: &Plan) -> Vec<FaultRow> {
    let (limits, strict) = (plan.config.limits.clone(), plan.config.ingest.strict);
    let options = ReadOptions { limits, strict, ..ReadOptions::default() };
    let mut skeletons: Vec<&Path> = found.inputs.iter().filter_map(|input| input.asf.as_deref()).collect();
    skeletons.sort();
    skeletons.dedup();
    let read: Vec<Result<Reading<AsfSkeleton>, Notice>> =
        skeletons.par_iter().map(|path| read_skeleton(path, &options)).collect();
    let skeletons: BTreeMap<&Path, Result<Reading<AsfSkeleton>, Notice>> = skeletons.into_iter().zip(read).collect();
    let of_clips: Vec<Vec<Notice>> =
        found.inputs.par_iter().map(|input| look_into(input, &skeletons, &options)).collect();
    let of_files = found.inputs.iter().zip(of_clips).flat_map(|(input, notices)| {
        notices.into_iter().map(|notice| FaultRow { source: input.source.clone(), name: input.name.clone(), notice })
    });
    let of_folders = found.notices.iter().map(|notice| FaultRow {
        source: notice.source.clone(),
        name: notice.name.clone(),
        notice: notice.notice.clone(),
    });
    let mut rows: Vec<FaultRow> = of_folders.chain(of_files).collect();
    rows.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    rows
}

fn read_skeleton(path: &Path, options: &ReadOptions) -> Result<Reading<AsfSkeleton>, Notice> {
    let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
    read_asf(&bytes, options).map_err(|finding| in_skeleton(finding.notice()))
}

fn look_into(
    input: &Input,
    skeletons: &BTreeMap<&Path, Result<Reading<AsfSkeleton>, Notice>>,
    options: &ReadOptions,
) -> Vec<Notice> {
    let mut notices = Vec::new();
    let asf = match input.asf.as_deref().and_then(|path| skeletons.get(path)) {
        None => None,
        Some(Ok(reading)) => {
            notices.extend(reading.notices().into_iter().map(in_skeleton));
            Some(&reading.value)
        }
        Some(Err(fault)) => return vec![fault.clone()],
    };
    let options = ReadOptions { position_rule: input.settings.position_channels, ..options.clone() };
    // A head has fewer frames than its file says; that alone is no deviation of the file.
    let lenient = ReadOptions { strict: false, ..options.clone() };
    let is_clean = |reading: &Reading<Motion>| {
        reading.findings.iter().all(|finding| matches!(finding.what, Deviation::FramesFewer { .. }))
    };
    let head = first_frame(&input.path, input.kind);
    if head.is_ok_and(|head| head.is_some_and(|head| parse(&head, asf, &lenient).is_ok_and(|read| is_clean(&read)))) {
        return notices;
    }
    match std::fs::read(&input.path) {
        Err(error) => notices.push(unreadable(&input.path, &error)),
        Ok(bytes) => match parse(&bytes, asf, &options) {
            Ok(reading) => notices.extend(reading.notices()),
            Err(finding) => notices.push(finding.notice()),
        },
    }
    notices
}

fn parse(bytes: &[u8], asf: Option<&AsfSkeleton>, options: &ReadOptions) -> Result<Reading<Motion>, Finding> {
    match asf {
        Some(asf) => read_amc(bytes, asf, options),
        None => read_bvh(bytes, options),
    }
}

/// The file up to the end of its first frame; None: it can't be told where that is.
fn first_frame(path: &Path, kind: Format) -> std::io::Result<Option<Vec<u8>>> {
    let mut head = Vec::new();
    File::open(path)?.take(HEAD_BYTES).read_to_end(&mut head)?;
    let end = match kind {
        Format::Bvh => end_of_bvh_frame(&head),
        Format::Amc => end_of_amc_frame(&head),
    };
    head.truncate(end.unwrap_or(0));
    Ok(end.map(|_| head))
}

/// After MOTION there are the number of frames, the frame time, and the first row.
fn end_of_bvh_frame(head: &[u8]) -> Option<usize> {
    let mut after_motion = None;
    for (line, end) in lines(head) {
        let word = line.trim_ascii();
        match &mut after_motion {
            None if word.eq_ignore_ascii_case(b"MOTION") => after_motion = Some(0),
            Some(seen) if !word.is_empty() => {
                *seen += 1;
                if *seen == 3 {
                    return Some(end);
                }
            }
            _ => {}
        }
    }
    None
}

/// A frame begins with its number alone on a line; the second number ends the first frame.
fn end_of_amc_frame(head: &[u8]) -> Option<usize> {
    let is_number = |line: &[u8]| {
        let word = line.trim_ascii();
        !word.is_empty() && word.iter().all(u8::is_ascii_digit)
    };
    let mut numbers = lines(head).filter(|(line, _)| is_number(line));
    numbers.next()?;
    numbers.next().map(|(line, end)| end - line.len())
}

/// Whole lines with their ends, and where they end.
fn lines(text: &[u8]) -> impl Iterator<Item = (&[u8], usize)> {
    text.split_inclusive(|&byte| byte == b'\n').filter(|line| line.ends_with(b"\n")).scan(0, |end, line| {
        *end += line.len();
        Some((line, *end))
    })
}

fn in_skeleton(mut notice: Notice) -> Notice {
    notice.message = format!("in the skeleton file: {}", notice.message);
    notice
}

fn unreadable(path: &Path, error: &std::io::Error) -> Notice {
    Notice {
        severity: Severity::Fault,
        kind: "file-unreadable".to_owned(),
        line: None,
        frame: None,
        count: 1,
        message: format!("{} can't be read: {error}", path.file_name().unwrap_or_default().display()),
        why: "without its bytes the clip is left out; the others go on".to_owned(),
        remedy: "make it readable, or list the clip under `skip` in your config".to_owned(),
    }
}

fn mistake(error: &PlanError) -> serde_json::Value {
    json!({"file": error.file, "line": error.line, "column": error.column, "what": error.what, "why": error.why,
        "try": error.try_})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_ends_with_its_first_frame() {
        let bvh = b"HIERARCHY\nROOT a\n{\n}\nMOTION\nFrames: 3\nFrame Time: .05\n\n1 2 3\n4 5 6\n";
        assert_eq!(end_of_bvh_frame(bvh).map(|end| &bvh[end..]), Some(&b"4 5 6\n"[..]));
        assert_eq!(end_of_bvh_frame(&bvh[..60]), None);
        let amc = b":DEGREES\n1\nroot 0 0 0\n2\nroot 1 1 1\n";
        assert_eq!(end_of_amc_frame(amc).map(|end| &amc[end..]), Some(&b"2\nroot 1 1 1\n"[..]));
        assert_eq!(end_of_amc_frame(&amc[..15]), None);
    }
}
