//! Phase of the stride: 0 at the left foot's strike, 1 at its next.

use super::gait_steps::StepGaits;
use super::gait_summary::stances;
use super::labels::{Foot, Gait};

/// Phase of every frame, 0..1; None outside walk and run.
///
/// Linear between two left strikes of one bout (consecutive frames of walk or run). Before a bout's first left strike
/// and after its last the nearest stride goes on at its pace: the left foot's, else the right's. None in a bout
/// that has no left strike or no stride.
pub fn stride_phases(gaits: &StepGaits) -> Vec<Option<f32>> {
    let left = strikes(gaits, Foot::Left);
    let right = strikes(gaits, Foot::Right);
    let mut phases = vec![None; gaits.gaits.len()];
    let moves = |frame: usize| matches!(gaits.gaits[frame], Gait::Walk | Gait::Run);
    let mut first = 0;
    while first < phases.len() {
        let mut end = first + 1;
        while end < phases.len() && moves(end) == moves(first) {
            end += 1;
        }
        if moves(first) {
            let within = |strikes: &[usize]| {
                let from = strikes.partition_point(|&strike| strike < first);
                from..strikes.partition_point(|&strike| strike < end)
            };
            fill_bout(&mut phases[first..end], first, &left[within(&left)], &right[within(&right)]);
        }
        first = end;
    }
    phases
}

/// Frames at which a foot strikes; not the start of the clip.
fn strikes(gaits: &StepGaits, foot: Foot) -> Vec<usize> {
    stances(&gaits.runs, foot).into_iter().map(|stance| stance.start).filter(|&first| first > 0).collect()
}

fn fill_bout(phases: &mut [Option<f32>], first: usize, left: &[usize], right: &[usize]) {
    let stride = |strikes: &[usize]| strikes.windows(2).next().map(|pair| pair[1] - pair[0]);
    let last_stride = |strikes: &[usize]| strikes.windows(2).next_back().map(|pair| pair[1] - pair[0]);
    let Some(before) = stride(left).or(stride(right)) else { return };
    let Some(after) = last_stride(left).or(last_stride(right)) else { return };
    let (Some(&first_strike), Some(&last_strike)) = (left.first(), left.last()) else { return };
    let mut next = 0;
    for (offset, phase) in phases.iter_mut().enumerate() {
        let frame = first + offset;
        while left.get(next).is_some_and(|&strike| strike <= frame) {
            next += 1;
        }
        let (done, stride) = if frame < first_strike {
            let to_strike = (first_strike - frame) % before;
            ((before - to_strike) % before, before)
        } else if frame >= last_strike {
            ((frame - last_strike) % after, after)
        } else {
            (frame - left[next - 1], left[next] - left[next - 1])
        };
        *phase = Some((done as f64 / stride as f64) as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::super::gait_steps::{Evidence, step_gaits};
    use super::super::gait_tokens::tests::spelled;
    use super::*;

    fn phases(text: &str) -> Vec<Option<f32>> {
        stride_phases(&step_gaits(&spelled(text, 10.0), 10.0, Evidence::default()))
    }

    #[test]
    fn phase_counts_from_the_left_strike() {
        // Left strikes at frames 6, 16, 26.
        let phases = phases("R.6 L.5 R.5 L.5 R.5 L.5");
        assert_eq!(phases[6], Some(0.0));
        assert_eq!(phases[11], Some(0.5));
        assert_eq!(phases[15], Some(0.9));
        assert_eq!(phases[16], Some(0.0));
        assert_eq!(phases[1], Some(0.5));
        assert_eq!(phases[0], Some(0.4));
        assert_eq!(phases[30], Some(0.4));
    }

    #[test]
    fn strides_stretch_and_shrink() {
        // Left strikes at 5, 15 and 35.
        let phases = phases("R.5 L.5 R.5 L1 R1 L.2");
        assert_eq!([phases[10], phases[20], phases[30]], [Some(0.5), Some(0.25), Some(0.75)]);
        assert_eq!(phases[36], Some(0.05));
    }

    #[test]
    fn right_strides_stand_in_and_stands_have_none() {
        // One left strike at 25, right strikes at 20 and 30.
        let phases = phases("B2 R.5 L.5 R.5 B2");
        assert_eq!((phases[0], phases[54]), (None, None));
        assert!(phases[25].is_none_or(|phase| phase == 0.0));
        let flown = super::stride_phases(&step_gaits(&spelled("L1 R1", 10.0), 10.0, Evidence::default()));
        assert!(flown.iter().all(Option::is_none), "one step is no stride");
        let right = super::stride_phases(&step_gaits(&spelled("L.4 R.4 L.6 R.4", 10.0), 10.0, Evidence::default()));
        assert_eq!(right[8], Some(0.0));
        assert_eq!(right[13], Some(0.5));
        assert_eq!(right[4], Some(0.6));
    }

    #[test]
    fn no_frames_no_phases() {
        assert_eq!(stride_phases(&StepGaits::default()), []);
    }
}
