//! Class, fractions, confidence and figures of a clip's gait (CONTACTS 3.8).

use super::gait_segments::gait_runs;
use super::gait_steps::{Evidence, Step, StepGaits};
use super::gait_tokens::TokenRun;
use super::labels::{Foot, Gait, Segment};
use core::ops::Range;

/// The classes that frames have.
pub const FRAME_GAITS: [Gait; 5] = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump];

/// Mean size of the log-odds of a clip that is clear throughout (3.8).
const CLEAR_LOG_ODDS: f64 = 1.8;
/// Confidence in a walk or run segment that holds no step between opposite feet.
const NO_STEP_CONFIDENCE: f64 = 0.5;

/// The gait of a clip.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipGait {
    /// The class with at least nine tenths of the known frames; `jump` where jumps have a third of them and the rest are
    /// stands; else `other`; `unknown` if less than half is known.
    pub class: Gait,
    /// Share of the frames of each of [`FRAME_GAITS`].
    pub fractions: [f64; 5],
    /// 0..1: share of the largest class among the known frames, times the mean certainty of its steps, times the
    /// clearness of the log-odds where there are any.
    pub confidence: f64,
}

/// Jumps with stands between them make a jump clip if they have this share of its known frames.
const JUMPS_AMONG_STANDS: f64 = 1.0 / 3.0;

/// Class, fractions and confidence of a clip (3.8). None: no frames.
///
/// Where CONTACTS calls a clip of separate standing jumps `other`, it is a jump here: stands are no other gait than the
/// jumps that begin and end in them, T 3.2's grammar `(BN)+B` lets both feet stay as long as they like, and who looks
/// for jumps wants them. Its stands are still stands, frame by frame and in its segments.
pub fn clip_gait(gaits: &StepGaits, evidence: Evidence<'_>) -> Option<ClipGait> {
    let n_frames = gaits.gaits.len();
    if n_frames == 0 {
        return None;
    }
    let counts = frames_of_gaits(&gaits.gaits);
    let (class, top, share) = class_of_counts(counts);
    let certainty = step_certainty(gaits.steps.iter(), top).unwrap_or(1.0);
    let fractions = counts.map(|count| count as f64 / n_frames as f64);
    Some(ClipGait { class, fractions, confidence: share * certainty * clearness(evidence, 0..n_frames) })
}

/// The class of a clip by the gaits of its frames: the rule of [`ClipGait::class`]; unknown without frames.
pub fn class_of_frames(gaits: &[Gait]) -> Gait {
    if gaits.is_empty() { Gait::Unknown } else { class_of_counts(frames_of_gaits(gaits)).0 }
}

fn frames_of_gaits(gaits: &[Gait]) -> [usize; 5] {
    let mut counts = [0; 5];
    for count in gaits.iter().filter_map(|&gait| FRAME_GAITS.iter().position(|&known| known == gait)) {
        counts[count] += 1;
    }
    counts
}

/// The class, the gait of most frames, and the share of the known frames that speaks for the class.
fn class_of_counts(counts: [usize; 5]) -> (Gait, Gait, f64) {
    let n_known: usize = counts[1..].iter().sum();
    let (mut top, mut most) = (Gait::Stand, counts[1]);
    for gait in &FRAME_GAITS[2..] {
        if counts[*gait as usize] > most {
            (top, most) = (*gait, counts[*gait as usize]);
        }
    }
    let [jumps, stands] = [Gait::Jump, Gait::Stand].map(|gait| counts[gait as usize]);
    let class = if n_known < counts[0] {
        Gait::Unknown
    } else if 10 * most >= 9 * n_known {
        top
    } else if jumps + stands == n_known && jumps as f64 >= JUMPS_AMONG_STANDS * n_known as f64 {
        (top, most) = (Gait::Jump, n_known);
        Gait::Jump
    } else {
        Gait::Other
    };
    (class, top, most as f64 / n_known.max(1) as f64)
}

/// Segments of one gait. Confidence: the mean certainty of the segment's own steps in a walk or run (0.5 without
/// any), 1 in a stand or jump, times the clearness of the segment's log-odds; None where the gait is unknown.
pub fn segments(gaits: &StepGaits, evidence: Evidence<'_>) -> Vec<Segment> {
    gait_runs(&gaits.gaits)
        .into_iter()
        .map(|(gait, range)| {
            let certainty = match gait {
                Gait::Unknown | Gait::Other => None,
                Gait::Stand | Gait::Jump => Some(1.0),
                Gait::Walk | Gait::Run => {
                    Some(step_certainty(steps_in(&gaits.steps, &range).iter(), gait).unwrap_or(NO_STEP_CONFIDENCE))
                }
            };
            let confidence = certainty.map(|certainty| (certainty * clearness(evidence, range.clone())) as f32);
            Segment { gait, first: range.start as u32, end: range.end as u32, confidence }
        })
        .collect()
}

/// Confidence in each frame's gait: in a walk or run the certainty of the segment's step nearest to the frame (0.5
/// without any), 1 in a stand or jump, times the clearness of the frame's log-odds; None where the gait is unknown.
pub fn frame_confidences(gaits: &StepGaits, evidence: Evidence<'_>) -> Vec<Option<f32>> {
    let mut confidences = vec![None; gaits.gaits.len()];
    for (gait, range) in gait_runs(&gaits.gaits) {
        let steps = match gait {
            Gait::Unknown | Gait::Other => continue,
            Gait::Stand | Gait::Jump => &[],
            Gait::Walk | Gait::Run => steps_in(&gaits.steps, &range),
        };
        let mut nearest = 0;
        for frame in range {
            let far = |step: &Step| (step.middle() - frame as f64).abs();
            while steps.get(nearest + 1).is_some_and(|next| far(next) < far(&steps[nearest])) {
                nearest += 1;
            }
            let certainty = match (gait, steps.get(nearest)) {
                (Gait::Stand | Gait::Jump, _) => 1.0,
                (_, Some(step)) => certainty(step, gait),
                (_, None) => NO_STEP_CONFIDENCE,
            };
            confidences[frame] = Some((certainty * clearness(evidence, frame..frame + 1)) as f32);
        }
    }
    confidences
}

/// Mean over feet of the share of their strides that they are in stance. Strides, strike to strike of one foot, count
/// if one walk or run segment holds them. None: no stride.
pub fn duty_factor(gaits: &StepGaits) -> Option<f64> {
    let of_feet: Vec<f64> = [Foot::Left, Foot::Right]
        .into_iter()
        .filter_map(|foot| {
            let stances = stances(&gaits.runs, foot);
            let shares: Vec<f64> = stances
                .windows(2)
                // A stance that the clip's start cuts off has no strike.
                .filter(|pair| pair[0].start > 0)
                .filter(|pair| {
                    let stride = &gaits.gaits[pair[0].start..pair[1].start];
                    matches!(stride[0], Gait::Walk | Gait::Run) && stride.iter().all(|gait| *gait == stride[0])
                })
                .map(|pair| pair[0].len() as f64 / (pair[1].start - pair[0].start) as f64)
                .collect();
            mean(&shares)
        })
        .collect();
    mean(&of_feet)
}

/// Runs of frames in which a foot is planted, flicker removed.
pub fn stances(runs: &[TokenRun], foot: Foot) -> Vec<Range<usize>> {
    let mut stances: Vec<Range<usize>> = Vec::new();
    for run in runs.iter().filter(|run| run.token.plants(foot)) {
        match stances.last_mut() {
            Some(last) if last.end == run.first => last.end = run.end,
            _ => stances.push(run.first..run.end),
        }
    }
    stances
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Steps whose middle lies in a range of frames; they are in order of time.
fn steps_in<'a>(steps: &'a [Step], range: &Range<usize>) -> &'a [Step] {
    let first = steps.partition_point(|step| step.middle() < range.start as f64);
    let end = steps.partition_point(|step| step.middle() < range.end as f64);
    &steps[first..end.max(first)]
}

/// Mean probability that steps are of a walk or run. None: no steps, or another gait.
fn step_certainty<'a>(steps: impl Iterator<Item = &'a Step>, gait: Gait) -> Option<f64> {
    if !matches!(gait, Gait::Walk | Gait::Run) {
        return None;
    }
    let certainties: Vec<f64> = steps.map(|step| certainty(step, gait)).collect();
    mean(&certainties)
}

/// Probability that a step is of a walk or run: the two differ by four units of evidence.
fn certainty(step: &Step, gait: Gait) -> f64 {
    let evidence = if gait == Gait::Run { step.run_evidence } else { -step.run_evidence };
    1.0 / (1.0 + libm::exp(-2.0 * evidence))
}

/// How clear the log-odds of some frames are, 0..1; 1 without log-odds.
fn clearness(evidence: Evidence<'_>, range: Range<usize>) -> f64 {
    let Some(odds) = evidence.log_odds.and_then(|odds| odds.get(range)) else { return 1.0 };
    let total: f64 = odds.iter().flatten().map(|odds| odds.abs()).sum();
    (total / (2 * odds.len()).max(1) as f64 / CLEAR_LOG_ODDS).min(1.0)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::super::gait_steps::step_gaits;
    use super::super::gait_tokens::tests::spelled;
    use super::*;

    fn read(text: &str) -> StepGaits {
        step_gaits(&spelled(text, 100.0), 100.0, Evidence::default())
    }

    #[test]
    fn nine_tenths_of_the_known_frames_make_a_class() {
        let clip = |text: &str| clip_gait(&read(text), Evidence::default());
        assert_eq!(clip(""), None);
        assert_eq!(clip("L.3").unwrap().class, Gait::Unknown);
        assert_eq!(clip("L.3").unwrap().confidence, 0.0);
        assert_eq!(clip("B9 L.25 N.2 L.25 N.3 L.0").unwrap().class, Gait::Stand);
        let mixed = clip("B1 L.4 B.15 R.4 B.15 L.4").unwrap();
        assert_eq!(mixed.class, Gait::Other);
        assert!(mixed.confidence < 0.8, "{}", mixed.confidence);
    }

    #[test]
    fn the_class_is_what_nine_tenths_of_the_known_frames_have() {
        let frames = |parts: &[(Gait, usize)]| -> Gait {
            let frames: Vec<Gait> = parts.iter().flat_map(|&(gait, n)| std::iter::repeat_n(gait, n)).collect();
            class_of_frames(&frames)
        };
        assert_eq!(frames(&[]), Gait::Unknown);
        assert_eq!(frames(&[(Gait::Walk, 9), (Gait::Stand, 1)]), Gait::Walk);
        assert_eq!(frames(&[(Gait::Walk, 8), (Gait::Stand, 1)]), Gait::Other);
        assert_eq!(frames(&[(Gait::Run, 5), (Gait::Unknown, 5)]), Gait::Run);
        assert_eq!(frames(&[(Gait::Run, 5), (Gait::Unknown, 6)]), Gait::Unknown);
        assert_eq!(frames(&[(Gait::Unknown, 1)]), Gait::Unknown);
    }

    #[test]
    fn separate_standing_jumps_are_a_clip_of_jumps() {
        let clip = |text: &str| clip_gait(&read(text), Evidence::default()).unwrap();
        let jump = clip("B1 N.4 B1");
        assert_eq!((jump.class, jump.confidence), (Gait::Jump, 1.0));
        assert!((jump.fractions[1] - 1.0 / 3.0).abs() < 0.01 && (jump.fractions[4] - 2.0 / 3.0).abs() < 0.01);
        assert_eq!(clip("B3 N.4 B4 N.4 B2").class, Gait::Other, "too few");
        assert_eq!(clip("B3 N.4 B3 N.4 B2").class, Gait::Jump);
        assert_eq!(clip("B30 N.4 B1").class, Gait::Stand);
        assert_eq!(clip("B1 N.4 B1 L.4 B.15 R.4 B.15 L.4 B.15").class, Gait::Other, "steps are no stand");
    }

    #[test]
    fn clear_steps_make_sure_clips() {
        let clip = |text: &str| clip_gait(&read(text), Evidence::default()).unwrap();
        let walk = clip("L.4 B.12 R.4 B.12 L.4 B.12 R.4");
        assert_eq!(walk.class, Gait::Walk);
        assert!((walk.confidence - 1.0 / (1.0 + (-4.0_f64).exp())).abs() < 1e-12);
        // Gaps of 30 ms: half a unit for walking.
        let doubtful = clip("L.4 N.03 R.4 N.03 L.4 N.03 R.4");
        assert_eq!(doubtful.class, Gait::Walk);
        assert!((doubtful.confidence - 1.0 / (1.0 + (-1.0_f64).exp())).abs() < 1e-9, "{}", doubtful.confidence);
        let odds = vec![[0.9, -0.9]; walk_frames()];
        let evidence = Evidence { log_odds: Some(&odds), ..Evidence::default() };
        let gaits = read("L.4 B.12 R.4 B.12 L.4 B.12 R.4");
        assert!((clip_gait(&gaits, evidence).unwrap().confidence - walk.confidence / 2.0).abs() < 1e-12);
    }

    fn walk_frames() -> usize {
        spelled("L.4 B.12 R.4 B.12 L.4 B.12 R.4", 100.0).len()
    }

    #[test]
    fn segments_and_frames_have_their_own_confidence() {
        let gaits = read("B2 L.4 B.12 R.4 N.02 L.4 B.12 R.4 B2");
        let segments = segments(&gaits, Evidence::default());
        assert_eq!(
            segments.iter().map(|segment| segment.gait).collect::<Vec<_>>(),
            [Gait::Stand, Gait::Walk, Gait::Stand]
        );
        assert_eq!(segments[0].confidence, Some(1.0));
        let (sure, doubtful) = (1.0 / (1.0 + (-4.0_f64).exp()), 1.0 / (1.0 + (-2.0_f64).exp()));
        let wanted = ((2.0 * sure + doubtful) / 3.0) as f32;
        assert!((segments[1].confidence.unwrap() - wanted).abs() < 1e-6);
        let frames = frame_confidences(&gaits, Evidence::default());
        let middle = gaits.steps[1].middle() as usize;
        assert!((frames[middle].unwrap() - doubtful as f32).abs() < 1e-6);
        assert!((frames[segments[1].first as usize].unwrap() - sure as f32).abs() < 1e-6);
        assert_eq!(frames[0], Some(1.0));
        assert_eq!(frame_confidences(&read("L.3"), Evidence::default()), vec![None; 30]);
    }

    #[test]
    fn duty_is_stance_over_stride() {
        assert_eq!(duty_factor(&read("B2")), None);
        // A stride of 1 s: each foot planted for 0.4 s and two double supports of 0.1 s.
        let walk = "L.4 B.1 R.4 B.1 ".repeat(4);
        assert!((duty_factor(&read(&walk)).unwrap() - 0.6).abs() < 1e-9);
        let run = "L.2 N.1 R.2 N.1 ".repeat(4);
        assert!((duty_factor(&read(&run)).unwrap() - 1.0 / 3.0).abs() < 1e-9);
    }
}
