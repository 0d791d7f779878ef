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
use crate::evaluate::{ContactScore, GaitConfusion, LengthsDiffer};
use std::collections::BTreeMap;

/// Runs the verb.
pub(super) fn evaluate(args: &Evaluate) -> Result<Answer, Refusal> {
    let name = args.name.as_deref().map(pattern).transpose()?;
    let (store, manifest) = open_to_read(&args.corpus)?;
    let mut clips = read_clips(&store)?;
    // What was made here has labels of its own, and nobody else's word about it.
    clips.retain(|clip| !clip.origin.is_made());
    let n_clips = clips.len();
    clips.retain(|clip| name.as_ref().is_none_or(|name| name.is_match(&clip.full_name())));
    clips.retain(|clip| args.source.as_ref().is_none_or(|source| *source == clip.source));
    clips.sort_by(|a, b| (&a.source, &a.name).cmp(&(&b.source, &b.name)));
    let truths = Truths::find(args, &manifest, &clips)?;
    let corpus = args.corpus.display().to_string();
    let mut evaluation = Evaluation { corpus, by_names: truths.has_rules(), ..Evaluation::default() };
    let mut compared: Vec<Compared> = clips.iter().map(|clip| by_name(clip, &truths)).collect();
    by_frames(&clips, &truths, &Catalog::open(&store)?, &mut compared)?;
    for (at, (clip, compared)) in clips.iter().zip(compared).enumerate() {
        match compared.is_empty() {
            false => evaluation.clips.push(compared),
            true => evaluation.left_out.push((clip.full_name(), why_left_out(at, clip, &truths))),
        }
    }
    if evaluation.clips.is_empty() {
        return Err(nothing(args, n_clips, clips.len(), &evaluation, &truths));
    }
    let answer = match args.json {
        true => Answer::json(&evaluation.json(args.min_confidence, args.by_clip)),
        false => Answer::text(evaluation.text(args.min_confidence, args.by_clip)),
    };
    // With fewer clips than there are, files of the others are to be expected.
    Ok(match truths.unused() {
        [first, ..] if clips.len() == n_clips => {
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

/// What the frames of the clips give, shard by shard: one clip's labels and truth are held at a time.
fn by_frames(clips: &[ClipRow], truths: &Truths, catalog: &Catalog, compared: &mut [Compared]) -> Result<(), Refusal> {
    let wanted: BTreeMap<u32, usize> =
        (0..clips.len()).filter(|&at| truths.has_frames(at, &clips[at])).map(|at| (clips[at].clip_id, at)).collect();
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
            compare(&clips[at], at, &labels, truths, &mut compared[at])?;
        }
    }
    Ok(())
}

fn compare(
    clip: &ClipRow,
    at: usize,
    labels: &FrameLabels,
    truths: &Truths,
    compared: &mut Compared,
) -> Result<(), Refusal> {
    let Some(truth) = truths.frames(at, clip)? else { return Ok(()) };
    // The truth has as many frames as the clip's row, so it is the labels that are too few or too many.
    let damaged = |error: LengthsDiffer| {
        let what = format!("{}: {} frames have labels, the clip has {}", clip.full_name(), error.labels, clip.frames);
        Refusal::new(what, "the table of annotations is damaged", "motionmill verify CORPUS")
    };
    let contacts = ContactScore::of_clip(labels, &truth, clip.rate_hz).map_err(damaged)?;
    compared.contacts = Some(contacts).filter(|contacts| contacts.foot_frames() > 0);
    if let Some(gaits) = &truth.gait {
        let confusion = GaitConfusion::of_frames(&labels.gait, gaits).map_err(damaged)?;
        compared.gaits = Some(confusion).filter(|confusion| confusion.total() > 0);
        if !truths.has_rules() {
            compared.class = clip.labels.gait_class.map(|found| (class_of_frames(gaits), found));
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
fn nothing(args: &Evaluate, n_clips: usize, n_wanted: usize, evaluation: &Evaluation, truths: &Truths) -> Refusal {
    let corpus = args.corpus.display();
    let what = format!("{corpus}: no clip could be compared");
    let count = |why: LeftOut| evaluation.left_out.iter().filter(|(_, reason)| *reason == why).count();
    if n_clips == 0 {
        return Refusal::new(what, "it holds no clip that was read", "motionmill inspect CORPUS shows what it holds");
    }
    if n_wanted == 0 {
        let why = format!("none of its {} fits --name and --source", counted(n_clips as u64, "clip"));
        return Refusal::new(what, why, format!("motionmill search {corpus} --quiet lists their names"));
    }
    if count(LeftOut::NoTruth) == n_wanted {
        let example = evaluation.left_out.first().map_or("", |(name, _)| name.as_str());
        let why = match (&args.truth, &args.names) {
            (Some(_), _) if truths.unused().is_empty() => "there is no file of truth in that folder".to_owned(),
            (Some(_), _) => format!("no file of truth there is called as a clip such as {example}"),
            (None, Some(_)) => format!("no rule fits a name such as {example}"),
            (None, None) => "the program made none of its clips, or not by the settings that it notes".to_owned(),
        };
        let last = example.rsplit('/').next().unwrap_or(example);
        let remedy = match (&args.truth, &args.names) {
            (None, Some(_)) => "a rule whose name, a regular expression, fits somewhere in that".to_owned(),
            _ => format!("--truth with a folder that holds {last}.truth.csv"),
        };
        return Refusal::new(what, why, remedy);
    }
    if count(LeftOut::NoLabels) > 0 {
        let why = format!(
            "{} with truth have no labels: no feet, or never annotated",
            grouped(count(LeftOut::NoLabels) as u64)
        );
        return Refusal::new(
            what,
            why,
            "motionmill run annotate, or motionmill inspect CORPUS for what is wrong with them",
        );
    }
    Refusal::new(what, "the truth says of no frame that anything is known", "files with cells that are not empty")
}

impl Compared {
    /// Whether the truth of the class is known and another was found.
    pub(super) fn is_wrong(&self) -> bool {
        self.class.is_some_and(|(truth, found)| truth != Gait::Unknown && truth != found)
    }
}
