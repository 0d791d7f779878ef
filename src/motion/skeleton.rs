//! Skeletons: joints in a tree, parents before children, with the channels that move them.
//!
//! One form serves both formats. A BVH joint turns by its rotation channels in the order listed (the first is
//! the outermost). An Acclaim bone is the joint at its *near* end: its offset is its parent's bone vector, it
//! turns by `C M C^-1` where `C` is its rest axis and `M` the product of its rotations in the order of the
//! axis letters (whatever the order of its numbers); a `l` channel lengthens the bone and so moves the children.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The text format that a skeleton came in, which decides how its channels compose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Biovision hierarchy.
    Bvh,
    /// Acclaim skeleton (ASF) and motion (AMC).
    Amc,
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "X, Y and Z say it")]
pub enum Axis {
    X,
    Y,
    Z,
}

/// What one number of a frame moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ChannelKind {
    /// Translation along an axis, file units.
    Position,
    /// Rotation about an axis, in the skeleton's angle unit.
    Rotation,
    /// Acclaim's `l`: added to the bone's length, file units. Its axis is X and means nothing.
    Length,
}

/// One scalar column of the source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Channel {
    /// What it moves.
    pub kind: ChannelKind,
    /// Along or about which axis.
    pub axis: Axis,
}

/// The unit of rotation channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "the names say it")]
pub enum AngleUnit {
    Degrees,
    Radians,
}

/// An Acclaim rest axis `C`: rotations applied in the order of the letters (`XYZ` is `Rz Ry Rx`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestAxis {
    /// Angles in degrees, one per letter, in the order written.
    pub degrees: [f64; 3],
    /// The letters.
    pub order: [Axis; 3],
}

/// An Acclaim bone from its joint to its far end, file units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bone {
    /// As written; not always of unit length.
    pub direction: DVec3,
    /// Multiplies the direction.
    pub length: f64,
}

/// What a position channel does to its joint's offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PositionRule {
    /// It replaces that component (Bandai-Namco, LaFAN1, and every root).
    #[default]
    Replace,
    /// It is added to it.
    Add,
}

/// A transform with a parent, and the channels that move it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// As in the file (repaired UTF-8), not necessarily unique.
    pub name: String,
    /// Index of the parent, always lower than the joint's own.
    pub parent: Option<usize>,
    /// From the parent's joint to this one at rest, file units. Acclaim: the parent's bone vector, the root's position.
    pub offset: DVec3,
    /// A leaf's End Site, or a leaf bone's far end, from the joint, file units.
    pub end: Option<DVec3>,
    /// In file order.
    pub channels: Vec<Channel>,
    /// Acclaim only.
    pub axis: Option<RestAxis>,
    /// Acclaim only, not at the root.
    pub bone: Option<Bone>,
}

/// Joints in a tree, parents before children.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skeleton {
    /// Decides how channels compose.
    pub format: Format,
    /// Parents before children; several roots are possible (a prop).
    pub joints: Vec<Joint>,
    /// Of the rotation channels.
    pub angle_unit: AngleUnit,
    /// What position channels do to offsets.
    pub position_rule: PositionRule,
}

impl Axis {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// `X`, `Y` or `Z`.
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z'][self.index()]
    }

    /// From a letter of either case.
    pub fn from_letter(letter: char) -> Option<Axis> {
        match letter.to_ascii_uppercase() {
            'X' => Some(Axis::X),
            'Y' => Some(Axis::Y),
            'Z' => Some(Axis::Z),
            _ => None,
        }
    }
}

impl Channel {
    /// The name after the dot in the `channels` table: `Xposition`, `Zrotation`, `Length`.
    pub fn name(self) -> String {
        match self.kind {
            ChannelKind::Position => format!("{}position", self.axis.letter()),
            ChannelKind::Rotation => format!("{}rotation", self.axis.letter()),
            ChannelKind::Length => "Length".to_owned(),
        }
    }
}

impl Format {
    /// The word in tables.
    pub fn name(self) -> &'static str {
        match self {
            Format::Bvh => "bvh",
            Format::Amc => "amc",
        }
    }
}

impl Skeleton {
    /// Channels of one frame.
    pub fn n_channels(&self) -> usize {
        self.joints.iter().map(|joint| joint.channels.len()).sum()
    }

    /// Index of each joint's first channel.
    pub fn first_channels(&self) -> Vec<usize> {
        let mut next = 0;
        self.joints
            .iter()
            .map(|joint| {
                let first = next;
                next += joint.channels.len();
                first
            })
            .collect()
    }

    /// Joints with an `end`, in order. Point `joints.len() + k` of [`Poses`](super::Poses) is the end of the k-th.
    pub fn ends(&self) -> Vec<usize> {
        (0..self.joints.len()).filter(|&joint| self.joints[joint].end.is_some()).collect()
    }

    /// Children of each joint, in order.
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = vec![Vec::new(); self.joints.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            if let Some(parent) = joint.parent {
                children[parent].push(index);
            }
        }
        children
    }

    /// Joint names made unique without regard to case: `#2`, `#3` ... on repeats, in joint order.
    pub fn unique_joint_names(&self) -> Vec<String> {
        unique_names(self.joints.iter().map(|joint| joint.name.clone()))
    }

    /// Column names of the `channels` table, in file order, unique without regard to case.
    pub fn channel_names(&self) -> Vec<String> {
        let joints = self.unique_joint_names();
        unique_names(
            self.joints.iter().zip(&joints).flat_map(|(joint, name)| {
                joint.channels.iter().map(move |channel| format!("{name}.{}", channel.name()))
            }),
        )
    }

    /// Digest of joint names, parents and channels: it fixes a table's columns. Begins with `L`.
    pub fn layout_id(&self) -> String {
        format!("L{}", self.layout_hasher().finalize().to_hex().split_at(8).0)
    }

    /// Layout plus what fixes the body (DESIGN 3): axes, bones and offsets. Begins with `S`.
    ///
    /// End Sites don't count. Where position channels replace a non-root joint's offset, `bone_lengths_mm` (the
    /// clip's median length of that joint's bone, one entry a joint, in millimetres) counts to 2 mm instead.
    pub fn skeleton_id(&self, bone_lengths_mm: &[f64]) -> String {
        let mut hasher = self.layout_hasher();
        for (index, joint) in self.joints.iter().enumerate() {
            if self.position_replaced(index) {
                let steps = if joint.parent.is_some() { (bone_lengths_mm[index] / 2.0).round() as i64 } else { 0 };
                hasher.update(&steps.to_le_bytes());
            } else {
                for value in joint.offset.to_array() {
                    hasher.update(&(value + 0.0).to_le_bytes());
                }
            }
            if let Some(axis) = &joint.axis {
                for (degrees, letter) in axis.degrees.iter().zip(axis.order) {
                    hasher.update(&(degrees + 0.0).to_le_bytes());
                    hasher.update(&[letter.letter() as u8]);
                }
            }
            if let Some(bone) = &joint.bone {
                for value in bone.direction.to_array().into_iter().chain([bone.length]) {
                    hasher.update(&(value + 0.0).to_le_bytes());
                }
            }
        }
        format!("S{}", hasher.finalize().to_hex().split_at(12).0)
    }

    /// Whether position channels take the whole place of a joint's offset.
    pub fn position_replaced(&self, joint: usize) -> bool {
        self.position_rule == PositionRule::Replace
            && self.format == Format::Bvh
            && [Axis::X, Axis::Y, Axis::Z]
                .into_iter()
                .all(|axis| self.joints[joint].channels.contains(&Channel { kind: ChannelKind::Position, axis }))
    }

    fn layout_hasher(&self) -> blake3::Hasher {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.format.name().as_bytes());
        hasher.update(&[self.angle_unit as u8, self.position_rule as u8]);
        for joint in &self.joints {
            hasher.update(&(joint.name.len() as u64).to_le_bytes());
            hasher.update(joint.name.as_bytes());
            hasher.update(&joint.parent.map_or(-1, |parent| parent as i64).to_le_bytes());
            hasher.update(&(joint.channels.len() as u64).to_le_bytes());
            for channel in &joint.channels {
                hasher.update(channel.name().as_bytes());
            }
        }
        hasher
    }
}

/// Appends `#2`, `#3` ... to names that repeat without regard to case.
pub fn unique_names(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut taken = std::collections::BTreeSet::<String>::new();
    names
        .map(|name| {
            let unique = (1..)
                .map(|n| if n == 1 { name.clone() } else { format!("{name}#{n}") })
                .find(|candidate| !taken.contains(&candidate.to_lowercase()))
                .unwrap_or_default();
            taken.insert(unique.to_lowercase());
            unique
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_names_stay_apart() {
        let names = ["Foot", "foot", "Foot#2", "Hand"].map(str::to_owned);
        assert_eq!(unique_names(names.into_iter()), ["Foot", "foot#2", "Foot#2#2", "Hand"]);
    }
}
