//! A clip's gaits and plants as rows of characters, time from left to right.

use crate::annotate::{Foot, Gait, Plant, Segment};

/// Characters of a row; fewer where there are fewer frames.
const WIDTH: usize = 72;

/// Three rows of one length.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Timeline {
    /// `S W R J`, `?` for unknown.
    pub(super) gait: String,
    /// `_` where the left foot is planted.
    pub(super) left: String,
    /// `_` where the right foot is planted.
    pub(super) right: String,
}

/// Each character stands for the frames of its share of the clip: what most of them are.
pub(super) fn timeline(n_frames: usize, segments: &[Segment], plants: &[Plant]) -> Timeline {
    let width = n_frames.min(WIDTH);
    let mut gaits = vec!['?'; n_frames];
    for segment in segments {
        paint(&mut gaits, segment.first, segment.end, letter(segment.gait));
    }
    let feet = [Foot::Left, Foot::Right].map(|foot| {
        let mut planted = vec![' '; n_frames];
        plants
            .iter()
            .filter(|plant| plant.foot == foot)
            .for_each(|plant| paint(&mut planted, plant.first, plant.end, '_'));
        planted
    });
    let row = |frames: &[char]| -> String {
        (0..width).map(|place| most(&frames[place * n_frames / width..(place + 1) * n_frames / width])).collect()
    };
    let [left, right] = feet.map(|foot| row(&foot));
    Timeline { gait: row(&gaits), left, right }
}

/// The letter of a gait.
pub(super) fn letter(gait: Gait) -> char {
    match gait {
        Gait::Stand => 'S',
        Gait::Walk => 'W',
        Gait::Run => 'R',
        Gait::Jump => 'J',
        Gait::Unknown | Gait::Other => '?',
    }
}

fn paint(frames: &mut [char], first: u32, end: u32, letter: char) {
    let end = frames.len().min(end as usize);
    if let Some(range) = frames.get_mut(first as usize..end) {
        range.fill(letter);
    }
}

/// The commonest, the earliest of several.
fn most(frames: &[char]) -> char {
    let count = |letter: char| frames.iter().filter(|&&other| other == letter).count();
    let mut best = frames.first().copied().unwrap_or(' ');
    for &letter in frames {
        if count(letter) > count(best) {
            best = letter;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant(foot: Foot, first: u32, end: u32) -> Plant {
        Plant { foot, first, end, position: [0.0; 3], slip_m: 0.0, confidence: None }
    }

    #[test]
    fn each_character_is_what_most_of_its_frames_are() {
        let segment = |gait, first, end| Segment { gait, first, end, confidence: None };
        let segments = [segment(Gait::Stand, 0, 100), segment(Gait::Walk, 100, 720)];
        let line = timeline(720, &segments, &[plant(Foot::Left, 0, 200), plant(Foot::Right, 196, 720)]);
        assert_eq!(line.gait, "S".repeat(10) + &"W".repeat(62));
        assert_eq!(line.left, "_".repeat(20) + &" ".repeat(52));
        // Four of ten frames are fewer than six.
        assert_eq!(line.right, " ".repeat(20) + &"_".repeat(52));
    }

    #[test]
    fn a_short_clip_has_a_short_line_and_odd_ranges_do_no_harm() {
        assert_eq!(timeline(3, &[], &[plant(Foot::Left, 1, 99), plant(Foot::Right, 7, 9)]).left, " __");
        assert_eq!(timeline(0, &[], &[]), Timeline::default());
    }
}
