//! The sentences of findings: what was found, why it matters, what to do.

use super::finding::{Deviation, NumberFlaw};
use crate::motion::Severity;

const EXPORT_AGAIN: &str = "export the clip again, or list it under `skip` in your config";
const CUT: &str = "the file looks cut off: fetch or export it again";
const CHECK_USED: &str = "nothing, if the clip looks right; otherwise export it again";

impl Deviation {
    /// Whether the file is still read.
    pub fn severity(&self) -> Severity {
        self.words().0
    }

    /// The short stable name of the kind.
    pub fn kind(&self) -> &'static str {
        self.words().1
    }

    /// Why it matters.
    pub fn why(&self) -> &'static str {
        self.words().2
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        self.words().3
    }

    /// Severity, kind, why, remedy.
    fn words(&self) -> (Severity, &'static str, &'static str, &'static str) {
        use Severity::{Fault, Warning};
        match self {
            Deviation::EmptyFile => (Fault, "empty-file", "there is nothing to read", CUT),
            Deviation::FileTooLarge { .. } => (
                Fault,
                "file-too-large",
                "one clip must fit in a worker's memory",
                "cut the take into clips, or raise `limits.max_clip_bytes`",
            ),
            Deviation::TooManyJoints { .. } => (
                Fault,
                "too-many-joints",
                "a body has dozens of joints; this looks like no body",
                "raise `limits.max_joints` if it is one",
            ),
            Deviation::TooDeep { .. } => (
                Fault,
                "too-deep",
                "a body is some ten joints deep; this looks like no body",
                "raise `limits.max_depth` if it is one",
            ),
            Deviation::NameTooLong { .. } => (
                Fault,
                "name-too-long",
                "names become column names, which must stay readable",
                "rename the joint, or raise `limits.max_name_bytes`",
            ),
            Deviation::TooManyPoses { .. } => (
                Fault,
                "too-many-poses",
                "the positions of all joints must fit in a worker's memory",
                "cut the take into clips, or raise `limits.max_poses`",
            ),
            Deviation::BadNumber { flaw, .. } => match flaw {
                NumberFlaw::Malformed => {
                    (Fault, "number-malformed", "a number that is guessed is silent damage", EXPORT_AGAIN)
                }
                NumberFlaw::NotFinite => {
                    (Fault, "number-not-finite", "nothing that a table or a mean could use", EXPORT_AGAIN)
                }
                NumberFlaw::TooLarge => {
                    (Fault, "number-too-large", "it doesn't fit in the tables' numbers", EXPORT_AGAIN)
                }
                NumberFlaw::DecimalComma => (
                    Fault,
                    "number-decimal-comma",
                    "it could be one number or two, and a guess would be silent damage",
                    "export it again with decimal points (set the exporter's locale to C or English)",
                ),
            },
            Deviation::Unexpected { .. } => {
                (Fault, "unexpected-word", "what follows can't be told apart", EXPORT_AGAIN)
            }
            Deviation::NameNotUtf8 { .. } => (
                Warning,
                "name-not-utf8",
                "tables hold UTF-8; the bytes are read as Latin-1",
                "rename the joint, or save the file as UTF-8",
            ),
            Deviation::TrailingText { .. } => {
                (Warning, "trailing-text", "it is no motion and is left out", "delete it, if it bothers you")
            }
            Deviation::TrailingNul { .. } => (
                Warning,
                "trailing-nul",
                "a program that crashed while writing leaves such bytes; the frames before are used",
                "compare the length of the clip with the take's",
            ),
            Deviation::ZeroFrames => (
                Warning,
                "zero-frames",
                "a skeleton without motion gives no rows",
                "delete the file if it holds only a skeleton",
            ),
            Deviation::HierarchyWordAbsent { .. } => (
                Fault,
                "hierarchy-word-absent",
                "every BVH file begins with HIERARCHY; this may be another format",
                "check what program wrote it",
            ),
            Deviation::CutInHierarchy { .. } => (Fault, "cut-in-hierarchy", "there is no motion to read", CUT),
            Deviation::BraceMissing { .. } => (
                Fault,
                "brace-missing",
                "which joint belongs to which parent can't be told",
                "close the brace, or export it again",
            ),
            Deviation::BraceExtra => (
                Fault,
                "brace-extra",
                "which joint belongs to which parent can't be told",
                "delete the brace, or export it again",
            ),
            Deviation::NameAbsent => (Fault, "name-absent", "columns need names", "name the joint, or export it again"),
            Deviation::OffsetAbsent { .. } => {
                (Fault, "offset-absent", "without it the joint has no place", EXPORT_AGAIN)
            }
            Deviation::OffsetShort { .. } => {
                (Fault, "offset-short", "an OFFSET is three numbers: x, y and z", EXPORT_AGAIN)
            }
            Deviation::SaidTwice { .. } => (Fault, "said-twice", "which of the two counts can't be told", EXPORT_AGAIN),
            Deviation::ChannelUnknown { .. } => (
                Fault,
                "channel-unknown",
                "channels are Xposition, Yposition, Zposition, Xrotation, Yrotation and Zrotation",
                EXPORT_AGAIN,
            ),
            Deviation::ChannelCount { .. } => {
                (Fault, "channel-count", "a wrong count shifts every later joint", EXPORT_AGAIN)
            }
            Deviation::NameTwice { .. } => (
                Warning,
                "name-twice",
                "both are kept; columns of the later are marked `#2`, `#3` and so on",
                "rename one of them, so that roles can tell them apart",
            ),
            Deviation::EndSiteTwice { .. } => {
                (Warning, "end-site-twice", "a joint has one end; the first is used", CHECK_USED)
            }
            Deviation::NoMotion => (Fault, "no-motion", "there is a skeleton, but no frame of it", CUT),
            Deviation::FramesAbsent { .. } => {
                (Fault, "frames-absent", "`Frames:` and `Frame Time:` come before the rows", EXPORT_AGAIN)
            }
            Deviation::FramesUnreadable { .. } => (
                Fault,
                "frames-unreadable",
                "the count of frames is a whole number from 0",
                "write the count of rows there",
            ),
            Deviation::FrameTimeAbsent { .. } => (
                Fault,
                "frame-time-absent",
                "without it the motion has no rate",
                "write `Frame Time: 0.0333333` (for 30 frames a second) below `Frames:`",
            ),
            Deviation::FrameTimeUnusable { .. } => (
                Fault,
                "frame-time-unusable",
                "without the seconds of a frame the motion has no rate",
                "write `Frame Time: 0.0333333` (for 30 frames a second) there",
            ),
            Deviation::FramesFewer { .. } => (
                Warning,
                "frames-fewer-than-said",
                "the rows are used; the clip may have been cut",
                "compare its length with the take's",
            ),
            Deviation::FramesMore { .. } => (Warning, "frames-more-than-said", "the rows are used", CHECK_USED),
            Deviation::RowWidth { .. } => (
                Fault,
                "row-width",
                "a row of another length shifts every later joint, so the clip can't be trusted",
                EXPORT_AGAIN,
            ),
            Deviation::SectionUnknown { .. } => (
                Warning,
                "section-unknown",
                "the format has no such section; it is left out",
                "nothing, unless it holds motion",
            ),
            Deviation::LengthUnitAbsent => (
                Warning,
                "length-unit-absent",
                "1 is assumed, so that one unit is an inch",
                "write `length 0.45` (CMU) below :units, or set `unit_m` for this source",
            ),
            Deviation::RootOrderAbsent => (
                Warning,
                "root-order-absent",
                "TX TY TZ RX RY RZ is assumed",
                "write `order TX TY TZ RX RY RZ` below :root",
            ),
            Deviation::UnitUnusable { .. } => (
                Fault,
                "unit-unusable",
                "sizes and angles can't be told without it",
                "write `length 0.45` and `angle deg` (CMU) below :units",
            ),
            Deviation::DofUnknown { .. } => {
                (Fault, "dof-unknown", "degrees of freedom are tx, ty, tz, rx, ry, rz and l", EXPORT_AGAIN)
            }
            Deviation::AxisLetters { .. } => (
                Fault,
                "axis-letters",
                "rotations are applied in the order of these letters",
                "write XYZ or another order of the three",
            ),
            Deviation::BoneIncomplete { .. } => {
                (Fault, "bone-incomplete", "without it the bone has no place", "fetch the skeleton again")
            }
            Deviation::BoneTwice { .. } => {
                (Fault, "bone-twice", "which of the two counts can't be told", "rename or delete one of them")
            }
            Deviation::CutInBone { .. } => (Fault, "cut-in-bone", "the bones and their hierarchy are incomplete", CUT),
            Deviation::NoHierarchy => (Fault, "no-hierarchy", "which bone hangs on which can't be told", CUT),
            Deviation::HierarchyUnknownBone { .. } => (
                Fault,
                "hierarchy-unknown-bone",
                ":bonedata has no such bone",
                "correct the name, or fetch the skeleton again",
            ),
            Deviation::TwoParents { .. } => {
                (Fault, "two-parents", "a bone hangs on one other bone", "delete one of the two lines")
            }
            Deviation::HierarchyLoose { .. } => (
                Fault,
                "hierarchy-loose",
                "no path leads there from the root",
                "let every chain of :hierarchy begin at root",
            ),
            Deviation::BoneOutsideHierarchy { .. } => (
                Warning,
                "bone-outside-hierarchy",
                "it hangs on nothing; it and its motion are left out",
                "add it to a line of :hierarchy",
            ),
            Deviation::AngleUnitAbsent { .. } => (
                Warning,
                "angle-unit-absent",
                "the skeleton's angle unit is taken",
                "write :DEGREES or :RADIANS at the top",
            ),
            Deviation::BeforeFirstFrame { .. } => (
                Fault,
                "before-first-frame",
                "which frame it belongs to can't be told",
                "write the frame's number above it",
            ),
            Deviation::BoneValues { .. } => (
                Fault,
                "bone-values",
                "which number is which can't be told, so the clip is left out",
                "check that this is its skeleton, or fetch the file again",
            ),
            Deviation::BoneLineTwice { .. } => {
                (Fault, "bone-line-twice", "which of the two counts can't be told", EXPORT_AGAIN)
            }
            Deviation::BoneUnknown { .. } => (
                Warning,
                "bone-unknown",
                "the skeleton lacks it; its lines are left out",
                "check that this is the clip's skeleton",
            ),
            Deviation::BoneLineAbsent { .. } => (
                Warning,
                "bone-line-absent",
                "the last value is kept (0 before the first), which can look like a freeze",
                CHECK_USED,
            ),
            Deviation::BoneAbsentEverywhere { .. } => (
                Warning,
                "bone-absent-everywhere",
                "zero is taken: the bone rests in the skeleton's pose",
                "check that this is the clip's skeleton",
            ),
            Deviation::SkeletonMismatch { .. } => (
                Fault,
                "skeleton-mismatch",
                "not one line of the motion fits this skeleton",
                "name the right .asf file for this clip in your config",
            ),
            Deviation::MostlyAbsent { .. } => (
                Fault,
                "bone-lines-mostly-absent",
                "most of the motion would have to be made up",
                "check that this is the clip's skeleton, or export it again",
            ),
            Deviation::FrameGap { .. } => (
                Warning,
                "frame-gap",
                "frames are read in the order of the file, so the motion may jump there",
                "cut the clip at the gap if it does",
            ),
            Deviation::FrameNumberTwice { .. } => {
                (Warning, "frame-number-twice", "both frames are read, in the order of the file", CHECK_USED)
            }
            Deviation::AngleUnitTwice { .. } => (
                Fault,
                "angle-unit-twice",
                "whether the numbers are degrees or radians can't be told",
                "delete one of the two lines",
            ),
        }
    }

    /// What was found, with the file's own values. `frame` counts from 0, where the file has no number of its own.
    pub fn message(&self, frame: Option<u32>) -> String {
        let frame = frame.map_or_else(|| "the row".to_owned(), |frame| format!("frame {frame}"));
        match self {
            Deviation::EmptyFile => "the file is empty".to_owned(),
            Deviation::FileTooLarge { bytes, limit } => format!("{bytes} bytes, the limit is {limit}"),
            Deviation::TooManyJoints { limit } => format!("more than {limit} joints"),
            Deviation::TooDeep { limit } => format!("joints nested more than {limit} deep"),
            Deviation::NameTooLong { bytes, limit } => format!("a name of {bytes} bytes, the limit is {limit}"),
            Deviation::TooManyPoses { frames, joints, limit } => {
                format!("{frames} frames of {joints} joints, the limit is {limit} in all")
            }
            Deviation::BadNumber { flaw, place, found } => match flaw {
                NumberFlaw::Malformed => format!("{place}: `{found}` is not a number"),
                NumberFlaw::NotFinite => format!("{place}: `{found}` is not a finite number"),
                NumberFlaw::TooLarge => format!("{place}: `{found}` is too large"),
                NumberFlaw::DecimalComma => format!("{place}: `{found}` has a decimal comma"),
            },
            Deviation::Unexpected { expected, found } => format!("`{found}` where {expected} belongs"),
            Deviation::NameNotUtf8 { name } => format!("a name is not UTF-8; it is read as `{name}`"),
            Deviation::TrailingText { bytes, found } => {
                format!("{bytes} bytes after the last frame, beginning with `{found}`")
            }
            Deviation::TrailingNul { bytes } => format!("{bytes} bytes after the last frame, beginning with NULs"),
            Deviation::ZeroFrames => "no frames".to_owned(),
            Deviation::HierarchyWordAbsent { found } => format!("the file begins with `{found}`, not with HIERARCHY"),
            Deviation::CutInHierarchy { open } => format!("the file ends inside the hierarchy, {open} braces open"),
            Deviation::BraceMissing { joint, open } => {
                format!("MOTION inside joint `{joint}`: {open} closing braces are missing")
            }
            Deviation::BraceExtra => "a closing brace too many".to_owned(),
            Deviation::NameAbsent => "a joint without a name".to_owned(),
            Deviation::OffsetAbsent { joint } => format!("joint `{joint}` has no OFFSET"),
            Deviation::OffsetShort { joint, found } => format!("the OFFSET of `{joint}` has {found} numbers, not 3"),
            Deviation::SaidTwice { joint, word } => format!("joint `{joint}` has {word} twice"),
            Deviation::ChannelUnknown { joint, found } => format!("joint `{joint}`: `{found}` is no channel"),
            Deviation::ChannelCount { joint, expected, found } => {
                format!("joint `{joint}`: `CHANNELS {expected}`, but {found} channel names follow")
            }
            Deviation::NameTwice { name } => format!("a second joint is called `{name}`"),
            Deviation::EndSiteTwice { joint } => format!("joint `{joint}` has a second End Site"),
            Deviation::NoMotion => "the file ends after the hierarchy, without MOTION".to_owned(),
            Deviation::FramesAbsent { found } => format!("`{found}` where `Frames:` belongs"),
            Deviation::FramesUnreadable { found } => format!("`Frames: {found}` is not a count"),
            Deviation::FrameTimeAbsent { found } => format!("`{found}` where `Frame Time:` belongs"),
            Deviation::FrameTimeUnusable { found } => format!("`Frame Time: {found}` gives no rate"),
            Deviation::FramesFewer { said, found } | Deviation::FramesMore { said, found } => {
                format!("`Frames: {said}`, but {found} rows follow; the rows are used")
            }
            Deviation::RowWidth { expected, found } => {
                format!("{frame} has {found} values, the skeleton declares {expected} channels")
            }
            Deviation::SectionUnknown { section } => format!("section `{section}` is not known"),
            Deviation::LengthUnitAbsent => "no `length` in :units".to_owned(),
            Deviation::RootOrderAbsent => "no `order` in :root".to_owned(),
            Deviation::UnitUnusable { unit, found } => format!("`{unit} {found}` can't be used"),
            Deviation::DofUnknown { bone, found } => format!("bone `{bone}`: `{found}` is no degree of freedom"),
            Deviation::AxisLetters { bone, found } => {
                format!("bone `{bone}`: `{found}` are not X, Y and Z in some order")
            }
            Deviation::BoneIncomplete { bone, lacks } => format!("bone `{bone}` has no {lacks}"),
            Deviation::BoneTwice { bone } => format!("a second bone is called `{bone}`"),
            Deviation::CutInBone { bone } => format!("the file ends inside bone `{bone}`"),
            Deviation::NoHierarchy => "the file ends without a :hierarchy".to_owned(),
            Deviation::HierarchyUnknownBone { bone } => format!("the hierarchy names `{bone}`, which :bonedata lacks"),
            Deviation::TwoParents { bone } => format!("bone `{bone}` has two parents"),
            Deviation::HierarchyLoose { bone } => format!("the chain of `{bone}` doesn't begin at the root"),
            Deviation::BoneOutsideHierarchy { bone } => format!("bone `{bone}` is in no line of :hierarchy"),
            Deviation::AngleUnitAbsent { assumed } => format!("neither :DEGREES nor :RADIANS; {assumed} are taken"),
            Deviation::BeforeFirstFrame { found } => format!("`{found}` before the first frame number"),
            Deviation::BoneValues { number, bone, expected, found } => {
                format!("frame {number}, bone `{bone}`: {found} values, the skeleton declares {expected}")
            }
            Deviation::BoneLineTwice { number, bone } => format!("frame {number} has two lines for bone `{bone}`"),
            Deviation::BoneUnknown { bone } => format!("bone `{bone}` is not in the skeleton"),
            Deviation::BoneLineAbsent { number, bones } => format!("frame {number} has no line for {}", list(bones)),
            Deviation::BoneAbsentEverywhere { bones } => format!("no frame has a line for {}", list(bones)),
            Deviation::SkeletonMismatch { found } => {
                format!("no bone of the skeleton moves; the first line is for `{found}`")
            }
            Deviation::MostlyAbsent { number } => format!("up to frame {number}, most bones have no line"),
            Deviation::FrameGap { from, to } => format!("frame {to} follows frame {from}"),
            Deviation::FrameNumberTwice { number } => format!("frame number {number} stands twice"),
            Deviation::AngleUnitTwice { found } => format!("`{found}` contradicts the angle unit before it"),
        }
    }
}

/// Names as a list, the first few in full.
fn list(names: &[String]) -> String {
    const MOST: usize = 5;
    let shown: Vec<String> = names.iter().take(MOST).map(|name| format!("`{name}`")).collect();
    let more = names.len().saturating_sub(MOST);
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { shown.join(", ") }
}
