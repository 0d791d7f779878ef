//! Which native frames each sample stands for (DESIGN 3).

use crate::annotate::PlantState;
use crate::annotate::samples::sample_of_frame;
use std::ops::Range;

/// The native frames of each sample: a frame belongs to the nearest sample of its own plant-state run, the earlier
/// one if two are as near ([`sample_of_frame`]).
///
/// # Shapes and units
/// `states`: one entry a native frame. `samples`: native frames, ascending, within the clip; a sample that is not has
/// an empty range. The ranges are half-open, ascending, and together cover the clip if there is a sample.
pub fn frame_ranges(states: &[Option<PlantState>], samples: &[u32]) -> Vec<Range<u32>> {
    let samples_of_frames = sample_of_frame(samples, states);
    let mut ranges = Vec::with_capacity(samples.len());
    let mut end = 0;
    for sample in 0..samples.len() as u32 {
        let first = end;
        while samples_of_frames.get(end as usize).is_some_and(|&of_frame| of_frame <= sample) {
            end += 1;
        }
        ranges.push(first..end);
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;
    use PlantState::{L, LB, R};

    #[test]
    fn frames_go_to_the_nearest_sample_of_their_own_run() {
        // 120 Hz: samples at 0 4 8 12 ..., and the middle of a short run that has none (frame 10).
        let states: Vec<_> =
            [(L, 9), (LB, 3), (R, 6)].into_iter().flat_map(|(state, n)| std::iter::repeat_n(Some(state), n)).collect();
        assert_eq!(frame_ranges(&states, &[0, 4, 8, 10, 12, 16]), [0..3, 3..7, 7..9, 9..12, 12..15, 15..18]);
    }

    #[test]
    fn at_every_frame_a_range_is_that_frame() {
        let states = [Some(L), Some(L), Some(R), Some(L)];
        assert_eq!(frame_ranges(&states, &[0, 1, 2, 3]), [0..1, 1..2, 2..3, 3..4]);
    }

    #[test]
    fn samples_off_the_clip_have_nothing() {
        assert_eq!(frame_ranges(&[None, None], &[1, 2, 700]), [0..2, 2..2, 2..2]);
        assert_eq!(frame_ranges(&[], &[]), []);
    }
}
