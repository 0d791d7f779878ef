//! What the numbers and names of a config may be, beyond their types.

use super::config::Config;
use super::document::{Node, Value};
use super::error::PlanError;
use super::mistakes::out_of_range;
use serde_json::Value as Json;

/// Bounds of one number; `[]` in the path stands for every element of a list.
pub(crate) struct Range {
    pub(crate) path: &'static str,
    low: Bound,
    high: f64,
    /// Why not beyond.
    reason: &'static str,
}

enum Bound {
    From(f64),
    Above(f64),
}

const fn from(path: &'static str, low: f64, high: f64, reason: &'static str) -> Range {
    Range { path, low: Bound::From(low), high, reason }
}

const fn above(path: &'static str, low: f64, high: f64, reason: &'static str) -> Range {
    Range { path, low: Bound::Above(low), high, reason }
}

const RATE: &str = "no capture has another rate";
const UNIT: &str = "no file is in another unit; a millimetre is 0.001, a mile 1609";
const SHARE: &str = "it is a share";
const WEIGHT: &str = "distances must stay positive and finite";
const SEAM: &str = "a blend is shorter than a clip";
const FACTOR: &str = "it multiplies the parents' figure";
const EXCESS: &str = "it is added to the parents' figure";

/// Every number of a config. A test holds it against the config's fields.
pub(crate) const RANGES: &[Range] = &[
    above("inputs.rate_hz", 0.0, 100_000.0, RATE),
    above("inputs.unit_m", 0.0, 2000.0, UNIT),
    above("source[].rate_hz", 0.0, 100_000.0, RATE),
    above("source[].unit_m", 0.0, 2000.0, UNIT),
    above("clip[].rate_hz", 0.0, 100_000.0, RATE),
    above("clip[].unit_m", 0.0, 2000.0, UNIT),
    from("limits.max_clip_bytes", 1.0, 1e15, "a limit of 0 refuses every clip"),
    from("limits.max_joints", 1.0, 1e6, "a limit of 0 refuses every clip, and tables have no more columns"),
    from("limits.max_depth", 1.0, 1e6, "a limit of 0 refuses every clip"),
    from("limits.max_name_bytes", 1.0, 1e6, "a limit of 0 refuses every clip"),
    from("limits.max_poses", 1.0, 1e12, "a limit of 0 refuses every clip"),
    from("shards.text_bytes", 1.0, 1e12, "a shard holds some text, and a worker holds two shards"),
    from("shards.min_count", 1.0, 1e6, "a corpus has a shard at least"),
    from("procedural.clips", 1.0, 1e6, "a corpus has clips"),
    from("procedural.seed", 0.0, u64::MAX as f64, "a seed is a whole number"),
    above("contacts.thesis.max_height_m", 0.0, 1.0, "at 0 no foot is ever planted, beyond 1 m all are"),
    above("contacts.thesis.max_speed_mps", 0.0, 20.0, "at 0 no foot is ever planted, beyond 20 m/s all are"),
    from("contacts.thesis.close_gap_s", 0.0, 1.0, "a gap of a second is a step"),
    above("contacts.extrema.max_height_m", 0.0, 1.0, "at 0 no foot is ever planted, beyond 1 m all are"),
    above("contacts.extrema.max_speed_mps", 0.0, 20.0, "at 0 no foot is ever planted, beyond 20 m/s all are"),
    above("cluster.rate_hz", 0.0, 100_000.0, RATE),
    above("cluster.t_max_m2", 0.0, 1e6, "no two frames would be merged"),
    from("cluster.velocity_scale_s", 0.0, 1e6, WEIGHT),
    from("cluster.acceleration_scale_s2", 0.0, 1e6, WEIGHT),
    above("cluster.max_acceleration_mps2", 0.0, 1e6, WEIGHT),
    from("cluster.weights.head", 0.0, 1e6, WEIGHT),
    from("cluster.weights.wrist_left", 0.0, 1e6, WEIGHT),
    from("cluster.weights.wrist_right", 0.0, 1e6, WEIGHT),
    from("cluster.weights.toe_left", 0.0, 1e6, WEIGHT),
    from("cluster.weights.toe_right", 0.0, 1e6, WEIGHT),
    from("neighbors.count", 1.0, 255.0, "ranks are one byte in the table"),
    above("neighbors.max_e_m2", 0.0, 1e6, "no partner would be near enough"),
    from("neighbors.min_gap_s", 0.0, 3600.0, "no clip is that long"),
    above("graph.thresholds_m2[]", 0.0, 1e6, "at 0 every frame is a node of its own"),
    from("recipes.select", 0.0, 1e9, "each becomes a clip"),
    from("recipes.seed", 0.0, u64::MAX as f64, "a seed is a whole number"),
    from("recipes.leg_groups", 1.0, 1e6, "every clip is in a group"),
    from("recipes.arm_groups", 1.0, 1e6, "every clip is in a group"),
    above("graft.correlation.ankle_cutoff_hz", 0.0, 1000.0, "a low-pass lets something through"),
    from("graft.correlation.min_pairs", 2.0, 1e6, "a map needs two knots"),
    above("graft.correlation.min_pair_share", 0.0, 1.0, SHARE),
    from("graft.correlation.velocity_weight_s", 0.0, 1e6, WEIGHT),
    above("graft.correlation.min_rate_factor", 0.0, 1.0, "a donor's own rate must be allowed"),
    from("graft.correlation.max_rate_factor", 1.0, 100.0, "a donor's own rate must be allowed"),
    from("graft.seam_s", 0.0, 10.0, SEAM),
    from("graft.moving_seam_s", 0.0, 10.0, SEAM),
    from("graft.moving_wrist_mps", 0.0, 100.0, "no wrist is faster"),
    above("action.wrist_cutoff_hz", 0.0, 1000.0, "a low-pass lets something through"),
    above("action.pose_s", 0.0, 10.0, "a pose is shorter than a clip"),
    from("action.min_excursion_m", 0.0, 3.0, "no arm is longer"),
    from("action.min_share_of_other", 0.0, 1.0, SHARE),
    from("action.window_share", 0.0, 1.0, SHARE),
    from("action.rest_speed_share", 0.0, 1.0, SHARE),
    from("action.fast_percentile", 0.0, 100.0, "it is a percentile"),
    above("judge.max_wrist_jerk_factor", 0.0, 1e6, FACTOR),
    above("judge.max_upper_angular_acceleration_factor", 0.0, 1e6, FACTOR),
    above("judge.max_leg_angular_acceleration_factor", 0.0, 1e6, FACTOR),
    from("judge.max_skate_excess_mps", 0.0, 1e6, EXCESS),
    from("judge.max_plant_drift_excess_m", 0.0, 1e6, EXCESS),
    from("judge.max_penetration_excess_m", 0.0, 1e6, EXCESS),
    from("judge.max_limit_excess_rad", 0.0, 1e6, EXCESS),
    from("judge.min_reference_s", 0.0, 1e6, "it is a time"),
    from("judge.max_self_collision_excess_m", 0.0, 1e6, EXCESS),
    from("judge.max_zmp_distance_excess_m", 0.0, 1e6, EXCESS),
    from("judge.max_arm_novelty", 0.0, 1e6, "it is a distance"),
    from("judge.arm_leg_relation_cycles", -1.0, 1.0, "it is a share of a cycle"),
    from("judge.max_arm_leg_relation_error_cycles", 0.0, 0.5, "half a cycle away is as far as it goes"),
    from("judge.min_arm_leg_lock", 0.0, 1.0, SHARE),
];

/// Bounds of the numbers in the `where` of a stage.
pub(crate) const WHERE_RANGES: &[Range] = &[
    from("min_gait_confidence", 0.0, 1.0, "it is a share"),
    from("min_duration_s", 0.0, 1e6, "no clip is longer"),
    from("max_duration_s", 0.0, 1e6, "no clip is longer"),
];

impl Range {
    fn holds(&self, number: f64) -> bool {
        let enough = match self.low {
            Bound::From(low) => number >= low,
            Bound::Above(low) => number > low,
        };
        enough && number <= self.high
    }

    fn why(&self) -> String {
        let low = match self.low {
            Bound::From(low) => format!("at least {low}"),
            Bound::Above(low) => format!("above {low}"),
        };
        match self.high {
            high if high >= 1e6 => format!("it must be {low}: {}", self.reason),
            high => format!("it must be {low} and at most {high}: {}", self.reason),
        }
    }
}

/// Paths and numbers, of the values read, that are out of their range, with the reason.
pub(crate) fn outside(ranges: &'static [Range], values: &Json) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for range in ranges {
        each(values, range.path, String::new(), &mut |path, value| {
            if value.as_f64().is_some_and(|number| !range.holds(number)) {
                found.push((path, range.why()));
            }
        });
    }
    found
}

/// All that is wrong with the values of a config, as far as it could be read: of lists that elements were left
/// out of (`shortened`, by path) nothing is said, since their elements have moved.
pub(crate) fn check(config: &Config, root: &Node, shortened: &[&str], reference: &Node) -> Vec<PlanError> {
    let values = serde_json::to_value(config).expect("plain fields always make JSON");
    let mut wrong = outside(RANGES, &values);
    not_finite(root, String::new(), &mut wrong);
    wrong.extend(wrong_names(config));
    wrong.extend(wrong_together(config));
    let has_moved =
        |path: &str| shortened.iter().any(|list| path.strip_prefix(list).is_some_and(|rest| rest.starts_with('[')));
    wrong
        .into_iter()
        .filter(|(path, _)| !has_moved(path))
        .filter_map(|(path, why)| {
            // A value that is a default by itself stands nowhere; its section does.
            let section = path.rsplit_once('.').map_or("", |(section, _)| section);
            let (path, node) = [path.as_str(), section].into_iter().find_map(|path| Some((path, root.find(path)?)))?;
            Some(out_of_range(node, path, why, reference))
        })
        .collect()
}

/// TOML knows `nan` and `inf`; no setting does.
fn not_finite(node: &Node, path: String, wrong: &mut Vec<(String, String)>) {
    match &node.value {
        Value::Float(number) if !number.is_finite() => {
            wrong.push((path, "it must be a finite number".to_owned()));
        }
        Value::List(nodes) => {
            for (index, node) in nodes.iter().enumerate() {
                not_finite(node, format!("{path}[{index}]"), wrong);
            }
        }
        Value::Table(entries) => {
            for entry in entries {
                let dot = if path.is_empty() { "" } else { "." };
                not_finite(&entry.node, format!("{path}{dot}{}", entry.key), wrong);
            }
        }
        _ => {}
    }
}

fn wrong_names(config: &Config) -> Vec<(String, String)> {
    let mut wrong = Vec::new();
    let mut say = |path: String, why: &str| wrong.push((path, why.to_owned()));
    for (index, rule) in config.source.iter().enumerate() {
        if rule.label.as_deref().is_some_and(|label| label.is_empty() || label.contains(['/', '#'])) {
            say(format!("source[{index}].label"), "a label stands before `/` in clip names, and `#2` marks repeats");
        }
        if config.source[..index].iter().any(|earlier| earlier.folder == rule.folder || earlier.folder == "*") {
            let path = format!("source[{index}].folder");
            let why = "an earlier [[source]] takes every such folder, so this one never counts";
            say(path, why);
        }
    }
    for (index, rule) in config.clip.iter().enumerate() {
        if rule.name.is_empty() {
            say(format!("clip[{index}].name"), "no clip has an empty name; `*` stands for anything");
        }
    }
    wrong
}

fn wrong_together(config: &Config) -> Vec<(String, String)> {
    let mut wrong = Vec::new();
    let thresholds = &config.graph.thresholds_m2;
    if thresholds.is_empty() {
        wrong.push(("graph.thresholds_m2".to_owned(), "without a threshold there is no graph".to_owned()));
    }
    for (index, threshold) in thresholds.iter().enumerate() {
        let path = format!("graph.thresholds_m2[{index}]");
        let most = config.cluster.t_max_m2;
        if most > 0.0 && *threshold > most {
            wrong.push((path, format!("the tree stops at `t_max_m2` = {most} in [cluster], so it can't be cut above")));
        } else if thresholds[..index].contains(threshold) {
            wrong.push((path, "one graph for each threshold, so each stands once".to_owned()));
        }
    }
    wrong
}

/// Calls back with the path and value of every match.
fn each(values: &Json, pattern: &str, path: String, call: &mut impl FnMut(String, &Json)) {
    if pattern.is_empty() {
        return call(path, values);
    }
    if let Some(rest) = pattern.strip_prefix("[]") {
        for (index, element) in values.as_array().into_iter().flatten().enumerate() {
            each(element, rest, format!("{path}[{index}]"), call);
        }
        return;
    }
    let pattern = pattern.strip_prefix('.').unwrap_or(pattern);
    let end = pattern.find(['.', '[']).unwrap_or(pattern.len());
    let (key, rest) = pattern.split_at(end);
    if let Some(value) = values.get(key) {
        let dot = if path.is_empty() { "" } else { "." };
        each(value, rest, format!("{path}{dot}{key}"), call);
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::document::parse;
    use super::super::shipped::reference;
    use super::*;

    /// Paths of all numbers of a tree, with `[]` for indices.
    fn numbers(node: &Node, path: &str, found: &mut Vec<String>) {
        match &node.value {
            Value::Integer(_) | Value::Float(_) => found.push(path.to_owned()),
            Value::List(nodes) => nodes.iter().for_each(|node| numbers(node, &format!("{path}[]"), found)),
            _ => {
                for entry in node.entries() {
                    let dot = if path.is_empty() { "" } else { "." };
                    numbers(&entry.node, &format!("{path}{dot}{}", entry.key), found);
                }
            }
        }
    }

    #[test]
    fn every_number_has_a_range_and_every_range_a_number() {
        let (mut all, mut ranged) = (Vec::new(), Vec::new());
        numbers(&parse(&reference()).unwrap(), "", &mut all);
        ranged.extend(RANGES.iter().map(|range| range.path.to_owned()));
        all.sort();
        ranged.sort();
        assert_eq!(all, ranged);
    }

    #[test]
    fn bounds_are_open_below_where_they_say_above() {
        assert!(!above("x", 0.0, 1.0, "").holds(0.0) && above("x", 0.0, 1.0, "").holds(1.0));
        assert!(from("x", 0.0, 1.0, "").holds(0.0) && !from("x", 0.0, 1.0, "").holds(1.1));
        assert!(!from("x", 0.0, 1.0, "").holds(f64::NAN));
    }
}
