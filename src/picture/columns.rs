//! Frames brought to the columns of a page: what a long clip shows where a pixel holds many frames.

use std::ops::Range;

/// Columns that a page has room for.
const MOST_COLUMNS: usize = 1000;

/// Frames side by side, as many in a column as it takes to bring all of them onto the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Columns {
    n_frames: usize,
    per_column: usize,
}

/// Neighboring columns in which something is so, as frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) frames: Range<usize>,
    /// In every frame; else in some frames of each column.
    pub(super) throughout: bool,
}

impl Columns {
    /// Up to twice as many frames as columns are shown one by one: two points a column is what thinning leaves.
    pub(super) fn new(n_frames: usize) -> Columns {
        let per_column = if n_frames <= 2 * MOST_COLUMNS { 1 } else { n_frames.div_ceil(MOST_COLUMNS) };
        Columns { n_frames, per_column }
    }

    /// Frames of a column; the last one may have fewer.
    pub(super) fn per_column(self) -> usize {
        self.per_column
    }

    fn all(self) -> impl Iterator<Item = Range<usize>> {
        let Columns { n_frames, per_column } = self;
        (0..n_frames).step_by(per_column).map(move |first| first..n_frames.min(first + per_column))
    }

    /// Unbroken pieces of a curve, as frame and value: the least and the greatest value of every column, each at its own
    /// frame. A column without a number breaks the curve.
    pub(super) fn curve(self, value: impl Fn(usize) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
        let mut pieces = Vec::new();
        let mut piece = Vec::new();
        for frames in self.all() {
            let mut ends: Option<[(usize, f64); 2]> = None;
            for frame in frames {
                let Some(value) = value(frame).filter(|value| value.is_finite()) else { continue };
                let [least, greatest] = ends.get_or_insert([(frame, value); 2]);
                if value < least.1 {
                    *least = (frame, value);
                }
                if value > greatest.1 {
                    *greatest = (frame, value);
                }
            }
            match ends {
                Some(mut ends) => {
                    ends.sort_by_key(|end| end.0);
                    let [first, last] = ends.map(|(frame, value)| (frame as f64, value));
                    piece.push(first);
                    if first != last {
                        piece.push(last);
                    }
                }
                None if piece.is_empty() => {}
                None => pieces.push(std::mem::take(&mut piece)),
            }
        }
        if !piece.is_empty() {
            pieces.push(piece);
        }
        pieces
    }

    /// Where something is so.
    pub(super) fn runs(self, is_so: impl Fn(usize) -> bool) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for frames in self.all() {
            let count = frames.clone().filter(|&frame| is_so(frame)).count();
            if count == 0 {
                continue;
            }
            let throughout = count == frames.len();
            match runs.last_mut() {
                Some(last) if last.frames.end == frames.start && last.throughout == throughout => {
                    last.frames.end = frames.end;
                }
                _ => runs.push(Run { frames, throughout }),
            }
        }
        runs
    }

    /// What most frames of every column are, the earliest of several; neighbors that are the same together.
    pub(super) fn commonest<T: Copy + PartialEq>(self, what: impl Fn(usize) -> Option<T>) -> Vec<(T, Range<usize>)> {
        let mut found: Vec<(T, Range<usize>)> = Vec::new();
        for frames in self.all() {
            let mut counts: Vec<(T, usize)> = Vec::new();
            for thing in frames.clone().filter_map(&what) {
                match counts.iter_mut().find(|(known, _)| *known == thing) {
                    Some((_, count)) => *count += 1,
                    None => counts.push((thing, 1)),
                }
            }
            // `max_by_key` gives the last of several.
            let Some(&(thing, _)) = counts.iter().rev().max_by_key(|(_, count)| *count) else { continue };
            match found.last_mut() {
                Some((last, range)) if *last == thing && range.end == frames.start => range.end = frames.end,
                _ => found.push((thing, frames)),
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_clip_is_shown_frame_by_frame_and_a_gap_breaks_the_curve() {
        let values = [Some(1.0), Some(2.0), None, Some(f64::NAN), Some(3.0)];
        let columns = Columns::new(values.len());
        assert_eq!(columns.curve(|frame| values[frame]), [vec![(0.0, 1.0), (1.0, 2.0)], vec![(4.0, 3.0)]]);
        let run = |frames| Run { frames, throughout: true };
        assert_eq!(columns.runs(|frame| frame != 2), [run(0..2), run(3..5)]);
        assert_eq!(columns.commonest(|frame| values[frame].map(|_| 'x')), [('x', 0..2), ('x', 3..5)]);
        assert!(Columns::new(0).curve(|_| Some(1.0)).is_empty() && Columns::new(0).runs(|_| true).is_empty());
    }

    #[test]
    fn a_long_clip_keeps_its_extremes_where_they_were() {
        let n_frames = 216_000;
        let columns = Columns::new(n_frames);
        // Two frames stick out of a slope: 3 m up, 2 m down.
        let value = |frame: usize| match frame {
            100_003 => 3.0,
            100_004 => -2.0,
            frame => frame as f64 / n_frames as f64,
        };
        let curve = columns.curve(|frame| Some(value(frame)));
        assert_eq!(curve.len(), 1);
        assert!((MOST_COLUMNS..=2 * MOST_COLUMNS).contains(&curve[0].len()), "{}", curve[0].len());
        assert!(curve[0].windows(2).all(|pair| pair[0].0 < pair[1].0));
        let at = curve[0].iter().position(|point| *point == (100_003.0, 3.0)).unwrap_or(usize::MAX - 1);
        assert_eq!(curve[0].get(at + 1), Some(&(100_004.0, -2.0)));
        assert_eq!(curve[0].first(), Some(&(0.0, 0.0)));
    }

    #[test]
    fn a_column_that_is_partly_so_is_told_from_one_that_is_so_throughout() {
        let columns = Columns::new(4000);
        assert_eq!(columns.per_column(), 4);
        let runs = columns.runs(|frame| (8..18).contains(&frame));
        let run = |frames, throughout| Run { frames, throughout };
        assert_eq!(runs, [run(8..16, true), run(16..20, false)]);
        // Two of four are as many as two of four: the earlier.
        assert_eq!(columns.commonest(|frame| Some(frame < 18)), [(true, 0..20), (false, 20..4000)]);
    }
}
