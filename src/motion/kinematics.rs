//! Forward kinematics: channels in file units to world positions in metres.
//!
//! [`poses`] is the fast way: eight frames at a time, constant channels folded. [`plain_poses`] is the same
//! mathematics joint by joint and frame by frame, in quaternions: the reference that the fast way is tested against.

use super::clip::{Clip, UpAxis};
use super::kernels;
use super::pose_program::PoseProgram;
use super::poses::{Poses, Rotations};
use super::rotation::about;
use super::skeleton::{AngleUnit, Axis, ChannelKind, Format, Joint, PositionRule, RestAxis};
use glam::{DQuat, DVec3};

/// World positions of every joint and leaf end; the same bits on every x86-64 machine.
///
/// Agrees with [`plain_poses`] to 1e-12 of the sizes involved. Angles beyond 2^30 degrees (2^19 radians) and values
/// that are no numbers take the plain way.
pub fn poses(clip: &Clip) -> Poses {
    match PoseProgram::of(clip) {
        Some(program) => {
            Poses { n_frames: clip.n_frames, n_points: program.points.len(), world: kernels::run(&program, clip) }
        }
        None => plain_poses(clip),
    }
}

/// World positions of every joint and leaf end, without hurry.
pub fn plain_poses(clip: &Clip) -> Poses {
    solve(clip, |_, _, _, _| ())
}

/// World positions of every joint and leaf end in one frame, metres; empty where the clip has no such frame.
pub fn pose_of_frame(clip: &Clip, frame: usize) -> Vec<DVec3> {
    pose_in_space(clip, frame, clip.unit_m, clip.up)
}

/// As [`pose_of_frame`], but in file units and with the file's own axes.
pub fn file_pose_of_frame(clip: &Clip, frame: usize) -> Vec<DVec3> {
    pose_in_space(clip, frame, 1.0, UpAxis::Y)
}

/// World positions (as [`plain_poses`]), and local and world rotations.
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

fn pose_in_space(clip: &Clip, frame: usize, unit_m: f64, up: UpAxis) -> Vec<DVec3> {
    if frame >= clip.n_frames {
        return Vec::new();
    }
    let (skeleton, channels) = (clip.skeleton.clone(), clip.frame(frame).to_vec());
    plain_poses(&Clip { skeleton, rate_hz: clip.rate_hz, unit_m, up, n_frames: 1, channels }).world
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::sample_bodies::{Draws, random_clip};
    use crate::motion::{Channel, Skeleton};
    use std::sync::Arc;

    /// Largest difference, and the largest coordinate.
    fn compare(a: &Poses, b: &Poses) -> (f64, f64) {
        assert_eq!((a.n_frames, a.n_points, a.world.len()), (b.n_frames, b.n_points, b.world.len()));
        let difference = a.world.iter().zip(&b.world).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
        let size = a.world.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        (difference, size)
    }

    #[test]
    fn the_fast_way_agrees_with_the_plain_one_on_random_skeletons() {
        for seed in 0..400 {
            let clip = random_clip(seed);
            let (difference, size) = compare(&plain_poses(&clip), &poses(&clip));
            assert!(difference <= 1e-12 * size.max(1.0), "seed {seed}: {difference} of {size}");
            let (turning, rotations) = poses_and_rotations(&clip);
            assert_eq!(compare(&turning, &plain_poses(&clip)).0, 0.0, "seed {seed}");
            assert_eq!(rotations.local.len(), clip.n_frames * clip.skeleton.joints.len());
        }
    }

    #[test]
    fn random_clips_reach_every_kind_of_step() {
        let clips: Vec<Clip> = (0..400).map(random_clip).collect();
        let skeletons = || clips.iter().map(|clip| &clip.skeleton);
        let joints = || skeletons().flat_map(|skeleton| &skeleton.joints);
        assert!(skeletons().any(|skeleton| skeleton.format == Format::Amc));
        assert!(skeletons().any(|skeleton| skeleton.angle_unit == AngleUnit::Radians));
        assert!(skeletons().any(|skeleton| skeleton.position_rule == PositionRule::Add));
        assert!(skeletons().any(|skeleton| skeleton.joints.iter().filter(|joint| joint.parent.is_none()).count() > 1));
        assert!(clips.iter().any(|clip| clip.up == UpAxis::Z && clip.skeleton.format == Format::Amc));
        assert!(clips.iter().any(|clip| clip.n_frames % 8 != 0) && clips.iter().any(|clip| clip.n_frames == 0));
        assert!(joints().any(|joint| joint.channels.iter().any(|channel| channel.kind == ChannelKind::Length)));
        assert!(joints().any(|joint| joint.channels.len() > 6), "an axis twice");
    }

    #[test]
    fn a_clip_does_not_depend_on_the_frames_around_it() {
        let clip = random_clip(3);
        let whole = poses(&clip);
        for frame in 0..clip.n_frames {
            let alone = pose_of_frame(&clip, frame);
            for (a, b) in alone.iter().zip(&whole.world[frame * whole.n_points..]) {
                assert!((*a - *b).abs().max_element() < 1e-9, "frame {frame}");
            }
        }
        assert!(pose_of_frame(&clip, clip.n_frames).is_empty());
    }

    #[test]
    fn numbers_too_large_for_the_kernel_take_the_plain_way() {
        let mut clip = random_clip(1);
        let last = clip.channels.len() - 1;
        for huge in [3e38, f32::NAN, f32::INFINITY] {
            clip.channels[last] = huge;
            let (fast, plain) = (poses(&clip), plain_poses(&clip));
            let bits =
                |poses: &Poses| poses.world.iter().flat_map(|p| p.to_array()).map(f64::to_bits).collect::<Vec<_>>();
            assert_eq!(bits(&fast), bits(&plain), "{huge}");
        }
    }

    #[test]
    fn three_thousand_joints_in_a_row_stay_exact() {
        let mut draws = Draws::new(5);
        let turn = |axis| Channel { kind: ChannelKind::Rotation, axis };
        let joints = (0..3000_usize)
            .map(|index| Joint {
                name: format!("j{index}"),
                parent: index.checked_sub(1),
                offset: DVec3::new(0.0, 1.0, 0.0),
                end: (index == 2999).then_some(DVec3::Y),
                channels: vec![turn(Axis::Z), turn(Axis::X), turn(Axis::Y)],
                axis: None,
                bone: None,
            })
            .collect();
        let skeleton = Skeleton {
            format: Format::Bvh,
            joints,
            angle_unit: AngleUnit::Degrees,
            position_rule: PositionRule::Replace,
        };
        let channels = (0..3 * 9000).map(|_| draws.between(-180.0, 180.0) as f32).collect();
        let clip =
            Clip { skeleton: Arc::new(skeleton), rate_hz: 30.0, unit_m: 0.01, up: UpAxis::Y, n_frames: 3, channels };
        let (difference, _) = compare(&plain_poses(&clip), &poses(&clip));
        assert!(difference < 1e-9, "{difference}");
    }
}
