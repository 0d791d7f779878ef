//! What a reader has to say about its input: notes, warnings and faults, as rows for the `faults` table.

use serde::{Deserialize, Serialize};

/// How much an oddity weighs (DESIGN 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A guess that was made: unit, up axis, rate.
    Note,
    /// A deviation with one meaning; the clip is used.
    Warning,
    /// No meaning; the clip is quarantined and the run goes on.
    Fault,
}

/// One thing that a user should know about a file: where, what, why it matters, what to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Notice {
    /// Note, warning or fault.
    pub severity: Severity,
    /// A short stable name of the kind of oddity, such as `frames-fewer-than-said`.
    pub kind: String,
    /// Line of the file, from 1.
    pub line: Option<u32>,
    /// Frame, from 0.
    pub frame: Option<u32>,
    /// How often this kind was met in the clip.
    pub count: u32,
    /// What was found, with the file's own values.
    pub message: String,
    /// Why it matters.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

impl Severity {
    /// The word in tables and messages.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Fault => "fault",
        }
    }
}
