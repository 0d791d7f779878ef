//! Foot contacts as the judge's figures were measured with (GRAFTS, header): a fixed, simple rule that any clip and its
//! parents are held to alike. The `contacts` stage has a better detector; its labels are not used here.

use super::super::signal::{gradient, percentile};
use super::super::subject::Movement;
use glam::DVec3;

const HEIGHT_ABOVE_REST_M: f64 = 0.05;
const SLOW_MPS: f64 = 0.6;
const CLOSED_GAP_S: f64 = 0.1;
/// Rest is at most this far above the lowest twentieth.
const REST_ABOVE_LOWEST_M: f64 = 0.03;

/// Whether each foot is on the ground: left, right; `[frame]` each.
///
/// Ankle or toe below its rest height + 5 cm and slower than 0.6 m/s; gaps of up to 0.1 s closed, then contacts
/// shorter than about 0.05 s dropped, both away from the clip's ends.
pub fn contacts(movement: &Movement) -> [Vec<bool>; 2] {
    // Half a frame goes to the even number.
    let gap = (CLOSED_GAP_S * movement.rate_hz).round_ties_even() as usize;
    movement.landmarks.legs.map(|leg| {
        let ankle = near_ground(&movement.poses.path(leg.ankle), movement.rate_hz);
        let toe = near_ground(&movement.poses.path(leg.toe), movement.rate_hz);
        let mut planted: Vec<bool> = ankle.into_iter().zip(toe).map(|(ankle, toe)| ankle || toe).collect();
        let n = planted.len();
        let inner = |&(first, end): &(usize, usize)| first > 0 && end < n;
        for (first, end) in runs(&planted, false).into_iter().filter(inner).filter(|run| run.1 - run.0 <= gap) {
            planted[first..end].fill(true);
        }
        let shortest = gap.div_ceil(2).max(2);
        for (first, end) in runs(&planted, true).into_iter().filter(inner).filter(|run| run.1 - run.0 < shortest) {
            planted[first..end].fill(false);
        }
        planted
    })
}

/// Runs of a value: half-open ranges in order.
pub fn runs(mask: &[bool], value: bool) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut first = 0;
    for block in mask.chunk_by(|a, b| a == b) {
        if block[0] == value {
            found.push((first, first + block.len()));
        }
        first += block.len();
    }
    found
}

fn near_ground(path: &[DVec3], rate_hz: f64) -> Vec<bool> {
    let [x, y, z] = [0, 1, 2].map(|axis| path.iter().map(|point| point[axis]).collect::<Vec<f64>>());
    let [vx, vy, vz] = [&x, &y, &z].map(|values| gradient(values));
    let slow: Vec<bool> =
        (0..path.len()).map(|n| DVec3::new(vx[n], vy[n], vz[n]).length() * rate_hz < SLOW_MPS).collect();
    let slow_heights: Vec<f64> = y.iter().zip(&slow).filter(|pair| *pair.1).map(|pair| *pair.0).collect();
    let lowest = percentile(&y, 5.0).unwrap_or(0.0);
    let rest = if slow_heights.len() > 5 { percentile(&slow_heights, 10.0).unwrap_or(lowest) } else { lowest };
    let rest = rest.min(lowest + REST_ABOVE_LOWEST_M);
    y.iter().zip(slow).map(|(&height, slow)| slow && height < rest + HEIGHT_ABOVE_REST_M).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::walker::{mover, waver};
    use super::*;
    use crate::motion::Role;

    #[test]
    fn a_stander_is_planted_and_a_lifted_foot_is_not() {
        let [left, right] = contacts(&waver(30.0, 60).movement);
        assert!(left.iter().chain(&right).all(|&planted| planted));
        // Lifts the left knee for frames 20..40.
        let lifter = mover(30.0, 60, 1.0, 0.0, &|time_s, _| {
            let lifted = (0.66..1.32).contains(&time_s);
            vec![(Role::ThighLeft, [0.0, if lifted { -60.0 } else { 0.0 }, 0.0])]
        });
        let [left, right] = contacts(&lifter.movement);
        assert!(right.iter().all(|&planted| planted));
        assert_eq!(runs(&left, false).len(), 1);
        assert!((15..=20).contains(&runs(&left, false)[0].0), "{:?}", runs(&left, false));
    }

    #[test]
    fn runs_are_half_open() {
        assert_eq!(runs(&[true, true, false, true], true), [(0, 2), (3, 4)]);
        assert_eq!(runs(&[], true), []);
    }
}
