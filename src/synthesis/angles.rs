//! From a local rotation back to the numbers of a joint's own channels.
//!
//! A joint that turns about three axes can show any rotation; with fewer it gets the nearest one it can show. Of the
//! ways to write a rotation the one nearest to the previous frame's numbers is taken, so that channels stay smooth.

use crate::motion::Skeleton;
use crate::motion::kinematics::rest_rotation;
use crate::motion::rotation::{about, euler_near, rotation_vector, unwrap};
use crate::motion::skeleton::{AngleUnit, Axis, ChannelKind, Format};
use core::f64::consts::{PI, TAU};
use glam::DQuat;

/// How a joint's rotation channels compose, and back.
#[derive(Clone, Debug)]
pub struct JointAngles {
    /// Axis and column (in the frame) of each rotation channel; the outermost rotation first.
    turns: Vec<(Axis, usize)>,
    /// Acclaim's `C`; identity elsewhere.
    rest: DQuat,
    /// Channel units a radian.
    per_radian: f64,
}

impl JointAngles {
    /// The rotation channels of a joint. None: they can't be solved for (four or more, or an axis twice).
    ///
    /// `first_channel` is the column of the joint's first channel ([`Skeleton::first_channels`]).
    pub fn of(skeleton: &Skeleton, joint: usize, first_channel: usize) -> Option<JointAngles> {
        let described = &skeleton.joints[joint];
        let listed = described.channels.iter().enumerate();
        let mut turns: Vec<(Axis, usize)> = listed
            .filter(|(_, channel)| channel.kind == ChannelKind::Rotation)
            .map(|(n, channel)| (channel.axis, first_channel + n))
            .collect();
        if skeleton.format == Format::Amc {
            // The axis line's letters rule, the last being the outermost; not the order of the numbers.
            let letters = described.axis.map_or([Axis::X, Axis::Y, Axis::Z], |axis| axis.order);
            turns.sort_by_key(|&(axis, _)| core::cmp::Reverse(letters.iter().position(|&letter| letter == axis)));
        }
        let repeats = (1..turns.len()).any(|n| turns[..n].iter().any(|turn| turn.0 == turns[n].0));
        let per_radian = match skeleton.angle_unit {
            AngleUnit::Degrees => 180.0 / PI,
            AngleUnit::Radians => 1.0,
        };
        let rest = described.axis.map_or(DQuat::IDENTITY, rest_rotation);
        (!repeats).then_some(JointAngles { turns, rest, per_radian })
    }

    /// Columns of the channels, in the order of the angles that [`Self::solve`] gives.
    pub fn columns(&self) -> impl Iterator<Item = usize> {
        self.turns.iter().map(|turn| turn.1)
    }

    /// The numbers in the channels of a frame.
    pub fn read(&self, frame: &[f32]) -> Vec<f64> {
        self.columns().map(|column| f64::from(frame[column])).collect()
    }

    /// The joint's numbers for a local rotation, near those of the previous frame.
    pub fn solve(&self, local: DQuat, previous: &[f64]) -> Vec<f64> {
        let wanted = self.rest.conjugate() * local * self.rest;
        let before = |n: usize| previous[n] / self.per_radian;
        let angles: Vec<f64> = match self.turns[..] {
            [] => Vec::new(),
            [(axis, _)] => vec![unwrap(twist(wanted, axis), before(0), TAU)],
            [(a, _), (b, _)] => two_angles(wanted, [a, b], [before(0), before(1)]).to_vec(),
            [(a, _), (b, _), (c, _), ..] => euler_near(wanted, [a, b, c], [before(0), before(1), before(2)]).to_vec(),
        };
        angles.into_iter().map(|angle| angle * self.per_radian).collect()
    }

    /// The local rotation that numbers mean.
    pub fn rotation(&self, values: &[f64]) -> DQuat {
        let turned = self.turns.iter().zip(values).map(|(turn, value)| about(turn.0, value / self.per_radian));
        self.rest * turned.fold(DQuat::IDENTITY, |product, turn| product * turn) * self.rest.conjugate()
    }

    /// Angle between a wanted rotation and the one that numbers mean, radians.
    pub fn error_rad(&self, wanted: DQuat, values: &[f64]) -> f64 {
        rotation_vector(wanted.conjugate() * self.rotation(values)).length()
    }

    /// How many units make a whole turn.
    pub fn whole_turn(&self) -> f64 {
        TAU * self.per_radian
    }
}

/// The angle about an axis that comes nearest to a rotation.
fn twist(rotation: DQuat, axis: Axis) -> f64 {
    2.0 * libm::atan2(rotation.to_array()[axis.index()], rotation.w)
}

/// The angles about two different axes, outermost first, whose product comes nearest to a rotation.
///
/// The dot product with the wanted quaternion is a bilinear form of the half angles; with their sum and difference it falls apart
/// into two cosines, each of which is largest at one angle.
fn two_angles(rotation: DQuat, axes: [Axis; 2], previous: [f64; 2]) -> [f64; 2] {
    let parts = rotation.to_array();
    let [i, j] = axes.map(Axis::index);
    let third = 3 - i - j;
    // e_i e_j = e_k for cyclic pairs, -e_k otherwise.
    let product = if (i + 1) % 3 == j { parts[third] } else { -parts[third] };
    let (w, first, second) = (rotation.w, parts[i], parts[j]);
    let turned = |y: f64, x: f64, otherwise: f64| {
        if libm::hypot(x, y) < 1e-12 { otherwise } else { libm::atan2(y, x) }
    };
    let difference = turned(first - second, w + product, 0.5 * (previous[0] - previous[1]));
    let sum = turned(first + second, w - product, 0.5 * (previous[0] + previous[1]));
    [unwrap(sum + difference, previous[0], TAU), unwrap(sum - difference, previous[1], TAU)]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::Joint;
    use crate::motion::skeleton::{Channel, PositionRule, RestAxis};
    use glam::DVec3;

    fn angles(format: Format, axes: &[Axis], rest: Option<RestAxis>) -> Option<JointAngles> {
        let channels = axes.iter().map(|&axis| Channel { kind: ChannelKind::Rotation, axis }).collect();
        let joint = Joint {
            name: "joint".to_owned(),
            parent: None,
            offset: DVec3::ZERO,
            end: None,
            channels,
            axis: rest,
            bone: None,
        };
        let (angle_unit, position_rule) = (AngleUnit::Degrees, PositionRule::Replace);
        JointAngles::of(&Skeleton { format, joints: vec![joint], angle_unit, position_rule }, 0, 0)
    }

    #[test]
    fn numbers_come_back_for_every_set_of_axes() {
        use Axis::*;
        let rest = RestAxis { degrees: [20.0, -35.0, 110.0], order: [X, Y, Z] };
        let sets: [&[Axis]; 8] = [&[], &[X], &[Y, X], &[X, Y], &[Z, X], &[X, Z], &[Z, X, Y], &[X, Y, Z]];
        for axes in sets {
            for (format, rest) in [(Format::Bvh, None), (Format::Amc, Some(rest))] {
                let joint = angles(format, axes, rest).unwrap();
                let values = &[35.0, -62.0, 101.0][..axes.len()];
                let near: Vec<f64> = values.iter().map(|value| value + 4.0).collect();
                let got = joint.solve(joint.rotation(values), &near);
                assert!(got.iter().zip(values).all(|(a, b)| (a - b).abs() < 1e-9), "{axes:?} {got:?}");
                assert!(joint.error_rad(joint.rotation(values), &got) < 1e-12);
            }
        }
        assert!(angles(Format::Bvh, &[X, X], None).is_none());
    }

    #[test]
    fn too_few_axes_get_the_nearest_angles() {
        use Axis::*;
        let wanted = DQuat::from_xyzw(0.5, -0.5, 0.6, 0.1).normalize();
        for axes in [&[X][..], &[Z], &[X, Y], &[Y, X], &[Z, Y], &[X, Z]] {
            let joint = angles(Format::Bvh, axes, None).unwrap();
            let best = joint.solve(wanted, &[0.0, 0.0][..axes.len()]);
            let error = joint.error_rad(wanted, &best);
            assert!(error > 0.1, "{axes:?} can't show it");
            for step in [-0.5, 0.5] {
                for n in 0..axes.len() {
                    let mut worse = best.clone();
                    worse[n] += step;
                    assert!(joint.error_rad(wanted, &worse) > error, "{axes:?}");
                }
            }
        }
    }

    #[test]
    fn angles_follow_the_previous_frame_past_a_half_turn() {
        let joint = angles(Format::Bvh, &[Axis::Z, Axis::X, Axis::Y], None).unwrap();
        let got = joint.solve(joint.rotation(&[190.0, 10.0, 5.0]), &[185.0, 9.0, 5.0]);
        assert!((got[0] - 190.0).abs() < 1e-9, "{got:?}");
        assert_eq!(joint.whole_turn(), 360.0);
    }
}
