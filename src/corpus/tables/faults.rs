//! The `faults` table: what the readers had to say about their input.

use super::{RowTable, texts};
use crate::corpus::columns::{Columns, PLAIN};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::motion::{Notice, Severity};
use arrow::array::Array;
use serde::{Deserialize, Serialize};

/// A row of `faults`: a notice and the clip it speaks of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultRow {
    /// Label of the source.
    pub source: String,
    /// Name of the clip; that of the folder, where the notice speaks of all its clips.
    pub name: String,
    /// What was found.
    pub notice: Notice,
}

impl RowTable for FaultRow {
    const NAME: &'static str = "faults";

    fn columns(rows: &[FaultRow]) -> Columns {
        Columns::new()
            .str("source", rows.iter().map(|row| row.source.as_str()))
            .str("name", rows.iter().map(|row| row.name.as_str()))
            .str("severity", rows.iter().map(|row| row.notice.severity.name()))
            .str("kind", rows.iter().map(|row| row.notice.kind.as_str()))
            .u32_opt("line", PLAIN, rows.iter().map(|row| row.notice.line))
            .u32_opt("frame", PLAIN, rows.iter().map(|row| row.notice.frame))
            .u32("count", PLAIN, rows.iter().map(|row| row.notice.count))
            .str("message", rows.iter().map(|row| row.notice.message.as_str()))
            .str("remedy", rows.iter().map(|row| row.notice.remedy.as_str()))
            .str("why", rows.iter().map(|row| row.notice.why.as_str()))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<FaultRow>, CorpusError> {
        let (source, name, kind) = (texts(rows, "source")?, texts(rows, "name")?, texts(rows, "kind")?);
        let (severity, count) = (rows.str("severity")?, rows.u32("count")?);
        let (line, frame) = (rows.u32_opt("line")?, rows.u32_opt("frame")?);
        let (message, remedy, why) = (texts(rows, "message")?, texts(rows, "remedy")?, texts(rows, "why")?);
        (0..rows.len())
            .map(|at| {
                let word = severity.value(at);
                let known = [Severity::Note, Severity::Warning, Severity::Fault].into_iter();
                let severity = known.into_iter().find(|severity| severity.name() == word);
                let notice = Notice {
                    severity: severity.ok_or_else(|| rows.damaged(format!("`{word}` is no severity")))?,
                    kind: kind[at].clone(),
                    line: line.is_valid(at).then(|| line.value(at)),
                    frame: frame.is_valid(at).then(|| frame.value(at)),
                    count: count[at],
                    message: message[at].clone(),
                    why: why[at].clone(),
                    remedy: remedy[at].clone(),
                };
                Ok(FaultRow { source: source[at].clone(), name: name[at].clone(), notice })
            })
            .collect()
    }
}
