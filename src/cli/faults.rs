//! Notes, warnings and faults as messages: where, what, why, what to do. Many of one kind are told once, and counted.

use super::numbers::grouped;
use super::output::three_lines;
use crate::corpus::FaultRow;
use crate::motion::Severity;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Of one kind, so many are told in full.
const IN_FULL: usize = 2;
/// And of so many more the places are named.
const NAMED: usize = 5;

/// All messages, the gravest kinds first, then those with most clips.
pub(super) fn text(rows: &[FaultRow]) -> String {
    let mut kinds = BTreeMap::<(Severity, &str), Vec<&FaultRow>>::new();
    for row in rows {
        kinds.entry((row.notice.severity, &row.notice.kind)).or_default().push(row);
    }
    let mut kinds: Vec<((Severity, &str), Vec<&FaultRow>)> = kinds.into_iter().collect();
    kinds.sort_by(|(a, rows_a), (b, rows_b)| b.0.cmp(&a.0).then(rows_b.len().cmp(&rows_a.len())).then(a.1.cmp(b.1)));
    let messages = kinds.iter().map(|((_, kind), rows)| of_kind(kind, rows));
    messages.collect::<Vec<_>>().join("\n") + if rows.is_empty() { "" } else { "\n" }
}

/// The same for programs, with the columns' names of SCHEMA.
pub(super) fn json(rows: &[FaultRow]) -> Value {
    let row = |row: &FaultRow| {
        let notice = &row.notice;
        json!({
            "source": row.source, "name": row.name, "severity": notice.severity.name(), "kind": notice.kind,
            "line": notice.line, "frame": notice.frame, "count": notice.count, "message": notice.message,
            "why": notice.why, "remedy": notice.remedy,
        })
    };
    rows.iter().map(row).collect()
}

/// `source/name:line`.
fn place(row: &FaultRow) -> String {
    let name = match row.source.as_str() {
        "" => row.name.clone(),
        source => format!("{source}/{}", row.name),
    };
    row.notice.line.map_or_else(|| name.clone(), |line| format!("{name}:{line}"))
}

fn of_kind(kind: &str, rows: &[&FaultRow]) -> String {
    // One beyond those told in full would take a line to be left out.
    let in_full = if rows.len() <= IN_FULL + 1 { rows.len() } else { IN_FULL };
    let (told, others) = rows.split_at(in_full);
    let mut text = String::new();
    for row in told {
        let notice = &row.notice;
        let times =
            if notice.count > 1 { format!(" ({} times)", grouped(u64::from(notice.count))) } else { String::new() };
        let what = format!("{}: {}{times}", place(row), notice.message);
        text.push_str(&three_lines(notice.severity.name(), &what, &notice.why, &notice.remedy));
        text.push('\n');
    }
    if !others.is_empty() {
        let named: Vec<String> = others.iter().take(NAMED).map(|row| place(row)).collect();
        let more = if others.len() > NAMED { ", ..." } else { "" };
        let count = grouped(others.len() as u64);
        text.push_str(&format!("  and {count} more of `{kind}`: {}{more}\n", named.join(", ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Notice;

    fn row(name: &str, severity: Severity, kind: &str, line: Option<u32>) -> FaultRow {
        let text = |word: &str| format!("{word} of {kind}");
        let notice = Notice {
            severity,
            kind: kind.to_owned(),
            line,
            frame: None,
            count: 1,
            message: text("what"),
            why: text("why"),
            remedy: text("remedy"),
        };
        FaultRow { source: "cmu".to_owned(), name: name.to_owned(), notice }
    }

    #[test]
    fn the_gravest_come_first_and_many_of_a_kind_are_counted() {
        let mut rows: Vec<FaultRow> =
            (0..12).map(|n| row(&format!("{n:02}"), Severity::Warning, "frames-more", Some(n + 1))).collect();
        rows.push(row("13/13_01", Severity::Fault, "bone-values", Some(10412)));
        rows.push(row("13/", Severity::Note, "rate-guessed", None));
        assert_eq!(
            text(&rows),
            "fault: cmu/13/13_01:10412: what of bone-values\n  why: why of bone-values\n  try: remedy of bone-values\n\n\
             warning: cmu/00:1: what of frames-more\n  why: why of frames-more\n  try: remedy of frames-more\n\
             warning: cmu/01:2: what of frames-more\n  why: why of frames-more\n  try: remedy of frames-more\n  \
             and 10 more of `frames-more`: cmu/02:3, cmu/03:4, cmu/04:5, cmu/05:6, cmu/06:7, ...\n\n\
             note: cmu/13/: what of rate-guessed\n  why: why of rate-guessed\n  try: remedy of rate-guessed\n\n"
        );
        assert_eq!(text(&[]), "");
    }
}
