//! The corpus on disk (SCHEMA, DESIGN 4): shards of Parquet tables under commit records, tables over all shards, the
//! manifest. The only room that names arrow or parquet. Prints nothing.
//!
//! # What can be relied on
//! - A file is there whole or not at all; a shard is there when its commit record is, which is put last.
//! - The same rows in the same order give the same bytes: writer settings are pinned, nothing written depends on a
//!   clock, a path, or how rows came in batches.
//! - What is read is checked: a damaged file is an error, never a panic or wrong numbers of rows.
//!
//! # How it goes
//! Process 0 calls [`open_to_run`]; a shard is written by a [`ShardWriter`], which gives a [`FinishedShard`], whose
//! `commit` puts files and record in place; at the end of a stage [`Folded`] writes the tables over all shards and
//! the [`Manifest`] is put. Later stages read through a [`Catalog`]. [`verify`] takes all digests again.

mod card;
mod columns;
mod error;
mod fold;
mod guard;
mod lock;
mod manifest;
mod open;
mod paths;
mod query;
mod read;
mod reader;
mod record;
mod reference;
mod replace;
mod rows;
mod sealed;
mod shard;
mod store;
mod tables;
mod unchanged;
mod verify;
mod whole;
mod writer;

pub use card::{SourceTerms, write_card};
pub use error::{CorpusError, Trouble};
pub use fold::{FAULT_ROWS_A_KIND, Folded, left_out};
pub use guard::in_guarded_call;
pub use lock::{RunLock, check_token};
pub use manifest::{ClipEntry, ClipState, Manifest, SourceEntry, TableDigest};
pub use open::{OpenCorpus, open_to_read, open_to_run};
pub use paths::{
    CARD, CLIPS, COMMITS, EDGES, FAULTS, MADE, MANIFEST, NODES, RECIPES, REFERENCE, SEQUENCES, SKELETONS, ShardId,
    ShardKind, ShardStage, Table, items_file, merges_file,
};
pub use query::{LookUpError, look_up};
pub use read::{Catalog, ShardReader};
pub use record::{FileRecord, InputFile, ShardRecord, StageKeys, read_record, read_records};
pub use reference::{read_reference, write_reference};
pub use replace::Replacement;
pub use shard::{ClipTables, FinishedShard, ShardSettings, ShardWriter, remove_shard};
pub use store::{Store, Temporary};
pub use tables::{ClipFormat, ClipRow, FaultRow, Origin, PARTS, SkeletonRow};
pub use verify::{Finding, Verified, Wrong, verify};
pub use whole::{
    read_clips, read_edges, read_faults, read_items, read_made, read_merges, read_nodes, read_recipes, read_sequences,
    read_skeletons, write_clips, write_edges, write_faults, write_items, write_made, write_merges, write_nodes,
    write_recipes, write_sequences, write_skeletons,
};
pub use writer::{Compressing, FORMAT_VERSION, FileNotes};
