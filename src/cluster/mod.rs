//! The cluster tree of all frames, and the cluster graph that cutting it gives (T 4).
//!
//! In the order of a run: [`Metric`] makes a canonical vector of each sample; [`tree()`] merges the samples of one
//! plant state, closest pair first; [`cut()`] says which samples share a node at a threshold; [`frame_ranges()`]
//! and [`runs()`] put a clip's samples into clip-frame sequences; [`graph()`] links them; [`medoids()`], [`align()`],
//! [`components()`] and [`nodes()`] add what the tables say of nodes. All are pure, and neither threads nor
//! the order in which clips are given show in their results.

pub mod alignment;
pub mod banded;
mod box_tree;
pub mod components;
pub mod cut;
#[cfg(test)]
mod dense;
mod duplicates;
pub mod error;
pub mod frame_ranges;
pub mod graph;
mod log;
pub mod matrix;
pub mod medoid;
pub mod metric;
pub mod nodes;
pub mod queue;
mod search_basis;
pub mod tables;
#[cfg(test)]
mod tree_tests;
#[cfg(test)]
mod walks;

pub use alignment::{AlignmentRule, StateCut, align};
pub use banded::tree;
pub use components::{Components, components, largest_share};
pub use cut::{Cut, cut, levels};
pub use error::ClusterError;
pub use frame_ranges::frame_ranges;
pub use graph::{ClipRuns, Graph, PlacedSample, Run, Visits, graph, runs, sequences};
pub use matrix::tree_by_matrix;
pub use medoid::{Medoid, medoids};
pub use metric::{EffectorWeights, Metric, Settings, Vector, error_m2};
pub use nodes::{first_nodes, nodes};
pub use queue::tree_by_queue;
pub use tables::{Edge, Merge, Node, Sample, Sequence};
