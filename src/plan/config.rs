//! All settings of a run, by section. `configs/default.toml` is their reference for users.

use super::sections::{AnnotationSettings, ClusterSettings, GraphSettings, NeighborSettings};
use crate::annotate::ContactSettings;
use crate::formats::ReadLimits;
use crate::inputs::{ClipRule, InputRules, InputSettings, SourceRule};
use crate::synthesis::judge::GateSettings;
use crate::synthesis::selection::SelectionSettings;
use crate::synthesis::{ActionSettings, GraftSettings};
use serde::{Deserialize, Serialize};

/// All settings, each with a default. One field a section of the TOML file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What is read when no input is named.
    pub ingest: IngestSettings,
    /// What holds for every input folder.
    pub inputs: InputSettings,
    /// Rules by input folder: license, unit, rate ...
    pub source: Vec<SourceRule>,
    /// Rules by clip, over those of its folder.
    pub clip: Vec<ClipRule>,
    /// Sizes beyond which a file is refused.
    pub limits: ReadLimits,
    /// How work is cut.
    pub shards: ShardSettings,
    /// What is written.
    pub tables: TableSettings,
    /// The `poses` table.
    pub poses: PoseSettings,
    /// The corpus that the program makes itself.
    pub procedural: ProceduralSettings,
    /// The `annotations` table.
    pub annotations: AnnotationSettings,
    /// Foot contacts.
    pub contacts: ContactSettings,
    /// How frames are compared and merged.
    pub cluster: ClusterSettings,
    /// The `neighbors` table.
    pub neighbors: NeighborSettings,
    /// Where the tree is cut.
    pub graph: GraphSettings,
    /// Which recipes are made, and how many.
    pub recipes: SelectionSettings,
    /// How donors are placed and blended.
    pub graft: GraftSettings,
    /// What counts as an action of an arm.
    pub action: ActionSettings,
    /// Limits of the gates.
    pub judge: GateSettings,
}

/// What `ingest` reads where no `--input` is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WithoutInput {
    /// Nothing: the run ends with a message.
    #[default]
    Nothing,
    /// A corpus of people made by the program.
    Procedural,
}

/// What is read when no input is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IngestSettings {
    /// Nothing, or the procedural corpus.
    pub without_input: WithoutInput,
    /// Warnings are faults: a clip that deviates is left out.
    pub strict: bool,
}

/// How work is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShardSettings {
    /// Text in a shard, bytes.
    pub text_bytes: u64,
    /// Smaller corpora are cut into so many shards, unless they would hold less than 1 MiB; count.
    pub min_count: u64,
}

/// Which of the large tables are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TableSettings {
    /// The file's own numbers; export and grafting need them.
    pub channels: bool,
    /// World positions of every joint.
    pub poses: bool,
    /// Features of every frame; the tree needs them.
    pub features: bool,
    /// Where each part of each made frame comes from.
    pub provenance: bool,
}

/// Rotations in the `poses` table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PoseRotations {
    /// None.
    #[default]
    None,
    /// Local unit quaternions, w last.
    Quaternion,
}

/// The `poses` table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseSettings {
    /// Whether and how rotations are written beside positions.
    pub rotations: PoseRotations,
}

/// The corpus that the program makes itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ProceduralSettings {
    /// How many clips, count.
    pub clips: u32,
    /// Seed of everything random in them.
    pub seed: u64,
}

impl Default for ShardSettings {
    /// 32 MiB: a corpus of CMU's size makes some 45. Each file costs its columns' compressors, so smaller ones are slower.
    fn default() -> Self {
        ShardSettings { text_bytes: 32 << 20, min_count: 16 }
    }
}

impl Default for TableSettings {
    fn default() -> Self {
        TableSettings { channels: true, poses: true, features: true, provenance: true }
    }
}

impl Default for ProceduralSettings {
    fn default() -> Self {
        ProceduralSettings { clips: 48, seed: 1 }
    }
}

impl Config {
    /// The rules about inputs.
    pub fn input_rules(&self) -> InputRules {
        InputRules { inputs: self.inputs.clone(), sources: self.source.clone(), clips: self.clip.clone() }
    }
}
