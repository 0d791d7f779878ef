//! How the arms keep time with the legs: phase of the arm swing after the leg swing, and how firmly it is locked (GRAFTS 2).

use super::super::heading::{forward, left_ahead};
use super::super::signal::fourier::Complex;
use super::super::signal::{analytic, lowpass, mean, spectrum, standard_deviation, unwrap_phase};
use super::super::subject::Movement;
use core::f64::consts::{PI, TAU};

/// Below these there is no swing to speak of.
const MIN_ARM_SWING_M: f64 = 0.06;
const MIN_LEG_SWING_M: f64 = 0.08;
const MIN_DURATION_S: f64 = 1.5;
/// Slower motion is no swing but drift.
const DRIFT_HZ: f64 = 0.35;
const SWING_HZ: core::ops::Range<f64> = 0.5..2.5;
const BAND_OVER_STRONGEST: f64 = 1.6;
const SPECTRUM_LENGTH: usize = 4096;

/// The relation of arms to legs over a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmLeg {
    /// Phase of the arms after the opposite legs, cycles in (-0.5, 0.5]; a captured walk has 0.058, a run 0.071.
    pub relation: f64,
    /// Length of the mean phase vector, 0..1; captured gaits have 0.96 and more.
    pub lock: f64,
}

/// The relation of arms to legs. None where there is no gait or no swing: the judge has nothing to say then.
pub fn arm_leg(movement: &Movement) -> Option<ArmLeg> {
    let forward = forward(movement);
    let marks = &movement.landmarks;
    let arms = left_ahead(movement, marks.arms.map(|arm| arm.wrist), &forward);
    let legs = left_ahead(movement, marks.legs.map(|leg| leg.ankle), &forward);
    let n_frames = movement.n_frames();
    if standard_deviation(&arms) <= MIN_ARM_SWING_M
        || standard_deviation(&legs) <= MIN_LEG_SWING_M
        || n_frames as f64 <= MIN_DURATION_S * movement.rate_hz
    {
        return None;
    }
    let against: Vec<f64> = legs.iter().map(|ahead| -ahead).collect();
    let arms = swing_phase(&arms, movement.rate_hz)?;
    let legs = swing_phase(&against, movement.rate_hz)?;
    // The ends carry the transform's own errors.
    let cut = (n_frames / 10).max(1);
    let inner = cut..n_frames - cut;
    if inner.is_empty() {
        return None;
    }
    let count = inner.len() as f64;
    let sum = inner.fold(Complex::default(), |sum, n| sum + Complex::turn(TAU * (arms[n] - legs[n])));
    Some(ArmLeg { relation: sum.angle_rad() / TAU, lock: sum.norm() / count })
}

/// Phase of a swing in cycles, never falling. None: no frequency in the band can be told at this rate.
fn swing_phase(swing: &[f64], rate_hz: f64) -> Option<Vec<f64>> {
    let n = swing.len();
    let slow = if n as f64 > 3.0 * rate_hz { lowpass(swing, DRIFT_HZ, rate_hz) } else { vec![mean(swing); n] };
    let swing: Vec<f64> = swing.iter().zip(slow).map(|(value, slow)| value - slow).collect();
    let strongest = strongest_hz(&swing, rate_hz)?;
    let swing = lowpass(&swing, BAND_OVER_STRONGEST * strongest, rate_hz);
    // One period at each end, reflected about the end's point.
    let pad = ((rate_hz / strongest) as usize).min(n - 1);
    let (first, last) = (swing[0], swing[n - 1]);
    let mut padded: Vec<f64> = swing[1..=pad].iter().rev().map(|value| 2.0 * first - value).collect();
    padded.extend_from_slice(&swing);
    padded.extend(swing[n - 1 - pad..n - 1].iter().rev().map(|value| 2.0 * last - value));
    let angles: Vec<f64> = analytic(&padded).into_iter().map(Complex::angle_rad).collect();
    let mut highest = f64::NEG_INFINITY;
    let mut phase = unwrap_phase(&angles);
    for angle in &mut phase {
        *angle /= TAU;
    }
    let phase = phase[pad..pad + n].iter().map(|&turns| {
        highest = highest.max(turns);
        highest
    });
    Some(phase.collect())
}

/// The frequency of a swing's highest spectral line inside the band of gaits.
fn strongest_hz(swing: &[f64], rate_hz: f64) -> Option<f64> {
    let n = swing.len();
    let bell = |k: usize| 0.5 - 0.5 * libm::cos(2.0 * PI * k as f64 / (n - 1).max(1) as f64);
    let windowed: Vec<f64> = swing.iter().enumerate().map(|(k, value)| value * bell(k)).collect();
    let length = n.next_power_of_two().max(SPECTRUM_LENGTH);
    let mut best: Option<(f64, f64)> = None;
    for (k, height) in spectrum(&windowed, length).into_iter().enumerate() {
        let hertz = k as f64 * rate_hz / length as f64;
        if hertz > SWING_HZ.start && hertz < SWING_HZ.end && best.is_none_or(|(highest, _)| height > highest) {
            best = Some((height, hertz));
        }
    }
    best.map(|(_, hertz)| hertz)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::super::walker::{mover, walker, waver};
    use super::*;
    use crate::motion::Role;

    #[test]
    fn arms_against_legs_are_in_phase_and_locked() {
        for rate_hz in [30.0, 120.0] {
            let found = arm_leg(&walker(rate_hz, (6.0 * rate_hz) as usize, 0.9).movement).unwrap();
            assert!(found.relation.abs() < 0.01 && found.lock > 0.999, "{rate_hz} {found:?}");
        }
    }

    #[test]
    fn late_arms_show_by_how_much() {
        let late = mover(30.0, 200, 1.0, 1.2, &|_, phase| {
            let [leg, arm] = [phase, phase - 0.2].map(|phase| 25.0 * libm::sin(TAU * phase));
            vec![
                (Role::ThighLeft, [0.0, -leg, 0.0]),
                (Role::ThighRight, [0.0, leg, 0.0]),
                (Role::ShoulderLeft, [0.0, arm, 0.0]),
                (Role::ShoulderRight, [0.0, -arm, 0.0]),
            ]
        });
        let found = arm_leg(&late.movement).unwrap();
        assert!((found.relation + 0.2).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn without_gait_or_time_there_is_no_relation() {
        assert_eq!(arm_leg(&waver(30.0, 120).movement), None);
        assert_eq!(arm_leg(&walker(30.0, 45, 1.0).movement), None);
        assert!(arm_leg(&walker(30.0, 46, 1.0).movement).is_some());
    }
}
