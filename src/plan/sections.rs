//! Sections of the config that speak to one room each.

use serde::{Deserialize, Serialize};

/// Sizes beyond which a file is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Size of a clip or skeleton file, bytes.
    pub max_clip_bytes: u64,
    /// Joints of a skeleton, count.
    pub max_joints: usize,
    /// Joints from a root to a leaf, count.
    pub max_depth: usize,
    /// Length of a joint's name, bytes.
    pub max_name_bytes: usize,
    /// Frames times joints, count.
    pub max_poses: u64,
}

/// How feet on the ground are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// Height and speed below fixed thresholds, gaps closed (T 3.1).
    #[default]
    Thesis,
}

/// Foot contacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSettings {
    /// Which detector.
    pub detector: Detector,
    /// Thresholds of the thesis' detector.
    pub thesis: ThesisContactSettings,
}

/// Thresholds of the thesis' detector (T 3.1), for a body with a leg of 0.9 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThesisContactSettings {
    /// A planted joint is within this distance of its resting height.
    pub max_height_m: f64,
    /// A planted joint is slower than this.
    pub max_speed_mps: f64,
    /// Gaps up to this long between contacts are closed.
    pub close_gap_s: f64,
}

/// How frames are compared, and how far they are merged (T 4.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClusterSettings {
    /// Frames a second that are clustered; a clip with fewer gives all of its frames.
    pub rate_hz: f64,
    /// The tree stops at the first merge that costs this much.
    pub t_max_m2: f64,
    /// Time by which velocities are multiplied to become lengths: the root of their weight.
    pub velocity_scale_s: f64,
    /// Square of a time by which accelerations are multiplied to become lengths: the root of their weight.
    pub acceleration_scale_s2: f64,
    /// Accelerations longer than this are shortened to it, in comparing only.
    pub max_acceleration_mps2: f64,
    /// Weight of each effector.
    pub weights: EffectorWeights,
}

/// Weight of each effector's squared differences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[expect(missing_docs, reason = "the names say it")]
pub struct EffectorWeights {
    pub head: f64,
    pub wrist_left: f64,
    pub wrist_right: f64,
    pub toe_left: f64,
    pub toe_right: f64,
}

/// Nearest partners of every sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NeighborSettings {
    /// Partners of a sample, count.
    pub count: u32,
    /// A partner is nearer than this.
    pub max_e_m2: f64,
    /// A partner in the same clip is at least this far away in time.
    pub min_gap_s: f64,
}

/// Where the tree is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraphSettings {
    /// One graph for each.
    pub thresholds_m2: Vec<f64>,
}

/// Which recipes are made, and how many (GRAFTS 8).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RecipeSettings {
    /// How many are selected of all that are possible, count.
    pub select: usize,
    /// Seed of whatever is random in them.
    pub seed: u64,
    /// Groups of clips by their legs, at most, count.
    pub leg_groups: usize,
    /// Groups of clips by their arms, at most, count.
    pub arm_groups: usize,
}

/// How donors are placed and blended (GRAFTS 3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraftSettings {
    /// How cyclic donors are laid over their base.
    pub correlation: CorrelationSettings,
    /// Length of the blend inside each end of the grafted stretch.
    pub seam_s: f64,
    /// Its length where the arms of base and donor both move. None: `seam_s` everywhere.
    pub moving_seam_s: Option<f64>,
    /// An arm moves when its wrist is faster than this about the shoulder.
    pub moving_wrist_mps: f64,
}

/// How clips are laid over each other (GRAFTS 2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CorrelationSettings {
    /// Low-pass of the distance between the ankles.
    pub ankle_cutoff_hz: f64,
    /// Fewest pairs of passes that make an alternate, count.
    pub min_pairs: usize,
    /// Share of the best alternate's pairs that any other must have, 0..1.
    pub min_pair_share: f64,
    /// Weight of velocities beside positions in the distance of leg poses.
    pub velocity_weight_s: f64,
    /// Slowest donor speed allowed at any frame, as a factor of its own.
    pub min_rate_factor: f64,
    /// Fastest donor speed allowed.
    pub max_rate_factor: f64,
}

/// What counts as an action of an arm (GRAFTS 3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActionSettings {
    /// Low-pass of the wrist's path about the shoulder.
    pub wrist_cutoff_hz: f64,
    /// The start (or end) pose is the median over this long.
    pub pose_s: f64,
    /// An arm is active when its wrist leaves its start pose by more than this.
    pub min_excursion_m: f64,
    /// And by more than this share of the other arm's, 0..1.
    pub min_share_of_other: f64,
    /// The action holds every frame beyond this share of the peak excursion, 0..1.
    pub window_share: f64,
    /// From there it reaches out to where the wrist is slower than this share of its fast speed, 0..1.
    pub rest_speed_share: f64,
    /// The fast speed is this percentile.
    pub fast_percentile: f64,
}

/// Limits of the gates (GRAFTS 5): the 99th percentile of captured clips, never computed from the user's corpus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GateSettings {
    /// Jerk of the wrists, at most this many times the parents'.
    pub max_wrist_jerk_factor: f64,
    /// Angular acceleration above the hips, at most this many times the parents'.
    pub max_upper_angular_acceleration_factor: f64,
    /// Angular acceleration of the legs, at most this many times the parents'.
    pub max_leg_angular_acceleration_factor: f64,
    /// Skate above the parents'.
    pub max_skate_excess_mps: f64,
    /// Drift of plants above the parents'.
    pub max_plant_drift_excess_m: f64,
    /// Penetration above the parents'; a guess, untested.
    pub max_penetration_excess_m: f64,
    /// Joint ranges, above the parents'.
    pub max_limit_excess_rad: f64,
    /// Self-collision above the parents'.
    pub max_self_collision_excess_m: f64,
    /// Distance of the zero moment point above the parents'.
    pub max_zmp_distance_excess_m: f64,
    /// Distance of an arm to its nearest captured pose.
    pub max_arm_novelty: f64,
    /// The phase of arms after legs that captured gaits have.
    pub arm_leg_relation_cycles: f64,
    /// How far from it is allowed.
    pub max_arm_leg_relation_error_cycles: f64,
    /// How firmly arms and legs must be locked, 0..1.
    pub min_arm_leg_lock: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            max_clip_bytes: 2 << 30,
            max_joints: 4096,
            max_depth: 4096,
            max_name_bytes: 1024,
            max_poses: 200_000_000,
        }
    }
}

impl Default for ThesisContactSettings {
    /// The best fixed pair under the step classifier (CONTACTS 1, 4).
    fn default() -> Self {
        ThesisContactSettings { max_height_m: 0.05, max_speed_mps: 1.0, close_gap_s: 0.05 }
    }
}

impl Default for ClusterSettings {
    /// A captured walk cycle falls into 5 to 10 nodes (FEASIBILITY 1).
    fn default() -> Self {
        ClusterSettings {
            rate_hz: 30.0,
            t_max_m2: 0.5,
            velocity_scale_s: 0.1,
            acceleration_scale_s2: 0.01,
            max_acceleration_mps2: 50.0,
            weights: EffectorWeights::default(),
        }
    }
}

impl Default for EffectorWeights {
    fn default() -> Self {
        EffectorWeights { head: 1.0, wrist_left: 1.0, wrist_right: 1.0, toe_left: 1.0, toe_right: 1.0 }
    }
}

impl Default for NeighborSettings {
    fn default() -> Self {
        NeighborSettings { count: 4, max_e_m2: 0.05, min_gap_s: 0.5 }
    }
}

impl Default for GraphSettings {
    fn default() -> Self {
        GraphSettings { thresholds_m2: vec![0.5] }
    }
}

impl Default for RecipeSettings {
    fn default() -> Self {
        RecipeSettings { select: 200, seed: 1, leg_groups: 25, arm_groups: 60 }
    }
}

impl Default for GraftSettings {
    fn default() -> Self {
        GraftSettings {
            correlation: CorrelationSettings::default(),
            seam_s: 0.5,
            moving_seam_s: None,
            moving_wrist_mps: 0.3,
        }
    }
}

impl Default for CorrelationSettings {
    fn default() -> Self {
        CorrelationSettings {
            ankle_cutoff_hz: 4.0,
            min_pairs: 3,
            min_pair_share: 0.6,
            velocity_weight_s: 0.12,
            min_rate_factor: 0.6,
            max_rate_factor: 1.6,
        }
    }
}

impl Default for ActionSettings {
    fn default() -> Self {
        ActionSettings {
            wrist_cutoff_hz: 6.0,
            pose_s: 0.15,
            min_excursion_m: 0.15,
            min_share_of_other: 0.35,
            window_share: 0.25,
            rest_speed_share: 0.12,
            fast_percentile: 95.0,
        }
    }
}

impl Default for GateSettings {
    fn default() -> Self {
        GateSettings {
            max_wrist_jerk_factor: 1.6,
            max_upper_angular_acceleration_factor: 2.0,
            max_leg_angular_acceleration_factor: 2.3,
            max_skate_excess_mps: 0.012,
            max_plant_drift_excess_m: 0.008,
            max_penetration_excess_m: 0.02,
            max_limit_excess_rad: 0.037,
            max_self_collision_excess_m: 0.034,
            max_zmp_distance_excess_m: 0.063,
            max_arm_novelty: 0.31,
            arm_leg_relation_cycles: 0.064,
            max_arm_leg_relation_error_cycles: 0.09,
            min_arm_leg_lock: 0.95,
        }
    }
}
