//! The body: a CMU-like skeleton scaled by height, as Acclaim (with its ASF text) or with the names of BVH conversions.
//!
//! Bone names, tree, rest pose, rest axes and degrees of freedom follow the CMU convention (legs spread by 20
//! degrees, arms out to the sides, every bone turning at its near end); lengths and directions are our own round numbers.

use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Bone, Channel, ChannelKind, Format, Joint, RestAxis, Skeleton};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Metres a file unit of CMU's ASF and AMC files: inches over the `length 0.45` of their headers.
pub const ASF_UNIT_M: f64 = 0.0254 / 0.45;

/// Metres a file unit of our BVH files: centimetres.
pub const BVH_UNIT_M: f64 = 0.01;

/// Somebody who moves: clips of one subject share one skeleton, so that they can be grafted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// Stem of the subject's ASF file.
    pub name: String,
    /// Body height in metres, 1.2 to 2.1.
    pub height_m: f64,
}

/// Joint indices, in the order of the file.
#[allow(missing_docs, reason = "the names of the bones say it")]
pub(crate) mod joint {
    pub(crate) const ROOT: usize = 0;
    /// Left, right.
    pub(crate) const FEMUR: [usize; 2] = [2, 7];
    pub(crate) const TIBIA: [usize; 2] = [3, 8];
    pub(crate) const FOOT: [usize; 2] = [4, 9];
    pub(crate) const TOES: [usize; 2] = [5, 10];
    pub(crate) const LOWER_BACK: usize = 11;
    pub(crate) const UPPER_BACK: usize = 12;
    pub(crate) const THORAX: usize = 13;
    pub(crate) const LOWER_NECK: usize = 14;
    pub(crate) const UPPER_NECK: usize = 15;
    pub(crate) const HEAD: usize = 16;
    pub(crate) const CLAVICLE: [usize; 2] = [17, 24];
    pub(crate) const HUMERUS: [usize; 2] = [18, 25];
    pub(crate) const RADIUS: [usize; 2] = [19, 26];
    pub(crate) const WRIST: [usize; 2] = [20, 27];
    pub(crate) const HAND: [usize; 2] = [21, 28];
    pub(crate) const FINGERS: [usize; 2] = [22, 29];
    pub(crate) const THUMB: [usize; 2] = [23, 30];
    pub(crate) const COUNT: usize = 31;
}

/// Height at which the lengths below are worn as written.
const REFERENCE_HEIGHT_M: f64 = 1.75;

/// One bone of the left side or the middle; the right side mirrors it.
struct BoneShape {
    name: &'static str,
    bvh_name: &'static str,
    parent: &'static str,
    /// To the far end, at rest.
    direction: [f64; 3],
    /// File units of [`ASF_UNIT_M`].
    length: f64,
    /// Rest axis, XYZ, degrees.
    axis_degrees: [f64; 3],
    dof: &'static str,
}

const fn bone(
    name: &'static str,
    bvh_name: &'static str,
    parent: &'static str,
    direction: [f64; 3],
    length: f64,
    axis_degrees: [f64; 3],
    dof: &'static str,
) -> BoneShape {
    BoneShape { name, bvh_name, parent, direction, length, axis_degrees, dof }
}

const LEG: [BoneShape; 5] = [
    bone("hipjoint", "HipJoint", "root", [0.65, -0.72, 0.243105], 2.5, [0.0, 0.0, 0.0], ""),
    bone("femur", "UpLeg", "hipjoint", [0.34202, -0.939693, 0.0], 7.6, [0.0, 0.0, 20.0], "xyz"),
    bone("tibia", "Leg", "femur", [0.34202, -0.939693, 0.0], 7.2, [0.0, 0.0, 20.0], "x"),
    bone("foot", "Foot", "tibia", [0.088925, -0.24432, 0.965609], 2.2, [-90.0, 0.0, 20.0], "xz"),
    bone("toes", "ToeBase", "foot", [0.0, 0.0, 1.0], 1.1, [-90.0, 0.0, 20.0], "x"),
];

const TRUNK: [BoneShape; 6] = [
    bone("lowerback", "LowerBack", "root", [0.0, 0.998, -0.0632], 2.05, [0.0, 0.0, 0.0], "xyz"),
    bone("upperback", "Spine", "lowerback", [0.0, 0.9996, -0.0283], 2.05, [0.0, 0.0, 0.0], "xyz"),
    bone("thorax", "Spine1", "upperback", [0.0, 1.0, 0.0], 2.05, [0.0, 0.0, 0.0], "xyz"),
    bone("lowerneck", "Neck", "thorax", [0.0, 0.9955, 0.0948], 1.55, [0.0, 0.0, 0.0], "xyz"),
    bone("upperneck", "Neck1", "lowerneck", [0.0, 0.998, -0.0632], 1.55, [0.0, 0.0, 0.0], "xyz"),
    bone("head", "Head", "upperneck", [0.0, 0.9995, -0.0316], 1.6, [0.0, 0.0, 0.0], "xyz"),
];

const ARM: [BoneShape; 7] = [
    bone("clavicle", "Shoulder", "thorax", [0.97, 0.23, -0.0787], 3.6, [0.0, 0.0, 0.0], "yz"),
    bone("humerus", "Arm", "clavicle", [1.0, 0.0, 0.0], 5.0, [180.0, -30.0, -90.0], "xyz"),
    bone("radius", "ForeArm", "humerus", [1.0, 0.0, 0.0], 3.35, [180.0, -30.0, -90.0], "x"),
    bone("wrist", "Hand", "radius", [1.0, 0.0, 0.0], 1.65, [0.0, 90.0, 90.0], "y"),
    bone("hand", "FingerBase", "wrist", [1.0, 0.0, 0.0], 0.7, [0.0, 90.0, 90.0], "xz"),
    bone("fingers", "HandIndex1", "hand", [1.0, 0.0, 0.0], 0.55, [0.0, 90.0, 90.0], "x"),
    bone("thumb", "Thumb", "wrist", [0.71, 0.0, 0.7042], 0.8, [-90.0, 45.0, 0.0], "xz"),
];

/// A bone with its side settled.
struct SidedBone {
    name: String,
    bvh_name: String,
    parent: String,
    direction: DVec3,
    length: f64,
    axis_degrees: [f64; 3],
    dof: &'static str,
}

/// The subject's skeleton as Acclaim: 62 channels a frame, root first; lengths in units of [`ASF_UNIT_M`].
pub fn acclaim_skeleton(subject: &Subject) -> Skeleton {
    let bones = sided_bones(subject.height_m);
    let root_axis = RestAxis { degrees: [0.0; 3], order: XYZ };
    let mut joints = vec![Joint {
        name: "root".to_owned(),
        parent: None,
        offset: DVec3::ZERO,
        end: None,
        channels: six_channels([Axis::X, Axis::Y, Axis::Z]),
        axis: Some(root_axis),
        bone: None,
    }];
    for bone in &bones {
        let parent = parent_index(&bones, bone);
        let vector = bone.direction * bone.length;
        joints.push(Joint {
            name: bone.name.clone(),
            parent: Some(parent),
            offset: joints[parent].bone.map_or(DVec3::ZERO, |bone: Bone| bone.direction * bone.length),
            end: is_leaf(&bones, bone).then_some(vector),
            channels: bone.dof.chars().filter_map(Axis::from_letter).map(rotation).collect(),
            axis: Some(RestAxis { degrees: bone.axis_degrees, order: XYZ }),
            bone: Some(Bone { direction: bone.direction, length: bone.length }),
        });
    }
    Skeleton { format: Format::Amc, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::default() }
}

/// The same body with the joint names of common BVH conversions of CMU, in centimetres.
///
/// Rotations are in the order Z Y X, in which a leg may bend as far as it likes before the angles lock; the root's are
/// in the order Y X Z, in which it may turn to any heading.
///
/// Joint for joint that of [`acclaim_skeleton`], so local rotations carry over unchanged.
pub fn bvh_skeleton(subject: &Subject) -> Skeleton {
    let bones = sided_bones(subject.height_m);
    // A tenth of a micrometre: short numbers in the file, no visible difference.
    let centimetres = |vector: DVec3| (vector * (ASF_UNIT_M / BVH_UNIT_M * 1e5)).round() / 1e5;
    let mut joints = vec![Joint {
        name: "Hips".to_owned(),
        parent: None,
        offset: DVec3::ZERO,
        end: None,
        channels: six_channels([Axis::Y, Axis::X, Axis::Z]),
        axis: None,
        bone: None,
    }];
    for bone in &bones {
        let parent = parent_index(&bones, bone);
        let from_parent =
            if parent == 0 { DVec3::ZERO } else { bones[parent - 1].direction * bones[parent - 1].length };
        joints.push(Joint {
            name: bone.bvh_name.clone(),
            parent: Some(parent),
            offset: centimetres(from_parent),
            end: is_leaf(&bones, bone).then(|| centimetres(bone.direction * bone.length)),
            channels: [Axis::Z, Axis::Y, Axis::X].map(rotation).to_vec(),
            axis: None,
            bone: None,
        });
    }
    Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::default() }
}

/// The text of the subject's ASF file; reading it gives [`acclaim_skeleton`].
pub fn asf_text(subject: &Subject) -> String {
    let bones = sided_bones(subject.height_m);
    let mut text = String::from(":version 1.10\n");
    // Writing to a String can't fail.
    let _ = writeln!(text, ":name {}", subject.name);
    text.push_str(":units\n  mass 1.0\n  length 0.45\n  angle deg\n");
    let _ = writeln!(
        text,
        ":documentation\n  A procedural body of {} m, made by motionmill. None of its motion is captured.",
        subject.height_m
    );
    text.push_str(":root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n:bonedata\n");
    for (index, bone) in bones.iter().enumerate() {
        let [x, y, z] = bone.direction.to_array();
        let [a, b, c] = bone.axis_degrees;
        let _ = writeln!(text, "  begin\n    id {}\n    name {}", index + 1, bone.name);
        let _ = writeln!(text, "    direction {x} {y} {z}\n    length {}\n    axis {a} {b} {c} XYZ", bone.length);
        if !bone.dof.is_empty() {
            let dof: Vec<String> = bone.dof.chars().map(|letter| format!("r{letter}")).collect();
            let _ = writeln!(text, "    dof {}", dof.join(" "));
            let limits = vec!["(-180.0 180.0)"; dof.len()];
            let _ = writeln!(text, "    limits {}", limits.join("\n           "));
        }
        text.push_str("  end\n");
    }
    text.push_str(":hierarchy\n  begin\n");
    for parent in core::iter::once("root").chain(bones.iter().map(|bone| bone.name.as_str())) {
        let children: Vec<&str> =
            bones.iter().filter(|bone| bone.parent == parent).map(|bone| bone.name.as_str()).collect();
        if !children.is_empty() {
            let _ = writeln!(text, "    {parent} {}", children.join(" "));
        }
    }
    text.push_str("  end\n");
    text
}

const XYZ: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

fn rotation(axis: Axis) -> Channel {
    Channel { kind: ChannelKind::Rotation, axis }
}

fn six_channels(rotations: [Axis; 3]) -> Vec<Channel> {
    let positions = XYZ.map(|axis| Channel { kind: ChannelKind::Position, axis });
    positions.into_iter().chain(rotations.map(rotation)).collect()
}

fn sided_bones(height_m: f64) -> Vec<SidedBone> {
    let scale = height_m / REFERENCE_HEIGHT_M;
    let sided = |shape: &BoneShape, side: &str| {
        let mirrored = side == "r";
        let flip = |value: f64| if mirrored && value != 0.0 { -value } else { value };
        let [x, y, z] = shape.direction;
        let [a, b, c] = shape.axis_degrees;
        let in_trunk = ["root", "thorax"].contains(&shape.parent);
        let bvh_side = match (side, shape.name) {
            ("", _) => "",
            ("l", "hipjoint" | "thumb") => "L",
            ("r", "hipjoint" | "thumb") => "R",
            ("l", _) => "Left",
            _ => "Right",
        };
        SidedBone {
            name: format!("{side}{}", shape.name),
            bvh_name: format!("{bvh_side}{}", shape.bvh_name),
            parent: if in_trunk || side.is_empty() {
                shape.parent.to_owned()
            } else {
                format!("{side}{}", shape.parent)
            },
            direction: DVec3::new(flip(x), y, z),
            length: (shape.length * scale * 1e4).round() / 1e4,
            axis_degrees: [a, flip(b), flip(c)],
            dof: shape.dof,
        }
    };
    let limbs = |shapes: &'static [BoneShape], side: &'static str| shapes.iter().map(move |shape| sided(shape, side));
    limbs(&LEG, "l")
        .chain(limbs(&LEG, "r"))
        .chain(limbs(&TRUNK, ""))
        .chain(limbs(&ARM, "l"))
        .chain(limbs(&ARM, "r"))
        .collect()
}

/// Joint index of a bone's parent: bones follow the root in their own order.
fn parent_index(bones: &[SidedBone], bone: &SidedBone) -> usize {
    bones.iter().position(|other| other.name == bone.parent).map_or(0, |at| at + 1)
}

fn is_leaf(bones: &[SidedBone], bone: &SidedBone) -> bool {
    bones.iter().all(|other| other.parent != bone.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn subject() -> Subject {
        Subject { name: "s01".to_owned(), height_m: 1.8 }
    }

    #[test]
    fn joints_stand_where_the_indices_say() {
        let skeleton = acclaim_skeleton(&subject());
        assert_eq!(skeleton.joints.len(), joint::COUNT);
        assert_eq!(skeleton.n_channels(), 62, "as many numbers a frame as CMU");
        for (index, name) in [
            (joint::ROOT, "root"),
            (joint::FEMUR[0], "lfemur"),
            (joint::TIBIA[1], "rtibia"),
            (joint::TOES[1], "rtoes"),
            (joint::THORAX, "thorax"),
            (joint::HEAD, "head"),
            (joint::CLAVICLE[0], "lclavicle"),
            (joint::WRIST[0], "lwrist"),
            (joint::FINGERS[0], "lfingers"),
            (joint::THUMB[0], "lthumb"),
            (joint::HUMERUS[1], "rhumerus"),
            (joint::THUMB[1], "rthumb"),
        ] {
            assert_eq!(skeleton.joints[index].name, name);
        }
        for (index, joint) in skeleton.joints.iter().enumerate() {
            assert!(joint.parent.is_none_or(|parent| parent < index), "{} stands before its parent", joint.name);
        }
    }

    #[test]
    fn both_formats_are_one_body() {
        let (acclaim, bvh) = (acclaim_skeleton(&subject()), bvh_skeleton(&subject()));
        for (a, b) in acclaim.joints.iter().zip(&bvh.joints) {
            assert_eq!(a.parent, b.parent);
            assert!((a.offset * ASF_UNIT_M - b.offset * BVH_UNIT_M).length() < 1e-6, "{} {}", a.name, b.name);
            assert_eq!(a.end.is_some(), b.end.is_some());
        }
        assert_eq!(bvh.joints[joint::WRIST[1]].name, "RightHand");
        assert_eq!(bvh.joints[1].name, "LHipJoint");
    }

    #[test]
    fn the_asf_text_prints_every_bone_as_the_skeleton_has_it() {
        let text = asf_text(&subject());
        for joint in &acclaim_skeleton(&subject()).joints[1..] {
            let bone = joint.bone.unwrap_or_else(|| panic!("{} has no bone", joint.name));
            let block = text.split("begin").find(|block| block.contains(&format!("name {}\n", joint.name)));
            let block = block.map_or_else(|| panic!("{} is missing", joint.name), str::to_owned);
            assert!(block.contains(&format!("length {}\n", bone.length)), "{block}");
            assert!(block.contains(&format!("direction {} ", bone.direction.x)), "{block}");
        }
        assert!(text.contains("    thorax lowerneck lclavicle rclavicle\n"));
        assert!(text.contains("    lwrist lhand lthumb\n"));
    }

    #[test]
    fn a_tall_subject_is_a_scaled_one() {
        let length = |height_m| {
            let skeleton = acclaim_skeleton(&Subject { name: "s".to_owned(), height_m });
            skeleton.joints[joint::FEMUR[0]].bone.map_or(0.0, |bone| bone.length)
        };
        assert!((length(2.1) / length(1.2) - 1.75).abs() < 1e-4);
    }
}
