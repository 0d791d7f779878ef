//! Acclaim motions: frame numbers, each followed by a line of numbers for every bone that moves.
//!
//! Bones may come in any order, but nearly always come in that of the frame before: each line's name is first
//! compared with the one that followed the last line's bone there, and only looked up where that fails.

use super::asf::{AsfSkeleton, is_root};
use super::without_comment;
use crate::formats::finding::{Deviation, Finding, Findings};
use crate::formats::number::{self, narrow, scan};
use crate::formats::reading::{Motion, ReadLimits, ReadOptions, Reading};
use crate::formats::text::{
    excerpt, is_blank, is_line_end, last_line, line_at, line_end, skip_blanks, text_start, word_end, words,
};
use crate::motion::skeleton::AngleUnit;
use std::collections::BTreeMap;

/// No joint: a line for a bone that is left out.
const LEFT_OUT: usize = usize::MAX;

/// Where a joint's numbers go.
#[derive(Clone, Copy)]
struct Slot {
    first: usize,
    count: usize,
}

/// Frames in which a joint has no line.
#[derive(Clone, Copy)]
struct Absence {
    /// First such frame, and where its number stands.
    frame: usize,
    at: usize,
    count: u32,
}

struct Reader<'a> {
    bytes: &'a [u8],
    asf: &'a AsfSkeleton,
    limits: &'a ReadLimits,
    findings: Findings,
    slots: Vec<Slot>,
    width: usize,
    /// Joints that need a line in every frame.
    n_moving: usize,
    /// The joint whose line came after each joint's in the frame before.
    next: Vec<usize>,
    /// The frame (from 1) of each joint's last line.
    seen: Vec<usize>,
    /// Joint of the last line.
    last: usize,
    /// Moving joints with a line in this frame.
    n_seen: usize,
    n_frames: usize,
    /// The file's number of this frame and of the first, and where this one's stands.
    number: i64,
    first_number: i64,
    frame_at: usize,
    first_frame_at: usize,
    channels: Vec<f32>,
    max_rounding: f64,
    angle_unit: Option<AngleUnit>,
    frame_time_s: Option<f64>,
    /// By joint.
    absent: BTreeMap<usize, Absence>,
    /// First line for a bone that the skeleton lacks, and how many there are.
    unknown: Option<(usize, u32)>,
}

/// Reads an Acclaim motion for a skeleton.
///
/// The angle unit of the returned skeleton is the motion's (`:DEGREES`, `:RADIANS`); rest axes stay in degrees.
/// Bones without a line keep their last value. AMC has no rate: `frame_time_s` is `None` unless the file has a
/// `:SAMPLES-PER-SECOND`.
///
/// # Errors
/// A [`Finding`] of severity fault where the file has no meaning, or exceeds the limits.
pub fn read_amc(bytes: &[u8], asf: &AsfSkeleton, options: &ReadOptions) -> Result<Reading<Motion>, Finding> {
    options.limits.check_bytes(bytes)?;
    let mut reader = Reader::new(bytes, asf, &options.limits);
    let mut at = text_start(bytes);
    loop {
        while bytes.get(at).is_some_and(|&byte| is_blank(byte) || is_line_end(byte)) {
            at += 1;
        }
        at = match bytes.get(at) {
            None => break,
            Some(b'#') => line_end(bytes, at),
            Some(b':') => reader.keyword(at)?,
            Some(0) if bytes[at..].iter().all(|&byte| byte == 0 || is_blank(byte) || is_line_end(byte)) => {
                let what = Deviation::TrailingNul { bytes: bytes.len() - at };
                reader.findings.add(Finding::new(line_at(bytes, at), what));
                break;
            }
            Some(_) => reader.line(at)?,
        };
    }
    reader.finish(options)
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], asf: &'a AsfSkeleton, limits: &'a ReadLimits) -> Self {
        let joints = &asf.skeleton.joints;
        let slots: Vec<Slot> = (asf.skeleton.first_channels().into_iter())
            .zip(joints)
            .map(|(first, joint)| Slot { first, count: joint.channels.len() })
            .collect();
        Reader {
            bytes,
            asf,
            limits,
            findings: Findings::default(),
            width: asf.skeleton.n_channels(),
            n_moving: slots.iter().filter(|slot| slot.count > 0).count(),
            next: vec![0; joints.len()],
            seen: vec![0; joints.len()],
            slots,
            last: 0,
            n_seen: 0,
            n_frames: 0,
            number: 0,
            first_number: 0,
            frame_at: 0,
            first_frame_at: 0,
            channels: Vec::new(),
            max_rounding: 0.0,
            angle_unit: None,
            frame_time_s: None,
            absent: BTreeMap::new(),
            unknown: None,
        }
    }

    /// `:DEGREES` and the like. Returns where the line ends.
    fn keyword(&mut self, at: usize) -> Result<usize, Finding> {
        let end = line_end(self.bytes, at);
        let mut parts = words(without_comment(&self.bytes[at + 1..end]));
        let key = parts.next().unwrap_or_default().to_ascii_uppercase();
        let unit = match key.as_slice() {
            b"DEGREES" => AngleUnit::Degrees,
            b"RADIANS" => AngleUnit::Radians,
            b"FULLY-SPECIFIED" => return Ok(end),
            b"SAMPLES-PER-SECOND" => {
                let rate_hz = parts.next().and_then(number::parse).filter(|rate| (1e-4..=1e6).contains(rate));
                self.frame_time_s = rate_hz.map(f64::recip);
                return Ok(end);
            }
            _ => {
                let section = excerpt(&self.bytes[at..end]);
                self.findings.add(Finding::new(line_at(self.bytes, at), Deviation::SectionUnknown { section }));
                return Ok(end);
            }
        };
        if self.angle_unit.is_some_and(|known| known != unit) {
            let found = excerpt(&self.bytes[at..end]);
            return Err(Finding::new(line_at(self.bytes, at), Deviation::AngleUnitTwice { found }));
        }
        self.angle_unit = Some(unit);
        Ok(end)
    }

    /// A frame number or a bone, whose line begins at `at`. Returns where the line ends.
    #[inline]
    fn line(&mut self, at: usize) -> Result<usize, Finding> {
        let bytes = self.bytes;
        if self.n_frames > 0 {
            let joint = self.next[self.last];
            let name = self.asf.names[joint].as_slice();
            let end = at + name.len();
            let ends = |byte: Option<&u8>| byte.is_none_or(|&byte| is_blank(byte) || is_line_end(byte));
            if bytes[at..].starts_with(name) && ends(bytes.get(end)) {
                return self.bone(joint, at, end);
            }
        }
        let line = without_comment(&bytes[at..line_end(bytes, at)]);
        let word = &line[..word_end(line, 0)];
        if let Some(number) = frame_number(word)
            && words(line).nth(1).is_none()
        {
            return self.frame(number, at).map(|()| at + line.len());
        }
        if self.n_frames == 0 {
            let found = excerpt(word);
            return Err(Finding::new(line_at(bytes, at), Deviation::BeforeFirstFrame { found }));
        }
        let joint = match self.asf.joint_of.get(word) {
            Some(joint) => joint.unwrap_or(LEFT_OUT),
            None if is_root(word) => 0,
            None => {
                let known = self.unknown.get_or_insert((at, 0));
                known.1 = known.1.saturating_add(1);
                LEFT_OUT
            }
        };
        if joint == LEFT_OUT {
            return Ok(at + line.len());
        }
        self.next[self.last] = joint;
        self.bone(joint, at, at + word.len())
    }

    /// The numbers of a bone, from `name_end` to the end of the line.
    #[inline]
    fn bone(&mut self, joint: usize, line_from: usize, name_end: usize) -> Result<usize, Finding> {
        let bytes = self.bytes;
        let Slot { first, count } = self.slots[joint];
        let frame_from = (self.n_frames - 1) * self.width;
        if self.seen[joint] == self.n_frames {
            let bone = excerpt(&self.asf.names[joint]);
            return Err(self.fault(line_from, Deviation::BoneLineTwice { number: self.number, bone }));
        }
        self.seen[joint] = self.n_frames;
        self.n_seen += usize::from(count > 0);
        self.last = joint;
        let mut at = skip_blanks(bytes, name_end);
        let mut worst = self.max_rounding;
        for channel in &mut self.channels[frame_from + first..frame_from + first + count] {
            let Some((value, end)) = scan(bytes, at) else {
                return Err(self.bad_line(joint, line_from, name_end));
            };
            *channel = narrow(value, bytes, at, end);
            // Infinite for what f32 can't hold, caught below.
            worst = worst.max((value - f64::from(*channel)).abs());
            at = match bytes.get(end) {
                Some(b' ') if bytes.get(end + 1).is_some_and(|&next| next > b' ') => end + 1,
                Some(&byte) if is_blank(byte) => skip_blanks(bytes, end),
                Some(&byte) if !is_line_end(byte) && byte != b'#' => {
                    return Err(self.bad_line(joint, line_from, name_end));
                }
                _ => end,
            };
        }
        if !worst.is_finite() || bytes.get(at).is_some_and(|&byte| !is_line_end(byte) && byte != b'#') {
            return Err(self.bad_line(joint, line_from, name_end));
        }
        self.max_rounding = worst;
        Ok(if bytes.get(at) == Some(&b'#') { line_end(bytes, at) } else { at })
    }

    /// What is wrong with a bone's line: its first bad number, else their count.
    #[cold]
    fn bad_line(&self, joint: usize, line_from: usize, name_end: usize) -> Finding {
        let rest = without_comment(&self.bytes[name_end..line_end(self.bytes, name_end)]);
        let bone = excerpt(&self.asf.names[joint]);
        for (at, word) in words(rest).enumerate() {
            if number::parse_in_f32(word).is_none() {
                let place = format!("frame {}, number {} of bone `{bone}`", self.number, at + 1);
                let what = Deviation::BadNumber { flaw: number::flaw(word), place, found: excerpt(word) };
                return self.fault(line_from, what);
            }
        }
        let (expected, found) = (self.slots[joint].count, words(rest).count());
        self.fault(line_from, Deviation::BoneValues { number: self.number, bone, expected, found })
    }

    /// A frame begins. Its numbers are those of the frame before until its lines say otherwise.
    fn frame(&mut self, number: i64, at: usize) -> Result<(), Finding> {
        if self.n_frames == 0 {
            (self.first_number, self.first_frame_at) = (number, at);
        } else {
            self.end_frame();
            if number == self.number {
                let what = Deviation::FrameNumberTwice { number };
                self.findings.add(Finding::new(line_at(self.bytes, at), what).in_frame(self.n_frames));
            } else if number != self.number.saturating_add(1) {
                let what = Deviation::FrameGap { from: self.number, to: number };
                self.findings.add(Finding::new(line_at(self.bytes, at), what).in_frame(self.n_frames));
            }
        }
        (self.number, self.frame_at) = (number, at);
        // Lines that are absent are filled in; more numbers than the file has bytes would be made up.
        let needed = self.channels.len() + self.width;
        if needed > self.bytes.len() {
            return Err(self.fault(at, Deviation::MostlyAbsent { number }));
        }
        let joints = self.slots.len();
        self.limits
            .check_poses(self.n_frames + 1, joints, self.bytes, 0)
            .map_err(|fault| fault.at(line_at(self.bytes, at)))?;
        match self.n_frames {
            0 => self.channels.resize(needed, 0.0),
            frames => self.channels.extend_from_within((frames - 1) * self.width..),
        }
        self.n_frames += 1;
        self.n_seen = 0;
        Ok(())
    }

    /// Remembers which joints had no line.
    fn end_frame(&mut self) {
        if self.n_seen == self.n_moving {
            return;
        }
        for (joint, slot) in self.slots.iter().enumerate() {
            if slot.count > 0 && self.seen[joint] != self.n_frames {
                let first = Absence { frame: self.n_frames - 1, at: self.frame_at, count: 0 };
                self.absent.entry(joint).or_insert(first).count += 1;
            }
        }
    }

    fn finish(mut self, options: &ReadOptions) -> Result<Reading<Motion>, Finding> {
        if self.n_frames == 0 {
            self.findings.add(Finding::new(last_line(self.bytes), Deviation::ZeroFrames));
        } else {
            self.end_frame();
        }
        self.report_lines()?;
        let angle_unit = self.angle_unit.unwrap_or(self.asf.skeleton.angle_unit);
        if self.angle_unit.is_none() {
            let assumed = match angle_unit {
                AngleUnit::Degrees => "degrees",
                AngleUnit::Radians => "radians",
            };
            let line = line_at(self.bytes, self.first_frame_at);
            self.findings.add(Finding::new(line, Deviation::AngleUnitAbsent { assumed }));
        }
        let mut skeleton = self.asf.skeleton.clone();
        skeleton.angle_unit = angle_unit;
        let motion = Motion {
            skeleton,
            n_frames: self.n_frames,
            channels: self.channels,
            frame_time_s: self.frame_time_s,
            unit_m: Some(self.asf.unit_m),
            max_rounding: self.max_rounding as f32,
            header: self.asf.header.clone(),
            first_frame_number: self.first_number,
        };
        Reading::checked(motion, self.findings.into_sorted(), options)
    }

    /// Says which lines were absent, and which fit no bone.
    fn report_lines(&mut self) -> Result<(), Finding> {
        let name = |joint: usize| excerpt(&self.asf.names[joint]);
        if let Some((at, count)) = self.unknown {
            let bone = excerpt(&self.bytes[at..word_end(self.bytes, at)]);
            if self.absent.len() == self.n_moving && self.seen.iter().all(|&frame| frame == 0) {
                return Err(self.fault(at, Deviation::SkeletonMismatch { found: bone }));
            }
            let finding = Finding::new(line_at(self.bytes, at), Deviation::BoneUnknown { bone });
            self.findings.add(Finding { count, ..finding });
        }
        let everywhere = |absence: &Absence| absence.count as usize == self.n_frames;
        let bones: Vec<String> =
            self.absent.iter().filter(|(_, absence)| everywhere(absence)).map(|(&joint, _)| name(joint)).collect();
        if !bones.is_empty() {
            let line = line_at(self.bytes, self.first_frame_at);
            self.findings.add(Finding::new(line, Deviation::BoneAbsentEverywhere { bones }));
        }
        let sometimes = || self.absent.iter().filter(|(_, absence)| !everywhere(absence));
        if let Some(first) = sometimes().map(|(_, absence)| *absence).min_by_key(|absence| absence.frame) {
            let bones = sometimes()
                .filter(|(_, absence)| absence.frame == first.frame)
                .map(|(&joint, _)| name(joint))
                .collect();
            let number = frame_number(&self.bytes[first.at..word_end(self.bytes, first.at)]).unwrap_or_default();
            let finding = Finding::new(line_at(self.bytes, first.at), Deviation::BoneLineAbsent { number, bones });
            let count = sometimes().map(|(_, absence)| absence.count).fold(0, u32::saturating_add);
            self.findings.add(Finding { count, ..finding }.in_frame(first.frame));
        }
        Ok(())
    }

    fn fault(&self, at: usize, what: Deviation) -> Finding {
        let finding = Finding::new(line_at(self.bytes, at), what);
        if self.n_frames > 0 { finding.in_frame(self.n_frames - 1) } else { finding }
    }
}

/// A whole number, clamped to what it fits in.
fn frame_number(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word.strip_prefix(b"-") {
        Some(digits) => (true, digits),
        None => (false, word),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let size = digits.iter().fold(0, |sum: i64, &byte| sum.saturating_mul(10).saturating_add(i64::from(byte - b'0')));
    Some(if negative { -size } else { size })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::formats::read_asf;

    /// A root with two channels, `b` with one below `c` with two; `:bonedata` has the child first.
    const ASF: &str = ":units\nlength 1\n:root\norder TX RZ\n:bonedata\nbegin\nname b\ndirection 1 0 0\nlength 1\n\
        dof ry\nend\nbegin\nname c\ndirection 1 0 0\nlength 1\ndof rz l\nend\n:hierarchy\nc b\nroot c\n";

    fn read(amc: &str) -> Result<Reading<Motion>, Finding> {
        let asf = read_asf(ASF.as_bytes(), &ReadOptions::default()).unwrap().value;
        read_amc(format!(":DEGREES\n{amc}").as_bytes(), &asf, &ReadOptions::default())
    }

    #[test]
    fn numbers_go_where_their_joint_is() {
        let motion = read("5\nb 3\nroot 1 2\nc 4 5\n6\nc 40 50 # later\nroot 10 20\nb 30\n").unwrap();
        assert_eq!(motion.findings, []);
        let motion = motion.value;
        let names: Vec<&str> = motion.skeleton.joints.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names, ["root", "c", "b"], "parents first");
        assert_eq!(motion.channels, [1.0, 2.0, 4.0, 5.0, 3.0, 10.0, 20.0, 40.0, 50.0, 30.0]);
        assert_eq!((motion.first_frame_number, motion.frame_time_s), (5, None));
    }

    #[test]
    fn absent_lines_keep_the_value_before() {
        let reading = read("1\nroot 1 2\nc 4 5\nb 3\n2\nroot 1 2\n3\nc 7 8\nroot 1 2\n").unwrap();
        assert_eq!(reading.value.channels[7..], [4.0, 5.0, 3.0, 1.0, 2.0, 7.0, 8.0, 3.0]);
        let [finding] = reading.findings.as_slice() else { panic!("{:?}", reading.findings) };
        assert_eq!((finding.kind(), finding.line, finding.frame, finding.count), ("bone-line-absent", 6, Some(1), 3));
        assert_eq!(finding.notice().message, "frame 2 has no line for `c`, `b`");
    }

    #[test]
    fn what_has_no_meaning_is_refused() {
        for (amc, kind, line) in [
            ("root 1 2\n", "before-first-frame", 2),
            ("1\nroot 1\n", "bone-values", 3),
            ("1\nroot 1 2 3\n", "bone-values", 3),
            ("1\nroot 1 x\n", "number-malformed", 3),
            ("1\nroot 1 1e999\n", "number-too-large", 3),
            ("1\nroot 1 2\nroot 1 2\n", "bone-line-twice", 4),
            ("1\nx 1 2 1 2 1 2 1 2\n", "skeleton-mismatch", 3),
            (":radians\n1\nroot 1 2\n", "angle-unit-twice", 2),
            // 27 bytes hold no more than five frames of five numbers.
            ("1\n2\n3\n4\n5\n6\n7\n8\n9\n", "bone-lines-mostly-absent", 7),
        ] {
            let fault = read(amc).unwrap_err();
            assert_eq!((fault.kind(), fault.line), (kind, line), "{amc}: {fault}");
        }
    }

    #[test]
    fn a_rate_is_taken_where_there_is_one() {
        let motion = read(":SAMPLES-PER-SECOND 60\n1\nroot 1 2\nc 4 5\nb 3\n").unwrap().value;
        assert_eq!(motion.frame_time_s, Some(1.0 / 60.0));
    }
}
