//! What happens in every frame: features, foot contacts, gait, plant states.

pub mod labels;

pub use labels::{ClipLabels, Features, Foot, FrameLabels, Gait, Plant, PlantState, Segment};
