//! Where every point of the body is in every frame: metres, world space, Y up.

use glam::{DQuat, DVec3};

/// World positions of a clip's points: its joints, then the ends of its leaves ([`Skeleton::ends`](super::Skeleton::ends)).
#[derive(Clone, Debug, PartialEq)]
pub struct Poses {
    /// Number of frames.
    pub n_frames: usize,
    /// Joints plus ends.
    pub n_points: usize,
    /// `[frame][point]`, metres.
    pub world: Vec<DVec3>,
}

/// Rotations of a clip's joints, unit quaternions.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotations {
    /// Number of frames.
    pub n_frames: usize,
    /// Joints, without ends.
    pub n_joints: usize,
    /// `[frame][joint]`, relative to the parent; no sign flips from frame to frame.
    pub local: Vec<DQuat>,
    /// `[frame][joint]`, relative to the scene (Y up).
    pub world: Vec<DQuat>,
}

impl Poses {
    /// Position of a point in a frame.
    pub fn at(&self, frame: usize, point: usize) -> DVec3 {
        self.world[frame * self.n_points + point]
    }

    /// The path of one point, `[frame]`.
    pub fn path(&self, point: usize) -> Vec<DVec3> {
        (0..self.n_frames).map(|frame| self.at(frame, point)).collect()
    }
}

impl Rotations {
    /// Local rotation of a joint in a frame.
    pub fn local_at(&self, frame: usize, joint: usize) -> DQuat {
        self.local[frame * self.n_joints + joint]
    }

    /// World rotation of a joint in a frame.
    pub fn world_at(&self, frame: usize, joint: usize) -> DQuat {
        self.world[frame * self.n_joints + joint]
    }
}
