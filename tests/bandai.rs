//! Reads Bandai-Namco's clips for tests of what comes after reading: one dialect, no refusals.

use glam::DVec3;
use motionmill::annotate::Gait;
use motionmill::evaluate::NameRules;
use motionmill::motion::skeleton::{AngleUnit, PositionRule};
use motionmill::motion::{
    Axis, Channel, ChannelKind, Clip, Format, Joint, Poses, Role, RoleMap, Skeleton, UpAxis, kinematics,
};
use motionmill::plan::load_name_rules;
use std::path::Path;
use std::sync::{Arc, OnceLock};

pub(crate) const RATE_HZ: f64 = 30.0;

const NAMES: [(&str, Role); 17] = [
    ("Hips", Role::Hips),
    ("Neck", Role::Neck),
    ("Head", Role::Head),
    ("UpperArm_L", Role::ShoulderLeft),
    ("LowerArm_L", Role::ElbowLeft),
    ("Hand_L", Role::WristLeft),
    ("UpperArm_R", Role::ShoulderRight),
    ("LowerArm_R", Role::ElbowRight),
    ("Hand_R", Role::WristRight),
    ("UpperLeg_L", Role::ThighLeft),
    ("LowerLeg_L", Role::KneeLeft),
    ("Foot_L", Role::AnkleLeft),
    ("Toes_L", Role::ToeLeft),
    ("UpperLeg_R", Role::ThighRight),
    ("LowerLeg_R", Role::KneeRight),
    ("Foot_R", Role::AnkleRight),
    ("Toes_R", Role::ToeRight),
];

/// A clip's poses and the roles of its joints.
pub(crate) fn read(path: &Path) -> (Poses, RoleMap) {
    let clip = read_clip(&std::fs::read_to_string(path).unwrap());
    let mut roles = RoleMap::default();
    for (point, joint) in clip.skeleton.joints.iter().enumerate() {
        if let Some((_, role)) = NAMES.iter().find(|(name, _)| *name == joint.name) {
            roles.set(*role, point);
        }
    }
    assert!(roles.has_feet(), "{}", path.display());
    (kinematics::poses(&clip), roles)
}

/// The gait that a clip's name promises, by the rules that ship. None: another motion.
pub(crate) fn gait_by_name(file: &str) -> Option<Gait> {
    static RULES: OnceLock<NameRules> = OnceLock::new();
    RULES.get_or_init(|| load_name_rules("bandai-namco").unwrap()).class_of(file)
}

/// Names of the clips in a folder that promise a gait, sorted.
pub(crate) fn clips_with_a_gait(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".bvh") && gait_by_name(name).is_some())
        .collect();
    names.sort();
    names
}

fn read_clip(text: &str) -> Clip {
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let mut joints: Vec<Joint> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut in_end_site = false;
    for line in hierarchy.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["ROOT" | "JOINT", name] => {
                joints.push(Joint {
                    name: name.to_owned(),
                    parent: open.last().copied(),
                    offset: DVec3::ZERO,
                    end: None,
                    channels: Vec::new(),
                    axis: None,
                    bone: None,
                });
                open.push(joints.len() - 1);
            }
            ["End", "Site"] => in_end_site = true,
            ["}"] if in_end_site => in_end_site = false,
            ["}"] => drop(open.pop()),
            ["OFFSET", ..] if !in_end_site => {
                let offset: Vec<f64> = words[1..].iter().map(|word| word.parse().unwrap()).collect();
                joints[*open.last().unwrap()].offset = DVec3::from_slice(&offset);
            }
            ["CHANNELS", _, ..] => {
                let channels = words[2..].iter().map(|word| Channel {
                    kind: if word.ends_with("position") { ChannelKind::Position } else { ChannelKind::Rotation },
                    axis: Axis::from_letter(word.chars().next().unwrap()).unwrap(),
                });
                joints[*open.last().unwrap()].channels = channels.collect();
            }
            _ => {}
        }
    }
    let skeleton =
        Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace };
    let rows = motion.split_once("Frame Time:").unwrap().1.split_once('\n').unwrap().1;
    let channels: Vec<f32> = rows.split_ascii_whitespace().map(|word| word.parse().unwrap()).collect();
    let n_frames = channels.len() / skeleton.n_channels();
    assert_eq!(channels.len(), n_frames * skeleton.n_channels());
    Clip { skeleton: Arc::new(skeleton), rate_hz: RATE_HZ, unit_m: 0.01, up: UpAxis::Y, n_frames, channels }
}
