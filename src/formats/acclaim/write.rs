//! ASF and AMC text from a skeleton and channels.

use super::INCH_M;
use super::asf::is_root;
use crate::formats::number::write_f32;
use crate::formats::reading::{WriteError, check_channels};
use crate::motion::skeleton::AngleUnit;
use crate::motion::{Axis, Channel, ChannelKind, Format, Skeleton};
use glam::DVec3;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Writes an Acclaim skeleton.
///
/// `header`: ASF text to write verbatim, which must be that of `skeleton`; without it one is made, in degrees,
/// with `unit_m` metres a unit. Bones are named as [`write_amc`] names them.
///
/// # Errors
/// [`WriteError`] for a BVH skeleton (convert it with `bvh_to_acclaim`), several roots, a unit that is not positive.
pub fn write_asf(skeleton: &Skeleton, header: Option<&str>, unit_m: f64) -> Result<Vec<u8>, WriteError> {
    check_skeleton(skeleton)?;
    if let Some(header) = header {
        return Ok(header.as_bytes().to_vec());
    }
    if !(unit_m > 0.0 && unit_m.is_finite()) {
        return Err(WriteError::NotPositive { what: "unit_m", value: unit_m });
    }
    let mut out = String::new();
    make_asf(skeleton, unit_m, &mut out).expect("writing to a String does not fail");
    Ok(out.into_bytes())
}

/// Writes an Acclaim motion. What is written reads back bit for bit with the same skeleton.
///
/// Bones come in joint order; those without degrees of freedom have no line. `channels`: `[frame][channel]` in
/// file units and the skeleton's angle unit. Frames are numbered from `first_frame_number`. `rate_hz` is written as
/// `:SAMPLES-PER-SECOND` where given; most files leave it out, and readers take 120.
///
/// # Errors
/// [`WriteError`] for a BVH skeleton, several roots, half a frame, a number that is not finite.
pub fn write_amc(
    skeleton: &Skeleton,
    channels: &[f32],
    rate_hz: Option<f64>,
    first_frame_number: i64,
) -> Result<Vec<u8>, WriteError> {
    check_skeleton(skeleton)?;
    let width = skeleton.n_channels();
    check_channels(channels, width)?;
    let names = bone_names(skeleton);
    let unit: &[u8] = match skeleton.angle_unit {
        AngleUnit::Degrees => b":DEGREES\n",
        AngleUnit::Radians => b":RADIANS\n",
    };
    let mut out = Vec::with_capacity(channels.len() * 10 + 100);
    out.extend_from_slice(b":FULLY-SPECIFIED\n");
    out.extend_from_slice(unit);
    if let Some(rate_hz) = rate_hz {
        out.extend_from_slice(format!(":SAMPLES-PER-SECOND {rate_hz}\n").as_bytes());
    }
    for (frame, values) in channels.chunks_exact(width.max(1)).enumerate() {
        let number = first_frame_number.saturating_add(frame as i64);
        out.extend_from_slice(format!("{number}\n").as_bytes());
        let mut values = values.iter();
        for (joint, name) in skeleton.joints.iter().zip(&names) {
            if joint.channels.is_empty() {
                continue;
            }
            out.extend_from_slice(name.as_bytes());
            for &value in values.by_ref().take(joint.channels.len()) {
                out.push(b' ');
                write_f32(&mut out, value);
            }
            out.push(b'\n');
        }
    }
    Ok(out)
}

/// A name for each joint that both files can hold: one word, no number, no comment, no two alike; the root is
/// `root`. Names that came from an ASF file stay as they are.
pub(super) fn bone_names(skeleton: &Skeleton) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let name = |(index, joint): (usize, &crate::motion::Joint)| {
        if index == 0 {
            return "root".to_owned();
        }
        let is_space = |c: char| c.is_whitespace() || c.is_control() || c == '#';
        let mut name: String = joint.name.chars().map(|c| if is_space(c) { '_' } else { c }).collect();
        let is_number = !name.is_empty() && name.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit());
        if name.is_empty() || name.starts_with(':') || is_number || is_root(name.as_bytes()) {
            name.insert_str(0, "bone_");
        }
        let unique = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}_{n}") });
        let unique = unique.into_iter().find(|name| !taken.contains(name)).unwrap_or_default();
        taken.insert(unique.clone());
        unique
    };
    skeleton.joints.iter().enumerate().map(name).collect()
}

fn check_skeleton(skeleton: &Skeleton) -> Result<(), WriteError> {
    if skeleton.format != Format::Amc {
        return Err(WriteError::WrongFormat { expected: "Acclaim", found: "BVH" });
    }
    let roots = skeleton.joints.iter().filter(|joint| joint.parent.is_none()).count();
    if roots != 1 {
        return Err(WriteError::NotOneRoot { roots });
    }
    Ok(())
}

fn make_asf(skeleton: &Skeleton, unit_m: f64, out: &mut String) -> std::fmt::Result {
    let names = bone_names(skeleton);
    let root = &skeleton.joints[0];
    let (degrees, letters) = axis(root.axis);
    writeln!(out, ":version 1.10\n:name motionmill\n:units\n  mass 1.0\n  length {}\n  angle deg", INCH_M / unit_m)?;
    writeln!(out, ":documentation\n   made by Motionmill")?;
    writeln!(out, ":root\n   order{}", words(&root.channels).to_uppercase())?;
    writeln!(out, "   axis {letters}\n   position {}\n   orientation {degrees}", numbers(root.offset))?;
    writeln!(out, ":bonedata")?;
    for (index, joint) in skeleton.joints.iter().enumerate().skip(1) {
        let (direction, length) = match joint.bone {
            Some(bone) => (bone.direction, bone.length),
            None => (joint.end.unwrap_or(DVec3::ZERO), 1.0),
        };
        let (degrees, letters) = axis(joint.axis);
        writeln!(out, "  begin\n     id {index}\n     name {}", names[index])?;
        writeln!(out, "     direction {}\n     length {length}\n     axis {degrees}  {letters}", numbers(direction))?;
        if !joint.channels.is_empty() {
            writeln!(out, "    dof{}", words(&joint.channels))?;
            for (at, channel) in joint.channels.iter().enumerate() {
                let word = if at == 0 { "limits" } else { "      " };
                let limit = if channel.kind == ChannelKind::Rotation { "-180.0 180.0" } else { "-inf inf" };
                writeln!(out, "    {word} ({limit})")?;
            }
        }
        writeln!(out, "  end")?;
    }
    writeln!(out, ":hierarchy\n  begin")?;
    for (parent, children) in skeleton.children().iter().enumerate().filter(|(_, children)| !children.is_empty()) {
        write!(out, "    {}", names[parent])?;
        for &child in children {
            write!(out, " {}", names[child])?;
        }
        writeln!(out)?;
    }
    writeln!(out, "  end")
}

/// Angles and letters of a rest axis.
fn axis(axis: Option<crate::motion::RestAxis>) -> (String, String) {
    match axis {
        Some(axis) => (numbers(DVec3::from_array(axis.degrees)), axis.order.iter().map(|axis| axis.letter()).collect()),
        None => ("0 0 0".to_owned(), "XYZ".to_owned()),
    }
}

/// ` tx rz l`
fn words(channels: &[Channel]) -> String {
    let letter = |axis: Axis| axis.letter().to_ascii_lowercase();
    channels
        .iter()
        .map(|channel| match channel.kind {
            ChannelKind::Position => format!(" t{}", letter(channel.axis)),
            ChannelKind::Rotation => format!(" r{}", letter(channel.axis)),
            ChannelKind::Length => " l".to_owned(),
        })
        .collect()
}

fn numbers(vector: DVec3) -> String {
    format!("{} {} {}", vector.x, vector.y, vector.z)
}
