//! Frames a second of forward kinematics alone, on one core: the fast way and the plain one.
//!
//! A made clip with the layout of Bandai-Namco's files: 22 joints, six channels each, of which the positions repeat
//! the offsets except at the hips; every rotation varies. Parsing and writing are left out. Both ways are compared
//! before anything is timed; the best of several rounds counts, since other programs only ever slow it down.
//!
//! ```text
//! cargo bench --bench kinematics
//! ```

use glam::DVec3;
use motionmill::motion::kinematics::{plain_poses, poses, poses_and_rotations};
use motionmill::motion::skeleton::{AngleUnit, PositionRule};
use motionmill::motion::{Axis, Channel, ChannelKind, Clip, Format, Joint, Poses, Skeleton, UpAxis};
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Name, parent, offset in centimetres.
const JOINTS: [(&str, Option<usize>, [f64; 3]); 22] = [
    ("joint_Root", None, [0.0, 0.0, 0.0]),
    ("Hips", Some(0), [0.8, 94.0, 0.0]),
    ("Spine", Some(1), [15.7, 0.0, 0.0]),
    ("Chest", Some(2), [9.0, -0.4, 0.0]),
    ("Neck", Some(3), [16.4, 0.0, 0.0]),
    ("Head", Some(4), [6.5, 0.0, 0.0]),
    ("Shoulder_L", Some(3), [13.0, -0.2, 5.0]),
    ("UpperArm_L", Some(6), [5.3, 0.0, 0.0]),
    ("LowerArm_L", Some(7), [27.0, 0.0, 0.0]),
    ("Hand_L", Some(8), [25.0, 0.0, 0.0]),
    ("Shoulder_R", Some(3), [13.0, -0.2, -5.0]),
    ("UpperArm_R", Some(10), [-5.3, 0.0, 0.0]),
    ("LowerArm_R", Some(11), [-27.0, 0.0, 0.0]),
    ("Hand_R", Some(12), [-25.0, 0.0, 0.0]),
    ("UpperLeg_L", Some(1), [-6.0, 0.5, 8.6]),
    ("LowerLeg_L", Some(14), [39.0, 0.0, 0.0]),
    ("Foot_L", Some(15), [41.0, 0.0, 0.0]),
    ("Toes_L", Some(16), [13.0, 0.0, 0.0]),
    ("UpperLeg_R", Some(1), [-6.0, 0.5, -8.6]),
    ("LowerLeg_R", Some(18), [-39.0, 0.0, 0.0]),
    ("Foot_R", Some(19), [-41.0, 0.0, 0.0]),
    ("Toes_R", Some(20), [-13.0, 0.0, 0.0]),
];

const N_FRAMES: usize = 6000;
const ROUNDS: usize = 30;

fn main() {
    let clip = made_clip();
    let (fast, plain) = (poses(&clip), plain_poses(&clip));
    let worst = largest_difference(&fast, &plain);
    assert!(fast.n_frames == N_FRAMES && worst < 1e-12, "the two ways differ by {worst} m");
    println!("{N_FRAMES} frames, {} joints, largest difference {worst:.1e} m", JOINTS.len());
    report("fast", || poses(&clip).world.len());
    report("plain", || plain_poses(&clip).world.len());
    report("plain, with rotations", || poses_and_rotations(&clip).1.world.len());
    // What a clip of usual length costs, with the work that is done once a clip.
    let short = Clip { n_frames: 117, channels: clip.channels[..117 * clip.skeleton.n_channels()].to_vec(), ..clip };
    report_frames("fast, clips of 117 frames", 50 * 117, || (0..50).map(|_| poses(&short).world.len()).sum());
}

fn report(name: &str, run: impl FnMut() -> usize) {
    report_frames(name, N_FRAMES, run);
}

fn report_frames(name: &str, n_frames: usize, mut run: impl FnMut() -> usize) {
    let best = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            assert!(black_box(run()) > 0, "work was done");
            start.elapsed()
        })
        .min()
        .unwrap_or(Duration::MAX);
    println!("{name:<28} {:>10.0} frames/s", n_frames as f64 / best.as_secs_f64());
}

fn largest_difference(a: &Poses, b: &Poses) -> f64 {
    a.world.iter().zip(&b.world).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max)
}

fn made_clip() -> Clip {
    let channel = |kind, axis| Channel { kind, axis };
    let (position, rotation) = (ChannelKind::Position, ChannelKind::Rotation);
    let channels = vec![
        channel(position, Axis::X),
        channel(position, Axis::Y),
        channel(position, Axis::Z),
        channel(rotation, Axis::Z),
        channel(rotation, Axis::X),
        channel(rotation, Axis::Y),
    ];
    let joint = |(name, parent, offset): (&str, Option<usize>, [f64; 3])| Joint {
        name: name.to_owned(),
        parent,
        offset: DVec3::from(offset),
        end: ["Head", "Hand_L", "Hand_R", "Toes_L", "Toes_R"].contains(&name).then_some(DVec3::ZERO),
        channels: channels.clone(),
        axis: None,
        bone: None,
    };
    let skeleton = Skeleton {
        format: Format::Bvh,
        joints: JOINTS.into_iter().map(joint).collect(),
        angle_unit: AngleUnit::Degrees,
        position_rule: PositionRule::Replace,
    };
    let mut values = Vec::new();
    for frame in 0..N_FRAMES {
        let time_s = frame as f64 / 30.0;
        for (index, (name, _, offset)) in JOINTS.into_iter().enumerate() {
            let travel = if name == "Hips" { [0.0, libm::sin(6.0 * time_s), 120.0 * time_s] } else { [0.0; 3] };
            values.extend((0..3).map(|axis| (offset[axis] + travel[axis]) as f32));
            let swing = |phase: f64| 60.0 * libm::sin(5.0 * time_s + phase + index as f64);
            values.extend([swing(0.0) as f32, swing(1.0) as f32, (swing(2.0) * 3.0) as f32]);
        }
    }
    let rate_hz = 30.0;
    Clip { skeleton: Arc::new(skeleton), rate_hz, unit_m: 0.01, up: UpAxis::Y, n_frames: N_FRAMES, channels: values }
}
