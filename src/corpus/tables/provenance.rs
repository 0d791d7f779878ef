//! The `provenance` table: where every part of every frame of a made clip comes from.

use crate::corpus::columns::{Columns, PLAIN};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::synthesis::ProvenanceRow;

/// Words of the column `part`.
pub const PARTS: [&str; 7] = ["root", "legs", "trunk", "head", "arm_left", "arm_right", "all"];

/// Gathers a clip's provenance.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherProvenance(Vec<ProvenanceRow>);

/// Columns of one clip's provenance.
pub(in crate::corpus) fn provenance_columns(clip_id: u32, rows: &[ProvenanceRow]) -> Columns {
    Columns::new()
        .u32("clip_id", PLAIN, rows.iter().map(|_| clip_id))
        .u32("frame", PLAIN, rows.iter().map(|row| row.frame))
        .str("part", rows.iter().map(|row| row.part))
        .u32("parent", PLAIN, rows.iter().map(|row| row.parent))
        .f64("parent_frame", PLAIN, rows.iter().map(|row| row.parent_frame))
        .f32("weight", PLAIN, rows.iter().map(|row| row.weight))
}

/// What is wrong with a clip's provenance, if anything.
pub(in crate::corpus) fn refuse_provenance(rows: &[ProvenanceRow], n_frames: usize) -> Result<(), String> {
    if !rows.is_sorted_by_key(|row| row.frame) {
        return Err("frames out of order".to_owned());
    }
    let good = |row: &ProvenanceRow| {
        PARTS.contains(&row.part)
            && (row.frame as usize) < n_frames
            && row.parent_frame.is_finite()
            && row.weight.is_finite()
    };
    rows.iter().find(|row| !good(row)).map_or(Ok(()), |row| Err(format!("{row:?} of {n_frames} frames")))
}

impl crate::corpus::reader::Gather for GatherProvenance {
    type Clip = Vec<ProvenanceRow>;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        let (frame, part, parent) = (rows.u32("frame")?, rows.str("part")?, rows.u32("parent")?);
        let (parent_frame, weight) = (rows.f64("parent_frame")?, rows.f32("weight")?);
        for at in 0..rows.len() {
            let word = part.value(at);
            let part = PARTS.into_iter().find(|&part| part == word);
            let part = part.ok_or_else(|| rows.damaged(format!("`{word}` is no part")))?;
            self.0.push(ProvenanceRow {
                frame: frame[at],
                part,
                parent: parent[at],
                parent_frame: parent_frame[at],
                weight: weight[at],
            });
        }
        Ok(())
    }

    fn done(self) -> Vec<ProvenanceRow> {
        self.0
    }
}
