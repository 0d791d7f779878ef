//! Puts pipeline, config and `--set` together into a checked plan.

use super::config::Config;
use super::document::{Node, parse, parse_set};
use super::error::PlanError;
use super::filter::ClipFilter;
use super::keys::{PlanKeys, digest};
use super::mistakes::{Root, explain};
use super::pipeline::{Pipeline, PlannedStage, read_pipeline};
use super::ranges::check;
use super::reader::read;
use super::shipped;
use super::stages::Stage;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::Path;

/// What will be done, and how: nothing in it is wrong as far as can be told before any work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the pipeline: a shipped one's, or the file's without extension.
    pub pipeline: String,
    /// What the pipeline says of itself.
    pub description: String,
    /// In flow order, each stage at most once.
    pub stages: Vec<PlannedStage>,
    /// Every setting; the stages' options are in their sections.
    pub config: Config,
}

impl Plan {
    /// Reads a pipeline (a shipped name or a file), a config (likewise; None: the defaults) and `--set` values.
    /// The later ones count: defaults, config, options in the pipeline, `--set`.
    ///
    /// # Errors
    /// Every mistake in them: those of the pipeline, then of the config, then of `--set`, each in the order of its text.
    pub fn load(pipeline: &str, config: Option<&str>, sets: &[String]) -> Result<Plan, Vec<PlanError>> {
        let mut errors = Vec::new();
        let source = shipped::pipeline(pipeline);
        let pipeline_file = source.as_ref().map_or_else(|error| error.file.clone(), |source| source.name.clone());
        let stages = match source.map_err(|error| vec![error]).and_then(|source| parse(&source)) {
            Ok(root) => Some(read_pipeline(&root)),
            Err(mistakes) => {
                errors.extend(mistakes);
                None
            }
        };
        errors.extend(stages.iter().flat_map(|pipeline| pipeline.errors.clone()));
        let options = stages.as_ref().map(|pipeline| pipeline.options.clone());
        let (config, settings_errors, root) = load_config(config, options, sets);
        errors.extend(settings_errors);
        errors.extend(stages.iter().flat_map(|pipeline| left_out(pipeline, &config, &root)));
        match stages {
            Some(Pipeline { description, stages, .. }) if errors.is_empty() => {
                let name =
                    Path::new(pipeline).file_stem().map_or_else(|| pipeline.into(), |stem| stem.to_string_lossy());
                Ok(Plan { pipeline: name.into_owned(), description, stages, config })
            }
            _ => {
                errors
                    .sort_by_key(|error| (error.file != pipeline_file, error.line.is_none(), error.line, error.column));
                Err(errors)
            }
        }
    }

    /// Whether the stage is part of the plan.
    pub fn has(&self, stage: Stage) -> bool {
        self.stages.iter().any(|planned| planned.stage == stage)
    }

    /// Which clips the stage works on; all where it says nothing.
    pub fn filter(&self, stage: Stage) -> ClipFilter {
        let planned = self.stages.iter().find(|planned| planned.stage == stage);
        planned.map_or_else(ClipFilter::default, |planned| planned.filter.clone())
    }

    /// The key of each stage.
    pub fn keys(&self) -> PlanKeys {
        PlanKeys::new(&self.config, |stage| self.filter(stage))
    }

    /// What two processes must agree on before they work together: stages, filters, settings, program.
    pub fn digest(&self) -> String {
        digest(&json!([env!("CARGO_PKG_VERSION"), self.stages, self.config, self.keys()]))
    }
}

impl Config {
    /// Reads a config (a shipped name or a file; None: the defaults) and `--set` values without a pipeline.
    ///
    /// # Errors
    /// Every mistake in them.
    pub fn load(config: Option<&str>, sets: &[String]) -> Result<Config, Vec<PlanError>> {
        let (config, mut errors, _) = load_config(config, None, sets);
        errors.sort_by_key(|error| (error.line.is_none(), error.line, error.column));
        if errors.is_empty() { Ok(config) } else { Err(errors) }
    }
}

/// The config as far as it can be read, the mistakes, and the tree that it was read from.
fn load_config(config: Option<&str>, options: Option<Node>, sets: &[String]) -> (Config, Vec<PlanError>, Node) {
    let reference = shipped::reference();
    let mut errors = Vec::new();
    let mut root = Node::empty(&reference);
    if let Some(config) = config {
        match shipped::config(config).map_err(|error| vec![error]).and_then(|source| parse(&source)) {
            Ok(node) => root = node,
            Err(mistakes) => errors.extend(mistakes),
        }
    }
    if let Some(options) = options {
        root.overlay(options);
    }
    for set in sets {
        match parse_set(set) {
            Ok(node) => root.overlay(node),
            Err(error) => errors.push(error),
        }
    }
    let reference = parse(&reference).unwrap_or_else(|_| Node::empty(&reference));
    let (config, mistakes) = read::<Config>(&root);
    errors.extend(mistakes.iter().map(|mistake| explain(mistake, &Root::Config { reference: &reference })));
    // Values that could not be read are defaults here, so what is said of the others stays true.
    let shortened: Vec<&str> = mistakes
        .iter()
        .filter_map(|mistake| mistake.path.strip_suffix(']')?.rsplit_once('['))
        .map(|(list, _)| list)
        .collect();
    errors.extend(check(&config, &root, &shortened, &reference));
    (config, errors, root)
}

/// Tables that stages read must be written.
fn left_out(pipeline: &Pipeline, config: &Config, root: &Node) -> Vec<PlanError> {
    let needs = [
        (Stage::Tree, "features", config.tables.features),
        (Stage::Neighbors, "features", config.tables.features),
        (Stage::Make, "channels", config.tables.channels),
    ];
    let missing = needs.into_iter().filter(|(_, _, written)| !written);
    let mut errors = Vec::new();
    for (stage, table, _) in missing {
        let planned = pipeline.stages.iter().any(|planned| planned.stage == stage);
        if let (true, Some(node)) = (planned, root.find(&format!("tables.{table}"))) {
            errors.push(node.place.error(
                format!("`{table}` in [tables] is false, and the pipeline has `{}`", stage.name()),
                format!("{} reads the {table} table", stage.name()),
                format!("leave it true, or take `{}` out of the pipeline", stage.name()),
            ));
        }
    }
    errors
}
