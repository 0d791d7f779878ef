//! Differences over 1/30 s on either side of a frame: the one baseline of all velocities (DESIGN 3).
//!
//! One frame of noise at 120 Hz weighs sixteen times as much in an acceleration as at 30 Hz; a baseline fixed in
//! seconds makes clips of different rates comparable.

use core::ops::{Add, Mul, Sub};

/// Length of one side of the baseline, seconds.
pub const BASELINE_S: f64 = 1.0 / 30.0;

/// One side of the baseline in frames of a clip: `rate / 30`, at least one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    rate_hz: f64,
    step: f64,
}

/// What can be differenced: a number or a vector.
pub trait Quantity: Copy + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Default + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Quantity for T {}

impl Baseline {
    /// The baseline of a clip of that rate.
    pub fn new(rate_hz: f64) -> Baseline {
        let step = if rate_hz > 30.0 { rate_hz / 30.0 } else { 1.0 };
        Baseline { rate_hz, step }
    }

    /// Central difference, per second. Where the clip ends within a step the difference stops at the clip's end, so
    /// it is one-sided in the first and the last frame. Zero in a clip of one frame.
    pub fn velocity<T: Quantity>(&self, path: &[T], frame: usize) -> T {
        let (Some(last), here) = (path.len().checked_sub(1), frame as f64) else { return T::default() };
        let (before, after) = ((here - self.step).max(0.0), (here + self.step).min(last as f64));
        if after <= before {
            return T::default();
        }
        (self.at(path, after) - self.at(path, before)) * (self.rate_hz / (after - before))
    }

    /// Second difference, per second squared; within a step of an end that of the nearest frame that has a whole
    /// step on both sides. Zero in a clip that has no such frame.
    pub fn acceleration<T: Quantity>(&self, path: &[T], frame: usize) -> T {
        let Some(last) = path.len().checked_sub(1) else { return T::default() };
        let (first_inner, last_inner) = (self.step.ceil(), (last as f64 - self.step).floor());
        if first_inner > last_inner {
            return T::default();
        }
        let here = (frame as f64).clamp(first_inner, last_inner);
        let (before, middle, after) =
            (self.at(path, here - self.step), self.at(path, here), self.at(path, here + self.step));
        let per_second = self.rate_hz / self.step;
        ((after - middle) - (middle - before)) * (per_second * per_second)
    }

    /// The path at a fractional frame inside the clip: the cubic through the four nearest frames, a line in clips
    /// of fewer than four.
    fn at<T: Quantity>(&self, path: &[T], frame: f64) -> T {
        let floor = frame.floor();
        let index = floor as usize;
        if frame == floor {
            return path[index];
        }
        if path.len() < 4 {
            return path[index] + (path[index + 1] - path[index]) * (frame - floor);
        }
        let first = index.saturating_sub(1).min(path.len() - 4);
        let x = frame - first as f64;
        let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
        path[first] * (b * c * d / -6.0)
            + path[first + 1] * (a * c * d / 2.0)
            + path[first + 2] * (a * b * d / -2.0)
            + path[first + 3] * (a * b * c / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic in time: differences of it are known, and cubic interpolation is exact.
    fn cubic(n_frames: usize, rate_hz: f64) -> Vec<f64> {
        (0..n_frames)
            .map(|frame| frame as f64 / rate_hz)
            .map(|t| 1.0 + 2.0 * t - 3.0 * t * t + 4.0 * t * t * t)
            .collect()
    }

    #[test]
    fn the_baseline_is_a_thirtieth_of_a_second_at_every_rate() {
        for rate_hz in [30.0, 45.0, 59.94, 60.0, 100.0, 119.88, 120.0, 240.0] {
            let path = cubic(240, rate_hz);
            let baseline = Baseline::new(rate_hz);
            for frame in [20, 77, 200] {
                let t = frame as f64 / rate_hz;
                // Of t^3 the central difference over h gives 3 t^2 + h^2; its second difference 6 t.
                let velocity = 2.0 - 6.0 * t + 4.0 * (3.0 * t * t + BASELINE_S * BASELINE_S);
                let acceleration = -6.0 + 24.0 * t;
                assert!((baseline.velocity(&path, frame) - velocity).abs() < 1e-9, "{rate_hz} Hz, frame {frame}");
                assert!(
                    (baseline.acceleration(&path, frame) - acceleration).abs() < 1e-7,
                    "{rate_hz} Hz, frame {frame}"
                );
            }
        }
    }

    #[test]
    fn slow_clips_use_one_frame() {
        let path: Vec<f64> = (0..10).map(|frame| f64::from(frame * frame)).collect();
        let baseline = Baseline::new(24.0);
        assert_eq!(baseline.velocity(&path, 4), 8.0 * 24.0);
        assert!((baseline.acceleration(&path, 4) - 2.0 * 24.0 * 24.0).abs() < 1e-9);
    }

    #[test]
    fn ends_are_one_sided_and_take_the_nearest_inner_acceleration() {
        let path: Vec<f64> = (0..40).map(|frame| f64::from(frame * frame * frame)).collect();
        let baseline = Baseline::new(120.0);
        assert_eq!(baseline.velocity(&path, 0), 64.0 * 120.0 / 4.0);
        assert_eq!(baseline.velocity(&path, 2), 216.0 * 120.0 / 6.0);
        assert_eq!(baseline.velocity(&path, 39), (59319.0 - 42875.0) * 120.0 / 4.0);
        for (frame, inner) in [(0, 4), (3, 4), (4, 4), (36, 35), (39, 35)] {
            assert_eq!(baseline.acceleration(&path, frame), baseline.acceleration(&path, inner), "frame {frame}");
        }
        assert_ne!(baseline.acceleration(&path, 34), baseline.acceleration(&path, 35));
    }

    #[test]
    fn short_clips_stand_still() {
        for n_frames in 0..9 {
            let path = vec![3.0; n_frames];
            for rate_hz in [30.0, 45.0, 120.0, 1e9] {
                let baseline = Baseline::new(rate_hz);
                for frame in 0..n_frames {
                    assert_eq!(baseline.velocity(&path, frame), 0.0);
                    assert_eq!(baseline.acceleration(&path, frame), 0.0);
                }
            }
        }
        let moving = [1.0, 2.0];
        assert_eq!(Baseline::new(30.0).velocity(&moving, 0), 30.0);
        assert_eq!(Baseline::new(30.0).acceleration(&moving, 0), 0.0);
    }
}
