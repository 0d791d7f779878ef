//! BVH text from a skeleton and channels.

use crate::formats::number::{write_f32, write_f64};
use crate::formats::reading::{WriteError, check_channels};
use crate::formats::text::first_line_end;
use crate::motion::skeleton::{PositionRule, unique_names};
use crate::motion::{ChannelKind, Format, Skeleton};

/// Writes a BVH file. What is written reads back bit for bit.
///
/// `header`: HIERARCHY text to write verbatim, which must be that of `skeleton`; without it one is made, with
/// unique names and, where position channels replace it, a root OFFSET of 0 (some readers add the two); its
/// joints then come in the order of the tree, each followed by all that hangs on it.
/// `channels`: `[frame][channel]`, degrees and file units. `frame_time_s` is printed with at least 7 decimals.
///
/// # Errors
/// [`WriteError`] for an Acclaim skeleton (convert it with `acclaim_to_bvh`), half a frame, a number that is not
/// finite, a frame time that is not positive.
pub fn write_bvh(
    skeleton: &Skeleton,
    header: Option<&str>,
    frame_time_s: f64,
    channels: &[f32],
) -> Result<Vec<u8>, WriteError> {
    if skeleton.format != Format::Bvh {
        return Err(WriteError::WrongFormat { expected: "BVH", found: "Acclaim" });
    }
    if !(frame_time_s > 0.0 && frame_time_s.is_finite()) {
        return Err(WriteError::NotPositive { what: "frame_time_s", value: frame_time_s });
    }
    let width = skeleton.n_channels();
    check_channels(channels, width)?;
    let mut out = Vec::with_capacity(channels.len() * 10 + 200 * skeleton.joints.len() + 100);
    let mut columns: Vec<usize> = (0..width).collect();
    match header {
        Some(header) => out.extend_from_slice(header.as_bytes()),
        None => {
            let firsts = skeleton.first_channels();
            let order = write_hierarchy(skeleton, &mut out);
            columns =
                order.iter().flat_map(|&joint| (firsts[joint]..).take(skeleton.joints[joint].channels.len())).collect();
        }
    }
    let line_end = header.map_or("\n", first_line_end);
    if !matches!(out.last(), Some(b'\n' | b'\r') | None) {
        out.extend_from_slice(line_end.as_bytes());
    }
    let n_frames = channels.len().checked_div(width).unwrap_or(0);
    out.extend_from_slice(format!("MOTION{line_end}Frames: {n_frames}{line_end}Frame Time: ").as_bytes());
    write_frame_time(&mut out, frame_time_s);
    out.extend_from_slice(line_end.as_bytes());
    for frame in channels.chunks_exact(width.max(1)) {
        for (at, &column) in columns.iter().enumerate() {
            if at > 0 {
                out.push(b' ');
            }
            write_f32(&mut out, frame[column]);
        }
        out.extend_from_slice(line_end.as_bytes());
    }
    Ok(out)
}

/// The shortest decimal that reads back, with zeros up to 7 decimals (readers have taken 0.008 for 125 Hz).
fn write_frame_time(out: &mut Vec<u8>, frame_time_s: f64) {
    const DECIMALS: usize = 7;
    let from = out.len();
    write_f64(out, frame_time_s);
    let decimals = match out[from..].iter().position(|&byte| byte == b'.') {
        Some(point) => out.len() - from - point - 1,
        None => {
            out.push(b'.');
            0
        }
    };
    out.extend(std::iter::repeat_n(b'0', DECIMALS.saturating_sub(decimals)));
}

/// A step of the walk over the joints.
enum Step {
    Open(usize),
    Close,
}

/// HIERARCHY for a skeleton whose joints may nest thousands deep. Returns the joints in the order written, each
/// before its children and they before its next sibling, which is also the order of the numbers in a row.
fn write_hierarchy(skeleton: &Skeleton, out: &mut Vec<u8>) -> Vec<usize> {
    // Where the tree is deeper than this, indents would be most of the file.
    const MAX_INDENT: usize = 64;
    let names = unique_names(skeleton.joints.iter().map(|joint| plain_name(&joint.name)));
    let children = skeleton.children();
    let mut steps: Vec<Step> = (0..skeleton.joints.len())
        .rev()
        .filter(|&joint| skeleton.joints[joint].parent.is_none())
        .map(Step::Open)
        .collect();
    let mut order = Vec::with_capacity(skeleton.joints.len());
    let mut depth = 0_usize;
    let line = |out: &mut Vec<u8>, depth: usize, text: &str| {
        out.extend(std::iter::repeat_n(b'\t', depth.min(MAX_INDENT)));
        out.extend_from_slice(text.as_bytes());
        out.push(b'\n');
    };
    line(out, 0, "HIERARCHY");
    while let Some(step) = steps.pop() {
        let Step::Open(index) = step else {
            depth -= 1;
            line(out, depth, "}");
            continue;
        };
        order.push(index);
        let joint = &skeleton.joints[index];
        let word = if joint.parent.is_none() { "ROOT" } else { "JOINT" };
        line(out, depth, &format!("{word} {}", names[index]));
        line(out, depth, "{");
        depth += 1;
        line(out, depth, &format!("OFFSET {}", numbers(written_offset(skeleton, index))));
        let channels: String = joint.channels.iter().map(|channel| format!(" {}", channel.name())).collect();
        line(out, depth, &format!("CHANNELS {}{channels}", joint.channels.len()));
        if let Some(end) = joint.end {
            line(out, depth, "End Site");
            line(out, depth, "{");
            line(out, depth + 1, &format!("OFFSET {}", numbers(end.to_array())));
            line(out, depth, "}");
        }
        steps.push(Step::Close);
        steps.extend(children[index].iter().rev().map(|&child| Step::Open(child)));
    }
    order
}

/// A root's offset is 0 along axes that a position channel replaces.
fn written_offset(skeleton: &Skeleton, index: usize) -> [f64; 3] {
    let joint = &skeleton.joints[index];
    let mut offset = joint.offset.to_array();
    if joint.parent.is_none() && skeleton.position_rule == PositionRule::Replace {
        for channel in joint.channels.iter().filter(|channel| channel.kind == ChannelKind::Position) {
            offset[channel.axis.index()] = 0.0;
        }
    }
    offset
}

fn numbers(values: [f64; 3]) -> String {
    let [x, y, z] = values;
    format!("{x} {y} {z}")
}

/// A name that a reader takes for one: a line of its own, no brace.
fn plain_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_control() || c == '{' || c == '}' { '_' } else { c }).collect();
    let trimmed = plain.trim();
    if trimmed.is_empty() { "joint".to_owned() } else { trimmed.to_owned() }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::formats::{ReadOptions, read_bvh};

    const SMALL: &str = "HIERARCHY\nROOT Hips\n{\n\tOFFSET 1 2 3\n\tCHANNELS 2 Yposition Zrotation\n\tJOINT Leg L\n\t{\n\t\t\
        OFFSET 0 -0.1 1e-9\n\t\tCHANNELS 1 Xrotation\n\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 1 0\n\t\t}\n\t}\n}\nMOTION\nFrames: 2\n\
        Frame Time: 0.05\n1 2.5 -0\n.1 1e-9 3\n";

    #[test]
    fn a_made_hierarchy_reads_back_as_the_same_skeleton() {
        let first = read_bvh(SMALL.as_bytes(), &ReadOptions::default()).unwrap().value;
        let text = write_bvh(&first.skeleton, None, 0.05, &first.channels).unwrap();
        let second = read_bvh(&text, &ReadOptions::default()).unwrap().value;
        assert_eq!(second.skeleton.joints[1], first.skeleton.joints[1]);
        assert_eq!(second.skeleton.joints[0].offset.to_array(), [1.0, 0.0, 3.0], "the channel replaces y");
        assert_eq!(second.channels, first.channels);
        assert!(String::from_utf8(text).unwrap().contains("Frame Time: 0.0500000\n1 2.5 -0\n0.1 0.000000001 3\n"));
    }

    #[test]
    fn what_text_cannot_carry_is_refused() {
        let skeleton = read_bvh(SMALL.as_bytes(), &ReadOptions::default()).unwrap().value.skeleton;
        let error = |time, channels: &[f32]| write_bvh(&skeleton, None, time, channels).unwrap_err();
        assert_eq!(error(0.1, &[0.0; 4]), WriteError::RaggedChannels { values: 4, width: 3 });
        assert!(matches!(
            error(0.1, &[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0]),
            WriteError::NotFinite { frame: 1, channel: 1, .. }
        ));
        assert_eq!(error(0.0, &[0.0; 3]), WriteError::NotPositive { what: "frame_time_s", value: 0.0 });
    }
}
