//! Which foot is on the ground: the thesis' detector (T 3.1.1).

use super::foot_paths::{FEET, FootPaths, joints_of, speeds};
use super::gait_tokens::Token;
use super::labels::Foot;
use super::resting_height::RestingHeights;
use serde::{Deserialize, Serialize};

/// A foot may be locked where its slower joint moves at less than this share of the speed threshold.
pub const PINNED_SHARE: f64 = 0.5;

/// How feet on the ground are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// Height and speed below fixed thresholds, gaps closed (T 3.1).
    #[default]
    Thesis,
}

/// Thresholds of foot contacts. Lengths are those of a body with a leg (hip to ankle) of 0.9 m (CONTACTS 2.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactSettings {
    /// Which detector.
    pub detector: Detector,
    /// A planted joint is within this distance of its resting height (T 3.1: epsilon).
    pub max_height_m: f64,
    /// A planted joint is slower than this (T 3.1: eta).
    pub max_speed_mps: f64,
    /// A joint that is off the ground is planted all the same if it is planted at most this long before and after
    /// (T 3.1: the debounce's window w).
    pub close_gap_s: f64,
}

impl Default for ContactSettings {
    /// 5 cm, 1.0 m/s, 0.05 s: the best fixed pair under the step classifier (CONTACTS 1, 4).
    fn default() -> Self {
        ContactSettings { detector: Detector::Thesis, max_height_m: 0.05, max_speed_mps: 1.0, close_gap_s: 0.05 }
    }
}

/// Contacts of a clip's feet.
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    /// `[foot][frame]`: in stance (phase, gait).
    pub stance: [Vec<bool>; 2],
    /// `[foot][frame]`: may be locked to its place: in stance, and its slower joint below half the speed threshold.
    pub pinned: [Vec<bool>; 2],
    /// `[foot joint][frame]`: above (below: negative) the resting height, metres, in the body's own size.
    pub heights_m: [Option<Vec<f64>>; 4],
    /// `[foot joint][frame]`: from the frame before, m/s, in the body's own size; frame 0 takes frame 1's.
    pub speeds_mps: [Option<Vec<f64>>; 4],
}

impl Contacts {
    /// Which feet are planted, frame by frame.
    pub fn tokens(&self) -> Vec<Token> {
        self.stance[0].iter().zip(&self.stance[1]).map(|(&left, &right)| Token::of_feet(left, right)).collect()
    }

    /// Whether a foot is in stance, `[frame]`.
    pub fn stance_of(&self, foot: Foot) -> &[bool] {
        &self.stance[foot as usize]
    }
}

/// The thesis' detector (T 3.1.1; CONTACTS 4): a joint is planted where `|height - rest| < max_height_m` and its
/// speed from the frame before is `< max_speed_mps`; short gaps are closed per joint; a foot is planted where its
/// ankle or its toe is.
///
/// A clip of one frame has no speeds: they count as zero. No frames give no labels.
pub fn thesis_contacts(feet: &FootPaths, rest: &RestingHeights, settings: &ContactSettings) -> Contacts {
    let heights = [0, 1, 2, 3].map(|joint| {
        let (path, rest) = (feet.paths[joint].as_deref()?, rest.height[joint].unwrap_or(0.0));
        Some(path.iter().map(|position| position.y - rest).collect::<Vec<f64>>())
    });
    let speeds = feet.paths.each_ref().map(|path| path.as_deref().map(|path| backward_speeds(path, feet.rate_hz)));
    let window = feet.frames_in(settings.close_gap_s);
    let planted = [0, 1, 2, 3].map(|joint| {
        let (heights, speeds) = (heights[joint].as_ref()?, speeds[joint].as_ref()?);
        let mut planted: Vec<bool> = heights
            .iter()
            .zip(speeds)
            .map(|(height, &speed)| height.abs() < settings.max_height_m && speed < settings.max_speed_mps)
            .collect();
        close_gaps(&mut planted, window);
        Some(planted)
    });
    let stance = FEET.map(|foot| {
        let joints = joints_of(foot).map(|joint| planted[joint].as_deref());
        (0..feet.n_frames).map(|frame| joints.iter().flatten().any(|planted| planted[frame])).collect::<Vec<bool>>()
    });
    let pinned = FEET.map(|foot| {
        let joints = joints_of(foot).map(|joint| speeds[joint].as_deref());
        let slow =
            |frame: usize| joints.iter().flatten().any(|speeds| speeds[frame] < PINNED_SHARE * settings.max_speed_mps);
        (0..feet.n_frames).map(|frame| stance[foot as usize][frame] && slow(frame)).collect()
    });
    let own_size = |values: [Option<Vec<f64>>; 4]| {
        values.map(|values| values.map(|values| values.into_iter().map(|value| value * feet.scale).collect()))
    };
    Contacts { stance, pinned, heights_m: own_size(heights), speeds_mps: own_size(speeds) }
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
            scale,
            paths: [Some(path.clone()), None, Some(path), None],
        }
    }

    fn at_zero() -> RestingHeights {
        RestingHeights { height: [Some(0.0), None, Some(0.0), None], apart: false }
    }

    #[test]
    fn height_and_speed_both_bind() {
        let settings = ContactSettings::default();
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
        let contacts = thesis_contacts(&feet(0.7, 0.0, 1.0), &at_zero(), &ContactSettings::default());
        assert!(contacts.stance[0].iter().all(|&stance| stance));
        let wanted: Vec<bool> = (0..30).map(|frame| !(10..20).contains(&frame)).collect();
        assert_eq!(contacts.pinned[0], wanted);
    }

    #[test]
    fn reported_heights_and_speeds_are_the_bodys_own() {
        let contacts = thesis_contacts(&feet(1.5, 0.04, 2.0), &at_zero(), &ContactSettings::default());
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
        let contacts = thesis_contacts(&feet, &at_zero(), &ContactSettings::default());
        assert_eq!(contacts.tokens(), [Token::Both]);
    }
}
