//! What a file leaves unsaid about its space: metres a unit, and which axis points up, guessed from the body.

use super::clip::{Clip, UpAxis};
use super::folding::{fold, rest_points};
use super::kinematics::file_pose_of_frame;
use super::notice::{Notice, Severity};
use super::roles::{Role, RoleMap};
use super::skeleton::Skeleton;
use glam::DVec3;

/// Units that exporters use, metres each, and their names.
const UNITS: [(f64, &str); 6] = [
    (1.0, "metres"),
    (0.01, "centimetres"),
    (0.001, "millimetres"),
    (0.0254, "inches"),
    (0.0254 / 0.45, "units of CMU's captures, 1/0.45 inch"),
    (0.3048, "feet"),
];

/// A usual body from the base of the skull along the spine and a leg to the ankle, metres.
const USUAL_BODY_M: f64 = 1.5;

/// Bodies outside this range make the guess of a unit doubtful, metres.
const LIKELY_BODY_M: std::ops::RangeInclusive<f64> = 0.9..=2.2;

/// Frames looked at for the up axis, spread over the clip.
const UP_FRAMES: usize = 16;

/// Metres a unit of a clip, from the size of its body, and a note that says so. The clip's own `unit_m` is ignored.
///
/// The measure is the way from the head along spine and leg to an ankle, which does not change when the body bends;
/// without roles for these it is the greatest extent in the first frame. Of the units in use the one is taken that
/// brings it nearest (by ratio) to 1.5 m.
pub fn guess_unit_m(clip: &Clip, roles: &RoleMap) -> (f64, Notice) {
    let (skeleton, points) = (&clip.skeleton, first_points(clip));
    let person = body_length(skeleton, roles, &points);
    let size = person.unwrap_or_else(|| extent(&points));
    let distance = |unit_m: f64| libm::fabs(libm::log(size * unit_m / USUAL_BODY_M));
    // What is no person may have any size; inches and feet would only add to the doubt.
    let units = if person.is_some() { &UNITS[..] } else { &UNITS[..3] };
    let (unit_m, name) = match size > 0.0 && size.is_finite() {
        true => units.iter().copied().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0))).unwrap_or(UNITS[0]),
        false => UNITS[0],
    };
    let body_m = size * unit_m;
    let measure = if person.is_some() { "from head to ankle" } else { "at its widest" };
    let doubt = if LIKELY_BODY_M.contains(&body_m) { "" } else { ", which no usual unit makes likely" };
    let notice = guess(
        "unit-guessed",
        format!(
            "the file does not say its unit; taken as {name} ({unit_m:.6} m): the body is {body_m:.2} m {measure}{doubt}"
        ),
        "heights and speeds of feet decide about plants and gaits",
        "set `unit_m` of the source in the config",
    );
    (unit_m, notice)
}

/// Which axis of a clip points up, and a note if it is not Y. The clip's own `up` is ignored.
///
/// Up is the way from the ankles to the hips: the mean over the clip, since somebody may lie down for a while; the
/// rest pose where the clip says neither Y nor Z clearly; Y where that doesn't either.
pub fn guess_up_axis(clip: &Clip, roles: &RoleMap) -> (UpAxis, Option<Notice>) {
    let frames = (0..UP_FRAMES.min(clip.n_frames)).map(|n| n * clip.n_frames / UP_FRAMES.min(clip.n_frames));
    let in_clip: DVec3 = frames.filter_map(|frame| legs_up(clip, roles, &file_pose_of_frame(clip, frame))).sum();
    let at_rest = legs_up(clip, roles, &rest_points(&clip.skeleton)).unwrap_or(DVec3::ZERO);
    match clear_axis(in_clip).or_else(|| clear_axis(at_rest)) {
        None | Some(UpAxis::Y) => (UpAxis::Y, None),
        Some(UpAxis::Z) => {
            let notice = guess(
                "up-guessed",
                "the file does not say which axis is up; taken as Z: the hips lie above the feet along it".to_owned(),
                "a wrong axis lays the body down: no feet on the ground, no gaits",
                "set `up` of the source in the config",
            );
            (UpAxis::Z, Some(notice))
        }
    }
}

/// Median length of each joint's bone (to its parent) over a clip's frames, millimetres: what
/// [`Skeleton::skeleton_id`] needs where position channels take the place of offsets.
///
/// 0 for a joint without parent, and for the hips and what lies above them: these carry the body's travel.
pub fn median_bone_lengths_mm(clip: &Clip, poses: &super::Poses, roles: &RoleMap) -> Vec<f64> {
    let joints = &clip.skeleton.joints;
    let mut travels = vec![false; joints.len()];
    let mut joint = roles.get(Role::Hips).filter(|&hips| hips < joints.len());
    while let Some(above) = joint {
        travels[above] = true;
        joint = joints[above].parent;
    }
    let mut lengths = Vec::with_capacity(poses.n_frames);
    joints
        .iter()
        .enumerate()
        .map(|(index, joint)| match joint.parent {
            Some(parent) if !travels[index] && poses.n_frames > 0 => {
                lengths.clear();
                lengths.extend((0..poses.n_frames).map(|n| poses.at(n, index).distance(poses.at(n, parent)) * 1000.0));
                let middle = (lengths.len() - 1) / 2;
                *lengths.select_nth_unstable_by(middle, f64::total_cmp).1
            }
            _ => 0.0,
        })
        .collect()
}

/// The first frame in file units and axes; the rest pose where the clip is empty.
fn first_points(clip: &Clip) -> Vec<DVec3> {
    if clip.n_frames == 0 {
        return rest_points(&clip.skeleton);
    }
    file_pose_of_frame(clip, 0)
}

/// Head to hips to ankle along the joints between, the mean of both legs.
fn body_length(skeleton: &Skeleton, roles: &RoleMap, points: &[DVec3]) -> Option<f64> {
    let along = |role: Role| {
        let (hips, mut joint) = (roles.get(Role::Hips)?, roles.get(role)?);
        let mut length = 0.0;
        while joint != hips {
            let parent = skeleton.joints.get(joint)?.parent?;
            length += points.get(joint)?.distance(*points.get(parent)?);
            joint = parent;
        }
        Some(length)
    };
    Some(along(Role::Head)? + 0.5 * (along(Role::AnkleLeft)? + along(Role::AnkleRight)?))
}

fn extent(points: &[DVec3]) -> f64 {
    let first = points.first().copied().unwrap_or(DVec3::ZERO);
    let (low, high) = points.iter().fold((first, first), |(low, high), &point| (low.min(point), high.max(point)));
    (high - low).max_element()
}

/// From the middle of the ankles to the hips, of unit length, by roles or by the tree's shape.
fn legs_up(clip: &Clip, roles: &RoleMap, points: &[DVec3]) -> Option<DVec3> {
    let at = |role| roles.get(role).and_then(|point| points.get(point).copied());
    let by_roles = || Some(at(Role::Hips)? - 0.5 * (at(Role::AnkleLeft)? + at(Role::AnkleRight)?));
    let by_shape = || {
        let folded = fold(&clip.skeleton, points).ok()?;
        let tip = |leg: &[usize]| leg.last().and_then(|&joint| points.get(joint).copied());
        let tips = tip(&folded.chains.leg_left)? + tip(&folded.chains.leg_right)?;
        Some(*points.get(folded.hips)? - 0.5 * tips)
    };
    let up = by_roles().or_else(by_shape)?;
    (up.length() > 0.0).then(|| up.normalize())
}

/// Y or Z where a direction clearly follows it.
fn clear_axis(direction: DVec3) -> Option<UpAxis> {
    let direction = direction.try_normalize()?;
    match (direction.y > 0.8, direction.z > 0.8) {
        (true, _) => Some(UpAxis::Y),
        (_, true) => Some(UpAxis::Z),
        _ => None,
    }
}

fn guess(kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    Notice {
        severity: Severity::Note,
        kind: kind.to_owned(),
        line: None,
        frame: None,
        count: 1,
        message,
        why: why.to_owned(),
        remedy: remedy.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::kinematics::poses;
    use crate::motion::sample_bodies::{CMU, named_body, shipped_tables};
    use crate::motion::{Axis, Channel, ChannelKind, assign_roles};
    use std::sync::Arc;

    /// A body that stands still, made larger by a factor, its axes exchanged if need be.
    fn still(factor: f64, z_up: bool) -> (Clip, RoleMap) {
        let mut skeleton = named_body(CMU);
        let place = |v: DVec3| factor * if z_up { DVec3::new(v.x, -v.z, v.y) } else { v };
        for joint in &mut skeleton.joints {
            joint.offset = place(joint.offset);
            joint.end = joint.end.map(place);
        }
        let roles = assign_roles(&skeleton, &shipped_tables(), None).0;
        let (rate_hz, unit_m) = (30.0, 123.0);
        let skeleton = Arc::new(skeleton);
        (Clip { skeleton, rate_hz, unit_m, up: UpAxis::Z, n_frames: 3, channels: Vec::new() }, roles)
    }

    #[test]
    fn a_body_tells_its_unit_by_its_size() {
        let cmu_m = 0.0254 / 0.45;
        for (wanted, _) in UNITS {
            for stature in [0.8, 1.0, 1.15] {
                let (clip, roles) = still(stature * cmu_m / wanted, false);
                let (unit_m, notice) = guess_unit_m(&clip, &roles);
                assert_eq!(unit_m, wanted, "{stature}");
                assert!(notice.severity == Severity::Note && !notice.message.contains("no usual unit"), "{notice:?}");
            }
        }
        let (clip, roles) = still(1e5, false);
        assert!(guess_unit_m(&clip, &roles).1.message.contains("no usual unit"));
        // Without roles only the metric units are in question.
        let (clip, _) = still(cmu_m / 0.01, false);
        assert_eq!(guess_unit_m(&clip, &RoleMap::default()).0, 0.01);
        let nothing = Clip { skeleton: Arc::new(named_body("a@0,0,0")), n_frames: 0, ..clip };
        assert_eq!(guess_unit_m(&nothing, &RoleMap::default()).0, 1.0);
    }

    #[test]
    fn hips_above_ankles_tell_the_up_axis() {
        for z_up in [false, true] {
            let (clip, roles) = still(1.0, z_up);
            for roles in [roles, RoleMap::default()] {
                let (up, notice) = guess_up_axis(&clip, &roles);
                assert_eq!(up, if z_up { UpAxis::Z } else { UpAxis::Y });
                assert_eq!(notice.is_some(), z_up);
            }
        }
    }

    #[test]
    fn bone_lengths_leave_the_travel_out() {
        let mut skeleton = named_body("place(hips@0,90,0(spine@0,30,0))");
        for joint in &mut skeleton.joints {
            let kind = ChannelKind::Position;
            joint.channels = [Axis::X, Axis::Y, Axis::Z].map(|axis| Channel { kind, axis }).to_vec();
        }
        let mut roles = RoleMap::default();
        roles.set(Role::Hips, 1);
        let frames: Vec<[f32; 9]> =
            (0..5).map(|n| [0.0, 0.0, 0.0, n as f32, 90.0, 0.0, 0.0, if n == 3 { 99.0 } else { 30.0 }, 0.0]).collect();
        let clip = Clip {
            skeleton: Arc::new(skeleton),
            rate_hz: 30.0,
            unit_m: 0.01,
            up: UpAxis::Y,
            n_frames: 5,
            channels: frames.concat(),
        };
        let lengths = median_bone_lengths_mm(&clip, &poses(&clip), &roles);
        assert_eq!(lengths[..2], [0.0, 0.0]);
        assert!((lengths[2] - 300.0).abs() < 1e-9, "{lengths:?}");
    }
}
