//! How the ground slopes: a plane through toes that are slow (CONTACTS 2.6).

use super::foot_paths::{FEET, FootPaths, joints_of};
use crate::annotate::order_statistics::{coordinate_medians, robust_deviation};
use glam::{DMat3, DVec3};

/// Fewer slow samples than this say nothing about a plane; nor do samples that lie closer together, mean square of
/// their horizontal coordinates about the median, scaled m^2.
const FEWEST_SAMPLES: usize = 10;
const LEAST_EXTENT_M2: f64 = 0.25;
/// Rounds of reweighting.
const ROUNDS: usize = 8;
/// The slopes are drawn to zero by this weight a sample, scaled m^2.
const RIDGE_M2: f64 = 0.02;
/// The scale of the weights is a robust standard deviation, at least this, scaled metres.
const LEAST_SCALE_M: f64 = 0.01;
/// A plane is a floor if more than this share of the samples lies this close to it, scaled metres, and it is flatter
/// than this, rise over run.
const FLOOR_SHARE: f64 = 0.7;
const FLOOR_DISTANCE_M: f64 = 0.03;
const STEEPEST: f64 = 0.12;

/// A sloping floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Rise along X and along Z, m/m.
    pub slope: [f64; 2],
    /// Share of the slow samples that lie within 3 scaled cm of the plane: how far it can be believed.
    pub share: f64,
}

/// Slopes of the floor. None: the samples say nothing about a plane, or it is no floor.
///
/// `is_slow(joint, frame)`: the toe (the ankle of a foot without one) is as good as at rest.
pub fn ground_tilt(feet: &FootPaths, is_slow: impl Fn(usize, usize) -> bool) -> Option<Tilt> {
    let mut samples: Vec<DVec3> = Vec::new();
    for foot in FEET {
        let [ankle, toe] = joints_of(foot);
        let joint = if feet.paths[toe].is_some() { toe } else { ankle };
        let path = feet.paths[joint].as_deref().unwrap_or(&[]);
        samples.extend(path.iter().enumerate().filter(|(frame, _)| is_slow(joint, *frame)).map(|(_, place)| *place));
    }
    if samples.len() < FEWEST_SAMPLES {
        return None;
    }
    let middle = coordinate_medians(&samples);
    for sample in &mut samples {
        *sample -= middle;
    }
    let extent = samples.iter().map(|sample| sample.x * sample.x + sample.z * sample.z).sum::<f64>();
    if extent / (2 * samples.len()) as f64 <= LEAST_EXTENT_M2 {
        return None;
    }
    let mut found = None;
    let mut weights = vec![1.0; samples.len()];
    let mut away = vec![0.0; samples.len()];
    for _ in 0..ROUNDS {
        let plane = weighted_plane(&samples, &weights)?;
        let height = |sample: &DVec3| sample.x * plane.x + sample.z * plane.y + plane.z;
        for (away, sample) in away.iter_mut().zip(&samples) {
            *away = (sample.y - height(sample)).abs();
        }
        let near = away.iter().filter(|&&away| away < FLOOR_DISTANCE_M).count();
        let share = near as f64 / samples.len() as f64;
        if share > FLOOR_SHARE && (plane.x * plane.x + plane.y * plane.y).sqrt() < STEEPEST {
            found = Some(Tilt { slope: [plane.x, plane.y], share });
        }
        let scale = 2.0 * LEAST_SCALE_M.max(robust_deviation(&mut away.clone()).unwrap_or(0.0));
        for (weight, away) in weights.iter_mut().zip(&away) {
            let ratio = away / scale;
            let bell = 1.0 + ratio * ratio;
            *weight = 1.0 / (bell * bell);
        }
    }
    found
}

/// Slope along X, slope along Z and height at the origin of the plane with the least weighted squares. None: no such
/// plane.
fn weighted_plane(samples: &[DVec3], weights: &[f64]) -> Option<DVec3> {
    let ridge = RIDGE_M2 * samples.len() as f64;
    let [mut xx, mut xz, mut zz] = [ridge, 0.0, ridge];
    let [mut x, mut z, mut n] = [0.0; 3];
    let mut right = DVec3::ZERO;
    for (sample, &weight) in samples.iter().zip(weights) {
        let (wx, wz) = (sample.x * weight, sample.z * weight);
        xx += wx * sample.x;
        xz += wx * sample.z;
        zz += wz * sample.z;
        x += wx;
        z += wz;
        n += weight;
        right += DVec3::new(wx, wz, weight) * sample.y;
    }
    let normal = DMat3::from_cols(DVec3::new(xx, xz, x), DVec3::new(xz, zz, z), DVec3::new(x, z, n));
    let plane = normal.inverse() * right;
    plane.is_finite().then_some(plane)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    /// Feet that stand on `height(x, z)` at 60 places.
    fn feet(height: impl Fn(f64, f64) -> f64, size: f64) -> FootPaths {
        let place = |at: i32| {
            let (x, z) = (size * f64::from(at % 10), size * f64::from(at / 10));
            DVec3::new(x, height(x, z), z)
        };
        let path: Vec<DVec3> = (0..60).map(place).collect();
        FootPaths {
            n_frames: 60,
            rate_hz: 30.0,
            leg_length_m: 0.9,
            leg_spread_m: 0.0,
            scale: 1.0,
            paths: [Some(path.clone()), Some(path.clone()), Some(path.clone()), Some(path)],
        }
    }

    #[test]
    fn a_sloping_floor_is_found_and_the_ridge_takes_little_off() {
        let tilt = ground_tilt(&feet(|x, z| 5.0 + 0.03 * x - 0.05 * z, 0.5), |_, _| true).unwrap();
        assert!((tilt.slope[0] - 0.03).abs() < 0.002 && (tilt.slope[1] + 0.05).abs() < 0.005, "{tilt:?}");
        assert!(tilt.share > 0.95, "{tilt:?}");
        let flat = ground_tilt(&feet(|_, _| -3.0, 0.5), |_, _| true).unwrap();
        assert!(flat.slope[0].abs() < 1e-12 && flat.slope[1].abs() < 1e-12);
    }

    #[test]
    fn a_box_to_step_on_does_not_tilt_the_floor() {
        let tilt = ground_tilt(&feet(|x, _| if x > 3.9 { 0.4 } else { 0.0 }, 0.5), |_, _| true).unwrap();
        assert!(tilt.slope[0].abs() < 0.01, "{tilt:?}");
    }

    #[test]
    fn small_patches_stairs_and_few_samples_have_no_plane() {
        assert_eq!(ground_tilt(&feet(|x, _| 0.1 * x, 0.05), |_, _| true), None);
        assert_eq!(ground_tilt(&feet(|x, _| 0.5 * x, 0.5), |_, _| true), None);
        assert_eq!(ground_tilt(&feet(|x, _| 0.05 * x, 0.5), |_, frame| frame < 4), None);
    }

    #[test]
    fn feet_without_toes_stand_on_their_ankles() {
        let mut feet = feet(|x, _| 0.04 * x, 0.5);
        (feet.paths[1], feet.paths[3]) = (None, None);
        assert!(ground_tilt(&feet, |joint, _| joint % 2 == 0).is_some());
    }
}
