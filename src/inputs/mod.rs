//! Finding clips and their skeletons in folders: which files, under which names, with which settings.
//!
//! [`find_inputs`] walks the folders and gives a list sorted by (source, name) that depends on neither the order of
//! the folders nor of their entries; [`hash_inputs`] reads the bytes; [`difference()`] compares with what a corpus
//! knows; [`cut_shards`] makes units of work; [`find_truth_files`] finds what people wrote about clips. What can't be
//! used becomes a notice, never a crash.

pub mod difference;
pub mod find;
pub mod hash;
pub mod lookup;
mod names;
mod pairing;
pub mod pattern;
pub mod settings;
pub mod shards;
pub mod truths;
mod walk;

pub use difference::{Difference, Keyed, difference};
pub use find::{Found, Input, InputError, InputNotice, InputSource, Unsure, find_inputs};
pub use hash::{InputHash, hash_inputs};
pub use lookup::{LookupError, look_up};
pub use pattern::matches;
pub use settings::{ClipRule, InputRules, InputSettings, SourceRule, SourceSettings};
pub use shards::{Shard, cut_shards};
pub use truths::{TruthFileError, TruthFiles, find_truth_files};
