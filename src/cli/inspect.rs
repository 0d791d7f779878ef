//! `inspect`: what a corpus holds and what to distrust in it; or all about one clip.

use super::args::Inspect;
use super::clip_page::ClipPage;
use super::distrust::{Distrust, is_doubtful};
use super::output::{Answer, Refusal};
use super::overview::{Overview, there};
use super::search::{clip_json, listing};
use super::{faults, made, pictures, plot, raw, strip};
use crate::corpus::{
    Catalog, ClipRow, FaultRow, LookUpError, Manifest, Store, left_out, look_up, open_to_read, read_clips, read_faults,
    read_made, read_recipes,
};
use serde_json::json;

/// Runs the verb.
pub(super) fn inspect(args: &Inspect) -> Result<Answer, Refusal> {
    let (store, manifest) = open_to_read(&args.corpus)?;
    let name = args.corpus.display().to_string();
    let clips = read_clips(&store)?;
    if let Some(wanted) = &args.clip {
        return clip(args, wanted, &clips, &store, &manifest);
    }
    if args.faults {
        let rows = there(read_faults(&store))?.unwrap_or_default();
        return Ok(faults_answer(&rows, args.json, &format!("{name}: no note, no warning, no fault")));
    }
    if args.doubtful {
        return Ok(doubtful(clips, args.json, &name));
    }
    if args.made {
        let recipes = there(read_recipes(&store))?.unwrap_or_default();
        let verdicts = there(read_made(&store))?.unwrap_or_default();
        return Ok(match (args.json, recipes.is_empty()) {
            (true, _) => Answer::json(&made::json(&recipes, &verdicts, &clips)),
            (false, true) => Answer::text(String::new()).remark(format!("{name}: no recipes: no enrichment was run")),
            (false, false) => Answer::text(made::text(&recipes, &verdicts, &clips)),
        });
    }
    whole(&store, &manifest, &clips, &name, args.json)
}

fn whole(store: &Store, manifest: &Manifest, clips: &[ClipRow], name: &str, json: bool) -> Result<Answer, Refusal> {
    let overview = Overview::of(store, manifest)?;
    let faults = there(read_faults(store))?.unwrap_or_default();
    let distrust = Distrust::of(clips, manifest, left_out(manifest, &faults));
    Ok(match json {
        true => Answer::json(&json!({"corpus": name, "holds": overview, "distrust": distrust})),
        false => Answer::text(format!("{}\n\n{}", overview.text(name), distrust.text(name))),
    })
}

fn doubtful(mut clips: Vec<ClipRow>, json: bool, name: &str) -> Answer {
    clips.retain(is_doubtful);
    let confidence = |clip: &ClipRow| clip.labels.gait_confidence.unwrap_or(0.0);
    clips.sort_by(|a, b| confidence(a).total_cmp(&confidence(b)).then_with(|| a.full_name().cmp(&b.full_name())));
    match (json, clips.is_empty()) {
        (true, _) => Answer::json(&clips.iter().map(clip_json).collect::<Vec<_>>()),
        (false, true) => Answer::text(String::new()).remark(format!("{name}: no gait is doubtful")),
        (false, false) => Answer::text(listing(&clips)),
    }
}

fn faults_answer(rows: &[FaultRow], json: bool, none: &str) -> Answer {
    match (json, rows.is_empty()) {
        (true, _) => Answer::json(&faults::json(rows)),
        (false, true) => Answer::text(String::new()).remark(none),
        (false, false) => Answer::text(faults::text(rows)),
    }
}

fn clip(
    args: &Inspect,
    wanted: &str,
    clips: &[ClipRow],
    store: &Store,
    manifest: &Manifest,
) -> Result<Answer, Refusal> {
    pictures::check_targets(args)?;
    let all_faults = there(read_faults(store))?.unwrap_or_default();
    let row = match look_up(clips, wanted) {
        Ok(row) => row,
        Err(error @ LookUpError::NotFound { .. }) => {
            // A clip that could not be used has no row; its faults say why.
            let of_it: Vec<FaultRow> = all_faults.into_iter().filter(|fault| is_called(fault, wanted)).collect();
            return match of_it.is_empty() {
                true => Err(Refusal::of_look_up(&error, &args.corpus)),
                false => Ok(faults_answer(&of_it, args.json, "").ending(super::Ending::Failed)),
            };
        }
        Err(error) => return Err(Refusal::of_look_up(&error, &args.corpus)),
    };
    let of_it: Vec<FaultRow> =
        all_faults.into_iter().filter(|fault| fault.source == row.source && fault.name == row.name).collect();
    if args.faults {
        return Ok(faults_answer(&of_it, args.json, &format!("{}: no note, no warning, no fault", row.full_name())));
    }
    let catalog = Catalog::open(store)?;
    // Everything is read and drawn before anything is written: each of it may be refused.
    let plotted = match args.plot {
        Some(_) => Some(plot::draw(row, &args.corpus, manifest, &catalog)?),
        None => None,
    };
    let drawn = match args.strip {
        Some(_) => Some(strip::draw(row, clips, store, &catalog)?),
        None => None,
    };
    let page = ClipPage::read(row, clips, of_it, store, &catalog)?;
    let skeleton = catalog.shard_of(row.clip_id)?.skeleton(row.clip_id)?;
    let mut written: Vec<(&str, String)> = Vec::new();
    if let Some((file, strip::Drawn { svg, words })) = args.strip.as_deref().zip(drawn) {
        pictures::write("--strip", file, &svg)?;
        written.push(("strip", format!("{}: {words}", file.display())));
    }
    let mut remark = None;
    if let Some((file, plotted)) = args.plot.as_deref().zip(plotted) {
        pictures::write("--plot", file, &plotted.svg)?;
        written.push(("plot", format!("{}: {}", file.display(), plotted.words)));
        remark = plotted.remark;
    }
    if args.json {
        let mut value = page.json();
        if args.raw {
            value["raw"] = raw::json(skeleton);
        }
        for (word, words) in written {
            value[word] = words.into();
        }
        return Ok(with_remark(Answer::json(&value), remark));
    }
    let mut text = page.text();
    if args.raw {
        text.push('\n');
        text.push_str(&raw::text(skeleton));
    }
    let written: String = written.iter().map(|(word, words)| format!("{word:<11}{words}\n")).collect();
    if !written.is_empty() {
        text.push_str(&format!("\n{written}"));
    }
    Ok(with_remark(Answer::text(text), remark))
}

fn with_remark(answer: Answer, remark: Option<String>) -> Answer {
    match remark {
        Some(remark) => answer.remark(remark),
        None => answer,
    }
}

/// Whether a notice is about the clip that the user means; folders end in `/`.
fn is_called(fault: &FaultRow, wanted: &str) -> bool {
    let whole = || wanted.strip_prefix(&fault.source).and_then(|rest| rest.strip_prefix('/')) == Some(&fault.name);
    !wanted.is_empty() && (fault.name == wanted || fault.name.rsplit('/').next() == Some(wanted) || whole())
}
