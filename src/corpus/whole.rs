//! Tables that are one file each: written in one go, atomically, and read whole.

use super::columns::Columns;
use super::error::CorpusError;
use super::paths::{CLIPS, EDGES, FAULTS, MADE, NODES, RECIPES, SEQUENCES, SKELETONS, items_file, merges_file};
use super::reader::TableFile;
use super::record::FileRecord;
use super::rows::Rows;
use super::store::Store;
use super::tables::{ClipRow, FaultRow, RowTable, SkeletonRow, made_columns, made_from_rows, numbered_items};
use super::writer::{Compressing, FileNotes, TableWriter};
use crate::annotate::PlantState;
use crate::cluster::{Edge, Merge, Node, Sample, Sequence};
use crate::synthesis::{Made, Recipe};

/// Rows that become columns at once.
const CHUNK: usize = 1 << 16;

/// Writes `clips`, by clip_id.
///
/// # Errors
/// The file system's refusals, here and in all writers below; the file is then as it was.
pub fn write_clips(store: &Store, rows: &[ClipRow], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, CLIPS, rows, notes)
}

/// Reads `clips`.
///
/// # Errors
/// [`CorpusError::NotThere`] and [`CorpusError::Damaged`], here and in all readers below.
pub fn read_clips(store: &Store) -> Result<Vec<ClipRow>, CorpusError> {
    read_rows(store, CLIPS)
}

/// Writes `skeletons`, by id.
pub fn write_skeletons(store: &Store, rows: &[SkeletonRow], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, SKELETONS, rows, notes)
}

/// Reads `skeletons`; `first_clip` is empty.
pub fn read_skeletons(store: &Store) -> Result<Vec<SkeletonRow>, CorpusError> {
    read_rows(store, SKELETONS)
}

/// Writes `faults`.
pub fn write_faults(store: &Store, rows: &[FaultRow], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, FAULTS, rows, notes)
}

/// Reads `faults`.
pub fn read_faults(store: &Store) -> Result<Vec<FaultRow>, CorpusError> {
    read_rows(store, FAULTS)
}

/// Writes the items of a tree in one plant state, in tie order; an item's number is its place.
pub fn write_items(
    store: &Store,
    tree: &str,
    state: PlantState,
    rows: &[Sample],
    notes: &FileNotes,
) -> Result<FileRecord, CorpusError> {
    let chunks = rows.chunks(CHUNK).enumerate().map(|(n, rows)| numbered_items((n * CHUNK) as u32, rows));
    write_columns(store, &items_file(tree, state), Sample::NAME, Sample::columns(&[]), chunks, notes)
}

/// Reads the items of a tree in one plant state.
pub fn read_items(store: &Store, tree: &str, state: PlantState) -> Result<Vec<Sample>, CorpusError> {
    read_rows(store, &items_file(tree, state))
}

/// Writes the merges of a tree in one plant state, in merge order.
pub fn write_merges(
    store: &Store,
    tree: &str,
    state: PlantState,
    rows: &[Merge],
    notes: &FileNotes,
) -> Result<FileRecord, CorpusError> {
    write_rows(store, &merges_file(tree, state), rows, notes)
}

/// Reads the merges of a tree in one plant state.
pub fn read_merges(store: &Store, tree: &str, state: PlantState) -> Result<Vec<Merge>, CorpusError> {
    read_rows(store, &merges_file(tree, state))
}

/// Writes `nodes`.
pub fn write_nodes(store: &Store, rows: &[Node], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, NODES, rows, notes)
}

/// Reads `nodes`.
pub fn read_nodes(store: &Store) -> Result<Vec<Node>, CorpusError> {
    read_rows(store, NODES)
}

/// Writes `sequences`.
pub fn write_sequences(store: &Store, rows: &[Sequence], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, SEQUENCES, rows, notes)
}

/// Reads `sequences`.
pub fn read_sequences(store: &Store) -> Result<Vec<Sequence>, CorpusError> {
    read_rows(store, SEQUENCES)
}

/// Writes `edges`.
pub fn write_edges(store: &Store, rows: &[Edge], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, EDGES, rows, notes)
}

/// Reads `edges`.
pub fn read_edges(store: &Store) -> Result<Vec<Edge>, CorpusError> {
    read_rows(store, EDGES)
}

/// Writes `recipes`.
pub fn write_recipes(store: &Store, rows: &[Recipe], notes: &FileNotes) -> Result<FileRecord, CorpusError> {
    write_rows(store, RECIPES, rows, notes)
}

/// Reads `recipes`.
pub fn read_recipes(store: &Store) -> Result<Vec<Recipe>, CorpusError> {
    read_rows(store, RECIPES)
}

/// Writes `made`; every row has the figures of these names, in this order, or none (never judged).
///
/// # Errors
/// [`CorpusError::Encoding`] for a row with other figures.
pub fn write_made(
    store: &Store,
    rows: &[Made],
    figures: &[&str],
    notes: &FileNotes,
) -> Result<FileRecord, CorpusError> {
    let refused = |recipe| CorpusError::Encoding {
        path: store.path(MADE),
        what: format!("recipe {recipe} was judged by other figures than {figures:?}"),
    };
    let empty = made_columns(&[], figures).map_err(refused)?;
    let chunks: Result<Vec<Columns>, String> = rows.chunks(CHUNK).map(|rows| made_columns(rows, figures)).collect();
    write_columns(store, MADE, "made", empty, chunks.map_err(refused)?.into_iter(), notes)
}

/// Reads `made`.
pub fn read_made(store: &Store) -> Result<Vec<Made>, CorpusError> {
    read_with(store, MADE, made_from_rows)
}

fn write_rows<R: RowTable>(
    store: &Store,
    name: &str,
    rows: &[R],
    notes: &FileNotes,
) -> Result<FileRecord, CorpusError> {
    write_columns(store, name, R::NAME, R::columns(&[]), rows.chunks(CHUNK).map(R::columns), notes)
}

fn write_columns(
    store: &Store,
    name: &str,
    table: &str,
    empty: Columns,
    chunks: impl Iterator<Item = Columns>,
    notes: &FileNotes,
) -> Result<FileRecord, CorpusError> {
    let temporary = store.temporary(name)?;
    let path = temporary.path().to_owned();
    let mut writer = TableWriter::new(temporary, &path, table, empty.schema(), notes, Compressing::default())?;
    for columns in chunks {
        writer.write(columns.into_batch()?)?;
    }
    let (temporary, written) = writer.finish()?;
    temporary.rename()?;
    store.sync_folder_of(name)?;
    Ok(FileRecord { path: name.to_owned(), bytes: written.bytes, blake3: written.blake3, rows: written.rows })
}

fn read_rows<R: RowTable>(store: &Store, name: &str) -> Result<Vec<R>, CorpusError> {
    read_with(store, name, R::from_rows)
}

fn read_with<R>(
    store: &Store,
    name: &str,
    from_rows: impl Fn(&Rows<'_>) -> Result<Vec<R>, CorpusError>,
) -> Result<Vec<R>, CorpusError> {
    if !store.is_there(name) {
        return Err(CorpusError::NotThere { what: name.to_owned() });
    }
    let file = TableFile::open(store, name, None)?;
    let mut all = Vec::new();
    for batch in file.batches(None, None)? {
        all.extend(from_rows(&Rows::new(&batch?, file.path()))?);
    }
    Ok(all)
}
