//! What grafting and judging need of a clip: who moves, how, and which joints are which part.

use super::parts::Parts;
use crate::annotate::labels::Foot;
use crate::motion::chains::BodyChains;
use crate::motion::kinematics::poses_and_rotations;
use crate::motion::rotation::slerp;
use crate::motion::{Clip, Poses, Role, RoleMap, Rotations, Skeleton};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// A clip that can be base or donor: its channels, its movement at its own rate, its parts.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The clip as read.
    pub clip: Arc<Clip>,
    /// Where its joints are, and how they turn.
    pub movement: Movement,
    /// Its joints by part of the body.
    pub parts: Parts,
}

/// A body in motion, at its clip's rate or resampled: what correlation and figures read.
#[derive(Clone, Debug)]
pub struct Movement {
    /// Its joints.
    pub skeleton: Arc<Skeleton>,
    /// Frames a second.
    pub rate_hz: f64,
    /// World positions of all points, metres.
    pub poses: Poses,
    /// Local and world rotations of all joints.
    pub rotations: Rotations,
    /// Which point is what.
    pub landmarks: Landmarks,
}

/// The points that definitions speak of. Sides are in the order of [`SIDES`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Landmarks {
    /// Root of legs and trunk.
    pub hips: usize,
    /// Above the hips, below the chest.
    pub spine: Option<usize>,
    /// A joint: its rotation is chest space.
    pub chest: usize,
    /// Base of the neck.
    pub neck: Option<usize>,
    /// Base of the skull.
    pub head: Option<usize>,
    /// Left, right.
    pub arms: [ArmPoints; 2],
    /// Left, right.
    pub legs: [LegPoints; 2],
}

/// Points of one arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct ArmPoints {
    pub shoulder: usize,
    pub elbow: usize,
    pub wrist: usize,
}

/// Points of one leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub struct LegPoints {
    pub thigh: usize,
    pub knee: usize,
    pub ankle: usize,
    /// The ankle where there is no toe.
    pub toe: usize,
}

/// Left, then right: the order of all pairs here.
pub const SIDES: [Foot; 2] = [Foot::Left, Foot::Right];

/// Rates of base and donor may lie this factor apart; captures lie between 20 and 480 Hz.
pub const MAX_RATE_RATIO: f64 = 64.0;

/// Why a clip can be neither base nor donor.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// A joint that every definition needs is not known.
    #[error("no joint has the role {}", .0.name())]
    MissingRole(Role),
    /// Hips or chest is the end of a leaf, so it has no rotation.
    #[error("the role {} is no joint but the end of one", .0.name())]
    NotAJoint(Role),
    /// The roles are there but don't lie like a body: legs below the hips, arms above.
    #[error("the joints with roles don't lie like those of a body")]
    NoChains,
    /// Fewer than two frames.
    #[error("{0} frames are too few")]
    TooShort(usize),
}

impl Subject {
    /// A subject from a clip and its roles; kinematics are solved here.
    ///
    /// # Errors
    /// [`Unfit`]: hips, chest, or a joint of an arm or leg (but for the toe) is not known, or there are fewer than two frames.
    pub fn new(clip: Arc<Clip>, roles: &RoleMap) -> Result<Subject, Unfit> {
        let movement = Movement::of_clip(&clip, roles)?;
        let chains = BodyChains::of_roles(&clip.skeleton, roles).ok_or(Unfit::NoChains)?;
        let parts = Parts::of(&chains);
        Ok(Subject { clip, movement, parts })
    }
}

impl Movement {
    /// The movement of a clip at its own rate. Errors as [`Subject::new`].
    pub fn of_clip(clip: &Clip, roles: &RoleMap) -> Result<Movement, Unfit> {
        let landmarks = Landmarks::of(&clip.skeleton, roles)?;
        if clip.n_frames < 2 {
            return Err(Unfit::TooShort(clip.n_frames));
        }
        let (poses, rotations) = poses_and_rotations(clip);
        Ok(Movement { skeleton: clip.skeleton.clone(), rate_hz: clip.rate_hz, poses, rotations, landmarks })
    }

    /// Number of frames.
    pub fn n_frames(&self) -> usize {
        self.poses.n_frames
    }

    /// The path of a point less the path of another, `[frame]`, metres.
    pub fn path_from(&self, point: usize, origin: usize) -> Vec<DVec3> {
        (0..self.n_frames()).map(|frame| self.poses.at(frame, point) - self.poses.at(frame, origin)).collect()
    }

    /// The path of a point about another in the chest's axes, `[frame]`, metres.
    pub fn path_in_chest(&self, point: usize, origin: usize) -> Vec<DVec3> {
        let turned = |(frame, offset)| self.rotations.world_at(frame, self.landmarks.chest).conjugate() * offset;
        self.path_from(point, origin).into_iter().enumerate().map(turned).collect()
    }

    /// The joints on the way from the hips (without them) to the head and both wrists: trunk, neck, arms.
    pub fn upper_joints(&self) -> Vec<usize> {
        let ends = self.skeleton.ends();
        let marks = &self.landmarks;
        let tips = [marks.head, Some(marks.arms[0].wrist), Some(marks.arms[1].wrist), Some(marks.chest)];
        let mut joints: Vec<usize> = tips
            .into_iter()
            .flatten()
            .flat_map(|tip| ancestry(&self.skeleton, joint_of(&self.skeleton, &ends, tip)))
            .filter(|&joint| joint > marks.hips && descends(&self.skeleton, joint, marks.hips))
            .collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    }

    /// Hips' ends of both thighs, knees and ankles: the joints whose rotations move the legs.
    pub fn leg_joints(&self) -> Vec<usize> {
        let n_joints = self.skeleton.joints.len();
        let legs = self.landmarks.legs.iter();
        legs.flat_map(|leg| [leg.thigh, leg.knee, leg.ankle]).filter(|&point| point < n_joints).collect()
    }

    /// Thigh plus shank, left, median over the clip, metres.
    pub fn leg_length_m(&self) -> f64 {
        let leg = self.landmarks.legs[0];
        let at = |frame, point| self.poses.at(frame, point);
        let lengths: Vec<f64> = (0..self.n_frames())
            .map(|frame| {
                at(frame, leg.thigh).distance(at(frame, leg.knee)) + at(frame, leg.knee).distance(at(frame, leg.ankle))
            })
            .collect();
        super::signal::median(&lengths).unwrap_or(0.0)
    }

    /// The same movement at another rate, from the first frame on: rotations by slerp, offsets linearly.
    ///
    /// The result holds as many frames as fit between the first and the last. None: the rates lie more than
    /// [`MAX_RATE_RATIO`] apart, so that the result could be out of all proportion.
    pub fn resampled(&self, rate_hz: f64) -> Option<Movement> {
        if !rates_are_near(self.rate_hz, rate_hz) {
            return None;
        }
        let n_joints = self.skeleton.joints.len();
        let ends = self.skeleton.ends();
        let n_points = n_joints + ends.len();
        let last = self.n_frames() - 1;
        let step = self.rate_hz / rate_hz;
        // A hair of slack: the last frame must not be lost to rounding.
        let n_frames = (last as f64 / step + 1e-9) as usize + 1;
        let offset = |frame: usize, point: usize, parent: usize| {
            let moved = self.poses.at(frame, point) - self.poses.at(frame, parent);
            self.rotations.world_at(frame, parent).conjugate() * moved
        };
        let mut world = Vec::with_capacity(n_frames * n_points);
        let mut local_rotations: Vec<DQuat> = Vec::with_capacity(n_frames * n_joints);
        let mut world_rotations: Vec<DQuat> = Vec::with_capacity(n_frames * n_joints);
        for frame in 0..n_frames {
            let (before, share) = split_frame(frame as f64 * step, self.n_frames());
            let first = world_rotations.len();
            let mut points: Vec<DVec3> = Vec::with_capacity(n_points);
            for point in 0..n_points {
                let parent = match point.checked_sub(n_joints) {
                    Some(end) => Some(ends[end]),
                    None => self.skeleton.joints[point].parent,
                };
                points.push(match parent {
                    None => self.poses.at(before, point).lerp(self.poses.at(before + 1, point), share),
                    Some(parent) => {
                        let offset = offset(before, point, parent).lerp(offset(before + 1, point, parent), share);
                        points[parent] + world_rotations[first + parent] * offset
                    }
                });
                if point < n_joints {
                    let (a, b) = (self.rotations.local_at(before, point), self.rotations.local_at(before + 1, point));
                    let turn = slerp(a, b, share);
                    world_rotations.push(parent.map_or(turn, |parent| world_rotations[first + parent] * turn));
                    let flip = frame > 0 && local_rotations[(frame - 1) * n_joints + point].dot(turn) < 0.0;
                    local_rotations.push(if flip { -turn } else { turn });
                }
            }
            world.extend(points);
        }
        Some(Movement {
            skeleton: self.skeleton.clone(),
            rate_hz,
            poses: Poses { n_frames, n_points, world },
            rotations: Rotations { n_frames, n_joints, local: local_rotations, world: world_rotations },
            landmarks: self.landmarks.clone(),
        })
    }
}

impl Landmarks {
    /// The landmarks of a skeleton with known roles.
    ///
    /// # Errors
    /// [`Unfit::MissingRole`], [`Unfit::NotAJoint`].
    pub fn of(skeleton: &Skeleton, roles: &RoleMap) -> Result<Landmarks, Unfit> {
        use Role::*;
        let need = |role: Role| roles.get(role).ok_or(Unfit::MissingRole(role));
        let arm = |roles: [Role; 3]| {
            let [shoulder, elbow, wrist] = roles.map(need);
            Ok(ArmPoints { shoulder: shoulder?, elbow: elbow?, wrist: wrist? })
        };
        let leg = |needed: [Role; 3], toe: Role| {
            let [thigh, knee, ankle] = needed.map(need);
            let ankle = ankle?;
            Ok(LegPoints { thigh: thigh?, knee: knee?, ankle, toe: roles.get(toe).unwrap_or(ankle) })
        };
        let landmarks = Landmarks {
            hips: need(Hips)?,
            spine: roles.get(Spine),
            chest: need(Chest)?,
            neck: roles.get(Neck),
            head: roles.get(Head),
            arms: [arm([ShoulderLeft, ElbowLeft, WristLeft])?, arm([ShoulderRight, ElbowRight, WristRight])?],
            legs: [
                leg([ThighLeft, KneeLeft, AnkleLeft], ToeLeft)?,
                leg([ThighRight, KneeRight, AnkleRight], ToeRight)?,
            ],
        };
        for (role, point) in [(Hips, landmarks.hips), (Chest, landmarks.chest)] {
            if point >= skeleton.joints.len() {
                return Err(Unfit::NotAJoint(role));
            }
        }
        Ok(landmarks)
    }
}

/// Whether two rates lie at most [`MAX_RATE_RATIO`] apart.
pub(super) fn rates_are_near(a_hz: f64, b_hz: f64) -> bool {
    let ratio = a_hz / b_hz;
    // Both comparisons are false for NaN.
    (1.0 / MAX_RATE_RATIO..=MAX_RATE_RATIO).contains(&ratio)
}

/// The frame before a fractional one and the share of the next; held at both ends. `n_frames` >= 2.
pub(super) fn split_frame(at: f64, n_frames: usize) -> (usize, f64) {
    let at = at.clamp(0.0, (n_frames - 1) as f64);
    let before = (at as usize).min(n_frames - 2);
    (before, at - before as f64)
}

/// A point's joint: itself, or the one whose end it is.
pub(super) fn joint_of(skeleton: &Skeleton, ends: &[usize], point: usize) -> usize {
    point.checked_sub(skeleton.joints.len()).map_or(point, |end| ends[end])
}

/// A joint, its parent, and so on to its root.
pub(super) fn ancestry(skeleton: &Skeleton, joint: usize) -> impl Iterator<Item = usize> {
    core::iter::successors(Some(joint), |&joint| skeleton.joints[joint].parent)
}

/// Whether a joint is another or below it.
pub(super) fn descends(skeleton: &Skeleton, joint: usize, ancestor: usize) -> bool {
    ancestry(skeleton, joint).any(|above| above == ancestor)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::walker::walker;
    use super::*;

    #[test]
    fn resampling_to_the_own_rate_changes_nothing() {
        let subject = walker(60.0, 90, 1.0);
        let again = subject.movement.resampled(60.0).unwrap();
        assert_eq!(again.n_frames(), 90);
        let pairs = again.poses.world.iter().zip(&subject.movement.poses.world);
        assert!(pairs.map(|(a, b)| a.distance(*b)).all(|distance| distance < 1e-12));
    }

    #[test]
    fn halving_the_rate_keeps_every_second_frame() {
        let subject = walker(60.0, 91, 1.0);
        let half = subject.movement.resampled(30.0).unwrap();
        assert!(subject.movement.resampled(1e9).is_none() && subject.movement.resampled(f64::NAN).is_none());
        assert_eq!(half.n_frames(), 46);
        for frame in 0..46 {
            for point in 0..half.poses.n_points {
                let far = half.poses.at(frame, point).distance(subject.movement.poses.at(2 * frame, point));
                assert!(far < 1e-12, "{frame} {point} {far}");
            }
        }
    }

    #[test]
    fn a_clip_without_a_chest_is_unfit() {
        let subject = walker(30.0, 10, 1.0);
        let roles = RoleMap::default();
        assert_eq!(Subject::new(subject.clip.clone(), &roles).unwrap_err(), Unfit::MissingRole(Role::Hips));
    }
}
