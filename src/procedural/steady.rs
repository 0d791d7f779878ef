//! How an act steps once it is under way: its beat, its way over the ground, and how its feet roll and rise.

use super::act::Act;
use super::pace::{GRAVITY_MPS2, Pace};
use super::plan::{Footing, MID_STANCE};
use crate::annotate::{Foot, Gait};

/// A gait in some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steady {
    pub(super) gait: Gait,
    /// With the speed over the ground, in whatever direction.
    pub(super) pace: Pace,
    pub(super) ahead_mps: f64,
    pub(super) aside_mps: f64,
    pub(super) turn_rate_radps: f64,
    /// Rise over run of the ground ahead.
    pub(super) grade: f64,
    /// From the path to the middle of a foot.
    pub(super) half_width_m: f64,
    /// The ankle is below the hips after this share of a stance.
    pub(super) mid_stance: f64,
    pub(super) strike_pitch_rad: f64,
    /// From the strike until the foot is flat, share of the stance, and the most that it may be, seconds.
    pub(super) landing: (f64, f64),
    pub(super) push_pitch_rad: f64,
    /// From the first rise of the heel to the lift-off, share of the stance.
    pub(super) push: f64,
    /// How much higher than usual the feet are lifted.
    pub(super) lift_m: f64,
}

impl Steady {
    /// The gait of an act that steps; none for the others.
    pub(super) fn of(act: Act, footing: &Footing) -> Option<Steady> {
        let (leg_m, cadence) = (footing.leg_m, footing.cadence);
        let walk = |speed_mps| Pace::walk(speed_mps, leg_m, cadence);
        let root = libm::sqrt(leg_m / GRAVITY_MPS2);
        match act {
            Act::Walk { speed_mps, turn_rate_radps, .. } => {
                Some(Steady { turn_rate_radps, ..Steady::forward(Gait::Walk, walk(speed_mps), footing) })
            }
            Act::Run { speed_mps, turn_rate_radps, .. } => {
                let pace = Pace::run(speed_mps, leg_m, cadence);
                Some(Steady { turn_rate_radps, ..Steady::forward(Gait::Run, pace, footing) })
            }
            Act::Back { speed_mps, turn_rate_radps, .. } => {
                let steady = Steady::forward(Gait::Walk, walk(speed_mps), footing);
                Some(Steady {
                    ahead_mps: -speed_mps,
                    turn_rate_radps,
                    half_width_m: 1.3 * steady.half_width_m,
                    // Like a walk forward that is played from its end, but for the heel, which rises less.
                    mid_stance: 0.52,
                    strike_pitch_rad: (-0.2 - 1.1 * steady.strike_pitch_rad.abs()).max(-0.55),
                    landing: (0.3, 0.25),
                    push_pitch_rad: -0.5 * steady.strike_pitch_rad.abs(),
                    push: 0.14,
                    lift_m: 0.045 * leg_m,
                    ..steady
                })
            }
            Act::Aside { speed_mps, toward, .. } => {
                // As at a slow walk, but quick enough for steps that a leg can span.
                let stride_s = (5.2 * root / cadence).min(0.44 * leg_m / speed_mps);
                let pace = Pace { speed_mps, stride_s, duty: 0.62 }.with_duty(footing.duty);
                let aside_mps = speed_mps * if toward == Foot::Left { 1.0 } else { -1.0 };
                Some(Steady {
                    ahead_mps: 0.0,
                    aside_mps,
                    // The feet come near each other, and never nearer.
                    half_width_m: 0.5 * pace.step_m() + 0.085 * leg_m,
                    mid_stance: 0.5,
                    strike_pitch_rad: -0.06,
                    push_pitch_rad: 0.22,
                    lift_m: 0.035 * leg_m,
                    ..Steady::forward(Gait::Walk, pace, footing)
                })
            }
            Act::March { lift, .. } => {
                let pace = Pace { speed_mps: 0.0, stride_s: 3.6 * root / cadence, duty: 0.62 };
                let steady = Steady::forward(Gait::Walk, pace.with_duty(footing.duty), footing);
                Some(Steady::on_the_spot(steady, lift * leg_m, 0.45))
            }
            Act::Jog { lift, .. } => {
                let pace = Pace { speed_mps: 0.0, stride_s: 2.3 * root / cadence, duty: 0.39 };
                let steady = Steady::forward(Gait::Run, pace.with_duty(footing.duty), footing);
                Some(Steady::on_the_spot(steady, lift * leg_m, 0.5))
            }
            Act::Slope { speed_mps, incline_rad, .. } => {
                let grade = libm::tan(incline_rad);
                let steady = Steady::forward(Gait::Walk, walk(speed_mps), footing);
                // Uphill the leg behind is the long one, downhill the one ahead.
                Some(Steady { grade, mid_stance: steady.mid_stance + 0.7 * grade, ..steady })
            }
            Act::Stairs { tread_m, riser_m, cadence_spm, .. } => {
                let stride_s = 120.0 / cadence_spm;
                let pace = Pace { speed_mps: 2.0 * tread_m / stride_s, stride_s, duty: 0.62 }.with_duty(footing.duty);
                // Down: toes first. Up: flat on the tread.
                let strike_pitch_rad = if riser_m < 0.0 { -0.3 } else { 0.04 };
                Some(Steady {
                    // The body stays behind going up, and holds back less going down.
                    mid_stance: if riser_m < 0.0 { 0.28 } else { 0.62 },
                    strike_pitch_rad,
                    landing: (0.2, 0.15),
                    push_pitch_rad: 0.7,
                    ..Steady::forward(Gait::Walk, pace, footing)
                })
            }
            Act::Stand { .. } | Act::Jump { .. } | Act::Hop { .. } | Act::Balance { .. } => None,
        }
    }

    /// Straight ahead on level ground.
    fn forward(gait: Gait, pace: Pace, footing: &Footing) -> Steady {
        let pace = if footing.duty == 0.0 { pace } else { pace.with_duty(footing.duty) };
        let speed = pace.speed_mps / libm::sqrt(GRAVITY_MPS2 * footing.leg_m);
        let running = gait == Gait::Run;
        let strike_pitch_rad = if running { 0.16 } else { (0.12 + 0.45 * speed).min(0.38) };
        let push_pitch_rad = if running { (0.5 + 0.22 * speed).min(0.8) } else { (0.35 + 1.2 * speed).min(1.0) };
        // The ball takes longer to let the heel down than the heel the ball.
        let landing = if footing.heel_strike < 0.0 { (0.2, 0.15) } else { (0.12, 0.1) };
        Steady {
            gait,
            pace,
            ahead_mps: pace.speed_mps,
            aside_mps: 0.0,
            turn_rate_radps: 0.0,
            grade: 0.0,
            half_width_m: half_width_m(gait, footing),
            mid_stance: MID_STANCE[usize::from(running)],
            strike_pitch_rad: strike_pitch_rad * footing.heel_strike,
            landing,
            push_pitch_rad,
            push: if running { 0.4 } else { 0.28 },
            lift_m: 0.0,
        }
    }

    fn on_the_spot(self, lift_m: f64, push_pitch_rad: f64) -> Steady {
        let half_width_m = self.half_width_m.max(0.0) * 1.4;
        Steady { half_width_m, strike_pitch_rad: -0.3, landing: (0.2, 0.15), push_pitch_rad, lift_m, ..self }
    }
}

/// From the path to the middle of a foot, of gaits straight ahead and of bodies that stand.
pub(super) fn half_width_m(gait: Gait, footing: &Footing) -> f64 {
    let share = match gait {
        Gait::Walk => 0.055,
        Gait::Run => 0.03,
        _ => 0.105,
    };
    share * footing.leg_m * footing.step_width
}
