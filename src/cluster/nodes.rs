//! The rows of the `nodes` table.

use super::alignment::StateCut;
use super::components::Components;
use super::error::ClusterError;
use super::graph::Visits;
use super::tables::{Merge, Node};
use crate::annotate::PlantState;

/// Number of the first node of each cut, when cuts are numbered one after the other: node = first + place in
/// [`Cut::items`](super::Cut::items). Give all cuts in one order, such as (tree, threshold, plant state).
///
/// # Errors
/// [`ClusterError::TooMany`] where u32 does not hold them all.
pub fn first_nodes(n_nodes: &[usize]) -> Result<Vec<u32>, ClusterError> {
    let mut next = 0_usize;
    let mut first = Vec::with_capacity(n_nodes.len());
    for &n in n_nodes {
        first.push(next as u32);
        next = next.saturating_add(n);
        if next > u32::MAX as usize {
            return Err(ClusterError::TooMany { found: next, limit: u32::MAX as usize });
        }
    }
    Ok(first)
}

/// The rows of one cut of one plant state's tree, by node.
///
/// `merges`: the tree that was cut. `visits`, `components`: of the whole graph; the column `component` is the *strong* one,
/// because a walk can return only inside it.
pub fn nodes(
    tree: &str,
    plant_state: PlantState,
    state: StateCut<'_>,
    merges: &[Merge],
    visits: &[Visits],
    components: &Components,
) -> Vec<Node> {
    let n_samples = state.samples.len();
    let row = |(at, (&item, medoid)): (usize, (&u32, &super::Medoid))| {
        let node = state.first_node + at as u32;
        let merge = (item as usize).checked_sub(n_samples).and_then(|at| merges.get(at));
        let clips = visits.binary_search_by_key(&node, |visits| visits.node).map_or(0, |at| visits[at].clips);
        Node {
            node,
            tree: tree.to_owned(),
            plant_state,
            threshold: state.cut.threshold_m2,
            item,
            members: state.cut.members(at).len() as u32,
            clips,
            radius2: merge.map_or(0.0, |merge| merge.radius2),
            max_radius2: medoid.max_radius2_m2,
            medoid: state.samples[medoid.sample as usize],
            component: components.nodes.binary_search(&node).map_or(node, |at| components.strong[at]),
        }
    };
    state.cut.items.iter().zip(state.medoids).enumerate().map(row).collect()
}
