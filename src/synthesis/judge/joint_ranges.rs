//! How far joints turn: where their bones point, and how far they roll about them (GRAFTS 5, `limit_excess`).
//!
//! A joint's local rotation is a swing after a twist: the twist rolls the joint about its bone, the swing then carries the
//! bone to where it points in the parent's axes. The bone of a joint goes to the next one on the way to the head, failing
//! that to a wrist; beyond head and wrists to the first child or the leaf's end. Where that lies on the joint itself, the
//! bone that the joint ends is carried on. Measured in the poses, since files may replace offsets frame by frame.
//!
//! Everything counted is a whole number, so clips add up to the same in any order.

use super::super::subject::Movement;
use super::directions::{angle_to_nearest, cell_of, n_cells};
use crate::motion::{ChannelKind, Skeleton};
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Bins of the circle of twists, a quarter of a degree each.
const TWIST_BINS: u16 = 1440;
const BIN_RAD: f64 = TAU / TWIST_BINS as f64;
/// One in so many samples is left out at either end of a twist's range: 0.05 %.
const TAIL: u64 = 2000;
/// How far a bone may point beside the nearest cell that was visited: 3 degrees, more than half a cell.
const SWING_MARGIN_RAD: f64 = PI / 60.0;
/// A shorter bone has no direction.
const SHORTEST_BONE_M: f64 = 0.001;
/// Squared cosine of half the swing beyond which the twist is not defined: 170 degrees.
const TWIST_LOST: f64 = 0.0076;

/// How the joints of one layout turned in some frames: what becomes [`JointRange`]s.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RangeCounts {
    captured_ms: u64,
    /// By unique name.
    joints: BTreeMap<String, JointCounts>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct JointCounts {
    cells: BTreeSet<u16>,
    /// Frames by bin of twist.
    twists: BTreeMap<u16, u64>,
}

/// The range of a joint: where its bone pointed in captures, and how far it rolled about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointRange {
    /// Cells of directions that its bone visited, ascending; 3 degrees across, in the parent's axes.
    pub swing_cells: Vec<u16>,
    /// First quarter degree of the twist, counted from 0 degrees, and the number of them.
    pub twist_bins: [u16; 2],
}

/// A joint in one frame.
struct Turn {
    /// Where its bone points, parent's axes, unit length.
    swing: DVec3,
    /// Roll about the bone, modulo a turn. None: the swing is half a turn or nearly.
    twist_rad: Option<f64>,
}

/// A joint above the hips that can turn.
struct Turning {
    joint: usize,
    name: String,
    /// The point that its bone goes to.
    toward: Option<usize>,
}

impl RangeCounts {
    /// Counts the frames of a clip.
    pub fn of(movement: &Movement) -> RangeCounts {
        let count = |turning: Turning| {
            let mut counts = JointCounts::default();
            for turn in turns(movement, &turning) {
                counts.cells.insert(cell_of(turn.swing));
                if let Some(twist_rad) = turn.twist_rad {
                    *counts.twists.entry(twist_bin(twist_rad)).or_default() += 1;
                }
            }
            (turning.name, counts)
        };
        RangeCounts {
            captured_ms: (1000.0 * movement.n_frames() as f64 / movement.rate_hz).round() as u64,
            joints: turning_joints(movement).into_iter().map(count).collect(),
        }
    }

    /// Adds the frames of other clips of the same layout.
    pub fn add(&mut self, others: RangeCounts) {
        self.captured_ms += others.captured_ms;
        for (joint, other) in others.joints {
            let own = self.joints.entry(joint).or_default();
            own.cells.extend(other.cells);
            for (bin, count) in other.twists {
                *own.twists.entry(bin).or_default() += count;
            }
        }
    }

    /// How long the clips last together, milliseconds.
    pub fn captured_ms(&self) -> u64 {
        self.captured_ms
    }

    /// The ranges, by unique name of the joint.
    pub fn ranges(&self) -> BTreeMap<String, JointRange> {
        let seen = self.joints.iter().filter(|(_, counts)| !counts.cells.is_empty());
        seen.map(|(joint, counts)| (joint.clone(), counts.range())).collect()
    }
}

impl JointCounts {
    fn range(&self) -> JointRange {
        JointRange { swing_cells: self.cells.iter().copied().collect(), twist_bins: twist_range(&self.twists) }
    }
}

impl JointRange {
    /// Whether its numbers are those of cells and bins.
    pub fn is_sound(&self) -> bool {
        let [first, count] = self.twist_bins;
        self.swing_cells.iter().all(|&cell| usize::from(cell) < n_cells())
            && self.swing_cells.is_sorted_by(|a, b| a < b)
            && first < TWIST_BINS
            && (1..=TWIST_BINS).contains(&count)
    }

    fn excess_rad(&self, turn: &Turn) -> f64 {
        let inside = self.swing_cells.binary_search(&cell_of(turn.swing)).is_ok();
        let swing = if inside { 0.0 } else { angle_to_nearest(turn.swing, &self.swing_cells) - SWING_MARGIN_RAD };
        swing.max(turn.twist_rad.map_or(0.0, |twist_rad| self.twist_excess_rad(twist_rad)))
    }

    fn twist_excess_rad(&self, twist_rad: f64) -> f64 {
        let [first, width] = self.twist_bins.map(|bins| f64::from(bins) * BIN_RAD);
        let past = (twist_rad - first).rem_euclid(TAU);
        if past <= width { 0.0 } else { (past - width).min(TAU - past) }
    }
}

/// The worst angle of a clip outside these ranges over frames and joints, radians; 0: all of it is inside.
///
/// A swing counts by its angle to the center of the nearest visited cell, less 3 degrees; a twist by its angle to the
/// range. None: no joint of the clip has a range.
pub fn limit_excess(movement: &Movement, ranges: &BTreeMap<String, JointRange>) -> Option<f64> {
    let worst = |turning: Turning| {
        let range = ranges.get(&turning.name)?;
        turns(movement, &turning).map(|turn| range.excess_rad(&turn)).reduce(f64::max)
    };
    // All inside is 0 even where every swing is within the margin.
    turning_joints(movement).into_iter().filter_map(worst).reduce(f64::max).map(|excess| excess.max(0.0))
}

/// The joints on the way from hips to head and wrists that have rotation channels, with what their bones go to.
fn turning_joints(movement: &Movement) -> Vec<Turning> {
    let skeleton = &movement.skeleton;
    let marks = &movement.landmarks;
    let names = skeleton.unique_joint_names();
    let ends = skeleton.ends();
    let mut toward = BTreeMap::<usize, usize>::new();
    for tip in marks.head.into_iter().chain(marks.arms.iter().map(|arm| arm.wrist)) {
        let mut point = tip;
        while let Some(joint) = parent_of(skeleton, &ends, point) {
            toward.entry(joint).or_insert(point);
            point = joint;
        }
    }
    let children = skeleton.children();
    let beyond = |joint: usize| {
        let end = || ends.iter().position(|&with_end| with_end == joint).map(|end| skeleton.joints.len() + end);
        children[joint].first().copied().or_else(end)
    };
    let turns =
        |&joint: &usize| skeleton.joints[joint].channels.iter().any(|channel| channel.kind == ChannelKind::Rotation);
    let described = |joint: usize| Turning {
        joint,
        name: names[joint].clone(),
        toward: toward.get(&joint).copied().or_else(|| beyond(joint)),
    };
    movement.upper_joints().into_iter().filter(turns).map(described).collect()
}

fn parent_of(skeleton: &Skeleton, ends: &[usize], point: usize) -> Option<usize> {
    match point.checked_sub(skeleton.joints.len()) {
        Some(end) => Some(ends[end]),
        None => skeleton.joints[point].parent,
    }
}

/// A joint frame by frame; frames in which it has no bone are left out.
fn turns<'a>(movement: &'a Movement, turning: &'a Turning) -> impl Iterator<Item = Turn> + 'a {
    let joint = turning.joint;
    let parent = movement.skeleton.joints[joint].parent;
    (0..movement.n_frames()).filter_map(move |frame| {
        let parent = parent?;
        let bone = |from: usize, to: usize| {
            let offset = movement.poses.at(frame, to) - movement.poses.at(frame, from);
            let length = offset.length();
            let local = movement.rotations.world_at(frame, from).conjugate() * offset;
            (length > SHORTEST_BONE_M).then(|| local / length)
        };
        let axis = turning.toward.and_then(|to| bone(joint, to)).or_else(|| bone(parent, joint))?;
        let local = movement.rotations.local_at(frame, joint);
        let along = DVec3::new(local.x, local.y, local.z).dot(axis);
        let defined = along * along + local.w * local.w > TWIST_LOST;
        Some(Turn { swing: local * axis, twist_rad: defined.then(|| 2.0 * libm::atan2(along, local.w)) })
    })
}

fn twist_bin(twist_rad: f64) -> u16 {
    ((twist_rad.rem_euclid(TAU) / BIN_RAD) as u16).min(TWIST_BINS - 1)
}

/// First bin and number of bins between the two tails. Twist is circular: its range begins after the longest gap, which
/// no joint turns through. All of the circle where nothing was counted.
fn twist_range(twists: &BTreeMap<u16, u64>) -> [u16; 2] {
    let bins: Vec<u16> = twists.keys().copied().collect();
    let gap = |at: usize| {
        let before = bins[(at + bins.len() - 1) % bins.len()];
        // A single bin has all of the circle before it.
        (bins[at] + TWIST_BINS - before - 1) % TWIST_BINS
    };
    // Of equal gaps the first.
    let Some(start) = (0..bins.len()).rev().max_by_key(|&at| gap(at)) else { return [0, TWIST_BINS] };
    let in_turn: Vec<(u16, u64)> = bins[start..].iter().chain(&bins[..start]).map(|bin| (*bin, twists[bin])).collect();
    let tail = in_turn.iter().map(|(_, count)| count).sum::<u64>() / TAIL;
    let (low, high) = (past_tail(in_turn.iter(), tail), past_tail(in_turn.iter().rev(), tail));
    match (low, high) {
        (Some(low), Some(high)) => [low, (high + TWIST_BINS - low) % TWIST_BINS + 1],
        _ => [0, TWIST_BINS],
    }
}

/// The bin that holds the first sample after so many.
fn past_tail<'a>(bins: impl Iterator<Item = &'a (u16, u64)>, tail: u64) -> Option<u16> {
    let mut passed = 0;
    bins.map(|&(bin, count)| {
        passed += count;
        (bin, passed)
    })
    .find_map(|(bin, passed)| (passed > tail).then_some(bin))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::super::walker::mover;
    use super::*;
    use crate::motion::Role;

    /// Two seconds in which the left elbow bends and the neck turns: degrees at the start and the end.
    fn clip(elbow: [f64; 2], neck: [f64; 2]) -> Movement {
        let at = move |[from, to]: [f64; 2], time_s: f64| from + (to - from) * time_s / 2.0;
        let pose = move |time_s: f64, _| {
            // Z, X, Y: forward is a negative turn about X, and the neck's bone is Y.
            vec![(Role::ElbowLeft, [0.0, -at(elbow, time_s), 0.0]), (Role::Neck, [0.0, 0.0, at(neck, time_s)])]
        };
        mover(30.0, 61, 1.0, 0.0, &pose).movement
    }

    fn excess_deg(movement: &Movement, ranges: &BTreeMap<String, JointRange>) -> f64 {
        limit_excess(movement, ranges).unwrap().to_degrees()
    }

    #[test]
    fn an_elbow_bent_backwards_is_seen_and_what_was_captured_is_not() {
        let clean = clip([5.0, 60.0], [0.0, 0.0]);
        let ranges = RangeCounts::of(&clean).ranges();
        assert_eq!(excess_deg(&clean, &ranges), 0.0);
        assert_eq!(excess_deg(&clip([20.0, 40.0], [0.0, 0.0]), &ranges), 0.0);
        // 45 degrees from where the elbow begins, less the margin, give or take half a cell.
        let backwards = excess_deg(&clip([20.0, -40.0], [0.0, 0.0]), &ranges);
        assert!((backwards - 42.0).abs() < 2.2, "{backwards}");
        let too_far = excess_deg(&clip([20.0, 80.0], [0.0, 0.0]), &ranges);
        assert!((too_far - 17.0).abs() < 2.2, "{too_far}");
    }

    #[test]
    fn a_twist_is_held_against_its_range_wherever_the_circle_is_cut() {
        for middle in [0.0, 90.0, 180.0, -179.9, 270.0, 359.9] {
            let turned = |from: f64, to: f64| clip([0.0, 0.0], [middle + from, middle + to]);
            let ranges = RangeCounts::of(&turned(-30.0, 30.0)).ranges();
            // The edge of a bin may fall on the first frame.
            assert!(excess_deg(&turned(-30.0, 30.0), &ranges) < 1e-9, "{middle}");
            assert!(excess_deg(&turned(-360.0, -340.0), &ranges) < 1e-9, "{middle}");
            // A bin of slack at most.
            for (from, to, expected) in [(0.0, 70.0, 40.0), (-70.0, 0.0, 40.0), (180.0, 180.0, 150.0)] {
                let found = excess_deg(&turned(from, to), &ranges);
                assert!((found - expected).abs() <= 0.26, "{middle}: {found} {expected}");
            }
        }
    }

    #[test]
    fn clips_add_up_to_the_same_in_any_order() {
        let clips =
            [clip([0.0, 50.0], [170.0, 190.0]), clip([20.0, 90.0], [185.0, 200.0]), clip([0.0, 9.0], [0.0, 5.0])];
        let sum = |order: [usize; 3]| {
            let mut sum = RangeCounts::default();
            order.into_iter().for_each(|n| sum.add(RangeCounts::of(&clips[n])));
            sum
        };
        let expected = sum([0, 1, 2]);
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            assert_eq!(sum(order), expected, "{order:?}");
        }
        let ranges = expected.ranges();
        assert!(clips.iter().all(|clip| excess_deg(clip, &ranges) == 0.0));
        assert_eq!(expected.captured_ms(), 3 * 2033);
        assert!(
            ranges.contains_key("wrist_right") && !ranges.contains_key("hips") && !ranges.contains_key("knee_left")
        );
        assert!(ranges.values().all(JointRange::is_sound));
        assert_eq!(limit_excess(&clips[0], &BTreeMap::new()), None);
    }

    #[test]
    fn the_tails_of_a_twist_are_cut_and_the_rest_is_kept() {
        let bins = |bins: &[(u16, u64)]| twist_range(&bins.iter().copied().collect());
        assert_eq!(bins(&[]), [0, 1440]);
        assert_eq!(bins(&[(7, 1)]), [7, 1]);
        assert_eq!(bins(&[(1439, 5), (0, 5)]), [1439, 2]);
        // One in 2000 goes at either end, not two.
        assert_eq!(bins(&[(100, 1), (200, 1998), (300, 1)]), [200, 1]);
        assert_eq!(bins(&[(100, 2), (200, 1996), (300, 2)]), [100, 201]);
        assert_eq!(bins(&[(100, 1), (200, 1997), (300, 1)]), [100, 201]);
        let all: Vec<(u16, u64)> = (0..1440).map(|bin| (bin, 1)).collect();
        assert_eq!(bins(&all), [0, 1440]);
    }

    #[test]
    fn numbers_that_are_no_cells_or_bins_are_told() {
        let sound = JointRange { swing_cells: vec![1, 2], twist_bins: [1439, 1440] };
        assert!(sound.is_sound());
        for cells in [vec![2, 1], vec![1, 1], vec![u16::MAX], vec![n_cells() as u16]] {
            assert!(!JointRange { swing_cells: cells, ..sound.clone() }.is_sound());
        }
        for twist_bins in [[1440, 1], [0, 0], [0, 1441]] {
            assert!(!JointRange { twist_bins, ..sound.clone() }.is_sound());
        }
    }
}
