//! Contacts with thresholds from the clip itself (CONTACTS 2): one setting for every body, rate and gait.

use super::decode::{self, decode};
use super::foot_paths::{FEET, FootPaths, REFERENCE_LEG_M, joints_of};
use super::foot_speeds::{self, FootSpeeds};
use super::force::{self, vertical_force};
use super::noise::{self, smooth_noise};
use super::repair::repair;
use super::resting_height::{RestingHeights, resting_heights_where};
use super::tilt::ground_tilt;
use super::treadmill::{belt_velocity, over_ground};
use super::uneven::{is_uneven, plant_levels};
use super::{Contacts, Diagnosis, EVIDENCE_HEIGHT_M, Ground, PINNED_SHARE};
use crate::annotate::labels::Foot;
use crate::annotate::order_statistics::robust_deviation;
use crate::motion::{Poses, Role, RoleMap};
use glam::DVec3;

/// Toes slower than this share of the threshold of stillness show the ground's slope (2.6); slower than that, the
/// heights at which joints rest (2.7, 2.9).
const TILT_SHARE: f64 = 0.3;
const REST_SHARE: f64 = 0.5;
/// A leg that is bent more than to this share of its length carries no weight on uneven ground (2.9).
const STRETCHED_SHARE: f64 = 0.75;
/// An ankle rises and moves on while the ball of the foot still carries the body. Where no toe tells, its evidence turns
/// at this many times the height, and towards the lift-off at this many times the speed.
const ANKLE_ALONE_HEIGHT: f64 = 2.0;
const ANKLE_ALONE_SPEED: f64 = 1.5;
/// Gaps of steps are wider by this than by CONTACTS 2 as written, seconds: the thresholds at strikes and lift-offs are
/// smaller. Measured on Bandai-Namco: from the walks' 99th percentile to the runs' least they moved by 8 to 11 ms.
pub(super) const WIDER_GAPS_S: f64 = 0.008;
/// Limit of the log-odds of a foot being planted (2.10).
const LOG_ODDS_LIMIT: f64 = 3.0;

/// What the detector is made of, by name with units, for the metadata of tables; every length in scaled metres.
pub const CONSTANTS: &[(&str, f64)] = &[
    ("reference_leg_m", REFERENCE_LEG_M),
    ("evidence_height_m", EVIDENCE_HEIGHT_M),
    ("still_share_of_swing", foot_speeds::STILL_SHARE),
    ("least_still_mps", foot_speeds::STILL_LIMITS_MPS[0]),
    ("most_still_mps", foot_speeds::STILL_LIMITS_MPS[1]),
    ("descent_weight", foot_speeds::DESCENT_WEIGHT),
    ("strike_peak_mps", foot_speeds::STRIKE_PEAK_MPS),
    ("lift_peak_mps", foot_speeds::LIFT_PEAK_MPS),
    ("swing_reach_s", foot_speeds::SWING_REACH_S),
    ("quiet_noise_m", noise::QUIET_M),
    ("smoothing_s_per_m", noise::SMOOTHING_S_PER_M),
    ("longest_smoothing_s", noise::LONGEST_SMOOTHING_S),
    ("force_window_s", force::WINDOW_S),
    ("change_cost", decode::CHANGE_COST),
    ("evidence_per_s", decode::EVIDENCE_PER_S),
    ("flight_force_bw", decode::FLIGHT_FORCE_BW),
    ("wider_gaps_s", WIDER_GAPS_S),
    ("log_odds_limit", LOG_ODDS_LIMIT),
    ("pinned_share", PINNED_SHARE),
];

/// The adaptive detector (CONTACTS 2). A foot without a toe is judged by its ankle alone.
///
/// A belt's velocity is taken off first. A clip shorter than two baselines of 1/30 s is judged over shorter ones, a
/// single frame by its heights alone. No frames give no labels.
pub fn adaptive_contacts(poses: &Poses, roles: &RoleMap, feet: &FootPaths) -> Contacts {
    let Some(belt) = belt_velocity(poses, roles, feet) else { return contacts_at_rest(poses, roles, feet, 0.0) };
    let poses = over_ground(poses, belt * feet.scale, feet.rate_hz);
    let mut moved = feet.clone();
    for path in moved.paths.iter_mut().flatten() {
        path.iter_mut().enumerate().for_each(|(frame, place)| *place -= belt * (frame as f64 / feet.rate_hz));
    }
    contacts_at_rest(&poses, roles, &moved, belt.length())
}

/// Contacts on ground that is at rest, after a belt of that speed was taken off, scaled m/s.
fn contacts_at_rest(poses: &Poses, roles: &RoleMap, feet: &FootPaths, belt_mps: f64) -> Contacts {
    let mut feet = feet.clone();
    let n_frames = feet.n_frames;
    let knees = [Role::KneeLeft, Role::KneeRight].map(|knee| scaled_path(poses, roles, knee, feet.scale));
    repair(&mut feet, &knees);
    let noise = smooth_noise(&mut feet);
    let speeds = FootSpeeds::new(&feet, &noise);
    let slow = |joint: usize, frame: usize, share: f64| {
        speeds.slower(joint, frame) < share * speeds.still_mps[joint / 2][frame]
    };
    let tilt = ground_tilt(&feet, |joint, frame| slow(joint, frame, TILT_SHARE));
    let heights = level_heights(&feet, tilt.map_or([0.0; 2], |tilt| tilt.slope));
    let rest =
        resting_heights_where(heights.each_ref().map(Option::as_deref), |joint, frame| slow(joint, frame, REST_SHARE));
    let mut above = heights.clone();
    for (above, rest) in above.iter_mut().zip(rest.height) {
        above.iter_mut().flatten().for_each(|height| *height -= rest.unwrap_or(0.0));
    }
    let force_bw = vertical_force(poses, roles, &feet);
    let uneven = is_uneven(&lowest(&above, n_frames), &force_bw, feet.rate_hz);
    if uneven {
        for foot in FEET {
            let still = stretched_and_still(foot, poses, roles, &feet, |joint, frame| slow(joint, frame, REST_SHARE));
            stand_on_levels(foot, &still, &speeds, &heights, &mut above, feet.rate_hz);
        }
    }
    let log_odds: Vec<[f64; 2]> =
        (0..n_frames).map(|frame| FEET.map(|foot| foot_log_odds(foot, frame, &speeds, &above))).collect();
    let tokens = decode(&log_odds, &force_bw, feet.rate_hz);
    let stance = FEET.map(|foot| tokens.iter().map(|token| token.plants(foot)).collect::<Vec<bool>>());
    let pinned = FEET.map(|foot| {
        let at_rest = |frame: usize| {
            joints_of(foot).into_iter().filter(|&joint| feet.paths[joint].is_some()).any(|joint| {
                let low = above[joint].as_ref().is_some_and(|above| above[frame] < EVIDENCE_HEIGHT_M);
                low && speeds.faster(joint, frame) < PINNED_SHARE * speeds.still_mps[foot as usize][frame]
            })
        };
        (0..n_frames).map(|frame| stance[foot as usize][frame] && at_rest(frame)).collect::<Vec<bool>>()
    });
    let scale = feet.scale;
    let ground = Ground {
        height_m: ground_height(&feet, &rest, tilt.map_or([0.0; 2], |tilt| tilt.slope)).map(|height| height * scale),
        spread_m: ground_spread(&feet, &above, |joint, frame| slow(joint, frame, REST_SHARE)).map(|sd| sd * scale),
        tilt,
        uneven: Some(uneven),
        belt_mps: Some(belt_mps * scale),
        feet_rest_apart: rest.apart,
    };
    let ground_m = FEET.map(|foot| {
        let joint = ball_joint(&feet, foot);
        let path = feet.ball(foot).iter();
        path.zip(above[joint].iter().flatten()).map(|(place, above)| (place.y - above) * scale).collect()
    });
    let own_size = |values: Option<Vec<f64>>| values.map(|values| values.iter().map(|value| value * scale).collect());
    Contacts {
        stance,
        pinned,
        heights_m: above.map(own_size),
        speeds_mps: [0, 1, 2, 3].map(|joint| own_size(speeds.mean_of_joint(joint, n_frames))),
        ground,
        diagnosis: Some(Diagnosis {
            log_odds,
            force_bw,
            ground_m,
            noise_m: noise.sd_m * scale,
            noise_spread_m: noise.spread_m * scale,
        }),
    }
}

/// Height above its rest at which the evidence of a foot's joint turns from planted to not, scaled metres.
pub fn evidence_height_m(has_toe: bool) -> f64 {
    if has_toe { EVIDENCE_HEIGHT_M } else { EVIDENCE_HEIGHT_M * ANKLE_ALONE_HEIGHT }
}

/// The path of a joint in scaled metres; all zeros where it isn't known.
fn scaled_path(poses: &Poses, roles: &RoleMap, role: Role, scale: f64) -> Vec<DVec3> {
    let Some(point) = roles.get(role) else { return vec![DVec3::ZERO; poses.n_frames] };
    (0..poses.n_frames).map(|frame| poses.at(frame, point) / scale).collect()
}

/// Index of the joint that stands for a foot: its toe, else its ankle.
fn ball_joint(feet: &FootPaths, foot: Foot) -> usize {
    let [ankle, toe] = joints_of(foot);
    if feet.paths[toe].is_some() { toe } else { ankle }
}

/// Heights above the sloping plane through the origin, `[foot joint][frame]`.
fn level_heights(feet: &FootPaths, slope: [f64; 2]) -> [Option<Vec<f64>>; 4] {
    feet.paths.each_ref().map(|path| {
        Some(path.as_ref()?.iter().map(|place| place.y - place.x * slope[0] - place.z * slope[1]).collect())
    })
}

/// The lowest joint of both feet above its rest, at least 0, `[frame]`.
fn lowest(above: &[Option<Vec<f64>>; 4], n_frames: usize) -> Vec<f64> {
    let mut lowest = vec![f64::INFINITY; n_frames];
    for above in above.iter().flatten() {
        for (lowest, above) in lowest.iter_mut().zip(above) {
            *lowest = lowest.min(above.max(0.0));
        }
    }
    lowest
}

/// Frames in which a foot may be planted on ground of its own: still, under a leg that is stretched.
fn stretched_and_still(
    foot: Foot,
    poses: &Poses,
    roles: &RoleMap,
    feet: &FootPaths,
    is_slow: impl Fn(usize, usize) -> bool,
) -> Vec<bool> {
    let hip = roles.get([Role::ThighLeft, Role::ThighRight][foot as usize]);
    let ankle = feet.paths[joints_of(foot)[0]].as_deref().unwrap_or(&[]);
    let stretched = |frame: usize| {
        hip.is_some_and(|hip| {
            (poses.at(frame, hip) / feet.scale - ankle[frame]).length() > STRETCHED_SHARE * REFERENCE_LEG_M
        })
    };
    let joint = ball_joint(feet, foot);
    (0..feet.n_frames).map(|frame| is_slow(joint, frame) && stretched(frame)).collect()
}

/// Lets a foot's joints rest on the levels of its plants.
fn stand_on_levels(
    foot: Foot,
    still: &[bool],
    speeds: &FootSpeeds,
    heights: &[Option<Vec<f64>>; 4],
    above: &mut [Option<Vec<f64>>; 4],
    rate_hz: f64,
) {
    for joint in joints_of(foot) {
        let Some(heights) = &heights[joint] else { continue };
        let Some([levels]) = plant_levels(still, &speeds.of_foot_mps[foot as usize], [heights], rate_hz) else {
            return;
        };
        above[joint] = Some(heights.iter().zip(levels).map(|(height, level)| height - level).collect());
    }
}

/// Log-odds of a foot being planted (2.10): of its joint that looks more like it.
fn foot_log_odds(foot: Foot, frame: usize, speeds: &FootSpeeds, above: &[Option<Vec<f64>>; 4]) -> f64 {
    let [still, strike, mut lift] =
        [&speeds.still_mps, &speeds.strike_mps, &speeds.lift_mps].map(|thresholds| thresholds[foot as usize][frame]);
    let has_toe = above[joints_of(foot)[1]].is_some();
    let turning_m = evidence_height_m(has_toe);
    if !has_toe {
        lift *= ANKLE_ALONE_SPEED;
    }
    let mut square = f64::INFINITY;
    for joint in joints_of(foot) {
        let Some(above) = &above[joint] else { continue };
        let (mut forward, mut backward) =
            (speeds.descending(joint, frame) / strike, speeds.backward(joint, frame) / lift);
        // Where the clip cuts a side off, nobody knows whether the foot strikes or lifts.
        if backward.is_infinite() {
            forward = speeds.forward(joint, frame) / still;
        } else if forward.is_infinite() {
            backward = speeds.backward(joint, frame) / still;
        }
        let slower = forward.min(backward);
        // A clip of one frame has no speeds.
        let slower = if slower.is_finite() { slower } else { 0.0 };
        let height = above[frame].max(0.0) / turning_m;
        square = square.min(slower * slower + height * height);
    }
    // Most frames are beyond doubt and need no logarithm: exp(3) is 20.09.
    if square >= 20.1 {
        -LOG_ODDS_LIMIT
    } else if square <= 0.049 {
        LOG_ODDS_LIMIT
    } else {
        (-libm::log(square)).clamp(-LOG_ODDS_LIMIT, LOG_ODDS_LIMIT)
    }
}

/// Scaled height at which the feet rest in the middle of their way.
fn ground_height(feet: &FootPaths, rest: &RestingHeights, slope: [f64; 2]) -> Option<f64> {
    let mut total = 0.0;
    for foot in FEET {
        let path = feet.ball(foot);
        let middle = path.iter().sum::<DVec3>() / path.len().max(1) as f64;
        total += rest.height[ball_joint(feet, foot)]? + middle.x * slope[0] + middle.z * slope[1];
    }
    Some(total / 2.0)
}

/// Robust standard deviation of slow toes about their rest, scaled metres.
fn ground_spread(
    feet: &FootPaths,
    above: &[Option<Vec<f64>>; 4],
    is_slow: impl Fn(usize, usize) -> bool,
) -> Option<f64> {
    let mut away: Vec<f64> = FEET
        .into_iter()
        .map(|foot| ball_joint(feet, foot))
        .flat_map(|joint| {
            above[joint].iter().flatten().enumerate().map(move |(frame, above)| (joint, frame, above.abs()))
        })
        .filter(|&(joint, frame, _)| is_slow(joint, frame))
        .map(|(_, _, away)| away)
        .collect();
    robust_deviation(&mut away)
}
