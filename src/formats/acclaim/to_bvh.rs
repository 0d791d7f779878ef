//! Acclaim motion as BVH: every bone a joint at its near end, its turn as three angles.

use crate::formats::reading::{WriteError, check_channels};
use crate::motion::rotation::{about, euler_near};
use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Channel, ChannelKind, Format, Joint, Skeleton, kinematics};
use glam::{DQuat, DVec3};

/// How a joint of the BVH skeleton moves.
struct Part {
    /// Joint of the Acclaim skeleton.
    source: usize,
    /// Whether it stands at the far end of `source` instead: a leaf whose bone changes length.
    is_far_end: bool,
    is_root: bool,
    has_positions: bool,
    /// Axis letters of `source`; the channels are listed last letter first.
    letters: [Axis; 3],
    /// The rest axis, unless it turns nothing: then angles are passed on.
    rest: Option<DQuat>,
    /// Column of each axis' translation and rotation.
    shift: [Option<usize>; 3],
    turn: [Option<usize>; 3],
    /// Angles of the frame before, radians.
    previous: [f64; 3],
}

/// Turns Acclaim motion into BVH motion in the same file units, with the same world positions.
///
/// Each joint gets three rotations, the root and bones that shift or hang on a bone that stretches also three
/// positions. Where the rest axis is zero angles are passed on as they are; elsewhere they are made anew and
/// continue those of the frame before. A leaf that stretches gets a joint `<name>End` at its far end.
/// Channels: `[frame][channel]` in and out.
///
/// # Errors
/// [`WriteError`] for a BVH skeleton, half a frame, a number that is not finite.
pub fn acclaim_to_bvh(skeleton: &Skeleton, channels: &[f32]) -> Result<(Skeleton, Vec<f32>), WriteError> {
    if skeleton.format != Format::Amc {
        return Err(WriteError::WrongFormat { expected: "Acclaim", found: "BVH" });
    }
    let width = skeleton.n_channels();
    check_channels(channels, width)?;
    let (target, mut parts) = build(skeleton);
    let to_radians = match skeleton.angle_unit {
        AngleUnit::Degrees => core::f64::consts::PI / 180.0,
        AngleUnit::Radians => 1.0,
    };
    let stretch_of: Vec<Option<usize>> = (skeleton.joints.iter().zip(skeleton.first_channels()))
        .map(|(joint, first)| {
            let at = joint.channels.iter().rposition(|channel| channel.kind == ChannelKind::Length);
            at.map(|at| first + at)
        })
        .collect();
    let mut made = Vec::with_capacity(channels.len().checked_div(width).unwrap_or(0) * target.n_channels());
    for frame in channels.chunks_exact(width.max(1)) {
        for part in &mut parts {
            if part.has_positions {
                let position = position(skeleton, &stretch_of, part, frame);
                made.extend(position.to_array().map(|value| value as f32));
            }
            made.extend(part.angles(frame, to_radians, skeleton.angle_unit));
        }
    }
    Ok((target, made))
}

/// The BVH skeleton, each joint followed by all that hangs on it, and where its numbers come from.
fn build(skeleton: &Skeleton) -> (Skeleton, Vec<Part>) {
    let firsts = skeleton.first_channels();
    let children = skeleton.children();
    let stretches =
        |joint: usize| skeleton.joints[joint].channels.iter().any(|channel| channel.kind == ChannelKind::Length);
    let mut target_of = vec![0; skeleton.joints.len()];
    let mut joints: Vec<Joint> = Vec::new();
    let mut parts = Vec::new();
    let mut stack: Vec<usize> =
        (0..skeleton.joints.len()).rev().filter(|&joint| skeleton.joints[joint].parent.is_none()).collect();
    while let Some(source) = stack.pop() {
        let joint = &skeleton.joints[source];
        let part = Part::of(joint, source, firsts[source], joint.parent.is_some_and(stretches));
        target_of[source] = joints.len();
        let far_end = joint.end.filter(|_| stretches(source));
        joints.push(Joint {
            name: joint.name.clone(),
            parent: joint.parent.map(|parent| target_of[parent]),
            offset: if joint.parent.is_some() { joint.offset } else { DVec3::ZERO },
            end: joint.end.filter(|_| far_end.is_none()),
            channels: part.channels(),
            axis: None,
            bone: None,
        });
        parts.push(part);
        if let Some(offset) = far_end {
            let mut part = Part::of(joint, source, firsts[source], true);
            (part.is_far_end, part.turn, part.rest) = (true, [None; 3], None);
            joints.push(Joint {
                name: format!("{}End", joint.name),
                parent: Some(target_of[source]),
                offset,
                end: Some(DVec3::ZERO),
                channels: part.channels(),
                axis: None,
                bone: None,
            });
            parts.push(part);
        }
        stack.extend(children[source].iter().rev());
    }
    let target =
        Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace };
    (target, parts)
}

/// Where a joint stands relative to its parent, file units.
fn position(skeleton: &Skeleton, stretch_of: &[Option<usize>], part: &Part, frame: &[f32]) -> DVec3 {
    let joint = &skeleton.joints[part.source];
    let value = |column: Option<usize>| column.map_or(0.0, |column| f64::from(frame[column]));
    let stretched =
        |bone: usize| skeleton.joints[bone].bone.map(|data| data.direction * (data.length + value(stretch_of[bone])));
    if part.is_far_end {
        return stretched(part.source).unwrap_or(DVec3::ZERO);
    }
    let shift = DVec3::from_array(part.shift.map(value));
    match joint.parent {
        None => joint.offset + shift,
        Some(parent) => {
            let offset = stretched(parent).unwrap_or(joint.offset);
            offset + part.rest.map_or(shift, |rest| rest * shift)
        }
    }
}

impl Part {
    fn of(joint: &Joint, source: usize, first: usize, on_stretching_bone: bool) -> Part {
        let mut part = Part {
            source,
            is_far_end: false,
            is_root: joint.parent.is_none(),
            has_positions: joint.parent.is_none() || on_stretching_bone,
            letters: joint.axis.map_or([Axis::X, Axis::Y, Axis::Z], |axis| axis.order),
            rest: joint.axis.filter(|axis| axis.degrees != [0.0; 3]).map(kinematics::rest_rotation),
            shift: [None; 3],
            turn: [None; 3],
            previous: [0.0; 3],
        };
        for (column, channel) in (first..).zip(&joint.channels) {
            match channel.kind {
                ChannelKind::Position => {
                    part.shift[channel.axis.index()] = Some(column);
                    part.has_positions = true;
                }
                ChannelKind::Rotation => part.turn[channel.axis.index()] = Some(column),
                ChannelKind::Length => {}
            }
        }
        // A bone that never turns needs no angles, whatever its rest axis.
        if joint.parent.is_some() && part.turn == [None; 3] {
            part.rest = part.rest.filter(|_| part.shift != [None; 3]);
        }
        part
    }

    fn channels(&self) -> Vec<Channel> {
        let [a, b, c] = self.letters;
        let positions = [Axis::X, Axis::Y, Axis::Z].map(|axis| Channel { kind: ChannelKind::Position, axis });
        let rotations = [c, b, a].map(|axis| Channel { kind: ChannelKind::Rotation, axis });
        positions.into_iter().filter(|_| self.has_positions).chain(rotations).collect()
    }

    /// Rotations in the order of the channels, degrees.
    fn angles(&mut self, frame: &[f32], to_radians: f64, unit: AngleUnit) -> [f32; 3] {
        let [a, b, c] = self.letters;
        let value = |axis: Axis| self.turn[axis.index()].map_or(0.0, |column| frame[column]);
        let Some(rest) = self.rest else {
            return [c, b, a].map(|axis| match unit {
                AngleUnit::Degrees => value(axis),
                AngleUnit::Radians => f64::from(value(axis)).to_degrees() as f32,
            });
        };
        let turn = |axis: Axis| about(axis, f64::from(value(axis)) * to_radians);
        let moved = rest * (turn(c) * turn(b) * turn(a));
        let rotation = if self.is_root { moved } else { moved * rest.conjugate() };
        self.previous = euler_near(rotation, [c, b, a], self.previous);
        self.previous.map(|angle| angle.to_degrees() as f32)
    }
}
