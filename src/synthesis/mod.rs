//! New clips from the ones that are there: correlation, grafts, recipes, and the judge.
//!
//! In reading order: a [`Subject`] is a clip with its movement and [`parts`]; [`compose`] says which pairs are allowed;
//! [`action`] what a donor's arms do; [`correlation`] and [`placement`] which donor frame goes with which base frame;
//! [`graft`](mod@graft) makes the clip, with its [`provenance`]; the [`judge`] sets it beside its parents.

pub mod action;
pub mod angles;
pub mod compose;
pub mod correlation;
pub mod graft;
pub mod groups;
pub mod heading;
pub mod judge;
pub mod making;
pub mod parts;
pub mod placement;
pub mod portrait;
pub mod product;
pub mod provenance;
pub mod refusal;
pub mod selection;
pub mod signal;
pub mod subject;
pub mod tables;
#[cfg(test)]
mod walker;

pub use action::{Action, ActionSettings};
pub use compose::Rule;
pub use correlation::{Alternate, CorrelationSettings, Footwork, FrameMap};
pub use graft::{GraftSettings, GraftedClip, Misfit, Seam, graft};
pub use judge::{Figures, GateSettings, Measure, Verdict};
pub use parts::{Part, Parts};
pub use placement::{Placement, Timing};
pub use provenance::Provenance;
pub use refusal::Refusal;
pub use subject::{Movement, Subject, Unfit};
pub use tables::{Figure, Made, ProvenanceRow, Recipe};
