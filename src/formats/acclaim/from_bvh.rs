//! BVH motion as Acclaim: every joint a bone that begins there, angles passed on.

use super::write::bone_names;
use crate::formats::reading::{WriteError, check_channels};
use crate::motion::rotation::{about, euler_near};
use crate::motion::skeleton::{AngleUnit, PositionRule, RestAxis};
use crate::motion::{Axis, Bone, Channel, ChannelKind, Format, Joint, Skeleton};
use glam::{DQuat, DVec3};

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// How a joint moves, from the channels of the clip.
struct Part {
    /// Columns of its channels.
    columns: Vec<(usize, Channel)>,
    /// Where it stands relative to its parent; for the root, and where it shifts, only to begin with.
    base: DVec3,
    /// Whether its position is written with every frame.
    shifts: bool,
    is_root: bool,
    /// In which order its rotations are applied; the first is the innermost.
    letters: [Axis; 3],
    /// Column of each axis' rotation; `None` in all where an axis turns twice and the angles are made anew.
    turn: [Option<usize>; 3],
    is_made: bool,
    /// Angles of the frame before, radians.
    previous: [f64; 3],
}

/// Turns BVH motion into Acclaim motion in the same file units, with the same world positions.
///
/// Bones have no rest axes; their axis letters are the joint's rotation order, so that angles are passed on as
/// they are (but for joints that turn twice about one axis). Position channels that never vary become part of the
/// skeleton, others `tx ty tz`. A joint whose children hang at several places gets a bone of length 0 and a fixed
/// bone `<child>_base` to each. Names become single words, the root's becomes `root`; the root has all six channels.
/// Channels: `[frame][channel]` in and out.
///
/// # Errors
/// [`WriteError`] for an Acclaim skeleton, several roots, half a frame, a number that is not finite.
pub fn bvh_to_acclaim(skeleton: &Skeleton, channels: &[f32]) -> Result<(Skeleton, Vec<f32>), WriteError> {
    if skeleton.format != Format::Bvh {
        return Err(WriteError::WrongFormat { expected: "BVH", found: "Acclaim" });
    }
    let roots = skeleton.joints.iter().filter(|joint| joint.parent.is_none()).count();
    if roots != 1 {
        return Err(WriteError::NotOneRoot { roots });
    }
    let width = skeleton.n_channels();
    check_channels(channels, width)?;
    let mut parts: Vec<Part> = (skeleton.joints.iter().zip(skeleton.first_channels()))
        .map(|(joint, first)| Part::of(joint, first, skeleton.position_rule, channels, width))
        .collect();
    let (target, sources) = build(skeleton, &parts);
    let mut made = Vec::with_capacity(channels.len().checked_div(width).unwrap_or(0) * target.n_channels());
    for frame in channels.chunks_exact(width.max(1)) {
        for source in sources.iter().copied().flatten() {
            let part = &mut parts[source];
            if part.shifts {
                let joint = &skeleton.joints[source];
                let position = part.position(joint, skeleton.position_rule, frame);
                let from = if joint.parent.is_some() { part.base } else { DVec3::ZERO };
                made.extend((position - from).to_array().map(|value| value as f32));
            }
            part.push_angles(frame, &mut made);
        }
    }
    Ok((target, made))
}

/// The Acclaim skeleton, and for each of its joints the BVH joint that moves it.
fn build(skeleton: &Skeleton, parts: &[Part]) -> (Skeleton, Vec<Option<usize>>) {
    let children = skeleton.children();
    let bone_vector = |joint: usize| match children[joint].as_slice() {
        _ if skeleton.joints[joint].parent.is_none() => DVec3::ZERO,
        [] => skeleton.joints[joint].end.unwrap_or(DVec3::ZERO),
        [first, others @ ..] if others.iter().all(|&other| parts[other].base == parts[*first].base) => {
            parts[*first].base
        }
        _ => DVec3::ZERO,
    };
    let vectors: Vec<DVec3> = (0..skeleton.joints.len()).map(bone_vector).collect();
    let mut joints: Vec<Joint> = Vec::new();
    let mut sources = Vec::new();
    let mut target_of = Vec::new();
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let part = &parts[index];
        let mut parent = joint.parent.map(|parent| target_of[parent]);
        let mut offset = joint.parent.map_or(DVec3::ZERO, |parent| vectors[parent]);
        if joint.parent.is_some() && part.base != offset {
            let vector = part.base - offset;
            joints.push(bone(&format!("{}_base", joint.name), parent, offset, vector, Vec::new(), AXES));
            sources.push(None);
            (parent, offset) = (Some(joints.len() - 1), vector);
        }
        target_of.push(joints.len());
        let mut made = bone(&joint.name, parent, offset, vectors[index], part.channels(), part.letters);
        if joint.parent.is_none() {
            made.bone = None;
        }
        made.end = (children[index].is_empty() && joint.parent.is_some()).then_some(vectors[index]);
        joints.push(made);
        sources.push(Some(index));
    }
    let mut target =
        Skeleton { format: Format::Amc, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace };
    for (joint, name) in bone_names(&target).into_iter().enumerate() {
        target.joints[joint].name = name;
    }
    (target, sources)
}

fn bone(
    name: &str,
    parent: Option<usize>,
    offset: DVec3,
    vector: DVec3,
    channels: Vec<Channel>,
    order: [Axis; 3],
) -> Joint {
    let length = vector.length();
    let direction = if length > 0.0 { vector / length } else { DVec3::Y };
    Joint {
        name: name.to_owned(),
        parent,
        offset,
        end: None,
        channels,
        axis: Some(RestAxis { degrees: [0.0; 3], order }),
        bone: Some(Bone { direction, length }),
    }
}

impl Part {
    fn of(joint: &Joint, first: usize, rule: PositionRule, channels: &[f32], width: usize) -> Part {
        let columns: Vec<(usize, Channel)> = (first..).zip(joint.channels.iter().copied()).collect();
        let turns: Vec<(usize, Axis)> = (columns.iter())
            .filter(|(_, channel)| channel.kind == ChannelKind::Rotation)
            .map(|&(column, channel)| (column, channel.axis))
            .collect();
        let mut turn = [None; 3];
        for &(column, axis) in &turns {
            turn[axis.index()] = Some(column);
        }
        let is_made = turn.iter().flatten().count() < turns.len();
        let mut letters: Vec<Axis> = turns.iter().rev().map(|&(_, axis)| axis).collect();
        if is_made {
            letters = AXES.to_vec();
        }
        letters.extend(AXES.into_iter().filter(|axis| !turns.iter().any(|(_, known)| known == axis)));
        let letters = [letters[0], letters[1], letters[2]];
        let mut part = Part {
            columns,
            base: joint.offset,
            shifts: joint.parent.is_none(),
            is_root: joint.parent.is_none(),
            letters,
            turn,
            is_made,
            previous: [0.0; 3],
        };
        let mut frames = channels.chunks_exact(width.max(1));
        if let Some(first) = frames.next() {
            part.base = part.position(joint, rule, first);
            part.shifts |= frames.any(|frame| part.position(joint, rule, frame) != part.base);
        }
        part
    }

    /// Where the joint stands relative to its parent, file units.
    fn position(&self, joint: &Joint, rule: PositionRule, frame: &[f32]) -> DVec3 {
        let mut position = joint.offset;
        for (column, channel) in self.columns.iter().filter(|(_, channel)| channel.kind == ChannelKind::Position) {
            let value = f64::from(frame[*column]);
            match rule {
                PositionRule::Replace => position[channel.axis.index()] = value,
                PositionRule::Add => position[channel.axis.index()] += value,
            }
        }
        position
    }

    /// Degrees of freedom in the order that every reader knows.
    fn channels(&self) -> Vec<Channel> {
        let positions = AXES.map(|axis| Channel { kind: ChannelKind::Position, axis });
        let rotations = AXES.map(|axis| Channel { kind: ChannelKind::Rotation, axis });
        positions
            .into_iter()
            .filter(|_| self.shifts)
            .chain(rotations.into_iter().filter(|channel| self.turns(channel.axis)))
            .collect()
    }

    fn turns(&self, axis: Axis) -> bool {
        // The root has all three whatever the file says: readers expect them.
        self.is_root || self.is_made || self.turn[axis.index()].is_some()
    }

    fn push_angles(&mut self, frame: &[f32], made: &mut Vec<f32>) {
        if !self.is_made {
            let value = |axis: Axis| self.turn[axis.index()].map_or(0.0, |column| frame[column]);
            made.extend(AXES.into_iter().filter(|&axis| self.turns(axis)).map(value));
            return;
        }
        let mut rotation = DQuat::IDENTITY;
        for (column, channel) in self.columns.iter().filter(|(_, channel)| channel.kind == ChannelKind::Rotation) {
            rotation *= about(channel.axis, f64::from(frame[*column]).to_radians());
        }
        // Letters XYZ: Z is the outermost.
        let [z, y, x] = euler_near(rotation, [Axis::Z, Axis::Y, Axis::X], self.previous);
        self.previous = [z, y, x];
        made.extend([x, y, z].map(|angle| angle.to_degrees() as f32));
    }
}
