//! Pipeline, config and `--set` become a checked [`Plan`]: every mistake is named before any work (DESIGN 7).
//!
//! `document` reads TOML into trees that remember places, and lays one over the other; `reader` reads such a tree
//! into [`Config`] with serde and collects the mistakes; `ranges` holds the values against their bounds; `pipeline`
//! checks the order of stages; `mistakes` says it in words. [`PlanKeys`] tell finished work from work to do.
//! `idle` finds settings that have no effect as others stand. `name_rules` reads the rules of `evaluate` in the same way.

pub mod config;
mod document;
pub mod error;
pub mod filter;
pub mod idle;
pub mod keys;
pub mod load;
mod mistakes;
pub mod name_rules;
mod nearest;
mod pipeline;
mod ranges;
mod reader;
pub mod sections;
pub mod shipped;
pub mod stages;

pub use config::{Config, PoseRotations, WithoutInput};
pub use error::PlanError;
pub use filter::{ClipFacts, ClipFilter};
pub use idle::IdleThresholds;
pub use keys::{PlanKeys, shard_key};
pub use load::Plan;
pub use name_rules::load_name_rules;
pub use pipeline::PlannedStage;
pub use stages::{Need, Stage};
