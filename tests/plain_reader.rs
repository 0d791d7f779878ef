//! Reads clean BVH, ASF and AMC text for tests of kinematics and roles: short, slow, trusting. The program's own
//! readers are in `formats`; these know nothing of oddities.

use glam::DVec3;
use motionmill::motion::skeleton::{AngleUnit, Bone, PositionRule, RestAxis};
use motionmill::motion::{Axis, Channel, ChannelKind, Clip, Format, Joint, Skeleton, UpAxis};
use std::path::Path;
use std::sync::Arc;

/// A BVH file, at most `most_frames` of it. Unit 1, Y up.
pub(crate) fn read_bvh(file: &Path, most_frames: usize) -> Clip {
    let text = std::fs::read_to_string(file).unwrap();
    let (head, motion) = text.split_once("MOTION").unwrap();
    let mut joints: Vec<Joint> = Vec::new();
    // None: an End Site.
    let mut open: Vec<Option<usize>> = Vec::new();
    let mut next = None;
    for line in head.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers = || DVec3::from_slice(&words[1..4].iter().map(|word| word.parse().unwrap()).collect::<Vec<f64>>());
        match words.first().copied().unwrap_or("") {
            "ROOT" | "JOINT" => {
                let name = line.trim().split_once(char::is_whitespace).unwrap().1.to_owned();
                let parent = open.last().copied().flatten();
                joints.push(joint(name, parent));
                next = Some(joints.len() - 1);
            }
            "End" => next = None,
            "{" => open.push(next),
            "}" => drop(open.pop()),
            "OFFSET" => match open[open.len() - 1] {
                Some(joint) => joints[joint].offset = numbers(),
                None => {
                    let leaf = open[open.len() - 2].unwrap();
                    joints[leaf].end = Some(numbers());
                }
            },
            "CHANNELS" => {
                let joint = open[open.len() - 1].unwrap();
                joints[joint].channels = words[2..].iter().map(|word| channel(word)).collect();
            }
            _ => {}
        }
    }
    let mut lines = motion.lines().filter(|line| !line.trim().is_empty());
    let mut after_colon = || lines.next().unwrap().split_once(':').unwrap().1.trim().to_owned();
    let n_frames = after_colon().parse::<usize>().unwrap().min(most_frames);
    let rate_hz = (1.0 / after_colon().parse::<f64>().unwrap()).round();
    let rows = lines.take(n_frames).flat_map(str::split_whitespace);
    let channels = rows.map(|number| number.parse::<f64>().unwrap() as f32).collect();
    let (angle_unit, position_rule) = (AngleUnit::Degrees, PositionRule::Replace);
    let skeleton = Arc::new(Skeleton { format: Format::Bvh, joints, angle_unit, position_rule });
    Clip { skeleton, rate_hz, unit_m: 1.0, up: UpAxis::Y, n_frames, channels }
}

/// An AMC file and its ASF, in degrees, at most `most_frames` of it.
pub(crate) fn read_amc(asf: &Path, amc: &Path, most_frames: usize) -> Clip {
    let text = std::fs::read_to_string(asf).unwrap();
    let mut joints = vec![joint("root".to_owned(), None)];
    let mut length_unit = 1.0;
    let mut section = "";
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |n: usize| words[n].parse::<f64>().unwrap();
        let first = words.first().copied().unwrap_or("");
        if first.starts_with(':') {
            section = &line[1..];
        }
        let last = joints.len() - 1;
        let axes = |letters: &str| {
            let letters: Vec<Axis> = letters.chars().map(|letter| Axis::from_letter(letter).unwrap()).collect();
            [letters[0], letters[1], letters[2]]
        };
        match (section.split_whitespace().next().unwrap_or(""), first) {
            ("units", "length") => length_unit = number(1),
            ("root", "order") => joints[0].channels = words[1..].iter().map(|word| acclaim_channel(word)).collect(),
            ("root", "axis") => joints[0].axis = Some(RestAxis { degrees: [0.0; 3], order: axes(words[1]) }),
            ("bonedata", "name") => {
                joints.push(joint(words[1].to_owned(), None));
                joints[last + 1].bone = Some(Bone { direction: DVec3::ZERO, length: 0.0 });
            }
            ("bonedata", "direction") => {
                joints[last].bone.as_mut().unwrap().direction = DVec3::new(number(1), number(2), number(3));
            }
            ("bonedata", "length") => joints[last].bone.as_mut().unwrap().length = number(1),
            ("bonedata", "axis") => {
                joints[last].axis =
                    Some(RestAxis { degrees: [number(1), number(2), number(3)], order: axes(words[4]) });
            }
            ("bonedata", "dof") => {
                joints[last].channels = words[1..].iter().map(|word| acclaim_channel(word)).collect()
            }
            ("hierarchy", parent) if joints.iter().any(|joint| joint.name == parent) => {
                let parent = joints.iter().position(|joint| joint.name == parent).unwrap();
                for child in &words[1..] {
                    let child = joints.iter().position(|joint| joint.name == *child).unwrap();
                    joints[child].parent = Some(parent);
                    if let Some(bone) = joints[parent].bone {
                        joints[child].offset = bone.direction * bone.length;
                    }
                }
            }
            _ => {}
        }
    }
    for index in 0..joints.len() {
        if !joints.iter().any(|joint| joint.parent == Some(index)) {
            joints[index].end = joints[index].bone.map(|bone| bone.direction * bone.length);
        }
    }
    let mut channels: Vec<f32> = Vec::new();
    let first_channels: Vec<usize> =
        (0..joints.len()).map(|n| joints[..n].iter().map(|joint| joint.channels.len()).sum()).collect();
    let width: usize = joints.iter().map(|joint| joint.channels.len()).sum();
    let mut n_frames = 0;
    for line in std::fs::read_to_string(amc).unwrap().lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.len() == 1 && words[0].parse::<usize>().is_ok() {
            if n_frames == most_frames {
                break;
            }
            n_frames += 1;
            channels.resize(n_frames * width, 0.0);
        } else if let Some(bone) = joints.iter().position(|joint| words.first() == Some(&joint.name.as_str())) {
            for (n, word) in words[1..].iter().enumerate() {
                channels[(n_frames - 1) * width + first_channels[bone] + n] = word.parse::<f64>().unwrap() as f32;
            }
        }
    }
    let (angle_unit, position_rule) = (AngleUnit::Degrees, PositionRule::Replace);
    let skeleton = Arc::new(Skeleton { format: Format::Amc, joints, angle_unit, position_rule });
    Clip { skeleton, rate_hz: 120.0, unit_m: 0.0254 / length_unit, up: UpAxis::Y, n_frames, channels }
}

fn joint(name: String, parent: Option<usize>) -> Joint {
    Joint { name, parent, offset: DVec3::ZERO, end: None, channels: Vec::new(), axis: None, bone: None }
}

fn channel(word: &str) -> Channel {
    let kind = if word.ends_with("position") { ChannelKind::Position } else { ChannelKind::Rotation };
    Channel { kind, axis: Axis::from_letter(word.chars().next().unwrap()).unwrap() }
}

fn acclaim_channel(word: &str) -> Channel {
    let kind = if word.to_lowercase().starts_with('t') { ChannelKind::Position } else { ChannelKind::Rotation };
    Channel { kind, axis: Axis::from_letter(word.chars().nth(1).unwrap()).unwrap() }
}
