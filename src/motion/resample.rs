//! Paths at fractional frames: Catmull-Rom cubics for numbers and points, slerp for rotations.
//!
//! Catmull-Rom passes through every frame with the slope between its neighbors, so velocity has no jumps. Before
//! the first and after the last frame the path is held; within the first and last step the missing neighbor is the
//! straight continuation. A path must have at least one frame.

use super::rotation::slerp;
use glam::{DQuat, DVec3};
use std::ops::{Add, Mul, Sub};

/// A scalar path at a fractional frame.
pub fn scalar_at(path: &[f64], frame: f64) -> f64 {
    cubic_at(path.len(), frame, |n| path[n])
}

/// A path of points at a fractional frame.
pub fn point_at(path: &[DVec3], frame: f64) -> DVec3 {
    cubic_at(path.len(), frame, |n| path[n])
}

/// A path of unit quaternions at a fractional frame: the short way between the two frames around it.
pub fn rotation_at(path: &[DQuat], frame: f64) -> DQuat {
    let (n, t) = split(path.len(), frame);
    if t == 0.0 { path[n] } else { slerp(path[n], path[n + 1], t) }
}

/// Catmull-Rom at a fractional frame of a path that is given frame by frame; `n_frames` > 0.
pub fn cubic_at<T>(n_frames: usize, frame: f64, at: impl Fn(usize) -> T) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let (n, t) = split(n_frames, frame);
    if t == 0.0 {
        return at(n);
    }
    let (a, b) = (at(n), at(n + 1));
    let before = if n > 0 { at(n - 1) } else { a + a - b };
    let after = if n + 2 < n_frames { at(n + 2) } else { b + b - a };
    let (slope_a, slope_b) = ((b - before) * 0.5, (after - a) * 0.5);
    let step = b - a;
    a + (slope_a + (step * 3.0 - slope_a * 2.0 - slope_b + (slope_a + slope_b - step * 2.0) * t) * t) * t
}

/// The fractional frames of a clip at one rate that lie under the frames of another, from frame 0 to its last.
pub fn frames_at_rate(n_frames: usize, rate_hz: f64, new_rate_hz: f64) -> Vec<f64> {
    if n_frames == 0 {
        return Vec::new();
    }
    let last = (n_frames - 1) as f64;
    let step = rate_hz / new_rate_hz;
    // A little slack, so that 4 frames at 120 Hz end on the second frame at 40 Hz in spite of rounding.
    (0..).map(|n| f64::from(n) * step).take_while(|&frame| frame <= last + 1e-9).map(|frame| frame.min(last)).collect()
}

/// The frame at or before a fractional one and the rest, held within the path. The rest is 0 at the last frame.
fn split(n_frames: usize, frame: f64) -> (usize, f64) {
    assert!(n_frames > 0, "a path has at least one frame");
    let last = n_frames - 1;
    // A NaN fails the comparison and is held at the start.
    if frame.is_nan() || frame <= 0.0 {
        return (0, 0.0);
    }
    if frame >= last as f64 {
        return (last, 0.0);
    }
    (frame as usize, frame - frame.floor())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::rotation::about;
    use crate::motion::skeleton::Axis;

    #[test]
    fn whole_frames_are_the_path_itself_and_ends_are_held() {
        let path = [1.0, -2.0, 5.0, 0.25];
        for (n, &value) in path.iter().enumerate() {
            assert_eq!(scalar_at(&path, n as f64), value);
        }
        assert_eq!((scalar_at(&path, -3.0), scalar_at(&path, 99.0), scalar_at(&path, f64::NAN)), (1.0, 0.25, 1.0));
        assert_eq!(scalar_at(&[7.0], 0.5), 7.0);
    }

    #[test]
    fn parabolas_are_exact_inside_and_straight_lines_everywhere() {
        let square: Vec<f64> = (0..8).map(|n| f64::from(n) * f64::from(n)).collect();
        let line: Vec<DVec3> = (0..8).map(|n| DVec3::new(2.0, -1.0, 0.5) * f64::from(n)).collect();
        for step in 0..70 {
            let frame = f64::from(step) * 0.1;
            assert!(point_at(&line, frame).distance(line[1] * frame) < 1e-12, "{frame}");
            if (1.0..6.0).contains(&frame) {
                assert!((scalar_at(&square, frame) - frame * frame).abs() < 1e-12, "{frame}");
            }
        }
    }

    #[test]
    fn slopes_do_not_jump_at_frames() {
        let path = [0.0, 1.0, -1.0, 4.0, 2.0];
        for frame in 1..4 {
            let slope = |from: f64, to: f64| (scalar_at(&path, to) - scalar_at(&path, from)) / (to - from);
            let frame = f64::from(frame);
            assert!((slope(frame - 1e-6, frame) - slope(frame, frame + 1e-6)).abs() < 1e-4, "{frame}");
        }
    }

    #[test]
    fn rotations_turn_evenly_whatever_their_sign() {
        let path = [about(Axis::Y, 0.0), -about(Axis::Y, 1.0), about(Axis::Y, 3.0)];
        for (frame, angle) in [(0.25, 0.25), (1.5, 2.0), (2.0, 3.0), (9.0, 3.0)] {
            assert!(rotation_at(&path, frame).dot(about(Axis::Y, angle)).abs() > 1.0 - 1e-12, "{frame}");
        }
    }

    #[test]
    fn another_rate_keeps_first_and_last_frame_where_it_can() {
        assert_eq!(frames_at_rate(9, 120.0, 30.0), [0.0, 4.0, 8.0]);
        assert_eq!(frames_at_rate(8, 120.0, 30.0), [0.0, 4.0]);
        assert_eq!(frames_at_rate(3, 30.0, 60.0), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(frames_at_rate(301, 30.0, 29.97).last().map(|frame| frame.round()), Some(299.0));
        assert!(frames_at_rate(0, 30.0, 60.0).is_empty());
    }
}
