//! Sections of the config that no room has settings of its own for, or that hold more than a room's settings.

use crate::cluster::EffectorWeights;
use serde::{Deserialize, Serialize};

/// The `annotations` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AnnotationSettings {
    /// Whether log-odds, force and ground of every frame are written beside the labels.
    pub diagnostics: bool,
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
