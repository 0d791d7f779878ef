//! Acclaim files: a skeleton (ASF) of bones with rest axes and degrees of freedom, and motions (AMC) for it.
//!
//! A bone becomes the joint at its near end (see [`skeleton`](crate::motion::skeleton)): `lfemur` is the hip.
//! Joints are numbered root first, then as `:bonedata` lists them where that puts parents before children, else
//! in the earliest order that does.

mod amc;
mod asf;
mod from_bvh;
mod to_bvh;
mod tree;
mod write;

pub use amc::read_amc;
pub use asf::{AsfSkeleton, read_asf};
pub use from_bvh::bvh_to_acclaim;
pub use to_bvh::acclaim_to_bvh;
pub use write::{write_amc, write_asf};

/// Metres of an inch; one unit of an ASF file is an inch over the `length` of its `:units`.
const INCH_M: f64 = 0.0254;

/// A line without its comment.
fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|&byte| byte == b'#').next().unwrap_or(line)
}
