//! Rows of the tree's and the graph's tables (SCHEMA: items, merges, nodes, sequences, edges).

use crate::annotate::PlantState;

/// A frame that clustering works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "as SCHEMA, items")]
pub struct Sample {
    pub clip_id: u32,
    pub frame: u32,
}

/// One merge of a plant state's tree, in merge order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merge {
    /// Number of the new item: samples first, then merges in order of creation.
    pub item: u32,
    /// The lower of the two merged.
    pub a: u32,
    /// The higher.
    pub b: u32,
    /// Their squared distance, m^2 (eq. 4.1).
    pub e: f64,
    /// Samples below.
    pub members: u32,
    /// Mean squared distance of the members to the centroid, m^2.
    pub radius2: f64,
}

/// A node of the cluster graph.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "as SCHEMA, nodes")]
pub struct Node {
    pub node: u32,
    pub tree: String,
    pub plant_state: PlantState,
    pub threshold: f64,
    pub item: u32,
    pub members: u32,
    pub clips: u32,
    pub radius2: f64,
    pub max_radius2: f64,
    pub medoid: Sample,
    pub component: u32,
}

/// A longest run of consecutive samples of one clip in one node (T 4.2): half-open range of native frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "as SCHEMA, sequences")]
pub struct Sequence {
    pub node: u32,
    pub clip_id: u32,
    pub first: u32,
    pub end: u32,
    pub samples: u32,
    pub alignment_frame: Option<u32>,
    pub previous_node: Option<u32>,
    pub next_node: Option<u32>,
}

/// A transition between two nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "as SCHEMA, edges")]
pub struct Edge {
    pub from_node: u32,
    pub to_node: u32,
    pub transitions: u32,
    pub clips: u32,
}
