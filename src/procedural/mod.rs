//! People who stand, walk, run, jump, hop, climb and wave, made from a footstep plan, with ground truth.
//!
//! In order of making: a [`ClipSpec`] lists [`Act`]s; `steady` says how each steps, from the speed's Froude number;
//! [`plan`] lays out strikes, lift-offs and places of the feet along a path and its ground; `carriage` carries the hips over them (load, sway, ballistic
//! flight); `feet` roll over heel and ball and swing from stance to stance; `legs` bend to reach them; `arms` swing
//! against the legs or do something of their own; `clip` writes it all as the channels of a CMU-like skeleton, as
//! ASF/AMC or BVH. `bench` and `corpus` list varied clips, `disturb` spoils what was made. The [`Truth`] of a clip comes from its plan alone, never from the poses that were made of it.
//!
//! Everything is a pure function of its spec; draws depend on (seed, clip name, purpose), so that a larger corpus
//! begins with the same clips.

mod act;
mod arms;
pub mod bench;
mod body;
mod carriage;
pub mod clip;
pub mod corpus;
pub mod disturb;
mod draws;
mod feet;
pub mod free_joints;
mod legs;
mod mover;
mod pace;
mod path;
pub mod plan;
mod planner;
pub mod skeleton;
mod steady;
mod style;

pub use act::{Act, PlanError};
pub use arms::{ArmAction, Gesture};
pub use bench::{BenchGroup, bench};
pub use clip::{ClipSpec, MakeError, SyntheticClip, TrueStance, Truth, make};
pub use corpus::corpus;
pub use disturb::{DisturbError, Disturbance, disturb};
pub use draws::Draws;
pub use free_joints::with_joint_positions;
pub use pace::Pace;
pub use path::{Course, Knots, Path, Waypoint};
pub use skeleton::{Subject, acclaim_skeleton, asf_text, bvh_skeleton};
pub use style::Style;
