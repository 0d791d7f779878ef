//! Motion files as text: BVH, ASF and AMC, bytes in, motion and notices out. Opens no file.
//!
//! Reading is exact and tolerant: every dialect that has one meaning is read, with a [`Finding`] for each
//! deviation that a user should hear of; what has no meaning is refused with a `Finding` of severity fault that
//! says where and why. Input is hostile: nothing here panics, recurses, or allocates by a number that has not
//! been checked against the bytes that are there. A [`Motion`] holds the nearest `f32` of every number, which
//! [`write_bvh`] and [`write_amc`] print so that they read back bit for bit.
//!
//! ```
//! use motionmill::formats::{ReadOptions, read_bvh};
//!
//! let text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 1 Yposition\n}\n\
//!     MOTION\nFrames: 3\nFrame Time: .05\n91.5\n92\n";
//! let reading = read_bvh(text.as_bytes(), &ReadOptions::default())?;
//! assert_eq!(reading.value.channels, [91.5, 92.0]);
//! assert_eq!(reading.notices()[0].message, "`Frames: 3`, but 2 rows follow; the rows are used");
//! # Ok::<(), motionmill::formats::Finding>(())
//! ```

pub mod acclaim;
pub mod bvh;
pub mod finding;
pub mod number;
pub mod reading;

mod text;
mod wording;

pub use acclaim::{AsfSkeleton, acclaim_to_bvh, bvh_to_acclaim, read_amc, read_asf, write_amc, write_asf};
pub use bvh::{read_bvh, write_bvh};
pub use finding::{Deviation, Finding, NumberFlaw};
pub use reading::{Motion, ReadLimits, ReadOptions, Reading, WriteError};
