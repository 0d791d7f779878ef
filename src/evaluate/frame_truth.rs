//! What is true of every frame of a clip.

use crate::annotate::{Foot, Gait};
use crate::procedural::Truth;

/// What is true of a clip, frame by frame, as far as somebody knows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTruth {
    /// How many frames it speaks of: from 0 on.
    pub n_frames: usize,
    /// `[foot][frame]`: whether the foot is planted. No foot: nothing is known of it; no entry: nobody knows of that frame.
    pub planted: [Option<Vec<Option<bool>>>; 2],
    /// `[foot]`: strike and lift-off of its stances, seconds from frame 0, in any order, where they are known better
    /// than by frames; beyond the clip, or infinite, where they are not in it.
    pub stance_times_s: [Vec<[f64; 2]>; 2],
    /// `[frame]`; [`Gait::Unknown`] where nobody knows.
    pub gait: Option<Vec<Gait>>,
}

/// Labels and truth are of different clips, or of different parts of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the clip has {labels} frames, its truth {truth}")]
pub struct LengthsDiffer {
    /// Frames that have labels.
    pub labels: usize,
    /// Frames whose truth is known.
    pub truth: usize,
}

impl From<&Truth> for FrameTruth {
    /// Truth of a made person, with the times of its footstep plan.
    fn from(truth: &Truth) -> FrameTruth {
        let marks = |contact: &[bool]| Some(contact.iter().copied().map(Some).collect());
        let times_s = |foot: Foot| {
            let own = truth.stances.iter().filter(|stance| stance.foot == foot);
            own.map(|stance| [stance.strike_s, stance.lift_s]).collect()
        };
        FrameTruth {
            n_frames: truth.gait.len(),
            planted: [marks(&truth.left_contact), marks(&truth.right_contact)],
            stance_times_s: [times_s(Foot::Left), times_s(Foot::Right)],
            gait: Some(truth.gait.clone()),
        }
    }
}
