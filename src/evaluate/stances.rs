//! Stances of a foot as runs of frames, and which of the found ones are which of the true ones.

use core::ops::Range;

/// Shorter stances are neither missed nor spurious, seconds: flicker of a label counts in the frames that it has.
pub(super) const MIN_STANCE_S: f64 = 0.1;

/// Half a microsecond, to which times are kept: a stance of 3 frames at 30 Hz is not shorter than 0.1 s.
const TOLERANCE_S: f64 = 0.5e-6;

/// A longest run of frames in which a foot is planted.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stance {
    /// Half-open, within the frames that are known.
    pub(super) frames: Range<usize>,
    /// Seconds from frame 0. None: it begins with the frames that are known, so the strike may have been earlier.
    pub(super) strike_s: Option<f64>,
    /// Seconds from frame 0. None: it ends with the frames that are known, so the lift-off may come later.
    pub(super) lift_off_s: Option<f64>,
}

/// The stances of a foot within a range of frames, which is all that is known. A transition lies half a frame before
/// the first frame of what follows it.
///
/// # Shapes and units
/// `planted`: whether the foot is planted in a frame; asked of every frame of `known`, and of no other. `rate_hz` > 0.
pub(super) fn stances(planted: impl Fn(usize) -> bool, known: Range<usize>, rate_hz: f64) -> Vec<Stance> {
    let time_s = |frame: usize| (frame as f64 - 0.5) / rate_hz;
    let mut found = Vec::new();
    let mut first = None;
    for frame in known.clone() {
        match (planted(frame), first) {
            (true, None) => first = Some(frame),
            (false, Some(start)) => {
                let strike_s = (start > known.start).then(|| time_s(start));
                found.push(Stance { frames: start..frame, strike_s, lift_off_s: Some(time_s(frame)) });
                first = None;
            }
            _ => {}
        }
    }
    if let Some(start) = first {
        let strike_s = (start > known.start).then(|| time_s(start));
        found.push(Stance { frames: start..known.end, strike_s, lift_off_s: None });
    }
    found
}

/// Puts true times in the place of those read from frames: where a known strike falls between the last frame before a
/// stance and its first, that is its strike; likewise its lift-off.
///
/// `times_s`: strike and lift-off of each stance, seconds from frame 0, in any order; infinite where there is none.
pub(super) fn refine(stances: &mut [Stance], times_s: &[[f64; 2]], rate_hz: f64) {
    let within = |frame: usize, which: usize| {
        // A foot that strikes at the very time of a frame is planted in it; one that lifts then is not.
        let fits =
            |time_s: f64| time_s * rate_hz > frame as f64 - 1.0 - 1e-9 && time_s * rate_hz <= frame as f64 + 1e-9;
        let times = times_s.iter().map(|times| times[which]).filter(|&time_s| fits(time_s));
        times.min_by(f64::total_cmp)
    };
    for stance in stances {
        for (time_s, frame, which) in
            [(&mut stance.strike_s, stance.frames.start, 0), (&mut stance.lift_off_s, stance.frames.end, 1)]
        {
            if let (Some(time_s), Some(exact_s)) = (time_s, within(frame, which)) {
                *time_s = exact_s;
            }
        }
    }
}

impl Stance {
    /// Whether it counts when stances are counted: both transitions are known, and it lasts [`MIN_STANCE_S`].
    pub(super) fn counts(&self) -> bool {
        match (self.strike_s, self.lift_off_s) {
            (Some(strike_s), Some(lift_off_s)) => lift_off_s - strike_s >= MIN_STANCE_S - TOLERANCE_S,
            _ => false,
        }
    }

    fn overlaps(&self, other: &Stance) -> bool {
        self.frames.start < other.frames.end && other.frames.start < self.frames.end
    }
}

/// For each of `these`, both lists in time: which of `those` overlap it.
pub(super) fn overlaps(these: &[Stance], those: &[Stance]) -> Vec<Range<usize>> {
    let mut from = 0;
    let mut found = Vec::with_capacity(these.len());
    for this in these {
        while those.get(from).is_some_and(|that| that.frames.end <= this.frames.start) {
            from += 1;
        }
        let n = those[from..].iter().take_while(|that| that.overlaps(this)).count();
        found.push(from..from + n);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(marks: &str, rate_hz: f64) -> Vec<Stance> {
        let planted: Vec<bool> = marks.bytes().map(|mark| mark == b'x').collect();
        stances(|frame| planted[frame], 0..planted.len(), rate_hz)
    }

    #[test]
    fn a_transition_lies_half_a_frame_before_its_frame() {
        let found = of("xx..xxx..x", 10.0);
        let stance = |frames, strike_s, lift_off_s| Stance { frames, strike_s, lift_off_s };
        assert_eq!(
            found,
            [stance(0..2, None, Some(0.15)), stance(4..7, Some(0.35), Some(0.65)), stance(9..10, Some(0.85), None)]
        );
        assert!(of("", 30.0).is_empty() && of("....", 30.0).is_empty());
        assert_eq!(of("xxx", 30.0), [stance(0..3, None, None)]);
    }

    #[test]
    fn a_stance_counts_from_a_tenth_of_a_second() {
        for (marks, rate_hz, counts) in [
            (".xxx.", 30.0, true),
            (".xx.", 30.0, false),
            ("xxx.", 30.0, false),
            (".xxx", 30.0, false),
            (".x.", 10.0, true),
            (".xxxxxxxxxxx.", 120.0, false),
            (".xxxxxxxxxxxx.", 120.0, true),
        ] {
            assert_eq!(of(marks, rate_hz)[0].counts(), counts, "{marks} at {rate_hz} Hz");
        }
    }

    #[test]
    fn true_times_replace_those_of_frames() {
        let mut found = of("..xxx..xx", 10.0);
        refine(&mut found, &[[0.12, 0.5], [-1.0, 0.05], [0.9, f64::INFINITY]], 10.0);
        assert_eq!((found[0].strike_s, found[0].lift_off_s), (Some(0.12), Some(0.5)));
        // No known strike lies between frames 6 and 7.
        assert_eq!((found[1].strike_s, found[1].lift_off_s), (Some(0.65), None));
    }

    #[test]
    fn overlaps_are_found_from_both_sides() {
        let (a, b) = (of("xx.xxxx.xx..", 30.0), of(".xxx.xx...xx", 30.0));
        assert_eq!(overlaps(&a, &b), [0..1, 0..2, 2..2]);
        assert_eq!(overlaps(&b, &a), [0..2, 1..2, 3..3]);
    }
}
