//! The footstep plan: when each foot strikes and lifts, where it stands, and which gait that is.
//!
//! The plan comes first and knows nothing of poses; legs, pelvis and arms are made to follow it, and the ground
//! truth of a clip is read from it alone.

use super::act::{Act, PlanError, check};
use super::draws::Draws;
use super::pace::{GRAVITY_MPS2, Pace};
use super::path::{Knots, Path};
use super::planner::footsteps;
use crate::annotate::{Foot, Gait};
use serde::{Deserialize, Serialize};

/// What the mover's body and taste put into a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Footing {
    /// From hip joint to the ground, metres.
    pub leg_m: f64,
    /// Multiplies the usual step rate.
    pub cadence: f64,
    /// Multiplies the usual step width.
    pub step_width: f64,
    /// Feet turned outwards, radians.
    pub toe_out_rad: f64,
    /// Added to the usual duty factor.
    pub duty: f64,
    /// Share of half a stride that the left foot's strikes come early by (`Style::limp`).
    pub limp: f64,
    /// Multiplies the pitch of the foot at its strike.
    pub heel_strike: f64,
    /// Multiplies the height of a swing over its arc.
    pub clearance: f64,
}

/// How a foot rolls on and off the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roll {
    /// Pitch of the foot at its strike, radians, toes up positive: about the heel when positive, about the ball else.
    pub strike_pitch_rad: f64,
    /// Seconds from the strike until the foot is flat.
    pub landing_s: f64,
    /// Heel rise at the lift-off, radians, about the ball; negative: the toes rise about the heel.
    pub push_pitch_rad: f64,
    /// Seconds from the first rise of the heel to the lift-off.
    pub push_s: f64,
}

/// What a foot does between this stance and the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Swing {
    /// A step of a walk.
    Walk,
    /// A step of a run.
    Run,
    /// Both feet are off the ground.
    Jump,
    /// Held up while the body stands on the other foot.
    Hold,
    /// Held up while the body hops on the other foot.
    Hop,
    /// To a tread of another height: up before forward, or forward before down.
    Stair,
}

/// One foot on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// First touch, seconds from the clip's first frame.
    pub strike_s: f64,
    /// Leaves the ground; infinite for a foot that stays.
    pub lift_s: f64,
    /// The path's point that the foot stands beside is that of this time.
    pub beside_s: f64,
    /// Sideways distance from the path, metres, at least 0.
    pub half_width_m: f64,
    /// Where the middle of the ankle stands on the ground while the foot is flat: x, z.
    pub place_m: [f64; 2],
    /// Height of the ground there.
    pub ground_m: f64,
    /// Of the ground along the foot, radians, rising towards the toes positive.
    pub slope_rad: f64,
    /// Direction of the foot, radians from +Z towards +X.
    pub yaw_rad: f64,
    /// How it rolls.
    pub roll: Roll,
    /// How it moves on.
    pub swing: Swing,
    /// How much higher than usual it is lifted then, metres.
    pub lift_m: f64,
    /// Multiplies the usual height of that swing over its arc.
    pub clearance: f64,
}

/// A stretch of one gait: half-open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Its class.
    pub gait: Gait,
    /// Seconds.
    pub start_s: f64,
    /// Seconds.
    pub end_s: f64,
}

/// Both feet off the ground: half-open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Seconds.
    pub takeoff_s: f64,
    /// Seconds.
    pub landing_s: f64,
    /// What it belongs to.
    pub leap: Leap,
}

/// What flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leap {
    /// From foot to foot.
    Step,
    /// From both feet to both.
    Jump,
    /// From a foot to the same foot.
    Hop,
}

/// A footstep plan; times in seconds from the clip's first frame, with some strides before and after the clip.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Length of the clip.
    pub duration_s: f64,
    /// Without gaps, covering the clip.
    pub phases: Vec<Phase>,
    /// Left, right; in order of time.
    pub stances: [Vec<Stance>; 2],
    /// The body's way over the ground.
    pub path: Path,
    /// Height of the stairs below the body over time, straight from tread to tread, metres.
    pub stairs: Knots,
    /// Phase of the stride: whole numbers where the left foot strikes, halves where the right one does.
    pub stride: Knots,
    /// Stride time, seconds.
    pub paces: Vec<(f64, Pace)>,
}

/// Time from the start of the crouch to the take-off of a jump, seconds.
pub const CROUCH_S: f64 = 0.6;
/// Time from landing to standing again, seconds.
pub const RECOVERY_S: f64 = 0.6;
/// The ankle is below the hips after this share of a walk's stance; of a run's.
pub(super) const MID_STANCE: [f64; 2] = [0.40, 0.32];
/// Time from the beginning of a hop's dip to its take-off, and from its last landing to a quiet stand on that foot, seconds.
pub const DIP_S: f64 = 0.45;

/// Plans footsteps for `acts`, one after the other, beginning at the origin with heading `yaw_rad` (from +Z towards +X).
///
/// `draws` decide the first foot and the phase of the stride at the first frame, nothing else.
///
/// # Errors
/// [`PlanError`] for an empty list, a value out of range, a jump, hop or balance that follows no stand.
pub fn plan(acts: &[Act], footing: &Footing, yaw_rad: f64, draws: &mut Draws) -> Result<Plan, PlanError> {
    check(acts)?;
    Ok(footsteps(acts, footing, yaw_rad, draws))
}

impl Plan {
    /// Whether a foot is on the ground.
    pub fn contact(&self, foot: Foot, time_s: f64) -> bool {
        let stances = &self.stances[foot as usize];
        stances.iter().any(|stance| stance.strike_s <= time_s && time_s < stance.lift_s)
    }

    /// The gait at a time.
    pub fn gait(&self, time_s: f64) -> Gait {
        let phase = self.phases.iter().rev().find(|phase| phase.start_s <= time_s);
        phase.or(self.phases.first()).map_or(Gait::Unknown, |phase| phase.gait)
    }

    /// The pace in force at a time, if the body has stepped yet.
    pub fn pace(&self, time_s: f64) -> Option<Pace> {
        self.paces.iter().rev().find(|(start_s, _)| *start_s <= time_s).or(self.paces.first()).map(|(_, pace)| *pace)
    }

    /// Height of the ground below the body.
    pub fn ground_m(&self, time_s: f64) -> f64 {
        self.path.at(time_s).rise_m + self.stairs.linear(time_s)
    }

    /// Whether a foot is held up for the other one's hops.
    fn held(&self, foot: usize, time_s: f64) -> bool {
        let stances = &self.stances[foot];
        let before = stances.partition_point(|stance| stance.strike_s <= time_s).checked_sub(1);
        before.is_some_and(|before| stances[before].swing == Swing::Hop && stances[before].lift_s <= time_s)
    }

    /// The times in which no foot is on the ground, within the planned time.
    pub fn flights(&self) -> Vec<Flight> {
        let mut flights = Vec::new();
        for (side, stances) in self.stances.iter().enumerate() {
            for pair in stances.windows(2) {
                let takeoff_s = pair[0].lift_s;
                // The other foot's last lift-off may come later: then the flight is found from that foot.
                if self.stances[1 - side].iter().any(|s| s.strike_s <= takeoff_s && takeoff_s < s.lift_s) {
                    continue;
                }
                let landing_s = self.stances.iter().flatten().map(|s| s.strike_s).filter(|&t| t > takeoff_s);
                let landing_s = landing_s.fold(f64::INFINITY, f64::min);
                let leap = match (pair[0].swing, self.held(1 - side, takeoff_s)) {
                    (Swing::Jump, false) => Leap::Jump,
                    (Swing::Jump, true) => Leap::Hop,
                    _ => Leap::Step,
                };
                flights.push(Flight { takeoff_s, landing_s, leap });
            }
        }
        flights.sort_by(|a, b| a.takeoff_s.total_cmp(&b.takeoff_s));
        flights.dedup_by(|a, b| a.takeoff_s == b.takeoff_s);
        flights
    }
}

/// Duration of a jump's flight and its speed at take-off, for a rise and a body that lands a little lower than it took off.
pub fn jump_flight(height_m: f64, leg_m: f64) -> (f64, f64) {
    let takeoff_mps = libm::sqrt(2.0 * GRAVITY_MPS2 * height_m);
    let drop_m = JUMP_DROP * leg_m;
    let flight_s = (takeoff_mps + libm::sqrt(takeoff_mps * takeoff_mps + 2.0 * GRAVITY_MPS2 * drop_m)) / GRAVITY_MPS2;
    (flight_s, takeoff_mps)
}

/// Landing height of a jump below its take-off height, share of the leg.
pub const JUMP_DROP: f64 = 0.06;

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    const FOOTING: Footing = Footing {
        leg_m: 0.9,
        cadence: 1.0,
        step_width: 1.0,
        toe_out_rad: 0.1,
        duty: 0.0,
        limp: 0.0,
        heel_strike: 1.0,
        clearance: 1.0,
    };

    fn planned(acts: &[Act]) -> Plan {
        plan(acts, &FOOTING, 0.0, &mut Draws::new(1, "test", "footsteps")).unwrap()
    }

    fn walk(seconds: f64, speed_mps: f64) -> Act {
        Act::Walk { seconds, speed_mps, turn_rate_radps: 0.0 }
    }

    fn run(seconds: f64, speed_mps: f64) -> Act {
        Act::Run { seconds, speed_mps, turn_rate_radps: 0.0 }
    }

    fn feet(plan: &Plan, time_s: f64) -> usize {
        [Foot::Left, Foot::Right].into_iter().filter(|&foot| plan.contact(foot, time_s)).count()
    }

    fn times(plan: &Plan) -> impl Iterator<Item = f64> {
        let n = (plan.duration_s * 200.0) as usize;
        (0..n).map(|k| k as f64 / 200.0)
    }

    #[test]
    fn walks_never_fly_and_every_running_step_does() {
        for speed_mps in [0.4, 0.9, 1.3, 2.0] {
            let plan = planned(&[walk(6.0, speed_mps)]);
            assert!(times(&plan).all(|t| feet(&plan, t) > 0 && plan.gait(t) == Gait::Walk), "{speed_mps}");
            assert!(times(&plan).any(|t| feet(&plan, t) == 2), "{speed_mps}");
        }
        for speed_mps in [1.8, 2.5, 4.0] {
            let plan = planned(&[run(6.0, speed_mps)]);
            assert!(times(&plan).all(|t| feet(&plan, t) < 2 && plan.gait(t) == Gait::Run), "{speed_mps}");
            let n_strikes = plan.stances.iter().flatten().filter(|s| 0.0 < s.strike_s && s.strike_s < 6.0).count();
            let n_flights = plan.flights().iter().filter(|f| 0.0 < f.landing_s && f.landing_s < 6.0).count();
            assert_eq!(n_strikes, n_flights, "{speed_mps}");
        }
    }

    #[test]
    fn duty_speed_and_step_are_those_of_the_pace() {
        for (act, pace) in [(walk(20.0, 1.2), Pace::walk(1.2, 0.9, 1.0)), (run(20.0, 3.0), Pace::run(3.0, 0.9, 1.0))] {
            let plan = planned(&[act]);
            let planted = times(&plan).filter(|&t| plan.contact(Foot::Left, t)).count() as f64;
            assert!((planted / (20.0 * 200.0) - pace.duty).abs() < 0.02);
            let gone = plan.path.at(20.0).z_m - plan.path.at(0.0).z_m;
            assert!((gone / 20.0 - pace.speed_mps).abs() < 1e-9);
            for pair in plan.stances[0].windows(2) {
                assert!((pair[1].place_m[1] - pair[0].place_m[1] - 2.0 * pace.step_m()).abs() < 0.01);
            }
        }
    }

    #[test]
    fn a_stance_ends_before_the_foot_s_next_one_begins() {
        let acts = [
            Act::Stand { seconds: 1.0 },
            walk(3.0, 1.2),
            run(3.0, 2.6),
            walk(2.0, 1.0),
            Act::Stand { seconds: 1.0 },
            Act::Jump { height_m: 0.2, forward_m: 0.5 },
            Act::Balance { lifted: Foot::Right, seconds: 1.0 },
            walk(2.0, 0.8),
        ];
        let plan = planned(&acts);
        for stances in &plan.stances {
            assert!(stances.iter().all(|s| s.strike_s < s.lift_s));
            assert!(stances.windows(2).all(|pair| pair[0].lift_s + 0.1 < pair[1].strike_s), "{stances:#?}");
        }
        for pair in plan.phases.windows(2) {
            assert_eq!(pair[0].end_s, pair[1].start_s);
        }
        let met: Vec<Gait> = plan.phases.iter().map(|phase| phase.gait).collect();
        use Gait::*;
        assert_eq!(met, [Stand, Walk, Run, Walk, Stand, Jump, Stand, Unknown, Stand, Walk]);
    }

    #[test]
    fn standing_feet_stand_side_by_side_after_a_walk() {
        let plan = planned(&[walk(3.0, 1.3), Act::Stand { seconds: 1.0 }]);
        assert_eq!(feet(&plan, plan.duration_s - 0.9), 2);
        assert!(plan.path.at(plan.duration_s - 0.9).speed_mps < 1e-9);
        let [left, right] = [0, 1].map(|foot| plan.stances[foot].last().unwrap().place_m);
        assert!((left[1] - right[1]).abs() < 1e-9 && left[0] > right[0] + 0.1, "{left:?} {right:?}");
    }

    #[test]
    fn a_jump_flies_as_long_as_its_height_asks_for() {
        let plan = planned(&[Act::Jump { height_m: 0.3, forward_m: 0.6 }]);
        let flights = plan.flights();
        assert_eq!(flights.len(), 1);
        let rise_s = libm::sqrt(2.0 * 0.3 / GRAVITY_MPS2);
        let flight_s = flights[0].landing_s - flights[0].takeoff_s;
        assert!(flight_s > 2.0 * rise_s && flight_s < 2.3 * rise_s, "{flight_s}");
        assert_eq!(feet(&plan, 0.5 * (flights[0].takeoff_s + flights[0].landing_s)), 0);
        let gone = plan.stances[0][1].place_m[1] - plan.stances[0][0].place_m[1];
        assert!((gone - 0.6).abs() < 0.01, "{gone}");
    }

    #[test]
    fn a_turn_to_the_left_goes_to_the_left() {
        let plan = planned(&[Act::Walk { seconds: 4.0, speed_mps: 1.0, turn_rate_radps: 0.4 }]);
        let end = plan.path.at(4.0);
        assert!((end.yaw_rad - 1.6).abs() < 1e-9 && end.x_m > 0.5, "+X is left of +Z: {end:?}");
        let outer = plan.stances[1].iter().map(|s| s.place_m[0]).fold(f64::INFINITY, f64::min);
        let inner = plan.stances[0].iter().map(|s| s.place_m[0]).fold(f64::INFINITY, f64::min);
        assert!(outer < inner);
    }

    #[test]
    fn hops_fly_from_one_foot_and_stairs_rise_a_tread_a_step() {
        let hop = Act::Hop { foot: Foot::Right, hops: 4, height_m: 0.1, forward_m: 0.3 };
        let plan = planned(&[Act::Stand { seconds: 1.0 }, hop]);
        assert_eq!(plan.flights().iter().map(|flight| flight.leap).collect::<Vec<Leap>>(), [Leap::Hop; 4]);
        assert_eq!(plan.stances[0].len(), 2, "the left foot is held");
        let met: Vec<Gait> = plan.phases.iter().map(|phase| phase.gait).collect();
        assert_eq!(met, [Gait::Stand, Gait::Jump, Gait::Stand]);
        let stairs = Act::Stairs { treads: 6, tread_m: 0.28, riser_m: -0.17, cadence_spm: 90.0 };
        let plan = planned(&[Act::Stand { seconds: 1.0 }, stairs, Act::Stand { seconds: 1.0 }]);
        let mut heights: Vec<f64> = plan.stances.iter().flatten().map(|stance| stance.ground_m).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        assert_eq!(heights.len(), 7, "{heights:?}");
        assert!((heights[0] + 6.0 * 0.17).abs() < 1e-9);
    }

    #[test]
    fn a_limp_shortens_one_stance_by_what_it_lengthens_the_other() {
        let footing = Footing { limp: 0.2, ..FOOTING };
        let plan = plan(&[walk(10.0, 1.0)], &footing, 0.0, &mut Draws::new(1, "test", "footsteps")).unwrap();
        let pace = Pace::walk(1.0, 0.9, 1.0);
        let stance_s = |foot: usize| plan.stances[foot][3].lift_s - plan.stances[foot][3].strike_s;
        assert!((stance_s(0) - stance_s(1) - 0.2 * pace.stride_s).abs() < 1e-9);
        assert!((stance_s(0) + stance_s(1) - 2.0 * pace.stance_s()).abs() < 1e-9);
        assert!(times(&plan).all(|t| feet(&plan, t) > 0));
    }
}
