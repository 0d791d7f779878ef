//! The plan as timely dataflows: operators, exchange, commits, faults, several processes. The only room that names
//! timely or differential-dataflow.
//!
//! ```text
//! prepare -> [clips: mill] -> fold -> [cluster: tree, graph] -> [enrich: mill] -> fold        (run.rs)
//! ```
//!
//! - The shard is the unit of work, commit and resume; shards are cut before any work, and who mills which changes
//!   nothing (`tickets`, `shard_source`, `lane`).
//! - Arithmetic lives in the pure rooms; operators hold state and time (`per_clip`, `clip_stages`, `make_stages`).
//! - Nothing is written but by `shard_writer`, the two table writers of the cluster dataflow, and worker 0's folds.
//! - Nothing prints: `gauges` are read, `halt` and `guard` say how a run ends.

mod barrier;
mod clip_stages;
mod enrich;
pub mod gauges;
mod graph;
mod graph_collections;
pub mod guard;
pub mod halt;
mod lane;
mod make_stages;
pub mod mesh;
mod mill;
mod per_clip;
mod prepare;
pub mod run;
pub mod settings;
mod shard_source;
mod shard_writer;
mod tickets;
mod tree;
mod work;

pub use graph::GraphError;
pub use run::{RunError, RunReport, RunRequest, run};
