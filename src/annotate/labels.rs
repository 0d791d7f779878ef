//! The labels of a clip, as the tables hold them (SCHEMA: annotations, features, plants, segments, clips).

use crate::motion::Role;
use serde::{Deserialize, Serialize};

/// A foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "the names say it")]
pub enum Foot {
    Left,
    Right,
}

/// Locomotion class of a frame or a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Gait {
    /// No class could be inferred.
    Unknown,
    /// Both feet planted for an extended time.
    Stand,
    /// Alternate feet, one always down.
    Walk,
    /// Alternate feet with flights between.
    Run,
    /// Flights between equal supports: both feet, or hops on one.
    Jump,
    /// Of a clip only: no class has nine tenths of its known frames.
    Other,
}

/// Foot plant state of a frame (T 4.2.2; DESIGN 6 where T is silent).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "left, right, both, none; the first letter is the last single support")]
pub enum PlantState {
    L,
    LB,
    LN,
    R,
    RB,
    RN,
    N,
}

/// Per-frame columns of the `annotations` table; every vector has one entry a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameLabels {
    /// Frame over rate, seconds.
    pub time_s: Vec<f64>,
    /// World position of the hips, metres.
    pub root: Vec<[f32; 3]>,
    /// Radians, 0 = +X, counter-clockwise seen from above, unwrapped in time. None: no hips.
    pub heading: Vec<Option<f32>>,
    /// Horizontal speed of the hips, m/s.
    pub speed: Vec<f32>,
    /// Change of heading, rad/s.
    pub turn_rate: Vec<Option<f32>>,
    /// Height above the resting ground, metres: left ankle, left toe, right ankle, right toe.
    pub heights: [Vec<Option<f32>>; 4],
    /// Speed in m/s, in the same order.
    pub speeds: [Vec<Option<f32>>; 4],
    /// Foot in stance (phase, gait): left, right.
    pub stance: [Vec<Option<bool>>; 2],
    /// Foot that may be locked: left, right.
    pub pinned: [Vec<Option<bool>>; 2],
    /// Plant state. None: no feet.
    pub plant_state: Vec<Option<PlantState>>,
    /// Gait. None: no feet.
    pub gait: Vec<Option<Gait>>,
    /// Confidence in the gait, 0..1.
    pub gait_confidence: Vec<Option<f32>>,
    /// Phase of the stride from the left foot's strike, 0..1; None outside walk and run.
    pub phase: Vec<Option<f32>>,
    /// What the detector of contacts weighed. None: not asked for.
    pub diagnostics: Option<FrameDiagnostics>,
}

/// What the detector of contacts weighed; every vector has one entry a frame, None where it is not known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameDiagnostics {
    /// Log-odds of the foot being planted, -3 to 3: left, right.
    pub log_odds: [Vec<Option<f32>>; 2],
    /// Vertical force on the feet, body weights.
    pub force: Vec<Option<f32>>,
    /// World height at which the foot's toe (its ankle where there is none) would rest there, metres: left, right.
    pub ground: [Vec<Option<f32>>; 2],
}

/// A foot on the ground: half-open frame range.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// Which foot.
    pub foot: Foot,
    /// First frame.
    pub first: u32,
    /// Frame after the last.
    pub end: u32,
    /// Median of the toe (ankle where there is none), world metres.
    pub position: [f32; 3],
    /// Largest horizontal distance from it in the middle 60 % of the plant, metres.
    pub slip_m: f32,
    /// Mean probability that the foot is planted, by its log-odds, 0..1. None: a detector without log-odds.
    pub confidence: Option<f32>,
}

/// A run of frames of one gait: half-open frame range.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its class.
    pub gait: Gait,
    /// First frame.
    pub first: u32,
    /// Frame after the last.
    pub end: u32,
    /// 0..1.
    pub confidence: Option<f32>,
}

/// What the `clips` table says of a clip's motion. All None for a skeleton whose feet can't be found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as SCHEMA, clips")]
pub struct ClipLabels {
    pub leg_length_m: Option<f32>,
    pub leg_spread_m: Option<f32>,
    pub ground_height_m: Option<f32>,
    pub ground_spread_m: Option<f32>,
    pub ground_slope_x: Option<f32>,
    pub ground_slope_z: Option<f32>,
    pub ground_slope_share: Option<f32>,
    pub uneven: Option<bool>,
    pub belt_mps: Option<f32>,
    pub noise_m: Option<f32>,
    pub noise_spread_m: Option<f32>,
    pub gait_class: Option<Gait>,
    pub thesis_class: Option<Gait>,
    pub stand_fraction: Option<f32>,
    pub walk_fraction: Option<f32>,
    pub run_fraction: Option<f32>,
    pub jump_fraction: Option<f32>,
    pub unknown_fraction: Option<f32>,
    pub gait_confidence: Option<f32>,
    pub duty_factor: Option<f32>,
    pub flight_fraction: Option<f32>,
    pub checks: Vec<String>,
}

/// Position, velocity and acceleration of the effectors in each frame's neutral frame (T 4.2.1), unweighted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Head, wrist_left, wrist_right, toe_left, toe_right (ankles where there are no toes); empty when one is missing.
    pub effectors: Vec<Role>,
    /// `[frame][effector][p v a][x y z]`: m, m/s, m/s^2.
    pub values: Vec<f32>,
}

impl Gait {
    /// The word in tables.
    pub fn name(self) -> &'static str {
        ["unknown", "stand", "walk", "run", "jump", "other"][self as usize]
    }
}

impl Foot {
    /// The word in tables.
    pub fn name(self) -> &'static str {
        ["left", "right"][self as usize]
    }
}

impl PlantState {
    /// All seven, in order.
    pub const ALL: [PlantState; 7] =
        [PlantState::L, PlantState::LB, PlantState::LN, PlantState::R, PlantState::RB, PlantState::RN, PlantState::N];

    /// The word in tables.
    pub fn name(self) -> &'static str {
        ["L", "LB", "LN", "R", "RB", "RN", "N"][self as usize]
    }

    /// The state of that name.
    pub fn from_name(name: &str) -> Option<PlantState> {
        PlantState::ALL.into_iter().find(|state| state.name() == name)
    }
}
