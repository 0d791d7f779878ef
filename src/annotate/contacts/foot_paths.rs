//! The paths of ankles and toes, in the scale of a body with a leg of 0.9 m.

use crate::annotate::labels::Foot;
use crate::annotate::order_statistics::{median, robust_deviation};
use crate::motion::{Poses, Role, RoleMap};
use glam::DVec3;

/// Leg (hip to ankle) of the body that all thresholds of contacts are meant for (CONTACTS 2.1), metres.
pub const REFERENCE_LEG_M: f64 = 0.9;

/// A leg shorter than this is none (every joint at one point): positions are then taken as they are, metres.
const SHORTEST_LEG_M: f64 = 1e-3;

/// The joints that feet are judged by, in the order of every `[_; 4]` here: left ankle, left toe, right ankle,
/// right toe.
pub const FOOT_JOINTS: [Role; 4] = [Role::AnkleLeft, Role::ToeLeft, Role::AnkleRight, Role::ToeRight];

/// Both feet, left first.
pub const FEET: [Foot; 2] = [Foot::Left, Foot::Right];

/// Paths of the feet's joints.
#[derive(Clone, Debug, PartialEq)]
pub struct FootPaths {
    /// Number of frames.
    pub n_frames: usize,
    /// Frames a second.
    pub rate_hz: f64,
    /// Mean of both sides' median thigh plus shank, metres.
    pub leg_length_m: f64,
    /// Mean of both sides' robust standard deviations of that length over the clip, metres: 0 for rigid bones.
    pub leg_spread_m: f64,
    /// Metres a scaled metre: `leg / 0.9` (CONTACTS 2.1).
    pub scale: f64,
    /// `[foot joint][frame]`, scaled metres, world, Y up. None: no toe. An ankle is always there.
    pub paths: [Option<Vec<DVec3>>; 4],
}

/// Indices of a foot's joints in [`FOOT_JOINTS`]: ankle, toe.
pub fn joints_of(foot: Foot) -> [usize; 2] {
    [2 * foot as usize, 2 * foot as usize + 1]
}

impl FootPaths {
    /// The feet's paths in scaled metres. None: the legs aren't known from hip to ankle, or have no length.
    pub fn new(poses: &Poses, roles: &RoleMap, rate_hz: f64) -> Option<FootPaths> {
        let mut feet = FootPaths::unscaled(poses, roles, rate_hz)?;
        if feet.leg_length_m <= SHORTEST_LEG_M {
            return None;
        }
        feet.scale = feet.leg_length_m / REFERENCE_LEG_M;
        for position in feet.paths.iter_mut().flatten().flatten() {
            *position /= feet.scale;
        }
        Some(feet)
    }

    /// The same in metres, scale 1: what the thesis' thresholds are applied to when they are compared with others'.
    pub fn unscaled(poses: &Poses, roles: &RoleMap, rate_hz: f64) -> Option<FootPaths> {
        if !roles.has_feet() {
            return None;
        }
        let left = leg_length_m(poses, roles, [Role::ThighLeft, Role::KneeLeft, Role::AnkleLeft])?;
        let right = leg_length_m(poses, roles, [Role::ThighRight, Role::KneeRight, Role::AnkleRight])?;
        let paths = FOOT_JOINTS.map(|role| roles.get(role).map(|point| poses.path(point)));
        Some(FootPaths {
            n_frames: poses.n_frames,
            rate_hz,
            leg_length_m: (left.0 + right.0) / 2.0,
            leg_spread_m: (left.1 + right.1) / 2.0,
            scale: 1.0,
            paths,
        })
    }

    /// The path that stands for where a foot is: its toe's, or its ankle's where there is no toe.
    pub fn ball(&self, foot: Foot) -> &[DVec3] {
        let [ankle, toe] = joints_of(foot).map(|joint| self.paths[joint].as_deref());
        toe.or(ankle).unwrap_or(&[])
    }

    /// Frames in `seconds`, to the nearest (ties to even), at least one.
    pub fn frames_in(&self, seconds: f64) -> usize {
        ((seconds * self.rate_hz).round_ties_even() as usize).max(1)
    }
}

/// Distances between a joint's positions `step` frames apart times `rate / step`: entry `i` is the speed from frame
/// `i` to `i + step`, in units a second. `n_frames - step` entries, none in a shorter clip.
pub fn speeds(path: &[DVec3], step: usize, rate_hz: f64) -> Vec<f64> {
    let per_second = rate_hz / step as f64;
    path.iter().zip(path.get(step..).unwrap_or(&[])).map(|(from, to)| (*to - *from).length() * per_second).collect()
}

/// Median of thigh plus shank of one side, and its robust standard deviation. None: a role is missing; 0 in an empty
/// clip.
fn leg_length_m(poses: &Poses, roles: &RoleMap, leg: [Role; 3]) -> Option<(f64, f64)> {
    let [hip, knee, ankle] = leg.map(|role| roles.get(role));
    let (hip, knee, ankle) = (hip?, knee?, ankle?);
    let mut lengths: Vec<f64> = (0..poses.n_frames)
        .map(|frame| {
            let knee = poses.at(frame, knee);
            (poses.at(frame, hip) - knee).length() + (knee - poses.at(frame, ankle)).length()
        })
        .collect();
    let middle = median(&mut lengths).unwrap_or(0.0);
    for length in &mut lengths {
        *length = (*length - middle).abs();
    }
    Some((middle, robust_deviation(&mut lengths).unwrap_or(0.0)))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn legs(size: f64, n_frames: usize, toes: bool) -> (Poses, RoleMap) {
        let mut roles = RoleMap::default();
        let named = [
            Role::Hips,
            Role::ThighLeft,
            Role::KneeLeft,
            Role::AnkleLeft,
            Role::ThighRight,
            Role::KneeRight,
            Role::AnkleRight,
            Role::ToeLeft,
            Role::ToeRight,
        ];
        for (point, role) in named.into_iter().enumerate().take(if toes { 9 } else { 7 }) {
            roles.set(role, point);
        }
        let heights = [1.0, 1.0, 0.5, 0.1, 1.0, 0.5, 0.1, 0.05, 0.05];
        let world = (0..n_frames)
            .flat_map(|frame| heights.map(|height| DVec3::new(frame as f64 * 0.01, height, 0.0) * size))
            .collect();
        (Poses { n_frames, n_points: 9, world }, roles)
    }

    #[test]
    fn every_body_is_brought_to_one_size() {
        for size in [0.01, 1.0, 100.0] {
            let (poses, roles) = legs(size, 5, true);
            let feet = FootPaths::new(&poses, &roles, 30.0).unwrap();
            assert!((feet.leg_length_m - 0.9 * size).abs() < 1e-12 * size, "{}", feet.leg_length_m);
            assert!((feet.ball(Foot::Right)[3] - DVec3::new(0.03, 0.05, 0.0)).length() < 1e-12, "size {size}");
        }
    }

    #[test]
    fn feet_without_toes_stand_on_their_ankles_and_half_a_leg_is_none() {
        let (poses, mut roles) = legs(1.0, 2, false);
        let feet = FootPaths::new(&poses, &roles, 30.0).unwrap();
        assert!(feet.paths[1].is_none() && (feet.ball(Foot::Left)[0].y - 0.1).abs() < 1e-12);
        roles = RoleMap::default();
        roles.set(Role::AnkleLeft, 3);
        assert_eq!(FootPaths::new(&poses, &roles, 30.0), None);
    }

    #[test]
    fn a_body_without_extent_has_no_feet() {
        let (mut poses, roles) = legs(1.0, 2, true);
        poses.world.fill(DVec3::ONE);
        assert_eq!(FootPaths::new(&poses, &roles, 30.0), None);
    }

    #[test]
    fn speeds_are_per_second() {
        let path = [DVec3::ZERO, DVec3::X, DVec3::X * 3.0];
        assert_eq!(speeds(&path, 1, 30.0), [30.0, 60.0]);
        assert_eq!(speeds(&path, 2, 30.0), [45.0]);
        assert!(speeds(&path, 3, 30.0).is_empty());
        assert!(speeds(&path, 9, 30.0).is_empty());
    }
}
