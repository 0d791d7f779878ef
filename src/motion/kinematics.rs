//! Forward kinematics: channels in file units to world positions in metres.

use super::clip::{Clip, UpAxis};
use super::poses::{Poses, Rotations};
use super::rotation::about;
use super::skeleton::{AngleUnit, Axis, ChannelKind, Format, Joint, PositionRule, RestAxis};
use glam::{DQuat, DVec3};

/// World positions of every joint and leaf end.
pub fn poses(clip: &Clip) -> Poses {
    solve(clip, |_, _, _, _| ())
}

/// World positions, and local and world rotations.
pub fn poses_and_rotations(clip: &Clip) -> (Poses, Rotations) {
    let n_joints = clip.skeleton.joints.len();
    let mut local = vec![DQuat::IDENTITY; clip.n_frames * n_joints];
    let mut world = local.clone();
    let poses = solve(clip, |frame, joint, local_rotation, world_rotation| {
        let at = frame * n_joints + joint;
        let flip = frame > 0 && local[at - n_joints].dot(local_rotation) < 0.0;
        local[at] = if flip { -local_rotation } else { local_rotation };
        world[at] = world_rotation;
    });
    (poses, Rotations { n_frames: clip.n_frames, n_joints, local, world })
}

fn solve(clip: &Clip, mut each: impl FnMut(usize, usize, DQuat, DQuat)) -> Poses {
    let skeleton = &*clip.skeleton;
    let n_joints = skeleton.joints.len();
    let ends = skeleton.ends();
    let n_points = n_joints + ends.len();
    let to_radians = match skeleton.angle_unit {
        AngleUnit::Degrees => core::f64::consts::PI / 180.0,
        AngleUnit::Radians => 1.0,
    };
    let rest: Vec<DQuat> =
        skeleton.joints.iter().map(|joint| joint.axis.map_or(DQuat::IDENTITY, rest_rotation)).collect();
    let up = match clip.up {
        UpAxis::Y => DQuat::IDENTITY,
        UpAxis::Z => DQuat::from_xyzw(-core::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, core::f64::consts::FRAC_1_SQRT_2),
    };
    let mut world = vec![DVec3::ZERO; clip.n_frames * n_points];
    let mut rotations = vec![DQuat::IDENTITY; n_joints];
    let mut stretches = vec![0.0; n_joints];
    for frame in 0..clip.n_frames {
        let positions = &mut world[frame * n_points..(frame + 1) * n_points];
        let mut values = clip.frame(frame).iter().map(|&value| f64::from(value));
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let stretch = joint.parent.map_or(0.0, |parent| stretches[parent]);
            let mut moved = rest_offset(skeleton.format, &skeleton.joints, joint, stretch);
            let mut shift = DVec3::ZERO;
            let mut turn = DQuat::IDENTITY;
            let mut turns = [0.0; 3];
            for channel in &joint.channels {
                let value = values.next().unwrap_or(0.0);
                match (channel.kind, skeleton.format) {
                    (ChannelKind::Position, Format::Amc) => shift[channel.axis.index()] += value,
                    (ChannelKind::Position, Format::Bvh) => match skeleton.position_rule {
                        PositionRule::Replace => moved[channel.axis.index()] = value,
                        PositionRule::Add => moved[channel.axis.index()] += value,
                    },
                    (ChannelKind::Rotation, Format::Bvh) => turn *= about(channel.axis, value * to_radians),
                    (ChannelKind::Rotation, Format::Amc) => turns[channel.axis.index()] = value * to_radians,
                    (ChannelKind::Length, _) => stretches[index] = value,
                }
            }
            let order = joint.axis.map_or([Axis::X, Axis::Y, Axis::Z], |axis| axis.order);
            if skeleton.format == Format::Amc {
                for axis in order {
                    turn = about(axis, turns[axis.index()]) * turn;
                }
                turn = rest[index] * turn;
                if joint.parent.is_some() {
                    turn *= rest[index].conjugate();
                }
            }
            match joint.parent {
                None => {
                    rotations[index] = up * turn;
                    positions[index] = up * (moved + shift);
                }
                Some(parent) => {
                    rotations[index] = rotations[parent] * turn;
                    positions[index] = positions[parent] + rotations[parent] * (moved + rest[index] * shift);
                }
            }
            each(frame, index, turn, rotations[index]);
        }
        for (k, &joint) in ends.iter().enumerate() {
            let end = far_end(&skeleton.joints[joint], stretches[joint]);
            positions[n_joints + k] = positions[joint] + rotations[joint] * end;
        }
        for position in positions {
            *position *= clip.unit_m;
        }
    }
    Poses { n_frames: clip.n_frames, n_points, world }
}

/// `C`: rotations applied in the order of the letters.
pub fn rest_rotation(axis: RestAxis) -> DQuat {
    let mut turn = DQuat::IDENTITY;
    for (degrees, letter) in axis.degrees.into_iter().zip(axis.order) {
        turn = about(letter, degrees.to_radians()) * turn;
    }
    turn
}

fn rest_offset(format: Format, joints: &[Joint], joint: &Joint, parent_stretch: f64) -> DVec3 {
    match joint.parent.and_then(|parent| joints[parent].bone) {
        Some(bone) if format == Format::Amc => bone.direction * (bone.length + parent_stretch),
        _ => joint.offset,
    }
}

fn far_end(joint: &Joint, stretch: f64) -> DVec3 {
    match joint.bone {
        Some(bone) => bone.direction * (bone.length + stretch),
        None => joint.end.unwrap_or(DVec3::ZERO),
    }
}
