//! The cluster tree of all frames, and the cluster graph that cutting it gives.

pub mod tables;

pub use tables::{Edge, Merge, Node, Sample, Sequence};
