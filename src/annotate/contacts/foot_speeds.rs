//! How fast ankles and toes move, and how slow is still (CONTACTS 2.4, 2.5).
//!
//! Over a baseline of 1/30 s, forward and backward: a frame is still if it is so against either side. The frame of a
//! strike is still forward, that of a lift-off backward, so that neither is late or early by half a frame.

use super::foot_paths::{FEET, FootPaths, joints_of};
use super::noise::Noise;
use glam::DVec3;

/// Baselines a second.
const BASELINES_PER_S: f64 = 30.0;
/// Share of the variance that noise adds to squared speeds which is taken off them.
const DEBIAS_SHARE: f64 = 0.7;
/// The swing beside a frame is sought this far away, seconds.
pub(super) const SWING_REACH_S: f64 = 0.5;
/// A foot is still below this share of the adjacent swing's peak speed, within these limits, scaled m/s.
pub(super) const STILL_SHARE: f64 = 0.25;
pub(super) const STILL_LIMITS_MPS: [f64; 2] = [0.4, 2.0];
/// At a strike and at a lift-off the threshold is smaller for slow swings: its share is the peak over this speed, scaled
/// m/s, at least so much. With one share for all, walks' strikes are found early and their lift-offs late, by plates
/// (CONTACTS 6, with 7 for 8 at the strike) and by plans alike, where those of runs are right.
pub(super) const STRIKE_PEAK_MPS: f64 = 8.0;
const LEAST_STRIKE_SHARE: f64 = 0.4;
pub(super) const LIFT_PEAK_MPS: f64 = 5.0;
const LEAST_LIFT_SHARE: f64 = 0.8;

/// At a strike vertical speed counts this many times: a foot that still comes down has not struck, be it as slow as one
/// that rolls. (CONTACTS 8 asks for the strike from the vertical deceleration.)
pub(super) const DESCENT_WEIGHT: f64 = 2.5;

/// Speeds of the feet's joints and the thresholds of stillness.
#[derive(Clone, Debug)]
pub struct FootSpeeds {
    /// Frames of a baseline.
    step: usize,
    /// `[foot joint][frame]`, from the frame to one baseline later, scaled m/s; shorter than the clip by a baseline.
    raw: [Option<Vec<f64>>; 4],
    /// The same without what noise adds.
    debiased: [Option<Vec<f64>>; 4],
    /// The same with vertical speed weighted.
    descending: [Option<Vec<f64>>; 4],
    /// `[foot][frame]`: mean over joints and sides, scaled m/s.
    pub of_foot_mps: [Vec<f64>; 2],
    /// `[foot][frame]`: below this a foot is still, scaled m/s.
    pub still_mps: [Vec<f64>; 2],
    /// `[foot][frame]`: the same for a foot that comes to rest.
    pub strike_mps: [Vec<f64>; 2],
    /// `[foot][frame]`: the same for a foot that was at rest.
    pub lift_mps: [Vec<f64>; 2],
}

impl FootSpeeds {
    /// Speeds and thresholds of paths that may be smoothed.
    pub fn new(feet: &FootPaths, noise: &Noise) -> FootSpeeds {
        let step = baseline_frames(feet);
        let baseline_s = step as f64 / feet.rate_hz;
        let raw = feet.paths.each_ref().map(|path| {
            let path = path.as_deref()?;
            let later = path.get(step..).unwrap_or(&[]);
            Some(path.iter().zip(later).map(|(from, to)| (*to - *from).length() / baseline_s).collect::<Vec<f64>>())
        });
        // Variance that noise adds to the squared difference of each coordinate.
        let noise_mps = noise.sd_m * noise.smoothed_share / baseline_s;
        let bias_of = |weights: f64| DEBIAS_SHARE * 2.0 * weights * noise_mps * noise_mps;
        let bias = bias_of(3.0);
        let debiased = raw.each_ref().map(|speeds| {
            Some(speeds.as_ref()?.iter().map(|speed| (speed * speed - bias).max(0.0).sqrt()).collect::<Vec<f64>>())
        });
        let bias = bias_of(2.0 + DESCENT_WEIGHT * DESCENT_WEIGHT);
        let weights = DVec3::new(1.0, DESCENT_WEIGHT, 1.0) / baseline_s;
        let descending = feet.paths.each_ref().map(|path| {
            let path = path.as_deref()?;
            let later = path.get(step..).unwrap_or(&[]);
            let square = |(from, to): (&DVec3, &DVec3)| ((*to - *from) * weights).length_squared();
            Some(path.iter().zip(later).map(square).map(|square| (square - bias).max(0.0).sqrt()).collect::<Vec<f64>>())
        });
        let of_foot_mps = FEET.map(|foot| {
            let joints = joints_of(foot).map(|joint| raw[joint].as_deref());
            mean_speeds(joints, step, feet.n_frames)
        });
        let reach = (SWING_REACH_S * feet.rate_hz).round_ties_even() as usize;
        let peaks = of_foot_mps.each_ref().map(|speeds| running_maxima(speeds, reach));
        let thresholds = |of_peak: fn(f64) -> f64| {
            peaks.each_ref().map(|peaks| peaks.iter().map(|&peak| of_peak(peak)).collect::<Vec<f64>>())
        };
        let (still_mps, strike_mps, lift_mps) = (
            thresholds(threshold_mps),
            thresholds(|peak| smaller_for_slow(peak, STRIKE_PEAK_MPS, LEAST_STRIKE_SHARE)),
            thresholds(|peak| smaller_for_slow(peak, LIFT_PEAK_MPS, LEAST_LIFT_SHARE)),
        );
        FootSpeeds { step, raw, debiased, descending, of_foot_mps, still_mps, strike_mps, lift_mps }
    }

    /// Mean speed of a joint over both sides, scaled m/s: of one where the clip cuts the other off. `[frame]`
    pub fn mean_of_joint(&self, joint: usize, n_frames: usize) -> Option<Vec<f64>> {
        Some(mean_speeds([Some(self.raw[joint].as_deref()?), None], self.step, n_frames))
    }

    /// Debiased speed to the frame one baseline later; infinite where the clip ends before.
    pub fn forward(&self, joint: usize, frame: usize) -> f64 {
        at(&self.debiased[joint], Some(frame))
    }

    /// Debiased speed from the frame one baseline earlier; infinite where the clip begins after.
    pub fn backward(&self, joint: usize, frame: usize) -> f64 {
        at(&self.debiased[joint], frame.checked_sub(self.step))
    }

    /// As [`forward`](FootSpeeds::forward), vertical speed counting more.
    pub fn descending(&self, joint: usize, frame: usize) -> f64 {
        at(&self.descending[joint], Some(frame))
    }

    /// The slower side; 0 in a clip of one frame.
    pub fn slower(&self, joint: usize, frame: usize) -> f64 {
        let slower = self.forward(joint, frame).min(self.backward(joint, frame));
        if slower.is_finite() { slower } else { 0.0 }
    }

    /// The faster side that the clip doesn't cut off; 0 in a clip of one frame.
    pub fn faster(&self, joint: usize, frame: usize) -> f64 {
        let sides = [self.forward(joint, frame), self.backward(joint, frame)];
        sides.into_iter().filter(|side| side.is_finite()).fold(0.0, f64::max)
    }
}

/// Frames of a baseline; in a clip that has no room for one on either side of some frame, as many as it has room for.
fn baseline_frames(feet: &FootPaths) -> usize {
    let wanted = (feet.rate_hz / BASELINES_PER_S).round_ties_even().max(1.0);
    let room = feet.n_frames.saturating_sub(1) / 2;
    if wanted < room as f64 { wanted as usize } else { room.max(1) }
}

fn at(speeds: &Option<Vec<f64>>, frame: Option<usize>) -> f64 {
    let speeds = speeds.as_deref().unwrap_or(&[]);
    frame.and_then(|frame| speeds.get(frame)).copied().unwrap_or(f64::INFINITY)
}

/// Mean over both sides of a frame, or the one that is there, and over joints.
fn mean_speeds(joints: [Option<&[f64]>; 2], step: usize, n_frames: usize) -> Vec<f64> {
    let n_joints = joints.iter().flatten().count().max(1) as f64;
    let one = |speeds: &[f64], frame: usize| {
        let (forward, backward) = (speeds.get(frame), frame.checked_sub(step).and_then(|frame| speeds.get(frame)));
        match (forward, backward) {
            (Some(forward), Some(backward)) => (forward + backward) / 2.0,
            (Some(speed), None) | (None, Some(speed)) => *speed,
            (None, None) => 0.0,
        }
    };
    (0..n_frames)
        .map(|frame| joints.iter().flatten().map(|speeds| one(speeds, frame)).sum::<f64>() / n_joints)
        .collect()
}

fn threshold_mps(peak_mps: f64) -> f64 {
    (STILL_SHARE * peak_mps).clamp(STILL_LIMITS_MPS[0], STILL_LIMITS_MPS[1])
}

fn smaller_for_slow(peak_mps: f64, whole_from_mps: f64, least_share: f64) -> f64 {
    STILL_LIMITS_MPS[0].max(threshold_mps(peak_mps) * (peak_mps / whole_from_mps).clamp(least_share, 1.0))
}

/// The largest value within `reach` frames of each frame.
fn running_maxima(values: &[f64], reach: usize) -> Vec<f64> {
    // Frames whose value is larger than all later ones within reach: the first of them is the maximum.
    let mut falling = std::collections::VecDeque::new();
    let mut next = 0;
    (0..values.len())
        .map(|frame| {
            while next < values.len() && next <= frame.saturating_add(reach) {
                while falling.back().is_some_and(|&at: &usize| values[at] <= values[next]) {
                    falling.pop_back();
                }
                falling.push_back(next);
                next += 1;
            }
            while falling.front().is_some_and(|&at| at + reach < frame) {
                falling.pop_front();
            }
            falling.front().map_or(0.0, |&at| values[at])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    const QUIET: Noise = Noise { sd_m: 0.0, spread_m: 0.0, smoothed_share: 1.0 };

    fn feet(x: &[f64], rate_hz: f64) -> FootPaths {
        let path: Vec<DVec3> = x.iter().map(|&x| DVec3::X * x).collect();
        FootPaths {
            n_frames: x.len(),
            rate_hz,
            leg_length_m: 0.9,
            leg_spread_m: 0.0,
            scale: 1.0,
            paths: [Some(path.clone()), None, Some(path.clone()), Some(path)],
        }
    }

    #[test]
    fn strikes_are_still_forward_and_lift_offs_backward() {
        let speeds = FootSpeeds::new(&feet(&[0.0, 0.1, 0.2, 0.2, 0.2, 0.3], 30.0), &QUIET);
        let slower: Vec<f64> = (0..6).map(|frame| (speeds.slower(0, frame) * 10.0).round() / 10.0).collect();
        assert_eq!(slower, [3.0, 3.0, 0.0, 0.0, 0.0, 3.0]);
        let faster: Vec<f64> = (0..6).map(|frame| (speeds.faster(0, frame) * 10.0).round() / 10.0).collect();
        assert_eq!(faster, [3.0, 3.0, 3.0, 0.0, 3.0, 3.0]);
        assert_eq!((speeds.forward(0, 5), speeds.backward(3, 0)), (f64::INFINITY, f64::INFINITY));
        let mean = speeds.mean_of_joint(2, 6).unwrap();
        assert!((mean[2] - 1.5).abs() < 1e-9 && (mean[5] - 3.0).abs() < 1e-9);
        assert_eq!(speeds.mean_of_joint(1, 6), None);
    }

    #[test]
    fn thresholds_follow_the_swing_beside() {
        // A swing at 6 m/s in the middle of a clip of 4 s.
        let x: Vec<f64> = (0..120).map(|frame| f64::from((frame - 50).clamp(0, 10)) * 0.2).collect();
        let speeds = FootSpeeds::new(&feet(&x, 30.0), &QUIET);
        assert_eq!((speeds.still_mps[0][0], speeds.strike_mps[0][0]), (0.4, 0.4));
        assert!((speeds.still_mps[0][45] - 1.5).abs() < 1e-9);
        assert!((speeds.strike_mps[1][45] - 1.5 * 6.0 / 8.0).abs() < 1e-9);
        assert_eq!((speeds.lift_mps[0][0], speeds.lift_mps[1][45]), (0.4, speeds.still_mps[1][45]));
    }

    #[test]
    fn what_noise_adds_is_taken_off() {
        let noise = Noise { sd_m: 0.01, ..QUIET };
        let speeds = FootSpeeds::new(&feet(&[0.0, 0.01, 0.02, 0.12], 30.0), &noise);
        // 0.3 m/s is less than noise makes of a foot at rest.
        assert_eq!(speeds.forward(0, 0), 0.0);
        let bias = 0.7 * 6.0 * 0.09;
        assert!((speeds.forward(0, 2) - (9.0_f64 - bias).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn short_clips_have_the_baseline_that_fits() {
        for n_frames in 1..12 {
            let x: Vec<f64> = (0..n_frames).map(|frame| f64::from(frame) * 0.01).collect();
            let speeds = FootSpeeds::new(&feet(&x, 120.0), &QUIET);
            for frame in 0..n_frames as usize {
                let wanted = if n_frames == 1 { 0.0 } else { 1.2 };
                assert!((speeds.slower(0, frame) - wanted).abs() < 1e-9, "{frame} of {n_frames}");
            }
        }
    }

    proptest::proptest! {
        #[test]
        fn running_maxima_are_maxima(values in proptest::collection::vec(0.0..9.0_f64, 0..60), reach in 0_usize..20) {
            let found = running_maxima(&values, reach);
            for (frame, found) in found.iter().enumerate() {
                let near = &values[frame.saturating_sub(reach)..(frame + reach + 1).min(values.len())];
                proptest::prop_assert_eq!(*found, near.iter().copied().fold(0.0, f64::max));
            }
        }
    }
}
