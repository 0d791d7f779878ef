//! How noisy the feet's paths are, and how much smoothing that asks for (CONTACTS 2.3).

use super::foot_paths::FootPaths;
use crate::annotate::order_statistics::{median, percentile, robust_deviation};
use glam::DVec3;

/// Below this number of frames a clip has no noise estimate: its noise counts as none.
const FEWEST_FRAMES: usize = 7;
/// The lower quartile of the size of a normal variable of standard deviation 1, and of the length of two of them.
const NORMAL_QUARTILE: f64 = 0.3186;
const PLANE_QUARTILE: f64 = 0.7585;
/// Variance of the third difference of white noise of variance 1.
const THIRD_DIFFERENCE_VARIANCE: f64 = 20.0;
/// Noise up to this is none: clean captures stay as they are, scaled metres.
pub(super) const QUIET_M: f64 = 0.0015;
/// Standard deviation of the smoothing for each metre of noise beyond that, seconds; and its limit.
pub(super) const SMOOTHING_S_PER_M: f64 = 6.0;
pub(super) const LONGEST_SMOOTHING_S: f64 = 0.03;
/// A Gaussian narrower than this does nothing, frames; it is cut off at so many standard deviations.
const NARROWEST_FRAMES: f64 = 0.3;
const CUT_OFF: f64 = 4.0;

/// Estimated noise of the feet's coordinates, the same for a clip that is turned about the vertical.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Standard deviation of white noise in each coordinate, scaled metres.
    pub sd_m: f64,
    /// Robust standard deviation of that estimate among the coordinates: how far it can be believed.
    pub spread_m: f64,
    /// What smoothing multiplies the noise by: 1 without.
    pub smoothed_share: f64,
}

/// Estimates the noise, and smooths the paths if there is enough of it.
///
/// A joint's estimates come from the lower quartile of the third difference, which looks at stance, where motion is
/// smallest: one of its height, one of its place on the ground. Their median counts. (CONTACTS 2.3 takes each coordinate
/// by itself, so that a clip that is turned has other noise.)
pub fn smooth_noise(feet: &mut FootPaths) -> Noise {
    let (sd_m, spread_m) = noise(feet);
    let smoothing_s = LONGEST_SMOOTHING_S.min(SMOOTHING_S_PER_M * (sd_m - QUIET_M).max(0.0));
    let sd_frames = smoothing_s * feet.rate_hz;
    if sd_frames < NARROWEST_FRAMES || sd_frames.is_nan() {
        return Noise { sd_m, spread_m, smoothed_share: 1.0 };
    }
    let weights = gaussian(sd_frames);
    for path in feet.paths.iter_mut().flatten() {
        *path = convolve(path, &weights);
    }
    let smoothed_share = 1.0 / (1.0 + 2.0 * core::f64::consts::PI.sqrt() * sd_frames).sqrt();
    Noise { sd_m, spread_m, smoothed_share }
}

/// Standard deviation of white noise in a coordinate, and the spread of the estimates.
fn noise(feet: &FootPaths) -> (f64, f64) {
    if feet.n_frames < FEWEST_FRAMES {
        return (0.0, 0.0);
    }
    let mut upright = vec![0.0; feet.n_frames - 3];
    let mut level = upright.clone();
    let mut estimates = Vec::with_capacity(8);
    for path in feet.paths.iter().flatten() {
        for ((upright, level), four) in upright.iter_mut().zip(&mut level).zip(path.windows(4)) {
            // As differences of differences: a clip far from the origin has no more noise than one near it.
            let (first, second, third) = (four[1] - four[0], four[2] - four[1], four[3] - four[2]);
            let difference = (third - second) - (second - first);
            *upright = difference.y.abs();
            *level = difference.x * difference.x + difference.z * difference.z;
        }
        let unit = THIRD_DIFFERENCE_VARIANCE.sqrt();
        let quartile = |values: &mut [f64]| percentile(values, 25.0).unwrap_or(0.0);
        let on_ground = quartile(&mut level).sqrt() / PLANE_QUARTILE / unit;
        estimates.extend([quartile(&mut upright) / NORMAL_QUARTILE / unit, on_ground]);
    }
    let middle = median(&mut estimates).unwrap_or(0.0);
    for estimate in &mut estimates {
        *estimate = (*estimate - middle).abs();
    }
    (middle, robust_deviation(&mut estimates).unwrap_or(0.0))
}

/// Weights of sum 1 from one cut-off to the other; an odd number.
fn gaussian(sd_frames: f64) -> Vec<f64> {
    // Half a million frames a second would ask for more; nobody has them.
    let reach = ((CUT_OFF * sd_frames + 0.5) as usize).min(1 << 16);
    let weight = |place: usize| {
        let away = (place as f64 - reach as f64) / sd_frames;
        libm::exp(-0.5 * away * away)
    };
    let weights: Vec<f64> = (0..=2 * reach).map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / total).collect()
}

/// The path averaged with these weights; its end frames go on for ever.
fn convolve(path: &[DVec3], weights: &[f64]) -> Vec<DVec3> {
    let reach = weights.len() / 2;
    let (Some(&first), Some(&last)) = (path.first(), path.last()) else { return Vec::new() };
    let mut padded = Vec::with_capacity(path.len() + 2 * reach);
    padded.resize(reach, first);
    padded.extend_from_slice(path);
    padded.resize(path.len() + 2 * reach, last);
    let mut smooth = vec![DVec3::ZERO; path.len()];
    for (at, &weight) in weights.iter().enumerate() {
        for (sum, &position) in smooth.iter_mut().zip(&padded[at..]) {
            *sum += position * weight;
        }
    }
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feet at rest, with noise of a standard deviation in every coordinate.
    fn noisy(sd_m: f64, rate_hz: f64, n_frames: usize) -> FootPaths {
        let mut state = 1_u64;
        let mut even = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        // A sum of twelve even draws is normal enough for a quartile.
        let mut normal = || (0..12).map(|_| even()).sum::<f64>() * sd_m;
        let paths = [0.0, 1.0, 2.0, 3.0]
            .map(|x| Some((0..n_frames).map(|_| DVec3::new(x + normal(), normal(), normal())).collect::<Vec<DVec3>>()));
        FootPaths { n_frames, rate_hz, leg_length_m: 0.9, leg_spread_m: 0.0, scale: 1.0, paths }
    }

    #[test]
    fn white_noise_is_measured() {
        for sd_m in [0.0, 0.001, 0.01] {
            let found = smooth_noise(&mut noisy(sd_m, 60.0, 3000));
            assert!((found.sd_m - sd_m).abs() <= 0.04 * sd_m, "{found:?}, not {sd_m}");
            assert!(found.spread_m <= 0.05 * sd_m, "{found:?}");
        }
    }

    #[test]
    fn quiet_paths_are_left_alone_and_noise_shrinks_as_it_is_said_to() {
        let mut quiet = noisy(0.001, 60.0, 300);
        let before = quiet.clone();
        assert_eq!(smooth_noise(&mut quiet).smoothed_share, 1.0);
        assert_eq!(quiet, before);
        let mut loud = noisy(0.01, 120.0, 4000);
        let share = smooth_noise(&mut loud).smoothed_share;
        let spread = |path: &[DVec3]| (path.iter().map(|p| p.y * p.y).sum::<f64>() / path.len() as f64).sqrt();
        let left = loud.paths[0].as_deref().map_or(0.0, spread) / 0.01;
        assert!((left / share - 1.0).abs() < 0.1, "{left} of the noise is left, {share} said");
    }

    #[test]
    fn a_path_at_rest_stays_and_short_ones_have_no_noise() {
        let still = vec![DVec3::new(1.0, 2.0, 3.0); 9];
        for (found, wanted) in convolve(&still, &gaussian(1.5)).into_iter().zip(&still) {
            assert!((found - *wanted).length() < 1e-12);
        }
        assert_eq!(noise(&noisy(0.01, 30.0, 6)), (0.0, 0.0));
        assert!(convolve(&[], &gaussian(1.0)).is_empty());
    }
}
