//! Foot contacts against truth, by frames (T 3.1.2) and by stances (CONTACTS 6).

use super::frame_truth::{FrameTruth, LengthsDiffer};
use super::stances::{Stance, overlaps, refine, stances};
use super::time_errors::TimeErrors;
use crate::annotate::FrameLabels;
use core::ops::Range;

/// How found contacts compare with true ones, over any number of feet and clips.
///
/// # What is counted
/// - **Foot-frames**: one foot in one frame. Frames without a label, or without truth, are left out.
/// - **Stances**: longest runs of planted frames of one foot. A clip's ends, and frames left out, bound what is known: a
///   transition there is none. A stance *counts* if both its transitions are known and are 100 ms or more apart.
/// - **Missed**: true stances that count and share no frame with a found stance of the foot, of any length.
/// - **Spurious**: found stances that count and share no frame with a true stance of the foot, of any length.
/// - **Strikes, lift-offs**: found minus true time, of stances that share frames with each other and with no third one
///   (matched one to one), where both transitions are known. A transition lies half a frame before the first frame that
///   follows it, unless the truth knows its time better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactScore {
    /// Foot-frames planted in both.
    pub true_positives: u64,
    /// Foot-frames found planted that are not.
    pub false_positives: u64,
    /// Foot-frames planted that were not found.
    pub false_negatives: u64,
    /// Foot-frames planted in neither.
    pub true_negatives: u64,
    /// True stances that count.
    pub true_stances: u64,
    /// Found stances that count.
    pub found_stances: u64,
    /// True stances that count and that no found one overlaps.
    pub missed: u64,
    /// Found stances that count and that overlap no true one.
    pub spurious: u64,
    /// Found minus true time of strikes.
    pub strikes: TimeErrors,
    /// Found minus true time of lift-offs.
    pub lift_offs: TimeErrors,
}

impl ContactScore {
    /// Both feet of a clip.
    ///
    /// # Errors
    /// [`LengthsDiffer`] if the truth is of another number of frames.
    pub fn of_clip(labels: &FrameLabels, truth: &FrameTruth, rate_hz: f64) -> Result<ContactScore, LengthsDiffer> {
        let mut score = ContactScore::default();
        for ((found, truth_of_foot), times_s) in labels.stance.iter().zip(&truth.planted).zip(&truth.stance_times_s) {
            if let Some(planted) = truth_of_foot {
                score.merge(&ContactScore::of_foot(found, planted, times_s, rate_hz)?);
            }
        }
        Ok(score)
    }

    /// One foot of a clip.
    ///
    /// # Shapes and units
    /// `found`, `truth`: `[frame]`, planted or not, None: not known. `true_times_s`: strike and lift-off of true
    /// stances, seconds from frame 0, where they are known better than by frames; may be empty. `rate_hz` > 0.
    ///
    /// # Errors
    /// [`LengthsDiffer`].
    ///
    /// # Example
    /// ```
    /// use motionmill::evaluate::ContactScore;
    /// let marks = |text: &str| text.bytes().map(|mark| Some(mark == b'x')).collect::<Vec<_>>();
    /// let score = ContactScore::of_foot(&marks("..xxxx.."), &marks("...xxxx."), &[], 10.0)?;
    /// assert_eq!((score.true_positives, score.false_positives, score.false_negatives), (3, 1, 1));
    /// assert_eq!(score.strikes.mean_ms(), Some(-100.0));
    /// # Ok::<(), motionmill::evaluate::LengthsDiffer>(())
    /// ```
    pub fn of_foot(
        found: &[Option<bool>],
        truth: &[Option<bool>],
        true_times_s: &[[f64; 2]],
        rate_hz: f64,
    ) -> Result<ContactScore, LengthsDiffer> {
        if found.len() != truth.len() {
            return Err(LengthsDiffer { labels: found.len(), truth: truth.len() });
        }
        let mut score = ContactScore::default();
        for (found, truth) in found.iter().zip(truth) {
            match (found, truth) {
                (Some(true), Some(true)) => score.true_positives += 1,
                (Some(true), Some(false)) => score.false_positives += 1,
                (Some(false), Some(true)) => score.false_negatives += 1,
                (Some(false), Some(false)) => score.true_negatives += 1,
                _ => {}
            }
        }
        for known in known_ranges(found, truth) {
            let found = stances(|frame| found[frame] == Some(true), known.clone(), rate_hz);
            let mut truth = stances(|frame| truth[frame] == Some(true), known, rate_hz);
            refine(&mut truth, true_times_s, rate_hz);
            score.add_stances(&found, &truth);
        }
        Ok(score)
    }

    /// Adds another score: sums, the same in any order.
    pub fn merge(&mut self, other: &ContactScore) {
        let ContactScore { true_positives, false_positives, false_negatives, true_negatives, .. } = other;
        self.true_positives += true_positives;
        self.false_positives += false_positives;
        self.false_negatives += false_negatives;
        self.true_negatives += true_negatives;
        self.true_stances += other.true_stances;
        self.found_stances += other.found_stances;
        self.missed += other.missed;
        self.spurious += other.spurious;
        self.strikes.merge(&other.strikes);
        self.lift_offs.merge(&other.lift_offs);
    }

    /// Foot-frames that were compared.
    pub fn foot_frames(&self) -> u64 {
        self.true_positives + self.false_positives + self.false_negatives + self.true_negatives
    }

    /// Share of the frames found planted that are. None, here and below: there are none to take a share of.
    pub fn precision(&self) -> Option<f64> {
        share(self.true_positives, self.true_positives + self.false_positives)
    }

    /// Share of the planted frames that were found.
    pub fn recall(&self) -> Option<f64> {
        share(self.true_positives, self.true_positives + self.false_negatives)
    }

    /// Harmonic mean of precision and recall.
    pub fn f1(&self) -> Option<f64> {
        let both = 2 * self.true_positives;
        share(both, both + self.false_positives + self.false_negatives)
    }

    /// Share of the frames not planted that were found so.
    pub fn specificity(&self) -> Option<f64> {
        share(self.true_negatives, self.true_negatives + self.false_positives)
    }

    /// Share of all frames that are right.
    pub fn accuracy(&self) -> Option<f64> {
        share(self.true_positives + self.true_negatives, self.foot_frames())
    }

    /// Stances of a stretch of frames, in time.
    fn add_stances(&mut self, found: &[Stance], truth: &[Stance]) {
        let (of_found, of_truth) = (overlaps(found, truth), overlaps(truth, found));
        let tally = |stances: &[Stance], partners: &[Range<usize>]| {
            let counting = || stances.iter().zip(partners).filter(|(stance, _)| stance.counts());
            let alone = counting().filter(|(_, partners)| partners.is_empty()).count();
            (counting().count() as u64, alone as u64)
        };
        let ((n_found, spurious), (n_true, missed)) = (tally(found, &of_found), tally(truth, &of_truth));
        self.found_stances += n_found;
        self.spurious += spurious;
        self.true_stances += n_true;
        self.missed += missed;
        for (truth, partners) in truth.iter().zip(&of_truth) {
            let only = partners.clone().filter(|_| partners.len() == 1).find(|&at| of_found[at].len() == 1);
            let Some(found) = only.map(|at| &found[at]) else { continue };
            if let (Some(found_s), Some(true_s)) = (found.strike_s, truth.strike_s) {
                self.strikes.add(found_s - true_s);
            }
            if let (Some(found_s), Some(true_s)) = (found.lift_off_s, truth.lift_off_s) {
                self.lift_offs.add(found_s - true_s);
            }
        }
    }
}

/// Part over whole.
pub(super) fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// Longest ranges of frames in which label and truth are both known.
fn known_ranges(found: &[Option<bool>], truth: &[Option<bool>]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for frame in (0..found.len()).filter(|&frame| found[frame].is_some() && truth[frame].is_some()) {
        match ranges.last_mut() {
            Some(last) if last.end == frame => last.end += 1,
            _ => ranges.push(frame..frame + 1),
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    /// `x` planted, `.` not, `?` nobody knows.
    fn marks(text: &str) -> Vec<Option<bool>> {
        text.bytes().map(|mark| (mark != b'?').then_some(mark == b'x')).collect()
    }

    fn of(found: &str, truth: &str, rate_hz: f64) -> ContactScore {
        ContactScore::of_foot(&marks(found), &marks(truth), &[], rate_hz).unwrap()
    }

    #[test]
    fn the_thesis_table_gives_the_thesis_numbers() {
        // T table 3.1; it sums to 8,020, not to the 7,640 of the text (CONTACTS 3).
        let score = ContactScore {
            true_positives: 5422,
            false_negatives: 152,
            false_positives: 167,
            true_negatives: 2279,
            ..ContactScore::default()
        };
        assert_eq!(score.foot_frames(), 8_020);
        let figures = [score.precision(), score.recall(), score.specificity(), score.accuracy()];
        for (figure, wanted) in figures.into_iter().zip([0.970120, 0.972731, 0.931725, 0.960224]) {
            assert!((figure.unwrap() - wanted).abs() < 5e-7, "{figure:?}, not {wanted}");
        }
        assert!((score.f1().unwrap() - 0.971423).abs() < 5e-7);
    }

    #[test]
    fn nothing_to_compare_gives_no_figures() {
        let none = of("", "", 30.0);
        assert_eq!(none, ContactScore::default());
        assert_eq!([none.precision(), none.recall(), none.f1(), none.specificity(), none.accuracy()], [None; 5]);
        let still = of("....", "....", 30.0);
        assert_eq!((still.precision(), still.specificity(), still.accuracy()), (None, Some(1.0), Some(1.0)));
        assert_eq!(ContactScore::of_foot(&[None], &[], &[], 30.0), Err(LengthsDiffer { labels: 1, truth: 0 }));
    }

    #[test]
    fn a_shift_by_a_frame_is_a_frame_in_ms_at_every_rate() {
        for (rate_hz, frame_ms) in [(24.0, 41.667), (30.0, 33.333), (60.0, 16.667), (120.0, 8.333), (240.0, 4.167)] {
            let score = of(&format!("....{}.....", "x".repeat(24)), &format!(".....{}....", "x".repeat(24)), rate_hz);
            assert_eq!((score.strikes.mean_ms(), score.lift_offs.mean_ms()), (Some(-frame_ms), Some(-frame_ms)));
            assert_eq!((score.true_stances, score.missed, score.spurious), (1, 0, 0));
        }
    }

    #[test]
    fn sub_frame_times_count_where_they_are_known() {
        let planted = marks("...xxxx...");
        let score = ContactScore::of_foot(&planted, &planted, &[[0.29, 0.61]], 10.0).unwrap();
        // Found at 2.5 and 6.5 frames.
        assert_eq!((score.strikes.mean_ms(), score.lift_offs.mean_ms()), (Some(-40.0), Some(40.0)));
    }

    #[test]
    fn transitions_at_the_ends_of_the_clip_are_none() {
        let score = of("xxxxx.....xxxxx", "xxxx......xxxxx", 30.0);
        assert_eq!((score.true_stances, score.found_stances), (0, 0));
        assert_eq!((score.strikes.count(), score.lift_offs.count()), (1, 1));
        assert_eq!((score.strikes.mean_ms(), score.lift_offs.mean_ms()), (Some(0.0), Some(33.333)));
        // One of both is inside: the other has no time.
        let cut = of("xxxxxx....", "..xxxx....", 30.0);
        assert_eq!((cut.strikes.count(), cut.lift_offs.count()), (0, 1));
    }

    #[test]
    fn missed_and_spurious_stances_are_long_ones_that_overlap_nothing() {
        let score = of("..xxx........x....xx..", ".........xxx...........".get(..22).unwrap(), 30.0);
        assert_eq!((score.true_stances, score.missed), (1, 1));
        assert_eq!((score.found_stances, score.spurious), (1, 1));
        // Any overlap, by however short a stance, is none missed.
        let touched = of("....x....", "..xxxxx..", 30.0);
        assert_eq!((touched.missed, touched.spurious, touched.found_stances), (0, 0, 0));
        assert_eq!(touched.strikes.mean_ms(), Some(66.667));
    }

    #[test]
    fn a_stance_that_was_found_in_two_has_no_times() {
        let split = of("..xxx.xxxx..", "..xxxxxxxx..", 30.0);
        assert_eq!((split.missed, split.spurious, split.true_stances, split.found_stances), (0, 0, 1, 2));
        assert_eq!((split.strikes.count(), split.lift_offs.count()), (0, 0));
    }

    #[test]
    fn frames_that_nobody_knows_are_ends_of_what_is_known() {
        let score = of("..xxxx..xx?", "..xx??..xxx", 30.0);
        assert_eq!(score.foot_frames(), 8);
        assert_eq!((score.true_stances, score.strikes.count(), score.lift_offs.count()), (0, 2, 0));
    }

    /// The score that found and true contacts have in each other's place.
    fn swapped(score: ContactScore) -> ContactScore {
        ContactScore {
            false_positives: score.false_negatives,
            false_negatives: score.false_positives,
            true_stances: score.found_stances,
            found_stances: score.true_stances,
            missed: score.spurious,
            spurious: score.missed,
            strikes: score.strikes.negated(),
            lift_offs: score.lift_offs.negated(),
            ..score
        }
    }

    /// Marks in runs, as feet make them, with gaps in what is known.
    fn runs() -> impl Strategy<Value = Vec<Option<bool>>> {
        let run = (1_usize..9, prop::sample::select(vec![Some(true), Some(true), Some(false), Some(false), None]));
        prop::collection::vec(run, 0..20)
            .prop_map(|runs| runs.into_iter().flat_map(|(n, mark)| std::iter::repeat_n(mark, n)).collect())
    }

    fn same_length(a: &[Option<bool>], b: &[Option<bool>]) -> usize {
        a.len().min(b.len())
    }

    proptest! {
        #[test]
        fn labels_against_themselves_are_perfect(marks in runs(), rate_hz in 10.0..250.0_f64) {
            let score = ContactScore::of_foot(&marks, &marks, &[], rate_hz).unwrap();
            prop_assert_eq!((score.false_positives, score.false_negatives, score.missed, score.spurious), (0, 0, 0, 0));
            prop_assert_eq!(score.true_stances, score.found_stances);
            let right = |figure: Option<f64>| figure.is_none_or(|figure| figure == 1.0);
            prop_assert!(right(score.precision()) && right(score.recall()) && right(score.f1()));
            prop_assert!(right(score.specificity()) && right(score.accuracy()));
            prop_assert!(score.strikes.mean_ms().is_none_or(|mean| mean == 0.0));
            prop_assert!(score.lift_offs.sd_ms().is_none_or(|sd| sd == 0.0));
        }

        #[test]
        fn swapped_roles_swap_the_figures(a in runs(), b in runs(), rate_hz in 10.0..250.0_f64) {
            let n = same_length(&a, &b);
            let there = ContactScore::of_foot(&a[..n], &b[..n], &[], rate_hz).unwrap();
            let back = ContactScore::of_foot(&b[..n], &a[..n], &[], rate_hz).unwrap();
            prop_assert_eq!((there.precision(), there.recall()), (back.recall(), back.precision()));
            prop_assert_eq!((there.f1(), there.accuracy()), (back.f1(), back.accuracy()));
            prop_assert_eq!(swapped(there), back);
        }

        #[test]
        fn stances_that_overlap_one_to_one_swap_with_their_times(
            gaps in prop::collection::vec((6_usize..12, 8_usize..20, 0_usize..4), 1..8),
        ) {
            // Each stance is found so many frames after it is true.
            let (mut truth, mut found) = (Vec::new(), Vec::new());
            for (before, planted, late) in &gaps {
                truth.extend([vec![Some(false); *before], vec![Some(true); *planted]].concat());
                found.extend([vec![Some(false); before + late], vec![Some(true); planted - late]].concat());
            }
            let [truth, found] = [truth, found].map(|marks| [marks, vec![Some(false); 3]].concat());
            let there = ContactScore::of_foot(&found, &truth, &[], 30.0).unwrap();
            let back = ContactScore::of_foot(&truth, &found, &[], 30.0).unwrap();
            prop_assert_eq!(swapped(there), back);
            let late_us: i64 = gaps.iter().map(|(_, _, late)| (*late as f64 / 30.0 * 1e6).round() as i64).sum();
            let mean_ms = there.strikes.mean_ms().unwrap();
            prop_assert_eq!(there.strikes.count(), gaps.len() as u64);
            prop_assert!((mean_ms * 1e3 * gaps.len() as f64 - late_us as f64).abs() < 1.0, "{}", mean_ms);
            prop_assert_eq!(there.lift_offs.mean_ms(), Some(0.0));
        }

        #[test]
        fn clips_add_up_in_any_order(clips in prop::collection::vec((runs(), runs()), 0..8), turn in 0_usize..8) {
            let scores: Vec<ContactScore> = clips
                .iter()
                .map(|(a, b)| {
                    let n = same_length(a, b);
                    ContactScore::of_foot(&a[..n], &b[..n], &[], 29.97).unwrap()
                })
                .collect();
            let sum = |scores: &mut dyn Iterator<Item = &ContactScore>| {
                let mut sum = ContactScore::default();
                scores.for_each(|score| sum.merge(score));
                sum
            };
            let turn = turn.min(scores.len());
            let forwards = sum(&mut scores.iter());
            prop_assert_eq!(forwards, sum(&mut scores.iter().rev()));
            let (mut a, b) = (sum(&mut scores[turn..].iter()), sum(&mut scores[..turn].iter()));
            a.merge(&b);
            prop_assert_eq!(forwards, a);
        }

        #[test]
        fn any_times_are_taken(
            marks in runs(),
            times in prop::collection::vec([any::<f64>(), any::<f64>()], 0..5),
            rate_hz in any::<f64>(),
        ) {
            let score = ContactScore::of_foot(&marks, &marks, &times, rate_hz).unwrap();
            prop_assert_eq!((score.missed, score.spurious), (0, 0));
        }
    }
}
