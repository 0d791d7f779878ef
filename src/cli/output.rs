//! What goes out: results to standard output, messages to standard error, refusals in three lines.
//!
//! A verb gives an [`Answer`] or a [`Refusal`]; nothing panics because a reader has gone (`... | head`).

use super::Ending;
use crate::corpus::{CorpusError, LookUpError};
use crate::inputs::InputError;
use crate::plan::{Config, IdleThresholds, PlanError};
use serde::Serialize;
use std::borrow::Cow;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// What a verb found.
#[derive(Debug)]
pub(super) struct Answer {
    /// For standard output, whole.
    pub(super) text: String,
    /// For standard error, after it.
    pub(super) remarks: Vec<String>,
    /// How the verb ends.
    pub(super) ending: Ending,
}

/// Why a verb could not do its work, in the words that the user sees.
#[derive(Debug)]
pub(super) struct Refusal {
    pub(super) text: String,
    pub(super) ending: Ending,
}

impl Answer {
    /// Text for people.
    pub(super) fn text(text: String) -> Answer {
        Answer { text, remarks: Vec::new(), ending: Ending::Done }
    }

    /// The same for programs.
    pub(super) fn json(value: &impl Serialize) -> Answer {
        // Strings, numbers and maps with string keys: nothing that JSON can't hold.
        let mut text = serde_json::to_string_pretty(value).expect("plain fields always make JSON");
        text.push('\n');
        Answer::text(text)
    }

    /// Says something beside the result.
    pub(super) fn remark(mut self, remark: impl Into<String>) -> Answer {
        self.remarks.push(remark.into());
        self
    }

    /// Ends otherwise.
    pub(super) fn ending(mut self, ending: Ending) -> Answer {
        self.ending = ending;
        self
    }
}

impl Refusal {
    /// What, why and what to do; exit code 1.
    pub(super) fn new(what: impl AsRef<str>, why: impl AsRef<str>, remedy: impl AsRef<str>) -> Refusal {
        let text = three_lines("error", what.as_ref(), why.as_ref(), remedy.as_ref());
        Refusal { text, ending: Ending::Failed }
    }

    /// The fault is in the arguments; exit code 2.
    pub(super) fn in_arguments(mut self) -> Refusal {
        self.ending = Ending::BadPlan;
        self
    }
}

impl From<CorpusError> for Refusal {
    fn from(error: CorpusError) -> Refusal {
        Refusal::new(error.to_string(), error.why(), error.remedy())
    }
}

impl Refusal {
    /// No clip of the corpus, or several, are called so.
    pub(super) fn of_look_up(error: &LookUpError, corpus: &Path) -> Refusal {
        match error {
            LookUpError::NotFound { nearest, .. } => {
                let remedy = match nearest.as_slice() {
                    [] => format!("motionmill search {} --quiet lists all names", corpus.display()),
                    near => near.join(", "),
                };
                Refusal::new(error.to_string(), "a name, its last part, or a prefix that only one clip has", remedy)
            }
            LookUpError::Ambiguous { matches, .. } => Refusal::new(
                error.to_string(),
                "one clip is meant, and none of these is nearer than the others",
                matches.first().map_or("", String::as_str),
            ),
        }
    }
}

impl From<Vec<PlanError>> for Refusal {
    fn from(errors: Vec<PlanError>) -> Refusal {
        let texts: Vec<String> = errors.iter().map(PlanError::to_string).collect();
        Refusal { text: texts.join("\n\n"), ending: Ending::BadPlan }
    }
}

impl From<Vec<InputError>> for Refusal {
    fn from(errors: Vec<InputError>) -> Refusal {
        let texts: Vec<String> = errors
            .iter()
            .map(|error| {
                let (why, remedy) = match error {
                    InputError::SameLabel { label, paths } => (
                        "a source's label is part of the name of every clip, and tells a run which clips it had before",
                        format!(
                            "another name for one: [[source]] folder = \"{}\" label = \"{label}-2\" in your config",
                            paths[1]
                        ),
                    ),
                    _ => (
                        "captures are read from there",
                        "--input with a folder that holds .bvh, or .amc and .asf, files, or with such a file"
                            .to_owned(),
                    ),
                };
                three_lines("error", &error.to_string(), why, &remedy)
            })
            .collect();
        Refusal { text: texts.join("\n\n"), ending: Ending::BadPlan }
    }
}

/// A note for each section of thresholds that somebody changed and that nothing goes by.
pub(super) fn idle_thresholds(config: &Config) -> Vec<String> {
    let note = |idle: &IdleThresholds| three_lines("note", &idle.what(), &idle.why(), &idle.remedy());
    config.idle_thresholds().iter().map(note).collect()
}

/// `error: what`, and below it why and what to do.
pub(super) fn three_lines(word: &str, what: &str, why: &str, remedy: &str) -> String {
    format!("{word}: {what}\n  why: {why}\n  try: {remedy}")
}

/// Writes to standard output. A reader who has gone has had enough; anything else that fails ends the program.
pub(super) fn say(text: &str) {
    let text = &printable(text);
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let why = "the result goes to standard output";
            tell(&three_lines("error", &error.to_string(), why, "another place for it: > FILE"));
            std::process::exit(1);
        }
        _ => {}
    }
}

/// The text with control characters spelt out, but for the ends of lines: names come from files and may hold any.
fn printable(text: &str) -> Cow<'_, str> {
    let controls = |c: char| c.is_control() && c != '\n' && c != '\t';
    match text.contains(controls) {
        false => Cow::Borrowed(text),
        true => text.chars().map(|c| if controls(c) { c.escape_unicode().to_string() } else { c.into() }).collect(),
    }
}

/// Writes a line to standard error; that nobody hears it is no reason to stop.
pub(super) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(line));
}
