//! What to distrust in a corpus, the worst first.

use super::numbers::{counted, grouped};
use crate::annotate::checks::{self, LOW_CONFIDENCE};
use crate::corpus::{ClipRow, ClipState, Manifest};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Hip to knee to ankle of people, small children to giants: outside of it the file's unit was misjudged.
const LEG_LENGTH_M: std::ops::RangeInclusive<f32> = 0.4..=1.25;
/// Clips that a line names.
const NAMED: usize = 4;

/// Clips by what is odd about them; each list the worst first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Distrust {
    /// Clips that fail self-checks, by check.
    pub(super) checks: BTreeMap<String, Vec<String>>,
    /// Gait confidence below 0.8.
    pub(super) doubtful: Vec<Doubtful>,
    /// Legs of a length that nobody has.
    pub(super) odd_scales: Vec<OddScale>,
    /// Clips whose files are the same, byte for byte.
    pub(super) duplicates: Vec<Vec<String>>,
    /// Clips that could not be used.
    pub(super) quarantined: Vec<String>,
    /// Clips whose files have gone.
    pub(super) gone: Vec<String>,
}

/// A clip whose gait is doubtful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Doubtful {
    pub(super) clip: String,
    pub(super) gait: Option<&'static str>,
    pub(super) confidence: f64,
}

/// A clip whose legs are too short or too long.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OddScale {
    pub(super) clip: String,
    pub(super) leg_length_m: f64,
}

/// Whether the gait of a clip is doubtful.
pub(super) fn is_doubtful(clip: &ClipRow) -> bool {
    !clip.origin.is_made() && clip.labels.gait_confidence.is_some_and(checks::is_doubtful)
}

impl Distrust {
    /// Looks through the clips that were read; made ones were judged.
    pub(super) fn of(clips: &[ClipRow], manifest: &Manifest, left_out: BTreeSet<String>) -> Distrust {
        let mut found = Distrust { quarantined: left_out.into_iter().collect(), ..Distrust::default() };
        for clip in clips.iter().filter(|clip| !clip.origin.is_made()) {
            let labels = &clip.labels;
            // Those of low confidence have a line of their own.
            for check in labels.checks.iter().filter(|check| *check != LOW_CONFIDENCE) {
                found.checks.entry(check.clone()).or_default().push(clip.full_name());
            }
            if let Some(confidence) = labels.gait_confidence.filter(|_| is_doubtful(clip)) {
                let gait = labels.gait_class.map(crate::annotate::Gait::name);
                found.doubtful.push(Doubtful { clip: clip.full_name(), gait, confidence: shortest(confidence) });
            }
            if let Some(leg_length_m) = labels.leg_length_m.filter(|length| !LEG_LENGTH_M.contains(length)) {
                found.odd_scales.push(OddScale { clip: clip.full_name(), leg_length_m: shortest(leg_length_m) });
            }
        }
        let mut files = BTreeMap::<(&str, Option<&str>), Vec<String>>::new();
        for (source, entry) in &manifest.sources {
            for (name, clip) in &entry.clips {
                let full = format!("{source}/{name}");
                if clip.state == ClipState::Gone {
                    found.gone.push(full.clone());
                }
                files.entry((&clip.blake3, clip.skeleton_blake3.as_deref())).or_default().push(full);
            }
        }
        found.duplicates = files.into_values().filter(|clips| clips.len() > 1).collect();
        found.duplicates.sort_by(|a, b| b.len().cmp(&a.len()).then(a.cmp(b)));
        found.doubtful.sort_by(|a, b| a.confidence.total_cmp(&b.confidence).then(a.clip.cmp(&b.clip)));
        // Ten times too long is as odd as ten times too short.
        let oddness = |odd: &OddScale| {
            let leg = odd.leg_length_m.max(1e-9);
            leg.max(1.0 / leg)
        };
        found.odd_scales.sort_by(|a, b| oddness(b).total_cmp(&oddness(a)).then(a.clip.cmp(&b.clip)));
        found
    }

    /// As lines below the overview. `corpus` is what the user calls it.
    pub(super) fn text(&self, corpus: &str) -> String {
        let mut lines = Vec::new();
        let mut line = |what: &str, clips: usize, remark: &str, names: &[String], how: &str| {
            let more = if names.len() > NAMED { ", ..." } else { "" };
            let named = names.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
            let count = counted(clips as u64, "clip");
            lines.push(format!("  {what:<22}{count:>12}  {remark}{named}{more}{how}"));
        };
        let mut checks: Vec<(&String, &Vec<String>)> = self.checks.iter().collect();
        checks.sort_by(|a, b| b.1.len().cmp(&a.1.len()).then(a.0.cmp(b.0)));
        for (check, clips) in checks {
            line(check, clips.len(), "", clips, "");
        }
        if !self.doubtful.is_empty() {
            let say = |doubt: &Doubtful| format!("{} {:.2}", doubt.clip, doubt.confidence);
            let names: Vec<String> = self.doubtful.iter().map(say).collect();
            line("doubtful gait", names.len(), "", &names, &format!("  (inspect {corpus} --doubtful)"));
        }
        if !self.odd_scales.is_empty() {
            let say = |odd: &OddScale| format!("{} leg {:.2} m", odd.clip, odd.leg_length_m);
            let names: Vec<String> = self.odd_scales.iter().map(say).collect();
            line("odd scale", names.len(), "", &names, "  (unit_m in the config)");
        }
        if !self.duplicates.is_empty() {
            let names: Vec<String> = self.duplicates.iter().map(|clips| clips.join(" = ")).collect();
            line("same file", self.duplicates.iter().map(Vec::len).sum(), "", &names, "");
        }
        if !self.quarantined.is_empty() {
            line(
                "quarantined",
                self.quarantined.len(),
                "",
                &self.quarantined,
                &format!("  (inspect {corpus} --faults)"),
            );
        }
        if !self.gone.is_empty() {
            line("file gone", self.gone.len(), "", &self.gone, "  (run with --prune removes them)");
        }
        match lines.is_empty() {
            true => "nothing to distrust: no self-check fails, no gait is doubtful, nobody is too small or too tall\n"
                .to_owned(),
            false => format!("to distrust, the worst first\n{}\n", lines.join("\n")),
        }
    }
}

/// How many clips have a check, in words.
pub(super) fn checks_of(clip: &ClipRow) -> String {
    match clip.labels.checks.as_slice() {
        [] => "all passed".to_owned(),
        failed => format!("{} failed: {}", grouped(failed.len() as u64), failed.join(", ")),
    }
}

/// The f64 of an f32's shortest decimal.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::corpus::{ClipEntry, ClipFormat, Origin, ShardId};
    use crate::motion::UpAxis;

    fn clip(clip_id: u32, name: &str, confidence: f32, leg: f32, checks: &[&str]) -> ClipRow {
        ClipRow {
            clip_id,
            name: name.to_owned(),
            source: "cmu".to_owned(),
            format: ClipFormat::Amc,
            layout: "L0".to_owned(),
            skeleton: "S0".to_owned(),
            subject: None,
            frames: 120,
            rate_hz: 120.0,
            frame_time_s: None,
            duration_s: 1.0,
            unit_m: 0.05,
            max_rounding: 0.0,
            licenses: Vec::new(),
            attribution: None,
            may_share: None,
            may_sell: None,
            origin: Origin::Captured,
            parents: Vec::new(),
            recipe: None,
            labels: crate::annotate::ClipLabels {
                gait_class: Some(crate::annotate::Gait::Walk),
                gait_confidence: Some(confidence),
                leg_length_m: Some(leg),
                checks: checks.iter().map(|&check| check.to_owned()).collect(),
                ..Default::default()
            },
            warnings: 0,
            up_axis: UpAxis::Y,
        }
    }

    #[test]
    fn the_worst_come_first() {
        let made = ClipRow { origin: Origin::Graft, ..clip(9, "made", 0.1, 9.0, &["no-step"]) };
        let clips = [
            clip(0, "a", 0.7, 0.85, &["walk-with-flight"]),
            clip(1, "b", 0.2, 0.02, &["walk-with-flight", "no-step"]),
            clip(2, "c", 0.9, 1.5, &[]),
            made,
        ];
        let mut manifest = Manifest::default();
        let entry = |clip_id, blake3: &str, state| ClipEntry {
            clip_id,
            blake3: blake3.to_owned(),
            skeleton_blake3: None,
            key: String::new(),
            bytes: 0,
            state,
            shard: ShardId::captured(0),
        };
        let cmu = &mut manifest.sources.entry("cmu".to_owned()).or_default().clips;
        cmu.insert("a".to_owned(), entry(0, "1", ClipState::Present));
        cmu.insert("b".to_owned(), entry(1, "2", ClipState::Gone));
        cmu.insert("c".to_owned(), entry(2, "1", ClipState::Present));
        cmu.insert("d".to_owned(), entry(3, "3", ClipState::Quarantined));
        let found = Distrust::of(&clips, &manifest, ["cmu/d".to_owned()].into());
        assert_eq!(found.doubtful.iter().map(|doubt| doubt.clip.as_str()).collect::<Vec<_>>(), ["cmu/b", "cmu/a"]);
        assert_eq!(found.odd_scales.iter().map(|odd| odd.clip.as_str()).collect::<Vec<_>>(), ["cmu/b", "cmu/c"]);
        assert_eq!(found.duplicates, [["cmu/a", "cmu/c"]]);
        assert_eq!((found.quarantined[0].as_str(), found.gone[0].as_str()), ("cmu/d", "cmu/b"));
        let text = found.text("corpus");
        let words: Vec<&str> = text.lines().skip(1).map(|line| line.get(2..24).unwrap().trim()).collect();
        let wanted =
            ["walk-with-flight", "no-step", "doubtful gait", "odd scale", "same file", "quarantined", "file gone"];
        assert_eq!(words, wanted, "{text}");
        assert!(
            Distrust::of(&clips[2..2], &Manifest::default(), Default::default())
                .text("corpus")
                .starts_with("nothing to distrust")
        );
    }
}
