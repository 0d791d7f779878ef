//! Reads a pipeline: its stages in flow order, their options and filters, and whether that can flow at all.

use super::document::{Entry, Node, Place, Value, nest};
use super::error::PlanError;
use super::filter::ClipFilter;
use super::mistakes::{Root, explain};
use super::nearest::{list, nearest};
use super::ranges::{WHERE_RANGES, outside};
use super::reader::read;
use super::stages::{Need, Stage};
use serde::{Deserialize, Serialize};

/// A stage of a plan. Its options are in the plan's config, in the stage's section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedStage {
    /// Which.
    pub stage: Stage,
    /// The clips that it works on.
    pub filter: ClipFilter,
}

/// A pipeline as read.
pub(crate) struct Pipeline {
    pub(crate) description: String,
    pub(crate) stages: Vec<PlannedStage>,
    /// Where each stage stands, in the same order.
    pub(crate) places: Vec<Place>,
    /// The options as sections of a config.
    pub(crate) options: Node,
    pub(crate) errors: Vec<PlanError>,
    /// A stage could not be read, so none can be called missing.
    unread: bool,
}

/// Reads a pipeline's tree.
pub(crate) fn read_pipeline(root: &Node) -> Pipeline {
    let mut pipeline = Pipeline {
        description: String::new(),
        stages: Vec::new(),
        places: Vec::new(),
        options: Node::empty(&root.place.source),
        errors: Vec::new(),
        unread: false,
    };
    for entry in root.entries() {
        match (entry.key.as_str(), &entry.node.value) {
            ("description", Value::Text(text)) => pipeline.description.clone_from(text),
            ("description", _) => pipeline.wrong(
                &entry.node.place,
                format!("`description` is {}", entry.node.kind()),
                "it is shown as text",
                "description = \"what this pipeline makes\"".to_owned(),
            ),
            ("stage", Value::List(nodes)) => nodes.iter().for_each(|node| pipeline.stage(node)),
            ("stage", _) => pipeline.wrong(
                &entry.node.place,
                format!("`stage` is {}", entry.node.kind()),
                "a pipeline is a list of stages, and in TOML a list of tables has double brackets",
                "[[stage]]".to_owned(),
            ),
            _ => pipeline.unknown(entry),
        }
    }
    if pipeline.stages.is_empty() && pipeline.errors.is_empty() {
        pipeline.wrong(
            &root.place,
            "a pipeline without stages".to_owned(),
            "there is nothing to do",
            "[[stage]] use = \"ingest\"".to_owned(),
        );
    }
    pipeline.check_flow();
    pipeline
}

impl Pipeline {
    fn wrong(&mut self, place: &Place, what: String, why: &str, try_: String) {
        self.errors.push(place.error(what, why.to_owned(), try_));
    }

    fn unknown(&mut self, entry: &Entry) {
        let near = nearest(&entry.key, &["stage", "description"]);
        let try_ = match near {
            Some("stage") => "[[stage]]".to_owned(),
            Some(near) => format!("{near} = {}", entry.node.place.raw()),
            None => "put options below the stage that they are for, settings into a config".to_owned(),
        };
        let what = format!("unknown field `{}` in a pipeline", entry.key);
        self.wrong(&entry.key_place, what, "a pipeline has a `description` and a list of [[stage]]", try_);
    }

    fn stage(&mut self, node: &Node) {
        let Value::Table(entries) = &node.value else {
            self.unread = true;
            let what = format!("a stage is {}: {node}", node.kind());
            return self.wrong(&node.place, what, "a stage is a table", "[[stage]] use = \"ingest\"".to_owned());
        };
        let Some(stage) = self.used(node) else {
            self.unread = true;
            return;
        };
        if self.stages.iter().any(|other| other.stage == stage) {
            let name = stage.name();
            return self.wrong(
                &node.place,
                format!("`{name}` stands twice"),
                "each stage writes its own tables, once",
                format!("take one [[stage]] use = \"{name}\" out"),
            );
        }
        let filter = self.filter(stage, entries);
        self.options(stage, entries);
        self.stages.push(PlannedStage { stage, filter });
        self.places.push(node.place.clone());
    }

    /// The stage that `use` names.
    fn used(&mut self, node: &Node) -> Option<Stage> {
        let try_ = "use = \"ingest\"".to_owned();
        match node.get("use") {
            Some(Node { value: Value::Text(name), place }) => {
                let stage = Stage::from_name(name);
                if stage.is_none() {
                    self.unknown_stage(place, name);
                }
                stage
            }
            Some(other) => {
                let what = format!("`use` is {}: {other}", other.kind());
                self.wrong(&other.place, what, "a stage is called by its name", try_);
                None
            }
            None => {
                let why = format!("`use` says which stage it is: {}", list(&Stage::NAMES));
                self.wrong(&node.place, "a stage without `use`".to_owned(), &why, try_);
                None
            }
        }
    }

    fn unknown_stage(&mut self, place: &Place, name: &str) {
        let (why, try_) = match nearest(name, &Stage::NAMES) {
            Some(near) => (format!("no such stage; the nearest is `{near}`"), format!("use = \"{near}\"")),
            None => {
                (format!("there are {}", list(&Stage::NAMES).replace(" or ", " and ")), "use = \"ingest\"".to_owned())
            }
        };
        self.wrong(place, format!("unknown stage `{name}`"), &why, try_);
    }

    fn filter(&mut self, stage: Stage, entries: &[Entry]) -> ClipFilter {
        let Some(entry) = entries.iter().find(|entry| entry.key == "where") else { return ClipFilter::default() };
        let name = stage.name();
        if !stage.may_choose_clips() {
            let choosers: Vec<&str> =
                Stage::ALL.into_iter().filter(|stage| stage.may_choose_clips()).map(Stage::name).collect();
            self.wrong(
                &entry.key_place,
                format!("`where` on stage `{name}`"),
                &format!("{name} works on all that the stages above it give"),
                format!("put it on {}", list(&choosers)),
            );
            return ClipFilter::default();
        }
        if !matches!(entry.node.value, Value::Table(_)) {
            let what = format!("`where` of stage `{name}` is {}: {}", entry.node.kind(), entry.node);
            let try_ = "where = { gait = \"walk\" }".to_owned();
            self.wrong(&entry.node.place, what, "it is a table of conditions", try_);
            return ClipFilter::default();
        }
        let (filter, mistakes) = read::<ClipFilter>(&entry.node);
        self.errors.extend(mistakes.iter().map(|mistake| explain(mistake, &Root::Where { stage })));
        let values = serde_json::to_value(&filter).expect("plain fields always make JSON");
        for (field, why) in outside(WHERE_RANGES, &values) {
            if let Some(node) = entry.node.find(&field) {
                let what = format!("`{field}` in `where` of stage `{name}` is {node}");
                self.wrong(&node.place, what, &why, "mend the number, or take the condition out".to_owned());
            }
        }
        let early = |entry: &&Entry| !ClipFilter::KNOWN_BEFORE_READING.contains(&entry.key.as_str());
        if stage == Stage::Ingest && mistakes.is_empty() {
            for condition in entry.node.entries().iter().filter(early) {
                self.wrong(
                    &condition.key_place,
                    format!("`{}` in `where` of stage `ingest`", condition.key),
                    "it is not known before the clips have been read",
                    "put it on `tree`, `neighbors` or `recipes`".to_owned(),
                );
            }
        }
        filter
    }

    fn options(&mut self, stage: Stage, entries: &[Entry]) {
        for entry in entries.iter().filter(|entry| !matches!(entry.key.as_str(), "use" | "where")) {
            match stage.section() {
                Some(section) => {
                    let table = Value::Table(vec![entry.clone()]);
                    self.options.overlay(nest(&[section], Node { value: table, place: entry.key_place.clone() }));
                }
                None => {
                    let name = stage.name();
                    let (why, try_) = match nearest(&entry.key, &["use", "where"]) {
                        Some(near) => (
                            format!("{name} has no options; the nearest word is `{near}`"),
                            format!("{near} = {}", entry.node.place.raw()),
                        ),
                        None => (format!("{name} has no options"), "take it out".to_owned()),
                    };
                    self.wrong(
                        &entry.key_place,
                        format!("unknown option `{}` of stage `{name}`", entry.key),
                        &why,
                        try_,
                    );
                }
            }
        }
    }

    fn check_flow(&mut self) {
        for index in 0..self.stages.len() {
            let stage = self.stages[index].stage;
            for need in stage.needs() {
                self.check_need(index, stage, need);
            }
            if let Some(need) = stage.needs_below()
                && self.position(need.stage).is_none()
                && !self.unread
            {
                let (name, below) = (stage.name(), need.stage.name());
                self.wrong(
                    &self.places[index].clone(),
                    format!("`{name}` without `{below}`"),
                    &format!("{name} needs {}", need.what),
                    format!("add [[stage]] use = \"{below}\" below it"),
                );
            }
        }
    }

    fn check_need(&mut self, index: usize, stage: Stage, need: &Need) {
        let (name, above) = (stage.name(), need.stage.name());
        let why = format!("{name} needs {}", need.what);
        let place = self.places[index].clone();
        match self.position(need.stage) {
            Some(other) if other < index => {}
            Some(_) => self.wrong(
                &place,
                format!("`{name}` comes before `{above}`"),
                &why,
                format!("move [[stage]] use = \"{name}\" below use = \"{above}\""),
            ),
            None if self.unread => {}
            None => self.wrong(
                &place,
                format!("`{name}` without `{above}`"),
                &why,
                format!("add [[stage]] use = \"{above}\" above it"),
            ),
        }
    }

    fn position(&self, stage: Stage) -> Option<usize> {
        self.stages.iter().position(|planned| planned.stage == stage)
    }
}
