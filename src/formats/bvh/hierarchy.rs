//! The HIERARCHY section: words and braces into a skeleton, without recursion.

use crate::formats::finding::{Deviation, Finding, Findings};
use crate::formats::number;
use crate::formats::reading::ReadLimits;
use crate::formats::text::{excerpt, is_blank, is_line_end, last_line, line_end, repaired, text_start, trimmed};
use crate::motion::skeleton::{AngleUnit, PositionRule};
use crate::motion::{Axis, Channel, ChannelKind, Format, Joint, Skeleton};
use glam::DVec3;
use std::collections::HashSet;

/// The skeleton and where the motion begins.
pub(super) struct Hierarchy {
    pub(super) skeleton: Skeleton,
    /// Where the line of MOTION begins, at the latest the word itself.
    pub(super) header_end: usize,
    /// Behind the word MOTION.
    pub(super) motion_at: usize,
}

/// Words with their lines; a brace is a word of its own.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
}

#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a [u8],
    line: u32,
    start: usize,
}

/// What is known of a joint besides the joint itself.
struct Open {
    line: u32,
    has_offset: bool,
    has_channels: bool,
}

struct Reader<'a> {
    words: Words<'a>,
    limits: &'a ReadLimits,
    joints: Vec<Joint>,
    known: Vec<Open>,
    /// Open joints, outermost first.
    open: Vec<usize>,
    names: HashSet<Vec<u8>>,
}

/// Reads from the start of the file to the word MOTION.
pub(super) fn read(bytes: &[u8], limits: &ReadLimits, findings: &mut Findings) -> Result<Hierarchy, Finding> {
    let words = Words { bytes, at: text_start(bytes), line: 1 };
    let mut reader =
        Reader { words, limits, joints: Vec::new(), known: Vec::new(), open: Vec::new(), names: HashSet::new() };
    let Some(first) = reader.words.next() else {
        return Err(Finding::new(1, Deviation::EmptyFile));
    };
    if !first.is("HIERARCHY") {
        return Err(Finding::new(first.line, Deviation::HierarchyWordAbsent { found: excerpt(first.text) }));
    }
    loop {
        let Some(word) = reader.words.next() else {
            let open = reader.open.len();
            let what = if open == 0 { Deviation::NoMotion } else { Deviation::CutInHierarchy { open } };
            return Err(Finding::new(last_line(bytes), what));
        };
        if let Some(&joint) = reader.open.last() {
            reader.in_joint(joint, word, findings)?;
        } else if word.is("ROOT") {
            reader.declare(None, word, findings)?;
        } else if word.is("}") {
            return Err(Finding::new(word.line, Deviation::BraceExtra));
        } else if word.is("MOTION") && !reader.joints.is_empty() {
            return Ok(reader.finish(word));
        } else {
            let expected = if reader.joints.is_empty() { "ROOT" } else { "MOTION or another ROOT" };
            return Err(Finding::new(word.line, Deviation::Unexpected { expected, found: excerpt(word.text) }));
        }
    }
}

impl<'a> Reader<'a> {
    fn finish(self, motion: Word<'_>) -> Hierarchy {
        let bytes = self.words.bytes;
        let blanks = bytes[..motion.start].iter().rev().take_while(|&&byte| is_blank(byte)).count();
        Hierarchy {
            skeleton: Skeleton {
                format: Format::Bvh,
                joints: self.joints,
                angle_unit: AngleUnit::Degrees,
                position_rule: PositionRule::default(),
            },
            header_end: motion.start - blanks,
            motion_at: self.words.at,
        }
    }

    fn in_joint(&mut self, joint: usize, word: Word<'_>, findings: &mut Findings) -> Result<(), Finding> {
        if word.is("OFFSET") {
            self.say_once(joint, word.line, "OFFSET")?;
            self.joints[joint].offset = self.offset(joint, word.line)?;
        } else if word.is("CHANNELS") {
            self.say_once(joint, word.line, "CHANNELS")?;
            self.joints[joint].channels = self.channels(joint, word.line)?;
        } else if word.is("JOINT") {
            self.declare(Some(joint), word, findings)?;
        } else if word.is("END") {
            self.words.rest_of_name();
            self.open_brace()?;
            let end = self.end_site(joint, word.line)?;
            if self.joints[joint].end.is_some() {
                let joint = self.name(joint);
                findings.add(Finding::new(word.line, Deviation::EndSiteTwice { joint }));
            } else {
                self.joints[joint].end = Some(end);
            }
        } else if word.is("}") {
            if !self.known[joint].has_offset {
                let line = self.known[joint].line;
                return Err(Finding::new(line, Deviation::OffsetAbsent { joint: self.name(joint) }));
            }
            self.open.pop();
        } else if word.is("MOTION") {
            let what = Deviation::BraceMissing { joint: self.name(joint), open: self.open.len() };
            return Err(Finding::new(word.line, what));
        } else {
            let expected = "OFFSET, CHANNELS, JOINT, End Site or a closing brace";
            return Err(Finding::new(word.line, Deviation::Unexpected { expected, found: excerpt(word.text) }));
        }
        Ok(())
    }

    /// A new joint: its name and its opening brace.
    fn declare(&mut self, parent: Option<usize>, word: Word<'_>, findings: &mut Findings) -> Result<(), Finding> {
        let fault = |what| Err(Finding::new(word.line, what));
        let raw = self.words.rest_of_name();
        let ReadLimits { max_joints, max_depth, max_name_bytes, .. } = *self.limits;
        if raw.is_empty() {
            return fault(Deviation::NameAbsent);
        }
        if raw.len() > max_name_bytes {
            return fault(Deviation::NameTooLong { bytes: raw.len(), limit: max_name_bytes });
        }
        if self.joints.len() >= max_joints {
            return fault(Deviation::TooManyJoints { limit: max_joints });
        }
        if self.open.len() >= max_depth {
            return fault(Deviation::TooDeep { limit: max_depth });
        }
        let (name, was_repaired) = repaired(raw);
        if was_repaired {
            findings.add(Finding::new(word.line, Deviation::NameNotUtf8 { name: name.clone() }));
        }
        if !self.names.insert(raw.to_vec()) {
            findings.add(Finding::new(word.line, Deviation::NameTwice { name: name.clone() }));
        }
        self.open_brace()?;
        self.open.push(self.joints.len());
        self.joints.push(Joint {
            name,
            parent,
            offset: DVec3::ZERO,
            end: None,
            channels: Vec::new(),
            axis: None,
            bone: None,
        });
        self.known.push(Open { line: word.line, has_offset: false, has_channels: false });
        Ok(())
    }

    fn open_brace(&mut self) -> Result<(), Finding> {
        match self.words.next() {
            Some(word) if word.is("{") => Ok(()),
            Some(word) => {
                let found = excerpt(word.text);
                Err(Finding::new(word.line, Deviation::Unexpected { expected: "an opening brace", found }))
            }
            None => Err(self.cut()),
        }
    }

    /// OFFSET and the closing brace of an End Site.
    fn end_site(&mut self, joint: usize, line: u32) -> Result<DVec3, Finding> {
        let mut offset = None;
        loop {
            match self.words.next() {
                None => return Err(self.cut()),
                Some(word) if word.is("OFFSET") && offset.is_none() => offset = Some(self.offset(joint, word.line)?),
                Some(word) if word.is("}") => {
                    let absent =
                        || Finding::new(line, Deviation::OffsetAbsent { joint: self.name(joint) + " End Site" });
                    return offset.ok_or_else(absent);
                }
                Some(word) if word.is("MOTION") => {
                    let what = Deviation::BraceMissing { joint: self.name(joint), open: self.open.len() + 1 };
                    return Err(Finding::new(word.line, what));
                }
                Some(word) => {
                    let expected = "OFFSET or a closing brace";
                    return Err(Finding::new(word.line, Deviation::Unexpected { expected, found: excerpt(word.text) }));
                }
            }
        }
    }

    /// Three numbers.
    fn offset(&mut self, joint: usize, line: u32) -> Result<DVec3, Finding> {
        let mut values = [0.0; 3];
        for (found, value) in values.iter_mut().enumerate() {
            let Some(word) = self.words.peek() else {
                return Err(self.cut());
            };
            match number::parse_in_f32(word.text) {
                Some(number) => *value = number,
                None if word.line == line && !word.is("}") => {
                    let (place, found) = (format!("the OFFSET of `{}`", self.name(joint)), excerpt(word.text));
                    let flaw = number::flaw(word.text);
                    return Err(Finding::new(line, Deviation::BadNumber { flaw, place, found }));
                }
                None => return Err(Finding::new(line, Deviation::OffsetShort { joint: self.name(joint), found })),
            }
            self.words.next();
        }
        Ok(DVec3::from_array(values))
    }

    /// A count and that many names.
    fn channels(&mut self, joint: usize, line: u32) -> Result<Vec<Channel>, Finding> {
        let Some(said) = self.words.next() else {
            return Err(self.cut());
        };
        let mut channels = Vec::new();
        while let Some(word) = self.words.peek() {
            if let Some(channel) = channel(word.text) {
                channels.push(channel);
                self.words.next();
            } else if word.line == line && !word.is("}") && !word.is("{") {
                let found = excerpt(word.text);
                return Err(Finding::new(line, Deviation::ChannelUnknown { joint: self.name(joint), found }));
            } else {
                break;
            }
        }
        if super::count(said.text) != Some(channels.len() as u64) {
            let (joint, expected) = (self.name(joint), excerpt(said.text));
            return Err(Finding::new(line, Deviation::ChannelCount { joint, expected, found: channels.len() }));
        }
        Ok(channels)
    }

    fn say_once(&mut self, joint: usize, line: u32, word: &'static str) -> Result<(), Finding> {
        let known = &mut self.known[joint];
        let said = if word == "OFFSET" { &mut known.has_offset } else { &mut known.has_channels };
        if std::mem::replace(said, true) {
            return Err(Finding::new(line, Deviation::SaidTwice { joint: self.name(joint), word }));
        }
        Ok(())
    }

    fn name(&self, joint: usize) -> String {
        excerpt(self.joints[joint].name.as_bytes())
    }

    fn cut(&self) -> Finding {
        Finding::new(last_line(self.words.bytes), Deviation::CutInHierarchy { open: self.open.len() })
    }
}

impl Word<'_> {
    fn is(&self, keyword: &str) -> bool {
        self.text.eq_ignore_ascii_case(keyword.as_bytes())
    }
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<Word<'a>> {
        self.skip_space();
        let start = self.at;
        let first = *self.bytes.get(start)?;
        self.at += 1;
        if !is_brace(first) {
            let ends = |&byte: &u8| is_blank(byte) || is_line_end(byte) || is_brace(byte);
            self.at = self.bytes[start..].iter().position(ends).map_or(self.bytes.len(), |length| start + length);
        }
        Some(Word { text: &self.bytes[start..self.at], line: self.line, start })
    }

    fn peek(&mut self) -> Option<Word<'a>> {
        self.skip_space();
        let (at, line) = (self.at, self.line);
        let word = self.next();
        (self.at, self.line) = (at, line);
        word
    }

    /// The rest of the line, up to an opening brace that stands alone or ends it.
    fn rest_of_name(&mut self) -> &'a [u8] {
        let end = line_end(self.bytes, self.at);
        let rest = &self.bytes[self.at..end];
        let alone = |at: usize| {
            rest[at] == b'{'
                && rest.get(at + 1).is_none_or(|&next| is_blank(next))
                && (at == 0 || is_blank(rest[at - 1]) || rest[at + 1..].iter().all(|&byte| is_blank(byte)))
        };
        let length = (0..rest.len()).find(|&at| alone(at)).unwrap_or(rest.len());
        self.at += length;
        trimmed(&rest[..length])
    }

    fn skip_space(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'\n' && self.at > 0 && self.bytes[self.at - 1] == b'\r' {
                // The CR was counted.
            } else if is_line_end(byte) {
                self.line = self.line.saturating_add(1);
            } else if !is_blank(byte) {
                break;
            }
            self.at += 1;
        }
    }
}

fn channel(word: &[u8]) -> Option<Channel> {
    let axis = Axis::from_letter(char::from(*word.first()?))?;
    let kind = match &word[1..] {
        kind if kind.eq_ignore_ascii_case(b"position") => ChannelKind::Position,
        kind if kind.eq_ignore_ascii_case(b"rotation") => ChannelKind::Rotation,
        _ => return None,
    };
    Some(Channel { kind, axis })
}

fn is_brace(byte: u8) -> bool {
    matches!(byte, b'{' | b'}')
}
