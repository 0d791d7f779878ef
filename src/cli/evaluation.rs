//! What `evaluate` shows: tables for people, the same facts as JSON.

use super::numbers::{counted, grouped};
use super::table::{Side, Table};
use crate::annotate::Gait;
use crate::evaluate::{ContactScore, GaitConfusion, TimeErrors};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A clip beside its truth; None: of that nothing is known.
#[derive(Clone, Debug, Default)]
pub(super) struct Compared {
    /// Full name.
    pub(super) clip: String,
    /// In the clip's gait.
    pub(super) confidence: Option<f32>,
    /// Both feet.
    pub(super) contacts: Option<ContactScore>,
    /// Frames.
    pub(super) gaits: Option<GaitConfusion>,
    /// True class and found class.
    pub(super) class: Option<(Gait, Gait)>,
}

/// Why a clip is not among those that were compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum LeftOut {
    NoTruth,
    NoLabels,
    NothingKnown,
}

/// Everything that was compared.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    /// As the user named it.
    pub(super) corpus: String,
    /// Whether true classes are those that names promise; else they follow from the frames.
    pub(super) by_names: bool,
    /// By full name.
    pub(super) clips: Vec<Compared>,
    /// By full name.
    pub(super) left_out: Vec<(String, LeftOut)>,
}

/// Sums over clips.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    clips: u64,
    contacts: ContactScore,
    gaits: GaitConfusion,
}

/// Confident clips of a wrong class that are named.
const NAMED: usize = 20;

impl Compared {
    pub(super) fn is_empty(&self) -> bool {
        self.contacts.is_none() && self.gaits.is_none() && self.class.is_none()
    }

    /// The least share right: of foot-frames or of gait frames.
    fn least_right(&self) -> f64 {
        let contacts = self.contacts.and_then(|contacts| contacts.accuracy());
        let gaits = self.gaits.and_then(|gaits| gaits.share_right());
        contacts.into_iter().chain(gaits).fold(1.0, f64::min)
    }
}

impl LeftOut {
    fn words(self) -> &'static str {
        match self {
            LeftOut::NoTruth => "without truth",
            LeftOut::NoLabels => "without labels",
            LeftOut::NothingKnown => "with truth that knows nothing",
        }
    }
}

impl Evaluation {
    /// Tables, ended.
    pub(super) fn text(&self, min_confidence: Option<f64>, by_clip: bool) -> String {
        let all = self.sums(|_| true);
        let mut parts = vec![self.head()];
        if all.contacts.foot_frames() > 0 {
            parts.push(self.contacts_text());
        }
        if all.gaits.total() > 0 {
            parts.push(confusion_text("gait of frames", "frames", &all.gaits, &GaitConfusion::ALL[..5]));
        }
        let classes = self.classes();
        if classes.total() > 0 {
            let title = if self.by_names { "class of clips, true by name" } else { "class of clips, true by frames" };
            parts.push(confusion_text(title, "clips", &classes, &GaitConfusion::ALL));
        }
        if let Some(least) = min_confidence {
            parts.push(self.confident_text(least));
        }
        if by_clip {
            parts.push(self.clips_text());
        }
        parts.join("\n")
    }

    /// The same facts.
    pub(super) fn json(&self, min_confidence: Option<f64>, by_clip: bool) -> Value {
        let all = self.sums(|_| true);
        let groups: serde_json::Map<String, Value> =
            self.groups().into_iter().map(|(gait, sums)| (gait.name().to_owned(), sums_json(&sums))).collect();
        let left_out = |why: LeftOut| -> Vec<&str> {
            self.left_out.iter().filter(|(_, own)| *own == why).map(|(name, _)| name.as_str()).collect()
        };
        let mut value = json!({
            "corpus": self.corpus,
            "clips": {
                "compared": self.clips.len(),
                "by_frames": self.clips.iter().filter(|clip| clip.contacts.is_some() || clip.gaits.is_some()).count(),
                "left_out": {
                    "without_truth": left_out(LeftOut::NoTruth),
                    "without_labels": left_out(LeftOut::NoLabels),
                    "with_nothing_known": left_out(LeftOut::NothingKnown),
                },
            },
            "contacts": (all.contacts.foot_frames() > 0).then(|| contacts_json(&all.contacts)),
            "gait_frames": (all.gaits.total() > 0).then(|| confusion_json(&all.gaits)),
            "clip_classes": Some(self.classes()).filter(|classes| classes.total() > 0).as_ref().map(confusion_json),
            "classes_by": if self.by_names { "name" } else { "frames" },
            "by_class": groups,
        });
        if let Some(least) = min_confidence {
            let (n, wrong) = self.confident(least);
            let names: Vec<&str> = wrong.iter().map(|clip| clip.clip.as_str()).collect();
            value["confident"] =
                json!({"min_confidence": least, "clips": n, "wrong": names.len(), "wrong_clips": names});
        }
        if by_clip {
            value["by_clip"] = self.worst_first().into_iter().map(clip_json).collect();
        }
        value
    }

    fn head(&self) -> String {
        let n = (self.clips.len() + self.left_out.len()) as u64;
        let mut text =
            format!("{}: {} of {} compared", self.corpus, grouped(self.clips.len() as u64), counted(n, "clip"));
        let mut reasons: BTreeMap<LeftOut, u64> = BTreeMap::new();
        self.left_out.iter().for_each(|(_, why)| *reasons.entry(*why).or_default() += 1);
        for (at, (why, n)) in reasons.into_iter().enumerate() {
            let lead = if at == 0 { "; left out: " } else { ", " };
            // A String takes whatever is written to it, here and below.
            let _ = write!(text, "{lead}{} {}", grouped(n), why.words());
        }
        text + "\n"
    }

    /// Contacts of all clips, then by true class where more than one is known.
    fn contacts_text(&self) -> String {
        let mut rows = vec![("all", self.sums(|_| true))];
        let groups = self.groups();
        if groups.len() > 1 {
            rows.extend(groups.iter().map(|(gait, sums)| (gait.name(), *sums)));
        }
        rows.retain(|(_, sums)| sums.contacts.foot_frames() > 0);
        let mut frames = Table::new(&[
            ("contacts", Side::Left),
            ("clips", Side::Right),
            ("foot-frames", Side::Right),
            ("precision", Side::Right),
            ("recall", Side::Right),
            ("F1", Side::Right),
            ("specificity", Side::Right),
            ("accuracy", Side::Right),
        ]);
        let mut stances = Table::new(&[
            ("stances", Side::Left),
            ("missed", Side::Right),
            ("spurious", Side::Right),
            ("strikes", Side::Right),
            ("mean ms", Side::Right),
            ("s.d.", Side::Right),
            ("lift-offs", Side::Right),
            ("mean ms", Side::Right),
            ("s.d.", Side::Right),
        ]);
        for (name, Sums { clips, contacts, .. }) in &rows {
            let counts = [grouped(*clips), grouped(contacts.foot_frames())];
            let figures = [contacts.precision(), contacts.recall(), contacts.f1(), contacts.specificity()];
            let figures = figures.into_iter().chain([contacts.accuracy()]).map(figure);
            frames.row([(*name).to_owned()].into_iter().chain(counts).chain(figures));
            let of = |part: u64, whole: u64| format!("{} of {}", grouped(part), grouped(whole));
            let counts = [
                (*name).to_owned(),
                of(contacts.missed, contacts.true_stances),
                of(contacts.spurious, contacts.found_stances),
            ];
            stances.row(counts.into_iter().chain(times(&contacts.strikes)).chain(times(&contacts.lift_offs)));
        }
        format!("{}\n{}", frames.text(), stances.text())
    }

    fn confident_text(&self, least: f64) -> String {
        let (n, wrong) = self.confident(least);
        let n = counted(n, "clip");
        let mut text = match wrong.len() {
            0 => format!("of {n} of confidence {least} or more, none is of the wrong class\n"),
            wrong => format!("of {n} of confidence {least} or more, {} of the wrong class:\n", grouped(wrong as u64)),
        };
        for clip in wrong.iter().take(NAMED) {
            if let Some((truth, found)) = clip.class {
                let sure = clip.confidence.map_or(String::new(), |sure| format!(", {sure:.2}"));
                let _ = writeln!(text, "  {}: {}, found {}{sure}", clip.clip, truth.name(), found.name());
            }
        }
        if wrong.len() > NAMED {
            let _ = writeln!(text, "  ... and {} more", grouped((wrong.len() - NAMED) as u64));
        }
        text
    }

    fn clips_text(&self) -> String {
        let mut table = Table::new(&[
            ("clip", Side::Left),
            ("class", Side::Left),
            ("found", Side::Left),
            ("confidence", Side::Right),
            ("gait right", Side::Right),
            ("F1", Side::Right),
            ("accuracy", Side::Right),
            ("missed", Side::Right),
            ("spurious", Side::Right),
            ("strikes ms", Side::Right),
            ("lift-offs ms", Side::Right),
        ]);
        for clip in self.worst_first() {
            let class = |pick: fn((Gait, Gait)) -> Gait| clip.class.map_or("-", |class| pick(class).name()).to_owned();
            let of_contacts =
                |say: &dyn Fn(&ContactScore) -> String| clip.contacts.as_ref().map_or("-".to_owned(), say);
            table.row([
                clip.clip.clone(),
                class(|(truth, _)| truth),
                class(|(_, found)| found),
                clip.confidence.map_or("-".to_owned(), |sure| format!("{sure:.2}")),
                figure(clip.gaits.and_then(|gaits| gaits.share_right())),
                of_contacts(&|contacts| figure(contacts.f1())),
                of_contacts(&|contacts| figure(contacts.accuracy())),
                of_contacts(&|contacts| grouped(contacts.missed)),
                of_contacts(&|contacts| grouped(contacts.spurious)),
                of_contacts(&|contacts| signed(contacts.strikes.mean_ms())),
                of_contacts(&|contacts| signed(contacts.lift_offs.mean_ms())),
            ]);
        }
        table.text()
    }

    fn sums(&self, which: impl Fn(&Compared) -> bool) -> Sums {
        let mut sums = Sums::default();
        for clip in self.clips.iter().filter(|clip| which(clip)) {
            sums.clips += u64::from(clip.contacts.is_some() || clip.gaits.is_some());
            sums.contacts.merge(&clip.contacts.unwrap_or_default());
            sums.gaits.merge(&clip.gaits.unwrap_or_default());
        }
        sums
    }

    /// Sums by true class, of the clips whose frames were compared.
    fn groups(&self) -> Vec<(Gait, Sums)> {
        let of = |gait| self.sums(|clip| clip.class.is_some_and(|(truth, _)| truth == gait));
        let groups = GaitConfusion::ALL.into_iter().map(|gait| (gait, of(gait)));
        groups.filter(|(_, sums)| sums.clips > 0).collect()
    }

    fn classes(&self) -> GaitConfusion {
        let mut classes = GaitConfusion::default();
        self.clips.iter().filter_map(|clip| clip.class).for_each(|(truth, found)| classes.add(truth, found));
        classes
    }

    /// How many clips of known class have that confidence, and which of them are wrong, the surest first.
    fn confident(&self, least: f64) -> (u64, Vec<&Compared>) {
        let known = |clip: &&Compared| clip.class.is_some_and(|(truth, _)| truth != Gait::Unknown);
        let sure = |clip: &&Compared| clip.confidence.is_some_and(|sure| f64::from(sure) >= least);
        let clips: Vec<&Compared> = self.clips.iter().filter(known).filter(sure).collect();
        let mut wrong: Vec<&Compared> = clips.iter().copied().filter(|clip| clip.is_wrong()).collect();
        let confidence = |clip: &Compared| clip.confidence.unwrap_or(0.0);
        wrong.sort_by(|a, b| confidence(b).total_cmp(&confidence(a)).then_with(|| a.clip.cmp(&b.clip)));
        (clips.len() as u64, wrong)
    }

    /// Clips of a wrong class first; then by the least share of frames that are right; then by name.
    fn worst_first(&self) -> Vec<&Compared> {
        let mut clips: Vec<&Compared> = self.clips.iter().collect();
        clips.sort_by(|a, b| {
            let right = a.least_right().total_cmp(&b.least_right());
            b.is_wrong().cmp(&a.is_wrong()).then(right).then_with(|| a.clip.cmp(&b.clip))
        });
        clips
    }
}

/// A matrix: true gaits down, found ones across; those that never were true have no row.
fn confusion_text(title: &str, noun: &str, confusion: &GaitConfusion, gaits: &[Gait]) -> String {
    let mut header = vec![("true \\ found", Side::Left)];
    header.extend(gaits.iter().map(|gait| (gait.name(), Side::Right)));
    header.push(("recall", Side::Right));
    let mut table = Table::new(&header);
    for &truth in gaits.iter().filter(|&&truth| confusion.of_truth(truth) > 0) {
        let counts = gaits.iter().map(|&found| grouped(confusion.count(truth, found)));
        table.row([truth.name().to_owned()].into_iter().chain(counts).chain([figure(confusion.recall(truth))]));
    }
    let precisions = gaits.iter().map(|&found| figure(confusion.precision(found)));
    table.row(["precision".to_owned()].into_iter().chain(precisions));
    let known = format!("{} {noun}", grouped(confusion.known()));
    let share = confusion.share_right().map_or(String::new(), |share| format!(", {share:.3}"));
    format!("  {title}: {} of {known} right{share}\n{}", grouped(confusion.right()), table.text())
}

fn times(errors: &TimeErrors) -> [String; 3] {
    let sd = errors.sd_ms().map_or("-".to_owned(), |sd| format!("{sd:.1}"));
    [grouped(errors.count()), signed(errors.mean_ms()), sd]
}

fn signed(mean_ms: Option<f64>) -> String {
    mean_ms.map_or("-".to_owned(), |mean| format!("{mean:+.1}"))
}

fn figure(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{share:.3}"))
}

fn sums_json(sums: &Sums) -> Value {
    json!({
        "clips": sums.clips,
        "contacts": (sums.contacts.foot_frames() > 0).then(|| contacts_json(&sums.contacts)),
        "gait_frames": (sums.gaits.total() > 0).then(|| confusion_json(&sums.gaits)),
    })
}

fn contacts_json(score: &ContactScore) -> Value {
    let times =
        |errors: &TimeErrors| json!({"count": errors.count(), "mean_ms": errors.mean_ms(), "sd_ms": errors.sd_ms()});
    json!({
        "true_positives": score.true_positives, "false_positives": score.false_positives,
        "false_negatives": score.false_negatives, "true_negatives": score.true_negatives,
        "precision": score.precision(), "recall": score.recall(), "f1": score.f1(),
        "specificity": score.specificity(), "accuracy": score.accuracy(),
        "true_stances": score.true_stances, "found_stances": score.found_stances,
        "missed": score.missed, "spurious": score.spurious,
        "strikes": times(&score.strikes), "lift_offs": times(&score.lift_offs),
    })
}

fn confusion_json(confusion: &GaitConfusion) -> Value {
    let row = |truth: Gait| -> Value {
        let cells = GaitConfusion::ALL.map(|found| (found.name().to_owned(), json!(confusion.count(truth, found))));
        Value::Object(cells.into_iter().collect())
    };
    let rows = GaitConfusion::ALL.into_iter().filter(|&truth| confusion.of_truth(truth) > 0);
    let by_gait = |of: &dyn Fn(Gait) -> Option<f64>| -> Value {
        let known = GaitConfusion::ALL.into_iter().filter_map(|gait| Some((gait.name().to_owned(), json!(of(gait)?))));
        Value::Object(known.collect())
    };
    json!({
        "known": confusion.known(), "right": confusion.right(), "share_right": confusion.share_right(),
        "precision": by_gait(&|gait| confusion.precision(gait)), "recall": by_gait(&|gait| confusion.recall(gait)),
        "found_by_truth": Value::Object(rows.map(|truth| (truth.name().to_owned(), row(truth))).collect()),
    })
}

fn clip_json(clip: &Compared) -> Value {
    // By way of its shortest decimal, not the f64 that an f32 happens to be.
    let confidence = clip.confidence.and_then(|sure| sure.to_string().parse::<f64>().ok());
    json!({
        "clip": clip.clip, "confidence": confidence, "wrong": clip.is_wrong(),
        "class": clip.class.map(|(truth, _)| truth.name()), "found": clip.class.map(|(_, found)| found.name()),
        "contacts": clip.contacts.as_ref().map(contacts_json), "gait_frames": clip.gaits.as_ref().map(confusion_json),
    })
}
