//! What a body can be asked to do, one act after another, and what it refuses.

use crate::annotate::Foot;
use serde::{Deserialize, Serialize};

/// One thing to do after another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Act {
    /// Both feet stay where they are.
    Stand {
        /// How long, from the moment both feet stand.
        seconds: f64,
    },
    /// One foot is always down.
    Walk {
        /// How long, 1 s or more.
        seconds: f64,
        /// 0.4 to 2.0 m/s.
        speed_mps: f64,
        /// Of the path, to the left, rad/s.
        turn_rate_radps: f64,
    },
    /// A flight between steps.
    Run {
        /// How long, 1 s or more.
        seconds: f64,
        /// 1.6 to 4.0 m/s.
        speed_mps: f64,
        /// Of the path, to the left, rad/s.
        turn_rate_radps: f64,
    },
    /// Off and on again with both feet, from a crouch.
    Jump {
        /// Rise of the body between take-off and the top, 0.03 to 0.6 m.
        height_m: f64,
        /// How far forward, 0 to 1.5 m.
        forward_m: f64,
    },
    /// A walk backwards: the toes strike first, the heel leaves last.
    Back {
        /// How long, 1 s or more.
        seconds: f64,
        /// 0.3 to 1.5 m/s.
        speed_mps: f64,
        /// Of the path, to the left, rad/s.
        turn_rate_radps: f64,
    },
    /// A walk to one side, each foot on its own side of the other one.
    Aside {
        /// How long, 1 s or more.
        seconds: f64,
        /// 0.1 to 0.7 m/s.
        speed_mps: f64,
        /// To which side.
        toward: Foot,
    },
    /// A walk on the spot.
    March {
        /// How long, 1 s or more.
        seconds: f64,
        /// How high the feet are lifted, 0.05 to 0.4 of the leg.
        lift: f64,
    },
    /// A run on the spot.
    Jog {
        /// How long, 1 s or more.
        seconds: f64,
        /// How high the feet are lifted, 0.05 to 0.3 of the leg.
        lift: f64,
    },
    /// A walk up or down a slope, which begins and ends with it.
    Slope {
        /// How long, 1 s or more.
        seconds: f64,
        /// 0.4 to 2.0 m/s over the ground below.
        speed_mps: f64,
        /// Of the ground ahead, -0.2 to 0.2 rad, up positive.
        incline_rad: f64,
    },
    /// Up or down a flight of stairs, a foot a tread, with some level steps before and after.
    Stairs {
        /// Treads to step on, 1 to 40.
        treads: u32,
        /// Of one tread, 0.2 to 0.4 m.
        tread_m: f64,
        /// From tread to tread, -0.22 to 0.22 m, up positive.
        riser_m: f64,
        /// Steps a minute, 50 to 130.
        cadence_spm: f64,
    },
    /// Off and on again with one foot, the other held up; begins and ends with both feet standing.
    Hop {
        /// The foot that hops.
        foot: Foot,
        /// How often, 1 to 40.
        hops: u32,
        /// Rise of the body between take-off and the top, 0.02 to 0.3 m.
        height_m: f64,
        /// How far forward each time, 0 to 0.8 m.
        forward_m: f64,
    },
    /// On one foot, the other lifted: no gait that the labels know.
    Balance {
        /// The foot that is lifted.
        lifted: Foot,
        /// How long, 0.5 s or more.
        seconds: f64,
    },
}

/// What can't be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A plan needs something to do.
    #[error("a plan needs at least one act")]
    Empty,
    /// Some value of an act has no meaning or lies outside what a body does.
    #[error("act {act}: {what} is {found}, must lie in {low} to {high}")]
    Range {
        /// Which act, from 0.
        act: usize,
        /// Which value.
        what: &'static str,
        /// As given.
        found: f64,
        /// Least.
        low: f64,
        /// Most.
        high: f64,
    },
    /// Jumping, hopping and balancing begin from a stand.
    #[error("act {act}: only a stand, a jump or a hop can come before it")]
    NeedsStand {
        /// Which act, from 0.
        act: usize,
    },
}

/// Refuses what has no meaning or lies outside what a body does, naming the act and the value.
pub(super) fn check(acts: &[Act]) -> Result<(), PlanError> {
    if acts.is_empty() {
        return Err(PlanError::Empty);
    }
    let mut standing = true;
    for (act, what) in acts.iter().enumerate() {
        let within = |what, found: f64, low: f64, high: f64| {
            let inside = low <= found && found <= high;
            if inside { Ok(()) } else { Err(PlanError::Range { act, what, found, low, high }) }
        };
        match *what {
            Act::Stand { seconds } => within("seconds", seconds, 0.0, 3600.0)?,
            Act::Walk { seconds, speed_mps, turn_rate_radps } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("speed_mps", speed_mps, 0.4, 2.0)?;
                within("turn_rate_radps", turn_rate_radps, -1.5, 1.5)?;
            }
            Act::Run { seconds, speed_mps, turn_rate_radps } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("speed_mps", speed_mps, 1.6, 4.0)?;
                within("turn_rate_radps", turn_rate_radps, -1.5, 1.5)?;
            }
            Act::Jump { height_m, forward_m } => {
                within("height_m", height_m, 0.03, 0.6)?;
                within("forward_m", forward_m, 0.0, 1.5)?;
            }
            Act::Back { seconds, speed_mps, turn_rate_radps } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("speed_mps", speed_mps, 0.3, 1.5)?;
                within("turn_rate_radps", turn_rate_radps, -1.5, 1.5)?;
            }
            Act::Aside { seconds, speed_mps, .. } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("speed_mps", speed_mps, 0.1, 0.7)?;
            }
            Act::March { seconds, lift } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("lift", lift, 0.05, 0.4)?;
            }
            Act::Jog { seconds, lift } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("lift", lift, 0.05, 0.3)?;
            }
            Act::Slope { seconds, speed_mps, incline_rad } => {
                within("seconds", seconds, 1.0, 3600.0)?;
                within("speed_mps", speed_mps, 0.4, 2.0)?;
                within("incline_rad", incline_rad, -0.2, 0.2)?;
            }
            Act::Stairs { treads, tread_m, riser_m, cadence_spm } => {
                within("treads", f64::from(treads), 1.0, 40.0)?;
                within("tread_m", tread_m, 0.2, 0.4)?;
                within("riser_m", riser_m, -0.22, 0.22)?;
                within("cadence_spm", cadence_spm, 50.0, 130.0)?;
            }
            Act::Hop { hops, height_m, forward_m, .. } => {
                within("hops", f64::from(hops), 1.0, 40.0)?;
                within("height_m", height_m, 0.02, 0.3)?;
                within("forward_m", forward_m, 0.0, 0.8)?;
            }
            Act::Balance { seconds, .. } => within("seconds", seconds, 0.5, 3600.0)?,
        }
        let from_stand = matches!(what, Act::Jump { .. } | Act::Hop { .. } | Act::Balance { .. });
        if !standing && from_stand {
            return Err(PlanError::NeedsStand { act });
        }
        standing = from_stand || matches!(what, Act::Stand { .. });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn walk(seconds: f64, speed_mps: f64) -> Act {
        Act::Walk { seconds, speed_mps, turn_rate_radps: 0.0 }
    }

    fn run(seconds: f64, speed_mps: f64) -> Act {
        Act::Run { seconds, speed_mps, turn_rate_radps: 0.0 }
    }

    #[test]
    fn what_can_t_be_planned_is_refused() {
        let refuse = |acts: &[Act]| check(acts).unwrap_err();
        assert_eq!(refuse(&[]), PlanError::Empty);
        let low = refuse(&[Act::Stand { seconds: 1.0 }, walk(2.0, 0.1)]);
        assert!(matches!(low, PlanError::Range { act: 1, what: "speed_mps", .. }), "{low}");
        assert!(matches!(refuse(&[walk(f64::NAN, 1.0)]), PlanError::Range { what: "seconds", .. }));
        let jump = Act::Jump { height_m: 0.2, forward_m: 0.0 };
        assert_eq!(refuse(&[run(2.0, 3.0), jump]), PlanError::NeedsStand { act: 1 });
        let balance = Act::Balance { lifted: Foot::Left, seconds: 0.1 };
        assert!(matches!(refuse(&[balance]), PlanError::Range { what: "seconds", .. }));
        let hop = |hops| Act::Hop { foot: Foot::Left, hops, height_m: 0.1, forward_m: 0.0 };
        assert!(matches!(refuse(&[hop(0)]), PlanError::Range { what: "hops", .. }));
        assert_eq!(refuse(&[walk(2.0, 1.0), hop(3)]), PlanError::NeedsStand { act: 1 });
        let stairs = Act::Stairs { treads: 5, tread_m: 0.28, riser_m: f64::NAN, cadence_spm: 90.0 };
        assert!(matches!(refuse(&[stairs]), PlanError::Range { what: "riser_m", .. }));
        let slope = Act::Slope { seconds: 2.0, speed_mps: 1.0, incline_rad: 0.5 };
        assert!(matches!(refuse(&[slope]), PlanError::Range { what: "incline_rad", .. }));
        let aside = Act::Aside { seconds: 2.0, speed_mps: 0.9, toward: Foot::Left };
        assert!(matches!(refuse(&[aside]), PlanError::Range { what: "speed_mps", .. }));
    }
}
