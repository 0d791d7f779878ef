//! `evaluate`: the labels of a corpus against what is true.

use super::args::Evaluate;
use super::evaluation::{Compared, Evaluation, LeftOut};
use super::numbers::{counted, grouped};
use super::output::{Answer, Refusal};
use super::search::pattern;
use super::truths::Truths;
use crate::annotate::gait_summary::class_of_frames;
use crate::annotate::{FrameLabels, Gait};
use crate::corpus::{Catalog, ClipRow, CorpusError, open_to_read, read_clips};
use crate::evaluate::{ContactScore, FrameTruth, GaitConfusion, LengthsDiffer};
use std::collections::BTreeMap;

/// Runs the verb.
pub(super) fn evaluate(args: &Evaluate) -> Result<Answer, Refusal> {
    let name = args.name.as_deref().map(pattern).transpose()?;
    let (store, manifest) = open_to_read(&args.corpus)?;
    let mut clips = read_clips(&store)?;
    // What was made here has labels of its own, and nobody else's word about it.
    clips.retain(|clip| !clip.origin.is_made());
    clips.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    let is_wanted = |clip: &ClipRow| {
        name.as_ref().is_none_or(|name| name.is_match(&clip.full_name()))
            && args.source.as_ref().is_none_or(|source| *source == clip.source)
    };
    let wanted: Vec<bool> = clips.iter().map(is_wanted).collect();
    let truths = Truths::find(args, &manifest, &clips, &wanted)?;
    let corpus = args.corpus.display().to_string();
    let mut evaluation = Evaluation { corpus, by_names: truths.has_rules(), ..Evaluation::default() };
    let mut compared: Vec<Compared> = clips.iter().map(|clip| by_name(clip, &truths)).collect();
    by_frames(args, &clips, &wanted, &truths, &Catalog::open(&store)?, &mut compared)?;
    for (at, (clip, compared)) in clips.iter().zip(compared).enumerate().filter(|&(at, _)| wanted[at]) {
        match compared.is_empty() {
            false => evaluation.clips.push(compared),
            true => evaluation.left_out.push((clip.full_name(), why_left_out(at, clip, &truths))),
        }
    }
    if evaluation.clips.is_empty() {
        return Err(nothing(args, clips.len(), &evaluation, &truths));
    }
    let answer = match args.json {
        true => Answer::json(&evaluation.json(args.min_confidence, args.by_clip)),
        false => Answer::text(evaluation.text(args.min_confidence, args.by_clip)),
    };
    Ok(match truths.unused() {
        [first, ..] => {
            let n = counted(truths.unused().len() as u64, "file");
            answer.remark(format!("note: truth about none of the clips: {n}, such as {}", first.display()))
        }
        _ => answer,
    })
}

/// What the name and the row of a clip give.
fn by_name(clip: &ClipRow, truths: &Truths) -> Compared {
    let class = truths.class_by_name(clip).zip(clip.labels.gait_class);
    Compared { clip: clip.full_name(), confidence: clip.labels.gait_confidence, class, ..Compared::default() }
}

/// What the frames of the wanted clips give, shard by shard: one clip's labels and truth are held at a time.
fn by_frames(
    args: &Evaluate,
    clips: &[ClipRow],
    wanted: &[bool],
    truths: &Truths,
    catalog: &Catalog,
    compared: &mut [Compared],
) -> Result<(), Refusal> {
    let with_truth = (0..clips.len()).filter(|&at| wanted[at] && truths.has_frames(at, &clips[at]));
    let wanted: BTreeMap<u32, usize> = with_truth.map(|at| (clips[at].clip_id, at)).collect();
    for shard in catalog.shards() {
        if !shard.record().clips.iter().any(|clip| wanted.contains_key(&clip.clip_id)) {
            continue;
        }
        let labels = match shard.all_labels() {
            Ok(labels) => labels,
            // Nothing was annotated.
            Err(CorpusError::NotThere { .. }) => continue,
            Err(error) => return Err(error.into()),
        };
        for clip in labels {
            let (clip_id, labels) = clip?;
            let Some(&at) = wanted.get(&clip_id) else { continue };
            let Some(truth) = truths.frames(at, &clips[at])? else { continue };
            compare(&clips[at], &labels, &truth, truths, &mut compared[at]).map_err(|error| {
                // The truth has as many frames as the clip's row, so it is the labels that are too few or too many.
                let (name, n) = (clips[at].full_name(), clips[at].frames);
                let what = format!("{name}: {} frames have labels, the clip has {n}", error.labels);
                let remedy = format!("motionmill verify {}", args.corpus.display());
                Refusal::new(what, "the table of annotations is damaged", remedy)
            })?;
        }
    }
    Ok(())
}

fn compare(
    clip: &ClipRow,
    labels: &FrameLabels,
    truth: &FrameTruth,
    truths: &Truths,
    compared: &mut Compared,
) -> Result<(), LengthsDiffer> {
    let contacts = ContactScore::of_clip(labels, truth, clip.rate_hz)?;
    compared.contacts = Some(contacts).filter(|contacts| contacts.foot_frames() > 0);
    if let Some(gaits) = &truth.gait {
        let confusion = GaitConfusion::of_frames(&labels.gait, gaits)?;
        // A column that is empty all along says nothing.
        compared.gaits = Some(confusion).filter(|confusion| confusion.known() > 0);
        if !truths.has_rules() {
            let truth = Some(class_of_frames(gaits)).filter(|&class| class != Gait::Unknown);
            compared.class = truth.zip(clip.labels.gait_class);
        }
    }
    Ok(())
}

fn why_left_out(at: usize, clip: &ClipRow, truths: &Truths) -> LeftOut {
    if !truths.has_frames(at, clip) && truths.class_by_name(clip).is_none() {
        LeftOut::NoTruth
    } else if clip.labels.gait_class.is_none() {
        LeftOut::NoLabels
    } else {
        LeftOut::NothingKnown
    }
}

/// Why there is nothing to show, and what to try.
fn nothing(args: &Evaluate, n_clips: usize, evaluation: &Evaluation, truths: &Truths) -> Refusal {
    let corpus = args.corpus.display();
    let what = format!("{corpus}: no clip could be compared");
    let n_wanted = evaluation.left_out.len();
    let count = |why: LeftOut| evaluation.left_out.iter().filter(|(_, reason)| *reason == why).count();
    if n_clips == 0 {
        let remedy = format!("motionmill inspect {corpus} shows what it holds");
        return Refusal::new(what, "it holds no clip that was read", remedy);
    }
    if n_wanted == 0 {
        let why = format!("none of its {} fits --name and --source", counted(n_clips as u64, "clip"));
        return Refusal::new(what, why, format!("motionmill search {corpus} --quiet lists their names"));
    }
    if count(LeftOut::NoTruth) == n_wanted {
        let example = evaluation.left_out.first().map_or("", |(name, _)| name.as_str());
        let why = match (&args.truth, &args.names) {
            (Some(_), _) if !truths.has_files() => "there is no file of truth in that folder".to_owned(),
            (Some(_), _) => format!("no file of truth there is called as a clip such as {example}"),
            (None, Some(_)) => format!(
                "no rule gives a gait to a name such as {example}: none fits, or the first that does says `unknown`"
            ),
            (None, None) => "the program made none of its clips, or not by the settings that it notes".to_owned(),
        };
        let last = example.rsplit('/').next().unwrap_or(example);
        let remedy = match (&args.truth, &args.names) {
            (None, Some(_)) => {
                "a rule with a gait, whose name, a regular expression, fits somewhere in that".to_owned()
            }
            _ => format!("--truth with a folder that holds {last}.truth.csv"),
        };
        return Refusal::new(what, why, remedy);
    }
    if count(LeftOut::NoLabels) > 0 {
        let n = grouped(count(LeftOut::NoLabels) as u64);
        let why = format!("{n} with truth have no labels: no feet, or never annotated");
        let remedy = format!("motionmill run annotate, or motionmill inspect {corpus} for what is wrong with them");
        return Refusal::new(what, why, remedy);
    }
    Refusal::new(what, "the truth leaves every frame open", "files with cells that are not empty")
}

impl Compared {
    /// Whether another class was found than the true one.
    pub(super) fn is_wrong(&self) -> bool {
        self.class.is_some_and(|(truth, found)| truth != found)
    }
}
