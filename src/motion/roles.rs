//! Which joint is which part of the body.

use serde::{Deserialize, Serialize};

/// A part of the body that a joint (or a leaf's end) stands for.
///
/// A role names a *point where the body turns*: `knee_left` is the joint that the shank turns about, `wrist_left`
/// the far end of the forearm, `head` the base of the skull, `toe_left` the ball of the foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Role {
    Hips,
    Spine,
    Chest,
    Neck,
    Head,
    ClavicleLeft,
    ShoulderLeft,
    ElbowLeft,
    WristLeft,
    ClavicleRight,
    ShoulderRight,
    ElbowRight,
    WristRight,
    ThighLeft,
    KneeLeft,
    AnkleLeft,
    ToeLeft,
    ThighRight,
    KneeRight,
    AnkleRight,
    ToeRight,
}

/// Which point of the skeleton has which role.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RoleMap {
    points: [Option<usize>; Role::COUNT],
}

impl Role {
    /// Number of roles.
    pub const COUNT: usize = 21;

    /// All roles, in order.
    pub const ALL: [Role; Role::COUNT] = [
        Role::Hips,
        Role::Spine,
        Role::Chest,
        Role::Neck,
        Role::Head,
        Role::ClavicleLeft,
        Role::ShoulderLeft,
        Role::ElbowLeft,
        Role::WristLeft,
        Role::ClavicleRight,
        Role::ShoulderRight,
        Role::ElbowRight,
        Role::WristRight,
        Role::ThighLeft,
        Role::KneeLeft,
        Role::AnkleLeft,
        Role::ToeLeft,
        Role::ThighRight,
        Role::KneeRight,
        Role::AnkleRight,
        Role::ToeRight,
    ];

    /// What contacts need: the hips and both legs down to the ankles.
    pub const FEET: [Role; 7] = [
        Role::Hips,
        Role::ThighLeft,
        Role::KneeLeft,
        Role::AnkleLeft,
        Role::ThighRight,
        Role::KneeRight,
        Role::AnkleRight,
    ];

    const NAMES: [&'static str; Role::COUNT] = [
        "hips",
        "spine",
        "chest",
        "neck",
        "head",
        "clavicle_left",
        "shoulder_left",
        "elbow_left",
        "wrist_left",
        "clavicle_right",
        "shoulder_right",
        "elbow_right",
        "wrist_right",
        "thigh_left",
        "knee_left",
        "ankle_left",
        "toe_left",
        "thigh_right",
        "knee_right",
        "ankle_right",
        "toe_right",
    ];

    /// The word in tables and configs.
    pub fn name(self) -> &'static str {
        Role::NAMES[self as usize]
    }

    /// The role of that name.
    pub fn from_name(name: &str) -> Option<Role> {
        Role::ALL.into_iter().find(|role| role.name() == name)
    }
}

impl RoleMap {
    /// The point (joint, or `n_joints` + k for the k-th leaf end) with a role.
    pub fn get(&self, role: Role) -> Option<usize> {
        self.points[role as usize]
    }

    /// Gives a role to a point.
    pub fn set(&mut self, role: Role, point: usize) {
        self.points[role as usize] = Some(point);
    }

    /// Takes a role away.
    pub fn clear(&mut self, role: Role) {
        self.points[role as usize] = None;
    }

    /// The first role of a point, if it has one.
    pub fn of_point(&self, point: usize) -> Option<Role> {
        Role::ALL.into_iter().find(|&role| self.get(role) == Some(point))
    }

    /// Whether both legs are known from the hip down to the ankle: what contacts need.
    pub fn has_feet(&self) -> bool {
        Role::FEET.into_iter().all(|role| self.get(role).is_some())
    }
}
