//! Contacts from low turning points of the height (T 5.5.1): a reference, not the default.

use super::foot_paths::FootPaths;
use super::resting_height::RestingHeights;
use super::thesis::fixed_contacts;
use super::uneven::runs_of_true;
use super::{Contacts, ExtremaSettings};

/// The detector of T 5.5.1 as CONTACTS 7 measured it: a joint is planted where its height turns (or stays), inside the
/// clip, within `max_height_m` of its rest, and its speed from the frame before is `< max_speed_mps`; from there in both
/// directions while it is as slow. A foot is planted where its ankle or its toe is.
pub fn extrema_contacts(feet: &FootPaths, rest: &RestingHeights, settings: &ExtremaSettings) -> Contacts {
    fixed_contacts(feet, rest, settings.max_speed_mps, |_, heights, speeds| {
        let slow: Vec<bool> = speeds.iter().map(|&speed| speed < settings.max_speed_mps).collect();
        let is_seed =
            |frame: usize| slow[frame] && turns(heights, frame) && heights[frame].abs() < settings.max_height_m;
        let mut planted = vec![false; heights.len()];
        for run in runs_of_true(&slow) {
            planted[run.clone()].fill(run.clone().any(is_seed));
        }
        planted
    })
}

/// Whether the height turns in a frame: it does not go on as it came. At the clip's ends nobody knows.
fn turns(heights: &[f64], frame: usize) -> bool {
    let (Some(before), Some(after)) = (frame.checked_sub(1), heights.get(frame + 1)) else { return false };
    (heights[frame] - heights[before]) * (after - heights[frame]) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotate::labels::Foot;
    use glam::DVec3;

    /// A foot at these heights and places along X, one pair a frame.
    fn contacts(path: &[(f64, f64)]) -> Vec<bool> {
        let path: Vec<DVec3> = path.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        let feet = FootPaths {
            n_frames: path.len(),
            rate_hz: 30.0,
            leg_length_m: 0.9,
            leg_spread_m: 0.0,
            scale: 1.0,
            paths: [Some(path.clone()), None, Some(path), None],
        };
        let rest = RestingHeights { height: [Some(0.0), None, Some(0.0), None], apart: false };
        extrema_contacts(&feet, &rest, &ExtremaSettings::default()).stance_of(Foot::Left).to_vec()
    }

    #[test]
    fn a_foot_is_planted_round_the_low_points_of_its_height_while_it_is_slow() {
        // Comes down, lies still for four frames, goes on and up.
        let path =
            [(0.0, 0.3), (0.2, 0.1), (0.25, 0.01), (0.25, 0.0), (0.25, 0.0), (0.255, 0.005), (0.3, 0.1), (0.5, 0.3)];
        let wanted = [false, false, false, true, true, true, false, false];
        assert_eq!(contacts(&path), wanted);
    }

    #[test]
    fn low_points_in_passing_and_high_ones_are_none() {
        // 0.3 m/s, then 1.5 m/s down and up again.
        assert_eq!(
            contacts(&[(0.0, 0.04), (0.01, 0.04), (0.02, 0.05), (0.07, 0.0), (0.12, 0.05)])[1..],
            [true, true, false, false]
        );
        assert_eq!(contacts(&[(0.0, 0.21), (0.0, 0.2), (0.0, 0.21)]), [false; 3], "too high");
    }
}
