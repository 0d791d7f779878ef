//! Labels against truth: how often contacts are right, how far strikes and lift-offs are off, which gaits are taken
//! for which.
//!
//! Labels and truth in, counts out. Truth of frames ([`FrameTruth`]) comes from a table that somebody wrote
//! ([`read_truth_csv`]) or from the footstep plan of a made person; truth of whole clips from their names
//! ([`NameRules`]). Counts are whole numbers, times whole microseconds: scores of clips add up to the same sums in any
//! order.
//!
//! ```text
//! frame_truth   what is true of every frame          truth_csv     its table
//! stances       runs of a planted foot, matched      time_errors   mean and s.d. of what they are off
//! contacts      P, R, F1, missed, spurious (T 3.1.2)  gaits         who is taken for whom (T 3.2.2)
//! name_rules    the class that a clip's name promises
//! ```

mod contacts;
mod frame_truth;
mod gaits;
mod name_rules;
mod stances;
mod time_errors;
mod truth_csv;

pub use contacts::ContactScore;
pub use frame_truth::{FrameTruth, LengthsDiffer};
pub use gaits::GaitConfusion;
pub use name_rules::{NameRule, NameRules};
pub use time_errors::TimeErrors;
pub use truth_csv::{TruthCsvError, TruthMistake, read_truth_csv};
