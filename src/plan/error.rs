//! A mistake in a pipeline, a config or a `--set`: where, what, why, what to do.

use std::fmt;

/// One mistake, found before any work. Its `Display` is the three lines that the user sees (UX, Mistakes).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanError {
    /// The file as the user named it, or the whole `--set a.b=c`.
    pub file: String,
    /// Line of the file, from 1. None: the file as a whole, or a `--set`.
    pub line: Option<u32>,
    /// Character of the line, from 1.
    pub column: Option<u32>,
    /// What was found, with the user's own names and values.
    pub what: String,
    /// Why it can't be used.
    pub why: String,
    /// What to write instead, or to do.
    pub try_: String,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.file)?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        write!(f, ": {}\n  why: {}\n  try: {}", self.what, self.why, self.try_)
    }
}

impl std::error::Error for PlanError {}
