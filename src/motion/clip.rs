//! A clip: a named run of frames of one skeleton at one rate, as the file said it.

use super::skeleton::Skeleton;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Which axis of the file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// Y up: nothing is turned.
    #[default]
    Y,
    /// Z up, right-handed: (x, y, z) of the file becomes (x, z, -y).
    Z,
}

/// Frames of one skeleton at one rate; channels in file order and file units.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Shared by the clips of one body.
    pub skeleton: Arc<Skeleton>,
    /// Frames a second, snapped (see [`snap_rate_hz`]).
    pub rate_hz: f64,
    /// Metres a file unit.
    pub unit_m: f64,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Number of frames.
    pub n_frames: usize,
    /// `[frame][channel]`, the nearest f32 of what was read.
    pub channels: Vec<f32>,
}

impl Clip {
    /// The channels of one frame.
    pub fn frame(&self, frame: usize) -> &[f32] {
        let width = self.skeleton.n_channels();
        &self.channels[frame * width..(frame + 1) * width]
    }

    /// Frames over rate.
    pub fn duration_s(&self) -> f64 {
        self.n_frames as f64 / self.rate_hz
    }
}

/// The rate that a frame time means: a whole number, or n x 1000 / 1001, if that is within 1e-4 of its inverse
/// (files print 0.0333333); the inverse itself otherwise.
pub fn snap_rate_hz(frame_time_s: f64) -> f64 {
    let raw = 1.0 / frame_time_s;
    let near = |rate: f64| rate > 0.0 && ((raw - rate) / rate).abs() <= 1e-4;
    let whole = raw.round();
    if near(whole) {
        return whole;
    }
    let broadcast = (raw * 1.001).round() * 1000.0 / 1001.0;
    if near(broadcast) { broadcast } else { raw }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_frame_times_snap_to_the_rate_they_mean() {
        assert_eq!(snap_rate_hz(0.0333333), 30.0);
        assert_eq!(snap_rate_hz(0.0083333), 120.0);
        assert_eq!(snap_rate_hz(0.033367), 30000.0 / 1001.0);
        assert_eq!(snap_rate_hz(0.0123), 1.0 / 0.0123);
        assert_eq!(snap_rate_hz(2.0), 0.5);
    }
}
