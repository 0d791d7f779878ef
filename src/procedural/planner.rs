//! Lays out the strikes and lift-offs of a list of acts, one act after the other.

use super::draws::Draws;
use super::pace::{GRAVITY_MPS2, Pace};
use super::path::{Knots, Path};
use super::plan::{Act, CROUCH_S, Footing, MID_STANCE, Phase, Plan, RECOVERY_S, Roll, Stance, Swing, jump_flight};
use crate::annotate::Gait;

/// Part of the crouch that pushes the body up and forward, seconds.
const JUMP_PUSH_S: f64 = 0.26;
/// Part of the recovery that takes the forward speed away, seconds.
const JUMP_BRAKE_S: f64 = 0.3;
/// Standing before a foot is lifted to balance, and after it is back, seconds.
const SETTLE_S: f64 = 0.7;

/// The plan of acts that were checked: at least one, values in range, jumps and balances after stands only.
pub(super) fn footsteps(acts: &[Act], footing: &Footing, yaw_rad: f64, draws: &mut Draws) -> Plan {
    let mut planner = Planner::new(acts, footing, draws);
    for act in acts {
        planner.act(*act);
    }
    planner.finish(yaw_rad)
}

/// What the feet are doing between two acts.
#[derive(Clone, Copy)]
enum Mode {
    Standing,
    Stepping { gait: Gait, pace: Pace, next_foot: usize, next_strike_s: f64 },
}

struct Planner<'a> {
    footing: &'a Footing,
    first_foot: usize,
    now_s: f64,
    start_s: f64,
    mode: Mode,
    stances: [Vec<Stance>; 2],
    phases: Vec<Phase>,
    speed: Knots,
    turn: Knots,
    stride: Knots,
    stride_phase: f64,
    paces: Vec<(f64, Pace)>,
}

impl<'a> Planner<'a> {
    fn new(acts: &[Act], footing: &'a Footing, draws: &mut Draws) -> Planner<'a> {
        let first_foot = draws.pick(2);
        let share = draws.uniform(0.0, 1.0);
        let mut planner = Planner {
            footing,
            first_foot,
            now_s: 0.0,
            start_s: -1.5,
            mode: Mode::Standing,
            stances: [Vec::new(), Vec::new()],
            phases: Vec::new(),
            speed: Knots::default(),
            turn: Knots::default(),
            stride: Knots::default(),
            stride_phase: if first_foot == 0 { 0.0 } else { 0.5 },
            paces: Vec::new(),
        };
        match steady(acts[0], footing) {
            // A clip that begins in mid-stride: steps before its first frame.
            Some((gait, pace, turn_rate_radps)) => {
                let first_strike_s = -(2.0 + share) * pace.stride_s;
                planner.start_s = first_strike_s - pace.stride_s;
                planner.speed.push(planner.start_s, pace.speed_mps);
                planner.turn.push(planner.start_s, turn_rate_radps);
                planner.stride.push(planner.start_s, planner.stride_phase - 1.0);
                planner.paces.push((planner.start_s, pace));
                planner.mode = Mode::Stepping { gait, pace, next_foot: first_foot, next_strike_s: first_strike_s };
                planner.step_until(0.0);
            }
            None => {
                planner.speed.push(planner.start_s, 0.0);
                planner.turn.push(planner.start_s, 0.0);
                for foot in 0..2 {
                    planner.strike(foot, planner.start_s, f64::INFINITY, planner.start_s, Gait::Stand);
                }
            }
        }
        planner
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Stand { seconds } => {
                self.stop();
                self.phase(Gait::Stand, self.now_s, self.now_s + seconds);
                self.now_s += seconds;
            }
            Act::Walk { seconds, .. } | Act::Run { seconds, .. } => {
                if let Some((gait, pace, turn_rate_radps)) = steady(act, self.footing) {
                    self.go(gait, pace, turn_rate_radps);
                    let end_s = self.now_s + seconds;
                    self.phase(gait, self.now_s, end_s);
                    self.now_s = end_s;
                    self.step_until(end_s);
                }
            }
            Act::Jump { height_m, forward_m } => self.jump(height_m, forward_m),
            Act::Balance { lifted, seconds } => self.balance(lifted as usize, seconds),
        }
    }

    /// Starts or changes a gait.
    fn go(&mut self, gait: Gait, pace: Pace, turn_rate_radps: f64) {
        let now_s = self.now_s;
        match self.mode {
            Mode::Standing => {
                let (first, other) = (self.first_foot, 1 - self.first_foot);
                self.lift(first, now_s, gait, &pace);
                self.lift(other, now_s + 0.5 * pace.stride_s, gait, &pace);
                let wanted = if first == 0 { 0.0 } else { 0.5 };
                self.stride_phase = (self.stride_phase - wanted).ceil() + wanted;
                self.stride.push(now_s, self.stride_phase - (1.0 - pace.duty));
                self.paces.push((now_s, pace));
                let ramp_s = (0.8 * pace.stride_s).max(pace.speed_mps / 2.5);
                self.speed.ramp(now_s - 0.1, now_s + ramp_s, pace.speed_mps);
                self.turn.ramp(now_s, now_s + ramp_s, turn_rate_radps);
                let next_strike_s = now_s + pace.swing_s();
                self.mode = Mode::Stepping { gait, pace, next_foot: first, next_strike_s };
            }
            Mode::Stepping { gait: before, pace: old, next_foot, next_strike_s } => {
                if before == gait && old == pace {
                    self.turn.ramp(now_s - 0.3, now_s + 0.3, turn_rate_radps);
                    return;
                }
                let half_s = 0.5 * (0.5_f64).max((pace.speed_mps - old.speed_mps).abs() / 2.5);
                self.speed.ramp(next_strike_s - half_s, next_strike_s + half_s, pace.speed_mps);
                self.turn.ramp(next_strike_s - half_s, next_strike_s + half_s, turn_rate_radps);
                self.paces.push((next_strike_s, pace));
                self.now_s = self.now_s.max(next_strike_s);
                if let Some(last) = self.phases.last_mut() {
                    last.end_s = self.now_s;
                }
                self.mode = Mode::Stepping { gait, pace, next_foot, next_strike_s };
            }
        }
    }

    /// All strikes before `end_s`.
    fn step_until(&mut self, end_s: f64) {
        while let Mode::Stepping { gait, pace, next_foot, next_strike_s } = self.mode {
            if next_strike_s >= end_s {
                break;
            }
            let mid_s = next_strike_s + MID_STANCE[usize::from(gait == Gait::Run)] * pace.stance_s();
            self.stride.push(next_strike_s, self.stride_phase);
            self.stride_phase += 0.5;
            self.strike(next_foot, next_strike_s, next_strike_s + pace.stance_s(), mid_s, gait);
            self.lift(next_foot, next_strike_s + pace.stance_s(), gait, &pace);
            let next_strike_s = next_strike_s + 0.5 * pace.stride_s;
            self.mode = Mode::Stepping { gait, pace, next_foot: 1 - next_foot, next_strike_s };
        }
    }

    /// Ends a gait: one more step, and the other foot drawn up beside it.
    fn stop(&mut self) {
        let Mode::Stepping { pace, next_foot, next_strike_s, gait } = self.mode else { return };
        let closed_s = next_strike_s + 0.5 * pace.stride_s;
        for (foot, strike_s) in [(next_foot, next_strike_s), (1 - next_foot, closed_s)] {
            self.stride.push(strike_s, self.stride_phase);
            self.stride_phase += 0.5;
            self.strike(foot, strike_s, f64::INFINITY, closed_s, gait);
            if let Some(stance) = self.stances[foot].last_mut() {
                stance.half_width_m = half_width_m(Gait::Stand, self.footing);
            }
        }
        let ramp_s = (0.9 * pace.stride_s).max(pace.speed_mps / 2.0);
        self.speed.ramp(closed_s - ramp_s, closed_s, 0.0);
        self.turn.ramp(closed_s - ramp_s, closed_s, 0.0);
        if let Some(last) = self.phases.last_mut() {
            last.end_s = closed_s;
        }
        self.first_foot = next_foot;
        self.now_s = closed_s;
        self.mode = Mode::Standing;
    }

    fn jump(&mut self, height_m: f64, forward_m: f64) {
        let (flight_s, _) = jump_flight(height_m, self.footing.leg_m);
        let takeoff_s = self.now_s + CROUCH_S;
        let landing_s = takeoff_s + flight_s;
        let end_s = landing_s + RECOVERY_S;
        let speed_mps = forward_m / (flight_s + 0.5 * (JUMP_PUSH_S + JUMP_BRAKE_S));
        self.speed.ramp(takeoff_s - JUMP_PUSH_S, takeoff_s, speed_mps);
        self.speed.ramp(landing_s, landing_s + JUMP_BRAKE_S, 0.0);
        for foot in 0..2 {
            if let Some(stance) = self.stances[foot].last_mut() {
                stance.lift_s = takeoff_s;
                stance.swing = Swing::Jump;
                (stance.roll.push_pitch_rad, stance.roll.push_s) = (0.8, 0.2);
            }
            self.strike(foot, landing_s, f64::INFINITY, end_s, Gait::Jump);
        }
        self.phase(Gait::Jump, self.now_s, end_s);
        self.now_s = end_s;
    }

    fn balance(&mut self, foot: usize, seconds: f64) {
        let lift_s = self.now_s + SETTLE_S;
        let back_s = lift_s + seconds;
        let end_s = back_s + SETTLE_S;
        if let Some(stance) = self.stances[foot].last_mut() {
            stance.lift_s = lift_s;
            stance.swing = Swing::Hold;
            (stance.roll.push_pitch_rad, stance.roll.push_s) = (0.25, 0.25);
        }
        self.strike(foot, back_s, f64::INFINITY, back_s, Gait::Stand);
        self.phase(Gait::Stand, self.now_s, lift_s);
        self.phase(Gait::Unknown, lift_s, back_s);
        self.phase(Gait::Stand, back_s, end_s);
        self.now_s = end_s;
    }

    fn strike(&mut self, foot: usize, strike_s: f64, lift_s: f64, beside_s: f64, gait: Gait) {
        let speed_mps = if let Mode::Stepping { pace, .. } = self.mode { pace.speed_mps } else { 0.0 };
        let speed = speed_mps / libm::sqrt(GRAVITY_MPS2 * self.footing.leg_m);
        let (strike_pitch_rad, landing_s) = match gait {
            Gait::Walk => ((0.12 + 0.45 * speed).min(0.38), 0.0),
            Gait::Run => (0.16, 0.0),
            Gait::Jump => (-0.42, 0.11),
            _ => (0.0, 0.1),
        };
        let stance_s = lift_s - strike_s;
        let landing_s = if landing_s > 0.0 { landing_s } else { (0.12 * stance_s).min(0.1) };
        self.stances[foot].push(Stance {
            strike_s,
            lift_s,
            beside_s,
            half_width_m: half_width_m(gait, self.footing),
            place_m: [0.0; 2],
            yaw_rad: 0.0,
            roll: Roll { strike_pitch_rad, landing_s, push_pitch_rad: 0.0, push_s: 0.1 },
            swing: Swing::Walk,
        });
    }

    fn lift(&mut self, foot: usize, lift_s: f64, gait: Gait, pace: &Pace) {
        let speed = pace.speed_mps / libm::sqrt(GRAVITY_MPS2 * self.footing.leg_m);
        if let Some(stance) = self.stances[foot].last_mut() {
            stance.lift_s = lift_s;
            (stance.roll.push_pitch_rad, stance.swing) = match gait {
                Gait::Run => ((0.5 + 0.22 * speed).min(0.8), Swing::Run),
                _ => ((0.35 + 1.2 * speed).min(1.0), Swing::Walk),
            };
            stance.roll.push_s = 0.28 * pace.stance_s();
            if gait == Gait::Run {
                stance.roll.push_s = 0.4 * pace.stance_s();
            }
        }
    }

    fn phase(&mut self, gait: Gait, start_s: f64, end_s: f64) {
        match self.phases.last_mut() {
            Some(last) if last.gait == gait => last.end_s = end_s,
            _ => self.phases.push(Phase { gait, start_s, end_s }),
        }
    }

    fn finish(mut self, yaw_rad: f64) -> Plan {
        let duration_s = self.now_s;
        let mut end_s = duration_s + 1.5;
        if let Mode::Stepping { pace, .. } = self.mode {
            // The feet that stand at the last frame need somewhere to go.
            end_s += 2.5 * pace.stride_s;
            self.step_until(duration_s + 2.0 * pace.stride_s);
        }
        let path = Path::new(self.start_s, end_s, yaw_rad, &self.speed, &self.turn);
        for (foot, stances) in self.stances.iter_mut().enumerate() {
            let side = [1.0, -1.0][foot];
            for stance in stances {
                let point = path.at(stance.beside_s);
                let (sin, cos) = libm::sincos(point.yaw_rad);
                let aside_m = side * stance.half_width_m;
                stance.place_m = [point.x_m + cos * aside_m, point.z_m - sin * aside_m];
                stance.yaw_rad = point.yaw_rad + side * self.footing.toe_out_rad;
            }
        }
        Plan { duration_s, phases: self.phases, stances: self.stances, path, stride: self.stride, paces: self.paces }
    }
}

/// The gait, pace and turn rate of an act that steps.
fn steady(act: Act, footing: &Footing) -> Option<(Gait, Pace, f64)> {
    let (leg_m, cadence) = (footing.leg_m, footing.cadence);
    match act {
        Act::Walk { speed_mps, turn_rate_radps, .. } => {
            Some((Gait::Walk, Pace::walk(speed_mps, leg_m, cadence), turn_rate_radps))
        }
        Act::Run { speed_mps, turn_rate_radps, .. } => {
            Some((Gait::Run, Pace::run(speed_mps, leg_m, cadence), turn_rate_radps))
        }
        _ => None,
    }
}

fn half_width_m(gait: Gait, footing: &Footing) -> f64 {
    let share = match gait {
        Gait::Walk => 0.055,
        Gait::Run => 0.03,
        _ => 0.105,
    };
    share * footing.leg_m * footing.step_width
}
