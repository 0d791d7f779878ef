//! What reading gives, and what it may cost.

use super::finding::{Deviation, Finding};
use crate::motion::skeleton::PositionRule;
use crate::motion::{Clip, Notice, Severity, Skeleton, UpAxis};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Limits on a file; beyond them it is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadLimits {
    /// Size of a clip or skeleton file, bytes.
    pub max_clip_bytes: u64,
    /// Joints of a skeleton, count.
    pub max_joints: usize,
    /// Joints from a root to a leaf, count.
    pub max_depth: usize,
    /// Length of a joint's name, bytes.
    pub max_name_bytes: usize,
    /// Frames times joints, count: what kinematics will have to hold. A file of n bytes may never ask for more than 16 n.
    pub max_poses: u64,
}

/// How to read a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// Beyond these a file is refused.
    pub limits: ReadLimits,
    /// What position channels of a BVH file do to offsets.
    pub position_rule: PositionRule,
    /// Every warning is a fault.
    pub strict: bool,
}

/// A clip as the file said it: channels in file order and file units.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Joints and channels; the angle unit is the motion's own.
    pub skeleton: Skeleton,
    /// Number of frames.
    pub n_frames: usize,
    /// `[frame][channel]`, the nearest f32 of what was read.
    pub channels: Vec<f32>,
    /// As read, seconds; AMC says none.
    pub frame_time_s: Option<f64>,
    /// Metres a file unit, where the file says it (ASF: 0.0254 / length).
    pub unit_m: Option<f64>,
    /// Largest distance of a channel from what was read, file units.
    pub max_rounding: f32,
    /// HIERARCHY or ASF text, verbatim (repaired to UTF-8).
    pub header: String,
    /// The file's number of the first frame; 0 where it has none.
    pub first_frame_number: i64,
}

/// Something read, and what there is to say about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading<T> {
    /// What was read.
    pub value: T,
    /// Warnings, at most one a kind, in the order of their lines.
    pub findings: Vec<Finding>,
}

/// Why a motion can't be written in a format, or converted to it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A BVH writer was given an Acclaim skeleton or the other way round.
    #[error("the skeleton is {found}; convert it to {expected} first")]
    WrongFormat {
        /// The writer's format.
        expected: &'static str,
        /// The skeleton's.
        found: &'static str,
    },
    /// The channels don't fill whole frames.
    #[error("{values} values are no whole number of frames of {width} channels")]
    RaggedChannels {
        /// Length of the table.
        values: usize,
        /// Channels of a frame.
        width: usize,
    },
    /// A value that text can't carry.
    #[error("frame {frame}, channel {channel}: {value} is not a finite number")]
    NotFinite {
        /// From 0.
        frame: usize,
        /// From 0.
        channel: usize,
        /// NaN or infinite.
        value: f32,
    },
    /// The format holds one body.
    #[error("{roots} roots, where Acclaim holds one")]
    NotOneRoot {
        /// Roots of the skeleton.
        roots: usize,
    },
    /// The rate or the unit is not a positive number.
    #[error("{what} is {value}, not a positive number")]
    NotPositive {
        /// `frame_time_s` or `unit_m`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

impl Default for ReadLimits {
    fn default() -> Self {
        ReadLimits {
            max_clip_bytes: 2 << 30,
            max_joints: 4096,
            max_depth: 4096,
            max_name_bytes: 1024,
            max_poses: 200_000_000,
        }
    }
}

impl<T> Reading<T> {
    /// The findings in sentences.
    pub fn notices(&self) -> Vec<Notice> {
        self.findings.iter().map(Finding::notice).collect()
    }

    /// With `strict`, the first warning refuses the file.
    pub(crate) fn checked(value: T, mut findings: Vec<Finding>, options: &ReadOptions) -> Result<Self, Finding> {
        let warning = findings.iter().position(|finding| finding.severity == Severity::Warning);
        match warning {
            Some(first) if options.strict => {
                let mut fault = findings.swap_remove(first);
                fault.severity = Severity::Fault;
                Err(fault)
            }
            _ => Ok(Reading { value, findings }),
        }
    }
}

impl Motion {
    /// As a clip, with what the file can't say.
    pub fn into_clip(self, rate_hz: f64, unit_m: f64, up: UpAxis) -> Clip {
        let Motion { skeleton, n_frames, channels, .. } = self;
        Clip { skeleton: Arc::new(skeleton), rate_hz, unit_m, up, n_frames, channels }
    }
}

impl ReadLimits {
    pub(crate) fn check_bytes(&self, bytes: &[u8]) -> Result<(), Finding> {
        let (found, limit) = (bytes.len() as u64, self.max_clip_bytes);
        if found > limit {
            return Err(Finding::new(1, Deviation::FileTooLarge { bytes: found, limit }));
        }
        Ok(())
    }

    /// A small file must not ask for the memory of a large one either: a body's frame takes some 20 bytes a joint.
    pub(crate) fn check_poses(&self, frames: usize, joints: usize, bytes: &[u8], line: u32) -> Result<(), Finding> {
        const MAX_POSES_PER_BYTE: u64 = 16;
        let limit = self.max_poses.min(MAX_POSES_PER_BYTE * bytes.len() as u64);
        if frames as u64 > limit / joints.max(1) as u64 {
            return Err(Finding::new(line, Deviation::TooManyPoses { frames, joints, limit }));
        }
        Ok(())
    }
}

/// That a table of channels can be written: whole frames, finite numbers.
pub(crate) fn check_channels(channels: &[f32], width: usize) -> Result<(), WriteError> {
    if width == 0 && !channels.is_empty() || width > 0 && !channels.len().is_multiple_of(width) {
        return Err(WriteError::RaggedChannels { values: channels.len(), width });
    }
    match channels.iter().position(|value| !value.is_finite()) {
        Some(at) => Err(WriteError::NotFinite { frame: at / width, channel: at % width, value: channels[at] }),
        None => Ok(()),
    }
}
