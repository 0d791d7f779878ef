//! What the stages of a run are told: the plan's settings, resolved once, shared by all workers.

use super::work::Todo;
use crate::annotate::contacts::adaptive;
use crate::annotate::{self, Detector};
use crate::cluster::{AlignmentRule, Metric};
use crate::corpus::{ShardSettings, Table};
use crate::formats::ReadOptions;
use crate::motion::role_names::NameTables;
use crate::plan::config::TableSettings;
use crate::plan::{Plan, PoseRotations, Stage};
use crate::synthesis::judge::GateSettings;
use crate::synthesis::selection::SelectionSettings;
use crate::synthesis::{ActionSettings, GraftSettings};
use std::collections::BTreeMap;

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct RunSettings {
    /// How files are read.
    pub read: ReadOptions,
    /// Names of joints.
    pub names: NameTables,
    /// Whether the plan has the stage `features`.
    pub features: bool,
    /// Whether the plan has the stages `contacts` and `gait`.
    pub labels: bool,
    /// Contacts and gait.
    pub annotate: annotate::Settings,
    /// Tables that are not to be written.
    pub left_out: Vec<Table>,
    /// Whether `poses` has rotations.
    pub rotations: bool,
    /// How frames are compared.
    pub cluster: crate::cluster::Settings,
    /// Samples a second.
    pub cluster_rate_hz: f64,
    /// Where the tree is cut, m^2.
    pub thresholds_m2: Vec<f64>,
    /// How alignment frames are chosen.
    pub alignment: AlignmentRule,
    /// Which recipes.
    pub selection: SelectionSettings,
    /// What an action is.
    pub action: ActionSettings,
    /// How grafts are made.
    pub graft: GraftSettings,
    /// What is accepted.
    pub gates: GateSettings,
}

impl RunSettings {
    /// The settings of a plan.
    pub fn of(plan: &Plan) -> RunSettings {
        let config = &plan.config;
        let TableSettings { channels, poses, features, provenance } = config.tables;
        let wanted = [
            (Table::Channels, channels),
            (Table::Poses, poses),
            (Table::Features, features),
            (Table::Provenance, provenance),
        ];
        RunSettings {
            read: ReadOptions { strict: config.ingest.strict, limits: config.limits.clone(), ..ReadOptions::default() },
            names: shipped_names(),
            features: plan.has(Stage::Features),
            labels: plan.has(Stage::Contacts),
            annotate: annotate::Settings {
                contacts: config.contacts.clone(),
                diagnostics: config.annotations.diagnostics,
            },
            left_out: wanted.into_iter().filter(|(_, wanted)| !wanted).map(|(table, _)| table).collect(),
            rotations: config.poses.rotations == PoseRotations::Quaternion,
            cluster: crate::cluster::Settings {
                t_max_m2: config.cluster.t_max_m2,
                velocity_scale_s: config.cluster.velocity_scale_s,
                acceleration_scale_s2: config.cluster.acceleration_scale_s2,
                max_acceleration_mps2: config.cluster.max_acceleration_mps2,
                weights: config.cluster.weights.clone(),
            },
            cluster_rate_hz: config.cluster.rate_hz,
            thresholds_m2: config.graph.thresholds_m2.clone(),
            alignment: AlignmentRule::default(),
            selection: config.recipes.clone(),
            action: config.action.clone(),
            graft: config.graft.clone(),
            gates: config.judge.clone(),
        }
    }

    /// What a shard's writer has to write.
    pub(crate) fn shard_settings(&self, todo: Todo, is_made: bool) -> ShardSettings {
        let wanted = |table: &Table| match (todo, table) {
            (Todo::Samples { .. }, _) => false,
            (_, Table::Features) => self.features && !matches!(todo, Todo::Again { features: false, .. }),
            (_, Table::Annotations | Table::Plants | Table::Segments) => {
                self.labels && !matches!(todo, Todo::Again { labels: false, .. })
            }
            (Todo::Everything, Table::Provenance) => is_made,
            (Todo::Everything, _) => true,
            _ => false,
        };
        let tables = Table::ALL.into_iter().filter(wanted).filter(|table| !self.left_out.contains(table)).collect();
        ShardSettings { tables, notes: self.notes(), rotations: self.rotations, ..ShardSettings::default() }
    }

    /// File metadata: detectors and constants, weights.
    fn notes(&self) -> BTreeMap<Table, crate::corpus::FileNotes> {
        let mut notes = BTreeMap::new();
        let labels = crate::corpus::FileNotes::from([
            ("detector".to_owned(), json(&self.annotate.contacts.detector)),
            ("contacts".to_owned(), json(&detector_constants(&self.annotate.contacts))),
        ]);
        for table in [Table::Annotations, Table::Plants, Table::Segments] {
            notes.insert(table, labels.clone());
        }
        if let Ok(metric) = Metric::new(&self.cluster) {
            let weights = [("metric".to_owned(), metric.digest()), ("cluster".to_owned(), json(&self.cluster))];
            notes.insert(Table::Features, crate::corpus::FileNotes::from(weights));
        }
        notes
    }
}

/// Constants of the detector that is in force.
fn detector_constants(contacts: &annotate::ContactSettings) -> serde_json::Value {
    match contacts.detector {
        Detector::Adaptive => {
            let named = |&(name, value): &(&str, f64)| (name.to_owned(), serde_json::Value::from(value));
            serde_json::Value::Object(adaptive::CONSTANTS.iter().map(named).collect())
        }
        Detector::Thesis => serde_json::json!(contacts.thesis),
        Detector::Extrema => serde_json::json!(contacts.extrema),
    }
}

fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

macro_rules! name_tables {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../configs/skeletons/", $name, ".toml")))),*]
    };
}

/// The name tables that ship with the program.
pub fn shipped_names() -> NameTables {
    const TEXTS: &[(&str, &str)] = name_tables!(
        "100style" "bandai-namco" "biped" "blender" "cgspeed" "cgspeed-3dsmax" "cmu-asf" "daz" "lafan1" "mixamo"
        "motionbuilder" "smpl" "unreal"
    );
    NameTables::from_toml(TEXTS).expect("the shipped name tables are sound")
}
