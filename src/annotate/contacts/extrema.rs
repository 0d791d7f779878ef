//! Contacts from low turning points of the height (T 5.5.1): a reference, not the default.

use super::foot_paths::{FEET, FootPaths, joints_of};
use super::resting_height::RestingHeights;
use super::thesis::fixed_contacts;
use super::{Contacts, ExtremaSettings};

/// The detector of T 5.5.1 as CONTACTS 7 reads it: a joint is planted where its height turns (or stays) within
/// `max_height_m` of its rest, and from there in both directions while its speed from the frame before is
/// `< max_speed_mps`; a foot is planted where its ankle or its toe is.
pub fn extrema_contacts(feet: &FootPaths, rest: &RestingHeights, settings: &ExtremaSettings) -> Contacts {
    fixed_contacts(feet, rest, settings.max_speed_mps, |joint, heights, speeds| {
        debug_assert!(FEET.iter().any(|&foot| joints_of(foot).contains(&joint)));
        let slow: Vec<bool> = speeds.iter().map(|&speed| speed < settings.max_speed_mps).collect();
        let seeds =
            (0..heights.len()).filter(|&frame| turns(heights, frame) && heights[frame].abs() < settings.max_height_m);
        let mut planted = vec![false; heights.len()];
        for seed in seeds {
            if planted[seed] {
                continue;
            }
            let first = (0..seed).rev().take_while(|&frame| slow[frame]).last().unwrap_or(seed);
            let end = (seed + 1..slow.len()).take_while(|&frame| slow[frame]).last().unwrap_or(seed) + 1;
            planted[first..end].fill(true);
        }
        planted
    })
}

/// Whether the height turns in a frame: it does not go on as it came. The ends of the clip turn.
fn turns(heights: &[f64], frame: usize) -> bool {
    let (Some(before), Some(after)) = (frame.checked_sub(1), heights.get(frame + 1)) else { return true };
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
    fn a_low_point_in_passing_is_one_frame_and_a_high_one_none() {
        assert_eq!(contacts(&[(0.0, 0.2), (0.2, 0.02), (0.4, 0.2)]), [false, true, false]);
        assert_eq!(contacts(&[(0.0, 0.3), (0.2, 0.2), (0.4, 0.3)]), [false, false, false]);
    }
}
