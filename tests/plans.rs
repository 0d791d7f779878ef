//! Plans: what ships loads, later words count over earlier ones, and keys tell finished work from work to do.

use crate::plan_mistakes::{messages, stages};
use motionmill::inputs::{ClipRule, SourceRule};
use motionmill::plan::shipped::{CONFIGS, PIPELINES};
use motionmill::plan::{Config, Plan, PlanKeys, Stage, WithoutInput};
use serde_json::Value;

#[test]
fn every_shipped_pipeline_loads_under_every_shipped_config() {
    for pipeline in PIPELINES {
        for config in CONFIGS {
            let plan = Plan::load(pipeline.name, Some(config.name), &[]).unwrap();
            assert_eq!(plan.pipeline, pipeline.name);
            assert!(!plan.description.is_empty());
        }
    }
    let names = |pipeline: &str| {
        let plan = Plan::load(pipeline, None, &[]).unwrap();
        plan.stages.iter().map(|planned| planned.stage.name()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names("annotate"), "ingest features contacts gait");
    assert_eq!(names("graph"), "ingest features contacts gait tree graph");
    assert_eq!(names("enrich"), "ingest features contacts gait tree graph recipes make judge");
    assert_eq!(names("demo"), names("enrich"));
    assert_eq!(Plan::load("demo", None, &[]).unwrap().config.ingest.without_input, WithoutInput::Procedural);
    assert_eq!(Plan::load("enrich", None, &[]).unwrap().config.ingest.without_input, WithoutInput::Nothing);
}

#[test]
fn what_ships_says_what_is_known_of_the_sources() {
    let cmu = Config::load(Some("cmu"), &[]).unwrap();
    let rule = &cmu.source[0];
    assert_eq!((rule.rate_hz, rule.unit_m), (Some(120.0), Some(0.0254 / 0.45)));
    assert_eq!((rule.may_share, rule.may_sell, rule.no_derivatives), (Some(true), Some(false), false));
    assert!(rule.attribution.as_deref().unwrap().contains("mocap.cs.cmu.edu"));
    let bandai = Config::load(Some("bandai-namco"), &[]).unwrap();
    let rule = &bandai.source[0];
    assert_eq!((rule.unit_m, rule.may_sell), (Some(0.01), Some(false)));
    assert_eq!(rule.license.as_deref(), Some("CC BY-NC 4.0"));
}

#[test]
fn the_default_config_is_the_default() {
    assert_eq!(Config::load(Some("default"), &[]).unwrap(), Config::default());
    assert_eq!(Config::load(None, &[]).unwrap(), Config::default());
}

/// `default.toml` with the settings switched on that are off by default.
fn switched_on() -> String {
    let on = |line: &'static str| match line.strip_prefix('#') {
        Some(rest) if !rest.starts_with(' ') && !rest.is_empty() => rest,
        _ => line,
    };
    CONFIGS[0].text.lines().map(on).collect::<Vec<_>>().join("\n")
}

fn fields(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(object) => object.iter().for_each(|(key, value)| fields(value, &format!("{path}.{key}"), found)),
        Value::Array(list) if list.iter().all(Value::is_object) && !list.is_empty() => {
            fields(&list[0], &format!("{path}[]"), found);
        }
        _ => found.push(path.to_owned()),
    }
}

#[test]
fn the_default_config_shows_every_field() {
    let text = switched_on();
    assert_eq!(messages(None, Some(&text), &[]), "no mistake\n", "the settings that are off are valid too");
    let shown = serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    // One of each list, so that the fields of its elements are asked for as well.
    let config = Config { source: vec![SourceRule::default()], clip: vec![ClipRule::default()], ..Config::default() };
    let (mut all, mut written) = (Vec::new(), Vec::new());
    fields(&serde_json::to_value(config).unwrap(), "", &mut all);
    fields(&shown, "", &mut written);
    all.sort();
    written.sort();
    assert_eq!(all, written);
    assert!(all.len() > 70);
}

#[test]
fn every_line_of_the_default_config_that_sets_something_says_what() {
    for line in switched_on().lines().filter(|line| line.contains(" = ") && !line.starts_with("# ")) {
        let (name, _) = line.split_once(" = ").unwrap();
        let plain = ["head", "wrist_", "toe_right"].iter().any(|plain| name.starts_with(plain));
        let gate = name.starts_with("max_") && (name.ends_with("_factor") || name.contains("_excess_"));
        assert!(line.contains('#') || plain || gate, "{line}");
    }
}

#[test]
fn every_order_that_can_flow_loads_and_no_other() {
    // Against the plain definition: all that a stage needs stands above it.
    for mask in 0u32..1 << Stage::ALL.len() {
        let chosen: Vec<Stage> = Stage::ALL.into_iter().filter(|&stage| mask >> stage as u32 & 1 == 1).collect();
        if chosen.len() > 4 && mask % 7 != 0 {
            continue;
        }
        let has = |stage: Stage| chosen.contains(&stage);
        let complete = chosen.iter().all(|stage| stage.needs().iter().all(|need| has(need.stage)));
        let flows = !chosen.is_empty() && complete && (!has(Stage::Make) || has(Stage::Judge));
        let names: Vec<&str> = chosen.iter().map(|stage| stage.name()).collect();
        let said = messages(Some(&stages(&names.join(" "))), None, &[]);
        assert_eq!(said == "no mistake\n", flows, "{names:?}: {said}");
    }
}

#[test]
fn one_value_is_set_from_the_command_line() {
    let set = |set: &str| Config::load(None, &[set.to_owned()]).unwrap();
    assert_eq!(set("contacts.thesis.max_height_m=0.04").contacts.thesis.max_height_m, 0.04);
    assert_eq!(set("graph.thresholds_m2 = [0.1, 0.2]").graph.thresholds_m2, [0.1, 0.2]);
    assert_eq!(set("poses.rotations=quaternion"), set("poses.rotations=\"quaternion\""));
    assert_eq!(set("inputs.rate_hz=120").inputs.rate_hz, Some(120.0));
}

#[test]
fn the_later_word_counts() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name).to_string_lossy().into_owned()
    };
    let pipeline = put("p.toml", &format!("{}select = 7\n", stages("ingest contacts gait recipes")));
    let config = put("c.toml", "[recipes]\nselect = 5\nseed = 9\n");
    let recipes = |config: Option<&str>, sets: &[String]| Plan::load(&pipeline, config, sets).unwrap().config.recipes;
    assert_eq!(recipes(None, &[]).select, 7);
    assert_eq!((recipes(Some(&config), &[]).select, recipes(Some(&config), &[]).seed), (7, 9));
    assert_eq!(recipes(Some(&config), &["recipes.select=3".to_owned(), "recipes.select=4".to_owned()]).select, 4);
}

/// Names of the stages whose keys differ.
fn changed(set: &str) -> Vec<String> {
    let keys = |sets: &[String]| serde_json::to_value(Plan::load("enrich", None, sets).unwrap().keys()).unwrap();
    let (before, after) = (keys(&[]), keys(&[set.to_owned()]));
    let names = before.as_object().unwrap().keys();
    names.filter(|&name| before[name] != after[name]).cloned().collect()
}

#[test]
fn a_changed_setting_changes_the_keys_of_what_reads_it_and_of_what_builds_on_that() {
    assert_eq!(
        changed("contacts.detector=thesis"),
        ["graph", "judge", "labels", "make", "neighbors", "recipes", "tree"]
    );
    assert_eq!(changed("contacts.thesis.max_height_m=0.04"), [""; 0], "the adaptive detector is not told");
    assert_eq!(changed("annotations.diagnostics=true"), ["labels"]);
    assert_eq!(changed("graph.thresholds_m2=[0.4]"), ["graph"]);
    assert_eq!(changed("cluster.t_max_m2=0.6"), ["graph", "neighbors", "tree"]);
    assert_eq!(changed("judge.max_arm_novelty=0.4"), ["judge"]);
    assert_eq!(changed("graft.seam_s=0.6"), ["judge", "make"]);
    assert_eq!(changed("recipes.select=10"), ["judge", "make", "recipes"]);
    assert_eq!(changed("neighbors.count=5"), ["neighbors"]);
    assert_eq!(changed("tables.poses=false"), ["ingest"]);
    assert_eq!(changed("poses.rotations=quaternion"), ["ingest"]);
    assert_eq!(changed("limits.max_joints=100").len(), 9);
    // How the work is cut and what the default spells out change nothing.
    assert_eq!(changed("shards.text_bytes=1000"), [""; 0]);
    assert_eq!(changed("graft.seam_s=0.5"), [""; 0]);
    assert_eq!(changed("inputs.rate_hz=60"), [""; 0], "it is in the keys of the clips");
}

#[test]
fn keys_do_not_depend_on_the_length_of_the_pipeline_and_filters_count() {
    let keys = |pipeline: &str| Plan::load(pipeline, None, &[]).unwrap().keys();
    assert_eq!(keys("annotate"), keys("enrich"));
    let plain = keys("graph");
    let walks = PlanKeys::new(&Config::default(), |stage| match stage {
        Stage::Tree => motionmill::plan::ClipFilter { name: vec!["walk*".to_owned()], ..Default::default() },
        _ => Default::default(),
    });
    assert_eq!(plain.labels, walks.labels);
    assert_ne!(plain.tree, walks.tree);
    assert_ne!(plain.graph, walks.graph);
}

#[test]
fn the_digest_covers_stages_and_settings() {
    let digest = |pipeline: &str, sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        Plan::load(pipeline, None, &sets).unwrap().digest()
    };
    assert_eq!(digest("enrich", &[]), digest("enrich", &["graft.seam_s=0.5"]));
    assert_ne!(digest("enrich", &[]), digest("graph", &[]));
    assert_ne!(digest("enrich", &[]), digest("enrich", &["shards.text_bytes=1000"]));
    assert_ne!(digest("enrich", &[]), digest("enrich", &["inputs.rate_hz=60"]));
}
