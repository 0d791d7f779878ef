//! A stick figure that walks in place of a capture, for unit tests: joints named like their roles.

use super::subject::Subject;
use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Channel, ChannelKind, Clip, Format, Joint, Role, RoleMap, Skeleton, UpAxis};
use core::f64::consts::TAU;
use glam::DVec3;
use std::sync::Arc;

/// What a walker does in a frame, given the time and the phase of its stride (0..1).
pub(crate) type Pose = dyn Fn(f64, f64) -> Vec<(Role, [f64; 3])>;

/// Walks along +Z at 1.2 m/s, arms swinging against the legs, `strides_hz` strides a second.
pub(crate) fn walker(rate_hz: f64, n_frames: usize, strides_hz: f64) -> Subject {
    mover(rate_hz, n_frames, strides_hz, 1.2, &|_, phase| {
        let swing = 25.0 * libm::sin(TAU * phase);
        vec![
            (Role::ThighLeft, [0.0, -swing, 0.0]),
            (Role::ThighRight, [0.0, swing, 0.0]),
            (Role::ShoulderLeft, [0.0, 0.8 * swing, 4.0]),
            (Role::ShoulderRight, [0.0, -0.8 * swing, -4.0]),
        ]
    })
}

/// Stands, and raises the left arm once over the whole clip.
pub(crate) fn waver(rate_hz: f64, n_frames: usize) -> Subject {
    let duration_s = n_frames as f64 / rate_hz;
    mover(rate_hz, n_frames, 1.0, 0.0, &move |time_s, _| {
        let raise = libm::sin(core::f64::consts::PI * time_s / duration_s);
        vec![(Role::ShoulderLeft, [80.0 * raise * raise, 10.0 * raise, 5.0])]
    })
}

/// A body of 1.7 m that turns its joints by (Z, X, Y) degrees as `pose` says; roles as named.
pub(crate) fn mover(rate_hz: f64, n_frames: usize, strides_hz: f64, speed_mps: f64, pose: &Pose) -> Subject {
    let skeleton = Arc::new(skeleton());
    let width = skeleton.n_channels();
    let mut channels = vec![0.0_f32; n_frames * width];
    for frame in 0..n_frames {
        let time_s = frame as f64 / rate_hz;
        let row = &mut channels[frame * width..(frame + 1) * width];
        row[1] = 90.0;
        row[2] = (100.0 * speed_mps * time_s) as f32;
        for (role, angles) in pose(time_s, (time_s * strides_hz) % 1.0) {
            for (slot, angle) in row[3 + 3 * role as usize..][..3].iter_mut().zip(angles) {
                *slot = angle as f32;
            }
        }
    }
    let clip = Clip { skeleton, rate_hz, unit_m: 0.01, up: UpAxis::Y, n_frames, channels };
    Subject::new(Arc::new(clip), &roles()).expect("all roles are given")
}

/// Role k is joint k.
pub(crate) fn roles() -> RoleMap {
    let mut roles = RoleMap::default();
    for role in Role::ALL {
        roles.set(role, role as usize);
    }
    roles
}

fn skeleton() -> Skeleton {
    use Role::*;
    let joint = |role: Role, parent: Option<Role>, offset: [f64; 3]| {
        let turns = [Axis::Z, Axis::X, Axis::Y].map(|axis| Channel { kind: ChannelKind::Rotation, axis });
        let moves = [Axis::X, Axis::Y, Axis::Z].map(|axis| Channel { kind: ChannelKind::Position, axis });
        let channels = if parent.is_none() { [moves, turns].concat() } else { turns.to_vec() };
        let end = matches!(role, Head | WristLeft | WristRight | ToeLeft | ToeRight).then_some(DVec3::new(0., 0., 8.));
        let (name, parent) = (role.name().to_owned(), parent.map(|parent| parent as usize));
        Joint { name, parent, offset: DVec3::from_array(offset), end, channels, axis: None, bone: None }
    };
    let joints = vec![
        joint(Hips, None, [0.0; 3]),
        joint(Spine, Some(Hips), [0.0, 15.0, 0.0]),
        joint(Chest, Some(Spine), [0.0, 15.0, 0.0]),
        joint(Neck, Some(Chest), [0.0, 22.0, 0.0]),
        joint(Head, Some(Neck), [0.0, 8.0, 0.0]),
        joint(ClavicleLeft, Some(Chest), [3.0, 18.0, 0.0]),
        joint(ShoulderLeft, Some(ClavicleLeft), [14.0, 0.0, 0.0]),
        joint(ElbowLeft, Some(ShoulderLeft), [2.0, -28.0, 0.0]),
        joint(WristLeft, Some(ElbowLeft), [0.0, -25.0, 3.0]),
        joint(ClavicleRight, Some(Chest), [-3.0, 18.0, 0.0]),
        joint(ShoulderRight, Some(ClavicleRight), [-14.0, 0.0, 0.0]),
        joint(ElbowRight, Some(ShoulderRight), [-2.0, -28.0, 0.0]),
        joint(WristRight, Some(ElbowRight), [0.0, -25.0, 3.0]),
        joint(ThighLeft, Some(Hips), [9.0, 0.0, 0.0]),
        joint(KneeLeft, Some(ThighLeft), [0.0, -42.0, 1.0]),
        joint(AnkleLeft, Some(KneeLeft), [0.0, -40.0, 0.0]),
        joint(ToeLeft, Some(AnkleLeft), [0.0, -6.0, 12.0]),
        joint(ThighRight, Some(Hips), [-9.0, 0.0, 0.0]),
        joint(KneeRight, Some(ThighRight), [0.0, -42.0, 1.0]),
        joint(AnkleRight, Some(KneeRight), [0.0, -40.0, 0.0]),
        joint(ToeRight, Some(AnkleRight), [0.0, -6.0, 12.0]),
    ];
    Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace }
}
