//! The `items` and `merges` tables: one file each a tree and plant state.

use super::RowTable;
use crate::cluster::{Merge, Sample};
use crate::corpus::columns::{Columns, PLAIN, SQUARE_METERS};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;

impl RowTable for Sample {
    const NAME: &'static str = "items";

    fn columns(rows: &[Sample]) -> Columns {
        numbered_items(0, rows)
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Sample>, CorpusError> {
        let (item, clip_id, frame) = (rows.u32("item")?, rows.u32("clip_id")?, rows.u32("frame")?);
        // Item numbers are places in the list: each is one more than the last.
        match item.windows(2).all(|pair| u64::from(pair[1]) == u64::from(pair[0]) + 1) {
            true => Ok(clip_id.iter().zip(frame).map(|(&clip_id, &frame)| Sample { clip_id, frame }).collect()),
            false => Err(rows.damaged("items out of order")),
        }
    }
}

/// Columns of samples whose first has the item number `first`.
pub(in crate::corpus) fn numbered_items(first: u32, rows: &[Sample]) -> Columns {
    Columns::new()
        .u32("item", PLAIN, (first..).take(rows.len()))
        .u32("clip_id", PLAIN, rows.iter().map(|row| row.clip_id))
        .u32("frame", PLAIN, rows.iter().map(|row| row.frame))
}

impl RowTable for Merge {
    const NAME: &'static str = "merges";

    fn columns(rows: &[Merge]) -> Columns {
        Columns::new()
            .u32("item", PLAIN, rows.iter().map(|row| row.item))
            .u32("a", PLAIN, rows.iter().map(|row| row.a))
            .u32("b", PLAIN, rows.iter().map(|row| row.b))
            .f64("e", SQUARE_METERS, rows.iter().map(|row| row.e))
            .u32("members", PLAIN, rows.iter().map(|row| row.members))
            .f64("radius2", SQUARE_METERS, rows.iter().map(|row| row.radius2))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Merge>, CorpusError> {
        let (item, a, b, e) = (rows.u32("item")?, rows.u32("a")?, rows.u32("b")?, rows.f64("e")?);
        let (members, radius2) = (rows.u32("members")?, rows.f64("radius2")?);
        let merge = |at: usize| Merge {
            item: item[at],
            a: a[at],
            b: b[at],
            e: e[at],
            members: members[at],
            radius2: radius2[at],
        };
        Ok((0..rows.len()).map(merge).collect())
    }
}
