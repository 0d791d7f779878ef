//! Acclaim files: a skeleton (ASF) of bones with rest axes and degrees of freedom, and motions (AMC) for it.
//!
//! A bone becomes the joint at its near end (see [`skeleton`](crate::motion::skeleton)): `lfemur` is the hip.
//! Joints are numbered root first, then as `:bonedata` lists them where that puts parents before children, else
//! in the earliest order that does.

mod amc;
mod asf;

mod tree;

pub use amc::read_amc;
pub use asf::{AsfSkeleton, read_asf};

/// Metres of an inch; one unit of an ASF file is an inch over the `length` of its `:units`.
const INCH_M: f64 = 0.0254;

/// A line without its comment.
fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|&byte| byte == b'#').next().unwrap_or(line)
}
