//! The stages: their names, what each needs, and which section of the config holds its options (DESIGN 6).

use serde::{Deserialize, Serialize};

/// A stage of a pipeline, in the order in which they can flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Files to channels and poses.
    Ingest,
    /// Positions, velocities and accelerations of the effectors.
    Features,
    /// Which foot is on the ground.
    Contacts,
    /// Stand, walk, run, jump.
    Gait,
    /// Frames merged by likeness.
    Tree,
    /// Nearest partners of every sample.
    Neighbors,
    /// The tree cut into nodes and edges.
    Graph,
    /// Which new clips to make.
    Recipes,
    /// The new clips.
    Make,
    /// Which of them hold up beside their parents.
    Judge,
}

/// What a stage takes from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// The other.
    pub stage: Stage,
    /// What it gives, as in "graph needs *the merges that tree makes*".
    pub what: &'static str,
}

impl Stage {
    /// All, in the order in which they can flow.
    pub const ALL: [Stage; 10] = [
        Stage::Ingest,
        Stage::Features,
        Stage::Contacts,
        Stage::Gait,
        Stage::Tree,
        Stage::Neighbors,
        Stage::Graph,
        Stage::Recipes,
        Stage::Make,
        Stage::Judge,
    ];

    /// All names, in the same order.
    pub const NAMES: [&'static str; 10] =
        ["ingest", "features", "contacts", "gait", "tree", "neighbors", "graph", "recipes", "make", "judge"];

    /// The word in pipelines.
    pub fn name(self) -> &'static str {
        Stage::NAMES[self as usize]
    }

    /// The stage of that name.
    pub fn from_name(name: &str) -> Option<Stage> {
        Stage::ALL.into_iter().find(|stage| stage.name() == name)
    }

    /// The section of the config whose fields are this stage's options.
    pub fn section(self) -> Option<&'static str> {
        match self {
            Stage::Ingest => Some("ingest"),
            Stage::Features | Stage::Gait => None,
            Stage::Contacts => Some("contacts"),
            Stage::Tree => Some("cluster"),
            Stage::Neighbors => Some("neighbors"),
            Stage::Graph => Some("graph"),
            Stage::Recipes => Some("recipes"),
            Stage::Make => Some("graft"),
            Stage::Judge => Some("judge"),
        }
    }

    /// What must have run above it.
    pub fn needs(self) -> &'static [Need] {
        const POSES: Need = Need { stage: Stage::Ingest, what: "the poses that ingest gives" };
        const FEATURES: Need = Need { stage: Stage::Features, what: "the features that frames are compared by" };
        const STATES: Need = Need { stage: Stage::Contacts, what: "the plant states that contacts gives" };
        match self {
            Stage::Ingest => &[],
            Stage::Features | Stage::Contacts => &[POSES],
            Stage::Gait => &[Need { stage: Stage::Contacts, what: "the foot contacts that contacts finds" }],
            Stage::Tree | Stage::Neighbors => &[FEATURES, STATES],
            Stage::Graph => &[Need { stage: Stage::Tree, what: "the merges that tree makes" }],
            Stage::Recipes => &[Need { stage: Stage::Gait, what: "the gaits by which clips may be combined" }],
            Stage::Make => &[Need { stage: Stage::Recipes, what: "the recipes that recipes selects" }],
            Stage::Judge => &[Need { stage: Stage::Make, what: "the clips that make gives" }],
        }
    }

    /// What must run below it.
    pub fn needs_below(self) -> Option<Need> {
        let judge = Need { stage: Stage::Judge, what: "the judge's word: no made clip counts without it" };
        (self == Stage::Make).then_some(judge)
    }

    /// Whether it may work on some clips only (`where`).
    pub fn may_choose_clips(self) -> bool {
        matches!(self, Stage::Ingest | Stage::Tree | Stage::Neighbors | Stage::Recipes)
    }
}
