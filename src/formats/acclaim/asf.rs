//! Acclaim skeletons: sections in any order, into bones and hierarchy lines, then a tree.

use super::tree::{self, BoneData, Child};
use super::{INCH_M, without_comment};
use crate::formats::finding::{Deviation, Finding, Findings};
use crate::formats::number;
use crate::formats::reading::{ReadLimits, ReadOptions, Reading};
use crate::formats::text::{Lines, excerpt, last_line, repaired, text_start, words};
use crate::motion::skeleton::{AngleUnit, RestAxis};
use crate::motion::{Axis, Channel, ChannelKind, Skeleton};
use glam::DVec3;
use std::collections::HashMap;

/// A skeleton file: what moves, and what reading its motions needs.
#[derive(Clone, Debug, PartialEq)]
pub struct AsfSkeleton {
    /// Its angle unit is that of `:units`; a motion may say its own.
    pub skeleton: Skeleton,
    /// Metres a file unit: an inch over `length`.
    pub unit_m: f64,
    /// The text, verbatim (repaired to UTF-8).
    pub header: String,
    /// Joint of each bone, by the bytes of its name; `None` for bones outside the hierarchy.
    pub(super) joint_of: HashMap<Vec<u8>, Option<usize>>,
    /// Name of each joint as written.
    pub(super) names: Vec<Vec<u8>>,
}

/// `:root`, with angles in the file's unit.
pub(super) struct Root {
    pub(super) channels: Vec<Channel>,
    pub(super) axis_letters: [Axis; 3],
    pub(super) position: DVec3,
    pub(super) orientation: [f64; 3],
}

#[derive(Clone, Copy, PartialEq)]
enum Section {
    None,
    Text,
    Units,
    Root,
    BoneData,
    Hierarchy,
    Unknown,
}

/// A bone between `begin` and `end`.
struct OpenBone {
    line: u32,
    name: Option<(Vec<u8>, u32)>,
    direction: Option<DVec3>,
    length: Option<f64>,
    axis: [f64; 3],
    axis_letters: [Axis; 3],
    dof: Vec<Channel>,
}

struct Reader<'a> {
    limits: &'a ReadLimits,
    findings: Findings,
    length: Option<f64>,
    angle_unit: Option<AngleUnit>,
    root: Root,
    root_order_seen: bool,
    bones: Vec<BoneData>,
    bone_of: HashMap<Vec<u8>, usize>,
    open: Option<OpenBone>,
    children: Vec<Child<'a>>,
    /// Lines of `:units` and `:root`.
    units_line: u32,
    root_line: u32,
}

/// Reads an Acclaim skeleton.
///
/// # Errors
/// A [`Finding`] of severity fault where the file has no meaning, or exceeds the limits.
pub fn read_asf(bytes: &[u8], options: &ReadOptions) -> Result<Reading<AsfSkeleton>, Finding> {
    options.limits.check_bytes(bytes)?;
    let mut reader = Reader::new(&options.limits);
    let mut section = Section::None;
    let mut is_empty = true;
    for (line, text) in Lines::new(bytes, text_start(bytes)) {
        let text = without_comment(text);
        let mut rest = words(text);
        let Some(key) = rest.next() else { continue };
        is_empty = false;
        if let Some(name) = key.strip_prefix(b":") {
            section = reader.section(name, line);
            continue;
        }
        let rest: Vec<&[u8]> = rest.collect();
        match section {
            Section::None => {
                let (expected, found) = ("a section such as :version", excerpt(key));
                return Err(Finding::new(line, Deviation::Unexpected { expected, found }));
            }
            Section::Text | Section::Unknown => {}
            Section::Units => reader.units(key, &rest, line)?,
            Section::Root => reader.root(key, &rest, line)?,
            Section::BoneData => reader.bone_data(key, &rest, line)?,
            Section::Hierarchy => reader.hierarchy(key, &rest, line)?,
        }
    }
    if is_empty {
        return Err(Finding::new(1, Deviation::EmptyFile));
    }
    reader.finish(bytes, options)
}

impl<'a> Reader<'a> {
    fn new(limits: &'a ReadLimits) -> Self {
        let channel = |kind, axis| Channel { kind, axis };
        let (position, rotation) = (ChannelKind::Position, ChannelKind::Rotation);
        let root = Root {
            channels: [Axis::X, Axis::Y, Axis::Z]
                .map(|axis| channel(position, axis))
                .into_iter()
                .chain([Axis::X, Axis::Y, Axis::Z].map(|axis| channel(rotation, axis)))
                .collect(),
            axis_letters: [Axis::X, Axis::Y, Axis::Z],
            position: DVec3::ZERO,
            orientation: [0.0; 3],
        };
        Reader {
            limits,
            findings: Findings::default(),
            length: None,
            angle_unit: None,
            root,
            root_order_seen: false,
            bones: Vec::new(),
            bone_of: HashMap::new(),
            open: None,
            children: Vec::new(),
            units_line: 1,
            root_line: 1,
        }
    }

    fn section(&mut self, name: &[u8], line: u32) -> Section {
        match name.to_ascii_lowercase().as_slice() {
            b"version" | b"name" | b"documentation" => Section::Text,
            b"units" => {
                self.units_line = line;
                Section::Units
            }
            b"root" => {
                self.root_line = line;
                Section::Root
            }
            b"bonedata" => Section::BoneData,
            b"hierarchy" => Section::Hierarchy,
            _ => {
                let section = format!(":{}", excerpt(name));
                self.findings.add(Finding::new(line, Deviation::SectionUnknown { section }));
                Section::Unknown
            }
        }
    }

    fn units(&mut self, key: &[u8], rest: &[&[u8]], line: u32) -> Result<(), Finding> {
        let value = rest.first().copied().unwrap_or_default();
        let unusable = |unit| Err(Finding::new(line, Deviation::UnitUnusable { unit, found: excerpt(value) }));
        if key.eq_ignore_ascii_case(b"length") {
            match number::parse_in_f32(value) {
                Some(length) if length >= 1e-9 => self.length = Some(length),
                _ => return unusable("length"),
            }
        } else if key.eq_ignore_ascii_case(b"angle") {
            match value.get(..3).map(<[u8]>::to_ascii_lowercase).as_deref() {
                Some(b"deg") => self.angle_unit = Some(AngleUnit::Degrees),
                Some(b"rad") => self.angle_unit = Some(AngleUnit::Radians),
                _ => return unusable("angle"),
            }
        }
        Ok(())
    }

    fn root(&mut self, key: &[u8], rest: &[&[u8]], line: u32) -> Result<(), Finding> {
        if key.eq_ignore_ascii_case(b"order") {
            self.root_order_seen = true;
            self.root.channels = dof(rest, "root", line)?;
        } else if key.eq_ignore_ascii_case(b"axis") {
            self.root.axis_letters = axis_letters(rest, "root", line)?;
        } else if key.eq_ignore_ascii_case(b"position") {
            self.root.position = DVec3::from_array(three(rest, "root", "position", line)?);
        } else if key.eq_ignore_ascii_case(b"orientation") {
            self.root.orientation = three(rest, "root", "orientation", line)?;
        }
        Ok(())
    }

    fn bone_data(&mut self, key: &[u8], rest: &[&[u8]], line: u32) -> Result<(), Finding> {
        if key.eq_ignore_ascii_case(b"begin") {
            if let Some(open) = &self.open {
                let expected = "the end of the bone";
                let found = format!("begin (the bone of line {})", open.line);
                return Err(Finding::new(line, Deviation::Unexpected { expected, found }));
            }
            self.open = Some(OpenBone {
                line,
                name: None,
                direction: None,
                length: None,
                axis: [0.0; 3],
                axis_letters: [Axis::X, Axis::Y, Axis::Z],
                dof: Vec::new(),
            });
            return Ok(());
        }
        let Some(bone) = &mut self.open else {
            return Err(Finding::new(line, Deviation::Unexpected { expected: "begin", found: excerpt(key) }));
        };
        let name = excerpt(bone.name.as_ref().map_or(b"", |(name, _)| name));
        if key.eq_ignore_ascii_case(b"end") {
            return self.close_bone();
        } else if key.eq_ignore_ascii_case(b"name") {
            let word = rest.first().copied().unwrap_or_default();
            bone.name = Some((word.to_vec(), line));
        } else if key.eq_ignore_ascii_case(b"direction") {
            bone.direction = Some(DVec3::from_array(three(rest, &name, "direction", line)?));
        } else if key.eq_ignore_ascii_case(b"length") {
            bone.length = Some(one(rest.first().copied().unwrap_or_default(), &name, "length", line)?);
        } else if key.eq_ignore_ascii_case(b"axis") {
            bone.axis = three(rest, &name, "axis", line)?;
            bone.axis_letters = axis_letters(rest.get(3..).unwrap_or_default(), &name, line)?;
        } else if key.eq_ignore_ascii_case(b"dof") {
            bone.dof = dof(rest, &name, line)?;
        }
        // id, limits and their lines, bodymass, cofmass: nothing that moves a bone.
        Ok(())
    }

    fn close_bone(&mut self) -> Result<(), Finding> {
        let bone = self.open.take().expect("called inside a bone");
        let (raw, line) = bone.name.unwrap_or((Vec::new(), bone.line));
        let fault = |what| Err(Finding::new(line, what));
        let lacks = |lacks| Err(Finding::new(line, Deviation::BoneIncomplete { bone: excerpt(&raw), lacks }));
        if raw.is_empty() {
            return lacks("name");
        }
        let limit = self.limits.max_name_bytes;
        if raw.len() > limit {
            return fault(Deviation::NameTooLong { bytes: raw.len(), limit });
        }
        let Some(direction) = bone.direction else { return lacks("direction") };
        let Some(length) = bone.length else { return lacks("length") };
        let limit = self.limits.max_joints;
        if self.bones.len() + 1 >= limit {
            return fault(Deviation::TooManyJoints { limit });
        }
        if is_root(&raw) || self.bone_of.insert(raw.clone(), self.bones.len()).is_some() {
            return fault(Deviation::BoneTwice { bone: excerpt(&raw) });
        }
        let (name, was_repaired) = repaired(&raw);
        if was_repaired {
            self.findings.add(Finding::new(line, Deviation::NameNotUtf8 { name: name.clone() }));
        }
        let (axis, axis_letters, channels) = (bone.axis, bone.axis_letters, bone.dof);
        self.bones.push(BoneData { raw, name, line, direction, length, axis, axis_letters, channels });
        Ok(())
    }

    fn hierarchy(&mut self, key: &'a [u8], rest: &[&'a [u8]], line: u32) -> Result<(), Finding> {
        if rest.is_empty() && (key.eq_ignore_ascii_case(b"begin") || key.eq_ignore_ascii_case(b"end")) {
            return Ok(());
        }
        // Sections come in any order, so names are looked up at the end.
        self.children.extend(rest.iter().map(|&child| Child { line, parent: key, child }));
        Ok(())
    }

    fn finish(mut self, bytes: &'a [u8], options: &ReadOptions) -> Result<Reading<AsfSkeleton>, Finding> {
        if let Some(open) = &self.open {
            let bone = excerpt(open.name.as_ref().map_or(b"", |(name, _)| name));
            return Err(Finding::new(last_line(bytes), Deviation::CutInBone { bone }));
        }
        if self.children.is_empty() {
            return Err(Finding::new(last_line(bytes), Deviation::NoHierarchy));
        }
        if self.length.is_none() {
            self.findings.add(Finding::new(self.units_line, Deviation::LengthUnitAbsent));
        }
        if !self.root_order_seen {
            self.findings.add(Finding::new(self.root_line, Deviation::RootOrderAbsent));
        }
        let angle_unit = self.angle_unit.unwrap_or(AngleUnit::Degrees);
        let tree = tree::build(&self.bones, &self.children, &self.bone_of, self.limits.max_depth)?;
        for &bone in &tree.left_out {
            let bone = &self.bones[bone];
            let what = Deviation::BoneOutsideHierarchy { bone: excerpt(&bone.raw) };
            self.findings.add(Finding::new(bone.line, what));
        }
        let joint_of = (self.bones.iter().map(|bone| bone.raw.clone()).zip(tree.joint_of.iter().copied())).collect();
        let names = tree.bone_of.iter().map(|bone| bone.map_or(b"root".to_vec(), |bone| self.bones[bone].raw.clone()));
        let skeleton = AsfSkeleton {
            names: names.collect(),
            skeleton: tree.skeleton(&self.root, &self.bones, angle_unit),
            unit_m: INCH_M / self.length.unwrap_or(1.0),
            header: repaired(&bytes[text_start(bytes)..]).0,
            joint_of,
        };
        Reading::checked(skeleton, self.findings.into_sorted(), options)
    }
}

/// Whether a name is that of the root.
pub(super) fn is_root(name: &[u8]) -> bool {
    name.eq_ignore_ascii_case(b"root")
}

/// A rest axis in degrees.
pub(super) fn rest_axis(angles: [f64; 3], order: [Axis; 3], unit: AngleUnit) -> RestAxis {
    let degrees = match unit {
        AngleUnit::Degrees => angles,
        AngleUnit::Radians => angles.map(f64::to_degrees),
    };
    RestAxis { degrees, order }
}

fn one(word: &[u8], bone: &str, what: &str, line: u32) -> Result<f64, Finding> {
    number::parse_in_f32(word).ok_or_else(|| {
        let (flaw, place, found) = (number::flaw(word), format!("the {what} of `{bone}`"), excerpt(word));
        Finding::new(line, Deviation::BadNumber { flaw, place, found })
    })
}

fn three(words: &[&[u8]], bone: &str, what: &str, line: u32) -> Result<[f64; 3], Finding> {
    let mut values = [0.0; 3];
    for (at, value) in values.iter_mut().enumerate() {
        *value = one(words.get(at).copied().unwrap_or_default(), bone, what, line)?;
    }
    Ok(values)
}

/// `XYZ`, or the letters apart; XYZ where there are none.
fn axis_letters(words: &[&[u8]], bone: &str, line: u32) -> Result<[Axis; 3], Finding> {
    let text = words.concat();
    if text.is_empty() {
        return Ok([Axis::X, Axis::Y, Axis::Z]);
    }
    let letters: Option<Vec<Axis>> = text.iter().map(|&byte| Axis::from_letter(char::from(byte))).collect();
    match letters.as_deref() {
        Some(&[a, b, c]) if a != b && b != c && a != c => Ok([a, b, c]),
        _ => Err(Finding::new(line, Deviation::AxisLetters { bone: bone.to_owned(), found: excerpt(&text) })),
    }
}

/// `tx ty tz rx ry rz l` in any order.
fn dof(words: &[&[u8]], bone: &str, line: u32) -> Result<Vec<Channel>, Finding> {
    let channel = |word: &[u8]| match *word {
        [b't' | b'T', axis] => Axis::from_letter(char::from(axis)).map(|axis| (ChannelKind::Position, axis)),
        [b'r' | b'R', axis] => Axis::from_letter(char::from(axis)).map(|axis| (ChannelKind::Rotation, axis)),
        [b'l' | b'L'] => Some((ChannelKind::Length, Axis::X)),
        _ => None,
    };
    words
        .iter()
        .map(|word| match channel(word) {
            Some((kind, axis)) => Ok(Channel { kind, axis }),
            None => Err(Finding::new(line, Deviation::DofUnknown { bone: bone.to_owned(), found: excerpt(word) })),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn bone(name: &str, more: &str) -> String {
        format!("begin\nname {name}\ndirection 0 1 0\nlength 2\n{more}\nend\n")
    }

    fn read(text: &str) -> Result<Reading<AsfSkeleton>, Finding> {
        read_asf(text.as_bytes(), &ReadOptions::default())
    }

    #[test]
    fn bones_are_numbered_in_the_earliest_order_with_parents_first() {
        let bones: String = ["d", "a", "c", "b"].map(|name| bone(name, "")).concat();
        let reading = read(&format!(":bonedata\n{bones}:hierarchy\nbegin\na d\nb c\nroot b a\nend\n")).unwrap();
        let joints = &reading.value.skeleton.joints;
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names, ["root", "a", "d", "b", "c"]);
        let parents: Vec<Option<usize>> = joints.iter().map(|joint| joint.parent).collect();
        assert_eq!(parents, [None, Some(0), Some(1), Some(0), Some(3)]);
        assert_eq!((joints[2].offset, joints[1].offset), (DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO));
        assert_eq!((joints[2].end, joints[1].end), (Some(DVec3::new(0.0, 2.0, 0.0)), None));
    }

    #[test]
    fn radians_become_degrees() {
        let text =
            format!(":units\nangle RADIANS\n:bonedata\n{}:hierarchy\nroot a\n", bone("a", "axis 0.5 0 -1 z y x"));
        let skeleton = read(&text).unwrap().value.skeleton;
        let axis = skeleton.joints[1].axis.unwrap();
        assert_eq!((axis.degrees[0], axis.order), (0.5_f64.to_degrees(), [Axis::Z, Axis::Y, Axis::X]));
        assert_eq!(skeleton.angle_unit, AngleUnit::Radians);
    }

    #[test]
    fn what_has_no_meaning_is_refused() {
        let two = format!("{}{}", bone("a", ""), bone("b", ""));
        for (text, kind) in [
            (String::new(), "empty-file"),
            ("hello\n".to_owned(), "unexpected-word"),
            (":bonedata\n".to_owned(), "no-hierarchy"),
            (":units\nlength 0\n".to_owned(), "unit-unusable"),
            (":units\nangle turns\n".to_owned(), "unit-unusable"),
            (":root\norder TX TQ\n".to_owned(), "dof-unknown"),
            (":root\naxis XXZ\n".to_owned(), "axis-letters"),
            (":root\nposition 0 0\n".to_owned(), "number-malformed"),
            (format!(":bonedata\n{}", bone("root", "")), "bone-twice"),
            (":bonedata\nbegin\nname a\nbegin\n".to_owned(), "unexpected-word"),
            (":bonedata\nbegin\nname a\nlength 1\nend\n".to_owned(), "bone-incomplete"),
            (":bonedata\nname a\n".to_owned(), "unexpected-word"),
            (format!(":bonedata\n{two}:hierarchy\nroot a\nb b\n"), "hierarchy-loose"),
            (format!(":bonedata\n{two}:hierarchy\nroot a a\n"), "two-parents"),
            (format!(":bonedata\n{two}:hierarchy\nroot x\n"), "hierarchy-unknown-bone"),
        ] {
            assert_eq!(read(&text).unwrap_err().kind(), kind, "{text}");
        }
    }
}
