//! The vertical force on the feet, from the acceleration of the center of mass (CONTACTS 2.8).

use super::foot_paths::FootPaths;
use crate::motion::{Poses, Role, RoleMap};

/// Length of the window that the acceleration is fitted in, seconds; at least so many frames.
pub(super) const WINDOW_S: f64 = 0.17;
const FEWEST_FRAMES: usize = 5;
/// From this number of frames on the fitted polynomial is a cubic, below it a parabola.
const CUBIC_FRAMES: usize = 7;
/// Standard gravity, m/s^2.
const GRAVITY_MPS2: f64 = 9.81;

/// Parts of the trunk: nearer end, farther end, where along it the mass lies, share of the body's mass.
const TRUNK: [(Role, Role, f64, f64); 2] = [(Role::Hips, Role::Neck, 0.5, 0.497), (Role::Neck, Role::Head, 0.8, 0.081)];
/// The same of the limbs, of both sides.
const LIMBS: [([Role; 2], [Role; 2], f64, f64); 6] = [
    ([Role::ThighLeft, Role::ThighRight], [Role::KneeLeft, Role::KneeRight], 0.433, 0.1),
    ([Role::KneeLeft, Role::KneeRight], [Role::AnkleLeft, Role::AnkleRight], 0.433, 0.0465),
    ([Role::AnkleLeft, Role::AnkleRight], [Role::ToeLeft, Role::ToeRight], 0.5, 0.0145),
    ([Role::ShoulderLeft, Role::ShoulderRight], [Role::ElbowLeft, Role::ElbowRight], 0.436, 0.028),
    ([Role::ElbowLeft, Role::ElbowRight], [Role::WristLeft, Role::WristRight], 0.43, 0.016),
    ([Role::WristLeft, Role::WristRight], [Role::WristLeft, Role::WristRight], 0.0, 0.006),
];

/// Vertical force in body weights, `[frame]`: `1 + a / g` of the center of mass in scaled metres, so that gravity scales
/// with the leg. None in the first and last quarter of a window, 1 throughout a clip shorter than a window.
pub fn vertical_force(poses: &Poses, roles: &RoleMap, feet: &FootPaths) -> Vec<Option<f64>> {
    let heights = mass_center_heights(poses, roles, feet.scale);
    force_of_heights(&heights, feet.rate_hz)
}

/// Height of the center of mass, scaled metres; that of the hips (of an ankle's side of the body at worst) where a
/// part of the body is not known.
fn mass_center_heights(poses: &Poses, roles: &RoleMap, scale: f64) -> Vec<f64> {
    let mut weights = vec![0.0; poses.n_points];
    if mass_weights(roles, &mut weights).is_none() {
        weights.fill(0.0);
        if let Some(weight) =
            roles.get(Role::Hips).or(roles.get(Role::ThighLeft)).and_then(|hips| weights.get_mut(hips))
        {
            *weight = 1.0;
        }
    }
    let points: Vec<(usize, f64)> =
        weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0).map(|(at, w)| (at, w / scale)).collect();
    (0..poses.n_frames)
        .map(|frame| points.iter().map(|&(point, weight)| poses.at(frame, point).y * weight).sum())
        .collect()
}

/// Adds every part's mass to the points at its ends. None: a part is not known.
fn mass_weights(roles: &RoleMap, weights: &mut [f64]) -> Option<()> {
    let limbs =
        LIMBS.iter().flat_map(|&(near, far, along, mass)| [0, 1].map(|side| (near[side], far[side], along, mass)));
    for (near, far, along, mass) in TRUNK.into_iter().chain(limbs) {
        *weights.get_mut(roles.get(near)?)? += mass * (1.0 - along);
        *weights.get_mut(roles.get(far)?)? += mass * along;
    }
    Some(())
}

fn force_of_heights(heights: &[f64], rate_hz: f64) -> Vec<Option<f64>> {
    let n_frames = heights.len();
    let asked = (WINDOW_S * rate_hz).round_ties_even();
    // Half a million frames a second would ask for more than a clip has.
    let window = if asked < 1e9 { (asked as usize | 1).max(FEWEST_FRAMES) } else { usize::MAX };
    if n_frames < window {
        return vec![Some(1.0); n_frames];
    }
    let half = window / 2;
    let margin = half / 2 + 1;
    let fit = Fit::new(window, rate_hz);
    let mut force = vec![None; n_frames];
    let mut kernel = fit.kernel(0.0);
    for (frame, force) in force.iter_mut().enumerate().take(n_frames.saturating_sub(margin)).skip(margin) {
        let first = frame.saturating_sub(half).min(n_frames - window);
        let off_center = frame as f64 - (first + half) as f64;
        if off_center != kernel.off_center {
            kernel = fit.kernel(off_center);
        }
        // Differences from the frame's own height: a body far above the origin weighs no more.
        let here = heights[frame];
        let acceleration: f64 =
            kernel.weights.iter().zip(&heights[first..]).map(|(weight, height)| weight * (height - here)).sum();
        *force = Some(1.0 + acceleration / GRAVITY_MPS2);
    }
    force
}

/// Least-squares fit of a polynomial to a window.
struct Fit {
    /// For each frame of the window its share in the second derivative at the window's middle, and in the third.
    second: Vec<f64>,
    third: Vec<f64>,
}

/// Weights of the second derivative at some distance from the window's middle.
struct Kernel {
    off_center: f64,
    weights: Vec<f64>,
}

impl Fit {
    /// Over frames `-m..=m` even and odd powers don't mix, so that each of the two normal equations is one fraction.
    fn new(window: usize, rate_hz: f64) -> Fit {
        let places: Vec<f64> = (0..window).map(|at| at as f64 - (window / 2) as f64).collect();
        let power_sum = |power: i32| places.iter().map(|place| place.powi(power)).sum::<f64>();
        let (s0, s2, s4, s6) = (window as f64, power_sum(2), power_sum(4), power_sum(6));
        let per_second2 = rate_hz * rate_hz;
        let (even, odd) = (s0 * s4 - s2 * s2, s2 * s6 - s4 * s4);
        let second = places.iter().map(|x| 2.0 * (s0 * x * x - s2) / even * per_second2).collect();
        let cubic = window >= CUBIC_FRAMES;
        let third = places
            .iter()
            .map(|x| if cubic { 6.0 * (s2 * x * x * x - s4 * x) / odd * per_second2 } else { 0.0 })
            .collect();
        Fit { second, third }
    }

    fn kernel(&self, off_center: f64) -> Kernel {
        let weights = self.second.iter().zip(&self.third).map(|(second, third)| second + third * off_center).collect();
        Kernel { off_center, weights }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]

    use super::*;

    #[test]
    fn cubics_have_the_force_that_calculus_gives_at_every_place_of_the_window() {
        for rate_hz in [45.0, 60.0, 120.0, 240.0] {
            let at = |t: f64| 100.0 + 2.0 * t - 3.0 * t * t + 5.0 * t * t * t;
            let heights: Vec<f64> = (0..120).map(|frame| at(f64::from(frame) / rate_hz)).collect();
            let force = force_of_heights(&heights, rate_hz);
            let defined: Vec<usize> = (0..120).filter(|&frame| force[frame].is_some()).collect();
            let window = (WINDOW_S * rate_hz).round_ties_even() as usize | 1;
            assert_eq!((defined[0], defined.len()), (window / 4 + 1, 120 - 2 * (window / 4 + 1)), "{rate_hz}");
            for frame in defined {
                let wanted = 1.0 + (-6.0 + 30.0 * frame as f64 / rate_hz) / GRAVITY_MPS2;
                assert!((force[frame].unwrap() - wanted).abs() < 1e-9, "{rate_hz} Hz, frame {frame}");
            }
        }
    }

    #[test]
    fn at_thirty_frames_a_parabola_is_fitted() {
        let heights: Vec<f64> = (0..20).map(|frame| f64::from(frame * frame)).collect();
        let force = force_of_heights(&heights, 30.0);
        assert_eq!(force[..2], [None, None]);
        assert!((force[2].unwrap() - (1.0 + 2.0 * 900.0 / GRAVITY_MPS2)).abs() < 1e-9);
    }

    #[test]
    fn short_clips_stand() {
        assert_eq!(force_of_heights(&[3.0; 4], 30.0), [Some(1.0); 4]);
        assert_eq!(force_of_heights(&[], 120.0), []);
        assert_eq!(force_of_heights(&[1.0; 30], 1e300).len(), 30);
    }

    #[test]
    fn masses_are_those_of_one_body() {
        let mut roles = RoleMap::default();
        for (point, role) in Role::ALL.into_iter().enumerate() {
            roles.set(role, point);
        }
        let mut weights = vec![0.0; Role::COUNT];
        mass_weights(&roles, &mut weights).unwrap();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(mass_weights(&RoleMap::default(), &mut weights), None);
    }
}
