//! Samples of ankles and toes that break the length of their bone (CONTACTS 2.2).
//!
//! Files whose bones are rigid never do; spikes of markers and of position channels do.

use super::foot_paths::{FEET, FootPaths, joints_of};
use crate::annotate::order_statistics::{median, robust_deviation};
use glam::DVec3;

/// A bone whose length differs by no more than this from its median is sound, scaled metres.
const SOUND_M: f64 = 0.03;
/// Nor is one that differs by less than so many robust standard deviations odd.
const ODD_DEVIATIONS: f64 = 6.0;

/// Fills ankles and toes that are odd linearly in time from sound neighbors; `knees`: `[foot][frame]`, scaled metres.
///
/// Where the length of the shank is odd the ankle is to blame, where that of the foot is and the shank's is not, the
/// toe. A joint with fewer than two sound samples is left as it is.
pub fn repair(feet: &mut FootPaths, knees: &[Vec<DVec3>; 2]) {
    for foot in FEET {
        let [ankle, toe] = joints_of(foot);
        let odd_shank = feet.paths[ankle].as_ref().and_then(|ankle| odd_samples(ankle, &knees[foot as usize]));
        let odd_foot = match (&feet.paths[ankle], &feet.paths[toe]) {
            (Some(ankle), Some(toe)) => odd_samples(toe, ankle),
            _ => None,
        };
        let odd_toe = odd_foot.map(|mut odd| {
            for (odd, shank) in odd.iter_mut().zip(odd_shank.iter().flatten()) {
                *odd &= !shank;
            }
            odd
        });
        for (joint, odd) in [(ankle, odd_shank), (toe, odd_toe)] {
            if let (Some(path), Some(odd)) = (&mut feet.paths[joint], odd) {
                fill(path, &odd);
            }
        }
    }
}

/// Frames in which the distance of two joints is odd. None: nowhere.
fn odd_samples(joint: &[DVec3], parent: &[DVec3]) -> Option<Vec<bool>> {
    let lengths: Vec<f64> = joint.iter().zip(parent).map(|(joint, parent)| (*joint - *parent).length()).collect();
    let (shortest, longest) =
        lengths.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &length| (low.min(length), high.max(length)));
    // Rigid bones, all but always.
    if longest - shortest <= SOUND_M {
        return None;
    }
    let middle = median(&mut lengths.clone())?;
    let away: Vec<f64> = lengths.iter().map(|length| (length - middle).abs()).collect();
    let limit = SOUND_M.max(ODD_DEVIATIONS * robust_deviation(&mut away.clone())?);
    let odd: Vec<bool> = away.iter().map(|&away| away > limit).collect();
    odd.contains(&true).then_some(odd)
}

/// Replaces odd samples by the line between the sound ones beside them; beyond the first and last sound one by those.
fn fill(path: &mut [DVec3], odd: &[bool]) {
    if odd.iter().filter(|&&odd| !odd).count() < 2 {
        return;
    }
    let mut before: Option<usize> = None;
    let mut frame = 0;
    while frame < path.len() {
        if !odd[frame] {
            before = Some(frame);
            frame += 1;
            continue;
        }
        let after = (frame..path.len()).find(|&at| !odd[at]);
        let end = after.unwrap_or(path.len());
        for at in frame..end {
            path[at] = match (before, after) {
                (Some(before), Some(after)) => {
                    let share = (at - before) as f64 / (after - before) as f64;
                    path[before] + (path[after] - path[before]) * share
                }
                (Some(near), None) | (None, Some(near)) => path[near],
                (None, None) => path[at],
            };
        }
        frame = end;
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn feet(ankle: Vec<DVec3>, toe: Vec<DVec3>) -> FootPaths {
        FootPaths {
            n_frames: ankle.len(),
            rate_hz: 30.0,
            leg_length_m: 0.9,
            leg_spread_m: 0.0,
            scale: 1.0,
            paths: [Some(ankle.clone()), Some(toe.clone()), Some(ankle), Some(toe)],
        }
    }

    /// A leg that moves on along X: knee 0.4 m above the ankle, toe 0.15 m ahead of it.
    fn walk(n_frames: usize) -> (Vec<DVec3>, Vec<DVec3>, Vec<DVec3>) {
        let at = |dx: f64, y: f64| (0..n_frames).map(|frame| DVec3::new(0.02 * frame as f64 + dx, y, 0.0)).collect();
        (at(0.0, 0.5), at(0.0, 0.1), at(0.15, 0.02))
    }

    #[test]
    fn spikes_of_either_joint_are_bridged_and_the_other_is_left() {
        let (knee, ankle, toe) = walk(40);
        let (mut bad_ankle, mut bad_toe) = (ankle.clone(), toe.clone());
        bad_ankle[10..13].iter_mut().for_each(|ankle| ankle.y += 0.3);
        bad_toe[0].x += 1.0;
        bad_toe[30].z += 0.5;
        let mut feet = feet(bad_ankle, bad_toe);
        repair(&mut feet, &[knee.clone(), knee]);
        for (path, wanted) in feet.paths.iter().flatten().zip([&ankle, &toe, &ankle, &toe]) {
            for (frame, (found, wanted)) in path.iter().zip(wanted).enumerate() {
                // The first toe has no sound sample before it and takes the next.
                let slack = if frame == 0 { 0.0201 } else { 1e-12 };
                assert!((*found - *wanted).length() < slack, "frame {frame}: {found}, not {wanted}");
            }
        }
    }

    #[test]
    fn sound_paths_keep_their_bits() {
        let (knee, ankle, toe) = walk(40);
        let mut feet = feet(ankle, toe);
        let before = feet.clone();
        repair(&mut feet, &[knee.clone(), knee]);
        assert_eq!(feet, before);
    }

    #[test]
    fn with_one_sound_sample_nothing_can_be_filled() {
        let mut path = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        fill(&mut path, &[true, false, true]);
        assert_eq!(path, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(odd_samples(&[], &[]), None);
        let (knee, mut ankle, _) = walk(9);
        ankle[4].y -= 2.0;
        assert_eq!(odd_samples(&ankle, &knee).unwrap().iter().filter(|&&odd| odd).count(), 1);
    }
}
