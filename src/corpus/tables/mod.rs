//! The tables of SCHEMA, one file each: columns from rows, and rows from columns.

mod annotations;
mod channels;
mod clips;
mod faults;
mod features;
mod float_block;
mod graph;
mod made;
mod plants;
mod poses;
mod provenance;
mod recipes;
mod skeletons;
mod tree;

use super::columns::Columns;
use super::error::CorpusError;
use super::rows::Rows;
use crate::annotate::Gait;

pub(super) use annotations::{GatherLabels, annotations_columns};
pub(super) use channels::{ChannelsTable, GatherChannels};
pub use clips::{ClipFormat, ClipRow, Origin};
pub use faults::FaultRow;
pub(super) use features::{FeaturesTable, GatherFeatures};
pub(super) use made::{made_columns, made_from_rows};
pub(super) use plants::{GatherPlants, GatherSegments, plants_columns, segments_columns};
pub(super) use poses::{GatherPoses, PosesTable, pose_layout};
pub use provenance::PARTS;
pub(super) use provenance::{GatherProvenance, provenance_columns, refuse_provenance};
pub use skeletons::SkeletonRow;
pub(super) use tree::numbered_items;

/// A table whose rows are values of one type and whose columns are fixed.
pub(super) trait RowTable: Sized {
    /// Its name in file metadata.
    const NAME: &'static str;

    /// All columns; of no rows: the schema.
    fn columns(rows: &[Self]) -> Columns;

    /// The rows of a batch.
    fn from_rows(rows: &Rows<'_>) -> Result<Vec<Self>, CorpusError>;
}

/// A column of strings.
fn texts(rows: &Rows<'_>, name: &str) -> Result<Vec<String>, CorpusError> {
    Ok(rows.str(name)?.iter().map(|text| text.unwrap_or_default().to_owned()).collect())
}

/// A column of strings that may be null.
fn strings(rows: &Rows<'_>, name: &str) -> Result<Vec<Option<String>>, CorpusError> {
    Ok(rows.str_opt(name)?.iter().map(|text| text.map(str::to_owned)).collect())
}

/// The gait of that name.
fn gait(rows: &Rows<'_>, word: &str) -> Result<Gait, CorpusError> {
    let all = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump, Gait::Other];
    all.into_iter().find(|gait| gait.name() == word).ok_or_else(|| rows.damaged(format!("`{word}` is no gait")))
}

/// Checks that a table by frame goes on with the frame after the last.
fn expect_frames(rows: &Rows<'_>, from: usize) -> Result<(), CorpusError> {
    let frames = rows.u32("frame")?;
    match frames.iter().enumerate().all(|(at, &frame)| frame as usize == from + at) {
        true => Ok(()),
        false => Err(rows.damaged("frames out of order")),
    }
}
