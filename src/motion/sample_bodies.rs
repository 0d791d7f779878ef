//! Bodies and clips for the tests of this room: random ones that use every kind of channel, and trees written as
//! `hips(spine left_leg(left_foot))`.

use super::clip::{Clip, UpAxis};
use super::role_names::NameTables;
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

/// A tree without channels from its names: children in brackets, `name@x,y,z` for an offset (else 0 1 0), and a
/// child `*` for an End Site.
pub(super) fn named_body(tree: &str) -> Skeleton {
    let spaced = tree.replace('(', " ( ").replace(')', " ) ");
    let mut joints: Vec<Joint> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for word in spaced.split_whitespace() {
        match word {
            "(" => open.push(joints.len() - 1),
            ")" => drop(open.pop()),
            _ => {
                let (name, offset) = word.split_once('@').unwrap_or((word, "0,1,0"));
                let numbers: Vec<f64> = offset.split(',').filter_map(|number| number.parse().ok()).collect();
                let offset = DVec3::from_slice(&numbers);
                if name == "*" {
                    joints[open[open.len() - 1]].end = Some(offset);
                    continue;
                }
                joints.push(Joint {
                    name: name.to_owned(),
                    parent: open.last().copied(),
                    offset,
                    end: None,
                    channels: Vec::new(),
                    axis: None,
                    bone: None,
                });
            }
        }
    }
    Skeleton { format: Format::Bvh, joints, angle_unit: AngleUnit::Degrees, position_rule: PositionRule::Replace }
}

/// Names of joints.
pub(super) fn body_names<'a>(skeleton: &'a Skeleton, joints: &[usize]) -> Vec<&'a str> {
    joints.iter().map(|&joint| skeleton.joints[joint].name.as_str()).collect()
}

/// The tables in `configs/skeletons`.
pub(super) fn shipped_tables() -> NameTables {
    macro_rules! tables {
        ($($name:literal),*) => {
            NameTables::from_toml(&[
                $(($name, include_str!(concat!("../../configs/skeletons/", $name, ".toml")))),*
            ])
        };
    }
    let tables = tables!(
        "100style",
        "bandai-namco",
        "biped",
        "blender",
        "cgspeed",
        "cgspeed-3dsmax",
        "cmu-asf",
        "daz",
        "lafan1",
        "mixamo",
        "motionbuilder",
        "smpl",
        "unreal"
    );
    tables.unwrap_or_else(|error| panic!("{error}"))
}

/// CMU's tree, from its ASF.
pub(super) const CMU: &str = "root@0,16,0(
    lhipjoint@0,0,0(lfemur@1.7,-1.8,0.6(ltibia@2.6,-7.1,0(lfoot@2.5,-6.8,0(ltoes@0.2,-0.5,2.1(*@0,0,1.1)))))
    rhipjoint@0,0,0(rfemur@-1.6,-1.8,0.7(rtibia@-2.6,-7.1,0(rfoot@-2.5,-6.8,0(rtoes@-0.2,-0.5,2.1(*@0,0,1.1)))))
    lowerback@0,0,0(upperback@0,2,-0.1(thorax@0,2,0(
        lowerneck@0,2,0(upperneck@0,1.7,0.2(head@0,1.7,0(*@0,1.7,0)))
        lclavicle@0,2,0(lhumerus@3.5,0.9,0(lradius@5,0,0(lwrist@3.4,0,0(lhand@1.7,0,0(lfingers@0.7,0,0(*@0.5,0,0))
            lthumb@1.7,0,0(*@0.5,0,0.5)))))
        rclavicle@0,2,0(rhumerus@-3.5,0.9,0(rradius@-5,0,0(rwrist@-3.4,0,0(rhand@-1.7,0,0(rfingers@-0.7,0,0(*@-0.5,0,0))
            rthumb@-1.7,0,0(*@-0.5,0,0.5)))))))))";
