//! The `nodes`, `sequences` and `edges` tables of the cluster graph.

use super::{RowTable, texts};
use crate::annotate::PlantState;
use crate::cluster::{Edge, Node, Sample, Sequence};
use crate::corpus::columns::{Columns, PLAIN, SQUARE_METERS};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use arrow::array::{Array, UInt32Array};

impl RowTable for Node {
    const NAME: &'static str = "nodes";

    fn columns(rows: &[Node]) -> Columns {
        Columns::new()
            .u32("node", PLAIN, rows.iter().map(|row| row.node))
            .str("tree", rows.iter().map(|row| row.tree.as_str()))
            .str("plant_state", rows.iter().map(|row| row.plant_state.name()))
            .f64("threshold", SQUARE_METERS, rows.iter().map(|row| row.threshold))
            .u32("item", PLAIN, rows.iter().map(|row| row.item))
            .u32("members", PLAIN, rows.iter().map(|row| row.members))
            .u32("clips", PLAIN, rows.iter().map(|row| row.clips))
            .f64("radius2", SQUARE_METERS, rows.iter().map(|row| row.radius2))
            .f64("max_radius2", SQUARE_METERS, rows.iter().map(|row| row.max_radius2))
            .u32("medoid_clip_id", PLAIN, rows.iter().map(|row| row.medoid.clip_id))
            .u32("medoid_frame", PLAIN, rows.iter().map(|row| row.medoid.frame))
            .u32("component", PLAIN, rows.iter().map(|row| row.component))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Node>, CorpusError> {
        let (node, tree, state) = (rows.u32("node")?, texts(rows, "tree")?, rows.str("plant_state")?);
        let (threshold, item) = (rows.f64("threshold")?, rows.u32("item")?);
        let (members, clips) = (rows.u32("members")?, rows.u32("clips")?);
        let (radius2, max_radius2) = (rows.f64("radius2")?, rows.f64("max_radius2")?);
        let (clip_id, frame) = (rows.u32("medoid_clip_id")?, rows.u32("medoid_frame")?);
        let component = rows.u32("component")?;
        (0..rows.len())
            .map(|at| {
                let word = state.value(at);
                let state = PlantState::from_name(word);
                Ok(Node {
                    node: node[at],
                    tree: tree[at].clone(),
                    plant_state: state.ok_or_else(|| rows.damaged(format!("`{word}` is no plant state")))?,
                    threshold: threshold[at],
                    item: item[at],
                    members: members[at],
                    clips: clips[at],
                    radius2: radius2[at],
                    max_radius2: max_radius2[at],
                    medoid: Sample { clip_id: clip_id[at], frame: frame[at] },
                    component: component[at],
                })
            })
            .collect()
    }
}

impl RowTable for Sequence {
    const NAME: &'static str = "sequences";

    fn columns(rows: &[Sequence]) -> Columns {
        Columns::new()
            .u32("node", PLAIN, rows.iter().map(|row| row.node))
            .u32("clip_id", PLAIN, rows.iter().map(|row| row.clip_id))
            .u32("first", PLAIN, rows.iter().map(|row| row.first))
            .u32("end", PLAIN, rows.iter().map(|row| row.end))
            .u32("samples", PLAIN, rows.iter().map(|row| row.samples))
            .u32_opt("alignment_frame", PLAIN, rows.iter().map(|row| row.alignment_frame))
            .u32_opt("previous_node", PLAIN, rows.iter().map(|row| row.previous_node))
            .u32_opt("next_node", PLAIN, rows.iter().map(|row| row.next_node))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Sequence>, CorpusError> {
        let (node, clip_id) = (rows.u32("node")?, rows.u32("clip_id")?);
        let (first, end, samples) = (rows.u32("first")?, rows.u32("end")?, rows.u32("samples")?);
        let (alignment, previous, next) =
            (rows.u32_opt("alignment_frame")?, rows.u32_opt("previous_node")?, rows.u32_opt("next_node")?);
        let optional = |column: &UInt32Array, at: usize| column.is_valid(at).then(|| column.value(at));
        let sequence = |at: usize| Sequence {
            node: node[at],
            clip_id: clip_id[at],
            first: first[at],
            end: end[at],
            samples: samples[at],
            alignment_frame: optional(alignment, at),
            previous_node: optional(previous, at),
            next_node: optional(next, at),
        };
        Ok((0..rows.len()).map(sequence).collect())
    }
}

impl RowTable for Edge {
    const NAME: &'static str = "edges";

    fn columns(rows: &[Edge]) -> Columns {
        Columns::new()
            .u32("from_node", PLAIN, rows.iter().map(|row| row.from_node))
            .u32("to_node", PLAIN, rows.iter().map(|row| row.to_node))
            .u32("transitions", PLAIN, rows.iter().map(|row| row.transitions))
            .u32("clips", PLAIN, rows.iter().map(|row| row.clips))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Edge>, CorpusError> {
        let (from, to) = (rows.u32("from_node")?, rows.u32("to_node")?);
        let (transitions, clips) = (rows.u32("transitions")?, rows.u32("clips")?);
        let edge =
            |at: usize| Edge { from_node: from[at], to_node: to[at], transitions: transitions[at], clips: clips[at] };
        Ok((0..rows.len()).map(edge).collect())
    }
}
