//! Biovision hierarchy files: a tree of joints with their channels, then one row of numbers a frame.

mod hierarchy;
mod rows;
mod write;

use super::finding::{Deviation, Finding, Findings};
use super::reading::{Motion, ReadOptions, Reading};
use super::text::{excerpt, is_blank, is_line_end, line_at, line_end, repaired, text_start, trimmed};
use super::{number, text};
pub use write::write_bvh;

/// The seconds of a frame that give a rate which anything can be done with.
const FRAME_TIMES_S: std::ops::RangeInclusive<f64> = 1e-6..=1e4;

/// What stands between MOTION and the rows.
struct MotionHead {
    /// `Frames:`.
    said: u64,
    frame_time_s: f64,
    /// Line of `Frames:`.
    frames_line: u32,
    /// Where the rows begin.
    rows_at: usize,
}

/// Reads a BVH file.
///
/// Keywords in any case, channels in any order and number, position channels on any joint, frames broken over
/// lines alike, all line ends; see `ReadOptions` for what position channels do. Channels stay in file units
/// and degrees.
///
/// # Errors
/// A [`Finding`] of severity fault where the file has no meaning, or exceeds the limits.
pub fn read_bvh(bytes: &[u8], options: &ReadOptions) -> Result<Reading<Motion>, Finding> {
    options.limits.check_bytes(bytes)?;
    let mut findings = Findings::default();
    let hierarchy = hierarchy::read(bytes, &options.limits, &mut findings)?;
    let head = read_head(bytes, hierarchy.motion_at)?;
    let mut skeleton = hierarchy.skeleton;
    skeleton.position_rule = options.position_rule;
    let rows = rows::read(bytes, head.rows_at, &skeleton, head.said, &mut findings)?;
    let found = rows.n_frames;
    options.limits.check_poses(found, skeleton.joints.len(), bytes, head.frames_line)?;
    if (found as u64) < head.said {
        findings.add(Finding::new(head.frames_line, Deviation::FramesFewer { said: head.said, found }));
    } else if found as u64 > head.said {
        findings.add(Finding::new(head.frames_line, Deviation::FramesMore { said: head.said, found }));
    }
    if found == 0 {
        findings.add(Finding::new(head.frames_line, Deviation::ZeroFrames));
    }
    let (header, _) = repaired(&bytes[text_start(bytes)..hierarchy.header_end]);
    let motion = Motion {
        skeleton,
        n_frames: found,
        channels: rows.channels,
        frame_time_s: Some(head.frame_time_s),
        unit_m: None,
        max_rounding: rows.max_rounding as f32,
        header,
        first_frame_number: 0,
    };
    Reading::checked(motion, findings.into_sorted(), options)
}

/// `Frames:` and `Frame Time:`, in either order, with or without blanks around the colon.
fn read_head(bytes: &[u8], motion_at: usize) -> Result<MotionHead, Finding> {
    let mut said = None;
    let mut frame_time_s = None;
    let mut frames_line = 0;
    let mut at = motion_at;
    loop {
        at += bytes[at..].iter().position(|&byte| !is_blank(byte) && !is_line_end(byte)).unwrap_or(bytes.len() - at);
        let (Some(said), Some(frame_time_s)) = (said, frame_time_s) else {
            if at == bytes.len() {
                return Err(Finding::new(text::last_line(bytes), Deviation::NoMotion));
            }
            let end = line_end(bytes, at);
            let line = trimmed(&bytes[at..end]);
            let number = || line_at(bytes, at);
            if let Some(value) = value_of(line, &[b"frame", b"time"]) {
                frame_time_s =
                    Some(usable_frame_time(value).ok_or_else(|| {
                        Finding::new(number(), Deviation::FrameTimeUnusable { found: excerpt(value) })
                    })?);
            } else if let Some(value) = value_of(line, &[b"frames"]) {
                frames_line = number();
                said =
                    Some(count(value).ok_or_else(|| {
                        Finding::new(frames_line, Deviation::FramesUnreadable { found: excerpt(value) })
                    })?);
            } else {
                let found = excerpt(line);
                let what = match said {
                    None => Deviation::FramesAbsent { found },
                    Some(_) => Deviation::FrameTimeAbsent { found },
                };
                return Err(Finding::new(number(), what));
            }
            at = end;
            continue;
        };
        return Ok(MotionHead { said, frame_time_s, frames_line, rows_at: at });
    }
}

/// What follows a key of these words (any case) and a colon that may be absent.
fn value_of<'a>(line: &'a [u8], key: &[&[u8]]) -> Option<&'a [u8]> {
    let mut rest = line;
    for word in key {
        rest = trimmed(rest);
        let head = rest.get(..word.len())?;
        if !head.eq_ignore_ascii_case(word) {
            return None;
        }
        rest = &rest[word.len()..];
        if rest.first().is_some_and(|&byte| !is_blank(byte) && byte != b':') {
            return None;
        }
    }
    let rest = trimmed(rest);
    Some(trimmed(rest.strip_prefix(b":").unwrap_or(rest)))
}

/// Digits; what overflows is as many as can be.
fn count(word: &[u8]) -> Option<u64> {
    if word.is_empty() || !word.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(word.iter().fold(0, |sum: u64, &byte| sum.saturating_mul(10).saturating_add(u64::from(byte - b'0'))))
}

fn usable_frame_time(word: &[u8]) -> Option<f64> {
    number::parse(word).filter(|seconds| FRAME_TIMES_S.contains(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_however_they_are_spaced() {
        for line in ["Frames: 12", "frames : 12", "FRAMES:12", "Frames:\t12", "Frames 12"] {
            assert_eq!(value_of(line.as_bytes(), &[b"frames"]), Some(&b"12"[..]), "{line}");
        }
        for line in ["Frame Time: .5", "frame  time\t:.5", "Frame Time .5"] {
            assert_eq!(value_of(line.as_bytes(), &[b"frame", b"time"]), Some(&b".5"[..]), "{line}");
        }
        assert_eq!(value_of(b"Framestore: 12", &[b"frames"]), None);
        assert_eq!(value_of(b"Frame: 12", &[b"frames"]), None);
    }

    #[test]
    fn a_count_is_digits_alone() {
        assert_eq!(count(b"012"), Some(12));
        assert_eq!(count(b"99999999999999999999999"), Some(u64::MAX));
        for word in [&b"-3"[..], b"three", b"3.0", b""] {
            assert_eq!(count(word), None);
        }
    }
}
