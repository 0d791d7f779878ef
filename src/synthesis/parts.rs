//! The parts of a body that grafting can exchange: chains with everything that hangs on them (GRAFTS 1).
//!
//! Given roles, the folding rule reads: from the hierarchy's root to the hips is `root`; below the hips towards the thighs
//! are `legs`; from there up to the joint where the shoulders part is the `trunk`; each shoulder's branch, with hand
//! and fingers, is an arm; what else hangs on that joint is the `head`. A fork joint belongs to the chain nearer the root.

use super::subject::{Landmarks, ancestry, descends, joint_of};
use crate::motion::Skeleton;
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
    /// Sorts a skeleton's joints into parts.
    pub fn of(skeleton: &Skeleton, landmarks: &Landmarks) -> Parts {
        let ends = skeleton.ends();
        let joint = |point: usize| joint_of(skeleton, &ends, point);
        let shoulders = landmarks.arms.map(|arm| joint(arm.shoulder));
        let fork = ancestry(skeleton, shoulders[0])
            .skip(1)
            .find(|&above| descends(skeleton, shoulders[1], above))
            .unwrap_or(landmarks.hips);
        let branch = |from: usize, towards: usize| {
            ancestry(skeleton, towards).find(|&above| skeleton.joints[above].parent == Some(from))
        };
        let arms = shoulders.map(|shoulder| branch(fork, shoulder));
        let legs = landmarks.legs.map(|leg| branch(landmarks.hips, joint(leg.thigh)));
        let mut joints: [Vec<usize>; 6] = Default::default();
        for index in 0..skeleton.joints.len() {
            let within = |top: &Option<usize>| top.is_some_and(|top| descends(skeleton, index, top));
            let part = if legs.iter().any(within) {
                Part::Legs
            } else if within(&arms[0]) {
                Part::ArmLeft
            } else if within(&arms[1]) {
                Part::ArmRight
            } else if index == landmarks.hips || !descends(skeleton, index, landmarks.hips) {
                Part::Root
            } else if descends(skeleton, fork, index) {
                Part::Trunk
            } else if descends(skeleton, index, fork) {
                Part::Head
            } else {
                Part::Root
            };
            joints[part as usize].push(index);
        }
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
