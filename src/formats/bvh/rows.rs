//! The rows of the MOTION section: as many numbers a line as the hierarchy has channels.
//!
//! The fast loop reads whole rows into place. Where the first row is short, frames are broken over lines: that
//! is accepted if every frame is broken alike and their number is the one promised, which a damaged file can't
//! imitate.

use crate::formats::finding::{Deviation, Finding, Findings};
use crate::formats::number::{self, narrow, scan};
use crate::formats::text::{excerpt, is_blank, is_line_end, line_at, line_end, skip_blanks, word_end, words};
use crate::motion::Skeleton;

/// All frames.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) n_frames: usize,
    pub(super) channels: Vec<f32>,
    pub(super) max_rounding: f64,
}

struct Reader<'a> {
    bytes: &'a [u8],
    skeleton: &'a Skeleton,
    width: usize,
    rows: Rows,
}

/// Reads from `at` to the end of the bytes. `said`: the count of `Frames:`.
pub(super) fn read(
    bytes: &[u8],
    at: usize,
    skeleton: &Skeleton,
    said: u64,
    findings: &mut Findings,
) -> Result<Rows, Finding> {
    let width = skeleton.n_channels();
    let mut reader = Reader { bytes, skeleton, width, rows: Rows::default() };
    // A number and a blank are two bytes: what `Frames:` promises beyond that is not there.
    let promised = usize::try_from(said).unwrap_or(usize::MAX).saturating_mul(width);
    reader.rows.channels.reserve_exact(promised.min((bytes.len() - at) / 2 + 1));
    let first = skip_space(bytes, at);
    let first_count = words(&bytes[first..line_end(bytes, first)]).take(width.saturating_add(1)).count();
    if first_count > 0 && first_count < width && !reader.is_trailing(first, said) {
        reader.wrapped(first, said, findings)?;
    } else {
        reader.whole(first, said, findings)?;
    }
    Ok(reader.rows)
}

impl Reader<'_> {
    /// One frame a line.
    fn whole(&mut self, mut at: usize, said: u64, findings: &mut Findings) -> Result<(), Finding> {
        loop {
            at = skip_space(self.bytes, at);
            if at == self.bytes.len() {
                return Ok(());
            }
            if self.is_trailing(at, said) {
                findings.add(self.trailing(at));
                return Ok(());
            }
            at = self.row(at)?;
        }
    }

    /// The row that begins at `row_at`, which holds no blank. Returns where its line ends.
    #[inline]
    fn row(&mut self, row_at: usize) -> Result<usize, Finding> {
        let Reader { bytes, width, rows: Rows { channels, max_rounding, .. }, .. } = self;
        let from = channels.len();
        channels.resize(from + *width, 0.0);
        let mut at = row_at;
        let mut worst = *max_rounding;
        for channel in &mut channels[from..] {
            let Some((value, end)) = scan(bytes, at) else {
                return Err(self.bad_row(row_at));
            };
            *channel = narrow(value, bytes, at, end);
            // Infinite for what f32 can't hold, caught below.
            worst = worst.max((value - f64::from(*channel)).abs());
            at = match bytes.get(end) {
                Some(b' ') if bytes.get(end + 1).is_some_and(|&next| next > b' ') => end + 1,
                Some(&byte) if is_blank(byte) => skip_blanks(bytes, end),
                Some(&byte) if !is_line_end(byte) => return Err(self.bad_row(row_at)),
                _ => end,
            };
        }
        if !worst.is_finite() || bytes.get(at).is_some_and(|&byte| !is_line_end(byte)) {
            return Err(self.bad_row(row_at));
        }
        *max_rounding = worst;
        self.rows.n_frames += 1;
        Ok(at)
    }

    /// What is wrong with a row: its first bad number, else its length.
    #[cold]
    fn bad_row(&self, row_at: usize) -> Finding {
        let line = &self.bytes[row_at..line_end(self.bytes, row_at)];
        let at_line = line_at(self.bytes, row_at);
        let frame = self.rows.n_frames;
        for (column, word) in words(line).enumerate() {
            if number::parse_in_f32(word).is_none() {
                return self.bad_number(word, column).at(at_line).in_frame(frame);
            }
        }
        let what = Deviation::RowWidth { expected: self.width, found: words(line).count() };
        Finding::new(at_line, what).in_frame(frame)
    }

    fn bad_number(&self, word: &[u8], column: usize) -> Finding {
        let channels = self.skeleton.joints.iter().flat_map(|joint| joint.channels.iter().map(move |c| (joint, c)));
        let place = match channels.clone().nth(column) {
            Some((joint, channel)) => {
                format!("column {} (`{}.{}`)", column + 1, excerpt(joint.name.as_bytes()), channel.name())
            }
            None => format!("column {}", column + 1),
        };
        Finding::new(0, Deviation::BadNumber { flaw: number::flaw(word), place, found: excerpt(word) })
    }

    /// Frames broken over lines, all alike, as many as promised.
    fn wrapped(&mut self, first: usize, said: u64, findings: &mut Findings) -> Result<(), Finding> {
        // Numbers on each line of a frame, from the first frame; then the place in it.
        let mut pattern: Vec<usize> = Vec::new();
        let mut place = 0;
        let mut filled = 0;
        let mut line_from = first;
        let mut frame_line = 0;
        loop {
            line_from = skip_space(self.bytes, line_from);
            let over = line_from == self.bytes.len();
            if over || (filled == 0 && self.is_trailing(line_from, said)) {
                if filled > 0 || self.rows.n_frames as u64 != said {
                    return Err(self.short_row(first, 0));
                }
                if !over {
                    findings.add(self.trailing(line_from));
                }
                return Ok(());
            }
            let line = &self.bytes[line_from..line_end(self.bytes, line_from)];
            let mut n_words = 0;
            for word in words(line) {
                let Some(value) = number::parse_in_f32(word) else {
                    let found = self.bad_number(word, filled + n_words);
                    return Err(found.at(line_at(self.bytes, line_from)).in_frame(self.rows.n_frames));
                };
                let narrowed = narrow(value, word, 0, word.len());
                self.rows.channels.push(narrowed);
                self.rows.max_rounding = self.rows.max_rounding.max((value - f64::from(narrowed)).abs());
                n_words += 1;
            }
            filled += n_words;
            if self.rows.n_frames == 0 {
                pattern.push(n_words);
            } else if place == 0 {
                frame_line = line_from;
            }
            let broken = filled > self.width || (self.rows.n_frames > 0 && pattern.get(place) != Some(&n_words));
            if broken {
                // One frame alone is no pattern: then its first row is short, and nothing is wrapped.
                let (at, frame) = if self.rows.n_frames > 1 { (frame_line, self.rows.n_frames) } else { (first, 0) };
                return Err(self.short_row(at, frame));
            }
            place += 1;
            if filled == self.width {
                self.rows.n_frames += 1;
                (filled, place) = (0, 0);
            }
            line_from += line.len();
        }
    }

    fn short_row(&self, at: usize, frame: usize) -> Finding {
        let line = &self.bytes[at..line_end(self.bytes, at)];
        let what = Deviation::RowWidth { expected: self.width, found: words(line).count() };
        Finding::new(line_at(self.bytes, at), what).in_frame(frame)
    }

    /// Whether the promised rows are there and no number stands at `at`.
    #[inline]
    fn is_trailing(&self, at: usize, said: u64) -> bool {
        self.rows.n_frames as u64 >= said && {
            let word = &self.bytes[at..word_end(self.bytes, at)];
            number::parse(word).is_none()
        }
    }

    fn trailing(&self, at: usize) -> Finding {
        let rest = &self.bytes[at..];
        let what = if rest[0] == 0 {
            Deviation::TrailingNul { bytes: rest.len() }
        } else {
            Deviation::TrailingText { bytes: rest.len(), found: excerpt(&rest[..line_end(rest, 0)]) }
        };
        Finding::new(line_at(self.bytes, at), what)
    }
}

/// First position from `at` on that is neither blank nor line end.
#[inline]
fn skip_space(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(|&byte| is_blank(byte) || is_line_end(byte)) {
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use crate::formats::{Deviation, Finding, Motion, ReadOptions, read_bvh};

    /// Four channels, `said` frames, these rows.
    fn read(said: usize, rows: &str) -> Result<(Motion, Vec<Finding>), Finding> {
        let text = format!(
            "HIERARCHY\nROOT a\n{{\nOFFSET 0 0 0\nCHANNELS 4 Xposition Zrotation Xrotation Yrotation\n}}\nMOTION\n\
             Frames: {said}\nFrame Time: 1\n{rows}"
        );
        read_bvh(text.as_bytes(), &ReadOptions::default()).map(|reading| (reading.value, reading.findings))
    }

    /// The line within the rows, from 1, and the count found there.
    fn width_fault(said: usize, rows: &str) -> (u32, usize) {
        let fault = read(said, rows).unwrap_err();
        let Deviation::RowWidth { expected: 4, found } = fault.what else { panic!("{fault}") };
        (fault.line - 9, found)
    }

    #[test]
    fn frames_broken_alike_are_read() {
        for rows in ["1 2\n3 4\n5 6\n7 8\n", "1\n2 3 4\n\n5\n6 7 8", "1 2 3\n4\n5 6 7\n8\nthe end\n"] {
            let (motion, findings) = read(2, rows).unwrap();
            assert_eq!(motion.channels, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
            assert_eq!(findings.len(), usize::from(rows.ends_with("end\n")));
        }
    }

    #[test]
    fn a_row_of_another_length_is_named() {
        assert_eq!(width_fault(3, "1 2 3 4\n5 6 7\n1 2 3 4\n"), (2, 3));
        assert_eq!(width_fault(3, "1 2 3\n1 2 3 4\n1 2 3 4\n"), (1, 3));
        assert_eq!(width_fault(2, "1 2\n3 4\n5 6 7\n8\n"), (1, 2));
        assert_eq!(width_fault(3, "1 2\n3 4\n5 6\n7 8\n5 6 7\n8\n"), (5, 3));
        // Half as many frames as promised: more likely half as many channels.
        assert_eq!(width_fault(4, "1 2\n3 4\n5 6\n7 8\n"), (1, 2));
        assert_eq!(width_fault(1, "1 2 3 4 5\n"), (1, 5));
    }

    #[test]
    fn a_bad_number_is_named_with_its_channel() {
        for (row, found) in [("1 2 nan 4", "nan"), ("1 2 1e39 4", "1e39"), ("1 2 3,5 4", "3,5"), ("1 2 - 4", "-")] {
            let fault = read(1, row).unwrap_err();
            assert_eq!((fault.line, fault.frame), (10, Some(0)));
            let place = "column 3 (`a.Xrotation`)".to_owned();
            assert!(
                matches!(&fault.what, Deviation::BadNumber { place: p, found: f, .. } if *p == place && f == found),
                "{fault}"
            );
        }
    }

    #[test]
    fn rounding_is_measured() {
        let (motion, _) = read(1, "0.1 16777217 0.5 2").unwrap();
        assert_eq!(motion.max_rounding, 1.0);
        assert_eq!(motion.channels, [0.1, 16777216.0, 0.5, 2.0]);
    }
}
