//! A clip whose every joint has position channels, so that a file can hold joints that were moved one by one.

use crate::motion::kinematics::poses_and_rotations;
use crate::motion::{Axis, Channel, ChannelKind, Clip, Format, Poses, UpAxis};
use std::sync::Arc;

/// The clip with three position channels before the rotations of every joint, its joints where `poses` has them.
///
/// Rotations stay as they are; the ends of bones have no channels and follow their joints.
///
/// # Shapes and units
/// `poses`: `[frame][point]`, metres, world, Y up, as `kinematics::poses` gives them for `clip`. The answer reads back
/// to the same positions within the rounding of its f32 channels.
///
/// `None` for Acclaim skeletons (their bones can't leave each other), files that are not Y up, and poses of another shape.
pub fn with_joint_positions(clip: &Clip, poses: &Poses) -> Option<Clip> {
    let n_joints = clip.skeleton.joints.len();
    let n_points = n_joints + clip.skeleton.ends().len();
    let fits = (poses.n_frames, poses.n_points) == (clip.n_frames, n_points);
    if clip.skeleton.format != Format::Bvh || clip.up != UpAxis::Y || !fits {
        return None;
    }
    let mut skeleton = (*clip.skeleton).clone();
    for joint in &mut skeleton.joints {
        let positions = [Axis::X, Axis::Y, Axis::Z].map(|axis| Channel { kind: ChannelKind::Position, axis });
        let rotations = joint.channels.iter().copied().filter(|channel| channel.kind == ChannelKind::Rotation);
        joint.channels = positions.into_iter().chain(rotations).collect();
    }
    let (_, rotations) = poses_and_rotations(clip);
    let firsts = clip.skeleton.first_channels();
    let mut channels = Vec::with_capacity(clip.n_frames * skeleton.n_channels());
    for frame in 0..clip.n_frames {
        let row = clip.frame(frame);
        for (index, joint) in clip.skeleton.joints.iter().enumerate() {
            let at = poses.at(frame, index);
            let from_parent = match joint.parent {
                Some(parent) => rotations.world_at(frame, parent).conjugate() * (at - poses.at(frame, parent)),
                None => at,
            };
            channels.extend((from_parent / clip.unit_m).to_array().map(|value| value as f32));
            for (channel, value) in joint.channels.iter().zip(&row[firsts[index]..]) {
                if channel.kind == ChannelKind::Rotation {
                    channels.push(*value);
                }
            }
        }
    }
    Some(Clip { skeleton: Arc::new(skeleton), channels, ..clip.clone() })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::motion::kinematics::poses;
    use crate::procedural::{Disturbance, Draws, bench, disturb, make};

    #[test]
    fn disturbed_joints_read_back_where_they_were_put() {
        for spec in &bench(5, 1)[..] {
            let made = make(spec, Format::Bvh).unwrap();
            let clean = poses(&made.clip);
            let noise = Disturbance::White { sd_m: 0.01 };
            let noisy = disturb(&clean, made.clip.rate_hz, &noise, &mut Draws::new(1, &spec.name, "noise"));
            let free = with_joint_positions(&made.clip, &noisy).unwrap();
            assert_eq!(free.skeleton.n_channels(), 6 * free.skeleton.joints.len());
            let read = poses(&free);
            for frame in 0..free.n_frames {
                for joint in 0..free.skeleton.joints.len() {
                    let off_m = (read.at(frame, joint) - noisy.at(frame, joint)).length();
                    assert!(off_m < 1e-5, "{} frame {frame} joint {joint}: {off_m} m", spec.name);
                }
            }
            assert!((read.at(3, 4) - clean.at(3, 4)).length() > 1e-4);
        }
    }

    #[test]
    fn what_has_no_free_joints_is_refused() {
        let spec = &bench(1, 1)[0];
        let (amc, bvh) = (make(spec, Format::Amc).unwrap().clip, make(spec, Format::Bvh).unwrap().clip);
        let clean = poses(&bvh);
        assert!(with_joint_positions(&amc, &clean).is_none());
        let short = Poses { n_frames: clean.n_frames - 1, ..clean.clone() };
        assert!(with_joint_positions(&bvh, &short).is_none());
        assert!(with_joint_positions(&bvh, &clean).is_some());
    }
}
