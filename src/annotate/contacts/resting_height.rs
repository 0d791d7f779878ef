//! How high ankles and toes lie when a foot rests on the ground.

use super::foot_paths::{FEET, FootPaths, joints_of, speeds};
use crate::annotate::order_statistics::percentile;

/// Side of the baseline over which a joint is judged to be slow (CONTACTS 2.4), seconds.
const SLOW_BASELINE_S: f64 = 1.0 / 30.0;
/// Speed threshold that the search for slow samples starts from, scaled m/s.
const SPEED_THRESHOLD_MPS: f64 = 1.0;
/// Samples below this share of the threshold are slow (CONTACTS 2.7).
const SLOW_SHARE: f64 = 0.5;
/// With fewer slow samples than this number, or this share of the clip, all samples count (CONTACTS 2.7).
const FEWEST_SLOW: (f64, f64) = (3.0, 0.05);
/// Slow samples count up to this height, scaled metres, above that percentile of them (CONTACTS 2.7).
const LOW_BAND: (f64, f64) = (0.12, 2.0);
/// A foot that rests this much higher than the other never rested (CONTACTS 2.7), scaled metres.
const APART_M: f64 = 0.03;

/// Heights of the feet's joints at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct RestingHeights {
    /// World height in scaled metres, in the order of `FOOT_JOINTS`. None: no such joint, or no frames.
    pub height: [Option<f64>; 4],
    /// Whether a joint's own resting height was replaced by the other foot's, which lies far lower.
    pub apart: bool,
}

impl RestingHeights {
    /// Mean over feet of the toe's resting height (the ankle's where there is no toe), scaled metres.
    pub fn of_feet(&self) -> Option<f64> {
        let [left, right] = FEET.map(|foot| {
            let [ankle, toe] = joints_of(foot);
            self.height[toe].or(self.height[ankle])
        });
        Some((left? + right?) / 2.0)
    }
}

/// Resting heights for fixed thresholds: as [`resting_heights_where`], slow being half of 1 m/s.
pub fn resting_heights(feet: &FootPaths) -> RestingHeights {
    let heights = feet
        .paths
        .each_ref()
        .map(|path| Some(path.as_deref()?.iter().map(|position| position.y).collect::<Vec<f64>>()));
    let slow = feet.paths.each_ref().map(|path| slow_frames(path.as_deref().unwrap_or(&[]), feet));
    resting_heights_where(heights.each_ref().map(Option::as_deref), |joint, frame| slow[joint][frame])
}

/// Resting heights by foot and joint (CONTACTS 2.7): the mode of the heights at which the joint is slow. A foot whose
/// mode lies far above the other's takes the other's. No global floor is needed, so a floor offset drops out.
///
/// `heights`: `[foot joint][frame]`, scaled metres; `is_slow(joint, frame)`.
pub fn resting_heights_where(heights: [Option<&[f64]>; 4], is_slow: impl Fn(usize, usize) -> bool) -> RestingHeights {
    let own = [0, 1, 2, 3].map(|joint| {
        let heights = heights[joint]?;
        let slow: Vec<f64> =
            heights.iter().enumerate().filter(|(frame, _)| is_slow(joint, *frame)).map(|(_, height)| *height).collect();
        let few = (slow.len() as f64) < FEWEST_SLOW.0.max(FEWEST_SLOW.1 * heights.len() as f64);
        low_mode(if few { heights.to_vec() } else { slow })
    });
    let mut rest = RestingHeights { height: own, apart: false };
    for kind in [0, 1] {
        let [left, right] = FEET.map(|foot| joints_of(foot)[kind]);
        if let (Some(a), Some(b)) = (own[left], own[right]) {
            let lowest = a.min(b);
            for joint in [left, right] {
                if own[joint].is_some_and(|height| height > lowest + APART_M) {
                    rest.height[joint] = Some(lowest);
                    rest.apart = true;
                }
            }
        }
    }
    rest
}

/// The clip's lowest ankle and toe, over both feet (CONTACTS 4: the resting height of the fixed thresholds).
pub fn clip_minimum(feet: &FootPaths) -> RestingHeights {
    let lowest = feet.paths.each_ref().map(|path| path.iter().flatten().map(|p| p.y).min_by(f64::total_cmp));
    let height = [0, 1, 2, 3].map(|joint: usize| {
        let other = lowest[(joint + 2) % 4];
        lowest[joint].map(|height| other.map_or(height, |other| height.min(other)))
    });
    RestingHeights { height, apart: false }
}

/// Frames in which the joint is slow against the frames before or after (CONTACTS 2.4).
fn slow_frames(path: &[glam::DVec3], feet: &FootPaths) -> Vec<bool> {
    let step = feet.frames_in(SLOW_BASELINE_S);
    let forward = speeds(path, step, feet.rate_hz);
    let slow = |speed: Option<&f64>| speed.is_some_and(|&speed| speed < SLOW_SHARE * SPEED_THRESHOLD_MPS);
    (0..path.len())
        .map(|frame| slow(forward.get(frame)) || frame.checked_sub(step).is_some_and(|at| slow(forward.get(at))))
        .collect()
}

/// The half-sample mode of the low part of the heights.
fn low_mode(mut heights: Vec<f64>) -> Option<f64> {
    let ceiling = percentile(&mut heights, LOW_BAND.1)? + LOW_BAND.0;
    heights.retain(|&height| height < ceiling);
    heights.sort_unstable_by(f64::total_cmp);
    half_sample_mode(&heights)
}

/// Keeps the tightest half of sorted values (the lowest of equals) until three or fewer are left; their mean.
pub(super) fn half_sample_mode(mut sorted: &[f64]) -> Option<f64> {
    while sorted.len() > 3 {
        let half = sorted.len().div_ceil(2);
        let mut tightest = (f64::INFINITY, 0);
        for first in 0..=sorted.len() - half {
            let width = sorted[first + half - 1] - sorted[first];
            if width < tightest.0 {
                tightest = (width, first);
            }
        }
        sorted = &sorted[tightest.1..tightest.1 + half];
    }
    (!sorted.is_empty()).then(|| sorted.iter().sum::<f64>() / sorted.len() as f64)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use glam::DVec3;

    /// Feet whose joints have the heights and places along X given, one list a joint, at 30 Hz.
    fn feet(joints: [Option<Vec<(f64, f64)>>; 4]) -> FootPaths {
        let n_frames = joints[0].as_ref().unwrap().len();
        let paths = joints
            .map(|joint| joint.map(|joint| joint.into_iter().map(|(x, height)| DVec3::new(x, height, 0.0)).collect()));
        FootPaths { n_frames, rate_hz: 30.0, leg_length_m: 0.9, leg_spread_m: 0.0, scale: 1.0, paths }
    }

    /// 30 frames at rest, 30 frames of a swing at 3 m/s that passes below the resting height.
    fn rest_and_swing(height: f64) -> Vec<(f64, f64)> {
        let rest = (0..30).map(|frame| (0.0, height + 0.0001 * f64::from(frame % 7)));
        rest.chain((1..31).map(|frame| (f64::from(frame) * 0.1, height - 0.02 + 0.01 * f64::from(frame)))).collect()
    }

    #[test]
    fn the_resting_height_is_where_the_joint_is_slow() {
        let feet = feet([Some(rest_and_swing(0.08)), Some(rest_and_swing(0.03)), Some(rest_and_swing(0.09)), None]);
        let rest = resting_heights(&feet);
        assert!((rest.height[0].unwrap() - 0.0803).abs() < 0.0004, "{rest:?}");
        assert!((rest.height[1].unwrap() - 0.0303).abs() < 0.0004, "{rest:?}");
        assert!((rest.height[2].unwrap() - 0.0903).abs() < 0.0004, "{rest:?}");
        assert_eq!((rest.height[3], rest.apart), (None, false));
        assert!((clip_minimum(&feet).height[2].unwrap() - 0.07).abs() < 1e-12);
    }

    #[test]
    fn a_foot_that_never_rests_takes_the_others_height() {
        let raised = vec![(0.0, 0.5); 60];
        let feet = feet([Some(rest_and_swing(0.08)), None, Some(raised), None]);
        let rest = resting_heights(&feet);
        assert_eq!(rest.height[0], rest.height[2]);
        assert!(rest.apart);
    }

    #[test]
    fn a_foot_that_is_always_fast_is_judged_by_all_its_frames() {
        let running: Vec<(f64, f64)> = (0..60).map(|frame| (f64::from(frame), 0.1)).collect();
        let feet = feet([Some(running.clone()), None, Some(running), None]);
        assert_eq!(resting_heights(&feet).height[0], Some(0.1));
    }

    #[test]
    fn a_foot_put_up_for_long_does_not_raise_the_ground() {
        let ground = (0..20).map(|frame| (0.0, 0.08 + 0.001 * f64::from(frame % 9)));
        let path: Vec<(f64, f64)> = ground.chain((0..80).map(|_| (0.0, 0.5))).collect();
        let rest = resting_heights(&feet([Some(path.clone()), None, Some(path), None]));
        assert!(rest.height[0].unwrap() < 0.09, "{rest:?}");
    }

    #[test]
    fn modes_of_small_sets() {
        assert_eq!(half_sample_mode(&[]), None);
        assert_eq!(half_sample_mode(&[2.0]), Some(2.0));
        assert_eq!(half_sample_mode(&[1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!(half_sample_mode(&[0.0, 5.0, 5.5, 9.0, 20.0]), Some((5.0 + 5.5 + 9.0) / 3.0));
    }
}
