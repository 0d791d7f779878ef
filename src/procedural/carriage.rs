//! How the body is carried over its feet: sway, height from the vertical load, ballistic flight, and how much of each gait.

use super::body::Body;
use super::pace::{GRAVITY_MPS2, Pace};
use super::path::{GRID_HZ, gaussian};
use super::plan::{CROUCH_S, DIP_S, Flight, JUMP_DROP, Leap, MID_STANCE, Plan, RECOVERY_S, jump_flight};
use super::style::Style;
use crate::annotate::Gait;

/// Tracks on the grid of the plan's path.
#[derive(Clone, Debug)]
pub(crate) struct Carriage {
    /// How much of a walk, 0 to 1.
    pub(crate) walk: Vec<f64>,
    /// How much of a run, 0 to 1.
    pub(crate) run: Vec<f64>,
    /// How much of a jump, 0 to 1.
    pub(crate) jump: Vec<f64>,
    /// Stride phase in cycles.
    pub(crate) stride: Vec<f64>,
    /// Hips to the left of the path, metres.
    pub(crate) sway_m: Vec<f64>,
    /// Height of the hips over the ground, metres, before the legs' reach and the mass of the limbs have their say.
    pub(crate) height_m: Vec<f64>,
    /// 1 in and around flights, where the centre of mass has to follow the height track.
    pub(crate) ballistic: Vec<f64>,
    /// In order of time.
    pub(crate) flights: Vec<Flight>,
    /// Height of the hips at rest.
    pub(crate) stand_m: f64,
}

/// A stretch of the height track that a flight decides.
struct Span {
    start_s: f64,
    end_s: f64,
    curve: Curve,
}

enum Curve {
    /// Polynomial of time since the start.
    Polynomial([f64; 6]),
    /// Height and speed at the start; load = `peak` sin(pi u) + `skew` sin(2 pi u) body weights.
    Load { height_m: f64, speed_mps: f64, peak: f64, skew: f64 },
}

/// Height and speed and acceleration at a time.
#[derive(Clone, Copy)]
struct State {
    time_s: f64,
    height_m: f64,
    speed_mps: f64,
    acceleration_mps2: f64,
}

impl Carriage {
    pub(crate) fn new(plan: &Plan, body: &Body, style: &Style) -> Carriage {
        let n = plan.path.n_samples();
        let times: Vec<f64> = (0..n).map(|index| plan.path.time_s(index)).collect();
        let share = |gait: Gait, sigma_s: f64| {
            let raw: Vec<f64> = times.iter().map(|&t| if plan.gait(t) == gait { 1.0 } else { 0.0 }).collect();
            gaussian(&raw, sigma_s)
        };
        let stride: Vec<f64> = times.iter().map(|&t| plan.stride.linear(t)).collect();
        let mut carriage = Carriage {
            walk: share(Gait::Walk, 0.14),
            run: share(Gait::Run, 0.14),
            jump: share(Gait::Jump, 0.1),
            stride: gaussian(&stride, 0.04),
            sway_m: sway_m(plan, &times),
            height_m: Vec::new(),
            ballistic: Vec::new(),
            flights: plan.flights(),
            stand_m: body.sole.ankle_m + (0.996 - style.crouch) * body.reach_m(),
        };
        let base: Vec<f64> = (0..n).map(|index| carriage.base_m(plan, body, style, index)).collect();
        let spans = spans(plan, body, style, &carriage.flights, &base);
        carriage.height_m = times
            .iter()
            .zip(&base)
            .map(|(&time_s, &base_m)| {
                let span = spans.iter().find(|span| span.start_s <= time_s && time_s < span.end_s);
                span.map_or(base_m, |span| span.curve.height_m(time_s - span.start_s, span.end_s - span.start_s))
            })
            .collect();
        let near_flight = |time_s: f64| {
            carriage.flights.iter().any(|flight| flight.takeoff_s - 0.15 < time_s && time_s < flight.landing_s + 0.15)
        };
        let raw: Vec<f64> = times.iter().map(|&t| if near_flight(t) { 1.0 } else { 0.0 }).collect();
        carriage.ballistic = gaussian(&raw, 0.04);
        carriage
    }

    /// Standing height; in a walk lower, and highest in the middle of each single support: the load's double hump.
    fn base_m(&self, plan: &Plan, body: &Body, style: &Style, index: usize) -> f64 {
        let time_s = plan.path.time_s(index);
        let speed_mps = plan.path.sample(index).pace_mps();
        let Some(pace) = plan.pace(time_s) else { return self.stand_m };
        let step_m = 0.5 * pace.stride_s * speed_mps;
        let reach_m = body.reach_m();
        // A third of what a stiff compass of the same step would bob.
        let bob_m = 0.5 * 0.30 * style.bounce * (step_m * step_m) / (8.0 * reach_m) * 4.0;
        let bob_m = bob_m.min(0.03 * reach_m);
        let wave = libm::cos(2.0 * core::f64::consts::TAU * (self.stride[index] - 0.5 * pace.duty));
        let walk_m = self.stand_m - bob_m + bob_m * wave;
        let run_m = run_height_m(&pace, body, style);
        self.stand_m + self.walk[index] * (walk_m - self.stand_m) + self.run[index] * (run_m - self.stand_m)
    }
}

/// Hips to the left: towards the planted feet, as quickly as a body can.
fn sway_m(plan: &Plan, times: &[f64]) -> Vec<f64> {
    let ease_s = 0.12;
    let mut held = 0.0;
    let raw: Vec<f64> = times
        .iter()
        .map(|&time_s| {
            let (mut sum, mut total) = (0.0, 0.0);
            for (foot, stances) in plan.stances.iter().enumerate() {
                for stance in stances.iter().filter(|s| s.strike_s <= time_s && time_s < s.lift_s) {
                    let on = ((time_s - stance.strike_s) / ease_s).min((stance.lift_s - time_s) / ease_s);
                    let weight = on.clamp(0.02, 1.0);
                    sum += weight * [1.0, -1.0][foot] * stance.half_width_m;
                    total += weight;
                }
            }
            if total > 0.0 {
                held = sum / total;
            }
            held
        })
        .collect();
    gaussian(&raw, 0.17)
}

/// Height of the hips at the ends of a running step's flight: what a slightly bent leg leaves when its foot strikes ahead.
fn run_height_m(pace: &Pace, body: &Body, style: &Style) -> f64 {
    let ahead_m = MID_STANCE[1] * pace.stance_s() * pace.speed_mps;
    let leg_m = (0.984 - style.crouch) * body.reach_m();
    body.sole.ankle_m + libm::sqrt(leg_m * leg_m - ahead_m * ahead_m).max(0.8 * leg_m)
}

/// Flights, the supports between them, and the ways into the first and out of the last.
fn spans(plan: &Plan, body: &Body, style: &Style, flights: &[Flight], base: &[f64]) -> Vec<Span> {
    let states: Vec<(State, State)> = flights.iter().map(|flight| flight_ends(plan, body, style, flight)).collect();
    let mut spans = Vec::new();
    for (index, flight) in flights.iter().enumerate() {
        let (takeoff, landing) = states[index];
        let previous = index.checked_sub(1).map(|before| (flights[before], states[before].1));
        match previous {
            Some((before, landed)) if joined(&before, flight) && flight.leap == Leap::Jump => {
                let low = crouch(body, takeoff, landed.time_s + 0.25, takeoff.time_s - 0.27);
                spans.extend(through(&[landed, low.0, low.1, takeoff]));
            }
            Some((before, landed)) if joined(&before, flight) => spans.push(supported(landed, takeoff)),
            _ => spans.extend(way_in(plan, body, takeoff, flight.leap, base)),
        }
        spans.push(ballistic(takeoff, landing));
        if !flights.get(index + 1).is_some_and(|next| joined(flight, next)) {
            spans.extend(way_out(plan, body, landing, flight.leap, base));
        }
    }
    spans
}

/// Whether the body does not come to its gait's own height between two flights.
fn joined(before: &Flight, next: &Flight) -> bool {
    let most_s = if next.leap == Leap::Jump { RECOVERY_S + CROUCH_S + 0.1 } else { 0.6 };
    before.leap == next.leap && next.takeoff_s - before.landing_s < most_s
}

/// The body at both ends of a flight.
fn flight_ends(plan: &Plan, body: &Body, style: &Style, flight: &Flight) -> (State, State) {
    let flight_s = flight.landing_s - flight.takeoff_s;
    let (takeoff_m, landing_m) = match flight.leap {
        // On the toes, legs all but straight.
        Leap::Jump => {
            let takeoff_m = body.sole.ankle_m + 0.62 * body.sole.length_m + 0.975 * body.reach_m();
            (takeoff_m, takeoff_m - JUMP_DROP * body.leg_m())
        }
        Leap::Hop => {
            let takeoff_m = body.sole.ankle_m + 0.45 * body.sole.length_m + 0.97 * body.reach_m();
            (takeoff_m, takeoff_m - JUMP_DROP * body.leg_m())
        }
        Leap::Step => {
            let pace = plan.pace(flight.takeoff_s);
            let height_m = pace.map_or(body.leg_m(), |pace| run_height_m(&pace, body, style));
            (height_m, height_m)
        }
    };
    let takeoff_mps = (landing_m - takeoff_m) / flight_s + 0.5 * GRAVITY_MPS2 * flight_s;
    let state = |time_s, height_m, speed_mps| State { time_s, height_m, speed_mps, acceleration_mps2: -GRAVITY_MPS2 };
    (
        state(flight.takeoff_s, takeoff_m, takeoff_mps),
        state(flight.landing_s, landing_m, takeoff_mps - GRAVITY_MPS2 * flight_s),
    )
}

fn ballistic(from: State, to: State) -> Span {
    let curve = Curve::Polynomial([from.height_m, from.speed_mps, -0.5 * GRAVITY_MPS2, 0.0, 0.0, 0.0]);
    Span { start_s: from.time_s, end_s: to.time_s, curve }
}

/// Between two flights of a run: a half sine of load, skewed as far as the two ends differ.
fn supported(from: State, to: State) -> Span {
    use core::f64::consts::PI;
    let span_s = to.time_s - from.time_s;
    let gained = to.speed_mps - from.speed_mps;
    let risen = to.height_m - from.height_m;
    let peak = (gained / (GRAVITY_MPS2 * span_s) + 1.0) * PI / 2.0;
    let by_peak = GRAVITY_MPS2 * span_s * span_s * (peak / PI - 0.5);
    let skew = (risen - from.speed_mps * span_s - by_peak) * 2.0 * PI / (GRAVITY_MPS2 * span_s * span_s);
    let curve = Curve::Load { height_m: from.height_m, speed_mps: from.speed_mps, peak, skew };
    Span { start_s: from.time_s, end_s: to.time_s, curve }
}

/// Quintics from state to state.
fn through(states: &[State]) -> Vec<Span> {
    states.windows(2).filter(|pair| pair[0].time_s < pair[1].time_s).map(|pair| quintic(pair[0], pair[1])).collect()
}

fn quintic(from: State, to: State) -> Span {
    let t = to.time_s - from.time_s;
    let (v0, a0) = (from.speed_mps, from.acceleration_mps2);
    let height = to.height_m - from.height_m - v0 * t - 0.5 * a0 * t * t;
    let speed = (to.speed_mps - v0 - a0 * t) * t;
    let bend = (to.acceleration_mps2 - a0) * t * t;
    let c3 = (10.0 * height - 4.0 * speed + 0.5 * bend) / (t * t * t);
    let c4 = (-15.0 * height + 7.0 * speed - bend) / (t * t * t * t);
    let c5 = (6.0 * height - 3.0 * speed + 0.5 * bend) / (t * t * t * t * t);
    let curve = Curve::Polynomial([from.height_m, v0, 0.5 * a0, c3, c4, c5]);
    Span { start_s: from.time_s, end_s: to.time_s, curve }
}

/// From the gait's own height to a take-off: down into a crouch first, if it is a jump.
fn way_in(plan: &Plan, body: &Body, takeoff: State, leap: Leap, base: &[f64]) -> Vec<Span> {
    match leap {
        Leap::Step => return through(&[base_state(plan, base, takeoff.time_s - 0.32), takeoff]),
        Leap::Hop => {
            let start = base_state(plan, base, takeoff.time_s - DIP_S);
            let low = dip(body, takeoff.height_m, takeoff.time_s - 0.2);
            return through(&[start, low, takeoff]);
        }
        Leap::Jump => {}
    }
    let start = base_state(plan, base, takeoff.time_s - CROUCH_S);
    let low = crouch(body, takeoff, takeoff.time_s - 0.27, takeoff.time_s - 0.27);
    through(&[start, low.0, takeoff])
}

/// From a landing to the gait's own height: down once more before standing up, if it is a jump.
fn way_out(plan: &Plan, body: &Body, landing: State, leap: Leap, base: &[f64]) -> Vec<Span> {
    match leap {
        Leap::Step => return through(&[landing, base_state(plan, base, landing.time_s + 0.32)]),
        Leap::Hop => {
            let low = dip(body, landing.height_m, landing.time_s + 0.16);
            return through(&[landing, low, base_state(plan, base, landing.time_s + DIP_S + 0.1)]);
        }
        Leap::Jump => {}
    }
    let depth_m = 0.09 * body.leg_m() + 0.018 * landing.speed_mps * landing.speed_mps;
    let low = State {
        time_s: landing.time_s + 0.2,
        height_m: landing.height_m - depth_m - 0.62 * body.sole.length_m,
        speed_mps: 0.0,
        acceleration_mps2: 6.0,
    };
    through(&[landing, low, base_state(plan, base, landing.time_s + RECOVERY_S + 0.1)])
}

/// The lowest point before a hop's take-off or after its landing.
fn dip(body: &Body, end_m: f64, time_s: f64) -> State {
    let height_m = end_m - 0.45 * body.sole.length_m - 0.06 * body.leg_m();
    State { time_s, height_m, speed_mps: 0.0, acceleration_mps2: 7.0 }
}

/// The lowest point before a take-off, held from one time to another.
fn crouch(body: &Body, takeoff: State, from_s: f64, to_s: f64) -> (State, State) {
    let (_, hop_mps) = jump_flight(0.05, body.leg_m());
    let depth_m = (0.10 + 0.06 * (takeoff.speed_mps / hop_mps - 1.0).clamp(0.0, 2.5)) * body.leg_m();
    let height_m = takeoff.height_m - 0.62 * body.sole.length_m - depth_m;
    let state = |time_s| State { time_s, height_m, speed_mps: 0.0, acceleration_mps2: 8.0 };
    (state(from_s), state(to_s.max(from_s)))
}

fn base_state(plan: &Plan, base: &[f64], time_s: f64) -> State {
    let index = plan.path.index(time_s).clamp(1, base.len() - 2);
    let rate = f64::from(GRID_HZ);
    State {
        time_s: plan.path.time_s(index),
        height_m: base[index],
        speed_mps: (base[index + 1] - base[index - 1]) * 0.5 * rate,
        acceleration_mps2: (base[index + 1] - 2.0 * base[index] + base[index - 1]) * rate * rate,
    }
}

impl Curve {
    fn height_m(&self, since_s: f64, span_s: f64) -> f64 {
        use core::f64::consts::PI;
        match self {
            Curve::Polynomial(c) => c.iter().rev().fold(0.0, |sum, c| sum * since_s + c),
            Curve::Load { height_m, speed_mps, peak, skew } => {
                let u = since_s / span_s;
                let weight = GRAVITY_MPS2 * span_s * span_s;
                // Twice the integral of sin(k pi u) from rest is u / (k pi) - sin(k pi u) / (k pi)^2.
                let twice = |k: f64| u / (k * PI) - libm::sin(k * PI * u) / (k * k * PI * PI);
                height_m + speed_mps * since_s + weight * (peak * twice(1.0) + skew * twice(2.0) - 0.5 * u * u)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(time_s: f64, height_m: f64, speed_mps: f64, acceleration_mps2: f64) -> State {
        State { time_s, height_m, speed_mps, acceleration_mps2 }
    }

    fn slope(span: &Span, at_s: f64) -> f64 {
        let length = span.end_s - span.start_s;
        (span.curve.height_m(at_s + 1e-6, length) - span.curve.height_m(at_s - 1e-6, length)) / 2e-6
    }

    #[test]
    fn a_supported_step_meets_both_flights() {
        for (v0, v1, h1) in [(-0.6, 0.6, 0.9), (-0.5, 0.8, 0.92), (-0.9, 0.4, 0.88)] {
            let span = supported(state(1.0, 0.9, v0, 0.0), state(1.25, h1, v1, 0.0));
            assert!((span.curve.height_m(0.0, 0.25) - 0.9).abs() < 1e-12);
            assert!((span.curve.height_m(0.25, 0.25) - h1).abs() < 1e-12);
            assert!((slope(&span, 0.0) - v0).abs() < 1e-4 && (slope(&span, 0.25) - v1).abs() < 1e-4);
            assert!(span.curve.height_m(0.12, 0.25) < 0.9, "the body sinks into its stance");
        }
    }

    #[test]
    fn quintics_meet_their_ends() {
        let span = quintic(state(0.0, 1.0, 0.2, -1.0), state(0.5, 0.8, 2.0, -9.81));
        assert!((span.curve.height_m(0.5, 0.5) - 0.8).abs() < 1e-12);
        assert!((slope(&span, 0.0) - 0.2).abs() < 1e-4 && (slope(&span, 0.5) - 2.0).abs() < 1e-4);
    }
}
