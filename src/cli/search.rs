//! `search`: clips by gait, confidence, length, name, source and origin.

use super::args::{GaitName, OriginName, Search};
use super::numbers::{counted, grouped};
use super::output::{Answer, Refusal};
use super::table::{Side, Table};
use crate::annotate::{ClipLabels, Gait};
use crate::corpus::{ClipRow, Origin, open_to_read, read_clips};
use regex::Regex;
use serde_json::Value;
use std::fmt::Write;

/// Runs the verb.
pub(super) fn search(args: &Search) -> Result<Answer, Refusal> {
    if args.min_fraction.is_some() && args.gait == Some(GaitName::Other) {
        return Err(Refusal::new(
            "--min-fraction with --gait other",
            "`other` is a class of clips, given where no gait has most of the frames; no frame is `other`",
            "leave --min-fraction out",
        )
        .in_arguments());
    }
    let name = args.name.as_deref().map(pattern).transpose()?;
    let (store, _) = open_to_read(&args.corpus)?;
    let mut clips = read_clips(&store)?;
    clips.retain(|clip| fits(clip, args, name.as_ref()));
    clips.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    if args.json {
        return Ok(Answer::json(&clips.iter().map(clip_json).collect::<Vec<_>>()));
    }
    if args.quiet {
        let lines = clips.iter().map(|clip| clip.full_name() + "\n");
        return Ok(Answer::text(lines.collect()));
    }
    if clips.is_empty() {
        return Ok(Answer::text(String::new()).remark("no clip fits"));
    }
    let frames: u64 = clips.iter().map(|clip| u64::from(clip.frames)).sum();
    let seconds: f64 = clips.iter().map(|clip| clip.duration_s).sum();
    let mut text = listing(&clips);
    // A String takes whatever is written to it.
    let _ = writeln!(text, "{}, {} frames, {seconds:.1} s", counted(clips.len() as u64, "clip"), grouped(frames));
    Ok(Answer::text(text))
}

/// The table of `search`, of any clips.
pub(super) fn listing(clips: &[ClipRow]) -> String {
    let mut table = Table::new(&[
        ("clip", Side::Left),
        ("gait", Side::Left),
        ("confidence", Side::Right),
        ("stand", Side::Right),
        ("walk", Side::Right),
        ("run", Side::Right),
        ("jump", Side::Right),
        ("frames", Side::Right),
        ("seconds", Side::Right),
        ("origin", Side::Left),
    ]);
    for clip in clips {
        let labels = &clip.labels;
        let percent = |gait| {
            fraction_of(labels, gait).map_or(String::new(), |share| format!("{:.0} %", f64::from(share) * 100.0))
        };
        table.row([
            clip.full_name(),
            labels.gait_class.map_or("-", Gait::name).to_owned(),
            labels.gait_confidence.map_or(String::new(), |confidence| format!("{confidence:.2}")),
            percent(Gait::Stand),
            percent(Gait::Walk),
            percent(Gait::Run),
            percent(Gait::Jump),
            grouped(u64::from(clip.frames)),
            format!("{:.2}", clip.duration_s),
            clip.origin.name().to_owned(),
        ]);
    }
    table.text()
}

/// A row of `clips` with the columns' names of SCHEMA.
pub(super) fn clip_json(clip: &ClipRow) -> Value {
    // By way of text, where an f32 is its shortest decimal and not the f64 that it happens to be.
    let text = serde_json::to_string(clip).unwrap_or_default();
    let mut value: Value = serde_json::from_str(&text).unwrap_or_default();
    if let Value::Object(columns) = &mut value
        && let Some(Value::Object(labels)) = columns.remove("labels")
    {
        columns.extend(labels);
    }
    value
}

/// The regular expression of `--name`.
pub(super) fn pattern(text: &str) -> Result<Regex, Refusal> {
    Regex::new(text).map_err(|error| {
        // The last line says what; those before draw where.
        let what = error.to_string();
        let what = what.lines().last().unwrap_or_default().trim_start_matches("error: ").to_owned();
        let remedy = format!("--name '{}'", regex::escape(text));
        Refusal::new(format!("--name {text}: {what}"), "it is read as a regular expression", remedy).in_arguments()
    })
}

fn fits(clip: &ClipRow, args: &Search, name: Option<&Regex>) -> bool {
    let labels = &clip.labels;
    let gait = match (args.gait.map(gait_of), args.min_fraction) {
        (None, _) => true,
        (Some(gait), None) => labels.gait_class == Some(gait),
        (Some(gait), Some(least)) => fraction_of(labels, gait).is_some_and(|share| f64::from(share) >= least),
    };
    let origin = args.origin.map(|origin| match origin {
        OriginName::Captured => Origin::Captured,
        OriginName::Procedural => Origin::Procedural,
        OriginName::Graft => Origin::Graft,
    });
    let least = args.min_confidence;
    gait && least.is_none_or(|least| labels.gait_confidence.is_some_and(|sure| f64::from(sure) >= least))
        && args.min_seconds.is_none_or(|least| clip.duration_s >= least)
        && name.is_none_or(|name| name.is_match(&clip.full_name()))
        && args.source.as_ref().is_none_or(|source| *source == clip.source)
        && origin.is_none_or(|origin| origin == clip.origin)
}

fn gait_of(name: GaitName) -> Gait {
    match name {
        GaitName::Stand => Gait::Stand,
        GaitName::Walk => Gait::Walk,
        GaitName::Run => Gait::Run,
        GaitName::Jump => Gait::Jump,
        GaitName::Other => Gait::Other,
        GaitName::Unknown => Gait::Unknown,
    }
}

fn fraction_of(labels: &ClipLabels, gait: Gait) -> Option<f32> {
    match gait {
        Gait::Stand => labels.stand_fraction,
        Gait::Walk => labels.walk_fraction,
        Gait::Run => labels.run_fraction,
        Gait::Jump => labels.jump_fraction,
        Gait::Unknown => labels.unknown_fraction,
        Gait::Other => None,
    }
}
