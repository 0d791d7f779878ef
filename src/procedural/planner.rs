//! Lays out the strikes and lift-offs of a list of acts, one act after the other.

use super::act::Act;
use super::draws::Draws;
use super::pace::{GRAVITY_MPS2, Pace};
use super::path::{Course, Knots, Path};
use super::plan::{CROUCH_S, DIP_S, Footing, Phase, Plan, RECOVERY_S, Roll, Stance, Swing, jump_flight};
use super::steady::{Steady, half_width_m};
use crate::annotate::{Foot, Gait};

/// Part of the crouch that pushes the body up and forward, seconds.
const JUMP_PUSH_S: f64 = 0.26;
/// Part of the recovery that takes the forward speed away, seconds.
const JUMP_BRAKE_S: f64 = 0.3;
/// On the ground between two hops, seconds.
const HOP_CONTACT_S: f64 = 0.29;
/// Quiet on one foot before the first hop's dip and after the last one, seconds.
const HOP_SETTLE_S: f64 = 0.3;
/// Least time of a swing, in units of the root of leg over gravity: 0.17 s for a grown body.
const SHORTEST_SWING: f64 = 0.55;
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
    Stepping { steady: Steady, next_foot: usize, next_strike_s: f64 },
}

struct Planner<'a> {
    footing: &'a Footing,
    first_foot: usize,
    now_s: f64,
    start_s: f64,
    mode: Mode,
    stances: [Vec<Stance>; 2],
    phases: Vec<Phase>,
    course: Course,
    stairs: Knots,
    stairs_m: f64,
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
            course: Course::default(),
            stairs: Knots::default(),
            stairs_m: 0.0,
            stride: Knots::default(),
            stride_phase: if first_foot == 0 { 0.0 } else { 0.5 },
            paces: Vec::new(),
        };
        match Steady::of(acts[0], footing) {
            // A clip that begins in mid-stride: steps before its first frame.
            Some(steady) => {
                let pace = steady.pace;
                let first_strike_s = -(2.0 + share) * pace.stride_s;
                planner.start_s = first_strike_s - pace.stride_s;
                planner.head_for(&steady, planner.start_s, planner.start_s);
                planner.stride.push(planner.start_s, planner.stride_phase - 1.0);
                planner.paces.push((planner.start_s, pace));
                planner.mode = Mode::Stepping { steady, next_foot: first_foot, next_strike_s: first_strike_s };
                planner.step_until(0.0);
            }
            None => {
                planner.halt(planner.start_s, planner.start_s);
                for foot in 0..2 {
                    planner.stand(foot, planner.start_s, planner.start_s);
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
            Act::Walk { seconds, .. }
            | Act::Run { seconds, .. }
            | Act::Back { seconds, .. }
            | Act::Aside { seconds, .. }
            | Act::March { seconds, .. }
            | Act::Jog { seconds, .. }
            | Act::Slope { seconds, .. } => {
                if let Some(steady) = Steady::of(act, self.footing) {
                    self.go(steady);
                    let end_s = self.now_s + seconds;
                    self.phase(steady.gait, self.now_s, end_s);
                    self.now_s = end_s;
                    self.step_until(end_s);
                }
            }
            Act::Stairs { treads, riser_m, .. } => {
                if let Some(steady) = Steady::of(act, self.footing) {
                    self.stairs(steady, treads, riser_m);
                }
            }
            Act::Hop { foot, hops, height_m, forward_m } => self.hop(foot as usize, hops, height_m, forward_m),
            Act::Jump { height_m, forward_m } => self.jump(height_m, forward_m),
            Act::Balance { lifted, seconds } => self.balance(lifted as usize, seconds),
        }
    }

    /// Holds the way until `start_s`, then turns it into another one's.
    fn head_for(&mut self, steady: &Steady, start_s: f64, end_s: f64) {
        self.course.speed.ramp(start_s, end_s, steady.ahead_mps);
        self.course.aside.ramp(start_s, end_s, steady.aside_mps);
        self.course.grade.ramp(start_s, end_s, steady.grade);
        self.course.turn.ramp(start_s, end_s, steady.turn_rate_radps);
    }

    fn halt(&mut self, start_s: f64, end_s: f64) {
        let Course { speed, aside, turn, grade } = &mut self.course;
        for knots in [speed, aside, turn, grade] {
            knots.ramp(start_s, end_s, 0.0);
        }
    }

    /// Starts or changes a gait.
    fn go(&mut self, steady: Steady) {
        let (now_s, pace) = (self.now_s, steady.pace);
        match self.mode {
            Mode::Standing => {
                if steady.aside_mps != 0.0 {
                    // The foot on that side leads.
                    self.first_foot = (if steady.aside_mps > 0.0 { Foot::Left } else { Foot::Right }) as usize;
                }
                let (first, other) = (self.first_foot, 1 - self.first_foot);
                self.lift(first, now_s, &steady);
                self.lift(other, now_s + 0.5 * pace.stride_s, &steady);
                let wanted = if first == 0 { 0.0 } else { 0.5 };
                self.stride_phase = (self.stride_phase - wanted).ceil() + wanted;
                self.stride.push(now_s, self.stride_phase - (1.0 - pace.duty));
                self.paces.push((now_s, pace));
                let ramp_s = (0.8 * pace.stride_s).max(pace.speed_mps / 2.5);
                self.course.speed.ramp(now_s - 0.1, now_s + ramp_s, steady.ahead_mps);
                self.course.aside.ramp(now_s - 0.1, now_s + ramp_s, steady.aside_mps);
                self.course.turn.ramp(now_s, now_s + ramp_s, steady.turn_rate_radps);
                self.course.grade.ramp(now_s, now_s + ramp_s, steady.grade);
                let next_strike_s = now_s + pace.swing_s();
                self.mode = Mode::Stepping { steady, next_foot: first, next_strike_s };
            }
            Mode::Stepping { steady: old, next_foot, next_strike_s } => {
                if old == (Steady { turn_rate_radps: old.turn_rate_radps, ..steady }) {
                    self.course.turn.ramp(now_s - 0.3, now_s + 0.3, steady.turn_rate_radps);
                    return;
                }
                let change_mps = (steady.ahead_mps - old.ahead_mps).abs() + (steady.aside_mps - old.aside_mps).abs();
                let half_s = 0.5 * (0.5_f64).max(change_mps / 2.5);
                self.head_for(&steady, next_strike_s - half_s, next_strike_s + half_s);
                self.paces.push((next_strike_s, pace));
                self.now_s = self.now_s.max(next_strike_s);
                if let Some(last) = self.phases.last_mut() {
                    last.end_s = self.now_s;
                }
                self.mode = Mode::Stepping { steady, next_foot, next_strike_s };
            }
        }
    }

    /// All strikes before `end_s`.
    fn step_until(&mut self, end_s: f64) {
        while let Mode::Stepping { next_strike_s, .. } = self.mode {
            if next_strike_s >= end_s {
                break;
            }
            self.step();
        }
    }

    /// The next strike; answers with the time when the body passes over it.
    fn step(&mut self) -> f64 {
        let Mode::Stepping { steady, next_foot, next_strike_s } = self.mode else { return self.now_s };
        let pace = steady.pace;
        // A limp takes from the stance of one foot, and from the way to the other's strike, what it gives the other way.
        let unequal_s = [0.5, -0.5][next_foot] * self.footing.limp * pace.stride_s;
        let stance_s = pace.stance_s() + unequal_s;
        let mid_s = next_strike_s + steady.mid_stance * stance_s;
        self.stride.push(next_strike_s, self.stride_phase);
        self.stride_phase += 0.5;
        self.strike(next_foot, next_strike_s, next_strike_s + stance_s, mid_s, &steady);
        self.lift(next_foot, next_strike_s + stance_s, &steady);
        let next_strike_s = next_strike_s + 0.5 * pace.stride_s + unequal_s;
        self.mode = Mode::Stepping { steady, next_foot: 1 - next_foot, next_strike_s };
        mid_s
    }

    /// Level steps until the speed is steady, a step a tread, and two level steps.
    fn stairs(&mut self, steady: Steady, treads: u32, riser_m: f64) {
        self.go(steady);
        let start_s = self.now_s;
        let mut mid_s = start_s;
        for _ in 0..3 {
            mid_s = self.step();
        }
        self.stairs.push(mid_s, self.stairs_m);
        for _ in 0..treads {
            mid_s = self.step();
        }
        self.stairs_m += f64::from(treads) * riser_m;
        self.stairs.push(mid_s, self.stairs_m);
        for _ in 0..2 {
            self.step();
        }
        if let Mode::Stepping { next_strike_s, .. } = self.mode {
            self.now_s = next_strike_s;
        }
        self.phase(steady.gait, start_s, self.now_s);
    }

    /// Ends a gait: one more step, and the other foot drawn up beside it.
    fn stop(&mut self) {
        let Mode::Stepping { steady, next_foot, next_strike_s } = self.mode else { return };
        let pace = steady.pace;
        let closed_s = next_strike_s + 0.5 * pace.stride_s;
        for (foot, strike_s) in [(next_foot, next_strike_s), (1 - next_foot, closed_s)] {
            self.stride.push(strike_s, self.stride_phase);
            self.stride_phase += 0.5;
            self.strike(foot, strike_s, f64::INFINITY, closed_s, &steady);
            if let Some(stance) = self.stances[foot].last_mut() {
                stance.half_width_m = half_width_m(Gait::Stand, self.footing);
            }
        }
        let ramp_s = (0.9 * pace.stride_s).max(pace.speed_mps / 2.0);
        self.halt(closed_s - ramp_s, closed_s);
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
        self.course.speed.ramp(takeoff_s - JUMP_PUSH_S, takeoff_s, speed_mps);
        self.course.speed.ramp(landing_s, landing_s + JUMP_BRAKE_S, 0.0);
        for foot in 0..2 {
            if let Some(stance) = self.stances[foot].last_mut() {
                stance.lift_s = takeoff_s;
                stance.swing = Swing::Jump;
                (stance.roll.push_pitch_rad, stance.roll.push_s) = (0.8, 0.2);
            }
            self.land(foot, landing_s, end_s);
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
        self.stand(foot, back_s, back_s);
        self.phase(Gait::Stand, self.now_s, lift_s);
        self.phase(Gait::Unknown, lift_s, back_s);
        self.phase(Gait::Stand, back_s, end_s);
        self.now_s = end_s;
    }

    /// One foot is lifted and held; the other hops, with a short dip between two hops.
    fn hop(&mut self, foot: usize, hops: u32, height_m: f64, forward_m: f64) {
        let held = 1 - foot;
        let lift_s = self.now_s + 0.5 * SETTLE_S;
        let (flight_s, _) = jump_flight(height_m, self.footing.leg_m);
        if let Some(stance) = self.stances[held].last_mut() {
            (stance.lift_s, stance.swing) = (lift_s, Swing::Hop);
            (stance.roll.push_pitch_rad, stance.roll.push_s) = (0.3, 0.25);
        }
        let mut takeoff_s = lift_s + HOP_SETTLE_S + DIP_S;
        let speed_mps = forward_m / (flight_s + HOP_CONTACT_S);
        self.course.speed.ramp(takeoff_s - JUMP_PUSH_S, takeoff_s, speed_mps);
        let mut landing_s = takeoff_s;
        for hop in 0..hops {
            landing_s = takeoff_s + flight_s;
            if let Some(stance) = self.stances[foot].last_mut() {
                (stance.lift_s, stance.swing) = (takeoff_s, Swing::Jump);
                (stance.roll.push_pitch_rad, stance.roll.push_s) = (0.6, 0.16);
            }
            // The body passes over the foot in the middle of a contact; over the last one where it comes to rest.
            let last = hop + 1 == hops;
            let beside_s = if last { landing_s + JUMP_BRAKE_S } else { landing_s + 0.5 * HOP_CONTACT_S };
            self.land(foot, landing_s, beside_s);
            takeoff_s = landing_s + HOP_CONTACT_S;
        }
        self.course.speed.ramp(landing_s, landing_s + JUMP_BRAKE_S, 0.0);
        let back_s = landing_s + DIP_S + HOP_SETTLE_S;
        self.stand(held, back_s, back_s);
        let end_s = back_s + SETTLE_S;
        self.phase(Gait::Stand, self.now_s, lift_s);
        self.phase(Gait::Jump, lift_s, back_s);
        self.phase(Gait::Stand, back_s, end_s);
        self.now_s = end_s;
    }

    fn strike(&mut self, foot: usize, strike_s: f64, lift_s: f64, beside_s: f64, steady: &Steady) {
        // From a slow gait to a quick one the foot has to leave early, or its swing would take no time.
        let latest_s = strike_s - SHORTEST_SWING * libm::sqrt(self.footing.leg_m / GRAVITY_MPS2);
        if let Some(stance) = self.stances[foot].last_mut() {
            stance.lift_s = stance.lift_s.min(latest_s.max(stance.strike_s + 0.1));
        }
        let (share, most_s) = steady.landing;
        let landing_s = (share * (lift_s - strike_s)).min(most_s);
        self.plant(foot, [strike_s, lift_s, beside_s], steady.half_width_m, steady.strike_pitch_rad, landing_s);
    }

    /// Flat on the ground, to stay.
    fn stand(&mut self, foot: usize, strike_s: f64, beside_s: f64) {
        let half_width_m = half_width_m(Gait::Stand, self.footing);
        self.plant(foot, [strike_s, f64::INFINITY, beside_s], half_width_m, 0.0, 0.1);
    }

    /// On the ball, from a jump.
    fn land(&mut self, foot: usize, strike_s: f64, beside_s: f64) {
        let half_width_m = half_width_m(Gait::Jump, self.footing);
        self.plant(foot, [strike_s, f64::INFINITY, beside_s], half_width_m, -0.42, 0.11);
    }

    fn plant(
        &mut self,
        foot: usize,
        [strike_s, lift_s, beside_s]: [f64; 3],
        half_width_m: f64,
        strike_pitch_rad: f64,
        landing_s: f64,
    ) {
        self.stances[foot].push(Stance {
            strike_s,
            lift_s,
            beside_s,
            half_width_m,
            place_m: [0.0; 2],
            ground_m: 0.0,
            slope_rad: 0.0,
            yaw_rad: 0.0,
            roll: Roll { strike_pitch_rad, landing_s, push_pitch_rad: 0.0, push_s: 0.1 },
            swing: Swing::Walk,
            lift_m: 0.0,
            clearance: self.footing.clearance,
        });
    }

    fn lift(&mut self, foot: usize, lift_s: f64, steady: &Steady) {
        if let Some(stance) = self.stances[foot].last_mut() {
            stance.lift_s = lift_s;
            stance.roll.push_pitch_rad = steady.push_pitch_rad;
            stance.roll.push_s = steady.push * steady.pace.stance_s();
            stance.swing = if steady.gait == Gait::Run { Swing::Run } else { Swing::Walk };
            stance.lift_m = steady.lift_m;
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
        if let Mode::Stepping { steady, .. } = self.mode {
            // The feet that stand at the last frame need somewhere to go.
            end_s += 2.5 * steady.pace.stride_s;
            self.step_until(duration_s + 2.0 * steady.pace.stride_s);
        }
        let path = Path::new(self.start_s, end_s, yaw_rad, &self.course);
        for (foot, stances) in self.stances.iter_mut().enumerate() {
            for stance in stances.iter_mut() {
                place(stance, [1.0, -1.0][foot], self.footing, &path, &self.stairs);
            }
            for at in 1..stances.len() {
                let steps_up = |a: &Stance, b: &Stance| {
                    self.stairs.linear(a.beside_s) != self.stairs.linear(b.beside_s) && a.swing == Swing::Walk
                };
                if steps_up(&stances[at - 1], &stances[at]) {
                    stances[at - 1].swing = Swing::Stair;
                }
            }
        }
        Plan {
            duration_s,
            phases: self.phases,
            stances: self.stances,
            path,
            stairs: self.stairs,
            stride: self.stride,
            paces: self.paces,
        }
    }
}

/// Puts a foot on the ground beside the path; `side` is 1 for the left foot, -1 for the right one.
fn place(stance: &mut Stance, side: f64, footing: &Footing, path: &Path, stairs: &Knots) {
    let point = path.at(stance.beside_s);
    let (sin, cos) = libm::sincos(point.yaw_rad);
    let aside_m = side * stance.half_width_m;
    stance.place_m = [point.x_m + cos * aside_m, point.z_m - sin * aside_m];
    stance.yaw_rad = point.yaw_rad + side * footing.toe_out_rad;
    stance.ground_m = point.rise_m + stairs.linear(stance.beside_s);
    stance.slope_rad = libm::atan(point.grade * libm::cos(footing.toe_out_rad));
}
