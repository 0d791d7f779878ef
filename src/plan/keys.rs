//! Keys of stages: what decides whether work that was done still counts (DESIGN 4).
//!
//! A key is a digest of the settings that a stage reads, the version of its algorithm, and the keys of the stages
//! that it builds on. What the inputs add is in the clips' own keys ([`InputHash::key`](crate::inputs::InputHash::key)
//! covers bytes, skeleton, and what the config says of that clip), so that a rule for one source leaves the others'
//! clips alone; [`shard_key`] joins both.

use super::config::Config;
use super::filter::ClipFilter;
use super::stages::Stage;
use crate::annotate::Detector;
use serde::Serialize;
use serde_json::{Value, json};

/// The key of each stage. `contacts` and `gait` make the labels together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "the names say it")]
pub struct PlanKeys {
    pub ingest: String,
    pub features: String,
    pub labels: String,
    pub tree: String,
    pub neighbors: String,
    pub graph: String,
    pub recipes: String,
    pub make: String,
    pub judge: String,
}

/// Versions of the algorithms: raised when a stage gives other output for the same input and settings.
mod version {
    pub(super) const INGEST: u32 = 1;
    pub(super) const FEATURES: u32 = 1;
    pub(super) const LABELS: u32 = 2;
    pub(super) const TREE: u32 = 1;
    pub(super) const NEIGHBORS: u32 = 1;
    pub(super) const GRAPH: u32 = 1;
    pub(super) const RECIPES: u32 = 2;
    pub(super) const MAKE: u32 = 1;
    pub(super) const JUDGE: u32 = 2;
}

impl PlanKeys {
    /// The keys under a config and filters. They don't depend on which stages a pipeline has, so that a longer
    /// pipeline finds what a shorter one has done.
    pub fn new(config: &Config, filter: impl Fn(Stage) -> ClipFilter) -> PlanKeys {
        let Config {
            ingest,
            limits,
            tables,
            poses,
            annotations,
            contacts,
            cluster,
            neighbors,
            graph,
            recipes,
            graft,
            action,
            judge,
            ..
        } = config;
        // What is read doesn't depend on which tables are written of it.
        let motion = key("motion", version::INGEST, &json!([limits]));
        let ingest =
            key("ingest", version::INGEST, &json!([motion, ingest.strict, poses, tables.channels, tables.poses]));
        let features = key("features", version::FEATURES, &json!([motion, tables.features]));
        // What another detector would be told doesn't count, and what builds on labels doesn't read diagnostics.
        let told = match contacts.detector {
            Detector::Adaptive => json!(contacts.detector),
            Detector::Thesis => json!([contacts.detector, contacts.thesis]),
            Detector::Extrema => json!([contacts.detector, contacts.extrema]),
        };
        let plants = key("labels", version::LABELS, &json!([motion, told]));
        let labels = key("labels", version::LABELS, &json!([plants, annotations]));
        let tree = key("tree", version::TREE, &json!([features, plants, cluster, filter(Stage::Tree)]));
        let partners = json!([features, plants, cluster, neighbors, filter(Stage::Neighbors)]);
        // Donors whose own arms a gate would refuse are not chosen.
        let beat = [judge.arm_leg_relation_cycles, judge.max_arm_leg_relation_error_cycles, judge.min_arm_leg_lock];
        let selection = json!([motion, plants, recipes, action, graft.correlation, beat, filter(Stage::Recipes)]);
        let recipes = key("recipes", version::RECIPES, &selection);
        let made = json!([recipes, features, graft, tables.provenance]);
        let make = key("make", version::MAKE, &made);
        PlanKeys {
            neighbors: key("neighbors", version::NEIGHBORS, &partners),
            graph: key("graph", version::GRAPH, &json!([tree, graph])),
            judge: key("judge", version::JUDGE, &json!([make, judge])),
            ingest,
            features,
            labels,
            tree,
            recipes,
            make,
        }
    }
}

/// The key of a stage that reads these values, 32 hexadecimal digits.
pub fn key(stage: &str, version: u32, values: &Value) -> String {
    digest(&json!([stage, version, values]))
}

/// The key of a per-clip stage for one shard: its own key and those of the shard's clips, in their order.
pub fn shard_key(stage_key: &str, clip_keys: &[String]) -> String {
    digest(&json!([stage_key, clip_keys]))
}

/// A digest of values, whatever the order in which their fields were declared.
pub(crate) fn digest(values: &Value) -> String {
    let mut text = String::new();
    write_canonical(values, &mut text);
    blake3::hash(text.as_bytes()).to_hex()[..32].to_owned()
}

/// JSON without blanks, fields by name. Numbers are printed by serde_json: the shortest that reads back equal.
fn write_canonical(values: &Value, text: &mut String) {
    match values {
        Value::Object(fields) => {
            let mut sorted: Vec<_> = fields.iter().collect();
            sorted.sort_by_key(|(name, _)| name.as_str());
            text.push('{');
            for (name, value) in sorted {
                text.push_str(&Value::from(name.as_str()).to_string());
                text.push(':');
                write_canonical(value, text);
                text.push(',');
            }
            text.push('}');
        }
        Value::Array(values) => {
            text.push('[');
            for value in values {
                write_canonical(value, text);
                text.push(',');
            }
            text.push(']');
        }
        plain => text.push_str(&plain.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_fields_does_not_matter_and_the_order_of_lists_does() {
        let parse = |text: &str| serde_json::from_str::<Value>(text).expect("valid JSON");
        assert_eq!(digest(&parse(r#"{"a":1,"b":[1,2]}"#)), digest(&parse(r#"{"b":[1,2],"a":1}"#)));
        assert_ne!(digest(&parse(r#"{"a":1,"b":[1,2]}"#)), digest(&parse(r#"{"a":1,"b":[2,1]}"#)));
        assert_ne!(digest(&parse(r#"["a","b"]"#)), digest(&parse(r#"["a,b"]"#)));
    }

    #[test]
    fn version_stage_and_values_all_count() {
        let base = key("tree", 1, &json!([0.5]));
        assert_eq!(base.len(), 32);
        assert_ne!(base, key("tree", 2, &json!([0.5])));
        assert_ne!(base, key("graph", 1, &json!([0.5])));
        assert_ne!(base, key("tree", 1, &json!([0.25])));
        let clips = ["a".to_owned(), "b".to_owned()];
        assert_ne!(shard_key(&base, &clips), shard_key(&base, &clips[..1]));
    }
}
