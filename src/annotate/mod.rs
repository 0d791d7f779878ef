//! What happens in every frame: features, foot contacts, gait, plant states.
//!
//! Poses in, labels out. [`annotate()`] gives the rows of `annotations`, `plants`, `segments` and
//! `clips`, [`features`](features::features) those of `features`, [`samples`](samples::samples) the frames that
//! clustering works on. The way from poses to a gait:
//!
//! ```text
//! root             where the hips are and face             baseline   differences over 1/30 s
//! contacts         feet on the ground, frame by frame      plants     where a foot stands, from when to when
//! gait_tokens      N L R B and their runs                  plant_state      the thesis' seven states
//! gait_machine     the thesis' strict class                gait_supports -> gait_steps -> gait_segments   the default
//! gait_summary     class, confidence, duty                 phase      of the stride
//! ```
//!
//! Contacts and gaits are those of people who stand, walk, run and jump on level ground; other motion comes out
//! as unknown or with low confidence, never as an error.

pub mod annotated;
pub mod baseline;
pub mod checks;
pub mod contacts;
pub mod features;
pub mod gait_machine;
pub mod gait_segments;
pub mod gait_steps;
pub mod gait_summary;
pub mod gait_supports;
pub mod gait_tokens;
pub mod labels;
pub mod order_statistics;
pub mod phase;
pub mod plant_state;
pub mod plants;
pub mod root;
pub mod samples;

pub use annotated::{Annotated, Settings, annotate, annotate_about};
pub use contacts::{ContactSettings, Detector};
pub use labels::{ClipLabels, Features, Foot, FrameDiagnostics, FrameLabels, Gait, Plant, PlantState, Segment};
