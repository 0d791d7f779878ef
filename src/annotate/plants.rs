//! Foot plants: where a foot stands, from when to when, and how much it slips.

use super::contacts::foot_paths::{FEET, FootPaths};
use super::contacts::uneven::runs_of_true;
use super::labels::{Foot, Plant};
use super::order_statistics::coordinate_medians;
use glam::DVec3;

/// This share of a plant at either end is left out of its slip: the foot still rolls.
const ROLLING_SHARE: f64 = 0.2;

/// Every run of stance of either foot: left foot first, then in time.
///
/// Position: the median, coordinate by coordinate, of the toe's path (the ankle's where there is no toe). Slip: the
/// largest horizontal distance from it in the middle 60 % of the plant. Confidence: the mean probability by the
/// foot's log-odds, `[frame][foot]`, where there are any.
pub fn plants(feet: &FootPaths, stance: &[Vec<bool>; 2], log_odds: Option<&[[f64; 2]]>) -> Vec<Plant> {
    let mut plants = Vec::new();
    for foot in FEET {
        let path = feet.ball(foot);
        for run in runs_of_true(&stance[foot as usize]) {
            let (position, slip_m) = place_and_slip_m(&path[run.clone()], feet.scale);
            plants.push(Plant {
                foot,
                first: run.start as u32,
                end: run.end as u32,
                position: position.as_vec3().to_array(),
                slip_m: slip_m as f32,
                confidence: log_odds.map(|odds| mean_probability(&odds[run], foot) as f32),
            });
        }
    }
    plants
}

/// Mean probability that a foot is planted.
fn mean_probability(log_odds: &[[f64; 2]], foot: Foot) -> f64 {
    let total: f64 = log_odds.iter().map(|odds| 1.0 / (1.0 + libm::exp(-odds[foot as usize]))).sum();
    total / log_odds.len().max(1) as f64
}

/// Median position and slip, metres, of a path in scaled metres that is not empty.
fn place_and_slip_m(path: &[DVec3], scale: f64) -> (DVec3, f64) {
    let position = coordinate_medians(path);
    let rolling = (ROLLING_SHARE * path.len() as f64) as usize;
    let slip = path[rolling..path.len() - rolling]
        .iter()
        .map(|place| *place - position)
        .map(|away| (away.x * away.x + away.z * away.z).sqrt())
        .fold(0.0, f64::max);
    (position * scale, slip * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plants_lie_where_the_toe_rests_and_slip_in_their_middle_only() {
        // Ten frames of stance: the toe lands 0.3 m off, slips 0.02 m in the sixth frame, and is 1 m away after it.
        let x = [9.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.1, 0.3, 1.0];
        let toe: Vec<DVec3> = x.iter().map(|&x| DVec3::new(x, 0.05, 2.0)).collect();
        let far: Vec<DVec3> = toe.iter().map(|_| DVec3::ONE * 7.0).collect();
        let feet = FootPaths {
            n_frames: 12,
            rate_hz: 30.0,
            leg_length_m: 1.8,
            leg_spread_m: 0.0,
            scale: 2.0,
            paths: [Some(far.clone()), Some(toe), Some(far), None],
        };
        let left: Vec<bool> = (0..12).map(|frame| (1..11).contains(&frame)).collect();
        let mut right = vec![false; 12];
        right[0] = true;
        right[11] = true;
        let plants = plants(&feet, &[left, right], None);
        assert_eq!(plants.len(), 3);
        assert_eq!((plants[0].foot, plants[0].first, plants[0].end), (Foot::Left, 1, 11));
        assert_eq!(plants[0].position, [0.0, 0.1, 4.0]);
        assert!((plants[0].slip_m - 0.04).abs() < 1e-6);
        assert_eq!((plants[1].foot, plants[1].first, plants[1].end), (Foot::Right, 0, 1));
        assert_eq!((plants[2].first, plants[2].end, plants[2].slip_m), (11, 12, 0.0));
        assert_eq!(plants[2].position, [14.0; 3]);
    }
}
