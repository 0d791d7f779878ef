//! Grafting: a donor's parts laid over a base, eased in and out (GRAFTS 3, T 5.4).
//!
//! Local rotations of the grafted joints are taken from the donor and blended with the base's by slerp under a
//! smoothstep weight, a seam long inside each end. The result is the base's channels with the rotation channels of those joints
//! replaced; every other number keeps its bits.

use super::Refusal;
use super::action::wrist_path;
use super::angles::JointAngles;
use super::correlation::CorrelationSettings;
use super::parts::Part;
use super::placement::{Placement, Timing};
use super::provenance::Provenance;
use super::signal::{gradient, mean};
use super::subject::{Subject, rates_are_near, split_frame};
use crate::motion::Clip;
use crate::motion::rotation::{rotation_vector, slerp, unwrap};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// How donors are placed and blended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraftSettings {
    /// How cyclic donors are laid over their base.
    pub correlation: CorrelationSettings,
    /// Length of the blend inside each end of the grafted stretch. Under 0.3 s seams show.
    pub seam_s: f64,
    /// Length where the arms of base and donor both move. None: `seam_s` everywhere.
    pub moving_seam_s: Option<f64>,
    /// An arm moves when its wrist is faster than this about the shoulder, on average over `seam_s`.
    pub moving_wrist_mps: f64,
}

/// A made clip with its origin.
#[derive(Clone, Debug)]
pub struct GraftedClip {
    /// The base's skeleton, rate and channels, with the grafted joints' turns replaced.
    pub clip: Clip,
    /// Where every part of every frame comes from.
    pub provenance: Provenance,
    /// Base frames that carry the donor's motion, half-open.
    pub base_range: [usize; 2],
    /// Donor frames used, half-open.
    pub donor_range: [usize; 2],
    /// The blend at the beginning, then the one at the end.
    pub seams: [Seam; 2],
    /// The worst misfit of a joint that can't show every rotation. None: all could show what was wanted.
    pub misfit: Option<Misfit>,
}

/// A blend between base and donor: where a graft could show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// First frame of the blend; with `end`, half-open.
    pub first: usize,
    /// Frame after the last.
    pub end: usize,
    /// Largest change of a grafted joint's angular velocity from one frame to the next, rad/s.
    pub jump_radps: f64,
    /// The same of the base's own motion there.
    pub base_jump_radps: f64,
}

/// How far a joint is from the rotation that it should have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Which joint.
    pub joint: usize,
    /// In which frame.
    pub frame: usize,
    /// Angle between the two rotations.
    pub angle_rad: f64,
}

impl Default for GraftSettings {
    fn default() -> Self {
        let correlation = CorrelationSettings::default();
        GraftSettings { correlation, seam_s: 0.5, moving_seam_s: None, moving_wrist_mps: 0.3 }
    }
}

/// Makes a clip of `base` with `parts` of `donor`, placed as asked.
///
/// # Errors
/// [`Refusal`]: of placement, of layout, of parts; see [`Placement::timing`] and [`graft_timed`].
pub fn graft(
    base: &Subject,
    donor: &Subject,
    parts: &[Part],
    placement: &Placement,
    settings: &GraftSettings,
) -> Result<GraftedClip, Refusal> {
    require_graftable(base, donor, parts)?;
    let timing = placement.timing(&base.movement, &donor.movement, &settings.correlation)?;
    graft_timed(base, donor, parts, &timing, settings)
}

/// Makes a clip of `base` with `parts` of `donor` under a given timing (one donor frame a base frame).
///
/// # Errors
/// [`Refusal::NotGraftable`], [`Refusal::LayoutDiffers`], [`Refusal::UnsolvableChannels`]; [`Refusal::BadPlacement`] when the
/// timing is not of this base or no frame lies inside it.
pub fn graft_timed(
    base: &Subject,
    donor: &Subject,
    parts: &[Part],
    timing: &Timing,
    settings: &GraftSettings,
) -> Result<GraftedClip, Refusal> {
    let parts = require_graftable(base, donor, parts)?;
    let n_frames = base.clip.n_frames;
    if timing.donor_frames.len() != n_frames {
        return Err(Refusal::BadPlacement);
    }
    let seams_s = [false, true].map(|at_end| seam_length(base, donor, &parts, timing, at_end, settings));
    let weights = weights(timing, seams_s, n_frames, base.clip.rate_hz);
    let inside = |frame: &usize| weights[*frame] > 0.0;
    let (Some(first), Some(last)) = ((0..n_frames).find(inside), (0..n_frames).rev().find(inside)) else {
        return Err(Refusal::BadPlacement);
    };
    let mut joints: Vec<usize> = parts.iter().flat_map(|&part| base.parts.joints(part)).copied().collect();
    joints.sort_unstable();

    let mut channels = base.clip.channels.clone();
    let first_channels = base.clip.skeleton.first_channels();
    let mut misfit: Option<Misfit> = None;
    let mut seams = [[first, last + 1]; 2];
    let seam_frames = seams_s.map(|seam_s| (seam_s * base.clip.rate_hz).ceil().max(0.0) as usize);
    seams[0][1] = (first + seam_frames[0]).min(last + 1);
    seams[1][0] = (last + 1).saturating_sub(seam_frames[1]).max(first);
    let mut jumps = [[0.0_f64; 2]; 2];
    for &joint in &joints {
        let angles = JointAngles::of(&base.clip.skeleton, joint, first_channels[joint])
            .ok_or_else(|| Refusal::UnsolvableChannels { joint: base.clip.skeleton.joints[joint].name.clone() })?;
        let own: Vec<DQuat> = (0..n_frames).map(|frame| base.movement.rotations.local_at(frame, joint)).collect();
        let taken: Vec<DQuat> = timing.donor_frames.iter().map(|&at| donor_rotation(donor, joint, at)).collect();
        let wanted = blended(&own, &taken, &weights);
        for (jump, seam) in jumps.iter_mut().zip(&seams) {
            *jump = [
                jump[0].max(velocity_jump(&wanted, *seam, base.clip.rate_hz)),
                jump[1].max(velocity_jump(&own, *seam, base.clip.rate_hz)),
            ];
        }
        if let Some(found) = write_joint(&base.clip, &angles, joint, &wanted, [first, last + 1], &mut channels)
            && misfit.is_none_or(|worst| found.angle_rad > worst.angle_rad)
        {
            misfit = Some(found);
        }
    }
    let used = &timing.donor_frames[first..=last];
    let lowest = used.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = used.iter().copied().fold(0.0, f64::max);
    let seam =
        |n: usize| Seam { first: seams[n][0], end: seams[n][1], jump_radps: jumps[n][0], base_jump_radps: jumps[n][1] };
    Ok(GraftedClip {
        clip: Clip { channels, ..(*base.clip).clone() },
        provenance: Provenance { parts, weights, donor_frames: timing.donor_frames.clone() },
        base_range: [first, last + 1],
        donor_range: [lowest as usize, highest.ceil() as usize + 1],
        seams: [seam(0), seam(1)],
        misfit,
    })
}

/// `3 x^2 - 2 x^3`, 0 below 0 and 1 above 1.
pub fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The parts in order, each once.
fn require_graftable(base: &Subject, donor: &Subject, parts: &[Part]) -> Result<Vec<Part>, Refusal> {
    let (own, other) = (&base.clip.skeleton, &donor.clip.skeleton);
    let alike = || {
        own.joints.len() == other.joints.len()
            && own
                .joints
                .iter()
                .zip(&other.joints)
                .all(|(a, b)| a.name == b.name && a.parent == b.parent && a.channels == b.channels)
            && (own.format, own.angle_unit, own.position_rule) == (other.format, other.angle_unit, other.position_rule)
    };
    if !alike() {
        return Err(Refusal::LayoutDiffers);
    }
    let (base_hz, donor_hz) = (base.clip.rate_hz, donor.clip.rate_hz);
    if !rates_are_near(base_hz, donor_hz) {
        return Err(Refusal::RatesTooFarApart { base_hz, donor_hz });
    }
    let mut parts = parts.to_vec();
    parts.sort_unstable();
    parts.dedup();
    if parts.is_empty() {
        return Err(Refusal::NotGraftable(None));
    }
    match parts.iter().find(|&&part| !part.is_graftable() || base.parts.joints(part).is_empty()) {
        Some(&part) => Err(Refusal::NotGraftable(Some(part))),
        None => Ok(parts),
    }
}

/// The donor's share in each frame, 0..1.
fn weights(timing: &Timing, seams_s: [f64; 2], n_frames: usize, rate_hz: f64) -> Vec<f64> {
    let eased = |since_s: f64, seam_s: f64| match seam_s > 0.0 {
        true => smoothstep(since_s / seam_s),
        false => f64::from(u8::from(since_s >= 0.0)),
    };
    (0..n_frames)
        .map(|frame| frame as f64 / rate_hz)
        .map(|time_s| eased(time_s - timing.first_s, seams_s[0]).min(eased(timing.last_s - time_s, seams_s[1])))
        .collect()
}

/// The donor's local rotation at a fractional frame.
fn donor_rotation(donor: &Subject, joint: usize, at: f64) -> DQuat {
    let (before, share) = split_frame(at, donor.clip.n_frames);
    let rotations = &donor.movement.rotations;
    slerp(rotations.local_at(before, joint), rotations.local_at(before + 1, joint), share)
}

/// The base's turns with the donor's share in them.
///
/// A quaternion and its negative are one rotation, but slerp goes the other way round: deciding frame by frame makes a joint
/// jump where the parents are half a turn apart. So one way is kept for a whole blend, the shorter one for the most of it,
/// unless that is far the longer one.
fn blended(own: &[DQuat], taken: &[DQuat], weights: &[f64]) -> Vec<DQuat> {
    /// Beyond two thirds of a turn the long way is refused.
    const LONGEST_DOT: f64 = -0.5;
    let middle = weights.iter().position(|&weight| weight == 1.0).unwrap_or(weights.len());
    let mut turns = Vec::with_capacity(own.len());
    for range in [0..middle, middle..weights.len()] {
        let mut sign = 1.0;
        let mut agreement = 0.0;
        let mut signs = Vec::with_capacity(range.len());
        for frame in range.clone() {
            if frame > range.start && taken[frame - 1].dot(taken[frame]) < 0.0 {
                sign = -sign;
            }
            agreement += weights[frame] * (1.0 - weights[frame]) * sign * own[frame].dot(taken[frame]);
            signs.push(sign);
        }
        let way = if agreement < 0.0 { -1.0 } else { 1.0 };
        for (frame, sign) in range.zip(signs) {
            let donor = taken[frame] * (way * sign);
            let donor = if own[frame].dot(donor) < LONGEST_DOT { -donor } else { donor };
            turns.push(if weights[frame] > 0.0 {
                slerp_as_given(own[frame], donor, weights[frame])
            } else {
                own[frame]
            });
        }
    }
    turns
}

/// Spherical interpolation along the arc from `a` to `b` themselves.
fn slerp_as_given(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let angle = libm::acos(a.dot(b).clamp(-1.0, 1.0));
    let sin = libm::sin(angle);
    let [share_a, share_b] =
        if sin > 1e-6 { [1.0 - t, t].map(|share| libm::sin(share * angle) / sin) } else { [1.0 - t, t] };
    (a * share_a + b * share_b).normalize()
}

/// Seconds of blend at the beginning or end of the grafted stretch.
fn seam_length(
    base: &Subject,
    donor: &Subject,
    parts: &[Part],
    timing: &Timing,
    at_end: bool,
    settings: &GraftSettings,
) -> f64 {
    let Some(moving_seam_s) = settings.moving_seam_s else {
        return settings.seam_s;
    };
    let rate_hz = base.clip.rate_hz;
    let inside = |frame: &usize| {
        let time_s = *frame as f64 / rate_hz;
        let since_s = if at_end { timing.last_s - time_s } else { time_s - timing.first_s };
        (0.0..=settings.seam_s).contains(&since_s)
    };
    let frames: Vec<usize> = (0..base.clip.n_frames).filter(inside).collect();
    let moves = |subject: &Subject, side: usize, at: &dyn Fn(usize) -> f64| {
        let path = wrist_path(&subject.movement, side, f64::INFINITY);
        let axes = [0, 1, 2].map(|axis| gradient(&path.iter().map(|wrist| wrist[axis]).collect::<Vec<_>>()));
        let speed = |frame: usize| DVec3::new(axes[0][frame], axes[1][frame], axes[2][frame]).length();
        let speeds: Vec<f64> = frames.iter().map(|&frame| speed(at(frame).round() as usize)).collect();
        mean(&speeds) * subject.clip.rate_hz > settings.moving_wrist_mps
    };
    let both_move = (0..2).filter(|&side| parts.contains(&Part::ARMS[side])).any(|side| {
        moves(base, side, &|frame| frame as f64) && moves(donor, side, &|frame| timing.donor_frames[frame])
    });
    if both_move { moving_seam_s } else { settings.seam_s }
}

/// Largest change of angular velocity between neighboring frames, inside a range and one frame about it.
fn velocity_jump(turns: &[DQuat], range: [usize; 2], rate_hz: f64) -> f64 {
    let inner = range[0].max(1)..range[1].min(turns.len() - 1);
    let velocity = |frame: usize| rotation_vector(turns[frame].conjugate() * turns[frame + 1]) * rate_hz;
    inner.map(|frame| (velocity(frame) - velocity(frame - 1)).length()).fold(0.0, f64::max)
}

/// Writes a joint's turns into the channels of the frames in `range`, and on until the base's own numbers fit on again.
/// The worst misfit inside the range, if there is one to speak of.
fn write_joint(
    base: &Clip,
    angles: &JointAngles,
    joint: usize,
    wanted: &[DQuat],
    range: [usize; 2],
    channels: &mut [f32],
) -> Option<Misfit> {
    /// Below this a misfit is rounding.
    const ROUNDING_RAD: f64 = 1e-6;
    let width = base.skeleton.n_channels();
    let mut previous = angles.read(base.frame(range[0].saturating_sub(1)));
    let mut worst: Option<Misfit> = None;
    for frame in range[0]..base.n_frames {
        let values = if frame < range[1] {
            let values = angles.solve(wanted[frame], &previous);
            let angle_rad = angles.error_rad(wanted[frame], &values);
            if angle_rad > worst.map_or(ROUNDING_RAD, |worst| worst.angle_rad) {
                worst = Some(Misfit { joint, frame, angle_rad });
            }
            values
        } else {
            // The base's own numbers may lie whole turns away; then the turns stay until the base itself comes round.
            let own = angles.read(base.frame(frame));
            let turn = angles.whole_turn();
            let mut values: Vec<f64> =
                own.iter().zip(&previous).map(|(&value, &previous)| unwrap(value, previous, turn)).collect();
            let other = angles.solve(wanted[frame], &previous);
            let far = |values: &[f64]| values.iter().zip(&previous).map(|(a, b)| (a - b).abs()).sum::<f64>();
            if far(&other) + 1e-6 * turn < far(&values) {
                values = other;
            }
            if values == own {
                break;
            }
            values
        };
        for (column, &value) in angles.columns().zip(&values) {
            channels[frame * width + column] = value as f32;
        }
        previous = values;
    }
    worst
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::subject::Movement;
    use super::super::walker::{mover, roles, walker, waver};
    use super::*;
    use crate::motion::Role;

    fn made(base: &Subject, donor: &Subject, parts: &[Part], placement: Placement) -> GraftedClip {
        graft(base, donor, parts, &placement, &GraftSettings::default()).unwrap()
    }

    #[test]
    fn the_middle_shows_the_donor_and_all_else_keeps_its_bits() {
        let (base, donor) = (walker(30.0, 151, 1.0), waver(60.0, 181));
        let grafted = made(&base, &donor, &[Part::ArmLeft], Placement::whole_at(1.0, &donor.movement));
        assert_eq!(grafted.base_range, [31, 120]);
        assert_eq!(grafted.donor_range, [2, 179]);
        assert_eq!(grafted.misfit, None);
        let turned: Vec<usize> = base
            .parts
            .joints(Part::ArmLeft)
            .iter()
            .flat_map(|&joint| {
                let first = base.clip.skeleton.first_channels()[joint];
                first..first + 3
            })
            .collect();
        let width = base.clip.skeleton.n_channels();
        for (n, (new, old)) in grafted.clip.channels.iter().zip(&base.clip.channels).enumerate() {
            let outside = !(31..120).contains(&(n / width)) || !turned.contains(&(n % width));
            assert!(!outside || new.to_bits() == old.to_bits(), "frame {} column {}", n / width, n % width);
        }
        let movement = Movement::of_clip(&grafted.clip, &roles()).unwrap();
        for frame in 46..=105 {
            for &joint in base.parts.joints(Part::ArmLeft) {
                let wanted = donor.movement.rotations.local_at(2 * (frame - 30), joint);
                let angle = rotation_vector(wanted.conjugate() * movement.rotations.local_at(frame, joint)).length();
                assert!(angle < 1e-6, "frame {frame} joint {joint}: {angle}");
            }
        }
        assert!(grafted.seams.iter().all(|seam| seam.jump_radps > 0.0 && seam.jump_radps < 3.0), "{:?}", grafted.seams);
        assert_eq!((grafted.seams[0].first, grafted.seams[0].end), (31, 46));
        assert_eq!((grafted.seams[1].first, grafted.seams[1].end), (105, 120));
    }

    #[test]
    fn a_clip_grafted_onto_itself_is_itself() {
        let base = walker(30.0, 151, 1.0);
        let placement = Placement::At { time_s: 1.0, first: 30, end: 121 };
        let grafted = made(&base, &base, &[Part::ArmLeft, Part::ArmRight, Part::Head], placement);
        let far = grafted.clip.channels.iter().zip(&base.clip.channels).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(far < 1e-4, "{far}");
    }

    #[test]
    fn a_seam_without_blend_jumps_more() {
        let (base, donor) = (walker(30.0, 151, 1.0), waver(30.0, 91));
        let placement = Placement::At { time_s: 1.0, first: 20, end: 70 };
        let jump = |seam_s: f64| {
            let settings = GraftSettings { seam_s, ..Default::default() };
            graft(&base, &donor, &[Part::ArmLeft], &placement, &settings).unwrap().seams[0].jump_radps
        };
        assert!(jump(0.1) > 3.0 * jump(0.5), "{} {}", jump(0.1), jump(0.5));
    }

    #[test]
    fn seams_grow_where_both_arms_move() {
        let (base, donor) = (walker(30.0, 151, 1.0), walker(30.0, 151, 1.1));
        let still = mover(30.0, 151, 1.0, 1.0, &|_, _| vec![(Role::ElbowLeft, [0.0, -90.0, 0.0])]);
        let settings = GraftSettings { moving_seam_s: Some(0.8), ..Default::default() };
        let placement = Placement::At { time_s: 1.0, first: 0, end: 91 };
        let seam = |base: &Subject, donor: &Subject| {
            let seam = graft(base, donor, &[Part::ArmLeft], &placement, &settings).unwrap().seams[0];
            seam.end - seam.first
        };
        assert_eq!((seam(&base, &donor), seam(&base, &still), seam(&still, &donor)), (24, 15, 15));
    }

    #[test]
    fn numbers_stay_smooth_where_the_donor_turns_round() {
        // The donor's forearm turns once about its axis; the base's stays at -170 degrees.
        let turning = mover(30.0, 121, 1.0, 0.0, &|time_s, _| {
            vec![(Role::ElbowLeft, [0.0, 0.0, (90.0 * time_s + 170.0) % 360.0 - 180.0])]
        });
        let base = mover(30.0, 151, 1.0, 0.0, &|_, _| vec![(Role::ElbowLeft, [0.0, 0.0, -170.0])]);
        let grafted = made(&base, &turning, &[Part::ArmLeft], Placement::whole_at(0.5, &turning.movement));
        let column = base.clip.skeleton.first_channels()[Role::ElbowLeft as usize] + 2;
        let values: Vec<f32> = (0..151).map(|frame| grafted.clip.frame(frame)[column]).collect();
        assert!(values.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 30.0), "{values:?}");
        assert!((values[150] + 170.0).abs() % 360.0 < 1e-3, "{}", values[150]);
    }

    #[test]
    fn what_makes_a_base_is_never_taken_from_a_donor() {
        let (base, donor) = (walker(30.0, 151, 1.0), waver(30.0, 91));
        let placement = Placement::whole_at(0.5, &donor.movement);
        let refused = |donor: &Subject, parts: &[Part]| {
            graft(&base, donor, parts, &placement, &GraftSettings::default()).unwrap_err()
        };
        assert_eq!(refused(&donor, &[Part::ArmLeft, Part::Legs]), Refusal::NotGraftable(Some(Part::Legs)));
        assert_eq!(refused(&donor, &[]), Refusal::NotGraftable(None));
        let mut clip = (*donor.clip).clone();
        let mut skeleton = (*clip.skeleton).clone();
        skeleton.joints[3].name = "throat".to_owned();
        clip.skeleton = std::sync::Arc::new(skeleton);
        let other = Subject::new(std::sync::Arc::new(clip), &roles()).unwrap();
        assert_eq!(refused(&other, &[Part::ArmLeft]), Refusal::LayoutDiffers);
    }
}
