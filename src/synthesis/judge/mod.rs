//! The judge: figures of a made clip beside the same figures of its parents, one gate per kind of fault (GRAFTS 5).
//!
//! Figures compare only at one rate: a parent at another rate is resampled to its child's first
//! ([`Movement::resampled`](super::Movement::resampled)), since a 120 Hz capture has more jerk than a 30 Hz one.

pub mod arm_leg;
pub mod collision;
pub mod contacts;
pub mod directions;
pub mod figures;
pub mod gates;
pub mod joint_ranges;
pub mod reference;

pub use figures::{Figures, Measure};
pub use gates::{GateSettings, Verdict, figure_rows, judge};
pub use joint_ranges::{JointRange, RangeCounts, limit_excess};
pub use reference::{Reference, ReferenceCounts};
