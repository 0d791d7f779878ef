//! Which gaits are taken for which, of frames or of whole clips (T 3.2.2).

use super::contacts::share;
use super::frame_truth::LengthsDiffer;
use crate::annotate::Gait;

/// How often each true gait was found as each: of frames, or of clips, where [`Gait::Other`] is a class too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GaitConfusion {
    /// `[truth][found]`, in the order of [`GaitConfusion::ALL`].
    counts: [[u64; 6]; 6],
}

impl GaitConfusion {
    /// Every gait, in the order of rows and columns.
    pub const ALL: [Gait; 6] = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump, Gait::Other];

    /// The frames of a clip; those without a label are left out.
    ///
    /// # Errors
    /// [`LengthsDiffer`].
    pub fn of_frames(found: &[Option<Gait>], truth: &[Gait]) -> Result<GaitConfusion, LengthsDiffer> {
        if found.len() != truth.len() {
            return Err(LengthsDiffer { labels: found.len(), truth: truth.len() });
        }
        let mut confusion = GaitConfusion::default();
        for (found, &truth) in found.iter().zip(truth) {
            if let Some(found) = *found {
                confusion.add(truth, found);
            }
        }
        Ok(confusion)
    }

    /// Counts one more.
    pub fn add(&mut self, truth: Gait, found: Gait) {
        self.counts[truth as usize][found as usize] += 1;
    }

    /// Adds another matrix: sums, the same in any order.
    pub fn merge(&mut self, other: &GaitConfusion) {
        for (row, other) in self.counts.iter_mut().zip(&other.counts) {
            row.iter_mut().zip(other).for_each(|(count, other)| *count += other);
        }
    }

    /// How often a true gait was found as another, or as itself.
    pub fn count(&self, truth: Gait, found: Gait) -> u64 {
        self.counts[truth as usize][found as usize]
    }

    /// How often a gait was true.
    pub fn of_truth(&self, truth: Gait) -> u64 {
        self.counts[truth as usize].iter().sum()
    }

    /// How often a gait was found.
    pub fn of_found(&self, found: Gait) -> u64 {
        self.counts.iter().map(|row| row[found as usize]).sum()
    }

    /// All that was counted, unknown truth too.
    pub fn total(&self) -> u64 {
        self.counts.iter().flatten().sum()
    }

    /// How often the truth was known.
    pub fn known(&self) -> u64 {
        self.total() - self.of_truth(Gait::Unknown)
    }

    /// How often a known truth was found.
    pub fn right(&self) -> u64 {
        Self::ALL[1..].iter().map(|&gait| self.count(gait, gait)).sum()
    }

    /// Share right of what is known. None, here and below: there is nothing to take a share of.
    pub fn share_right(&self) -> Option<f64> {
        share(self.right(), self.known())
    }

    /// Share right of what was found as a gait and whose truth is known. Of [`Gait::Unknown`]: none.
    pub fn precision(&self, found: Gait) -> Option<f64> {
        let known = self.of_found(found) - self.count(Gait::Unknown, found);
        share(self.count(found, found), known).filter(|_| found != Gait::Unknown)
    }

    /// Share found of what a gait is true of. Of [`Gait::Unknown`]: none.
    pub fn recall(&self, truth: Gait) -> Option<f64> {
        share(self.count(truth, truth), self.of_truth(truth)).filter(|_| truth != Gait::Unknown)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn shares_leave_out_what_nobody_knows() {
        use Gait::{Run, Stand, Unknown, Walk};
        let found = [Walk, Walk, Run, Stand, Unknown, Walk].map(Some);
        let truth = [Walk, Walk, Walk, Unknown, Run, Unknown];
        let confusion = GaitConfusion::of_frames(&found, &truth).unwrap();
        assert_eq!((confusion.total(), confusion.known(), confusion.right()), (6, 4, 2));
        assert_eq!(confusion.share_right(), Some(0.5));
        assert_eq!((confusion.precision(Walk), confusion.recall(Walk)), (Some(1.0), Some(2.0 / 3.0)));
        assert_eq!((confusion.precision(Run), confusion.recall(Run)), (Some(0.0), Some(0.0)));
        assert_eq!((confusion.precision(Stand), confusion.recall(Stand)), (None, None));
        assert_eq!((confusion.precision(Unknown), confusion.recall(Unknown)), (None, None));
        assert_eq!((confusion.count(Walk, Run), confusion.count(Unknown, Walk)), (1, 1));
        assert_eq!(GaitConfusion::of_frames(&found, &[]), Err(LengthsDiffer { labels: 6, truth: 0 }));
        assert_eq!(GaitConfusion::default().share_right(), None);
    }

    #[test]
    fn tables_3_3_of_the_thesis_in_figures() {
        // Seven clips; the front kick, whose class is another, was taken for a walk.
        let mut clips = GaitConfusion::default();
        for (truth, found) in
            [(Gait::Walk, Gait::Walk); 4].into_iter().chain([(Gait::Jump, Gait::Jump), (Gait::Run, Gait::Run)])
        {
            clips.add(truth, found);
        }
        clips.add(Gait::Other, Gait::Walk);
        assert_eq!((clips.right(), clips.known()), (6, 7));
        assert_eq!((clips.precision(Gait::Walk), clips.recall(Gait::Walk)), (Some(0.8), Some(1.0)));
        assert_eq!((clips.precision(Gait::Other), clips.recall(Gait::Other)), (None, Some(0.0)));
    }

    fn gaits() -> impl Strategy<Value = Vec<Gait>> {
        prop::collection::vec(prop::sample::select(GaitConfusion::ALL[..5].to_vec()), 0..60)
    }

    proptest! {
        #[test]
        fn gaits_against_themselves_are_right(gaits in gaits()) {
            let found: Vec<Option<Gait>> = gaits.iter().copied().map(Some).collect();
            let confusion = GaitConfusion::of_frames(&found, &gaits).unwrap();
            prop_assert_eq!(confusion.right(), confusion.known());
            prop_assert!(confusion.share_right().is_none_or(|share| share == 1.0));
        }

        #[test]
        fn swapped_roles_swap_precision_and_recall(a in gaits(), b in gaits()) {
            let n = a.len().min(b.len());
            let known = |gaits: &[Gait]| gaits[..n].iter().map(|&gait| gait.max(Gait::Stand)).collect::<Vec<_>>();
            let (a, b) = (known(&a), known(&b));
            let some = |gaits: &[Gait]| gaits.iter().copied().map(Some).collect::<Vec<_>>();
            let there = GaitConfusion::of_frames(&some(&a), &b).unwrap();
            let back = GaitConfusion::of_frames(&some(&b), &a).unwrap();
            for gait in GaitConfusion::ALL {
                prop_assert_eq!(there.precision(gait), back.recall(gait));
            }
            prop_assert_eq!(there.share_right(), back.share_right());
        }

        #[test]
        fn clips_add_up_in_any_order(a in gaits(), b in gaits()) {
            let of = |gaits: &[Gait]| {
                let found: Vec<Option<Gait>> = gaits.iter().rev().copied().map(Some).collect();
                GaitConfusion::of_frames(&found, gaits).unwrap()
            };
            let (mut ab, mut ba) = (of(&a), of(&b));
            ab.merge(&of(&b));
            ba.merge(&of(&a));
            prop_assert_eq!(ab, ba);
            prop_assert_eq!(ab.total(), (a.len() + b.len()) as u64);
        }
    }
}
