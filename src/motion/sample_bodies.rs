//! Bodies and clips for the tests of this room: random ones that use every kind of channel.

use super::clip::{Clip, UpAxis};
use super::skeleton::{AngleUnit, Axis, Bone, Channel, ChannelKind, Format, Joint, PositionRule, RestAxis, Skeleton};
use glam::DVec3;
use std::sync::Arc;

/// A stream of numbers that depends on its seed alone.
pub(super) struct Draws(u64);

impl Draws {
    pub(super) fn new(seed: u64) -> Draws {
        Draws(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d)
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    fn axis(&mut self) -> Axis {
        [Axis::X, Axis::Y, Axis::Z][self.below(3)]
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }

    fn next(&mut self) -> u64 {
        // splitmix64
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

/// A clip of a random skeleton: both formats and angle units, several roots, any list of channels, some of them
/// constant, any number of frames up to 36.
pub(super) fn random_clip(seed: u64) -> Clip {
    let mut draws = Draws::new(seed);
    let format = if draws.one_in(2) { Format::Bvh } else { Format::Amc };
    let n_joints = 1 + draws.below(12);
    let joints: Vec<Joint> = (0..n_joints).map(|index| random_joint(&mut draws, format, index)).collect();
    let skeleton = Skeleton {
        format,
        joints,
        angle_unit: if draws.one_in(3) { AngleUnit::Radians } else { AngleUnit::Degrees },
        position_rule: if draws.one_in(3) { PositionRule::Add } else { PositionRule::Replace },
    };
    let n_frames = draws.below(37);
    let width = skeleton.n_channels();
    let constant: Vec<Option<f32>> = (0..width)
        .map(|_| match draws.below(4) {
            0 => Some(draws.between(-200.0, 200.0) as f32),
            1 => Some(0.0),
            _ => None,
        })
        .collect();
    let channels = (0..n_frames)
        .flat_map(|_| constant.clone())
        .map(|constant| constant.unwrap_or_else(|| draws.between(-200.0, 200.0) as f32))
        .collect();
    let up = if draws.one_in(3) { UpAxis::Z } else { UpAxis::Y };
    Clip { skeleton: Arc::new(skeleton), rate_hz: 30.0, unit_m: draws.between(0.01, 0.1), up, n_frames, channels }
}

fn random_joint(draws: &mut Draws, format: Format, index: usize) -> Joint {
    let amc = format == Format::Amc;
    let parent = if index == 0 || draws.one_in(12) { None } else { Some(draws.below(index)) };
    let n_channels = if draws.one_in(10) { 9 } else { draws.below(7) };
    let channels = (0..n_channels)
        .map(|_| {
            let kind = match draws.below(8) {
                0 | 1 => ChannelKind::Position,
                2 if amc => ChannelKind::Length,
                _ => ChannelKind::Rotation,
            };
            Channel { kind, axis: draws.axis() }
        })
        .collect();
    let orders = [[Axis::X, Axis::Y, Axis::Z], [Axis::Z, Axis::Y, Axis::X], [Axis::Y, Axis::X, Axis::Z]];
    let rest = RestAxis { degrees: draws.vector(180.0).to_array(), order: orders[draws.below(3)] };
    let bone = Bone { direction: draws.vector(1.0), length: draws.between(0.0, 10.0) };
    Joint {
        name: format!("joint{index}"),
        parent,
        offset: draws.vector(20.0),
        end: draws.one_in(2).then(|| draws.vector(5.0)),
        channels,
        axis: (amc && !draws.one_in(4)).then_some(rest),
        bone: (amc && parent.is_some()).then_some(bone),
    }
}
