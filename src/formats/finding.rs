//! What a reader found wrong with a file: facts, not finished prose. `wording` puts them into sentences.

use crate::motion::{Notice, Severity};

/// A deviation and where it stands. As an error, the reason why a file was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Warning: the file is read. Fault: it is refused.
    pub severity: Severity,
    /// Line of the file, from 1.
    pub line: u32,
    /// Frame, from 0.
    pub frame: Option<u32>,
    /// How often this kind was met; the rest speaks of the first.
    pub count: u32,
    /// What it is.
    pub what: Deviation,
}

/// Why a word is no number for us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberFlaw {
    /// Not a decimal number.
    Malformed,
    /// `nan` or `inf`.
    NotFinite,
    /// Beyond the range of `f32` (channels) or `f64` (offsets).
    TooLarge,
    /// A comma where the decimal point belongs.
    DecimalComma,
}

/// Everything that a motion file can get wrong. Text fields quote the file (shortened, made visible).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are facts named in plain words; each variant says what they are about")]
pub enum Deviation {
    // Any file.
    /// Nothing but blanks.
    EmptyFile,
    /// More bytes than allowed.
    FileTooLarge { bytes: u64, limit: u64 },
    /// More joints than allowed.
    TooManyJoints { limit: usize },
    /// Joints nested deeper than allowed.
    TooDeep { limit: usize },
    /// A name longer than allowed.
    NameTooLong { bytes: usize, limit: usize },
    /// Frames times joints beyond what is allowed.
    TooManyPoses { frames: usize, joints: usize, limit: u64 },
    /// A word that is no number. `place`: what it should have been.
    BadNumber { flaw: NumberFlaw, place: String, found: String },
    /// A word that has no business here.
    Unexpected { expected: &'static str, found: String },
    /// A name that is not UTF-8; its bytes are read as Latin-1.
    NameNotUtf8 { name: String },
    /// The frames are over and something else follows.
    TrailingText { bytes: usize, found: String },
    /// NUL bytes after the frames.
    TrailingNul { bytes: usize },
    /// A skeleton without motion.
    ZeroFrames,

    // BVH, hierarchy.
    /// The file begins with something else.
    HierarchyWordAbsent { found: String },
    /// The file ends inside the hierarchy.
    CutInHierarchy { open: usize },
    /// MOTION while joints are open.
    BraceMissing { joint: String, open: usize },
    /// More closing braces than opening ones.
    BraceExtra,
    /// A joint without a name.
    NameAbsent,
    /// A joint without OFFSET.
    OffsetAbsent { joint: String },
    /// OFFSET with fewer than three numbers.
    OffsetShort { joint: String, found: usize },
    /// OFFSET or CHANNELS twice in a joint.
    SaidTwice { joint: String, word: &'static str },
    /// A channel of unknown name.
    ChannelUnknown { joint: String, found: String },
    /// CHANNELS promises another number of names than follow.
    ChannelCount { joint: String, expected: String, found: usize },
    /// Two joints of one name.
    NameTwice { name: String },
    /// A second End Site in a joint; the first counts.
    EndSiteTwice { joint: String },

    // BVH, motion.
    /// The file ends after the hierarchy.
    NoMotion,
    /// No `Frames:` before the first row.
    FramesAbsent { found: String },
    /// `Frames:` is not a count.
    FramesUnreadable { found: String },
    /// No `Frame Time:` before the first row.
    FrameTimeAbsent { found: String },
    /// `Frame Time:` gives no rate.
    FrameTimeUnusable { found: String },
    /// Fewer rows than promised; the rows count.
    FramesFewer { said: u64, found: usize },
    /// More rows than promised; the rows count.
    FramesMore { said: u64, found: usize },
    /// A row with another count of numbers than the hierarchy declares.
    RowWidth { expected: usize, found: usize },

    // ASF.
    /// A section that the format doesn't have; left out.
    SectionUnknown { section: String },
    /// No `length` in `:units`; 1 is assumed.
    LengthUnitAbsent,
    /// No `order` in `:root`; TX TY TZ RX RY RZ is assumed.
    RootOrderAbsent,
    /// A unit that can't be used.
    UnitUnusable { unit: &'static str, found: String },
    /// A word in `dof` or `order` that is no degree of freedom.
    DofUnknown { bone: String, found: String },
    /// Axis letters that are not X, Y and Z in some order.
    AxisLetters { bone: String, found: String },
    /// A bone without name, direction or length.
    BoneIncomplete { bone: String, lacks: &'static str },
    /// Two bones of one name.
    BoneTwice { bone: String },
    /// The file ends inside `:bonedata`.
    CutInBone { bone: String },
    /// No `:hierarchy`, or nothing in it.
    NoHierarchy,
    /// The hierarchy names a bone that `:bonedata` lacks.
    HierarchyUnknownBone { bone: String },
    /// A bone that is a child twice.
    TwoParents { bone: String },
    /// Bones that no path leads to from the root: a cycle or a loose end.
    HierarchyLoose { bone: String },
    /// A bone that no hierarchy line mentions; left out.
    BoneOutsideHierarchy { bone: String },

    // AMC.
    /// Neither `:DEGREES` nor `:RADIANS`; the skeleton's unit is taken.
    AngleUnitAbsent { assumed: &'static str },
    /// A bone line before any frame number.
    BeforeFirstFrame { found: String },
    /// A bone with another count of numbers than its dof.
    BoneValues { number: i64, bone: String, expected: usize, found: usize },
    /// Two lines for one bone in one frame.
    BoneLineTwice { number: i64, bone: String },
    /// A line for a bone that the skeleton lacks; left out.
    BoneUnknown { bone: String },
    /// No line for a bone in some frames; its last value is kept. `bones`: of the first such frame.
    BoneLineAbsent { number: i64, bones: Vec<String> },
    /// No line for these bones in any frame; zero is taken.
    BoneAbsentEverywhere { bones: Vec<String> },
    /// No line fits the skeleton at all.
    SkeletonMismatch { found: String },
    /// So few lines that most of the motion would be made up.
    MostlyAbsent { number: i64 },
    /// Frame numbers that skip or go back; frames are read in file order.
    FrameGap { from: i64, to: i64 },
    /// A frame number twice in a row; both are read.
    FrameNumberTwice { number: i64 },
    /// A second, different angle unit.
    AngleUnitTwice { found: String },
}

impl Finding {
    /// One deviation at a line, with the severity of its kind.
    pub fn new(line: u32, what: Deviation) -> Self {
        Finding { severity: what.severity(), line, frame: None, count: 1, what }
    }

    /// The same, in a frame (from 0).
    pub fn in_frame(mut self, frame: usize) -> Self {
        self.frame = Some(u32::try_from(frame).unwrap_or(u32::MAX));
        self
    }

    /// The same, at another line.
    pub(crate) fn at(mut self, line: u32) -> Self {
        self.line = line;
        self
    }

    /// The short stable name of the kind.
    pub fn kind(&self) -> &'static str {
        self.what.kind()
    }

    /// In sentences, for the `faults` table and the screen.
    pub fn notice(&self) -> Notice {
        Notice {
            severity: self.severity,
            kind: self.kind().to_owned(),
            line: Some(self.line),
            frame: self.frame,
            count: self.count,
            message: self.what.message(self.frame),
            why: self.what.why().to_owned(),
            remedy: self.what.remedy().to_owned(),
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}: {}", self.line, self.what.message(self.frame))
    }
}

impl std::error::Error for Finding {}

/// Findings of one file, at most one a kind: a repeat only counts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings(Vec<Finding>);

impl Findings {
    pub(crate) fn add(&mut self, finding: Finding) {
        match self.0.iter_mut().find(|known| known.kind() == finding.kind()) {
            Some(known) => known.count = known.count.saturating_add(finding.count),
            None => self.0.push(finding),
        }
    }

    /// In the order of their lines.
    pub(crate) fn into_sorted(mut self) -> Vec<Finding> {
        self.0.sort_by_key(|finding| finding.line);
        self.0
    }
}
