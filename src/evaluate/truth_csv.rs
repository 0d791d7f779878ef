//! The table of a clip's truth, as people and `motionmill synth` write it: `frame,left,right,gait`.
//!
//! One row a frame, counted from 0, under a header; columns in any order. `left` and `right`: whether the foot is on the
//! ground, `1` or `0` (or `true`, `false`); `gait`: `stand`, `walk`, `run`, `jump` or `unknown`. Any of these three may be
//! left out, and a cell left empty where nobody knows.

use super::frame_truth::FrameTruth;
use crate::annotate::Gait;
use csv::{ReaderBuilder, StringRecord, Trim};

/// A table that can't be used: where, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TruthCsvError {
    /// Line of the file, from 1. None: the file as a whole.
    pub line: Option<u64>,
    /// What is wrong.
    pub mistake: TruthMistake,
}

/// What is wrong with a table of truth. `Display` says what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TruthMistake {
    /// No line with anything on it.
    #[error("there is nothing in it")]
    Empty,
    /// Bytes that are no UTF-8.
    #[error("not UTF-8")]
    NotText,
    /// A column that is none of ours.
    #[error("unknown column `{name}`")]
    UnknownColumn {
        /// As in the header.
        name: String,
    },
    /// A header whose names are not between commas.
    #[error("the header's names are separated by {}", separator_name(*separator))]
    Separator {
        /// What is between them.
        separator: char,
    },
    /// A column that has no name.
    #[error("column {number} has no name")]
    NamelessColumn {
        /// From 1.
        number: usize,
    },
    /// A column that stands there twice.
    #[error("column `{name}` stands there twice")]
    ColumnTwice {
        /// As in the header.
        name: String,
    },
    /// No column `frame`.
    #[error("no column `frame`")]
    NoFrameColumn,
    /// Only a column `frame`.
    #[error("no column `left`, `right` or `gait`")]
    NoTruthColumn,
    /// A row that is longer or shorter than the header.
    #[error("{found} cell{}, the header has {expected} columns", if *found == 1 { "" } else { "s" })]
    CellCount {
        /// In the row.
        found: usize,
        /// In the header.
        expected: usize,
    },
    /// A row that doesn't follow the one before.
    #[error("frame `{found}` where {expected} is due")]
    Frame {
        /// As written, cut off if long.
        found: String,
        /// The frame whose turn it is.
        expected: usize,
    },
    /// A cell of `left` or `right`.
    #[error("`{column}` is `{found}`")]
    Contact {
        /// Which.
        column: &'static str,
        /// As written, cut off if long.
        found: String,
    },
    /// A cell of `gait`.
    #[error("`gait` is `{found}`")]
    Gait {
        /// As written, cut off if long.
        found: String,
    },
}

impl TruthMistake {
    /// Why the table can't be used so.
    pub fn why(&self) -> &'static str {
        match self {
            TruthMistake::Empty | TruthMistake::NotText | TruthMistake::NoFrameColumn => {
                "truth is a table in CSV: a header, then one row a frame"
            }
            TruthMistake::Separator { .. } => "cells are separated by commas, so this is one column of an unknown name",
            TruthMistake::UnknownColumn { .. } | TruthMistake::NamelessColumn { .. } => {
                "the columns are `frame`, `left`, `right` and `gait`"
            }
            TruthMistake::ColumnTwice { .. } => "it would be unclear which of the two counts",
            TruthMistake::NoTruthColumn => "it says nothing of contacts and nothing of gaits",
            TruthMistake::CellCount { .. } => "what stands in which column can't be told",
            TruthMistake::Frame { .. } => "rows are the clip's frames from 0 on, one after the other, none left out",
            TruthMistake::Contact { .. } => "a foot is on the ground, `1`, or it is not, `0`",
            TruthMistake::Gait { .. } => "a frame's gait is `stand`, `walk`, `run`, `jump` or `unknown`",
        }
    }

    /// What to do.
    pub fn remedy(&self) -> String {
        match self {
            TruthMistake::Empty | TruthMistake::NoFrameColumn => {
                "a header with frame,left,right,gait; the last three as far as they are known".to_owned()
            }
            TruthMistake::NotText => "save it as UTF-8, with commas between the cells".to_owned(),
            TruthMistake::UnknownColumn { name } => format!("take `{name}` out, or give it one of these names"),
            TruthMistake::Separator { .. } => "save it with commas between the cells: frame,left,right,gait".to_owned(),
            TruthMistake::NamelessColumn { number } => {
                format!("take column {number} out of every row, commas at the ends of lines too, or name it")
            }
            TruthMistake::ColumnTwice { name } => format!("take one `{name}` out"),
            TruthMistake::NoTruthColumn => "one of these columns at least".to_owned(),
            TruthMistake::CellCount { expected, .. } => {
                format!("{expected} cells in every row; empty where nobody knows")
            }
            TruthMistake::Frame { expected, .. } => {
                format!("a row for frame {expected}, with empty cells where nobody knows")
            }
            TruthMistake::Contact { .. } => "1 or 0, or an empty cell where nobody knows".to_owned(),
            TruthMistake::Gait { .. } => "one of these words, or an empty cell where nobody knows".to_owned(),
        }
    }
}

/// Which column of the file holds what.
#[derive(Clone, Copy, Debug, Default)]
struct Columns {
    frame: usize,
    feet: [Option<usize>; 2],
    gait: Option<usize>,
}

const FEET: [&str; 2] = ["left", "right"];

/// Reads the bytes of a table of truth. Takes any bytes.
///
/// # Errors
/// [`TruthCsvError`], the first that there is.
///
/// # Example
/// ```
/// use motionmill::evaluate::read_truth_csv;
/// let truth = read_truth_csv(b"frame,left,right\n0,1,0\n1,1,\n").unwrap();
/// assert_eq!(truth.n_frames, 2);
/// assert_eq!(truth.planted[1], Some(vec![Some(false), None]));
/// assert_eq!(truth.gait, None);
/// ```
pub fn read_truth_csv(bytes: &[u8]) -> Result<FrameTruth, TruthCsvError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Err(error) = std::str::from_utf8(bytes) {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count() as u64;
        return Err(TruthCsvError { line: Some(line), mistake: TruthMistake::NotText });
    }
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).trim(Trim::All).from_reader(bytes);
    let mut record = StringRecord::new();
    if !next(&mut reader, &mut record)? {
        return Err(TruthCsvError { line: None, mistake: TruthMistake::Empty });
    }
    let n_columns = record.len();
    let columns = columns(&record).map_err(|mistake| TruthCsvError { line: line_of(&record, bytes), mistake })?;
    let mut truth = FrameTruth {
        planted: columns.feet.map(|column| column.map(|_| Vec::new())),
        gait: columns.gait.map(|_| Vec::new()),
        ..FrameTruth::default()
    };
    while next(&mut reader, &mut record)? {
        let row = if record.len() == n_columns {
            add_row(&mut truth, &record, columns)
        } else {
            Err(TruthMistake::CellCount { found: record.len(), expected: n_columns })
        };
        row.map_err(|mistake| TruthCsvError { line: line_of(&record, bytes), mistake })?;
    }
    Ok(truth)
}

/// Reads a row; false: there is none left.
fn next(reader: &mut csv::Reader<&[u8]>, record: &mut StringRecord) -> Result<bool, TruthCsvError> {
    reader.read_record(record).map_err(|error| {
        let line = error.position().map(csv::Position::line);
        TruthCsvError { line, mistake: TruthMistake::NotText }
    })
}

/// The line that a record begins on. Its position may still be before the rest of a line's end, or before empty lines.
fn line_of(record: &StringRecord, bytes: &[u8]) -> Option<u64> {
    let position = usize::try_from(record.position()?.byte()).ok()?;
    let blank = bytes.get(position..)?.iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    let before = bytes.get(..position + blank)?;
    let ends = before.iter().enumerate().filter(|&(at, &byte)| match byte {
        b'\n' => true,
        b'\r' => before.get(at + 1) != Some(&b'\n'),
        _ => false,
    });
    Some(1 + ends.count() as u64)
}

fn columns(header: &StringRecord) -> Result<Columns, TruthMistake> {
    let mut columns = Columns::default();
    let mut frame = None;
    for (at, name) in header.iter().enumerate() {
        let place = match name {
            "frame" => &mut frame,
            "left" => &mut columns.feet[0],
            "right" => &mut columns.feet[1],
            "gait" => &mut columns.gait,
            "" => return Err(TruthMistake::NamelessColumn { number: at + 1 }),
            _ => return Err(unknown_column(name)),
        };
        if place.replace(at).is_some() {
            return Err(TruthMistake::ColumnTwice { name: name.to_owned() });
        }
    }
    let Columns { feet, gait, .. } = columns;
    if feet == [None; 2] && gait.is_none() && frame.is_some() {
        return Err(TruthMistake::NoTruthColumn);
    }
    frame.map(|frame| Columns { frame, ..columns }).ok_or(TruthMistake::NoFrameColumn)
}

/// A name that is none of ours, or several between which there is something else than commas.
fn unknown_column(name: &str) -> TruthMistake {
    let is_ours = |part: &str| ["frame", "left", "right", "gait"].contains(&part.trim().trim_matches('"'));
    let splits = |separator: &char| name.contains(*separator) && name.split(*separator).any(is_ours);
    match [';', '\t'].into_iter().find(splits) {
        Some(separator) => TruthMistake::Separator { separator },
        None => TruthMistake::UnknownColumn { name: quoted(name) },
    }
}

fn separator_name(separator: char) -> String {
    if separator == '\t' { "tabs".to_owned() } else { format!("`{separator}`") }
}

fn add_row(truth: &mut FrameTruth, row: &StringRecord, columns: Columns) -> Result<(), TruthMistake> {
    let cell = |column: usize| row.get(column).unwrap_or_default();
    let frame = cell(columns.frame);
    if frame.parse() != Ok(truth.n_frames) {
        return Err(TruthMistake::Frame { found: quoted(frame), expected: truth.n_frames });
    }
    for ((planted, column), name) in truth.planted.iter_mut().zip(columns.feet).zip(FEET) {
        let (Some(planted), Some(column)) = (planted, column) else { continue };
        planted.push(match cell(column) {
            "" => None,
            "1" | "true" | "True" | "TRUE" => Some(true),
            "0" | "false" | "False" | "FALSE" => Some(false),
            other => return Err(TruthMistake::Contact { column: name, found: quoted(other) }),
        });
    }
    if let (Some(gaits), Some(column)) = (&mut truth.gait, columns.gait) {
        gaits.push(match cell(column) {
            "" | "unknown" => Gait::Unknown,
            "stand" => Gait::Stand,
            "walk" => Gait::Walk,
            "run" => Gait::Run,
            "jump" => Gait::Jump,
            other => return Err(TruthMistake::Gait { found: quoted(other) }),
        });
    }
    truth.n_frames += 1;
    Ok(())
}

/// A cell for a message: on one line, not longer than it.
fn quoted(cell: &str) -> String {
    const MOST: usize = 40;
    let line: String = cell.chars().take(MOST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if cell.chars().count() > MOST { line + "..." } else { line }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn refused(text: &str, line: Option<u64>, what: &str) {
        let error = read_truth_csv(text.as_bytes()).unwrap_err();
        assert_eq!((error.line, error.mistake.to_string().as_str()), (line, what), "{text:?}");
        assert!(!error.mistake.why().is_empty() && !error.mistake.remedy().is_empty());
    }

    #[test]
    fn columns_come_in_any_order_and_may_be_missing() {
        let whole = read_truth_csv(b"gait,right,frame,left\nwalk,0,0,1\nunknown,1,1,0\n").unwrap();
        assert_eq!(whole.planted, [Some(vec![Some(true), Some(false)]), Some(vec![Some(false), Some(true)])]);
        assert_eq!(whole.gait, Some(vec![Gait::Walk, Gait::Unknown]));
        let gait = read_truth_csv(b"frame,gait\n0,stand\n1,run\n2,jump\n3,\n").unwrap();
        assert_eq!(gait.gait, Some(vec![Gait::Stand, Gait::Run, Gait::Jump, Gait::Unknown]));
        assert!(gait.planted == [None, None] && gait.n_frames == 4);
        let left = read_truth_csv(b"frame,left\n0,true\n1,False\n2,\n").unwrap();
        assert_eq!(left.planted, [Some(vec![Some(true), Some(false), None]), None]);
        assert_eq!(read_truth_csv(b"frame,left").unwrap().n_frames, 0);
    }

    #[test]
    fn what_spreadsheets_do_to_a_file_does_not_matter() {
        let plain = read_truth_csv(b"frame,left,gait\n0,1,walk\n1,0,run\n").unwrap();
        for text in [
            "frame,left,gait\r\n0,1,walk\r\n1,0,run\r\n",
            "\u{feff}frame,left,gait\n0,1,walk\n1,0,run",
            "\"frame\",\"left\",\"gait\"\n\"0\",\"1\",\"walk\"\n 1 , 0 , run \n",
            "frame,left,gait\n\n0,1,walk\n\n1,0,run\n\n",
        ] {
            assert_eq!(read_truth_csv(text.as_bytes()).as_ref(), Ok(&plain), "{text:?}");
        }
    }

    #[test]
    fn every_mistake_is_named_at_its_line() {
        refused("", None, "there is nothing in it");
        refused("\n\n", None, "there is nothing in it");
        refused("left,right\n1,0\n", Some(1), "no column `frame`");
        refused("frame;left;right\n0;1;0\n", Some(1), "the header's names are separated by `;`");
        refused("\"frame\";\"gait\"\n0;walk\n", Some(1), "the header's names are separated by `;`");
        refused("frame\tleft\n0\t1\n", Some(1), "the header's names are separated by tabs");
        refused("frame,le;ft\n0,1\n", Some(1), "unknown column `le;ft`");
        refused("frame,left,\n0,1,\n", Some(1), "column 3 has no name");
        refused(",frame,left\n0,0,1\n", Some(1), "column 1 has no name");
        refused("frame\n0\n", Some(1), "no column `left`, `right` or `gait`");
        refused("frame,lefft\n0,1\n", Some(1), "unknown column `lefft`");
        refused("frame,left,left\n0,1,1\n", Some(1), "column `left` stands there twice");
        refused("frame,left\n0,1\n1\n", Some(3), "1 cell, the header has 2 columns");
        refused("frame,left\r\n0,1\r\n1,1,1\r\n", Some(3), "3 cells, the header has 2 columns");
        refused("frame,left\n\n\n0,1\n\n1\n", Some(6), "1 cell, the header has 2 columns");
        refused("frame,left\r0,1\r1\r", Some(3), "1 cell, the header has 2 columns");
        refused("frame,left\n1,1\n", Some(2), "frame `1` where 0 is due");
        refused("frame,left\n0,1\n0,1\n", Some(3), "frame `0` where 1 is due");
        refused("frame,left\n0,1\n2,1\n", Some(3), "frame `2` where 1 is due");
        refused("frame,left\n0,1\nx,1\n", Some(3), "frame `x` where 1 is due");
        refused("frame,left\n0,2\n", Some(2), "`left` is `2`");
        refused("frame,right\n0,yes\n", Some(2), "`right` is `yes`");
        refused("frame,gait\n0,walk\n1,other\n", Some(3), "`gait` is `other`");
        refused("frame,gait\n0,Walk\n", Some(2), "`gait` is `Walk`");
        refused(&format!("frame,gait\n0,{}\n", "a".repeat(99)), Some(2), &format!("`gait` is `{}...`", "a".repeat(40)));
        let bytes = read_truth_csv(b"frame,gait\n0,walk\n1,w\xfflk\n").unwrap_err();
        assert_eq!(bytes, TruthCsvError { line: Some(3), mistake: TruthMistake::NotText });
    }

    proptest! {
        #[test]
        fn any_bytes_give_rows_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = read_truth_csv(&bytes);
        }

        #[test]
        fn what_is_nearly_a_table_gives_rows_or_an_error(
            text in "(frame|left|right|gait|,){1,7}\n([0-3]|walk|run|true|,|\"|\r|\n| ){0,40}"
        ) {
            if let Ok(truth) = read_truth_csv(text.as_bytes()) {
                let lengths = truth.planted.iter().flatten().map(Vec::len).chain(truth.gait.iter().map(Vec::len));
                prop_assert!(lengths.into_iter().all(|length| length == truth.n_frames));
            }
        }

        #[test]
        fn rows_read_back_as_written(rows in prop::collection::vec((any::<bool>(), prop::option::of(any::<bool>()), 0_usize..5), 0..50)) {
            let mut text = "frame,left,right,gait\n".to_owned();
            let gaits = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump];
            for (frame, (left, right, gait)) in rows.iter().enumerate() {
                let right = right.map_or(String::new(), |right| u8::from(right).to_string());
                text += &format!("{frame},{},{right},{}\n", u8::from(*left), gaits[*gait].name());
            }
            let truth = read_truth_csv(text.as_bytes()).unwrap();
            prop_assert_eq!(truth.n_frames, rows.len());
            prop_assert_eq!(truth.planted[0].clone().unwrap(), rows.iter().map(|row| Some(row.0)).collect::<Vec<_>>());
            prop_assert_eq!(truth.planted[1].clone().unwrap(), rows.iter().map(|row| row.1).collect::<Vec<_>>());
            prop_assert_eq!(truth.gait.unwrap(), rows.iter().map(|row| gaits[row.2]).collect::<Vec<_>>());
        }
    }
}
