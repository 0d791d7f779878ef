//! What forward kinematics does for each joint of one clip, worked out once: channels that never vary are folded
//! into constants, Acclaim's rest axes are multiplied together, the unit and the up axis go into the offsets.
//!
//! A joint's world rotation is kept as `V T` with `V` per frame and `T` constant. `T` moves on to whatever hangs
//! on the joint, so an Acclaim bone costs one constant product instead of two, and a joint whose rotations never
//! vary costs nothing: it shares its parent's `V`.

use super::clip::{Clip, UpAxis};
use super::kinematics::rest_rotation;
use super::sincos::{DEGREES_LIMIT, RADIANS_LIMIT, sincos_degrees, sincos_radians};
use super::skeleton::{AngleUnit, Axis, ChannelKind, Format, Joint, PositionRule};
use glam::{DMat3, DQuat, DVec3};

/// One factor of a joint's rotation, applied to the right of what is there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Factor {
    /// About an axis, by a channel's angle.
    Turn(Axis, usize),
    /// The same in every frame: `[row][column]`.
    Fixed([[f64; 3]; 3]),
}

/// How one rotation that varies comes about.
#[derive(Clone, Debug)]
pub(super) struct TurnStep {
    /// Number of the rotation it starts from; None: no rotation.
    pub(super) from: Option<usize>,
    /// In the order applied. The n-th step makes rotation number n.
    pub(super) factors: Vec<Factor>,
}

/// Where one point lies.
#[derive(Clone, Debug)]
pub(super) struct PointStep {
    /// The point that it hangs on.
    pub(super) base: Option<usize>,
    /// Number of the rotation that its offset is turned by; None: no rotation.
    pub(super) rotation: Option<usize>,
    /// The constant part of the offset, metres.
    pub(super) offset: [f64; 3],
    /// What channels add to it: channel, metres a unit of it along each axis.
    pub(super) moves: Vec<(usize, [f64; 3])>,
}

/// A clip's kinematics as a list of steps.
#[derive(Clone, Debug)]
pub(super) struct PoseProgram {
    /// Of the rotation channels.
    pub(super) angle_unit: AngleUnit,
    /// Each makes one rotation, parents first.
    pub(super) turns: Vec<TurnStep>,
    /// Joints, then leaf ends; bases first.
    pub(super) points: Vec<PointStep>,
}

/// A channel as the program sees it.
#[derive(Clone, Copy)]
enum Value {
    Fixed(f64),
    Varies(usize),
}

impl PoseProgram {
    /// The steps for a clip; None where a value is too large for the sine kernel, or no number.
    pub(super) fn of(clip: &Clip) -> Option<PoseProgram> {
        let skeleton = &*clip.skeleton;
        let values = channel_values(clip)?;
        let first_channels = skeleton.first_channels();
        let up = match clip.up {
            UpAxis::Y => DMat3::IDENTITY,
            UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        };
        let n_joints = skeleton.joints.len();
        let mut program = PoseProgram { angle_unit: skeleton.angle_unit, turns: Vec::new(), points: Vec::new() };
        // Of each joint: the rotation V, the constant T, and the channel that stretches its bone.
        let mut rotations: Vec<(Option<usize>, DMat3)> = Vec::with_capacity(n_joints);
        let mut stretches: Vec<Value> = Vec::with_capacity(n_joints);
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let channels = &values[first_channels[index]..first_channels[index] + joint.channels.len()];
            let rest = joint.axis.map_or(DQuat::IDENTITY, rest_rotation);
            let (from, tail) = joint.parent.map_or((None, up), |parent| rotations[parent]);

            let parts = offset_parts(clip, joint, channels, rest, |parent| stretches[parent]);
            program.add_point(joint.parent, from, tail, clip.unit_m, &parts);

            let mut factors = Factors { done: Vec::new(), pending: tail };
            if skeleton.format == Format::Amc {
                factors.fixed(DMat3::from_quat(rest));
            }
            for (axis, value) in turns_in_order(skeleton.format, joint, channels) {
                factors.turn(axis, value, skeleton.angle_unit);
            }
            if skeleton.format == Format::Amc && joint.parent.is_some() {
                factors.fixed(DMat3::from_quat(rest).transpose());
            }
            let rotation = if factors.done.is_empty() {
                from
            } else {
                program.turns.push(TurnStep { from, factors: factors.done });
                Some(program.turns.len() - 1)
            };
            rotations.push((rotation, factors.pending));
            stretches.push(last_of(joint, channels, ChannelKind::Length, None));
        }
        for joint in skeleton.ends() {
            let parts = match skeleton.joints[joint].bone {
                Some(bone) => {
                    vec![(Value::Fixed(bone.length), bone.direction), (stretches[joint], bone.direction)]
                }
                None => vec![(Value::Fixed(1.0), skeleton.joints[joint].end.unwrap_or(DVec3::ZERO))],
            };
            let (rotation, tail) = rotations[joint];
            program.add_point(Some(joint), rotation, tail, clip.unit_m, &parts);
        }
        Some(program)
    }

    /// Adds a point at `tail` times the sum of `value * vector`, in metres.
    fn add_point(
        &mut self,
        base: Option<usize>,
        rotation: Option<usize>,
        tail: DMat3,
        unit_m: f64,
        parts: &[(Value, DVec3)],
    ) {
        let mut offset = DVec3::ZERO;
        let mut moves = Vec::new();
        for &(value, vector) in parts {
            match value {
                Value::Fixed(value) => offset += vector * value,
                Value::Varies(channel) => moves.push((channel, (tail * vector * unit_m).to_array())),
            }
        }
        self.points.push(PointStep { base, rotation, offset: (tail * offset * unit_m).to_array(), moves });
    }
}

/// Factors of one joint; neighbors that are constant are multiplied together.
struct Factors {
    done: Vec<Factor>,
    pending: DMat3,
}

impl Factors {
    fn fixed(&mut self, matrix: DMat3) {
        self.pending *= matrix;
    }

    fn turn(&mut self, axis: Axis, value: Value, unit: AngleUnit) {
        match value {
            Value::Fixed(0.0) => {}
            Value::Fixed(angle) => self.fixed(about(axis, angle, unit)),
            Value::Varies(channel) => {
                if self.pending != DMat3::IDENTITY {
                    self.done.push(Factor::Fixed(self.pending.transpose().to_cols_array_2d()));
                    self.pending = DMat3::IDENTITY;
                }
                self.done.push(Factor::Turn(axis, channel));
            }
        }
    }
}

/// Which channels vary, and what the others are.
fn channel_values(clip: &Clip) -> Option<Vec<Value>> {
    let limit = match clip.skeleton.angle_unit {
        AngleUnit::Degrees => DEGREES_LIMIT,
        AngleUnit::Radians => RADIANS_LIMIT,
    };
    let width = clip.skeleton.n_channels();
    if clip.n_frames == 0 {
        return Some(vec![Value::Fixed(0.0); width]);
    }
    let first = clip.frame(0);
    let mut varies = vec![false; width];
    let mut fits = true;
    for frame in 0..clip.n_frames {
        for ((varies, value), first) in varies.iter_mut().zip(clip.frame(frame)).zip(first) {
            *varies |= value != first;
            fits &= value.abs() < limit;
        }
    }
    let value = |channel: usize| match varies[channel] {
        true => Value::Varies(channel),
        false => Value::Fixed(f64::from(first[channel])),
    };
    fits.then(|| (0..width).map(value).collect())
}

/// The offset from the parent as a sum of values times vectors, file units.
fn offset_parts(
    clip: &Clip,
    joint: &Joint,
    channels: &[Value],
    rest: DQuat,
    stretch_of: impl Fn(usize) -> Value,
) -> Vec<(Value, DVec3)> {
    let skeleton = &*clip.skeleton;
    let positions = joint.channels.iter().zip(channels).filter(|(channel, _)| channel.kind == ChannelKind::Position);
    if skeleton.format == Format::Amc {
        let bone = joint.parent.and_then(|parent| skeleton.joints[parent].bone.map(|bone| (parent, bone)));
        let mut parts = match bone {
            Some((parent, bone)) => {
                vec![(Value::Fixed(bone.length), bone.direction), (stretch_of(parent), bone.direction)]
            }
            None => vec![(Value::Fixed(1.0), joint.offset)],
        };
        let space = if joint.parent.is_some() { rest } else { DQuat::IDENTITY };
        parts.extend(positions.map(|(channel, &value)| (value, space * unit(channel.axis))));
        return parts;
    }
    if skeleton.position_rule == PositionRule::Add {
        let mut parts = vec![(Value::Fixed(1.0), joint.offset)];
        parts.extend(positions.map(|(channel, &value)| (value, unit(channel.axis))));
        return parts;
    }
    // The last position channel of an axis takes the place of that component.
    let mut components = joint.offset.to_array().map(Value::Fixed);
    for (channel, &value) in positions {
        components[channel.axis.index()] = value;
    }
    components.into_iter().zip([DVec3::X, DVec3::Y, DVec3::Z]).collect()
}

/// A joint's rotations from the outermost to the innermost.
fn turns_in_order(format: Format, joint: &Joint, channels: &[Value]) -> Vec<(Axis, Value)> {
    match format {
        Format::Bvh => joint
            .channels
            .iter()
            .zip(channels)
            .filter(|(channel, _)| channel.kind == ChannelKind::Rotation)
            .map(|(channel, &value)| (channel.axis, value))
            .collect(),
        Format::Amc => {
            let order = joint.axis.map_or([Axis::X, Axis::Y, Axis::Z], |axis| axis.order);
            let turn = |axis| (axis, last_of(joint, channels, ChannelKind::Rotation, Some(axis)));
            order.into_iter().rev().map(turn).collect()
        }
    }
}

/// The last channel of a kind (about an axis); 0 where there is none.
fn last_of(joint: &Joint, channels: &[Value], kind: ChannelKind, axis: Option<Axis>) -> Value {
    let fits = |n: &usize| {
        let channel = joint.channels[*n];
        channel.kind == kind && axis.is_none_or(|axis| axis == channel.axis)
    };
    (0..channels.len()).rev().find(fits).map_or(Value::Fixed(0.0), |n| channels[n])
}

fn unit(axis: Axis) -> DVec3 {
    DVec3::AXES[axis.index()]
}

fn about(axis: Axis, angle: f64, unit: AngleUnit) -> DMat3 {
    let (sin, cos) = match unit {
        AngleUnit::Degrees => sincos_degrees(angle),
        AngleUnit::Radians => sincos_radians(angle),
    };
    let (next, last) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
    let mut matrix = DMat3::IDENTITY;
    matrix.col_mut(next)[next] = cos;
    matrix.col_mut(last)[last] = cos;
    matrix.col_mut(next)[last] = sin;
    matrix.col_mut(last)[next] = -sin;
    matrix
}
