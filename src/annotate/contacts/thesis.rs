//! The thesis' detector: fixed thresholds on height and speed (T 3.1.1).

use super::foot_paths::{FEET, FootPaths, joints_of, speeds};
use super::resting_height::RestingHeights;
use super::{Contacts, Ground, PINNED_SHARE, ThesisSettings};

/// The thesis' detector (T 3.1.1; CONTACTS 4): a joint is planted where `|height - rest| < max_height_m` and its
/// speed from the frame before is `< max_speed_mps`; short gaps are closed per joint; a foot is planted where its
/// ankle or its toe is.
///
/// A clip of one frame has no speeds: they count as zero. No frames give no labels.
pub fn thesis_contacts(feet: &FootPaths, rest: &RestingHeights, settings: &ThesisSettings) -> Contacts {
    let window = feet.frames_in(settings.close_gap_s);
    fixed_contacts(feet, rest, settings.max_speed_mps, |_, heights, speeds| {
        let mut planted: Vec<bool> = heights
            .iter()
            .zip(speeds)
            .map(|(height, &speed)| height.abs() < settings.max_height_m && speed < settings.max_speed_mps)
            .collect();
        close_gaps(&mut planted, window);
        planted
    })
}

/// Contacts by a rule for each joint: `is_planted(joint, heights above rest, speeds from the frame before)`, both in
/// scaled metres. A foot is planted where its ankle or its toe is, and pinned where one of them is slower than half of
/// `max_speed_mps`.
pub(super) fn fixed_contacts(
    feet: &FootPaths,
    rest: &RestingHeights,
    max_speed_mps: f64,
    is_planted: impl Fn(usize, &[f64], &[f64]) -> Vec<bool>,
) -> Contacts {
    let heights = [0, 1, 2, 3].map(|joint| {
        let (path, rest) = (feet.paths[joint].as_deref()?, rest.height[joint].unwrap_or(0.0));
        Some(path.iter().map(|position| position.y - rest).collect::<Vec<f64>>())
    });
    let speeds = feet.paths.each_ref().map(|path| path.as_deref().map(|path| backward_speeds(path, feet.rate_hz)));
    let planted = [0, 1, 2, 3].map(|joint| Some(is_planted(joint, heights[joint].as_ref()?, speeds[joint].as_ref()?)));
    let stance = FEET.map(|foot| {
        let joints = joints_of(foot).map(|joint| planted[joint].as_deref());
        (0..feet.n_frames).map(|frame| joints.iter().flatten().any(|planted| planted[frame])).collect::<Vec<bool>>()
    });
    let pinned = FEET.map(|foot| {
        let joints = joints_of(foot).map(|joint| speeds[joint].as_deref());
        let slow = |frame: usize| joints.iter().flatten().any(|speeds| speeds[frame] < PINNED_SHARE * max_speed_mps);
        (0..feet.n_frames).map(|frame| stance[foot as usize][frame] && slow(frame)).collect()
    });
    let own_size = |values: [Option<Vec<f64>>; 4]| {
        values.map(|values| values.map(|values| values.into_iter().map(|value| value * feet.scale).collect()))
    };
    let ground = Ground {
        height_m: rest.of_feet().map(|height| height * feet.scale),
        feet_rest_apart: rest.apart,
        ..Ground::default()
    };
    Contacts { stance, pinned, heights_m: own_size(heights), speeds_mps: own_size(speeds), ground, diagnosis: None }
}

/// Speed of every frame from the one before; frame 0 takes frame 1's, a lone frame 0.
fn backward_speeds(path: &[glam::DVec3], rate_hz: f64) -> Vec<f64> {
    let steps = speeds(path, 1, rate_hz);
    let first = steps.first().copied().unwrap_or(0.0);
    let lead = if path.is_empty() { None } else { Some(first) };
    lead.into_iter().chain(steps).collect()
}

/// Marks frames that have a marked frame within `window` frames both before and after (T 3.1.1, de-bouncing).
fn close_gaps(planted: &mut [bool], window: usize) {
    let mut last: Option<usize> = None;
    for frame in 0..planted.len() {
        if !planted[frame] {
            continue;
        }
        if let Some(last) = last {
            let first = frame.saturating_sub(window).max(last + 1);
            let end = last.saturating_add(window + 1).min(frame);
            if first < end {
                planted[first..end].fill(true);
            }
        }
        last = Some(frame);
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use crate::annotate::gait_tokens::Token;
    use crate::annotate::labels::Foot;
    use glam::DVec3;

    fn marks(text: &str) -> Vec<bool> {
        text.chars().map(|mark| mark == 'x').collect()
    }

    #[test]
    fn gaps_close_where_plants_lie_within_the_window_on_both_sides() {
        for (window, before, after) in [
            (1, "x.x..x", "xxx..x"),
            (2, "..x.x..x...x....x.", "..xxxxxx.x.x....x."),
            (2, "x..", "x.."),
            (2, "", ""),
            (9, "x.....x", "xxxxxxx"),
            (usize::MAX - 1, "x.....x", "xxxxxxx"),
        ] {
            let raw = marks(before);
            let mut planted = raw.clone();
            close_gaps(&mut planted, window);
            assert_eq!(planted, marks(after), "window {window}, {before}");
            // The definition, word for word.
            let near = |frame: usize| {
                let earlier = (0..frame).rev().take(window).any(|at| raw[at]);
                earlier && (frame + 1..raw.len()).take(window).any(|at| raw[at])
            };
            let wanted: Vec<bool> = (0..raw.len()).map(|frame| raw[frame] || near(frame)).collect();
            assert_eq!(planted, wanted, "window {window}, {before}");
        }
    }

    /// A foot that rests at height 0 for 10 frames, then moves on at `speed_mps`, then rests at `height_m`.
    fn feet(speed_mps: f64, height_m: f64, scale: f64) -> FootPaths {
        let path: Vec<DVec3> = (0..30)
            .map(|frame| {
                let x = f64::from((frame - 9).clamp(0, 10)) * speed_mps / 30.0;
                DVec3::new(x, if frame < 20 { 0.0 } else { height_m }, 0.0)
            })
            .collect();
        FootPaths {
            n_frames: 30,
            rate_hz: 30.0,
            leg_length_m: 0.9 * scale,
            leg_spread_m: 0.0,
            scale,
            paths: [Some(path.clone()), None, Some(path), None],
        }
    }

    fn at_zero() -> RestingHeights {
        RestingHeights { height: [Some(0.0), None, Some(0.0), None], apart: false }
    }

    #[test]
    fn height_and_speed_both_bind() {
        let settings = ThesisSettings::default();
        let contacts = thesis_contacts(&feet(1.5, 0.04, 1.0), &at_zero(), &settings);
        let wanted: Vec<bool> = (0..30).map(|frame| !(10..20).contains(&frame)).collect();
        // Rising 4 cm in one frame is 1.2 m/s: frame 20 is off the ground by its speed, and closed as a gap is not.
        let wanted_with_rise: Vec<bool> = (0..30).map(|frame| wanted[frame] && frame != 20).collect();
        assert_eq!(contacts.stance_of(Foot::Left), wanted_with_rise);
        let high = thesis_contacts(&feet(1.5, 0.06, 1.0), &at_zero(), &settings);
        assert!(high.stance_of(Foot::Right)[20..].iter().all(|&stance| !stance));
        assert_eq!(high.tokens()[0], Token::Both);
    }

    #[test]
    fn a_sliding_foot_is_in_stance_but_not_pinned() {
        let contacts = thesis_contacts(&feet(0.7, 0.0, 1.0), &at_zero(), &ThesisSettings::default());
        assert!(contacts.stance[0].iter().all(|&stance| stance));
        let wanted: Vec<bool> = (0..30).map(|frame| !(10..20).contains(&frame)).collect();
        assert_eq!(contacts.pinned[0], wanted);
    }

    #[test]
    fn reported_heights_and_speeds_are_the_bodys_own() {
        let contacts = thesis_contacts(&feet(1.5, 0.04, 2.0), &at_zero(), &ThesisSettings::default());
        assert!((contacts.heights_m[0].as_ref().unwrap()[25] - 0.08).abs() < 1e-12);
        assert!((contacts.speeds_mps[2].as_ref().unwrap()[12] - 3.0).abs() < 1e-9);
        assert_eq!(contacts.heights_m[1], None);
    }

    #[test]
    fn one_frame_is_judged_by_height_alone() {
        let mut feet = feet(0.0, 0.0, 1.0);
        feet.n_frames = 1;
        for path in feet.paths.iter_mut().flatten() {
            path.truncate(1);
        }
        let contacts = thesis_contacts(&feet, &at_zero(), &ThesisSettings::default());
        assert_eq!(contacts.tokens(), [Token::Both]);
    }
}
