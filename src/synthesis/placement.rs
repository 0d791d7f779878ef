//! When a donor's motion is laid over a base: by correlation for cyclic donors, at a time for stand donors (GRAFTS 2, 3).

use super::Refusal;
use super::correlation::{CorrelationSettings, Footwork, FrameMap, alternates, frame_map};
use super::subject::Movement;
use serde::{Deserialize, Serialize};

/// How a recipe places its donor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// By ankle passes.
    Correlated {
        /// Which alternate, 0 being the default one.
        alternate: usize,
    },
    /// At the donor's own speed.
    At {
        /// Base time of the first donor frame used.
        time_s: f64,
        /// First donor frame used; with `end`, half-open.
        first: usize,
        /// Donor frame after the last one used.
        end: usize,
    },
}

/// A donor frame for every base frame, and the stretch of time in which it counts.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// Base time at which the donor begins to count.
    pub first_s: f64,
    /// Base time at which it no longer counts.
    pub last_s: f64,
    /// Fractional donor frame of each base frame; held outside the stretch.
    pub donor_frames: Vec<f64>,
}

impl Placement {
    /// The whole donor from a base time on.
    pub fn whole_at(time_s: f64, donor: &Movement) -> Placement {
        Placement::At { time_s, first: 0, end: donor.n_frames() }
    }

    /// The timing that a placement means for a pair.
    ///
    /// # Errors
    /// [`Refusal::TooFewPairs`], [`Refusal::NoSuchAlternate`], [`Refusal::RateOutOfRange`], [`Refusal::BadPlacement`],
    /// [`Refusal::BaseTooShort`]: an action is never cut.
    pub fn timing(&self, base: &Movement, donor: &Movement, settings: &CorrelationSettings) -> Result<Timing, Refusal> {
        match *self {
            Placement::Correlated { alternate } => {
                Timing::correlated(&Footwork::of(base, settings), &Footwork::of(donor, settings), alternate, settings)
            }
            Placement::At { time_s, first, end } => Timing::at(base, donor, time_s, [first, end]),
        }
    }
}

impl Timing {
    /// The timing of an alternate. Errors as [`Placement::timing`].
    pub fn correlated(
        base: &Footwork,
        donor: &Footwork,
        alternate: usize,
        settings: &CorrelationSettings,
    ) -> Result<Timing, Refusal> {
        let found = alternates(base, donor, settings)?;
        let refusal = Refusal::NoSuchAlternate { wanted: alternate, found: found.len() };
        let map = frame_map(found.get(alternate).ok_or(refusal)?, base, donor, settings)?;
        Timing::of_map(&map, base.n_frames(), base.rate_hz)
    }

    /// The timing of donor frames `frames` (half-open) at their own speed from a base time on.
    ///
    /// # Errors
    /// [`Refusal::BadPlacement`], [`Refusal::BaseTooShort`].
    pub fn at(base: &Movement, donor: &Movement, time_s: f64, frames: [usize; 2]) -> Result<Timing, Refusal> {
        let [first, end] = frames;
        // The comparisons are false for NaN.
        if !(time_s >= 0.0 && time_s.is_finite() && first + 1 < end && end <= donor.n_frames()) {
            return Err(Refusal::BadPlacement);
        }
        let last_s = time_s + (end - 1 - first) as f64 / donor.rate_hz;
        let held_s = (base.n_frames() - 1) as f64 / base.rate_hz;
        if last_s > held_s {
            return Err(Refusal::BaseTooShort { needed_s: last_s, held_s });
        }
        let (first, last) = (first as f64, (end - 1) as f64);
        let donor_frames = (0..base.n_frames())
            .map(|frame| first + (frame as f64 / base.rate_hz - time_s) * donor.rate_hz)
            .map(|at| at.clamp(first, last))
            .collect();
        Ok(Timing { first_s: time_s, last_s, donor_frames })
    }

    /// The timing of a map over a base of `n_frames`.
    ///
    /// # Errors
    /// [`Refusal::BadPlacement`]: the map is empty.
    pub fn of_map(map: &FrameMap, n_frames: usize, rate_hz: f64) -> Result<Timing, Refusal> {
        let last = map.donor_frames.len().checked_sub(1).ok_or(Refusal::BadPlacement)?;
        let donor_frames =
            (0..n_frames).map(|frame| map.donor_frames[frame.saturating_sub(map.first).min(last)]).collect();
        let time_s = |frame: usize| frame as f64 / rate_hz;
        Ok(Timing { first_s: time_s(map.first), last_s: time_s(map.first + last), donor_frames })
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::walker::{walker, waver};
    use super::*;

    #[test]
    fn an_action_must_fit_into_its_base() {
        let base = walker(30.0, 91, 1.0).movement;
        let donor = waver(60.0, 121).movement;
        let timing = Timing::at(&base, &donor, 0.5, [0, 121]).unwrap();
        assert_eq!((timing.first_s, timing.last_s), (0.5, 2.5));
        assert_eq!((timing.donor_frames[0], timing.donor_frames[45], timing.donor_frames[90]), (0.0, 60.0, 120.0));
        let refused = Timing::at(&base, &donor, 1.5, [0, 121]).unwrap_err();
        assert_eq!(refused, Refusal::BaseTooShort { needed_s: 3.5, held_s: 3.0 });
        for (time_s, frames) in [(-0.1, [0, 10]), (f64::NAN, [0, 10]), (0.0, [5, 6]), (0.0, [9, 3]), (0.0, [0, 122])] {
            assert_eq!(Timing::at(&base, &donor, time_s, frames), Err(Refusal::BadPlacement), "{time_s} {frames:?}");
        }
    }

    #[test]
    fn an_alternate_that_is_not_there_is_refused_by_number() {
        let base = walker(30.0, 91, 1.0).movement;
        let settings = CorrelationSettings::default();
        let refused = Placement::Correlated { alternate: 99 }.timing(&base, &base, &settings).unwrap_err();
        assert!(matches!(refused, Refusal::NoSuchAlternate { wanted: 99, found: 1.. }), "{refused}");
    }
}
