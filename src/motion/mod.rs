//! What a motion is: skeletons, joint roles, clips, poses, and the geometry between them.
//!
//! A [`Clip`] keeps what the file said (channels in file order and file units); [`kinematics`] turns it into
//! [`Poses`] (metres, Y up, world). Degrees and centimetres stop there. Which joint is which is decided by
//! [`assign_roles`]: [`role_names`] first, else [`folding`] and [`role_topology`]. What a file leaves unsaid (unit,
//! up axis) is guessed in [`bounds`].

pub mod bounds;
pub mod chains;
pub mod clip;
pub mod folding;
mod kernels;
pub mod kinematics;
mod lanes;
pub mod notice;
mod pose_program;
pub mod poses;
pub mod resample;
pub mod role_assign;
pub mod role_names;
pub mod role_topology;
pub mod roles;
pub mod rotation;
#[cfg(test)]
mod sample_bodies;
mod sincos;
pub mod skeleton;

pub use chains::{BodyChain, BodyChains};
pub use clip::{Clip, UpAxis};
pub use notice::{Notice, Severity};
pub use poses::{Poses, Rotations};
pub use role_assign::{RoleSource, assign_roles};
pub use role_names::{NameTable, NameTableError, NameTables};
pub use roles::{Role, RoleMap};
pub use skeleton::{Axis, Bone, Channel, ChannelKind, Format, Joint, RestAxis, Skeleton};
