//! How fast a body of some size steps at some speed: stride time and duty factor from the Froude number.
//!
//! Bodies of different size move alike at equal v / sqrt(g leg); times scale with sqrt(leg / g).

use serde::{Deserialize, Serialize};

/// Standard gravity, m/s^2.
pub(super) const GRAVITY_MPS2: f64 = 9.81;

/// The beat of a steady gait.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pace {
    /// Asked speed, m/s.
    pub speed_mps: f64,
    /// From a strike to the same foot's next strike, seconds.
    pub stride_s: f64,
    /// Stance over stride of one foot, 0 to 1.
    pub duty: f64,
}

impl Pace {
    /// Steps at `speed_mps` of a walker with legs of `leg_m`; `cadence` multiplies the usual step rate (1 = usual).
    ///
    /// Duty 0.68 at a stroll to 0.56 near the walk-run transition: always above one half, so one foot is always down.
    pub fn walk(speed_mps: f64, leg_m: f64, cadence: f64) -> Pace {
        let speed = speed_mps / libm::sqrt(GRAVITY_MPS2 * leg_m);
        let step_rate = 0.575 * libm::sqrt(speed / 0.44) * cadence;
        let duty = (0.705 - 0.19 * speed).clamp(0.56, 0.68);
        Pace { speed_mps, stride_s: 2.0 / step_rate * libm::sqrt(leg_m / GRAVITY_MPS2), duty }
    }

    /// Steps at `speed_mps` of a runner: duty 0.40 at a jog to 0.26, always below one half, so every step has a flight.
    pub fn run(speed_mps: f64, leg_m: f64, cadence: f64) -> Pace {
        let speed = speed_mps / libm::sqrt(GRAVITY_MPS2 * leg_m);
        let step_rate = 0.87 * libm::pow(speed, 0.15) * cadence;
        let duty = (0.47 - 0.13 * speed).clamp(0.26, 0.40);
        Pace { speed_mps, stride_s: 2.0 / step_rate * libm::sqrt(leg_m / GRAVITY_MPS2), duty }
    }

    /// The same beat with longer or shorter stances: walks keep to 0.56 to 0.78, runs to 0.26 to 0.42.
    pub(super) fn with_duty(self, added: f64) -> Pace {
        let [low, high] = if self.duty > 0.5 { [0.56, 0.78] } else { [0.26, 0.42] };
        Pace { duty: (self.duty + added).clamp(low, high), ..self }
    }

    /// Time of one foot on the ground, seconds.
    pub fn stance_s(&self) -> f64 {
        self.duty * self.stride_s
    }

    /// Time of one foot off the ground, seconds.
    pub fn swing_s(&self) -> f64 {
        (1.0 - self.duty) * self.stride_s
    }

    /// Distance from a strike to the other foot's strike, metres.
    pub fn step_m(&self) -> f64 {
        0.5 * self.stride_s * self.speed_mps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grown_people_step_as_people_do() {
        let walk = Pace::walk(1.3, 0.92, 1.0);
        let cadence_spm = 120.0 / walk.stride_s;
        assert!((105.0..120.0).contains(&cadence_spm), "{cadence_spm}");
        let run = Pace::run(3.0, 0.92, 1.0);
        let cadence_spm = 120.0 / run.stride_s;
        assert!((160.0..180.0).contains(&cadence_spm), "{cadence_spm}");
        let flight_s = (0.5 - run.duty) * run.stride_s;
        assert!((0.08..0.16).contains(&flight_s), "{flight_s}");
    }

    #[test]
    fn duty_keeps_walks_on_the_ground_and_runs_off_it() {
        for speed_mps in [0.4, 0.9, 1.8, 2.0, 3.0, 4.0] {
            for leg_m in [0.6, 0.9, 1.1] {
                assert!((0.56..=0.68).contains(&Pace::walk(speed_mps, leg_m, 1.0).duty));
                assert!((0.26..=0.42).contains(&Pace::run(speed_mps, leg_m, 1.0).duty));
            }
        }
    }

    #[test]
    fn small_bodies_step_faster() {
        assert!(Pace::walk(1.2, 0.6, 1.0).stride_s < Pace::walk(1.2, 1.0, 1.0).stride_s);
    }
}
