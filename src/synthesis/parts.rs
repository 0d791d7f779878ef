//! The parts of a body that grafting can exchange, as provenance names them: chains with everything that hangs on
//! them ([`BodyChains`], GRAFTS 1), the legs taken together.

use crate::motion::chains::BodyChains;
use serde::{Deserialize, Serialize};

/// A part of the body, as provenance names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// All from the hierarchy's root down to the hips, and what belongs to nothing else.
    Root,
    /// Both legs.
    Legs,
    /// Above the hips, up to and with the joint where the shoulders part.
    Trunk,
    /// Neck and head.
    Head,
    /// Left arm with clavicle, hand and fingers.
    ArmLeft,
    /// Right arm likewise.
    ArmRight,
}

/// The joints of each part; every joint is in one part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parts {
    joints: [Vec<usize>; 6],
}

impl Part {
    /// All six, in the order of their rows.
    pub const ALL: [Part; 6] = [Part::Root, Part::Legs, Part::Trunk, Part::Head, Part::ArmLeft, Part::ArmRight];

    /// The arms, left first.
    pub const ARMS: [Part; 2] = [Part::ArmLeft, Part::ArmRight];

    /// The word in tables and recipes.
    pub fn name(self) -> &'static str {
        ["root", "legs", "trunk", "head", "arm_left", "arm_right"][self as usize]
    }

    /// The part of that name.
    pub fn from_name(name: &str) -> Option<Part> {
        Part::ALL.into_iter().find(|part| part.name() == name)
    }

    /// Whether it may be taken from a donor: legs and root are what makes a clip the base.
    pub fn is_graftable(self) -> bool {
        !matches!(self, Part::Root | Part::Legs)
    }
}

impl Parts {
    /// The parts that chains make.
    pub fn of(chains: &BodyChains) -> Parts {
        let sorted = |joints: &[&[usize]]| {
            let mut joints = joints.concat();
            joints.sort_unstable();
            joints
        };
        let joints = Part::ALL.map(|part| match part {
            Part::Root => sorted(&[&chains.pelvis]),
            Part::Legs => sorted(&[&chains.leg_left, &chains.leg_right]),
            Part::Trunk => sorted(&[&chains.trunk]),
            Part::Head => sorted(&[&chains.head]),
            Part::ArmLeft => sorted(&[&chains.arm_left]),
            Part::ArmRight => sorted(&[&chains.arm_right]),
        });
        Parts { joints }
    }

    /// The joints of a part, ascending.
    pub fn joints(&self, part: Part) -> &[usize] {
        &self.joints[part as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::walker::walker;
    use super::*;

    #[test]
    fn every_joint_is_in_the_part_that_the_rule_says() {
        let subject = walker(30.0, 10, 1.0);
        let names = |part: Part| -> Vec<&str> {
            subject.parts.joints(part).iter().map(|&joint| &*subject.clip.skeleton.joints[joint].name).collect()
        };
        assert_eq!(names(Part::Root), ["hips"]);
        assert_eq!(names(Part::Legs)[..4], ["thigh_left", "knee_left", "ankle_left", "toe_left"]);
        assert_eq!(names(Part::Trunk), ["spine", "chest"]);
        assert_eq!(names(Part::Head), ["neck", "head"]);
        assert_eq!(names(Part::ArmLeft), ["clavicle_left", "shoulder_left", "elbow_left", "wrist_left"]);
        assert_eq!(names(Part::ArmRight).len(), 4);
        assert!(Part::ALL.into_iter().all(|part| Part::from_name(part.name()) == Some(part)));
    }
}
